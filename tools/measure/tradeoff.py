"""Pareto fronts, stability maps, qualities, the choices of auto, the predictions of the plan."""
import json
import math
import re
from types import SimpleNamespace

from . import drawing
from .registry import markdown, off, percent, table
from .runs import Unknown, attempt, number, read_rows, read_scene, root


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
            text = (folder / f"{kind}.csv").read_text().replace(f"{root}/", "")  # messages contain absolute paths
            m.write(f"docs/studies/{name}.csv", text.encode())

    return make


fronts = {"hydrostatic_column": "Pareto front of still water, pressure compared with rho g h",
          "taylor_green": "Pareto front of vortices, decay compared with theory",
          "micropolar_decay": "Pareto front of micropolar vortices, decay compared with theory",
          "coil_frequency": "Pareto front of a coil, frequency compared with slender-thread theory",
          "dam_front": "Pareto front of a dam break, centre of mass compared with a finer run"}
maps = {"viscous_steps": "stability over time step and viscosity, every model", "sound_steps": "stability over time step and sound speed",
        "coupled_steps": "stability of the coupled solve", "scale": "stability over spacings from 1e-6 m to 1e3 m",
        "gravity": "stability over gravity from 0 to 1000 g", "impact": "stability over impact speeds from 0.1 to 100 m/s",
        "thread_across": "stability over the number of particles across a thread",
        "micropolar_exchange": "stability over micropolar coupling and micro-inertia",
        "density_ratio": "stability over a body's relative density and its impact speed",
        "precision": "single and double precision over the distance from the origin"}
for prefix, kind, shipped in (("front", "tradeoff", fronts), ("map", "stability", maps)):
    for name, words in shipped.items():
        files = f"docs/studies/{name}.svg and .csv"
        table(f"{prefix}_{name}", words, "1 to 5 minutes", files=files, section=False)(shipped_study(kind, name))


def study_settings(until, frames):
    return [f"time.end={until}", "time.slow_motion=1", f"time.fps={frames / until:.12g}"]


# Draft, standard and fine

def against(quality, column, part="diagnostics.csv"):
    return {"of": "reference", "reference": [f"quality={quality}"], "at": "all", "table": part, "column": column}


density = ("mean density error", {"of": "exact", "column": "density_error_mean", "at": "all", "expected": "0", "scale": 1})
potential = ("potential energy, relative to fine", against("fine", "potential_energy"))
kinetic = ("kinetic energy, relative to fine", against("fine", "kinetic_energy"))
second_panel = ("kinetic energy, relative to fine", against("fine", "kinetic_energy", "panels/2/diagnostics.csv"))
coil = ("frequency of the first turns, relative to steady theory",
        {"of": "exact", "table": "probes/coil.csv", "column": "frequency", "expected": "2.139"})
angular = ("angular momentum lost", {"of": "conserved", "column": "angular_momentum_z", "at": "all"})
qualities = {  # scene: seconds, quantity whose error is measured
    "thick_coil": (1.6, *coil), "honey_ball": (0.9, *potential), "honey_thread": (0.45, *potential), "sewing_machine": (0.7, *kinetic),
    "cake_batter": (0.8, *potential), "toothpaste": (2.0, *potential), "lava": (1.2, *potential), "dripping_syrup": (0.3, *potential),
    "rotating_drop": (0.4, *angular), "dam_break": (0.08, *density), "dam_break_obstacle": (0.12, *density), "paddle": (0.08, *density),
    "floating_boxes": (0.06, *density), "karman_street": (0.02, *second_panel), "shear_layer": (0.02, *second_panel),
    "vortex_rings": (0.015, *second_panel), "taylor_green": (0.04, *kinetic), "stirred_tank": (0.3, *second_panel)}


def measure_quality(m, scene):
    """Rows of docs/studies/quality.csv for a scene; writes its image of the three qualities. Eight frames suffice and cost little."""
    until, error_of, accuracy = qualities[scene]
    name, rows, images = f"quality/{scene}", [], []
    keys = {"scenes": [scene], "set": [*study_settings(until, 8), "output.size=[480, 270]"], "pictures": True, "limit": 3600,
            "knob": [{"key": "quality", "values": ["draft", "standard", "fine"]}]}
    figures, pictures = ({r["quality"]: r for r in m.study(name, {**keys, "accuracy": a})} or Unknown()
                         for a in (accuracy, {"of": "picture", "reference": ["quality=fine"]}))  # the second reuses the runs of the first
    for quality in ("draft", "standard", "fine"):
        run = m.point(name, f"quality={quality}-")
        cpu = (run.cpu_seconds - run.drawing_seconds) / run.report["time"]
        rows.append({"scene": scene, "until": until, "quality": quality, "spacing": run.scene["fluid"]["spacing"],
                     "particles": run.report["particles"], "cpu_seconds_a_second": f"{cpu:.4g}", "error": figures[quality]["error"],
                     "error_of": error_of, "picture_difference": pictures[quality]["error"]})
        images.append(max(run.folder.glob("frames/*.png"), default=run.folder))
    drawing.picture(m, f"docs/pictures/quality/{scene}.jpg", images, 320, ["-q:v", "3"])
    return rows


@table("quality", "draft, standard and fine of every scene: CPU time, error and image of the first part of its run", "3 hours",
       files="docs/studies/quality.csv, docs/pictures/quality", keeps_rows=True)
def quality(m):
    file, order = "docs/studies/quality.csv", list(qualities)
    columns = ["scene", "until", "quality", "spacing", "particles", "cpu_seconds_a_second", "error", "error_of", "picture_difference"]
    rows = read_rows(m.into / file) if (m.into / file).exists() else []
    for scene in filter(m.wanted, qualities):
        rows = [r for r in rows if r["scene"] != scene] + measure_quality(m, scene)
        rows.sort(key=lambda r: order.index(r["scene"]))
        m.write_csv(file, columns, rows)
    return quality_section(rows)


def short(value, digits):
    return f"{value:.0f}" if abs(value) >= 10**(digits - 1) else f"{value:.{digits}g}"


def quality_section(rows):
    figures, words = [], {}
    for r in rows:
        error, picture = (number(r[name]) for name in ("error", "picture_difference"))
        fine = r["quality"] == "fine"
        figures.append([f"`{r['scene']}`", r["until"], r["quality"], short(1000 * number(r["spacing"]), 3), r["particles"],
                        short(number(r["cpu_seconds_a_second"]), 3), "reference" if fine and error < 1e-8 else short(100 * error, 2),
                        "reference" if fine else short(picture, 2)])
        words[r["scene"]] = [f"`{r['scene']}`", r["error_of"], f"![](../pictures/quality/{r['scene']}.jpg)"]
    columns = "scene | until [s] | quality | spacing [mm] | particles | CPU s per simulated second | error [%] | image, dE"
    return markdown(columns, figures) + "\n\n" + markdown("scene | error of | draft, standard and fine", words.values())


# Choices of auto

honey = ["coupled+none", "ppe+full", "ppe+full_assembled", "ppe+explicit", "wcsph+full"]
water = ["ppe+none", "ppe+xsph", "wcsph+none", "wcsph+xsph"]
vortices = ["wcsph+explicit", "wcsph+full", "ppe+explicit", "ppe+full"]
cases = {
    "pours": (honey, {"thick_coil": 0.9, "honey_ball": 0.7, "honey_thread": 0.4, "sewing_machine": 0.6, "cake_batter": 0.6,
                      "toothpaste": 0.7, "lava": 0.8, "rotating_drop": 0.2, "dripping_syrup": 0.15}),
    "water": (water, {"dam_break": 0.25, "dam_break_obstacle": 0.1, "paddle": 0.2, "floating_boxes": 0.06}),
    "vortices": (vortices, {"taylor_green": 0.02, "karman_street": 0.02, "shear_layer": 0.02, "stirred_tank": 0.03, "vortex_rings": 0.015})}


def scene_with_models(m, scene, combination):
    """A copy of a scene with these models, without the keys of other models and without panels."""
    keys, (pressure, viscosity) = read_scene(f"scenes/{scene}.toml"), combination.split("+")
    micropolar = "micropolar" in keys.get("models", {})
    keys["models"] = {**keys.get("models", {}), "pressure": pressure, "viscosity": viscosity}
    if viscosity != "xsph":
        keys.pop("viscosity", None)
    if pressure not in ("auto", "wcsph") or not micropolar:
        keys.pop("pressure", None)
    if keys.pop("panel", None):
        keys.pop("output", None)
    if pressure == "wcsph":  # it solves no system
        for changes in keys.get("quality", {}).values():
            changes.pop("pressure.tolerance", None)
    return m.toml_file(f"auto/{scene}/{combination}", keys)


def compare_models(m, scene, until, combinations):
    """Compares auto with other models, at draft quality on one thread: the models that auto chooses, and cells of CPU seconds (the
    smaller of two timings) and error by combination. The error is that of the kinetic energy over all frames, relative to
    auto at standard spacing. A run is stopped after more than four times the wall time of auto, because it cannot be cheaper."""
    name, limit, by_name = f"auto/{scene}", 120.0, {}
    files = [scene_with_models(m, scene, combination) for combination in ("auto+auto", *combinations)]
    for some in (files[:2], files):
        rows = m.study(name, {
            "scenes": [files[0]], "quality": "draft", "limit": limit, "set": study_settings(until, 12),
            "knob": [{"key": "scene", "values": some}], "cost": {"repeat": 2}, "accuracy": against("standard", "kinetic_energy")})
        # The rows have two columns "scene". DictReader returns the second, which is the knob.
        by_name = {combination: next((r for r in rows if f"/{combination}.toml" in r["scene"]), Unknown())
                   for combination in ("auto+auto", *combinations)}
        limit = 2 + 4 * number(by_name["auto+auto"]["wall_seconds"])
    models = {c["key"]: c["value"] for c in m.point(name, "auto+auto_scene=").report["models"]}
    auto, took = by_name.pop("auto+auto"), "+".join(models.get(f"models.{key}", "?") for key in ("pressure", "viscosity"))
    if took in by_name and by_name[took]["error"] == auto["error"]:  # both are the same run: use the smallest of its four timings
        auto["cost_low"] = by_name[took]["cost_low"] = min(auto["cost_low"], by_name[took]["cost_low"], key=number)

    def cells(r):
        if r["status"] == "refused":
            return ["refused", ""]
        return [f"{number(r['cost_low']):.2g}", f"{100 * number(r['error']):.2g} %"] if r["status"] == "done" else ["-", "-"]

    return SimpleNamespace(took=took, auto=cells(auto), cells={combination: cells(r) for combination, r in by_name.items()})


def words_of(combination):
    return combination.replace("+none", "").replace("+", " + ")


@table("auto", "auto compared with every combination of pressure and viscosity, for the beginning of each scene", "25 minutes")
def auto(m):
    sections = []
    for kind, (combinations, scenes) in cases.items():
        rows = []
        for scene in filter(m.wanted, scenes):
            def measure():
                c = compare_models(m, scene, scenes[scene], combinations)
                return [words_of(c.took), *c.auto, *(cell for cells in c.cells.values() for cell in cells)]

            rows.append([scene, f"{scenes[scene]}", *attempt(measure)])
        columns = [f"{kind} | until [s] | auto chooses | s | error", *(f"{words_of(combination)} s | error" for combination in combinations)]
        sections += [markdown(" | ".join(columns), rows)] if rows else []
    return "\n\n".join(sections)


lava_time = 0.8  # s


def planned_viscous_number(m, *settings):
    """nu dt/d^2 of lava, from the plan's reason for its pressure model."""
    reasons = json.dumps(m.plan("lava", "models.pressure=auto", *settings, options=["--until", lava_time]), default=str)
    found = re.search(r"viscous number nu dt/d\^2 = ([0-9.e-]+)", reasons)
    return found[1] if found else ""


@table("lava_viscosity", "lava with decreasing viscosity: coupled compared with ppe + full", "3 minutes")
def lava_viscosity(m):
    rows, coarse, fine = [], 6.25e-3, 4e-3
    for viscosity in (100, 30, 10):
        found = {coarse: [], fine: []}
        for pressure, models in (("coupled", []), ("ppe", ["models.viscosity=full"])):
            for r in m.study(f"lava_viscosity/{viscosity}-{pressure}", {
                    "scenes": ["lava"], "set": [*study_settings(lava_time, 12), f"fluid.viscosity={viscosity}", f"models.pressure={pressure}",
                                                *models],
                    "knob": [{"key": "fluid.spacing", "values": list(found)}],
                    "accuracy": {**against("", "kinetic_energy"), "reference": [f"fluid.spacing={fine}"]}}):
                d = number(r["fluid.spacing"])
                if pressure == "coupled":
                    found[d].append(planned_viscous_number(m, f"fluid.viscosity={viscosity}", f"fluid.spacing={d}"))
                found[d] += [f"{number(r['cost']):.2f}", f"{100 * number(r['error']):.2g} %" if d == coarse else ""]
        rows += [[f"{viscosity} Pa s", f"{1e3 * d:g} mm", *cells] for d, cells in found.items()]
    return markdown("viscosity | spacing | viscous number | coupled [s] | error | ppe + full [s] | error", rows)


# Predictions of the plan

def plan_and_run(m, scene, until, name, *settings):
    """Prediction of whorl plan for the beginning of a scene, and the run itself."""
    options, file = ["--quality", "draft", "--until", until], f"scenes/{scene}.toml"
    return m.plan(file, *settings, options=options)["cost"], m.render(file, name, *settings, options=options)


plan_cases = ("thick_coil:1.5 honey_ball:1.2 honey_thread:0.7 sewing_machine:1 cake_batter:0.8 toothpaste:1 lava:1 dripping_syrup:0.8 "
              "spin_up:1 dam_break:0.4 dam_break_obstacle:0.4 paddle:0.4 floating_boxes:0.3 rotating_drop:0.3 karman_street:0.1 "
              "shear_layer:0.1 stirred_tank:0.3 taylor_green:0.1 towed_post:0.3 turbulence:0.4 vortex_rings:0.5")


@table("plan", "the plan's CPU time and memory compared with those of a run, the beginning of each scene", "10 minutes")
def plan(m):
    rows, stages = [], ("surface", "draw")
    for scene, until in (case.split(":") for case in plan_cases.split()):
        def measure():
            options, file, name = ["--quality", "draft", "--until", until], f"scenes/{scene}.toml", f"plan/{scene}-{until}"
            cost = m.plan(file, options=options, images=True)["cost"]
            run = m.render(file, name, options=[*options, "--no-video"], images=True)
            pictures = sum(cost["film_cpu_seconds"][stage] for stage in stages), run.stage_seconds(*stages)
            simulate = cost["film_cpu_seconds"]["simulate"], run.simulation_seconds
            memory = cost["memory_bytes"], max(panel["peak_memory_bytes"] for panel in run.panels)
            return [text for predicted, taken in (simulate, pictures)
                    for text in (f"{predicted:.1f} s", f"{taken:.1f} s", off(predicted, taken))] + [
                        *(f"{bytes / 1e6:.0f} MB" for bytes in memory), off(*memory)]

        if m.wanted(scene):
            rows.append([scene, f"{until} s", *attempt(measure)])
    return markdown("scene | until | simulation, predicted | measured | off by | images, predicted | measured | off by | memory, "
                    "predicted | measured | off by", rows)


tension, full = ("surface tension", ["fluid.surface_tension=0.05"]), ("implicit viscosity (full)", ["models.viscosity=full"])
shifting = ("shifting", ["models.shifting=fickian"])
multigrid, exchange = ("multigrid", ["pressure.preconditioner=multigrid"]), ("implicit exchange of spin", ["micropolar.exchange=implicit"])
bodies = ("free bodies", [f"solid[{k}].density={density}" for k, density in enumerate((450, 350, 250, 2500, 500, 150), 1)])
water_tension = ("surface tension", ["fluid.surface_tension=0.07"])
model_cases = (("thick_coil", 1.2, tension), ("honey_ball", 0.9, tension), ("cake_batter", 0.7, tension),
               ("lava", 0.8, tension), ("rotating_drop", 0.3, tension), ("dam_break", 0.4, water_tension),
               ("dam_break", 0.4, shifting), ("dam_break_obstacle", 0.3, multigrid),
               ("floating_boxes", 0.3, bodies),
               ("karman_street", 0.1, full), ("shear_layer", 0.1, full), ("shear_layer", 0.1, exchange), ("vortex_rings", 0.1, full),
               ("taylor_green", 0.1, full), ("stirred_tank", 0.2, full), ("stirred_tank", 0.2, shifting))


@table("model_cost", "measured and predicted cost of adding a model to a scene", "20 minutes")
def model_cost(m):
    rows = []
    for scene, until, model in model_cases:
        words, settings = model
        fixed = [f"solid[{k}].density=0" for k in range(1, 7)] if model is bodies else []

        def measure():
            name = f"model_cost/{scene}-"
            (p0, t0), (p1, t1) = ((cost["film_seconds"], run.cpu_seconds) for cost, run in (
                plan_and_run(m, scene, until, name + ("fixed" if fixed else "without"), *fixed),
                plan_and_run(m, scene, until, name + words.replace(" ", "_"), *fixed, *settings)))
            return [*(f"{seconds:.2f} s" for seconds in (p1, t1, p0, t0)), f"{p1 / p0:.2f}", f"{t1 / t0:.2f}", off(p1 / p0, t1 / t0)]

        if m.wanted(scene):
            rows.append([scene, f"{until} s", words, *attempt(measure)])
    return markdown("scene | until | switched on | predicted | measured | predicted, without | measured, without | factor, predicted | "
                    "factor, measured | off by", rows)


@table("live_speed", "simulated time per real time of a draft run with images, by setting", "2 minutes, an idle machine")
def live_speed(m):
    settings, rows = [], []
    for k, (words, more) in enumerate((
            ("none", ["surface.voxel=0.5", "time.cfl=0.4", "pressure.tolerance=1e-3"]),
            ("surface of one voxel per spacing (`surface.voxel = 1`)", ["surface.voxel=1"]),
            ("steps of up to 1.6 spacings (`time.cfl = 1.6`)", ["time.cfl=1.6"]),
            ("a looser solve (`pressure.tolerance = 3e-3`)", ["pressure.tolerance=3e-3"]),
            ("`pressure.tolerance = 1e-2` (not the draft's)", ["pressure.tolerance=1e-2"]))):
        settings += more  # later settings override earlier ones
        run = m.render("thick_coil", f"live_speed/{k}", *settings, threads=2, images=True,
                       options=["--quality", "draft", "--size", "640x360", "--until", 2, "--no-video"])
        d, stages = run.table(), run.report["stages"]
        late = ~(d["time"] < 1 - 1e-9)
        wall, time, steps, iterations = (d[name][late] for name in ("wall_seconds", "time", "steps", "pressure_iterations"))
        simulate = sum(stage["wall_seconds"] for name, stage in stages.items() if name not in ("draw", "surface", "write", "encode"))
        pictures = [1e3 * stages[name]["wall_seconds"] / stages[name]["calls"] for name in ("draw", "surface")]
        rows.append([words, f"{(time[-1] - time[0]) / (wall[-1] - wall[0]):.2f}", f"{1e3 * simulate / run.report['frames']:.0f}",
                     f"{iterations[1:].sum() / (steps[-1] - steps[0]):.0f}", f"{(steps[-1] - steps[0]) / (len(steps) - 1):.0f}",
                     *(f"{ms:.0f}" for ms in pictures)])
    return markdown("change | fraction of real time | simulate ms | iterations per step | steps per image | draw ms | surface ms", rows)
