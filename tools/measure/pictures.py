"""Images of README.md and docs/guide, and the time of whole runs."""
import re

from . import drawing
from .registry import markdown, table, write_file
from .runs import number, read_rows, read_scene, root


@table("picture_honey_coil", "the README's first image: the gallery's frame of honey_coil", "1 minute",
       files="docs/pictures/honey_coil.png", section=False)
def picture_honey_coil(m):
    drawing.picture(m, "docs/pictures/honey_coil.png", [gallery_image(m, "honey_coil")], 720)


@table("picture_over_plate", "thick_coil without a background, laid over an image of a cloth with a box and a ball", "2 minutes",
       files="docs/pictures/guide/over_plate.jpg", section=False)
def picture_over_plate(m):
    camera = {"kind": "fixed", "position": [0, 0.12, 0.42], "target": [0, 0.008, 0], "fov": 25}  # thick_coil's
    plate = m.toml_file("pictures/plate", {
        "time": {"end": 0.01},
        "domain": {"min": [-0.3, -0.1, -0.3], "max": [0.3, 0.2, 0.7]},
        "fluid": {"spacing": 5e-3, "viscosity": 10},
        "emitter": [{"position": [0, 0.05, 0.6], "radius": 0.02, "speed": 0.2, "start": 5}],  # behind the camera, closed until 5 s
        "solid": [{"shape": "plane", "position": ["0", "-0.068", "0"], "normal": [0, 1, 0]},
                  {"shape": "sphere", "position": ["0.13", "-0.033", "-0.12"], "radius": 0.035, "material": "wood"},
                  {"shape": "box", "min": [-0.19, -0.068, -0.16], "max": [-0.12, 0.002, -0.09], "material": "rock"}],
        "camera": camera,
        "look": {"table": "cloth", "samples": 8}})
    pictures = [m.render(scene, f"pictures/{name}", *settings, threads=2, images=True, options=["--frames", frame, "--no-video"]).folder
                / f"frames/{frame:06}.png"
                for scene, name, frame, settings in ((plate, "plate_run", 1, ()),
                                                     ("scenes/thick_coil.toml", "over_plate", 80,
                                                      ["look.background=transparent", "look.table=none", "camera.aperture=0"]))]
    laid = m.out / "pictures/laid.png"
    m.call(["ffmpeg", "-v", "error", "-y", "-i", pictures[0], "-i", pictures[1], "-filter_complex", "overlay", laid])
    drawing.picture(m, "docs/pictures/guide/over_plate.jpg", [laid], 800, ["-q:v", "4"])


# One frame of honey_ball, drawn with the defaults and with one key changed.
controls = ("", "surface.smoothing=0", "surface.voxel=1", "look.samples=1", "camera.shutter=360", "camera.aperture=0.016",
            "look.absorption=[2, 11, 55]", "look.background=dark", "look.table=none")


@table("picture_controls", "a frame of honey_ball, drawn again with one key changed", "3 minutes",
       files="docs/pictures/guide/controls.jpg", section=False)
def picture_controls(m):
    frame = 36
    run = m.render("honey_ball", "pictures/controls", threads=2, images=True,
                   options=["--frames", frame, "--size", "480x400", "--quality", "draft", "--no-draw", "--set", "camera.fov=19",
                            "--set", "look.samples=16"]).folder
    pictures = []
    for k, change in enumerate(controls):
        folder = m.out / f"pictures/control_{k}"
        m.whorl("draw", run, "--frames", f"{frame}-{frame}", "--no-video", "--quiet", "--overwrite", "--out", folder,
                *(["--set", change] if change else []))
        pictures.append(folder / f"frames/{frame:06}.png")
    drawing.picture(m, "docs/pictures/guide/controls.jpg", pictures, 400, ["-q:v", "3"], columns=3)


# A plain look of five scenes: no lens, no motion blur, few samples, little smoothing.
plain_look = ("camera.aperture=0", "camera.shutter=0", "look.samples=4")
plain_looks = {"honey_ball": ("surface.smoothing=3",), "toothpaste": ("surface.smoothing=1", "look.table=none", "look.scattering=0"),
               "sewing_machine": ("surface.smoothing=3", "look.table=none"), "honey_coil": ("surface.smoothing=3", "look.table=none"),
               "dam_break": ("surface.smoothing=1", "look.table=none", "look.foam=0")}


@table("picture_pairs", "five images of the gallery, each next to the same frame with a plain look", "10 minutes",
       files="docs/pictures/guide/pairs.jpg", section=False)
def picture_pairs(m):
    pictures = [gallery_image(m, scene, *change) for scene, look in plain_looks.items() for change in ((*plain_look, *look), ())]
    drawing.picture(m, "docs/pictures/guide/pairs.jpg", pictures, 480, ["-q:v", "3"], columns=2)


@table("picture_live", "the page of a live run, as Chromium shows it", "1 minute", files="docs/pictures/live.png", section=False)
def picture_live(m):
    m.call(["bash", "tools/setup.sh", "chromium"])
    folder = m.build("whorl_validation")
    m.call([folder / "tests/whorl_validation", "[page_picture]"], environment={"WHORL_PICTURE": str(m.into / "docs/pictures/live.png")})


# Caption, time of the image [s], quality of the run and other options
gallery_scenes = {
    "honey_coil": ("A thread of cold honey coils into a stack of ten turns, which sinks. At two thirds of the speed.", 1.36, "standard"),
    "thick_coil": ("A finger-thick coil of very viscous honey.", 3.3, "standard"),
    "honey_ball": ("Honey over a wooden ball.", 2.33, "standard"),
    "honey_thread": ("A long fall: the thread thins and coils fast. At half speed.", 2.2, "standard"),
    "sewing_machine": ("Honey on a belt that slows down: a line, meanders, loops, coils.", 5.9, "standard"),
    "cake_batter": ("A ribbon from a slot folds to and fro.", 2.6, "standard"),
    "toothpaste": ("Paste on a moving roll. It stiffens as it lies.", 3.9, "standard"),
    "chocolate_cake": ("Chocolate over a ring cake on a turning plate.", 2.46, "standard"),
    "honey_dipper": ("Honey runs off a dipper.", 2.04, "standard"),
    "honey_jar": ("A spoon lifts honey out of a jar and lets it run back.", 2.21, "draft --set look.samples=6"),
    "toothpaste_writing": ("A nozzle writes a word in toothpaste.", 6.46, "draft --set look.samples=16"),
    "whipped_cream": ("A nozzle lays a rosette of whipped cream on a cake.", 4.2, "standard"),
    "melting_chocolate": ("One cube of chocolate melts on a warm plate, the other keeps its edges on a cold one.", 4.0, "standard"),
    "melting_wax": ("Wax on a hot candlestick runs over the edge and freezes.", 2.9, "draft --set look.samples=16"),
    "marbled_paint": ("A comb is drawn through stripes of paint, and back.", 4.0, "draft --set look.samples=16"),
    "lava": ("Lava flows around boulders: its crust cracks.", 4.5, "standard"),
    "freezing_lava": ("Toes of lava creep over cold rock and freeze one after the other.", 5.46, "draft --set look.samples=16"),
    "dripping_syrup": ("A falling drop draws out a thread, which snaps. At a quarter of the speed.", 0.84, "standard"),
    "rotating_drop": ("Two drops with a neck between them rotate in weightlessness until the neck breaks. At a third of the speed.", 0.85, "standard"),
    "dam_break": ("A block of water collapses and hits the wall.", 0.96, "standard"),
    "dam_break_obstacle": ("The same water runs into a post.", 0.3, "standard"),
    "paddle": ("Two crossed blades turn in a box of water.", 2.9, "standard"),
    "floating_boxes": ("A wave carries off crates, a cask and a ball.", 1.05, "standard"),
    "turbulence": ("A crowd of vortices merges into a few. With spin they stay strong.", 1.4, "standard"),
    "towed_post": ("A post is towed and stops: spin keeps its vortices.", 1.5, "standard"),
    "spin_up": ("A torque on the particles' spin sets the fluid in rotation if the spin is zero at the wall.", 1.4, "standard"),
    "karman_street": ("A cylinder in a stream sheds vortices in turn.", 2.5, "standard"),
    "shear_layer": ("Two streams roll up into billows, which pair.", 1.2, "standard"),
    "taylor_green": ("Vortices that fill a cube break up into tubes.", 0.71, "standard"),
    "vortex_rings": ("One ring slips through the other; two meet head on and break into five.", 1.75, "draft --set look.samples=8"),
    "stirred_tank": ("A paddle stirs ink in a glass and stops. With spin the fluid turns on.", 1.0, "draft --set look.samples=16"),
}


# Runs keep both cores busy. So half of a run's CPU time is its duration on an idle machine, even if other programs delay the measured run.
cores = 2


@table("films", "time of each scene's whole run on two cores, drawing included: the README's gallery", "hours: --only SCENE",
       files="docs/studies/films.csv", keeps_rows=True)
def films(m):
    file, columns = "docs/studies/films.csv", ["scene", "quality", "minutes"]
    rows = {r["scene"]: r for r in read_rows(m.into / file)} if (m.into / file).exists() else {}
    for scene in gallery_scenes:
        if m.wanted(scene):
            run, quality = whole_film(m, scene), gallery_scenes[scene][2]
            minutes = run.cpu_seconds / cores / 60
            rows[scene] = {"scene": scene, "quality": quality.split()[0], "minutes": f"{minutes:.2f}"}
            m.write_csv(file, columns, [rows[name] for name in gallery_scenes if name in rows])
    cells = [film(m, scene, rows.get(scene)) for scene in gallery_scenes]
    cells += [""] * (len(cells) % 2)
    return markdown(" | ", zip(cells[::2], cells[1::2]))


def whole_film(m, scene, quality=None):
    name = f"films/{scene}" + (f"_{quality}" if quality else "")
    return m.render(scene, name, threads=cores, images=True, options=["--quality", *(quality or gallery_scenes[scene][2]).split()])


# Scenes whose whole run at fine is measured, for comparison with the plan.
fine_films_run = ("dripping_syrup", "spin_up", "honey_ball")


@table("fine_films", "time of each scene's run at fine, predicted by the plan, and measured for three of them",
       "10 minutes, and 15 for the three whole runs", files="docs/studies/fine_films.csv", keeps_rows=True)
def fine_films(m):
    file, columns = "docs/studies/fine_films.csv", ["scene", "how", "simulation", "surface", "drawing"]
    rows = {(r["scene"], r["how"]): r for r in read_rows(m.into / file)} if (m.into / file).exists() else {}

    def keep(scene, how, seconds):
        rows[scene, how] = dict(zip(columns, [scene, how, *(f"{part:.0f}" for part in seconds)]))
        order = list(gallery_scenes)
        m.write_csv(file, columns, sorted(rows.values(), key=lambda row: (order.index(row["scene"]), row["how"] == "measured")))

    for scene in filter(m.wanted, gallery_scenes):
        seconds = m.plan(scene, options=["--quality", "fine"], threads=cores, images=True)["cost"]["film_cpu_seconds"]
        keep(scene, "predicted", (seconds["simulate"], seconds["surface"], seconds["draw"]))
        if scene in fine_films_run:
            run = whole_film(m, scene, "fine")
            surface, drawing = run.stage_seconds("surface"), run.drawing_seconds
            keep(scene, "measured", (run.cpu_seconds - drawing, surface, drawing - surface))
    columns = "scene | | simulation [CPU s] | surface [CPU s] | drawing [CPU s] | minutes of two cores"
    cells = []
    for (scene, how), row in sorted(rows.items(), key=lambda item: (list(gallery_scenes).index(item[0][0]), item[0][1] == "measured")):
        parts = [row[name] for name in ("simulation", "surface", "drawing")]
        cells.append([f"`{scene}`", how, *parts, f"{sum(map(number, parts)) / cores / 60:.1f}"])
    return markdown(columns, cells)


# Scenes and the moments [s] up to which their images are measured; what draft and standard set for drawing.
drawn_scenes = {"honey_coil": 1, "dam_break_obstacle": 0.4, "lava": 3, "stirred_tank": 0.4, "chocolate_cake": 2}
drawn_as = {"draft": (), "standard": ("look.samples=8", "surface.smoothing=8", "camera.shutter=180")}
image_stages = {"surface": "surface", "draw": "drawing", "write": "PNG file", "encode": "video"}


def stage_seconds(m, run, name, settings, options):
    """CPU seconds per frame that whorl draw prints, by stage, and the number of images."""
    folder = m.out / f"pictures/{name}"
    log = folder.with_name(folder.name + ".log")
    panel = run.folder / "panels/1"
    m.whorl("draw", panel if panel.exists() else run.folder, "--threads", 1, "--overwrite", "--out", folder, *options, *m.sets(settings),
            log=log)
    if m.dry:
        return dict.fromkeys(image_stages, 0.0), 2
    line = re.search(r"CPU seconds per frame: (.*)", log.read_text(encoding="utf-8"))[1]
    found = {stage: float(seconds) for stage, seconds in (part.rsplit(" ", 1) for part in line.split(", ")) if stage in image_stages}
    return found, len(list(folder.glob("frames/*")))


@table("image_stages", "CPU time of an image by stage, at draft and standard", "10 minutes")
def time_of_stages(m):
    cells = []
    for scene, until in filter(lambda item: m.wanted(item[0]), drawn_scenes.items()):
        run = m.render(f"scenes/{scene}.toml", f"pictures/stages_{scene}", f"time.fps={4 / until:g}", images=True,
                       options=["--quality", "draft", "--until", until, "--no-draw"])
        for quality, settings in drawn_as.items():
            name = f"stages_{scene}_{quality}"
            whole, frames = stage_seconds(m, run, name, settings, [])
            first, _ = stage_seconds(m, run, f"{name}_first", settings, ["--frames", 1])  # nearly all of it is the start of the program
            seconds = [(frames * whole.get(stage, 0) - first.get(stage, 0)) / (frames - 1) for stage in image_stages]
            cells.append([f"`{scene}`", quality, *(f"{max(part, 0):.2f}" for part in seconds), f"{sum(seconds):.2f}"])
    return markdown(" | ".join(["scene", "", *(f"{name} [CPU s]" for name in image_stages.values()), "sum [CPU s]"]), cells)


@table("gallery", "one frame of every scene", "half a minute to 5 minutes per scene", files="docs/pictures/gallery", section=False)
def gallery(m):
    for scene in filter(m.wanted, gallery_scenes):
        drawing.picture(m, f"docs/pictures/gallery/{scene}.jpg", [gallery_image(m, scene)], 960, ["-q:v", "3"])


def gallery_image(m, scene, *changes):
    """File of the scene's frame in the gallery, drawn with these changes of its look."""
    _, moment, quality = gallery_scenes[scene]
    keys = read_scene(f"scenes/{scene}.toml")
    frame = 1 + round(moment * keys["time"]["fps"] * keys["time"].get("slow_motion", 1))
    if "panel" in keys:  # whorl draw draws one panel
        run = m.render(f"scenes/{scene}.toml", f"pictures/gallery_{scene}", threads=cores, images=True,
                       options=["--quality", *quality.split(), "--frames", frame])
        return run.folder / f"frames/{frame:06}.png"
    run = m.render(f"scenes/{scene}.toml", f"pictures/gallery_{scene}", threads=cores, images=True,
                   options=["--quality", *quality.split(), "--frames", frame, "--export", "raw", "--no-draw"])
    image = m.out / f"pictures/gallery_{scene}_{'plain' if changes else 'image'}/frames/{frame:06}.png"
    m.whorl("draw", run.folder, "--frames", f"{frame}-{frame}", "--no-video", "--quiet", "--overwrite", "--out", image.parents[1],
            *m.sets(changes))
    return image


def film(m, scene, row):
    """A cell of the README's gallery, with the measured time, or the predicted one if `row` is empty."""
    words, _, quality = gallery_scenes[scene]
    if row and row["quality"] == quality.split()[0]:
        minutes = number(row["minutes"])
    else:
        minutes = m.plan(scene, options=["--quality", *quality.split()], threads=2, images=True)["cost"]["film_seconds"] / 60
    takes = f" {minutes:.0f} min." if minutes > 0.75 else f" {max(6 * minutes, 1):.0f}0 s."
    command = f"build/release/whorl render {scene}" + f" --quality {quality}" * (quality != "standard")
    return f"![{scene}](docs/pictures/gallery/{scene}.jpg)<br>{words}{takes}<br>`{command}`"


@table("guide_pictures", "the last frame and the probe plots of the scenes printed in docs/guide", "1 minute per scene",
       files="docs/pictures/guide", section=False)
def guide_pictures(m):
    for page in sorted((m.into / "docs/guide").glob("*.md")):
        text = page.read_text(encoding="utf-8")
        files = dict(re.findall(r"^```\w+\n(?=# ([\w.]+\.\w+)\n)(.*?)^```$", text, re.M | re.S))
        folder = m.out / "guide" / page.stem
        for name, body in files.items():
            if not m.dry:
                write_file(folder / name, body.encode())
        scene = None
        for name in (file[:-5] for file in files if file.endswith(".toml")):
            whole = "[time]" in files[f"{name}.toml"]  # otherwise it changes the complete scene before it
            scene = folder / f"{name}.toml" if whole else scene
            if f"pictures/guide/{name}.jpg" in text and m.wanted(name):
                over = [] if whole else ["--with", folder / f"{name}.toml"]
                run = m.render(scene, f"guide/{page.stem}/{name}", threads=2, images=True,
                               options=["--fps", 8, "--size", "960x540", "--no-video", *over])
                last = max(run.folder.glob("frames/*.png"), default=run.folder)
                drawing.picture(m, f"docs/pictures/guide/{name}.jpg", [last], 960, ["-q:v", "4"])
            for probe in re.findall(r"pictures/guide/(\w+)\.svg", text):
                if f'name = "{probe}"' in files[f"{name}.toml"] and m.wanted(name):
                    run = m.render(folder / f"{name}.toml", f"guide/{page.stem}/{name}_plots")
                    if not m.dry:
                        write_file(m.into / f"docs/pictures/guide/{probe}.svg", (run.folder / f"probes/{probe}.svg").read_bytes())
