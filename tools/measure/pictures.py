"""Pictures of README.md and docs/guide, and the README's gallery."""
from . import drawing
from .registry import table
from .runs import number, read_rows

# Name of the file in docs/pictures: scene (or scene file), frame, width, options of whorl render.
pictures = {
    "honey_coil": ("honey_coil", 54, 720, []),
    "honey_ball": ("honey_ball", 62, 720, ["--quality", "draft", "--set", "look.samples=4"]),
    "dam_break": ("dam_break", 16, 720, ["--quality", "draft", "--set", "look.samples=4"]),
    "karman_street": ("karman_street", 60, 560, ["--quality", "draft"]),
}


def picture_of(name, scene, frame, width, options):
    def make(m):
        run = m.render(scene, f"pictures/{name}", threads=2, images=True, options=["--frames", frame, "--no-video", *options])
        drawing.picture(m, f"docs/pictures/{name}.png", [run.folder / f"frames/{frame:06d}.png"], width)

    return make


for name, what in pictures.items():
    table(f"picture_{name}", f"frame {what[1]} of {what[0]}", "some minutes", files=f"docs/pictures/{name}.png")(picture_of(name, *what))


@table("picture_live", "the page of a live run, as Chromium shows it", "1 minute", files="docs/pictures/live.png")
def picture_live(m):
    m.call(["bash", "tools/setup.sh", "chromium"])
    folder = m.build("whorl_validation")
    m.call([folder / "tests/whorl_validation", "[page_picture]"], environment={"WHORL_PICTURE": str(m.into / "docs/pictures/live.png")})


# The scenes of the gallery: what to see, the frame that is shown, quality of the whole film.
gallery_scenes = {
    "honey_coil": ("A thread of honey coils on a plate", 54, "standard"),
    "honey_ball": ("Honey over a wooden ball: folds heap on top and creep down the sides", 62, "standard"),
    "honey_thread": ("A long fall: the thread thins to half its radius and coils four times a second", 60, "standard"),
    "sewing_machine": ("Honey on a belt that slows down: a line, meanders, loops, coils", 120, "standard"),
    "cake_batter": ("A ribbon from a slot folds to and fro", 48, "standard"),
    "toothpaste": ("Paste on a roll, which stiffens as it lies", 72, "standard"),
    "lava": ("Lava pours on a slope and freezes as it ages", 96, "standard"),
    "dripping_syrup": ("Drops grow under a spout and fall on a thread that parts", 72, "standard"),
    "rotating_drop": ("A bar of syrup turns in weightlessness and slowly lengthens", 24, "draft"),
    "dam_break": ("Water collapses, hits the wall and sloshes back", 16, "draft"),
    "dam_break_obstacle": ("The same water runs into a post and splits", 16, "draft"),
    "paddle": ("Two crossed blades turn in a box of water", 48, "draft"),
    "floating_boxes": ("A dam breaks into a stack of crates and carries off what floats", 24, "draft"),
    "karman_street": ("A cylinder in a stream sheds vortices to both sides in turn", 60, "draft"),
    "shear_layer": ("Two streams slide past each other and roll up", 48, "draft"),
    "vortex_rings": ("The rear one of two rings passes through the front one", 36, "draft"),
    "taylor_green": ("An array of vortices decays, loses its symmetry, and merges", 48, "draft"),
    "stirred_tank": ("A paddle stirs a tank with a free surface", 48, "draft"),
}


@table("gallery", "every scene's best frame, its command, and how long its whole film takes on two cores", "hours: --only SCENE", "README.md",
       "docs/studies/gallery.csv and docs/pictures/gallery", keeps_rows=True)
def gallery(m):
    file = "docs/studies/gallery.csv"
    rows = {r["scene"]: r for r in read_rows(m.into / file)} if (m.into / file).exists() else {}
    for scene, (_, frame, quality) in gallery_scenes.items():
        if not m.wanted(scene):
            continue
        run = m.render(scene, f"gallery/{scene}", threads=2, images=True, options=["--quality", quality])
        drawing.picture(m, f"docs/pictures/gallery/{scene}.jpg", [run.folder / f"frames/{frame:06d}.png"], 960, ["-q:v", "3"])
        rows[scene] = {"scene": scene, "quality": quality, "frame": frame, "minutes": f"{max(panel['wall_seconds'] for panel in run.panels) / 60:.2f}"}
        lines = ["scene,quality,frame,minutes", *(",".join(str(cell) for cell in rows[s].values()) for s in gallery_scenes if s in rows)]
        m.write(file, ("\n".join(lines) + "\n").encode())
    return "\n\n".join(entry(rows[scene]) for scene in gallery_scenes if scene in rows)


def entry(row):
    scene, quality = row["scene"], row["quality"]
    words, minutes = gallery_scenes[scene][0], number(row["minutes"])
    takes = f"{60 * minutes:.0f} seconds" if minutes < 1 else f"{minutes:.0f} minutes"
    command = f"build/release/whorl render {scene}" + (f" --quality {quality}" if quality != "standard" else "")
    return f"![{words}](docs/pictures/gallery/{scene}.jpg)\n\n{words}: `{command}` ({takes})."
