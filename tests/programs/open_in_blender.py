"""Blender opens runs of Whorl: python3 tests/programs/open_in_blender.py build/release/whorl

A draft of honey_coil comes in with tools/blender/whorl_import.py and is drawn with Cycles. Its silhouette lies over Whorl's within two pixels,
the honey is amber, and the paddle's blades have the same pose as here. Ends with 77 (skipped) without Blender.
"""
import json
import math
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
HONEY_FRAME, PADDLE_FRAME, WIDTH, HEIGHT = 48, 20, 640, 360


def outside(whorl):
    """The part outside Blender: makes the runs, then calls Blender on them."""
    blender = shutil.which("blender")
    if not blender:
        print("there is no Blender; install it with: apt-get install -y --no-install-recommends blender")
        return 77
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)

        def run(*words):
            subprocess.run([whorl, *map(str, words), "--quiet"], check=True)

        run("render", "honey_coil", "--quality", "draft", "--frames", HONEY_FRAME, "--no-images", "--export", "mesh,scene,raw", "--out", folder / "honey")
        for colour in (0, 1):  # pixels that change with the fluid's colour show fluid
            run("draw", folder / "honey", "--frames", HONEY_FRAME, "--size", f"{WIDTH}x{HEIGHT}", "--set", "look.style=opaque", "--set", "look.roughness=1",
                "--set", f"look.colour=[{colour}, {colour}, {colour}]", "--out", folder / f"colour_{colour}")
        run("render", "paddle", "--frames", PADDLE_FRAME, "--set", "fluid.spacing=0.02", "--no-images", "--export", "mesh,scene", "--out", folder / "paddle")
        run("render", "cake_batter", "--quality", "draft", "--frames", PADDLE_FRAME, "--no-images", "--export", "mesh,scene", "--out", folder / "inks", "--set", "emitter[0].ink=[0, 1, 0]",
            "--set", "look.style=opaque", "--set", "look.colour=[0.9, 0.9, 0.9]")
        done = subprocess.run([blender, "--background", "--factory-startup", "--python-exit-code", "1", "--python", __file__, "--", folder], text=True,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        print(done.stdout if done.returncode else "\n".join(line for line in done.stdout.splitlines() if line.startswith("ok")))
        return done.returncode


def inside(folder):
    import bpy
    import numpy
    from mathutils import Vector
    sys.path.insert(0, str(ROOT / "tools/blender"))
    import whorl_import

    def opened(run, frame):
        bpy.ops.wm.read_factory_settings(use_empty=True)
        fluid = whorl_import.import_run(bpy.context, folder / run)
        whorl_import.set_cycles(bpy.context.scene, 4)
        bpy.context.scene.frame_set(frame)
        return bpy.context.scene, fluid

    def pixels(path):
        image = bpy.data.images.load(str(path))
        image.colorspace_settings.name = "Non-Color"
        return numpy.array(image.pixels[:]).reshape(image.size[1], image.size[0], -1)[::-1]

    def drawn(scene, name, width, height):
        scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = width, height, 100
        scene.render.filepath = str(folder / name)
        bpy.ops.render.render(write_still=True)
        return pixels(folder / name)

    def shining(colour):
        material = bpy.data.materials.new("shining")
        material.use_nodes = True
        nodes = material.node_tree.nodes
        nodes.clear()
        light, output = nodes.new("ShaderNodeEmission"), nodes.new("ShaderNodeOutputMaterial")
        light.inputs["Color"].default_value = (colour, colour, colour, 1)
        material.node_tree.links.new(light.outputs[0], output.inputs["Surface"])
        return material

    def widened(mask, radius):
        """The mask, dilated by `radius` pixels."""
        wide = mask.copy()
        for dy in range(-radius, radius + 1):
            for dx in range(-radius, radius + 1):
                if dx * dx + dy * dy <= radius * radius:
                    wide |= numpy.roll(mask, (dy, dx), (0, 1))
        return wide

    # The fluid follows the timeline, with its velocities.
    scene, fluid = opened("honey", 1)
    counts = []
    for frame in (2, 24, HONEY_FRAME):
        scene.frame_set(frame)
        counts.append(len(fluid.data.vertices))
    assert counts[0] < counts[1] < counts[2], counts
    velocity = numpy.empty(3 * counts[2], dtype=numpy.float32)
    fluid.data.attributes["velocity"].data.foreach_get("vector", velocity)
    fastest = numpy.linalg.norm(velocity.reshape(-1, 3), axis=1).max()
    assert 0.2 < fastest < 0.5, fastest  # it leaves the nozzle at 0.25 m/s
    print(f"ok: {counts} vertices, up to {fastest:.2f} m/s")

    # The look of the scene: amber, not black and not blank.
    about = json.loads((folder / "honey/run.json").read_text())
    assert about["status"] == "done"
    picture = drawn(scene, "honey.png", 160, 90)
    assert picture[..., :3].std() > 0.05

    # Its silhouette: the fluid shines, everything else is black.
    for thing in scene.objects:
        if thing.type == "LIGHT":
            thing.hide_render = True
        if thing.type == "MESH":
            thing.data.materials.clear()
            thing.data.materials.append(shining(1 if thing == fluid else 0))
    for node in scene.world.node_tree.nodes:
        if node.type == "BACKGROUND":
            node.inputs["Strength"].default_value = 0
    scene.view_settings.view_transform = "Standard"
    theirs = drawn(scene, "silhouette.png", WIDTH, HEIGHT)[..., 0] > 0.5
    small = drawn(scene, "small.png", 160, 90)[..., 0] > 0.5
    amber = picture[small][:, :3].mean(axis=0)
    assert amber[0] > 1.3 * amber[2], amber
    print("ok: the honey is", amber.round(2))
    black, white = (pixels(folder / f"colour_{colour}/frames/{HONEY_FRAME:06d}.png")[..., :3].max(axis=2) for colour in (0, 1))
    ours = white - black > 0.15  # more than what a white coil throws onto the plate
    unlit = white < 0.15  # holes between turns of the coil, dark whatever their colour
    assert ours.sum() > 3000, ours.sum()
    missing, beyond = (ours & ~widened(theirs, 2)).sum(), (theirs & ~widened(ours | unlit, 2)).sum()
    assert missing == 0 and beyond == 0, f"{missing} pixels of ours and {beyond} of theirs lie further than 2 pixels off"
    print(f"ok: silhouettes of {ours.sum()} and {theirs.sum()} pixels within 2 pixels of each other, {(ours != theirs).sum()} differ")

    # A fluid that is all of the second ink has that ink's colour, and is drawn in it: blue.
    scene, fluid = opened("inks", PADDLE_FRAME)
    colour = numpy.empty(4 * len(fluid.data.vertices), dtype=numpy.float32)
    fluid.data.attributes["colour"].data.foreach_get("color", colour)
    blue = whorl_import.linear("#1e50a0")
    assert numpy.abs(colour.reshape(-1, 4)[:, :3] - blue).max() < 0.01, colour[:4]
    assert fluid.active_material.node_tree.nodes["Principled BSDF"].inputs["Base Color"].is_linked
    print("ok: the ink is", blue.round(3))

    # The paddle: turned by the integral of its rotation, -5 min(1, t/0.5), about the middle of its first blade.
    scene, _ = opened("paddle", PADDLE_FRAME)
    t = (PADDLE_FRAME - 1) / 24
    angle = -5 * (t - 0.25)
    blade = next(thing for thing in scene.objects if thing.name.startswith("solid[1]"))
    blade = blade.evaluated_get(bpy.context.evaluated_depsgraph_get())
    there = [blade.matrix_world @ vertex.co for vertex in blade.data.vertices]
    for x in (-0.09, 0.09):
        for y in (-0.008, 0.008):
            for z in (-0.07, 0.07):
                here = Vector((x * math.cos(angle) - y * math.sin(angle), -z, 0.12 + x * math.sin(angle) + y * math.cos(angle)))  # z is up there
                off = min((corner - here).length for corner in there)
                assert off < 1e-5, (here, off)
    print(f"ok: the blade is turned by {math.degrees(angle):.1f} degrees")


if "bpy" in sys.modules or "--" in sys.argv:
    inside(Path(sys.argv[sys.argv.index("--") + 1]))
else:
    sys.exit(outside(sys.argv[1]))
