"""Writes a scene of Whorl from Blender (3.4 and later): File > Export > Whorl scene. Or without a window:

    blender --background FILE.blend --python whorl_export.py -- SCENE.toml

Objects are exported if they are in a collection named fluid, solid, container, emitter or drain, or have a custom property of such a name.
Meshes are written into the folder SCENE_meshes. A custom property whorl.KEY of an object sets a key of its table, as in whorl.speed; of the
scene a key of the scene file, as in whorl.fluid.viscosity.
"""
bl_info = {
    "name": "Export a Whorl scene",
    "description": "Fluid, solids, emitters, drains and camera as a scene file of Whorl",
    "author": "Whorl",
    "version": (1, 0, 0),
    "blender": (3, 4, 0),
    "location": "File > Export > Whorl scene",
    "category": "Import-Export",
}

import argparse
import json
import math
import re
import struct
import sys
from collections import Counter
from pathlib import Path

import bpy
import numpy
from bpy_extras.io_utils import ExportHelper
from mathutils import Matrix, Vector

TABLES = {"fluid": "block", "solid": "solid", "container": "solid", "emitter": "emitter", "drain": "drain"}
SIDES = (("left", "right"), ("bottom", "top"), ("back", "front"))
SHADER_KEYS = {"Base Color": "colour", "Roughness": "roughness", "Metallic": "metallic", "IOR": "refraction",
               "Transmission": "transmission", "Transmission Weight": "transmission"}
LOOKS = {  # (fluid, transparent): keys that are set, keys of the shader
    (True, True): ({"style": "liquid", "material": "water"}, ("refraction", "absorption")),
    (True, False): ({"style": "opaque", "material": "paint"}, ("colour", "roughness")),
    (False, True): ({"material": "glass"}, ("colour",)),
    (False, False): ({"material": "ceramic"}, ("colour", "roughness", "metallic")),
}
Y_UP = Matrix(((1, 0, 0, 0), (0, 0, 1, 0), (0, -1, 0, 0), (0, 0, 0, 1)))  # from Blender, where z is up, to Whorl, where y is up


class NotAScene(Exception):
    """Raised if the scene cannot be exported. Each line of the message names an object, the cause and the fix."""


# Objects -------------------------------------------------------------------------------------------------------------------------------


def find_roles(scene):
    """{object: set of its roles}"""
    found = {thing: {role for role in TABLES if thing.get(role)} for thing in scene.objects}
    for collection in scene.collection.children_recursive:
        role = collection.name.split(".")[0].lower()
        for thing in collection.all_objects if role in TABLES else []:
            found[thing].add(role)
    return found


def properties(owner):
    """{key: value} of the custom properties whorl.key"""
    return {name[6:]: owner[name] for name in owner.keys() if name.startswith("whorl.")}


def each(action, things, *more):
    """[action(thing, *more) for all things]. Raises NotAScene with the faults of all of them."""
    results, faults = [], []
    for thing in things:
        try:
            results.append(action(thing, *more))
        except NotAScene as fault:
            faults.append(str(fault))
    if faults:
        raise NotAScene("\n".join(faults))
    return results


class Part:
    """An object with a role: its mesh in its own axes, in metres and with y up, and its pose at every frame."""

    def __init__(self, marked, metres):
        self.thing, found = marked
        self.name, self.metres, self.poses, self.size = self.thing.name, metres, [], None
        if len(found) > 1:
            raise NotAScene(f"{self.name}: is marked as {' and '.join(sorted(found))}; leave one of them")
        self.role, self.keys = *found, properties(self.thing)
        self.sample()
        self.points, self.faces = self.read()

    def read(self):
        """Points (n x 3) and faces (lists of points) of the object with its modifiers. Points at the same position are merged."""
        seen = self.thing.evaluated_get(bpy.context.evaluated_depsgraph_get())
        if not seen.is_evaluated:
            raise NotAScene(f"{self.name}: is disabled in viewports, so it has no position; disable it in renders instead")
        try:
            mesh = seen.to_mesh()
        except RuntimeError:
            mesh = None
        if not mesh or not mesh.polygons:
            raise NotAScene(f"{self.name}: has no faces; make it a mesh with faces, or remove it from its collection")
        points = numpy.array([vertex.co for vertex in mesh.vertices])
        cells = numpy.round(points / max(1e-6 * numpy.ptp(points, axis=0).max(), 1e-30))
        _, kept, merged = numpy.unique(cells, axis=0, return_index=True, return_inverse=True)
        faces = [[int(merged.ravel()[corner]) for corner in face.vertices] for face in mesh.polygons]
        seen.to_mesh_clear()
        if min(self.size) * max(self.size) * sorted(self.size)[1] < 0:  # mirrored
            faces = [face[::-1] for face in faces]
        return points[kept] * numpy.array(self.size) @ numpy.array(Y_UP.to_3x3()).T * self.metres, faces

    def sample(self):
        """Adds the pose at the current frame. Poses have no scale, which belongs to the mesh."""
        matrix = self.thing.matrix_world
        place, turn, size = matrix.decompose()
        self.size = self.size or size
        if (size - self.size).length > 1e-4 * self.size.length:
            raise NotAScene(f"{self.name}: its scale changes at frame {bpy.context.scene.frame_current}; remove the animation of its scale")
        if max(abs(x) for row in matrix - Matrix.LocRotScale(place, turn, size) for x in row) > 1e-4 * max(map(abs, size)):
            raise NotAScene(f"{self.name}: is sheared by its parent; apply the parent's scale")
        self.poses.append(Y_UP @ Matrix.LocRotScale(self.metres * place, turn, None) @ Y_UP.inverted())

    def placed(self, frame=0, points=None):
        """Points in Whorl's coordinates; default: those of the mesh."""
        pose = numpy.array(self.poses[frame])
        return (self.points if points is None else points) @ pose[:3, :3].T + pose[:3, 3]

    def corners(self):
        """Corners of the bounding box in Whorl's coordinates, frames x 8 x 3."""
        low, high = self.points.min(axis=0), self.points.max(axis=0)
        box = numpy.array([[(low, high)[n >> a & 1][a] for a in range(3)] for n in range(8)])
        return numpy.array([self.placed(frame, box) for frame in range(len(self.poses))])

    def moves(self):
        corners = self.corners()
        return numpy.abs(corners - corners[0]).max() > 1e-5 * numpy.ptp(corners[0], axis=0).max()

    def triangles(self, points):
        return numpy.array([[points[face[0]], points[b], points[c]] for face in self.faces for b, c in zip(face[1:], face[2:])])

    def hole(self):
        """The edges with an odd number of faces, (start, end), in the direction of one of these faces"""
        edges = [(a, b) for face in self.faces for a, b in zip(face, face[1:] + face[:1]) if a != b]
        faces = Counter(frozenset(edge) for edge in edges)
        return list({frozenset(edge): edge for edge in edges if faces[frozenset(edge)] % 2}.values())


# Tables of the scene file ----------------------------------------------------------------------------------------------------------------


def close(part):
    """Refuses a mesh that is not closed. The flat hole of a container is filled; returns its open side and its rim."""
    hole = part.hole()
    if not hole:
        return {}
    if part.role != "container":
        raise NotAScene(f"{part.name}: is not closed at {len(hole)} edges; fill its holes, or add the modifier Solidify")
    before, near = {end: start for start, end in hole}, 1e-4 * numpy.ptp(part.points, axis=0).max()
    ends = [(side, axis, pick(part.points[:, axis])) for axis, sides in enumerate(SIDES) for side, pick in zip(sides, (min, max))]
    found = [(side, end) for side, axis, end in ends if numpy.abs(part.points[list(before), axis] - end).max() < near]
    if not found or set(before) != set(before.values()) or len(before) < len(hole):
        raise NotAScene(f"{part.name}: a container is open at one end, cut flat across its own axes; fill other holes, recalculate normals")
    while before:  # a face for each loop of edges
        face = [next(iter(before))]
        while face[-1] in before:
            face.append(before.pop(face[-1]))
        part.faces.append(face[:-1])
    return {"open": found[0][0], "rim": found[0][1]}


def opening(part, said):
    """The keys of an emitter: a rectangle is a slot, any other flat mesh a disc of the same area. Fluid flows along the normal."""
    points = part.placed()
    a, b, c = part.triangles(points).transpose(1, 0, 2)
    normal, middle = numpy.cross(b - a, c - a).sum(axis=0) / 2, points.mean(axis=0)
    area = numpy.linalg.norm(normal)
    if numpy.abs((points - middle) @ normal).max() > 1e-3 * area**1.5 or not area:
        raise NotAScene(f"{part.name}: an emitter is flat; use a plane or a filled circle, whose normal is the direction of flow")
    normal, radius = normal / area, (area / math.pi)**0.5
    keys = {"position": middle, "direction": normal, "speed": 0.2}
    if "speed" not in part.keys:
        said.append(f"{part.name}: a speed, as it has no property whorl.speed; 0.2 m/s is written")
    if len(part.points) != 4:
        if numpy.linalg.norm(points - middle, axis=1).max() > 1.2 * radius:
            said.append(f"{part.name}: its outline; a disc of the same area is written")
        return {"shape": "disc", "radius": radius, **keys}
    corners = points[part.faces[0]]
    sides = [corners[1] - corners[0], corners[2] - corners[1]]
    lengths = [numpy.linalg.norm(side) for side in sides]
    width = numpy.cross((0, 1, 0), normal) if abs(normal[1]) < 0.9 else (1, 0, 0) - normal[0] * normal  # as Whorl turns a slot
    along = [abs(side @ width) / length / numpy.linalg.norm(width) for side, length in zip(sides, lengths)]
    if max(along) < 0.999:
        said.append(f"{part.name}: the turn of the slot about its normal; its side is level, or for a flow downwards along x")
    return {"shape": "box", "width": lengths[along[1] > along[0]], "thickness": lengths[along[1] <= along[0]], **keys}


def shader_of(part, said):
    """{key: value} of the first material's Principled BSDF and of the absorption in its volume; empty without one"""
    materials = [slot.material for slot in part.thing.material_slots if slot.material]
    nodes = list(materials[0].node_tree.nodes) if materials and materials[0].use_nodes else []
    shader = next((node for node in nodes if node.type == "BSDF_PRINCIPLED"), None)
    said += [f"{part.name}: its material {materials[0].name}, which has no Principled BSDF"] if materials and not shader else []
    said += [f"{part.name}: its materials after the first"] if len(set(materials)) > 1 else []
    inputs = shader.inputs if shader else []
    linked = [socket.name for socket in inputs if socket.is_linked]
    said += [f"{part.name}: the nodes at {', '.join(linked)} of its material"] if linked else []
    values = {SHADER_KEYS[socket.name]: socket.default_value for socket in inputs if socket.name in SHADER_KEYS and not socket.is_linked}
    for node in nodes:
        if node.type == "VOLUME_ABSORPTION":
            density, colour = (node.inputs[name].default_value for name in ("Density", "Color"))
            values["absorption"] = [density / part.metres * (1 - c) for c in colour[:3]]
    return values | ({"colour": values["colour"][:3]} if "colour" in values else {})


def look(part, said):
    """The keys of a solid's appearance, or of [look] for fluid"""
    values = {} if "material" in part.keys else shader_of(part, said)
    if not values:
        return {}
    keys, names = LOOKS[part.role == "fluid", values.get("transmission", 0) > 0.5]
    return keys | {name: values[name] for name in names if name in values}


def view_of(scene, size):
    """Pose and vertical angle of view [degrees] of the camera at the current frame, and the shift of its lens"""
    graph = bpy.context.evaluated_depsgraph_get()
    camera, render = scene.camera.evaluated_get(graph), scene.render
    lens = camera.calc_matrix_camera(graph, x=size[0], y=size[1], scale_x=render.pixel_aspect_x, scale_y=render.pixel_aspect_y)
    place, turn, _ = camera.matrix_world.decompose()
    pose = Y_UP @ Matrix.LocRotScale(scene.unit_settings.scale_length * place, turn, None)
    return pose, math.degrees(2 * math.atan(1 / lens[1][1])), max(abs(lens[0][2]), abs(lens[1][2]))


def camera_table(scene, views, middle, folder, tracks, said):
    """The keys of [camera]. middle: of the scene [m]"""
    name, camera, metres, (pose, fov, shift) = scene.camera.name, scene.camera.data, scene.unit_settings.scale_length, views[0]
    place, out, up = pose.translation, -pose.col[2].xyz, pose.col[1].xyz
    away = max((middle - place).dot(out), 0.1 * (middle - place).length)
    keys = {"shutter": min(360 * scene.render.motion_blur_shutter, 360) if scene.render.use_motion_blur else 0}
    if camera.dof.use_dof:
        sharp = camera.dof.focus_object
        focus = (metres * (Y_UP @ sharp.matrix_world.translation) - place).dot(out) if sharp else metres * camera.dof.focus_distance
        keys |= {"aperture": metres * camera.lens / 1000 / camera.dof.aperture_fstop, "focus": focus}
    said += [f"{name}: the shift of its lens"] if shift > 1e-4 else []
    said += [f"{name}: the change of its angle of view"] if any(abs(view[1] - fov) > 1e-3 for view in views) else []
    if any(max(map(abs, (view[0] - pose).col[a])) > 1e-5 for view in views for a in range(4)):
        return {"kind": "animation", **follow("camera", [view[0] for view in views], folder, tracks), "fov": fov, **keys}
    return {"kind": "fixed", "position": place, "target": place + away * out, "up": up, "fov": fov, **keys}


def light_table(light, middle, metres, said):
    """The keys of a light. middle: of the scene [m]. A strength of 1 gives a white surface that faces the light the radiance 0.7."""
    data, (place, turn, size) = light.data, light.matrix_world.decompose()
    place, out, brightest = metres * (Y_UP @ place), -(Y_UP.to_3x3() @ turn.to_matrix()).col[2], max(*data.color, 1e-6)
    colour, strength = {"colour": data.color / brightest}, data.energy * brightest / (0.7 * math.pi)
    if data.type == "SUN":
        return {"kind": "sun", "direction": out, "angle": min(max(math.degrees(data.angle), 0.1), 60), **colour, "strength": strength}
    target = place + max((middle - place).dot(out), 0.1 * (middle - place).length) * out if data.type == "AREA" else middle
    strength /= 4 * ((target - place).length / metres)**2  # the radiance of an area light of A m^2 is 1/(4 A) per W
    if data.type == "AREA":
        sides = metres * data.size * size.x, metres * (data.size_y if data.shape in ("RECTANGLE", "ELLIPSE") else data.size) * size.y
        round_off = 1 if data.shape in ("SQUARE", "RECTANGLE") else math.pi**0.5 / 2
        return {"kind": "soft_box", "position": place, "target": target, "size": [round_off * side for side in sides], **colour,
                "strength": strength}
    said += [f"{light.name}: its cone"] if data.type == "SPOT" else []
    return {"kind": "lamp", "position": place, "target": target, "radius": max(metres * data.shadow_soft_size, 1e-4), **colour,
            "strength": strength / math.pi}


def follow(name, poses, folder, tracks):
    """The keys of a table that follows a node of the file of motions. Adds the node to tracks, {name: poses}."""
    tracks[name] = poses
    return {"animation": f"{folder.name}/motion.glb", "node": name}


# Files -----------------------------------------------------------------------------------------------------------------------------------


def toml(value, digits=12):
    if isinstance(value, (str, bool)):  # Blender 3.4 has no custom properties that are true or false
        return value if value in ("true", "false") else json.dumps(value, ensure_ascii=False)
    if hasattr(value, "__len__"):
        return f"[{', '.join(toml(x, 7) for x in value)}]"
    short = f"{value + 0.0:.6g}"
    return short if abs(float(short) - value) <= 3e-7 * abs(value) else f"{value:.{digits}g}"


def write_obj(path, points, faces):
    path.parent.mkdir(exist_ok=True)
    lines = ["# metres, y up"] + ["v %.7g %.7g %.7g" % tuple(point) for point in points]
    path.write_text("\n".join(lines + ["f " + " ".join(str(corner + 1) for corner in face) for face in faces]) + "\n")


def write_tracks(path, tracks, fps):
    """Writes a glTF file with a node for each track. Pose k of a track is at k/fps seconds."""
    nodes, accessors, channels, samplers, views, data = [], [], [], [], [], bytearray()

    def store(kind, values, **more):
        values = numpy.asarray(values, dtype="<f4")
        views.append({"buffer": 0, "byteOffset": len(data), "byteLength": values.nbytes})
        accessors.append({"bufferView": len(views) - 1, "componentType": 5126, "count": len(values), "type": kind, **more})
        data.extend(values.tobytes())
        return len(accessors) - 1

    times = numpy.arange(len(next(iter(tracks.values())))) / fps
    times = store("SCALAR", times, min=[0], max=[times[-1]])
    for name, poses in tracks.items():
        turns = [pose.to_quaternion() for pose in poses]
        for before, turn in zip(turns, turns[1:]):
            turn.make_compatible(before)
        values = {"translation": [list(pose.translation) for pose in poses], "rotation": [[q.x, q.y, q.z, q.w] for q in turns]}
        for target, kind in (("translation", "VEC3"), ("rotation", "VEC4")):
            channels.append({"sampler": len(samplers), "target": {"node": len(nodes), "path": target}})
            samplers.append({"input": times, "output": store(kind, values[target])})
        nodes.append({"name": name, **{target: value[0] for target, value in values.items()}})
    text = json.dumps({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": list(range(len(nodes)))}], "nodes": nodes,
                       "animations": [{"channels": channels, "samplers": samplers}], "accessors": accessors, "bufferViews": views,
                       "buffers": [{"byteLength": len(data)}]}).encode()
    text += b" " * (-len(text) % 4)
    head = struct.pack("<4sIIII", b"glTF", 2, 28 + len(text) + len(data), len(text), 0x4E4F534A)
    path.write_bytes(head + text + struct.pack("<II", len(data), 0x004E4942) + data)


def write_scene(path, said, tables, lists):
    lines = [f"# From {Path(bpy.data.filepath).name or 'an unsaved file'} of Blender."]
    lines += ["# Not exported:", *(f"# - {line}" for line in said)] if said else []
    heads = [("", tables.pop("", {}))] + [(f"\n[{name}]", keys) for name, keys in tables.items()]
    for head, keys in heads + [(f"\n[[{name}]]  # {comment}", keys) for name, comment, keys in lists]:
        lines += [head, *(f"{key} = {toml(value)}" for key, value in keys.items())] if keys else []
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


# A scene ---------------------------------------------------------------------------------------------------------------------------------


def describe(part, folder, tracks, said):
    """The keys of an object's table. Writes its mesh, and adds its motion to the tracks."""
    moves = part.moves() and not part.keys.get("density")  # a free body only starts
    hidden = {"show": False} if part.thing.hide_render else {}
    if part.role == "emitter":
        keys = opening(part, said)
        if moves:
            del keys["position"]
            middle = Matrix.Translation(part.points.mean(axis=0))
            keys["direction"] = numpy.array(part.poses[0])[:3, :3].T @ keys["direction"]
            keys |= follow(part.stem, [pose @ middle for pose in part.poses], folder, tracks)
        return {**keys, **look(part, said), **hidden, **part.keys}
    keys, solid = {"shape": "mesh", "file": f"{folder.name}/{part.stem}.obj", **close(part)}, TABLES[part.role] == "solid"
    write_obj(folder / f"{part.stem}.obj", part.points if solid else part.placed(), part.faces)
    if not solid:
        said += [f"{part.name}: its motion; its position at the first frame is written"] if moves else []
        return {**keys, **part.keys}
    if moves:
        keys |= follow(part.stem, part.poses, folder, tracks)
    else:
        place, (axis, angle) = part.poses[0].translation, part.poses[0].to_quaternion().to_axis_angle()
        keys |= {"position": place} if place.length else {}
        keys |= {"pivot": (0, 0, 0), "tilt": math.degrees(angle) * axis} if angle else {}
    keys |= {"container": True} if part.role == "container" else {}
    return {**keys, **look(part, said), **hidden, **part.keys}


def record(scene, size, said):
    """The objects with a role, and the views of the camera at all frames, none without a camera that Whorl has."""
    metres, now, views = scene.unit_settings.scale_length, scene.frame_current, []
    try:
        scene.frame_set(scene.frame_start)
        parts = each(Part, [(thing, found) for thing, found in find_roles(scene).items() if found], metres)
        lights = {thing: thing.matrix_world.copy() for thing in scene.objects if thing.type == "LIGHT"}
        for frame in range(scene.frame_start, scene.frame_end + 1):
            scene.frame_set(frame)
            if frame > scene.frame_start:
                each(Part.sample, parts)
            if scene.camera and scene.camera.data.type == "PERSP" and "whorl.camera.kind" not in scene:
                views.append(view_of(scene, size))
        for part in parts:
            points, _ = part.read()
            if points.shape != part.points.shape or numpy.abs(points - part.points).max() > 1e-4 * numpy.ptp(part.points, axis=0).max():
                said.append(f"{part.name}: the change of its shape; its shape at the first frame is written")
        said += [f"{light.name}: its motion" for light, matrix in lights.items() if light.matrix_world != matrix]
    finally:
        scene.frame_set(now)
    if not any(part.role in ("fluid", "emitter") for part in parts):
        raise NotAScene("the scene has no fluid; put an object into a collection named fluid or emitter")
    stems = {"camera"}
    for part in parts:
        part.stem = re.sub(r"[^\w-]+", "_", part.name)
        while part.stem.lower() in stems:  # some file systems do not distinguish upper and lower case
            part.stem += "_"
        stems.add(part.stem.lower())
    return parts, views


def spacing_of(parts, keys):
    """Ten thousand particles in the fluid at the start, and six across the narrowest opening [m]"""
    volume = sum(abs(numpy.linalg.det(part.triangles(part.points)).sum()) / 6 for part in parts if part.role == "fluid")
    narrow = [min(2 * table.get("radius", math.inf), table.get("width", math.inf), table.get("thickness", math.inf)) / 6
              for part, table in zip(parts, keys) if part.role == "emitter"]
    return float(f"{min(narrow + ([(volume / 1e4)**(1 / 3)] if volume else [])):.2g}")


def export_scene(context, path):
    """Writes the scene of the context to a scene file. Returns its content that Whorl cannot express, as lines. Raises NotAScene."""
    path, scene, said, tracks = Path(path), context.scene, [], {}
    render, metres, folder = scene.render, scene.unit_settings.scale_length, path.with_name(path.stem + "_meshes")
    size = [2 * max(8, round(side * render.resolution_percentage / 200)) for side in (render.resolution_x, render.resolution_y)]
    parts, views = record(scene, size, said)
    keys = each(describe, parts, folder, tracks, said)
    corners, fps = numpy.concatenate([part.corners().reshape(-1, 3) for part in parts]), render.fps / render.fps_base
    low, high = corners.min(axis=0), corners.max(axis=0)
    margin, middle = 0.25 * (high - low).max(), Vector((low + high) / 2)

    fluid, ours = [part for part in parts if part.role == "fluid"], {part.thing for part in parts}
    others = [thing.name for thing in scene.objects if thing.type == "MESH" and thing not in ours]
    said += [f"objects without a role: {', '.join(others)}"] if others else []
    said += ["the step between frames"] if scene.frame_step != 1 else []
    said += ["pixels that are not square"] if render.pixel_aspect_x != render.pixel_aspect_y else []
    said += [f"{scene.camera.name}: is not a perspective camera"] if scene.camera and scene.camera.data.type != "PERSP" else []
    tables = {
        "time": {"end": max(scene.frame_end - scene.frame_start, 1) / fps, "fps": fps},
        "domain": {"min": low - margin, "max": high + margin, "gravity": Y_UP @ scene.gravity if scene.use_gravity else (0, 0, 0)},
        "fluid": {"spacing": spacing_of(parts, keys)},
        "camera": camera_table(scene, views, middle, folder, tracks, said) if views else {},
        "look": look(fluid[0], said) if fluid and "whorl.look.material" not in scene else {},
        "output": {"size": size},
    }
    for key, value in properties(scene).items():
        table, _, name = key.rpartition(".")
        tables.setdefault(table, {})[name] = value
    lights = [thing for thing in scene.objects if thing.type == "LIGHT" and not thing.hide_render]
    said += [f"{light.name}: is light 9 or later" for light in lights[8:]]
    lists = [(TABLES[part.role], part.name, table) for part, table in zip(parts, keys)]
    lists += [("light", light.name, light_table(light, middle, metres, said)) for light in lights[:8]]
    if tracks:
        write_tracks(folder / "motion.glb", tracks, fps)
    write_scene(path, said, tables, lists)
    return said


# Add-on and command line ---------------------------------------------------------------------------------------------------------------


class WHORL_OT_export(bpy.types.Operator, ExportHelper):
    """Write a scene file of Whorl, with meshes in a folder next to it"""
    bl_idname = "export_scene.whorl"
    bl_label = "Export Whorl scene"
    filename_ext = ".toml"
    filter_glob: bpy.props.StringProperty(default="*.toml", options={"HIDDEN"})

    def execute(self, context):
        try:
            for line in export_scene(context, self.filepath):
                self.report({"WARNING"}, f"Not exported: {line}")
        except NotAScene as fault:
            self.report({"ERROR"}, str(fault))
            return {"CANCELLED"}
        return {"FINISHED"}


def menu_line(self, _):
    self.layout.operator(WHORL_OT_export.bl_idname, text="Whorl scene (.toml)")


def register():
    bpy.utils.register_class(WHORL_OT_export)
    bpy.types.TOPBAR_MT_file_export.append(menu_line)


def unregister():
    bpy.types.TOPBAR_MT_file_export.remove(menu_line)
    bpy.utils.unregister_class(WHORL_OT_export)


if __name__ == "__main__" and "--" in sys.argv:
    options = argparse.ArgumentParser(prog="whorl_export.py --", description="Writes the open Blender file as a scene of Whorl.")
    options.add_argument("scene", metavar="SCENE.toml")
    try:
        for not_exported in export_scene(bpy.context, options.parse_args(sys.argv[sys.argv.index("--") + 1:]).scene):
            print(f"Not exported: {not_exported}")
    except NotAScene as fault:
        sys.exit(f"whorl_export.py: {fault}")
elif __name__ == "__main__":
    register()
