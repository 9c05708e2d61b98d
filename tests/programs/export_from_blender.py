"""Scenes of Blender become scenes of Whorl: /usr/bin/python3 tests/programs/export_from_blender.py build/release/whorl

A scene made by script goes out with tools/blender/whorl_export.py, runs coarsely, and comes back with whorl_import.py: every object is
where it was, at the first and at the last frame, and so is the image of the camera. Ends with 77 (skipped) without Blender.
"""
import json
import math
import re
import shutil
import subprocess
import sys
import tempfile
import tomllib
from pathlib import Path

if "--" in sys.argv:  # in Blender
    sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tools/blender"))
    import bpy
    import numpy
    import whorl_export
    import whorl_import
    from bpy_extras.object_utils import world_to_camera_view
    from mathutils import Vector

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
    """Makes and returns a scene in units of `unit` metres."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.unit_settings.scale_length = unit
    scene.render.fps, scene.render.resolution_x, scene.render.resolution_y = FPS, 320, 180
    scene.frame_start, scene.frame_end = FIRST, FIRST + FRAMES - 1
    scene["whorl.fluid.spacing"], scene["whorl.fluid.viscosity"] = SPACING, 20
    for role in ("fluid", "solid", "container", "emitter", "drain"):
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
    wedge = [(0, 0, 0), (0.08, 0, 0), (0, 0.05, 0), (0, 0, 0.03)], [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]
    stone = add("stone", "solid", *wedge, (0.16, 0.2, 0), (0.3, -0.2, 1), (1, -2, 1))
    stone.data.materials.append(bpy.data.materials.new("red"))
    stone.active_material.use_nodes = True
    inputs = stone.active_material.node_tree.nodes["Principled BSDF"].inputs
    inputs["Base Color"].default_value, inputs["Roughness"].default_value = (0.5, 0.1, 0.05, 1), 0.25
    tray = add("tray", "container", [(0.3 * x - 0.15, 0.2 * y - 0.1, 0.1 * z) for x, y, z in box], sides, turn=(0, 0, 0.4))
    tray["whorl.wall"] = WALL
    slot = [(-0.04, -0.02, 0), (-0.04, 0.02, 0), (0.04, 0.02, 0), (0.04, -0.02, 0)]
    nozzle = add("nozzle", "emitter", slot, [(0, 1, 2, 3)], (0.03, -0.02, 0.2))
    nozzle["whorl.speed"] = 0.1
    paddle = add("paddle", "solid", *wedge, (0.03, 0.01, 0.1), (0, 0.2, 0))
    paddle.parent = bpy.data.objects.new("arm", None)
    paddle.parent.scale = (0.7, 0.7, 0.7)
    scene.collection.objects.link(paddle.parent)
    drain = add("drain", "drain", box, [*sides, (4, 5, 7, 6)], (-0.2, -0.15, -0.05), size=(0.3, 0.3, 0.02))
    drain["whorl.delay"] = 0.5
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.location, camera.rotation_euler = Vector((0.5, -0.8, 0.6)) / unit, (0.95, 0.1, 0.5)
    scene.collection.objects.link(camera)
    scene.camera = camera
    for thing, place, turn in ((paddle.parent, (-0.02, 0.01, 0.05), (0.1, 0, 2.5)), (camera, (0.6, -0.7, 0.5), (1, -0.2, 0.6)),
                               (nozzle, (0.01, -0.02, 0.2), (0.3, 0, 0))):
        for value, end in (("location", Vector(place) / unit), ("rotation_euler", turn)):
            thing.keyframe_insert(value, frame=FIRST)
            setattr(thing, value, end)
            thing.keyframe_insert(value, frame=FIRST + FRAMES - 1)
    for kind, energy, place, turn in (("AREA", 5, (0, 0, 0.9), (0, 0, 0)), ("POINT", 5, (0.3, 0, 0.4), (0, 0, 0)),
                                      ("SUN", 2, (1, 1, 1), (0.5, 0.3, 0))):
        lamp = bpy.data.objects.new(kind, bpy.data.lights.new(kind, kind))
        lamp.location, lamp.rotation_euler, lamp.data.color = Vector(place) / unit, turn, (0.8, 0.4, 0.2)
        lamp.data.energy = energy if kind == "SUN" else energy / unit**2  # W of Blender, whatever its unit of length
        if kind == "AREA":
            lamp.data.shape, lamp.data.size, lamp.data.size_y, lamp.scale = "RECTANGLE", 0.1 / unit, 0.05 / unit, (2, 2, 2)
        if kind == "POINT":
            lamp.data.shadow_soft_size = 0.02 / unit
        scene.collection.objects.link(lamp)
    scene.frame_set(FIRST)
    bpy.context.view_layer.update()
    return scene


def shape(thing):
    """Corners of an object, and its bounding box and centre of volume (3 x 3), in Blender's coordinates."""
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
    size = scene.render.resolution_x, scene.render.resolution_y
    return numpy.array([world_to_camera_view(scene, scene.camera, Vector(point)).to_2d() for point in points]) * size


def exported(scene, path):
    """Exports a scene. Returns its tables, and the text and the numbers of all of its files."""
    assert whorl_export.export_scene(bpy.context, path) == []
    folder, number = path.with_name(path.stem + "_meshes"), r"-?\d+(?:\.\d+)?(?:e[-+]\d+)?"
    text = "".join(file.read_text() for file in [path, *sorted(folder.glob("*.obj"))])
    motion = (folder / "motion.glb").read_bytes()
    values = numpy.frombuffer(motion[28 + int.from_bytes(motion[12:16], "little"):], dtype="<f4")
    values = numpy.concatenate([[float(found) for found in re.findall(number, text)], values])
    return tomllib.loads(path.read_text()), re.sub(number, "0", text), values


def go_out(folder):

    _, small_text, small = exported(make(0.01), folder / "scene.toml")
    scene = make(1)
    tables, text, values = exported(scene, folder / "scene.toml")
    assert text == small_text and numpy.abs(values - small).max() < 2e-5, "a scene in centimetres differs"  # degrees in single precision
    assert tables["time"] == {"end": (FRAMES - 1) / FPS, "fps": FPS} and tables["output"]["size"] == [320, 180], tables
    solids, slot, view = tables["solid"], tables["emitter"][0], tables["camera"]
    red, vessel = solids[0], solids[2]
    assert red["colour"] == [0.5, 0.1, 0.05] and red["roughness"] == 0.25 and red["metallic"] == 0, red
    assert vessel["container"] and vessel["open"] == "top" and vessel["rim"] == 0.1 and vessel["wall"] == WALL, vessel
    assert [slot[key] for key in ("direction", "width", "thickness")] == [[0, -1, 0], 0.08, 0.04], slot
    assert [table.get("node") for table in (*solids, slot, view)] == [None, "paddle", None, "nozzle", "camera"], tables
    assert tables["drain"][0]["delay"] == 0.5, tables["drain"]
    print("ok: the scene file has the frames, looks, vessel and opening of Blender's, in metres and in centimetres")

    there = []
    for frame in (FIRST, FIRST + FRAMES - 1):
        scene.frame_set(frame)
        nozzle = scene.objects["nozzle"].evaluated_get(bpy.context.evaluated_depsgraph_get()).matrix_world
        there.append([{name: [of.tolist() for of in shape(scene.objects[name])] for name in ("fluid", "stone", "tray", "paddle")},
                      [list(nozzle @ Vector(corner)) for corner in ((0, 0, 0), (0, 0, 1))], seen(scene, POINTS).tolist()])
    (folder / "there.json").write_text(json.dumps(there))
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

    # Blender's own reader of glTF sees the same motion.
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.context.scene.render.fps = FPS
    bpy.ops.import_scene.gltf(filepath=str(folder / "scene_meshes/motion.glb"))
    for frame, (_, nozzle, _) in zip((0, FRAMES - 1), there):
        bpy.context.scene.frame_set(frame)
        matrix = bpy.data.objects["nozzle"].matrix_world
        assert max((matrix @ Vector(a) - Vector(b)).length for a, b in zip(((0, 0, 0), (0, 0, 1)), nozzle)) < 1e-5, (matrix, nozzle)
    print("ok: the file of motions")

    scene = make(1)
    whorl_export.register()
    assert bpy.ops.export_scene.whorl(filepath=str(folder / "menu.toml")) == {"FINISHED"} and (folder / "menu.toml").exists()
    whorl_export.unregister()
    compare_lights(scene, tables, folder)
    faults(folder)


def compare_lights(scene, tables, folder):
    """Draws a white card at the target of each light, facing it."""
    lights = {thing.name: thing for thing in scene.objects if thing.type == "LIGHT"}
    scene.render.resolution_x = scene.render.resolution_y = 8
    scene.render.image_settings.file_format, scene.render.filepath = "OPEN_EXR", str(folder / "card.exr")
    whorl_import.set_cycles(scene, 64)
    scene.cycles.max_bounces = 0
    for thing in scene.objects:
        thing.hide_render = True
    card = bpy.data.objects.new("card", bpy.data.meshes.new("card"))
    card.data.from_pydata([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], [], [(0, 1, 2, 3)])
    card.data.materials.append(bpy.data.materials.new("white"))
    card.active_material.use_nodes = True
    nodes = card.active_material.node_tree.nodes
    white = nodes.new("ShaderNodeBsdfDiffuse")
    white.inputs["Color"].default_value = (1, 1, 1, 1)
    card.active_material.node_tree.links.new(white.outputs[0], nodes["Material Output"].inputs["Surface"])
    scene.camera = bpy.data.objects.new("over the card", bpy.data.cameras.new("over the card"))
    scene.camera.data.type, scene.camera.data.ortho_scale, scene.camera.parent, scene.camera.location = "ORTHO", 0.01, card, (0, 0, 20)
    for thing in (card, scene.camera):
        scene.collection.objects.link(thing)
    for table, name in zip(tables["light"], lights):
        target = table.get("target", [0, 0, 0])
        x, y, z = numpy.subtract(table["position"], target) if "position" in table else -numpy.array(table["direction"])
        card.location, card.rotation_euler = (target[0], -target[2], target[1]), Vector((x, -z, y)).to_track_quat("Z", "Y").to_euler()
        card.scale = (0.01, 0.01, 0.01)
        lights[name].hide_render = False
        bpy.ops.render.render(write_still=True)
        lights[name].hide_render = True
        image = bpy.data.images.load(scene.render.filepath)
        drawn = numpy.array(image.pixels[:]).reshape(-1, 4)[:, :3].mean(axis=0)
        bpy.data.images.remove(image)
        said = 0.7 * table["strength"] * numpy.array(table["colour"])
        assert numpy.abs(drawn / said - 1).max() < 0.03, (name, drawn, said)  # a large light is weaker at its sides
    print("ok: the lights are as bright as in Blender")


def faults(folder):
    """Scenes that are refused, and limits that are reported."""

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

    def disable(scene, things):
        things["stone"].hide_viewport = True

    def dry(scene, things):
        for name in ("fluid", "nozzle"):
            bpy.data.objects.remove(things[name])

    refused("stone: its scale changes at frame 11; remove", change=grow)
    refused("nothing: has no faces; make it", "fluid: has no faces", change=add_empty)
    refused("fluid: is not closed at 4 edges; fill", change=open_fluid)
    refused("stone: is marked as drain and solid; leave one", change=mark_twice)
    refused("tray: a container is open at one end, cut flat", change=tilt_hole)
    refused("nozzle: an emitter is flat; use", change=bend)
    refused("stone: is disabled in viewports", change=disable)
    refused("the scene has no fluid; put", change=dry)

    def many(scene, things):  # names that differ only in characters that file names lack, or in capitals
        for name in ("Stone", "a/b", "a b"):
            copy = things["stone"].copy()
            copy.name = name
            bpy.data.collections["solid"].objects.link(copy)
        mesh = bpy.data.objects.new("forgotten", things["stone"].data)
        scene.collection.objects.link(mesh)
        del things["nozzle"]["whorl.speed"]
        things["stone"].hide_render, things["tray"].data = True, things["fluid"].data
        things["fluid"].shape_key_add(name="rest")
        things["fluid"].shape_key_add(name="bent").data[0].co.z -= 0.01
        bent = things["fluid"].data.shape_keys.key_blocks["bent"]
        bent.keyframe_insert("value", frame=FIRST)
        bent.value = 1
        bent.keyframe_insert("value", frame=FIRST + 2)
        material = things["stone"].active_material
        things["fluid"].data.materials.append(material)
        material.node_tree.nodes["Principled BSDF"].inputs["Transmission"].default_value = 1
        absorption = material.node_tree.nodes.new("ShaderNodeVolumeAbsorption")
        absorption.inputs["Color"].default_value, absorption.inputs["Density"].default_value = (0.75, 0.5, 0.25, 1), 40

    refused("without a role: forgotten", "nozzle: a speed", "fluid: the change of its shape", change=many)
    tables = tomllib.loads((folder / "fault.toml").read_text())
    assert len({solid["file"].lower() for solid in tables["solid"]}) == 6, tables["solid"]
    assert tables["look"] == {"style": "liquid", "material": "water", "refraction": 1.45, "absorption": [10, 20, 30]}, tables["look"]
    assert tables["solid"][0]["material"] == "glass" and tables["solid"][0]["show"] is False, tables["solid"]
    assert "open" not in tables["solid"][-1] and tables["solid"][-1]["container"] is True, tables["solid"]  # closed, so with a lid
    assert "# - objects without a role: forgotten" in (folder / "fault.toml").read_text().splitlines()
    print("ok: scenes that cannot be exported are refused, with the object and a fix")


def come_back(folder):

    bpy.ops.wm.read_factory_settings(use_empty=True)
    whorl_import.import_run(bpy.context, folder / "run")
    scene = bpy.context.scene
    assert (scene.frame_start, scene.frame_end, scene.render.fps) == (1, FRAMES, FPS), (scene.frame_start, scene.frame_end)
    lights = {thing.data.type: thing for thing in scene.objects if thing.type == "LIGHT"}
    assert {kind: round(light.data.energy, 4) for kind, light in lights.items()} == {"AREA": 4, "POINT": 4, "SUN": 1.6}, lights
    area = lights["AREA"].data
    assert abs(area.size - 0.2) + abs(area.size_y - 0.1) + abs(lights["POINT"].data.shadow_soft_size - 0.02) < 1e-6
    assert (lights["AREA"].matrix_world.translation - Vector((0, 0, 0.9))).length < 1e-5
    frames = json.loads((folder / "there.json").read_text())
    for frame, (there, opening, pixels) in zip((1, FRAMES), frames):
        scene.frame_set(frame)
        compare(scene, frame == 1, there, zip(frames[0][1], opening), pixels)


def compare(scene, first, there, opening, pixels):
    """Compares a frame of the imported run with the exported scene. opening: points at the first frame and at this one"""
    names = {"fluid": "scene fluid", "stone": "solid[0]", "tray": "solid[2]", "paddle": "solid[1]", "nozzle": "nozzle[0]"}
    here = {name: next(thing for thing in scene.objects if thing.name.startswith(theirs)) for name, theirs in names.items()}
    if first:
        off = numpy.abs(shape(here["fluid"])[1] - there["fluid"][1])
        assert off.max() < SPACING and off[2].max() < SPACING / 2, off  # the surface is rounded, and within half a spacing of the mesh
        print(f"ok: the fluid's box is {off[:2].max():.4f} m off, its centre {off[2].max():.4f} m, of {SPACING} m")
    for name in ("stone", "tray", "paddle"):  # the tray has more corners, on its outside
        off = max(numpy.linalg.norm(shape(here[name])[0] - point, axis=1).min() for point in there[name][0])
        assert off < 1e-5, (name, off)  # single precision at 0.5 m
    off = max((here["nozzle"].matrix_world @ Vector(start) - Vector(now)).length for start, now in opening)
    assert off < 1e-5, off
    off = numpy.abs(seen(scene, POINTS) - pixels).max()
    assert off < 0.01, off
    print(f"ok: all corners of solids and the nozzle are there, and points of the image are within {off:.4f} pixels")


if "--" in sys.argv:
    stage, place = sys.argv[sys.argv.index("--") + 1:]
    {"out": go_out, "back": come_back}[stage](Path(place))
else:
    sys.exit(outside(sys.argv[1]))
