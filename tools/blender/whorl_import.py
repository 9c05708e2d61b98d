"""Opens a run of Whorl in Blender (3.4 and later): File > Import > Whorl run. Or without a window:

    blender --background --python whorl_import.py -- RUN_FOLDER [--save FILE.blend] [--render FILE.png] [--frame N] [--samples N] [--size WxH]

The run needs exports: whorl render SCENE --export mesh,scene (add vdb for volumes; replace mesh by points if the run has no surface). The
fluid follows the timeline: frame n of Blender shows frame n of the run. Install this file as an add-on (Edit > Preferences > Add-ons >
Install), so that saved .blend files keep following the timeline.
"""
bl_info = {
    "name": "Import a Whorl run",
    "description": "Fluid, solids, camera and light of a run of Whorl",
    "author": "Whorl",
    "version": (1, 0, 0),
    "blender": (3, 4, 0),
    "location": "File > Import > Whorl run",
    "category": "Import-Export",
}

import argparse
import json
import math
import struct
import sys
from pathlib import Path

import bpy
import numpy
from bpy.app.handlers import persistent
from mathutils import Matrix, Vector

Y_UP = Matrix.Rotation(math.pi / 2, 4, "X")  # from Whorl, where y is up, to Blender, where z is up


class NotARun(Exception):
    """Raised if a run cannot be opened; the message names the cause and, if there is one, the fix."""


# The files of a run --------------------------------------------------------------------------------------------------------------------


def read_ply(path):
    """Reads a PLY file of Whorl. Returns {name: column (numpy array)} and the triangles, n x 3."""
    with open(path, "rb") as file:
        columns, counts, element = [], {}, None
        for line in iter(file.readline, b"end_header\n"):
            if not line:
                raise NotARun(f"{path} is not a PLY file")
            words = line.decode().split()
            if words[0] == "element":
                element, counts[words[1]] = words[1], int(words[2])
            elif words[0] == "property" and element == "vertex":
                columns.append((words[2], "<i4" if words[1] == "int" else "<f4"))
        vertices = numpy.frombuffer(file.read(counts["vertex"] * 4 * len(columns)), dtype=columns)
        faces = numpy.frombuffer(file.read(), dtype=[("count", "u1"), ("corner", "<u4", 3)])
    return {name: vertices[name] for name, _ in columns}, faces["corner"]


def vectors(columns, ends, name):
    """The columns name + end, for all ends, as an array with one column each; None if one of them does not exist."""
    names = [name + end for end in ends]
    return numpy.stack([columns[n] for n in names], axis=1) if all(n in columns for n in names) else None


def read_scene(path):
    """Name of the scene in the .glb of a run, and its extras under "whorl"."""
    with open(path, "rb") as file:
        header = struct.unpack("<4sIIII", file.read(20))
        if header[0] != b"glTF":
            raise NotARun(f"{path} is not a glTF file")
        scene = json.loads(file.read(header[3]))["scenes"][0]
    return scene["name"], scene["extras"]["whorl"]


def sequence(folder, kind, name, suffix):
    """{frame: file} of the files folder/kind/name.NUMBER.suffix."""
    files = {}
    for path in (folder / kind).glob(f"{name}.*.{suffix}"):
        number = path.name[len(name) + 1:-len(suffix) - 1]
        if number.isdigit():
            files[int(number)] = path
    return files


# The fluid follows the timeline --------------------------------------------------------------------------------------------------------


def linear(colour):
    """"#rrggbb" as linear light."""
    value = numpy.array([int(colour[i:i + 2], 16) for i in (1, 3, 5)]) / 255
    return numpy.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055)**2.4)


def inked(body, inks, amounts):
    """Linear colours of a body with inks, for amounts n x 3. K/S = (1 - R)^2/(2 R) of pigments adds up (Kubelka and Munk)."""

    def ratio(reflected):
        kept = numpy.clip(reflected, 0.005, 0.98)
        return (1 - kept)**2 / (2 * kept)

    total = numpy.clip(1 - amounts.sum(axis=1), 0, 1)[:, None] * ratio(numpy.array(body))
    for amount, ink in zip(amounts.T, inks):
        total += amount[:, None] * ratio(linear(ink))
    return 1 + total - numpy.sqrt(total * (2 + total))


def fill(mesh, path, about):
    """Replaces the content of a mesh by a PLY file. about: the property "whorl" of the fluid object."""
    columns, triangles = read_ply(path)
    count = len(columns["x"])
    mesh.clear_geometry()
    mesh.vertices.add(count)
    mesh.vertices.foreach_set("co", numpy.stack([columns[c] for c in "xyz"], axis=1).ravel())
    if len(triangles):
        mesh.loops.add(3 * len(triangles))
        mesh.loops.foreach_set("vertex_index", triangles.astype(numpy.int32).ravel())
        mesh.polygons.add(len(triangles))
        mesh.polygons.foreach_set("loop_start", numpy.arange(0, 3 * len(triangles), 3, dtype=numpy.int32))
        if bpy.app.version < (4, 1, 0):
            mesh.polygons.foreach_set("loop_total", numpy.full(len(triangles), 3, dtype=numpy.int32))
        mesh.polygons.foreach_set("use_smooth", numpy.ones(len(triangles), dtype=bool))

    def attribute(name, kind, member, values):
        if count:
            mesh.attributes.new(name, kind, "POINT").data.foreach_set(member, numpy.ascontiguousarray(values).ravel())

    velocity, ink = vectors(columns, ("_x", "_y", "_z"), "velocity"), vectors(columns, ("_1", "_2", "_3"), "ink")
    if velocity is not None:
        # In m per second of the video. Cycles uses this name for motion blur.
        attribute("velocity", "FLOAT_VECTOR", "vector", velocity * about["slow"])
    if ink is not None:
        attribute("ink", "FLOAT_VECTOR", "vector", ink)
        colour = inked(about["body"], about["inks"].split(), ink)
        attribute("colour", "FLOAT_COLOR", "color", numpy.column_stack([colour, numpy.ones(count)]))
    for name in ("age", "viscosity", "density", "pressure", "radius"):
        if name in columns:
            attribute(name, "FLOAT", "value", columns[name])
    for name in ("id", "source"):
        if name in columns:
            attribute(name, "INT", "value", columns[name])
    mesh.update(calc_edges=True)


def show_frame(thing, frame):
    """Shows a frame of the run in a fluid object. Earlier frames show the first one, later frames the last one."""
    about = thing["whorl"]
    folder = Path(bpy.path.abspath(about["folder"]))
    number = min(max(frame, about["first"]), about["last"])
    path = folder / about["kind"] / f"{about['name']}.{number:04d}.ply"
    if path.exists():
        fill(thing.data, path, about)
    else:
        print(f"Whorl: {path} is missing")


@persistent
def follow(scene, _=None):
    for thing in scene.objects:
        if "whorl" in thing:
            show_frame(thing, scene.frame_current)


def follow_from_now_on():
    changes = bpy.app.handlers.frame_change_pre
    for old in [handler for handler in changes if handler.__name__ == "follow" and handler.__module__ == __name__]:
        changes.remove(old)
    changes.append(follow)


# Materials, light, camera --------------------------------------------------------------------------------------------------------------


def put(node, values):
    """Sets inputs of a node. values: (names, value) per input; uses the first name that the node has, as Blender 4 renamed some."""
    for names, value in values:
        for name in names:
            if name in node.inputs:
                node.inputs[name].default_value = value
                break


def body_of(fluid):
    """Colour of the surface; white for transparent materials, which get their colour from absorption."""
    return [1.0, 1.0, 1.0] if fluid["refracts"] else list(fluid["colour"])


def fluid_material(fluid, has_ink):
    material = bpy.data.materials.new("Whorl " + fluid["material"])
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    surface = next(node for node in nodes if node.type == "BSDF_PRINCIPLED")
    put(surface, [(("Roughness",), fluid["roughness"]), (("IOR",), fluid["refraction"])])
    put(surface, [(("Base Color",), (*body_of(fluid), 1))])
    if has_ink:
        colour = nodes.new("ShaderNodeAttribute")
        colour.attribute_name = "colour"
        links.new(colour.outputs["Color"], surface.inputs["Base Color"])
    if not fluid["refracts"]:
        put(surface, [(("Emission Color", "Emission"), (*fluid["emission"], 1)),
                      (("Emission Strength",), 1.0 if max(fluid["emission"]) > 0 else 0.0)])
        return material
    put(surface, [(("Transmission Weight", "Transmission"), 1.0)])
    # Beer-Lambert: the node absorbs density (1 - colour) per metre.
    most = max(max(fluid["absorption_per_m"]), 1e-6)
    absorption = nodes.new("ShaderNodeVolumeAbsorption")
    put(absorption, [(("Color",), (*(1 - a / most for a in fluid["absorption_per_m"]), 1)), (("Density",), most)])
    output = next(node for node in nodes if node.type == "OUTPUT_MATERIAL")
    volume = absorption.outputs[0]
    if fluid["haze_per_m"] > 0:  # scattered light, as a glow
        glow, both = nodes.new("ShaderNodeEmission"), nodes.new("ShaderNodeAddShader")
        put(glow, [(("Color",), (*fluid["scatter"], 1)), (("Strength",), fluid["haze_per_m"] * 0.25)])
        links.new(volume, both.inputs[0])
        links.new(glow.outputs[0], both.inputs[1])
        volume = both.outputs[0]
    links.new(volume, output.inputs["Volume"])
    return material


def cloud_material(size):
    """Material of a volume with an optical depth of about one through its middle. size: diagonal of the scene [m]."""
    material = bpy.data.materials.new("Whorl volume")
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.remove(next(node for node in nodes if node.type == "BSDF_PRINCIPLED"))
    volume = nodes.new("ShaderNodeVolumePrincipled")
    put(volume, [(("Density",), 10 / max(size, 1e-6))])
    links.new(volume.outputs[0], next(node for node in nodes if node.type == "OUTPUT_MATERIAL").inputs["Volume"])
    return material


def light_world(scene, about):
    scene.world = bpy.data.worlds.new("Whorl")
    scene.world.use_nodes = True
    nodes, links = scene.world.node_tree.nodes, scene.world.node_tree.links
    background = next(node for node in nodes if node.type == "BACKGROUND")
    if "environment" in about:
        if not Path(about["environment"]).exists():
            print(f"Whorl: {about['environment']} is missing, so the world stays grey")
            return
        picture = nodes.new("ShaderNodeTexEnvironment")
        picture.image = bpy.data.images.load(about["environment"])
        # The middle of the panorama is at Whorl's -z, which is Blender's y. Blender expects it at x.
        place, turn = nodes.new("ShaderNodeTexCoord"), nodes.new("ShaderNodeMapping")
        turn.inputs["Rotation"].default_value = (0, 0, math.pi / 2)
        links.new(place.outputs["Generated"], turn.inputs["Vector"])
        links.new(turn.outputs["Vector"], picture.inputs["Vector"])
        links.new(picture.outputs["Color"], background.inputs["Color"])
    else:
        background.inputs["Color"].default_value = (*about["studio"]["sky"], 1)


def add_soft_boxes(collection, about, studio, centre, distance):
    """Adds the studio's soft boxes as distant area lights. They are visible in reflections, but do not light matt surfaces."""
    for number, box in enumerate(about.get("studio", {}).get("soft_boxes", [])):
        light = bpy.data.lights.new(f"soft box {number}", "AREA")
        light.shape, light.size, light.size_y = "RECTANGLE", 2 * distance * box["size"][0], 2 * distance * box["size"][1]
        radiance = Vector(box["radiance"])
        light.color = radiance / max(radiance)
        light.energy = 4 * max(radiance) * light.size * light.size_y  # W: Cycles gives an area light of A m^2 the radiance 1/(4 A) per W
        lamp = bpy.data.objects.new(light.name, light)
        out, right = Y_UP.to_3x3() @ Vector(box["direction"]), Y_UP.to_3x3() @ Vector(box["right"])
        lamp.matrix_world = Matrix.Translation(centre + distance * out) @ Matrix((right, out.cross(right), out)).transposed().to_4x4()
        lamp.visible_diffuse = False
        lamp.visible_camera = False
        collection.objects.link(lamp)


def shape_lights(things):
    """Gives the lights of a scene file their sizes, which glTF lacks."""
    for light in (thing for thing in things if thing.type == "LIGHT"):
        if "radius" in light:
            light.data.shadow_soft_size = light["radius"]
        if "size" in light:
            light.data.energy /= math.pi  # a spot of P W has the intensity P/(4 pi), an area light P/4
            light.data.type = "AREA"
            light.data.shape, light.data.size, light.data.size_y = "RECTANGLE", *light["size"]


def set_camera(scene, camera, about):
    scene.camera = camera
    camera.data.sensor_fit = "VERTICAL"
    for number, degrees in enumerate(about["fov_degrees"]):
        camera.data.lens = 0.5 * camera.data.sensor_height / math.tan(math.radians(degrees) / 2)
        if len(set(about["fov_degrees"])) == 1:
            break
        camera.data.keyframe_insert("lens", frame=about["first_frame"] + number)


# A run ---------------------------------------------------------------------------------------------------------------------------------


def find_run(path):
    """The run folder that is or contains the path."""
    path = Path(path).absolute()
    for folder in (path, *path.parents[:2]):
        if (folder / "run.json").exists():
            return folder
    raise NotARun(f"{path} is not a run folder of Whorl (it has no run.json)")


def add_fluid(scene, folder, name, about):
    """Adds an object that follows the timeline: the mesh, or points if the run has no mesh. Returns None without either."""
    for kind in ("mesh", "points"):
        files = sequence(folder, kind, name, "ply")
        if not files:
            continue
        fluid = bpy.data.objects.new(f"{name} fluid", bpy.data.meshes.new(f"{name} fluid"))
        fluid["whorl"] = {"folder": str(folder), "kind": kind, "name": name, "first": min(files), "last": max(files),
                          "slow": about["seconds_a_frame"] * about["fps"], "body": body_of(about["fluid"]), "inks": " ".join(about["fluid"]["inks"])}
        fluid.matrix_world = Y_UP
        fluid.data.materials.append(fluid_material(about["fluid"], "ink_1" in read_ply(files[min(files)])[0]))
        scene.collection.objects.link(fluid)
        return fluid
    return None


def add_volume(scene, folder, name):
    files = sequence(folder, "vdb", name, "vdb")
    if not files:
        return None
    data = bpy.data.volumes.new(f"{name} volume")
    data.filepath = str(files[min(files)])
    data.is_sequence, data.frame_start, data.frame_duration, data.frame_offset = True, min(files), len(files), 0
    data.sequence_mode = "EXTEND"
    volume = bpy.data.objects.new(data.name, data)
    volume.matrix_world = Y_UP
    scene.collection.objects.link(volume)
    return volume


def import_run(context, path):
    """Imports a run into the scene of the context. Returns the object of the fluid or its volume. Raises NotARun."""
    folder, scene = find_run(path), context.scene
    scenes = sorted((folder / "scene").glob("*.glb"))
    if not scenes:
        raise NotARun(f"{folder} has no scene/*.glb; render it with --export mesh,scene")
    name, about = read_scene(scenes[0])
    scene.render.fps = max(1, round(about["fps"]))
    scene.render.fps_base = scene.render.fps / about["fps"]
    scene.frame_start, scene.frame_end = about["first_frame"], about["first_frame"] + about["frames"] - 1
    scene.render.resolution_x, scene.render.resolution_y = about["size"]

    before = set(bpy.data.objects)
    if not hasattr(numpy, "bool"):
        numpy.bool = bool  # Blender 3.4's glTF importer uses this name, which Debian 12's numpy lacks
    bpy.ops.import_scene.gltf(filepath=str(scenes[0]))
    things = {thing.name.split(".")[0]: thing for thing in set(bpy.data.objects) - before}
    for thing in things.values():
        for curve in thing.animation_data.action.fcurves if thing.animation_data and thing.animation_data.action else []:
            for key in curve.keyframe_points:
                key.interpolation = "LINEAR"
    camera = next(thing for thing in things.values() if thing.type == "CAMERA")
    set_camera(scene, camera, about)
    light_world(scene, about)
    shape_lights(things.values())

    cloud = about["fluid"]["style"] == "volume"
    fluid = (add_volume(scene, folder, name) if cloud else None) or add_fluid(scene, folder, name, about)
    if fluid is None:
        raise NotARun(f"{folder} has no fluid to show; render it with --export mesh,scene")
    follow_from_now_on()
    scene.frame_set(scene.frame_start)
    middle, size = fluid_extent(fluid, things)
    if fluid.type == "VOLUME":
        fluid.data.materials.append(cloud_material(size))
    if "studio" in things:
        add_soft_boxes(scene.collection, about, things["studio"], middle, 10 * size)
    return fluid


def fluid_extent(fluid, things):
    """Middle and diagonal [m] of the bounding box of the fluid and all meshes."""
    corners = [thing.matrix_world @ Vector(corner) for thing in things.values() if thing.type == "MESH" for corner in thing.bound_box]
    corners += [fluid.matrix_world @ Vector(corner) for corner in fluid.bound_box]
    low, high = (Vector(pick(c[a] for c in corners) for a in range(3)) for pick in (min, max))
    return (low + high) / 2, max((high - low).length, 1e-3)


# Add-on and command line --------------------------------------------------------------------------------------------------------------


class WHORL_OT_import(bpy.types.Operator):
    """Open a run of Whorl: choose run.json in the run folder"""
    bl_idname = "import_scene.whorl"
    bl_label = "Import Whorl run"
    bl_options = {"REGISTER", "UNDO"}
    filepath: bpy.props.StringProperty(subtype="FILE_PATH")
    filter_glob: bpy.props.StringProperty(default="run.json", options={"HIDDEN"})

    def invoke(self, context, _):
        context.window_manager.fileselect_add(self)
        return {"RUNNING_MODAL"}

    def execute(self, context):
        try:
            import_run(context, self.filepath)
        except NotARun as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        return {"FINISHED"}


def menu_line(self, _):
    self.layout.operator(WHORL_OT_import.bl_idname, text="Whorl run (run.json)")


def register():
    bpy.utils.register_class(WHORL_OT_import)
    bpy.types.TOPBAR_MT_file_import.append(menu_line)
    follow_from_now_on()


def unregister():
    bpy.app.handlers.frame_change_pre[:] = [h for h in bpy.app.handlers.frame_change_pre if h is not follow]
    bpy.types.TOPBAR_MT_file_import.remove(menu_line)
    bpy.utils.unregister_class(WHORL_OT_import)


def set_cycles(scene, samples):
    scene.render.engine = "CYCLES"
    scene.cycles.samples = samples
    scene.cycles.use_denoising = False  # not built into every Blender
    scene.cycles.sample_clamp_indirect, scene.cycles.blur_glossy = 2, 1  # without these, light through the fluid leaves bright grains
    scene.cycles.max_bounces = scene.cycles.transmission_bounces = 16


def main(words):
    options = argparse.ArgumentParser(prog="whorl_import.py --", description="Opens a run of Whorl in Blender.")
    options.add_argument("run", help="the run folder, as in out/honey_coil")
    options.add_argument("--save", metavar="FILE.blend", help="save the imported run")
    options.add_argument("--render", metavar="FILE.png", help="draw a frame with Cycles")
    options.add_argument("--frame", type=int, help="frame to draw (default: the last)")
    options.add_argument("--samples", type=int, default=64, help="samples per pixel (default: 64)")
    options.add_argument("--size", help="size of the image in pixels, as in 640x360 (default: the run's)")
    options = options.parse_args(words)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    register()
    scene = bpy.context.scene
    import_run(bpy.context, options.run)
    set_cycles(scene, options.samples)
    scene.frame_set(scene.frame_end if options.frame is None else options.frame)
    if options.size:
        scene.render.resolution_x, scene.render.resolution_y = map(int, options.size.split("x"))
    if options.save:
        bpy.ops.wm.save_as_mainfile(filepath=str(Path(options.save).absolute()))
    if options.render:
        scene.render.filepath = str(Path(options.render).absolute())
        bpy.ops.render.render(write_still=True)


if __name__ == "__main__" and "--" in sys.argv:
    try:
        main(sys.argv[sys.argv.index("--") + 1:])
    except NotARun as error:
        sys.exit(f"whorl_import.py: {error}")
elif __name__ == "__main__":
    register()
