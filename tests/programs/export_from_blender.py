"""Scenes of Blender become scenes of Whorl: /usr/bin/python3 tests/programs/export_from_blender.py build/release/whorl

A scene made by script goes out with tools/blender/whorl_export.py, runs coarsely, and comes back with whorl_import.py: every object is where
it was, and so is the image of the camera. Ends with 77 (skipped) without Blender.
"""
import json
import math
import shutil
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SPACING, WALL, FIRST, FRAMES, FPS = 0.01, 0.03, 10, 7, 25
POINTS = [(x, y, z) for x in (-0.15, 0.1) for y in (-0.1, 0.15) for z in (0, 0.2)]


def outside(whorl):
    """The part outside Blender."""
    blender = shutil.which("blender")
    if not blender:
        print("there is no Blender; install it with: apt-get install -y --no-install-recommends blender")
        return 77
    with tempfile.TemporaryDirectory() as folder:

        def in_blender(stage):
            words = [blender, "--background", "--factory-startup", "--python-exit-code", "1", "--python", __file__, "--", stage, folder]
            done = subprocess.run(words, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
            print(done.stdout if done.returncode else "\n".join(line for line in done.stdout.splitlines() if line.startswith("ok")))
            return done.returncode

        film = [whorl, "render", f"{folder}/scene.toml", "--no-images", "--export", "mesh,scene", "--out", f"{folder}/run", "--quiet"]
        return in_blender("out") or subprocess.run(film).returncode or in_blender("back")


def make(unit):
    """A scene in units of `unit` metres. Returns its objects."""
    import bpy
    from mathutils import Vector
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.unit_settings.scale_length = unit
    scene.render.fps, scene.render.resolution_x, scene.render.resolution_y = FPS, 320, 180
    scene.frame_start, scene.frame_end = FIRST, FIRST + FRAMES - 1
    scene["whorl.fluid.spacing"], scene["whorl.fluid.viscosity"] = SPACING, 20
    for role in ("fluid", "solid", "container", "emitter"):
        scene.collection.children.link(bpy.data.collections.new(role))

    def add(name, role, corners, faces, place=(0, 0, 0), turn=(0, 0, 0), size=(1, 1, 1)):
        mesh = bpy.data.meshes.new(name)
        mesh.from_pydata([Vector(corner) / unit for corner in corners], [], faces)
        thing = bpy.data.objects.new(name, mesh)
        thing.location, thing.rotation_euler, thing.scale = Vector(place) / unit, turn, size
        bpy.data.collections[role].objects.link(thing)
        return thing

    box = [(x, y, z) for z in (0, 1) for y in (0, 1) for x in (0, 1)]
    sides = [(0, 2, 3, 1), (0, 1, 5, 4), (1, 3, 7, 5), (3, 2, 6, 7), (2, 0, 4, 6)]
    corner = [(0, 0), (0.12, 0), (0.12, 0.04), (0.05, 0.04), (0.05, 0.09), (0, 0.09)]
    prism = [tuple(range(5, -1, -1)), tuple(range(6, 12)), *((k, (k + 1) % 6, 6 + (k + 1) % 6, 6 + k) for k in range(6))]
    add("fluid", "fluid", [(x, y, z) for z in (0, 0.05) for x, y in corner], prism, (-0.07, -0.05, 0.02))
    wedge = [(0, 0, 0), (0.08, 0, 0), (0, 0.05, 0), (0, 0, 0.03)]
    stone = add("stone", "solid", wedge, [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)], (0.16, 0.2, 0), (0.3, -0.2, 1), (1, -2, 1))
    stone.data.materials.append(bpy.data.materials.new("red"))
    stone.active_material.use_nodes = True
    inputs = stone.active_material.node_tree.nodes["Principled BSDF"].inputs
    inputs["Base Color"].default_value, inputs["Roughness"].default_value = (0.5, 0.1, 0.05, 1), 0.25
    tray = add("tray", "container", [(0.3 * x - 0.15, 0.2 * y - 0.1, 0.1 * z) for x, y, z in box], sides, turn=(0, 0, 0.4))
    tray["whorl.wall"] = WALL
    slot = [(-0.04, -0.02, 0), (-0.04, 0.02, 0), (0.04, 0.02, 0), (0.04, -0.02, 0)]
    nozzle = add("nozzle", "emitter", slot, [(0, 1, 2, 3)], (0.03, -0.02, 0.2))
    nozzle["whorl.speed"] = 0.1
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.location, camera.rotation_euler = Vector((0.5, -0.8, 0.6)) / unit, (0.95, 0.1, 0.5)
    scene.collection.objects.link(camera)
    scene.camera = camera
    bpy.context.view_layer.update()
    return scene


def shape(thing):
    """Corners of an object, and its bounding box and centre of volume (3 x 3), in Blender's coordinates."""
    import bpy
    import numpy
    seen = thing.evaluated_get(bpy.context.evaluated_depsgraph_get())
    mesh = seen.to_mesh()
    mesh.calc_loop_triangles()
    points = numpy.array([seen.matrix_world @ vertex.co for vertex in mesh.vertices])
    corners = points[[triangle.vertices for triangle in mesh.loop_triangles]]
    volumes = numpy.linalg.det(corners)
    centre = (corners.sum(axis=1) / 4 * volumes[:, None]).sum(axis=0) / volumes.sum()
    return points, numpy.array([points.min(axis=0), points.max(axis=0), centre])


def seen(scene, points):
    """The pixels of points."""
    import numpy
    from bpy_extras.object_utils import world_to_camera_view
    from mathutils import Vector
    size = scene.render.resolution_x, scene.render.resolution_y
    return numpy.array([world_to_camera_view(scene, scene.camera, Vector(point)).to_2d() for point in points]) * size


def go_out(folder):
    import bpy
    import numpy
    import whorl_export

    scene = make(0.01)
    centimetres = whorl_export.export_scene(bpy.context, folder / "scene.toml")
    files = {path.name: numpy.array([line.split()[1:] for line in path.read_text().splitlines() if line[0] == "v"], dtype=float)
             for path in (folder / "scene_meshes").iterdir()}
    with open(folder / "scene.toml", "rb") as file:
        small = tomllib.load(file)
    scene = make(1)
    said = whorl_export.export_scene(bpy.context, folder / "scene.toml")
    with open(folder / "scene.toml", "rb") as file:
        tables = tomllib.load(file)
    assert said == centimetres == [], said
    there = {name: [of.tolist() for of in shape(scene.objects[name])] for name in ("fluid", "stone", "tray")}
    (folder / "there.json").write_text(json.dumps([there, seen(scene, POINTS).tolist()]))

    # A unit of a centimetre changes nothing but single-precision rounding.
    def same(a, b, at):
        if isinstance(a, dict):
            assert a.keys() == b.keys(), at
            return all(same(a[key], b[key], f"{at}.{key}") for key in a)
        if isinstance(a, list) and a and isinstance(a[0], (list, dict)):
            return len(a) == len(b) and all(same(x, y, at) for x, y in zip(a, b))
        assert a == b or numpy.abs(numpy.subtract(a, b)).max() < 1e-5, (at, a, b)
        return True

    assert same(tables, small, "scene")
    for name, points in files.items():
        metres = [line.split()[1:] for line in (folder / "scene_meshes" / name).read_text().splitlines() if line[0] == "v"]
        assert numpy.abs(points - numpy.array(metres, dtype=float)).max() < 1e-6, name
    assert tables["time"] == {"end": (FRAMES - 1) / FPS, "fps": FPS} and tables["output"]["size"] == [320, 180], tables
    red, vessel, slot = tables["solid"][0], tables["solid"][1], tables["emitter"][0]
    assert red["colour"] == [0.5, 0.1, 0.05] and red["roughness"] == 0.25 and red["metallic"] == 0, red
    assert vessel["container"] and vessel["open"] == "top" and vessel["rim"] == 0.1 and vessel["wall"] == WALL, vessel
    assert [slot[key] for key in ("position", "direction", "width", "thickness")] == [[0.03, 0.2, 0.02], [0, -1, 0], 0.08, 0.04], slot
    print("ok: the scene file has the frames, looks, vessel and opening of Blender's, in metres and in centimetres")

    # The angle of view, for all fits of the sensor.
    for fit, width, height in (("AUTO", 200, 320), ("HORIZONTAL", 200, 320), ("VERTICAL", 320, 200)):
        scene.camera.data.sensor_fit, scene.render.resolution_x, scene.render.resolution_y = fit, width, height
        scene.camera.data.dof.use_dof = True
        whorl_export.export_scene(bpy.context, folder / "fit.toml")
        view = tomllib.loads((folder / "fit.toml").read_text())["camera"]
        _, up, back, eye = (axis.xyz for axis in scene.camera.matrix_world.col)
        at_top = seen(scene, [eye - back + math.tan(math.radians(view["fov"] / 2)) * up])[0]
        assert abs(at_top[1] - height) < 0.01, (fit, at_top)
        assert view["focus"] == 10 and abs(view["aperture"] - 0.05 / 2.8) < 1e-6, view
    print("ok: the vertical angle of view")

    faults(folder)


def faults(folder):
    """Scenes that are refused, and limits that are reported."""
    import bpy
    import whorl_export

    def refused(*texts, change):
        scene = make(1)
        change(scene, bpy.data.objects)
        try:
            said = "; ".join(whorl_export.export_scene(bpy.context, folder / "fault.toml"))
        except whorl_export.NotAScene as fault:
            said = str(fault)
        assert all(text in said for text in texts), said

    def grow(scene, things):
        things["stone"].keyframe_insert("scale", frame=FIRST)
        things["stone"].scale = (1, -2, 3)
        things["stone"].keyframe_insert("scale", frame=FIRST + 2)

    def add_empty(scene, things):
        bpy.data.collections["solid"].objects.link(bpy.data.objects.new("nothing", None))
        things["fluid"].data.clear_geometry()

    def open_fluid(scene, things):
        things["fluid"].data = things["tray"].data

    def mark_twice(scene, things):
        things["stone"]["drain"] = 1

    def tilt_hole(scene, things):
        things["tray"].data.vertices[4].co.z += 0.01

    def bend(scene, things):
        things["nozzle"].data.vertices[0].co.z += 0.01

    def dry(scene, things):
        for name in ("fluid", "nozzle"):
            bpy.data.objects.remove(things[name])

    refused("stone: its scale changes at frame 11; remove", change=grow)
    refused("nothing: has no faces; make it", "fluid: has no faces", change=add_empty)
    refused("fluid: is not closed at 4 edges; fill", change=open_fluid)
    refused("stone: is marked as drain and solid; leave one", change=mark_twice)
    refused("tray: a container is open at one end, cut flat", change=tilt_hole)
    refused("nozzle: an emitter is flat; use", change=bend)
    refused("the scene has no fluid; put", change=dry)

    def many(scene, things):  # names that differ only in characters that file names lack, or in capitals
        for name in ("Stone", "a/b", "a b"):
            copy = things["stone"].copy()
            copy.name = name
            bpy.data.collections["solid"].objects.link(copy)
        mesh = bpy.data.objects.new("forgotten", things["stone"].data)
        lamp = bpy.data.objects.new("lamp", bpy.data.lights.new("lamp", "POINT"))
        scene.collection.objects.link(mesh)
        scene.collection.objects.link(lamp)
        del things["nozzle"]["whorl.speed"]

    refused("without a role: forgotten", "lamp", "nozzle: a speed", change=many)
    tables = tomllib.loads((folder / "fault.toml").read_text())
    assert len({solid["file"].lower() for solid in tables["solid"]}) == 5, tables["solid"]
    assert "# - objects without a role: forgotten" in (folder / "fault.toml").read_text().splitlines()
    print("ok: scenes that cannot be exported are refused, with the object and a fix")


def come_back(folder):
    import bpy
    import numpy
    import whorl_import

    bpy.ops.wm.read_factory_settings(use_empty=True)
    whorl_import.import_run(bpy.context, folder / "run")
    scene = bpy.context.scene
    assert (scene.frame_start, scene.frame_end, scene.render.fps) == (1, FRAMES, FPS), (scene.frame_start, scene.frame_end)
    scene.frame_set(1)
    there, pixels = json.loads((folder / "there.json").read_text())
    fluid, stone, tray = (shape(next(thing for thing in scene.objects if thing.name.startswith(name)))
                          for name in ("scene fluid", "solid[0]", "solid[1]"))
    off = numpy.abs(fluid[1] - there["fluid"][1])
    assert off.max() < SPACING and off[2].max() < SPACING / 2, off  # the surface lies up to half a spacing beside the mesh, and is rounded
    print(f"ok: the fluid's box is {off[:2].max():.4f} m off, its centre {off[2].max():.4f} m, of {SPACING} m")
    assert numpy.abs(stone[1] - there["stone"][1]).max() < 1e-5
    for corners, (points, _) in ((stone[0], there["stone"]), (tray[0], there["tray"])):
        off = max(numpy.linalg.norm(corners - point, axis=1).min() for point in points)
        assert off < 1e-5, off  # single precision at 0.5 m
    print("ok: every corner of the solid and of the vessel's inside")
    off = numpy.abs(seen(scene, POINTS) - pixels).max()
    assert off < 0.01, off
    print(f"ok: points of the image are within {off:.4f} pixels")


if "bpy" in sys.modules or "--" in sys.argv:
    sys.path.insert(0, str(ROOT / "tools/blender"))
    stage, place = sys.argv[sys.argv.index("--") + 1:]
    {"out": go_out, "back": come_back}[stage](Path(place))
else:
    sys.exit(outside(sys.argv[1]))
