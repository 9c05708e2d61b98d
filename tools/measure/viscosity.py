"""docs/reports/viscosity.md: the viscous models and their solvers beside each other."""
import math

from . import theory
from .registry import markdown, table
from .runs import attempt, number
from .tradeoff import compare_models, honey_cases, vortex_cases

page = "docs/reports/viscosity.md"
across = (3, 4, 5, 6, 8)


def properties(m):
    """What each model measured, by (model, support): a dict by quantity."""
    models = {}
    for row in m.solver("viscous_models", "viscous_models"):
        models.setdefault((str(row["model"]), f"{number(row['support']):g}"), {})[row["quantity"]] = number(row["value"])
    return models


def cell(quantities, name, digits):
    return f"{quantities[name]:{digits}}" if name in quantities else ""


@table("viscous_conservation", "what each viscous model keeps of momentum, angular momentum and a rotation", "1 minute", page)
def viscous_conservation(m):
    rows = [[*model, cell(q, "momentum", ".1e"), cell(q, "angular_momentum", ".1e"), cell(q, "braking", ".1%").replace("%", " %")]
            for model, q in properties(m).items()]
    return markdown(["model", "R/d", "momentum", "angular momentum", "braking"], rows)


@table("viscous_ropes", "dissipation of a rope, 3 to 8 particles across, over the exact one", "nothing beside viscous_conservation", page)
def viscous_ropes(m):
    names = [f"{strain}_{n}" for strain in ("stretching", "bending", "torsion") for n in across]
    rows = [[*model, *(cell(q, name, ".2f") for name in names)] for model, q in properties(m).items()]
    return markdown(["model", "R/d", *(name.replace("_", " ") if name.endswith("_3") else name.split("_")[1] for name in names)], rows)


@table("viscous_waves", "decay of waves over theory, largest step, iterations and time", "nothing beside viscous_conservation", page)
def viscous_waves(m):
    rows = []
    for model, q in properties(m).items():
        decay = [q.get(f"decay_{n}", math.nan) for n in (8, 16, 32, 64)]
        order = math.log2((decay[1] - decay[2]) / (decay[2] - decay[3])) if decay[0] == decay[0] else math.nan
        rows.append([*model, *(f"{rate:.3f}" for rate in decay), f"{order:.1f}", cell(q, "largest_step", ".2f") or "any",
                     *(cell(q, f"iterations_{K}", ".0f") for K in ("1", "100", "10000")), cell(q, "nanoseconds_100", ".0f") or cell(q, "nanoseconds_0.1", ".0f")])
    return markdown(["model", "R/d", "8", "16", "32", "64", "order", "largest nu dt/d^2", "iterations at 1", "at 100", "at 10^4", "ns a particle"], rows)


def preconditioners(m, solve, cases):
    """@param cases scale and unevenness of a thread on its pile"""
    names, cells = ("none", "block_jacobi", "two_level"), {}
    for scale, uneven in cases:
        for row in m.solver(f"viscous_preconditioners/{solve}-{scale}-{uneven}", "viscous_preconditioners", "--solve", solve, "--scale", scale,
                            "--uneven", uneven):
            particles = f"{number(row['particles']):.0f}" + (", uneven" if uneven > 0.1 else "")
            cells.setdefault((particles, f"{number(row['K']):g}"), {})[row["preconditioner"]] = [
                f"{number(row['cold']):.0f} / {number(row['warm']):.1f}", f"{number(row['error']):.0e}", f"{number(row['milliseconds']):.1f}"]
    rows = [[*case, *(text for name in names for text in by_name.get(name, [""] * 3))] for case, by_name in cells.items()]
    return markdown(["particles", "K", *(column for name in names for column in (name, "error", "CPU ms"))], rows)


small, large = [(1, 0.05), (1, 0.3), (2.35, 0.05)], [(5.05, 0.05)]


@table("full_preconditioners", "iterations, error and time of full by preconditioner", "5 minutes", page)
def full_preconditioners(m):
    return preconditioners(m, "full", small)


@table("full_preconditioners_large", "the same, half a million particles", "half an hour, 4 GB", page)
def full_preconditioners_large(m):
    return preconditioners(m, "full", large)


@table("coupled_preconditioners", "iterations, error and time of coupled by preconditioner", "15 minutes", page)
def coupled_preconditioners(m):
    return preconditioners(m, "coupled", small)


@table("coupled_preconditioners_large", "the same, half a million particles", "hours, 4 GB", page)
def coupled_preconditioners_large(m):
    return preconditioners(m, "coupled", large)


@table("coupled_or_ppe", "coupled beside ppe + full: a coil, a falling thread, a dam break", "5 minutes", page)
def coupled_or_ppe(m):
    def coil(run):
        p = run.last("probes/coil.csv")
        if not p["frequency"] > 0:
            return "no coil"
        return f"{p['frequency']:.2f} Hz ({100 * (p['frequency'] / 2.14 - 1):+.0f} %), {1e3 * p['radius']:.1f} mm ({100 * (p['radius'] / 0.0177 - 1):+.0f} %)"

    def thread(run):
        """Between 0.13 and 0.15 m below the nozzle, in the second half of the run."""
        probe = run.table("probes/thread.csv")
        mass = probe["mass"][~(probe["time"] <= 0.8)]
        z, u = theory.falling_thread_speed(0.05, 0.1, 0.25)
        radius, expected = math.sqrt(mass.mean() / (1000 * math.pi * 0.02)), 5e-3 * math.sqrt(0.1 / u[abs(z - 0.14).argmin()])
        return f"radius {1e3 * radius:.2f} mm ({100 * (radius / expected - 1):+.1f} %), least mass {100 * mass.min() / mass.mean():.0f} % of the mean"

    def dam(run):
        d = run.table()
        energy = d["kinetic_energy"] + d["potential_energy"]
        return f"{100 * energy[-1] / energy[0]:.0f} % of the energy left"

    dam_slab = m.scene_without("scenes/studies/dam_slab.toml", "coupled_or_ppe/dam_slab", "viscosity")
    cases = [("steady_coil", "scenes/studies/steady_coil.toml", coil, ["fluid.spacing=2.5e-3"]),
             ("falling_thread", "scenes/studies/falling_thread.toml", thread, ["fluid.spacing=2.5e-3"]),
             ("dam_slab", dam_slab, dam, ["fluid.viscosity=1e-3", "solid[0].slip=free", "time.end=0.7"])]
    rows = []
    for name, scene, found, settings in cases:
        for words, models in (("coupled", ("coupled", "auto")), ("ppe + full", ("ppe", "full"))):
            if not m.wanted(name):
                continue

            def measure():
                run = m.render(scene, f"coupled_or_ppe/{name}-{models[0]}", f"models.pressure={models[0]}", f"models.viscosity={models[1]}", *settings)
                return [f"{run.report['steps']:.0f}", f"{run.iterations_per_step:.1f}", f"{run.microseconds:.1f}", found(run)]

            rows.append(attempt([name, words], measure, 6))
    return markdown(["scene", "models", "steps", "iterations a step", "CPU us a particle-step", "found"], rows)


@table("pairwise_or_full", "every implicit and explicit viscosity beside auto: CPU seconds and error, from the runs of auto", "nothing beside auto", page)
def pairwise_or_full(m):
    columns = ["auto", "coupled+none", "ppe+full", "ppe+pairwise", "wcsph+explicit", "wcsph+full", "wcsph+pairwise"]
    rows = []
    for scene, until, combinations in honey_cases + vortex_cases:
        if m.wanted(scene):
            compared = compare_models(m, scene, until, combinations)
            cells = [compared.cell(name) for name in columns[1:]]
            rows.append([scene, compared.took, *cells, compared.best or "none"])
    return markdown(["scene", "auto takes", *(f"{name}: CPU s, error" for name in columns[1:]), "cheapest that is as exact"], rows)
