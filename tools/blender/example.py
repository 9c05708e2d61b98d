"""Makes a Blender file to export with whorl_export.py: a jug pours caramel over a ball in a bowl.

    blender --background --python example.py -- pour.blend
"""
import math
import sys
from pathlib import Path

import bpy
from mathutils import Vector

bpy.ops.wm.read_factory_settings(use_empty=True)
scene = bpy.context.scene
scene.render.fps, scene.frame_start, scene.frame_end = 24, 1, 49
scene.render.resolution_x, scene.render.resolution_y = 640, 640
scene["whorl.fluid.spacing"], scene["whorl.fluid.viscosity"] = 0.003, 8.0


def add(thing, role=None):
    """Adds an object to the collection of its role."""
    collection = scene.collection
    if role:
        collection = bpy.data.collections.get(role) or bpy.data.collections.new(role)
        if role not in scene.collection.children:
            scene.collection.children.link(collection)
    collection.objects.link(thing)
    return thing


def lathe(name, role, profile, colour, roughness=0.3, glass=False, sides=48):
    """A profile (radius, height) turned about the z axis, and closed at the ends of radius 0."""
    points, faces, rings = [], [], []
    for radius, height in profile:
        count = sides if radius > 1e-9 else 1
        rings.append([len(points) + k for k in range(count)])
        points += [(radius * math.cos(2 * math.pi * k / sides), radius * math.sin(2 * math.pi * k / sides), height) for k in range(count)]
    for low, high in zip(rings, rings[1:]):
        for k in range(sides):
            face = [low[k % len(low)], low[(k + 1) % len(low)], high[(k + 1) % len(high)], high[k % len(high)]]
            faces.append(list(dict.fromkeys(face)))
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(points, [], faces)
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    inputs = material.node_tree.nodes["Principled BSDF"].inputs
    inputs["Base Color"].default_value, inputs["Roughness"].default_value = (*colour, 1), roughness
    inputs["Transmission" if "Transmission" in inputs else "Transmission Weight"].default_value = float(glass)
    mesh.materials.append(material)
    return add(bpy.data.objects.new(name, mesh), role)


lathe("board", "solid", [(0, -0.02), (0.16, -0.02), (0.16, -0.01), (0, -0.01)], (0.25, 0.11, 0.05), 0.6)
ball, bowl = ([(radius * math.sin(math.pi * k / parts), low + radius * (1 - math.cos(math.pi * k / parts))) for k in range(rings)]
              for radius, low, parts, rings in ((0.02, -0.002, 16, 17), (0.075, 0, 28, 13)))
lathe("ball", "solid", ball, (0.05, 0.25, 0.3))
lathe("bowl", "container", bowl, (0.8, 0.8, 0.78), 0.2)
jug = lathe("jug", "container", [(0, 0), (0.03, 0), (0.03, 0.08)], (1, 1, 1), 0, glass=True)
caramel = lathe("caramel", "fluid", [(0, 0.0015), (0.0285, 0.0015), (0.0285, 0.07), (0, 0.07)], (0.55, 0.2, 0.04), 0.25)
caramel.location = jug.location = (-0.1, 0, 0.12)
caramel["whorl.sampling"] = "blue_noise"
for frame, angle, height in ((1, 0, 0.12), (25, 95, 0.14), (49, 115, 0.14)):
    jug.rotation_euler.y, jug.location.z = math.radians(angle), height
    jug.keyframe_insert("rotation_euler", frame=frame)
    jug.keyframe_insert("location", frame=frame)

camera = add(bpy.data.objects.new("camera", bpy.data.cameras.new("camera")))
camera.location = (0.15, -0.5, 0.3)
camera.rotation_euler = (Vector((-0.02, 0, 0.08)) - camera.location).to_track_quat("-Z", "Y").to_euler()
scene.camera = camera
window = add(bpy.data.objects.new("window", bpy.data.lights.new("window", "AREA")))
window.location = (-0.5, -0.4, 0.8)
window.rotation_euler = (Vector((0, 0, 0.05)) - window.location).to_track_quat("-Z", "Y").to_euler()
window.data.size, window.data.energy = 0.4, 7
bpy.ops.wm.save_as_mainfile(filepath=str(Path(sys.argv[-1]).absolute()))
