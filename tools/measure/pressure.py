"""The pressure solves, their preconditioners, dam breaks and pools."""
import math

from . import theory
from .registry import markdown, percent, table
from .runs import attempt, number

forms = ("constraint", "poisson")


def milliseconds(seconds):
    return f"{1e3 * number(seconds):.3g}"


def preconditioners(m, cases):
    """@param cases layers across the depth and steps before the one that is measured"""
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
                    " | of it set-up | levels | bytes a particle | times faster", rows)


@table("pressure_preconditioners", "none, the diagonal and multigrid: iterations, time, error; 1e3 to 1e5 particles", "3 minutes")
def pressure_preconditioners(m):
    return preconditioners(m, [(7, 10), (14, 16), (29, 20)])


@table("pressure_preconditioners_large", "the same, a million particles", "15 minutes, 3 GB")
def pressure_preconditioners_large(m):
    return preconditioners(m, [(63, 4)])


@table("pressure_hierarchies", "multigrid with other first levels, interpolations and cycles", "2 minutes")
def pressure_hierarchies(m):
    rows = {}
    for form in forms:
        for r in m.solver("pressure_hierarchies", "--form", form):  # additive, then V-cycle
            row = rows.setdefault((form, r["cell"] + " d", r["interpolation"]), [])
            row += [r["iterations"], milliseconds(r["set_up_seconds"]), milliseconds(r["seconds"])]
    return markdown("form | cells | coarse interpolation | additive: iterations | set-up ms | ms | V-cycle: iterations | set-up ms | ms",
                    [[*case, *row] for case, row in rows.items()])


@table("pressure_threads", "wall time of a solve with one and with two threads", "1 minute, an idle machine")
def pressure_threads(m):
    rows = []
    for form in forms:
        found = m.solver("pressure_threads", "--form", form)
        seconds = [number(r["set_up_seconds"]) + number(r["solve_seconds"]) for r in found]
        rows += [[form, r["threads"], milliseconds(r["set_up_seconds"]), milliseconds(r["solve_seconds"]), f"{seconds[0] / total:.2f}"]
                 for r, total in zip(found, seconds)]
    return markdown("form | threads | set-up ms | solve ms | faster", rows)


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
    return markdown("particles | steps | iterations a step | CPU us a particle-step | CPU s a simulated s | mean density error | "
                    "largest mean of a frame | largest of any particle | lost", rows)


@table("dam_break_threads", "three pairs of its first 0.1 s on one and on two threads", "10 minutes, an idle machine")
def dam_break_threads(m):
    rows = []
    for spacing in (5.47e-3, 8e-3):
        runs = [[dam_break(m, spacing, 0.1, threads, words=f"-{k}").report for threads in (1, 2)] for k in range(3)]
        gains = [one["wall_seconds"] / two["wall_seconds"] for one, two in runs]
        rows.append([f"{runs[0][0]['particles']:.0f}", f"{min(gains):.2f}", f"{max(gains):.2f}"])
    return markdown("particles | two threads over one, least | most", rows)


@table("dam_break_density", "density errors of dam breaks 10 and 16 particles wide", "2 minutes")
def dam_break_density(m):
    rows = []
    for spacing, until in ((1.6e-2, 2.5), (1e-2, 2)):
        run = dam_break(m, spacing, until, 1)
        d = run.table()
        rows.append([f"{1e3 * spacing:g} mm", f"{run.report['particles']:.0f}", percent(d["density_error_mean"].mean(), 3),
                     percent(d["density_error_max"].max(), 2), f"{run.iterations_per_step:.1f}", f"{run.microseconds:.1f}"])
    return markdown("spacing | particles | mean | largest | iterations a step | CPU us a particle-step", rows)


@table("dam_break_stages", "where the time of a step goes: the first 0.15 s of dam_break", "1 minute")
def dam_break_stages(m):
    run = dam_break(m, 8e-3, 0.15, 1)
    stages = {name: stage["cpu_seconds"] for name, stage in run.report["stages"].items() if name != "write"}
    rows = [[name, percent(seconds / sum(stages.values())), f"{1e6 * seconds / run.report['particle_steps']:.2f}"]
            for name, seconds in sorted(stages.items(), key=lambda stage: -stage[1])]
    return markdown("stage | share of the time | CPU us a particle-step", rows)


@table("standing_water", "pressure in a resting column against rho g h, by the length of the step", "1 minute")
def standing_water(m):
    rows = []
    for cfl in (0.8, 0.4, 0.2, 0.1):
        run = m.render("scenes/studies/standing_water.toml", f"standing_water/{cfl}", f"time.cfl={cfl}")
        low = run.table("probes/low.csv")
        expected = 1000 * theory.gravity * 0.16  # a fifth above the floor of 0.2 m of water
        deviation = abs(low["pressure"][~(low["time"] < 0.5)] / expected - 1).mean()
        rows.append([f"{cfl}", percent(deviation, 1), f"{run.iterations_per_step:.1f}", f"{run.report['cpu_seconds']:.2f}"])
    return markdown("CFL | mean deviation | iterations a step | CPU s", rows)


# Scenes of divergence_free, and what is read from their runs

def scene(end, fps, low, high, spacing, block, **more):
    """Water in a box; `more` is laid over it, table by table."""
    keys = {"time": {"end": end, "fps": fps}, "domain": {"min": low, "max": high}, "fluid": {"spacing": spacing}, "block": [block],
            "models": {"pressure": "ppe", "viscosity": "none"}}
    for name, part in more.items():
        keys[name] = {**keys.get(name, {}), **part} if isinstance(part, dict) else part
    return keys


def box(low, high, **more):
    return {"shape": "box", "min": low, "max": high, **more}


weightless, channel = {"gravity": [0, 0, 0]}, {"periodic": [True, False, True]}
floor = {"solid": [{"shape": "plane"}], "domain": channel, "time": {"max_step": 5e-3}}


def vortex(sampling):
    velocity = ["sin(2*pi*x)*cos(2*pi*y)*cos(2*pi*z)", "-cos(2*pi*x)*sin(2*pi*y)*cos(2*pi*z)", "0"]
    return scene(0.3, 100, [0, 0, 0], [1, 1, 1], 0.0625, box([0, 0, 0], [1, 1, 1], velocity=velocity, sampling=sampling),
                 domain={**weightless, "periodic": [True] * 3})


def wave(damping):
    """A standing wave of 0.4 m on water 0.2 m deep, 0.1 m/s at its surface; the probe sees the water under a crest."""
    k = 2 * math.pi / 0.4
    U = 0.1 / math.sinh(k * 0.2)
    velocity = [f"{U}*sin({k}*x)*cosh({k}*y)", f"-{U}*cos({k}*x)*sinh({k}*y)", "0"]
    return scene(2, 200, [0, -0.05, 0], [0.4, 0.4, 0.06], 0.01, box([0, 0, 0], [0.4, 0.2, 0.06], velocity=velocity),
                 pressure={"damping": damping}, probe=[{"name": "crest", "kind": "region", "min": [0, -0.05, 0], "max": [0.1, 0.4, 0.06]}],
                 **floor)


def rod(end, **more):
    rod = {"shape": "cylinder", "from": [-0.045, 0, 0], "to": [0.045, 0, 0], "radius": 0.022, "velocity": ["-6*y", "6*x", "0"],
           "sampling": "blue_noise"}
    return scene(end, 50, [-0.4] * 3, [0.4] * 3, 4e-3, rod, domain=weightless, **more)


def left(words, column, digits):
    def found(run):
        values = run.table()[column]
        return [[words, percent(values[-1] / values[0], digits)]]

    return found


def rest(run):
    d = run.table()
    lost = 1 - d["potential_energy"][-1] / d["potential_energy"][0]
    return [["energy of motion", f"{d['kinetic_energy'][-1]:.1e} J"], ["height lost", percent(lost, 2)]]


def period(run):
    """Over that of linear theory, from five half periods of the velocity under the crest."""
    k, probe = 2 * math.pi / 0.4, run.table("probes/crest.csv")
    expected = 2 * math.pi / math.sqrt(theory.gravity * k * math.tanh(k * 0.2))
    zeros = theory.zeros(probe["time"], probe["velocity_y"], expected / 4)
    return [["period over theory's", f"{(zeros[5] - zeros[0]) / 2.5 / expected:.3f}" if len(zeros) > 5 else "no five half periods"]]


energy_left, momentum_left = left("energy left", "kinetic_energy", 1), left("angular momentum left", "angular_momentum_z", 2)


@table("divergence_free", "what a divergence-free velocity keeps of energy, density and period, and what it costs", "3 minutes")
def divergence_free(m):
    column = scene(1.5, 50, [0, -0.05, 0], [0.1, 0.4, 0.1], 0.0125, box([0, 0, 0], [0.1, 0.25, 0.1]), **floor)
    rows = []
    for k, (words, keys, *found) in enumerate((
            ("Taylor-Green, scattered, 0.3 s", vortex("blue_noise"), energy_left),
            ("Taylor-Green, lattice, 0.3 s", vortex("lattice"), energy_left),
            ("column of 20 layers, 1.5 s", column, rest),
            ("standing wave", wave(2), period), ("standing wave, damping = 0", wave(0), period),
            ("rotating_drop without viscosity, a radian", rod(1 / 6), energy_left, momentum_left),
            ("rotating_drop, 60 Pa s, two turns", rod(2.1, fluid={"viscosity": 60}, models={"viscosity": "full"}), energy_left,
             momentum_left))):
        file, cells = m.toml_file(f"divergence_free/scene{k}", keys), []
        for value in ("false", "true"):
            run = m.render(file, f"divergence_free/run{k}-{value}", f"pressure.divergence_free={value}")
            lines = [line for find in found for line in find(run)]
            cells.append([*lines[0], f"{100 * run.table()['density_error_mean'].mean():.2g}", f"{run.microseconds:.1f}", lines[1:]])
        (what, value, error, us, more), (_, free_value, free_error, free_us, free_more) = cells
        rows.append([words, what, value, error, us, free_value, free_error, free_us])
        rows += [["", also, a, "", "", b] for (also, a), (_, b) in zip(more, free_more)]
    return markdown("case | what | constraint | density error % | CPU us a particle-step | divergence-free | density error % | "
                    "CPU us a particle-step", rows)
