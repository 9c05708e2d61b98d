"""docs/reports/tradeoff.md: fronts, maps, qualities, sleep, what auto chooses, what the plan foresees."""
import math
from types import SimpleNamespace

from . import drawing
from .registry import markdown, table
from .runs import Unknown, attempt, number, read_rows, read_scene, root

page = "docs/reports/tradeoff.md"


# Fronts and maps: whorl tradeoff and whorl stability draw them

def shipped_study(kind, name):
    def make(m):
        folder = m.out / "studies" / name
        if name == "precision":  # compares two programs
            m.build("whorl")
            m.build("whorl", "double")
        m.whorl(kind, root / f"scenes/studies/{kind}/{name}.toml", "--out", folder, log=folder.with_suffix(".log"))
        if not m.dry:
            m.write(f"docs/studies/{name}.svg", (folder / f"{kind}.svg").read_bytes())
            text = (folder / f"{kind}.csv").read_text().replace(f"{root}/", "")  # messages name files
            m.write(f"docs/studies/{name}.csv", text.encode())

    return make


fronts = {"hydrostatic_column": "still water, pressure against rho g h", "taylor_green": "vortices, decay against theory",
          "micropolar_decay": "micropolar vortices, decay against theory", "coil_frequency": "a coil, frequency against slender-thread theory",
          "dam_front": "a dam breaks, its centre against a finer run"}
maps = {"viscous_steps": "time step against viscosity, every model", "sound_steps": "time step against sound speed", "coupled_steps": "the coupled solve",
        "scale": "spacing 1e-6 m to 1e3 m", "gravity": "no gravity to 1000 g", "impact": "impact at 0.1 to 100 m/s", "thread_across": "particles across a thread",
        "micropolar_exchange": "micropolar coupling against inertia", "density_ratio": "a body's density over the water's against its impact speed",
        "precision": "single and double precision, against the distance from the origin"}
for prefix, kind, shipped in (("front", "tradeoff", fronts), ("map", "stability", maps)):
    for name, words in shipped.items():
        table(f"{prefix}_{name}", words, "1 to 5 minutes", files=f"docs/studies/{name}.svg and .csv")(shipped_study(kind, name))


def study_settings(until, frames):
    return [f"time.end={until}", "time.slow_motion=1", f"time.fps={frames / until:.12g}"]


# Draft, standard and fine

def against_fine(column, part="diagnostics.csv"):
    return {"of": "reference", "reference": ["quality=fine"], "at": "all", "table": part, "column": column}


density = {"of": "exact", "column": "density_error_mean", "at": "all", "expected": "0", "scale": 1}
potential, kinetic, second_panel = ((f"{kind} energy, to fine", against_fine(f"{kind}_energy", part)) for kind, part in (
    ("potential", "diagnostics.csv"), ("kinetic", "diagnostics.csv"), ("kinetic", "panels/2/diagnostics.csv")))
qualities = {  # scene: seconds, what the error is of
    "honey_coil": (1.6, "frequency of the first turns to steady theory",
                   {"of": "exact", "table": "probes/coil.csv", "column": "frequency", "expected": "2.139"}),
    "honey_ball": (0.9, *potential), "honey_thread": (0.45, *potential), "sewing_machine": (0.7, *kinetic), "cake_batter": (0.8, *potential),
    "toothpaste": (2.0, *potential), "lava": (1.2, *potential), "dam_break": (0.08, "mean density error", density),
    "dam_break_obstacle": (0.12, "mean density error", density), "paddle": (0.08, "mean density error", density),
    "floating_boxes": (0.06, "mean density error", density), "dripping_syrup": (0.3, *potential),
    "rotating_drop": (0.4, "angular momentum lost", {"of": "conserved", "column": "angular_momentum_z", "at": "all"}),
    "karman_street": (0.02, *second_panel), "shear_layer": (0.02, *second_panel), "vortex_rings": (0.015, *second_panel),
    "taylor_green": (0.04, "kinetic energy without spin, to theory",
                     {"of": "exact", "table": "panels/1/diagnostics.csv", "column": "kinetic_energy", "at": "all",
                      "expected": "0.004*exp(-4*2e-5*(20*pi)^2*t)"}),
    "stirred_tank": (0.04, *second_panel)}


def measure_quality(m, scene):
    """Rows of docs/studies/quality.csv of a scene, and its three pictures. Eight frames are enough to see, and pictures then cost little."""
    until, error_of, accuracy = qualities[scene]
    name, rows, images = f"quality/{scene}", [], []
    keys = {"scenes": [scene], "set": [*study_settings(until, 8), "output.size=[480, 270]"], "pictures": True, "limit": 3600,
            "knob": [{"key": "quality", "values": ["draft", "standard", "fine"]}]}
    figures, pictures = ({r["quality"]: r for r in m.study(name, {**keys, "accuracy": a})} or Unknown()
                         for a in (accuracy, {"of": "picture", "reference": ["quality=fine"]}))  # the second finds the points of the first
    for quality in ("draft", "standard", "fine"):
        run = m.point(name, f"quality={quality}-")
        cpu = (run.cpu_seconds - run.drawing_seconds) / run.report["time"]
        rows.append({"scene": scene, "until": until, "quality": quality, "spacing": run.scene["fluid"]["spacing"], "particles": run.report["particles"],
                     "cpu_seconds_a_second": f"{cpu:.4g}", "error": figures[quality]["error"], "error_of": error_of,
                     "picture_difference": pictures[quality]["error"]})
        images.append(max(run.folder.glob("frames/*.png"), default=run.folder))
    drawing.picture(m, f"docs/pictures/quality/{scene}.jpg", images, 320, ["-q:v", "3"])
    return rows


@table("quality", "draft, standard and fine of every scene: CPU time, error and picture of the first part of its film", "3 hours", page,
       "docs/studies/quality.csv and docs/pictures/quality", keeps_rows=True)
def quality(m):
    file, order = "docs/studies/quality.csv", list(qualities)
    columns = ["scene", "until", "quality", "spacing", "particles", "cpu_seconds_a_second", "error", "error_of", "picture_difference"]
    rows = read_rows(m.into / file) if (m.into / file).exists() else []
    for scene in filter(m.wanted, qualities):
        rows = [r for r in rows if r["scene"] != scene] + measure_quality(m, scene)
        rows.sort(key=lambda r: order.index(r["scene"]))
        m.write(file, "".join(",".join(str(r[c]) for c in columns) + "\n" for r in [dict(zip(columns, columns)), *rows]).encode())
    return quality_section(rows)


def quality_section(rows):
    scenes, lines = {}, []
    for r in rows:
        scenes.setdefault(r["scene"], {})[r["quality"]] = r
    for scene, q in scenes.items():
        cells = [f"`{scene}`", q["draft"]["error_of"], f"{q['draft']['until']} s"]
        for name in ("draft", "standard", "fine"):
            cpu, error = number(q[name]["cpu_seconds_a_second"]), 100 * number(q[name]["error"])
            reference = name == "fine" and error < 1e-6
            cells += [f"{cpu:.0f} s" if cpu >= 1000 else f"{cpu:.3g} s", "" if reference else f"{error:.2g} %"]
            cells += [f"{number(q[name]['picture_difference']):.2g}"] if name != "fine" else []
        lines.append([*cells, f"![](../pictures/quality/{scene}.jpg)"])
    return markdown(["scene", "error of", "until", "draft: time", "error", "dE", "standard: time", "error", "dE", "fine: time", "error", "the three"], lines)


# Sleep

@table("sleep", "what sleep saves and what it changes: fluid that has come to rest", "8 minutes", page)
def sleep(m):
    puddle, closed = "scenes/studies/puddle.toml", ["fluid.spacing=2.5e-3", "emitter[0].stop=1", "look.samples=1"]
    rows = []
    for words, scene, end, value, settings in (
            ("puddle, honey, coupled", puddle, 3, 0.06, []), ("puddle, honey, ppe", puddle, 3, 1, ["models.pressure=ppe"]),
            ("puddle, water, ppe", puddle, 8, 1, ["models.pressure=ppe", "fluid.viscosity=0", "look.material=water"]),
            ("honey_ball, poured out after 1 s", "scenes/honey_ball.toml", 5, 0.06, closed),
            ("toothpaste, laid in one place for 1 s", "scenes/toothpaste.toml", 8, 0.15, [*closed, 'solid[0].position=["0", "0", "0"]'])):
        if not m.wanted(words):
            continue
        name = "sleep/" + words.replace(", ", "_").replace(" ", "_")
        compared = m.study(name, {"scenes": [root / scene], "limit": 3600, "pictures": True,
                                  "set": [f"time.end={end}", "time.fps=8", "time.slow_motion=1", "output.size=[480, 270]", *settings],
                                  "knob": [{"key": "time.sleep", "values": [0, value]}],
                                  "accuracy": {"of": "picture", "reference": ["time.sleep=0"]}})
        awake, asleep = (m.point(name, f"time.sleep={v:g}-") for v in (0, value))
        times = []
        for run in (awake, asleep):  # of the simulation, from the start and over the last second
            d = run.table()
            late = ~(d["time"] < d["time"][-1] - 1 - 1e-9)
            seconds = d["cpu_seconds"][late]
            times.append((run.cpu_seconds - run.drawing_seconds, seconds[-1] - seconds[0] - run.drawing_seconds * (late.sum() - 1) / len(late)))
        (all_awake, late_awake), (all_asleep, late_asleep) = times
        a, b, fluid = awake.table(), asleep.table(), awake.scene["fluid"]
        weight = a["particles"][-1] * fluid["density"] * fluid["spacing"]**3 * 9.81
        off = abs(a["potential_energy"] - b["potential_energy"]).max()
        picture = next((r["error"] for r in compared if number(r["time.sleep"]) > 0), Unknown())
        rows.append([f"{words}, {end} s", value, f"{all_asleep:.2f}", f"{all_awake:.2f}", f"{all_awake / all_asleep:.1f}", f"{max(late_asleep, 0):.3f}",
                     f"{late_awake:.2f}", f"{late_awake / late_asleep:.0f}" if 100 * late_asleep > late_awake else "> 100",
                     f"{off / weight / fluid['spacing']:.3f} d", f"{100 * off / abs(a['potential_energy'][-1]):.2f} %", f"{number(picture):.2g} dE"])
    return markdown(["pool", "time.sleep", "CPU s, all", "awake", "times", "CPU s, last second", "awake", "times", "height differs by", "energy by",
                     "picture by"], rows)


# What auto chooses

honey = ["coupled+none", "ppe+full", "ppe+full_assembled", "ppe+explicit", "ppe+pairwise", "wcsph+full", "wcsph+pairwise"]
water = ["ppe+none", "ppe+xsph", "wcsph+none", "wcsph+xsph"]
vortices = ["wcsph+explicit", "wcsph+full", "wcsph+pairwise", "ppe+explicit", "ppe+full"]
honey_cases = [(scene, until, honey) for scene, until in (
    ("honey_coil", 0.9), ("honey_ball", 0.7), ("honey_thread", 0.4), ("sewing_machine", 0.6), ("cake_batter", 0.6), ("toothpaste", 0.7), ("lava", 0.8),
    ("rotating_drop", 0.2), ("dripping_syrup", 0.15))]
water_cases = [(scene, until, water) for scene, until in (("dam_break", 0.25), ("dam_break_obstacle", 0.1), ("paddle", 0.2), ("floating_boxes", 0.06))]
vortex_cases = [(scene, until, vortices) for scene, until in (
    ("karman_street", 0.02), ("shear_layer", 0.02), ("vortex_rings", 0.015), ("taylor_green", 0.02), ("stirred_tank", 0.03))]


def scene_with_models(m, scene, combination):
    """A copy of a scene with these models: keys of models that are not chosen may not stand in it. Panels go."""
    keys, (pressure, viscosity) = read_scene(f"scenes/{scene}.toml"), combination.split("+")
    micropolar = "micropolar" in keys.get("models", {})
    keys["models"] = {**keys.get("models", {}), "pressure": pressure, "viscosity": viscosity}
    if viscosity != "xsph":
        keys.pop("viscosity", None)
    if pressure not in ("auto", "wcsph") or not micropolar:
        keys.pop("pressure", None)
    if keys.pop("panel", None):
        keys.pop("output", None)
    if pressure == "wcsph":  # it solves nothing
        for changes in keys.get("quality", {}).values():
            changes.pop("pressure.tolerance", None)
    return m.overlay(f"auto/{scene}/{combination}", keys)


def compare_models(m, scene, until, combinations):
    """auto beside other models, at draft quality, one thread, least of two timings. Error: of the kinetic energy over all frames against auto at
    standard spacing. What takes more than four times the wall time of auto is broken off: it cannot be the cheaper one."""
    name, limit, by_name = f"auto/{scene}", 120.0, {}
    files = [scene_with_models(m, scene, combination) for combination in ("auto+auto", *combinations)]
    for some in (files[:2], files):
        keys = {"scenes": [files[0]], "quality": "draft", "limit": limit, "set": study_settings(until, 12), "knob": [{"key": "scene", "values": some}],
                "accuracy": {"of": "reference", "reference": ["quality=standard"], "column": "kinetic_energy", "at": "all"}, "cost": {"repeat": 2}}
        rows = m.study(name, keys)
        by_name = {combination: next((r for r in rows if f"/{combination}.toml" in str(r["scene"])), Unknown())  # of two columns, the knob's is read
                   for combination in ("auto+auto", *combinations)}
        limit = 2 + 4 * number(by_name["auto+auto"]["wall_seconds"])
    auto, models = by_name.pop("auto+auto"), [c for c in m.point(name, "auto+auto_scene=").report["models"]]
    took = "+".join(c["value"] for key in ("models.pressure", "models.viscosity") for c in models if c["key"] == key)
    cost, error = number(auto["cost_low"]), number(auto["error"])
    if took in by_name and by_name[took]["error"] == auto["error"]:  # the same run: four timings of it
        cost = by_name[took]["cost_low"] = min(cost, number(by_name[took]["cost_low"]))
    as_exact = {c: number(r["cost_low"]) for c, r in by_name.items() if r["status"] == "done" and number(r["error"]) <= 1.1 * error}
    best = min(as_exact, key=as_exact.get, default=None)

    def cell(combination):
        if combination not in by_name:
            return ""
        r = by_name[combination]
        if r["status"] == "refused":
            return "refused (" + r["message"].strip().split(": ", 1)[-1].split(";")[0][:90] + ")"
        return f"{number(r['cost_low']):.2g} s, {100 * number(r['error']):.2g} %" if r["status"] == "done" else str(r["status"])

    return SimpleNamespace(took=took, cost=cost, error=error, best=best, best_cost=as_exact.get(best, math.nan), cell=cell)


@table("auto", "is auto a good choice: beside every combination of pressure and viscosity, the beginning of each scene", "25 minutes", page)
def auto(m):
    rows = []
    for scene, until, combinations in honey_cases + water_cases + vortex_cases:
        if m.wanted(scene):
            def measure():
                c = compare_models(m, scene, until, combinations)
                hand = [c.best, f"{c.best_cost:.2f} s", f"{100 * (c.cost / c.best_cost - 1):+.0f} %"] if c.best else ["none", "", ""]
                others = "; ".join(f"{name} {c.cell(name)}" for name in combinations if name != c.best)
                return [c.took, f"{c.cost:.2f} s", f"{100 * c.error:.2g} %", *hand, others]

            rows.append(attempt([scene, f"{until} s"], measure, 9))
    return markdown(["scene", "until", "auto takes", "time", "error", "best by hand that is as exact", "time", "auto is dearer by", "others"], rows)


@table("lava_viscosity", "lava with less and less viscosity: coupled beside ppe + full", "3 minutes", page)
def lava_viscosity(m):
    rows = []
    for viscosity in (100, 30, 10):
        found = {}
        for words, models in (("coupled", ["models.pressure=coupled"]), ("ppe + full", ["models.pressure=ppe", "models.viscosity=full"])):
            for r in m.study(f"lava_viscosity/{viscosity}-{words[:3]}", {
                    "scenes": ["lava"], "set": [*study_settings(0.8, 12), f"fluid.viscosity={viscosity}", *models],
                    "knob": [{"key": "quality", "values": ["draft", "standard"]}],
                    "accuracy": {"of": "reference", "reference": ["quality=standard"], "column": "kinetic_energy", "at": "all"}}):
                found[words, str(r["quality"])] = [f"{number(r['cost']):.2f} s", f"{100 * number(r['error']):.2g} %" if r["quality"] == "draft" else ""]
        for name in ("draft", "standard"):
            rows.append([f"{viscosity} Pa s", name, *(cell for words in ("coupled", "ppe + full") for cell in found.get((words, name), ["", ""]))])
    return markdown(["viscosity", "spacing", "coupled", "error", "ppe + full", "error"], rows)


# What the plan foresees

def plan_and_run(m, scene, until, name, *settings):
    """What whorl plan predicts, and the run."""
    options = ["--quality", "draft", "--until", until]
    return m.plan(f"scenes/{scene}.toml", *settings, options=options)["cost"], m.render(f"scenes/{scene}.toml", name, *settings, options=options)


@table("plan", "the plan's CPU time and memory beside what a run takes, the beginning of each scene", "8 minutes", page)
def plan(m):
    rows = []
    for scene, until in (("honey_coil", 1.5), ("honey_ball", 1.2), ("honey_thread", 0.7), ("sewing_machine", 1), ("cake_batter", 0.8), ("toothpaste", 1),
                         ("lava", 1), ("dripping_syrup", 0.8), ("dripping_syrup", 1.5), ("dam_break", 0.6), ("dam_break_obstacle", 0.6), ("paddle", 0.4),
                         ("floating_boxes", 0.5), ("rotating_drop", 0.3), ("karman_street", 0.2), ("shear_layer", 0.15), ("stirred_tank", 0.3),
                         ("taylor_green", 0.15), ("vortex_rings", 0.15)):
        if m.wanted(scene):
            def measure():
                cost, run = plan_and_run(m, scene, until, f"plan/{scene}-{until}")
                memory, taken = cost["memory_bytes"], max(panel["peak_memory_bytes"] for panel in run.panels)
                return [f"{cost['film_seconds']:.1f} s", f"{run.cpu_seconds:.1f} s", f"{100 * (cost['film_seconds'] / run.cpu_seconds - 1):+.0f} %",
                        f"{memory / 1e6:.0f} MB", f"{taken / 1e6:.0f} MB", f"{100 * (memory / taken - 1):+.0f} %"]

            rows.append(attempt([scene, f"{until} s"], measure, 8))
    return markdown(["scene", "until", "predicted", "taken", "off by", "memory predicted", "taken", "off by"], rows)


tension, full = ("surface tension", ["fluid.surface_tension=0.05"]), ("implicit viscosity (full)", ["models.viscosity=full"])
shifting, free = ("shifting", ["models.shifting=fickian"]), ("divergence-free velocities", ["pressure.divergence_free=true"])
bodies = ("free bodies", [f"solid[{k}].density={density}" for k, density in enumerate((450, 350, 250, 2500, 500, 150), 1)])


@table("model_cost", "what a model costs that a scene does not need, and what the plan says that it costs", "20 minutes", page)
def model_cost(m):
    rows = []
    for scene, until, (words, settings) in (
            ("honey_coil", 1.2, tension), ("honey_ball", 0.9, tension), ("honey_ball", 0.9, ("sleep", ["time.sleep=0.06"])), ("cake_batter", 0.7, tension),
            ("lava", 0.8, tension), ("toothpaste", 0.8, ("sleep", ["time.sleep=0.06"])), ("rotating_drop", 0.3, tension),
            ("dam_break", 0.4, ("surface tension", ["fluid.surface_tension=0.07"])), ("dam_break", 0.4, shifting), ("dam_break", 0.4, free),
            ("dam_break_obstacle", 0.3, ("multigrid", ["pressure.preconditioner=multigrid"])), ("paddle", 0.3, free),
            ("paddle", 0.3, ("sleep", ["time.sleep=1"])), ("floating_boxes", 0.3, bodies), ("floating_boxes", 0.3, free), ("karman_street", 0.1, full),
            ("shear_layer", 0.1, full), ("shear_layer", 0.1, ("implicit exchange of spin", ["micropolar.exchange=implicit"])), ("vortex_rings", 0.1, full),
            ("taylor_green", 0.1, full), ("stirred_tank", 0.2, full), ("stirred_tank", 0.2, shifting)):
        if not m.wanted(scene):
            continue
        off = [f"solid[{k}].density=0" for k in range(1, 7)] if words == "free bodies" else []

        def measure():
            file = words.replace(" ", "_")
            (p0, t0), (p1, t1) = ((cost["film_seconds"], run.cpu_seconds) for cost, run in (
                plan_and_run(m, scene, until, f"model_cost/{scene}-{'fixed' if off else 'without'}", *off),
                plan_and_run(m, scene, until, f"model_cost/{scene}-{file}", *off, *settings)))
            return [*(f"{seconds:.2f} s" for seconds in (p1, t1, p0, t0)), f"{p1 / p0:.2f}", f"{t1 / t0:.2f}", f"{100 * (p1 / p0 / (t1 / t0) - 1):+.0f} %"]

        rows.append(attempt([scene, f"{until} s", words], measure, 10))
    return markdown(["scene", "until", "switched on", "predicted", "taken", "predicted, without", "taken, without", "times as dear, predicted", "taken",
                     "off by"], rows)


@table("live_speed", "how much of real time a draft reaches with its pictures, lever by lever", "2 minutes, an idle machine", page)
def live_speed(m):
    levers = [("fine steps, a tight solve, two voxels a spacing", ["surface.voxel=0.5", "time.cfl=0.4", "pressure.tolerance=1e-3"]),
              ("one voxel a spacing (`surface.voxel = 1`)", ["surface.voxel=1"]), ("steps of up to 1.6 spacings (`time.cfl = 1.6`)", ["time.cfl=1.6"]),
              ("a looser solve (`pressure.tolerance = 3e-3`)", ["pressure.tolerance=3e-3"]),
              ("and `pressure.tolerance = 1e-2` (not the draft's)", ["pressure.tolerance=1e-2"])]
    settings, rows = [], []
    for k, (words, more) in enumerate(levers):
        settings += more  # the later the stronger
        run = m.render("honey_coil", f"live_speed/{k}", *settings, threads=2, images=True,
                       options=["--quality", "draft", "--size", "640x360", "--until", 2, "--no-video"])
        d, stages = run.table(), run.report["stages"]
        late = ~(d["time"] < 1 - 1e-9)
        wall, time, steps, iterations = (d[name][late] for name in ("wall_seconds", "time", "steps", "pressure_iterations"))
        frame = [f"{1e3 * stages[name]['wall_seconds'] / stages[name]['calls']:.0f}" for name in ("draw", "surface")]
        simulation = sum(stage["wall_seconds"] for name, stage in stages.items() if name not in ("draw", "surface", "write", "encode"))
        rows.append([words, f"{(time[-1] - time[0]) / (wall[-1] - wall[0]):.2f}", f"{1e3 * simulation / run.report['frames']:.0f}",
                     f"{iterations[1:].sum() / (steps[-1] - steps[0]):.0f}", f"{(steps[-1] - steps[0]) / (len(steps) - 1):.0f}", *frame])
    return markdown(["lever", "of real time, from 1 to 2 s", "simulate [ms a frame]", "iterations a step", "steps a frame", "draw", "surface"], rows)
