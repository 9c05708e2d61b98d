"""Comparison of the viscous models and their solvers."""
import math

from . import theory
from .registry import markdown, off, percent, table
from .runs import number, read_scene


def properties(m):
    """Measured values: {(model, support): {quantity: value}}."""
    models = {}
    for r in m.solver("viscous_models"):
        models.setdefault((r["model"], f"{number(r['support']):g}"), {})[r["quantity"]] = number(r["value"])
    return models


def cells(quantities, form, names):
    return [f"{quantities[name]:{form}}" if name in quantities else "" for name in names]


@table("viscous_conservation", "errors in momentum, angular momentum and a rigid rotation by viscous model", "1 minute")
def viscous_conservation(m):
    rows = [[*model, *cells(q, ".1e", ("momentum", "angular_momentum")), percent(q["braking"], 1)] for model, q in properties(m).items()]
    return markdown("model | R/d | momentum | angular momentum | braking", rows)


@table("viscous_ropes", "dissipation of a rope, 3 to 8 particles across, over the exact one", "no time after viscous_conservation")
def viscous_ropes(m):
    names = [f"{strain}_{across}" for strain in ("stretching", "bending", "torsion") for across in (3, 4, 5, 6, 8)]
    rows = [[*model, *cells(q, ".2f", names)] for model, q in properties(m).items()]
    return markdown("model | R/d | " + " | ".join(name.replace("_", " ") for name in names), rows)


@table("viscous_waves", "decay of waves over theory, largest step, iterations and time", "no time after viscous_conservation")
def viscous_waves(m):
    rows, lengths = [], [f"decay_{n}" for n in (8, 16, 32, 64)]
    for model, q in properties(m).items():
        order = math.log2((q["decay_16"] - q["decay_32"]) / (q["decay_32"] - q["decay_64"]))
        step = cells(q, ".2f", ["largest_step"])[0] or "any"
        iterations, nanoseconds = cells(q, ".0f", ("iterations_1", "iterations_100", "iterations_10000")), cells(q, ".0f", (
            "nanoseconds_100" if "nanoseconds_100" in q else "nanoseconds_0.1",))
        rows.append([*model, *cells(q, ".3f", lengths), f"{order:.1f}", step, *iterations, *nanoseconds])
    return markdown("model | R/d | 8 | 16 | 32 | 64 | order | largest nu dt/d^2 | iterations at K = 1 | at K = 100 | at K = 10^4 | "
                    "ns per particle", rows)


def preconditioners(m, solve, cases):
    """Table of preconditioners for a thread on its pile. @param cases tuples (scale, unevenness) of whorl_solver_tables"""
    names, rows = ("none", "block_jacobi", "two_level"), {}
    for scale, uneven in cases:
        for r in m.solver("viscous_preconditioners", "--solve", solve, "--scale", scale, "--uneven", uneven):
            row = rows.setdefault((r["particles"] + ", uneven" * (uneven > 0.1), r["K"]), [])  # in the order of names
            row += [f"{number(r['cold']):.0f}", f"{number(r['warm']):.1f}", f"{number(r['error']):.0e}", f"{number(r['milliseconds']):.1f}"]
    return markdown("particles | K | " + " | ".join(f"{name} {what}" for name in names for what in ("first", "later", "error", "CPU ms")),
                    [[*case, *row] for case, row in rows.items()])


for solve, minutes, hours in (("full", "5 minutes", "half an hour, 4 GB"), ("coupled", "15 minutes", "hours, 4 GB")):
    table(f"{solve}_preconditioners", f"iterations, error and time of {solve} by preconditioner", minutes)(
        lambda m, solve=solve: preconditioners(m, solve, [(1, 0.05), (1, 0.3), (2.35, 0.05)]))
    table(f"{solve}_preconditioners_large", f"iterations, error and time of {solve} by preconditioner, half a million particles", hours)(
        lambda m, solve=solve: preconditioners(m, solve, [(5.05, 0.05)]))


def coil_found(run):
    p = run.last("probes/coil.csv")
    return [["frequency", f"{p['frequency']:.2f} Hz", off(p["frequency"], 2.14)],
            ["radius", f"{1e3 * p['radius']:.1f} mm", off(p["radius"], 0.0177)]]


def thread_found(run):
    """Radius and least mass of the thread between 0.13 and 0.15 m below the nozzle, in the second half of the run."""
    probe = run.table("probes/thread.csv")
    mass = probe["mass"][~(probe["time"] <= 0.8)]
    z, u = theory.falling_thread_speed(0.05, 0.1, 0.25)
    radius, expected = math.sqrt(mass.mean() / (1000 * math.pi * 0.02)), 5e-3 * math.sqrt(0.1 / u[abs(z - 0.14).argmin()])
    return [["radius", f"{1e3 * radius:.2f} mm", off(radius, expected, 1)], ["least mass", percent(mass.min() / mass.mean())]]


def dam_found(run):
    d = run.table()
    energy = d["kinetic_energy"] + d["potential_energy"]
    return [["energy left", percent(energy[-1] / energy[0])]]


@table("coupled_or_ppe", "coupled compared with ppe + full: a coil, a falling thread, a dam break", "5 minutes")
def coupled_or_ppe(m):
    keys, rows = read_scene("scenes/studies/dam_slab.toml"), []
    del keys["viscosity"]  # keys of xsph, which is not used here
    dam_slab = m.toml_file("coupled_or_ppe/dam_slab", keys)
    for name, scene, found, settings in (
            ("steady_coil", "scenes/studies/steady_coil.toml", coil_found, ["fluid.spacing=2.5e-3"]),
            ("falling_thread", "scenes/studies/falling_thread.toml", thread_found, ["fluid.spacing=2.5e-3"]),
            ("dam_slab", dam_slab, dam_found, ["fluid.viscosity=1e-3", "solid[0].slip=free", "time.end=0.7"])):
        thin = scene == dam_slab  # coupled rejects it
        for pressure, viscosity in (("ppe", "full"),) if thin else (("coupled", "auto"), ("ppe", "full")):
            if m.wanted(name):
                run = m.render(scene, f"coupled_or_ppe/{name}-{pressure}", f"models.pressure={pressure}", f"models.viscosity={viscosity}",
                               *settings)
                first, *more = found(run)
                rows.append([name, "ppe + full" if pressure == "ppe" else pressure, f"{run.report['steps']:.0f}",
                             f"{run.iterations_per_step:.1f}", f"{run.microseconds:.1f}", *first])
                rows += [[""] * 5 + line for line in more]
    return markdown("scene | models | steps | iterations per step | CPU us per particle-step | quantity | measured | off theory by", rows)
