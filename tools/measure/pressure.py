"""The pressure solves, their preconditioners, dam breaks and pools."""

from . import theory
from .registry import markdown, percent, table
from .runs import attempt, number

forms = ("constraint", "published")


def milliseconds(seconds):
    return f"{1e3 * number(seconds):.3g}"


def preconditioners(m, cases):
    """Table of preconditioners. @param cases tuples (layers across the depth, steps before the measured one)"""
    names, rows = ("none", "diagonal", "multigrid"), []
    for form, (layers, steps) in ((form, case) for form in forms for case in cases):
        systems = {}
        for r in m.solver("pressure_preconditioners", "--form", form, "--layers", layers, "--steps", steps):
            systems.setdefault((r["particles"], r["factor"], r["residual"]), {})[r["preconditioner"]] = r
        for (particles, factor, residual), found in systems.items():
            cells, last = [], found["multigrid"]
            for r in (found[name] for name in names):
                cells += [r["iterations"] + "+" * (r["converged"] != "1"), milliseconds(r["seconds"]), f"{100 * number(r['error']):.2g}"]
            rows.append([form, particles, factor, f"{number(residual):.1e}", *cells, milliseconds(last["set_up_seconds"]), last["levels"],
                         f"{number(last['bytes']):.0f}", f"{number(found['diagonal']['seconds']) / number(last['seconds']):.1f}"])
    return markdown("form | particles | step over CFL 0.4 | residual | " + " | ".join(f"{name} | ms | error %" for name in names) +
                    " | set-up ms | levels | bytes per particle | times faster", rows)


@table("pressure_preconditioners", "pressure solves by preconditioner: iterations, time, error; 1e3 to 1e5 particles", "3 minutes")
def pressure_preconditioners(m):
    return preconditioners(m, [(7, 10), (14, 16), (29, 20)])


@table("pressure_preconditioners_large", "pressure solves by preconditioner, a million particles", "15 minutes, 3 GB")
def pressure_preconditioners_large(m):
    return preconditioners(m, [(63, 4)])


@table("pressure_hierarchies", "pressure solves by multigrid with other first levels, interpolations and cycles", "2 minutes")
def pressure_hierarchies(m):
    rows = {}
    for form in forms:
        for r in m.solver("pressure_hierarchies", "--form", form):  # additive, then V-cycle
            row = rows.setdefault((form, r["cell"] + " d", r["interpolation"]), [])
            row += [r["iterations"], milliseconds(r["set_up_seconds"]), milliseconds(r["seconds"])]
    return markdown("form | cells | coarse interpolation | additive: iterations | set-up ms | ms | V-cycle: iterations | set-up ms | ms",
                    [[*case, *row] for case, row in rows.items()])


def dam_break(m, spacing, until, threads, *settings, words=""):
    name = "-".join([f"{spacing:g}", f"{until:g}", f"{threads}", *settings]) + words
    return m.render("scenes/dam_break.toml", f"dam_break/{name}", f"fluid.spacing={spacing:g}", *settings, options=["--until", until],
                    threads=threads)


@table("dam_break_whole", "scenes/dam_break.toml, 4 s, 49,000 and 197,000 particles on two threads", "9 hours")
def dam_break_whole(m):
    rows = []
    for spacing in (5.47e-3, 3.43e-3):
        def measure():
            run = dam_break(m, spacing, 4, 2)
            d, r = run.table(), run.report
            mean, largest = d["density_error_mean"], d["density_error_max"]
            return [f"{r['particles']:.0f}", f"{r['steps']:.0f}", f"{run.iterations_per_step:.1f}", f"{run.microseconds:.1f}",
                    f"{r['cpu_seconds'] / r['time']:.0f}", percent(mean.mean(), 3), percent(mean.max(), 2), percent(largest.max(), 2),
                    f"{r['lost_particles']:.0f}"]

        if m.wanted(f"{spacing:g}"):
            rows.append(attempt(measure))
    return markdown("particles | steps | iterations per step | CPU us per particle-step | CPU s per simulated s | mean density error | "
                    "largest mean of a frame | largest of any particle | lost", rows)


@table("dam_break_threads", "the first 0.1 s of dam_break on one and on two threads, three pairs of runs", "10 minutes, an idle machine")
def dam_break_threads(m):
    rows = []
    for spacing in (5.47e-3, 8e-3):
        runs = [[dam_break(m, spacing, 0.1, threads, words=f"-{k}").report for threads in (1, 2)] for k in range(3)]
        gains = [one["wall_seconds"] / two["wall_seconds"] for one, two in runs]
        rows.append([f"{runs[0][0]['particles']:.0f}", f"{min(gains):.2f}", f"{max(gains):.2f}"])
    return markdown("particles | speed-up by two threads, smallest | largest", rows)


@table("dam_break_density", "density errors of dam breaks 10 and 16 particles wide", "2 minutes")
def dam_break_density(m):
    rows = []
    for spacing, until in ((1.6e-2, 2.5), (1e-2, 2)):
        run = dam_break(m, spacing, until, 1)
        d = run.table()
        rows.append([f"{1e3 * spacing:g} mm", f"{run.report['particles']:.0f}", percent(d["density_error_mean"].mean(), 3),
                     percent(d["density_error_max"].max(), 2), f"{run.iterations_per_step:.1f}", f"{run.microseconds:.1f}"])
    return markdown("spacing | particles | mean | largest | iterations per step | CPU us per particle-step", rows)


@table("dam_break_stages", "share of each stage in the time of a step, first 0.15 s of dam_break", "1 minute")
def dam_break_stages(m):
    run = dam_break(m, 8e-3, 0.15, 1)
    stages = {name: stage["cpu_seconds"] for name, stage in run.report["stages"].items() if name != "write"}
    rows = [[name, percent(seconds / sum(stages.values())), f"{1e6 * seconds / run.report['particle_steps']:.2f}"]
            for name, seconds in sorted(stages.items(), key=lambda stage: -stage[1])]
    return markdown("stage | share of the time | CPU us per particle-step", rows)


@table("standing_water", "pressure in a resting column against rho g h, by the length of the step", "1 minute")
def standing_water(m):
    rows = []
    for cfl in (0.8, 0.4, 0.2, 0.1):
        run = m.render("scenes/studies/standing_water.toml", f"standing_water/{cfl}", f"time.cfl={cfl}")
        low = run.table("probes/low.csv")
        expected = 1000 * theory.gravity * 0.16  # the probe is 0.16 m below the surface of 0.2 m of water
        deviation = abs(low["pressure"][~(low["time"] < 0.5)] / expected - 1).mean()
        rows.append([f"{cfl}", percent(deviation, 1), f"{run.iterations_per_step:.1f}", f"{run.report['cpu_seconds']:.2f}"])
    return markdown("CFL | mean deviation | iterations per step | CPU s", rows)
