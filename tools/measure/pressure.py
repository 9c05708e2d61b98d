"""docs/reports/pressure.md: the pressure solves, their preconditioners, dam breaks and pools."""
import math

import numpy as np

from . import theory
from .registry import markdown, table
from .runs import attempt, number

page = "docs/reports/pressure.md"


def preconditioners(m, cases):
    """@param cases layers across the depth and steps before the one that is measured"""
    columns, rows = ("none", "diagonal", "multigrid"), []
    for form in ("constraint", "poisson"):
        for layers, steps in cases:
            systems = {}
            for r in m.solver(f"pressure_preconditioners/{form}-{layers}-{steps}", "pressure_preconditioners", "--form", form, "--layers", layers,
                              "--steps", steps):
                systems.setdefault((r["particles"], r["factor"], r["residual"]), {})[r["preconditioner"]] = r
            for (particles, factor, residual), found in systems.items():
                cells, multigrid, diagonal = [], found["multigrid"], found["diagonal"]
                for r in (found[name] for name in columns):
                    cells += [f"{number(r['iterations']):.0f}" + ("" if number(r["converged"]) else "+"), f"{1e3 * number(r['seconds']):.3g}",
                              f"{100 * number(r['error']):.2g}"]
                rows.append([form, f"{number(particles):.0f}", f"{number(factor):g}", f"{number(residual):.1e}", *cells,
                             f"{1e3 * number(multigrid['set_up_seconds']):.3g}", f"{number(multigrid['levels']):.0f}",
                             f"{number(multigrid['bytes']):.0f}", f"{number(diagonal['seconds']) / number(multigrid['seconds']):.1f}"])
    return markdown(["form", "particles", "step over CFL 0.4", "residual", *(c for name in columns for c in (name, "ms", "error %")), "of it set-up",
                     "levels", "bytes a particle", "times faster"], rows)


@table("pressure_preconditioners", "iterations, time and error without, with the diagonal, with multigrid; 1e3 to 1e5 particles", "3 minutes", page)
def pressure_preconditioners(m):
    return preconditioners(m, [(7, 10), (14, 16), (29, 20)])


@table("pressure_preconditioners_large", "the same, a million particles", "15 minutes, 3 GB", page)
def pressure_preconditioners_large(m):
    return preconditioners(m, [(63, 4)])


@table("pressure_hierarchies", "multigrid with other first levels, interpolations and cycles", "2 minutes", page)
def pressure_hierarchies(m):
    cells = {}
    for form in ("constraint", "poisson"):
        for r in m.solver(f"pressure_hierarchies/{form}", "pressure_hierarchies", "--form", form):
            cells.setdefault((form, f"{number(r['cell']):g} d", r["interpolation"]), []).append(
                [f"{number(r['iterations']):.0f}", f"{1e3 * number(r['set_up_seconds']):.3g}", f"{1e3 * number(r['seconds']):.3g}"])
    rows = [[*case, *(cell for cycle in cycles for cell in cycle)] for case, cycles in cells.items()]
    return markdown(["form", "cells", "coarse interpolation", "additive: iterations", "set-up ms", "ms", "V-cycle: iterations", "set-up ms", "ms"], rows)


@table("pressure_threads", "wall time of a solve with one and with two threads", "1 minute, an idle machine", page)
def pressure_threads(m):
    rows = []
    for form in ("constraint", "poisson"):
        one = math.nan
        for r in m.solver(f"pressure_threads/{form}", "pressure_threads", "--form", form):
            set_up, solve = number(r["set_up_seconds"]), number(r["solve_seconds"])
            one = set_up + solve if r["threads"] == "1" else one
            rows.append([form, r["threads"], f"{1e3 * set_up:.3g}", f"{1e3 * solve:.3g}", f"{one / (set_up + solve):.2f}"])
    return markdown(["form", "threads", "set-up ms", "solve ms", "faster"], rows)


def dam_break(m, spacing, until, threads, *settings):
    words = "-".join([f"{spacing:g}", f"{until:g}", f"{threads}", *settings])
    return m.render("scenes/dam_break.toml", f"dam_break/{words}", f"fluid.spacing={spacing:g}", *settings, options=["--until", until], threads=threads)


@table("dam_break_whole", "scenes/dam_break.toml, 4 s, 49,000 and 197,000 particles on two threads", "9 hours", page)
def dam_break_whole(m):
    rows = []
    for spacing in (5.47e-3, 3.43e-3):
        if not m.wanted(f"{spacing:g}"):
            continue

        def measure():
            run = dam_break(m, spacing, 4, 2)
            d, r = run.table(), run.report
            return [f"{r['particles']:.0f}", f"{r['steps']:.0f}", f"{run.iterations_per_step:.1f}", f"{run.microseconds:.2f}",
                    f"{1e6 * r['wall_seconds'] / r['particle_steps']:.2f}", f"{r['cpu_seconds'] / r['time']:.0f}",
                    f"{100 * d['density_error_mean'].mean():.3f} %", f"{100 * d['density_error_mean'].max():.3f} %",
                    f"{100 * d['density_error_max'].max():.2f} %", f"{r['lost_particles']:.0f}", f"{r['peak_memory_bytes'] / r['particles']:.0f}"]

        rows.append(attempt([f"{1e3 * spacing:g} mm"], measure, 12))
    return markdown(["spacing", "particles", "steps", "iterations a step", "CPU us a particle-step", "wall us", "CPU s a simulated s", "mean density error",
                     "largest of a frame", "largest of a particle", "lost", "bytes a particle"], rows)


@table("dam_break_threads", "the first 0.1 s of it on one and on two threads", "4 minutes, an idle machine", page)
def dam_break_threads(m):
    rows = []
    for spacing in (8e-3, 5.47e-3):
        one = math.nan
        for threads in (1, 2):
            r = dam_break(m, spacing, 0.1, threads).report
            wall = 1e6 * r["wall_seconds"] / r["particle_steps"]
            one = wall if threads == 1 else one
            rows.append([f"{r['particles']:.0f}", threads, f"{wall:.2f}", f"{1e6 * r['cpu_seconds'] / r['particle_steps']:.2f}", f"{one / wall:.2f}"])
    return markdown(["particles", "threads", "wall us a particle-step", "CPU us", "times as fast"], rows)


@table("dam_break_density", "density errors of dam breaks of 10 and 20 layers", "5 minutes", page)
def dam_break_density(m):
    rows = []
    for layers, spacing, until in ((10, 1.6e-2, 2.5), (16, 1e-2, 2)):
        run = dam_break(m, spacing, until, 1)
        d = run.table()
        rows.append([layers, f"{run.report['particles']:.0f}", f"{until} s", f"{100 * d['density_error_mean'].mean():.3f} %",
                     f"{100 * d['density_error_max'].max():.2f} %", f"{run.iterations_per_step:.1f}", f"{run.microseconds:.1f}"])
    return markdown(["layers", "particles", "until", "mean density error", "largest", "iterations a step", "CPU us a particle-step"], rows)


@table("dam_break_stages", "where the time of a step goes: the first 0.15 s of dam_break", "1 minute", page)
def dam_break_stages(m):
    run = dam_break(m, 8e-3, 0.15, 1)
    stages = {name: stage["cpu_seconds"] for name, stage in run.report["stages"].items() if name != "write"}
    rows = [[name, f"{100 * seconds / sum(stages.values()):.0f} %", f"{1e6 * seconds / run.report['particle_steps']:.2f}"]
            for name, seconds in sorted(stages.items(), key=lambda stage: -stage[1])]
    return markdown(["stage", "part", "CPU us a particle-step"], rows)


@table("active_set", "pressures cut off at zero after one solve beside those found with the particles that press", "1 minute", page)
def active_set(m):
    columns = []
    for value in ("true", "false"):
        run = dam_break(m, 1.6e-2, 2.5, 1, f"pressure.active_set={value}")
        d = run.table()
        windows = [100 * d["density_error_mean"][~((d["time"] < start) | (d["time"] > end))].mean() for start, end in ((0, 0.4), (0.8, 1.0), (2.3, 2.5))]
        weight = run.report["particles"] * 1000 * 1.6e-2**3 * theory.gravity
        columns.append([*(f"{w:.2f} %" for w in windows), f"{1e3 * d['potential_energy'][-1] / weight:.1f} mm", f"{run.iterations_per_step:.1f}",
                        f"{run.microseconds:.1f}"])
    names = ["mean density error to 0.4 s", "from 0.8 to 1 s (impact)", "from 2.3 to 2.5 s", "height of the mass at 2.5 s", "iterations a step",
             "CPU us a particle-step"]
    return markdown(["", "active set", "cut off"], [[name, *cells] for name, *cells in zip(names, *columns)])


@table("standing_water", "pressure in a resting column against rho g h, by the length of the step", "1 minute", page)
def standing_water(m):
    rows = []
    for cfl in (0.8, 0.4, 0.2, 0.1):
        run = m.render("scenes/studies/standing_water.toml", f"standing_water/{cfl}", f"time.cfl={cfl}", "time.fps=200")
        low = run.table("probes/low.csv")
        expected = 1000 * theory.gravity * 0.16
        deviation = abs(low["pressure"][~(low["time"] < 0.5)] / expected - 1).mean()
        rows.append([cfl, f"{100 * deviation:.1f} %", f"{run.iterations_per_step:.1f}", f"{run.report['cpu_seconds']:.2f}"])
    return markdown(["CFL", "mean deviation of the pressure", "iterations a step", "CPU s"], rows)


# Scenes of divergence_free

periodic = [True, True, True]


def box(low, high):
    return {"shape": "box", "min": low, "max": high}


def vortex(sampling):
    velocity = ["sin(2*pi*x)*cos(2*pi*y)*cos(2*pi*z)", "-cos(2*pi*x)*sin(2*pi*y)*cos(2*pi*z)", "0"]
    return {"time": {"end": 0.3, "fps": 100}, "domain": {"min": [0, 0, 0], "max": [1, 1, 1], "periodic": periodic, "gravity": [0, 0, 0]},
            "fluid": {"spacing": 0.0625}, "block": [{**box([0, 0, 0], [1, 1, 1]), "velocity": velocity, "sampling": sampling}]}


def column():
    return {"time": {"end": 1.5, "fps": 50, "max_step": 5e-3}, "domain": {"min": [0, -0.05, 0], "max": [0.1, 0.4, 0.1], "periodic": [True, False, True]},
            "fluid": {"spacing": 0.0125}, "block": [box([0, 0, 0], [0.1, 0.25, 0.1])], "solid": [{"shape": "plane"}]}


def wave(damping):
    length, depth, speed = 0.4, 0.2, 0.1
    k = 2 * math.pi / length
    U = speed / math.sinh(k * depth)
    velocity = [f"{U}*sin({k}*x)*cosh({k}*y)", f"-{U}*cos({k}*x)*sinh({k}*y)", "0"]
    return {"time": {"end": 2, "fps": 200, "max_step": 5e-3}, "domain": {"min": [0, -0.05, 0], "max": [length, 0.4, 0.06], "periodic": [True, False, True]},
            "fluid": {"spacing": 0.01}, "block": [{**box([0, 0, 0], [length, depth, 0.06]), "velocity": velocity}], "solid": [{"shape": "plane"}],
            "pressure": {"damping": damping}, "probe": [{"name": "crest", "kind": "region", "min": [0, -0.05, 0], "max": [length / 4, 0.4, 0.06]}]}


def rod(viscosity, end):
    return {"time": {"end": end, "fps": 50}, "domain": {"min": [-0.4] * 3, "max": [0.4] * 3, "gravity": [0, 0, 0]},
            "fluid": {"spacing": 4e-3, "viscosity": viscosity},
            "block": [{"shape": "cylinder", "from": [-0.045, 0, 0], "to": [0.045, 0, 0], "radius": 0.022, "velocity": ["-6*y", "6*x", "0"],
                       "sampling": "blue_noise"}]}


def energy_left(run):
    energy = run.table()["kinetic_energy"]
    return f"{100 * energy[-1] / energy[0]:.1f} % of the energy left"


def rest(run):
    d = run.table()
    lost = 1 - d["potential_energy"][-1] / d["potential_energy"][0]
    return f"{d['kinetic_energy'][-1]:.1e} J of motion, {100 * lost:.2f} % of the height lost"


def period(run):
    """Of the standing wave, over that of linear theory: five half periods of the velocity under the crest."""
    k, probe = 2 * math.pi / 0.4, run.table("probes/crest.csv")
    expected = 2 * math.pi / math.sqrt(theory.gravity * k * math.tanh(k * 0.2))
    zeros = theory.zeros(probe["time"], probe["velocity_y"], expected / 4)
    return f"period {(zeros[5] - zeros[0]) / 2.5 / expected:.3f} of theory's" if len(zeros) > 5 else "no five half periods"


def spinning(run):
    momentum = run.table()["angular_momentum_z"]
    return f"{energy_left(run)}, {100 * momentum[-1] / momentum[0]:.2f} % of the angular momentum"


@table("divergence_free", "what a divergence-free velocity keeps of energy, density and period, and what it costs", "3 minutes", page)
def divergence_free(m):
    cases = [("Taylor-Green, scattered, 0.3 s", vortex("blue_noise"), energy_left), ("Taylor-Green, lattice, 0.3 s", vortex("lattice"), energy_left),
             ("column of 20 layers, 1.5 s", column(), rest), ("standing wave", wave(2), period), ("standing wave, damping = 0", wave(0), period),
             ("rotating_drop without viscosity, a radian", rod(0, 1 / 6), spinning), ("rotating_drop, 60 Pa s, two turns", rod(60, 2.1), spinning)]
    rows = []
    for k, (words, scene, found) in enumerate(cases):
        scene["models"] = {"pressure": "ppe", "viscosity": "full" if scene["fluid"].get("viscosity") else "none"}
        file, cells = m.overlay(f"divergence_free/scene{k}", scene), [words]
        for value in ("false", "true"):
            run = m.render(file, f"divergence_free/run{k}-{value}", f"pressure.divergence_free={value}")
            cells += [found(run), f"{100 * np.mean(run.table()['density_error_mean']):.2g}", f"{run.microseconds:.1f}"]
        rows.append(cells)
    return markdown(["case", "constraint", "mean density error %", "CPU us a particle-step", "divergence-free", "mean density error %",
                     "CPU us a particle-step"], rows)
