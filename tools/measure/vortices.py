"""2D flows of the projection, compared with exact solutions, the tables of references.py and published values."""
import math
from collections import defaultdict

import numpy as np

from . import theory
from .registry import markdown, percent, table
from .references import folder
from .runs import read_columns, root

pi = math.pi


def flow(m, scene, name, *settings, **keys):
    return m.render(f"{folder}/{scene}.toml", f"vortices/{scene}-{name}", *settings, **keys)


def at(columns, time):
    """Row at this time of a probe with one row per frame, by column."""
    if isinstance(columns, defaultdict):  # a dry run
        return defaultdict(lambda: math.nan)
    k = int(np.argmin(np.abs(columns["time"] - time)))
    return {name: values[k] for name, values in columns.items()}


def cost(run):
    return [f"{run.report['steps']:.0f}", f"{run.report['cpu_seconds']:.3g}"]


def worst(values):
    """The value furthest from 1."""
    return max(values, key=lambda value: abs(value - 1))


def vortices(nu, depth=()):
    rate = 8 * pi**2 * nu
    return ", ".join([f'["exp(-{rate}*t)*sin(2*pi*x)*cos(2*pi*y)"', f'"-exp(-{rate}*t)*cos(2*pi*x)*sin(2*pi*y)"', *depth]) + "]"


def taylor_green_run(m, reynolds, a_side, sampling):
    return flow(m, "taylor_green_vortices", f"{reynolds}-{a_side}-{sampling}", f"fluid.spacing={1 / a_side}", f"fluid.viscosity={1000 / reynolds:g}",
                f"block.0.sampling={sampling}", f"probe.0.expected={vortices(1 / reynolds)}")


def slab_of(thickness):
    """Settings that extend the 2D flow to a slab in 3D, at Re 100."""
    box = ["domain", "block.0", "probe.0"]
    return ["domain.dimensions=3", "domain.periodic=[true,true,true]", "domain.gravity=[0,0,0]", *(f"{one}.min=[0,0,0]" for one in box),
            *(f"{one}.max=[1,1,{thickness}]" for one in box), 'block.0.velocity=["sin(2*pi*x)*cos(2*pi*y)", "-cos(2*pi*x)*sin(2*pi*y)", "0"]',
            "probe.1.min=[0,0,0]", f"probe.1.max=[0.5,0.5,{thickness}]", f"""probe.0.expected={vortices(0.01, ['"0"'])}"""]


@table("taylor_green_vortices", "Taylor-Green vortices in 2D and in a slab, from a lattice and from jittered particles", "3 minutes")
def taylor_green_vortices(m):
    rows = []

    def add(words, asked, run):
        probe = run.table("probes/flow.csv")
        ratio = [at(probe, t)["kinetic_energy"] / at(probe, t)["expected_energy"] for t in (0.5, 1, 2)]
        error = [at(probe, t)["velocity_error"] for t in (0.5, 1, 2)]
        rows.append([words, asked, *(f"{value:.4f}" for value in ratio), percent(max(error), 2), *cost(run)])

    for a_side, asked in ((32, "1.5, 2 %"), (64, "0.5, 0.5 %")):
        for reynolds in (100, 1000):
            for sampling in ("lattice", "jittered"):
                if m.wanted(f"{reynolds}-{a_side}-{sampling}"):
                    add(f"Re {reynolds}, {a_side} a side, {sampling}", asked, taylor_green_run(m, reynolds, a_side, sampling))
    slab = slab_of(0.25)
    for sampling in ("lattice", "jittered"):
        if m.wanted(f"slab-{sampling}"):
            run = flow(m, "taylor_green_vortices", f"slab-{sampling}", *slab, f"block.0.sampling={sampling}")
            add(f"Re 100, 32 a side, slab of 8 layers, {sampling}", "2, 2 %", run)
    return markdown("case | bound | energy over theory at 0.5 s | 1 s | 2 s | velocity error | steps | CPU s", rows)


def order(coarse, fine, factor=2):
    """Order of convergence of an error. @param factor ratio of the two spacings or steps"""
    return math.log(coarse / fine) / math.log(factor)


@table("orders_in_space", "the order with which the velocity of Taylor-Green vortices converges with the spacing", "1 minute")
def orders_in_space(m):
    rows = []
    for reynolds in (100, 1000):
        for sampling in ("lattice", "jittered"):
            errors = []
            for a_side in (16, 32, 64):
                run = taylor_green_run(m, reynolds, a_side, sampling)
                errors.append(at(run.table("probes/flow.csv"), 1)["velocity_error"])
            rows.append([f"Re {reynolds}, {sampling}", *(percent(error, 2) for error in errors),
                         *(f"{order(*pair):.1f}" for pair in zip(errors, errors[1:]))])
    return markdown("case | error with 16 a side | 32 | 64 | order from 16 to 32 | from 32 to 64", rows)


@table("orders_in_time", "the order with which the energy of Taylor-Green vortices converges with the step", "1 minute")
def orders_in_time(m):
    rows, end, steps = [], 0.25, (10, 20, 40, 80)  # the viscous limit of the step itself requires 10
    for reynolds in (100, 1000):
        energies = []
        for count in steps:
            run = flow(m, "taylor_green_vortices", f"{reynolds}-{count}-steps", f"fluid.viscosity={1000 / reynolds:g}", f"time.max_step={end / count}",
                       "time.cfl=2", f"time.end={end}", f"time.fps={1 / end:g}", "block.0.sampling=jittered",
                       f"probe.0.expected={vortices(1 / reynolds)}")
            last = run.last("probes/flow.csv")
            energies.append(last["kinetic_energy"] / last["expected_energy"])
        changes = np.abs(np.diff(energies))
        rows.append([f"Re {reynolds}", *(f"{energy:.5f}" for energy in energies), *(f"{order(*pair):.2f}" for pair in zip(changes, changes[1:])),
                     f"{order(changes[0], changes[-1], 4):.2f}"])
    return markdown("case | energy over theory with 10 steps | 20 | 40 | 80 | order from 10, 20, 40 | from 20, 40, 80 | mean order", rows)


@table("equal_error", "cost of Taylor-Green vortices by error, with the projection and weakly compressible", "1 minute")
def equal_error(m):
    rows, sound = [], ["models.pressure=wcsph", "pressure.sound_speed=15", "pressure.background_pressure=1000", "pressure.gradient=difference",
                       "pressure.artificial_viscosity=0", "fluid.support=3"]
    for words, sizes, settings in (("projection", (16, 32), []), ("weakly compressible", (32, 64, 128), sound)):
        for a_side in sizes:
            run = flow(m, "taylor_green_vortices", f"{words.split()[0]}-{a_side}", *settings, f"fluid.spacing={1 / a_side}", "time.end=1",
                       "block.0.sampling=jittered")
            then = at(run.table("probes/flow.csv"), 0.9)
            rows.append([words, f"{a_side}", f"{then['kinetic_energy'] / then['expected_energy']:.4f}", percent(then["velocity_error"], 2), *cost(run)])
    return markdown("pressure | a side | energy over theory at 0.9 s | velocity error | steps | CPU s to 1 s", rows)


@table("projection_sizes", "iterations and time of the projection from 16 thousand to a million particles", "2 minutes")
def projection_sizes(m):
    rows = []
    for a_side in (128, 256, 512, 1024):
        end = 2 / a_side
        run = flow(m, "taylor_green_vortices", f"size-{a_side}", f"fluid.spacing={1 / a_side}", f"time.end={end}", f"time.fps={1 / end}",
                   "block.0.sampling=jittered", "pressure.preconditioner=multigrid")
        r = run.report
        ns = {name: 1e9 * stage["cpu_seconds"] / r["particle_steps"] for name, stage in r["stages"].items()}
        rows.append([f"{a_side**2}", f"{run.iterations_per_step:.1f}", *(f"{ns.get(name, math.nan):.0f}" for name in ("neighbours", "density", "viscosity", "pressure", "move")),
                     f"{1e9 * r['cpu_seconds'] / r['particle_steps']:.0f}"])
    return markdown("particles | iterations per step | ns per particle-step: neighbours | geometry | viscosity | pressure | move | all", rows)


@table("plane_speed", "cost of a particle-step in 2D and in a slab, by stage, smallest of three runs", "1 minute")
def plane_speed(m):
    rows, parts = [], ("neighbours", "density", "viscosity", "pressure", "move")
    for words, settings in (("projection", []), ("weakly compressible", ["models.pressure=wcsph", "pressure.sound_speed=15"])):
        all_of = {}
        for shape, spacing, more in (("2D", 1 / 128, []), ("slab of 8 layers", 1 / 64, slab_of(0.125))):
            runs = [flow(m, "taylor_green_vortices", f"speed-{words.split()[0]}-{shape.split()[0]}-{k}", f"fluid.spacing={spacing}", "time.end=0.2",
                         "block.0.sampling=jittered", *more, *settings).report for k in range(3)]
            best = min(runs, key=lambda r: r["cpu_seconds"] / r["particle_steps"])
            ns = {name: 1e9 * stage["cpu_seconds"] / best["particle_steps"] for name, stage in best["stages"].items()}
            all_of[shape] = 1e9 * best["cpu_seconds"] / best["particle_steps"]
            rows.append([words, shape, *(f"{ns.get(name, 0):.0f}" for name in parts), f"{all_of[shape]:.0f}"])
        rows[-2].append(f"{all_of['slab of 8 layers'] / all_of['2D']:.2f}")
    return markdown("pressure | shape | ns per particle-step: neighbours | density or geometry | viscosity | pressure | move | all | times faster", rows)


@table("kept_momentum", "changes of momentum and angular momentum under the projection", "1 minute")
def kept_momentum(m):
    rows = []
    for a_side in (32, 64):
        for reynolds in (100, 1000):
            for sampling in ("lattice", "jittered"):
                run = taylor_green_run(m, reynolds, a_side, sampling)
                d, mass = run.table(), 1000
                size = mass * np.sqrt(2 * d["kinetic_energy"][0] / mass)
                off = np.hypot(d["momentum_x"] - d["momentum_x"][0], d["momentum_y"] - d["momentum_y"][0]) / size
                rows.append([f"momentum, Taylor-Green, Re {reynolds}, {a_side} a side, {sampling}", f"{off.max():.1e}", *cost(run)])
    for across in (32, 64, 128):
        run = flow(m, "single_vortex", f"{across}", f"fluid.spacing={1 / across}")
        turn = run.table()["angular_momentum_z"]
        rows.append([f"angular momentum, single vortex, {across} a side", f"{np.abs(turn / turn[0] - 1).max():.1e}", *cost(run)])
    return markdown("case | largest relative change | steps | CPU s", rows)


def spinning(a, kappa, g, theta_s, k, times):
    """Amplitudes (U, W) of u = U (sin kx cos ky, -cos kx sin ky) and w = W sin kx sin ky with (U, W) = (1, 0) at t = 0:
    U' = -2 a k^2 U + kappa k W, theta W' = -2 g k^2 W + kappa (2 k U - 2 W)."""
    rates = np.array([[-2 * a * k**2, kappa * k], [2 * kappa * k / theta_s, -(2 * g * k**2 + 2 * kappa) / theta_s]])
    values, vectors = np.linalg.eig(rates)
    weights = np.linalg.solve(vectors, [1, 0])
    return [(vectors @ (weights * np.exp(values * t))).real for t in times]


@table("taylor_green_spin", "Taylor-Green vortices with spin, compared with the exact amplitudes of flow and spin", "1 minute")
def taylor_green_spin(m):
    rows, times = [], (0.5, 1, 2)
    exact = spinning(0.0125, 0.005, 1e-4, 1e-3, 2 * pi, times)
    for a_side in (32, 64):
        run = flow(m, "taylor_green_vortices", f"spin-{a_side}", f"fluid.spacing={1 / a_side}", "models.micropolar=bender", "fluid.viscosity=12.5",
                   "micropolar.transfer_viscosity=5", "micropolar.spin_viscosity=0.1", "micropolar.micro_inertia=1e-3",
                   "micropolar.xsph_velocity=0", "micropolar.xsph_spin=0")
        energy, cell = run.table("probes/flow.csv"), run.table("probes/cell.csv")
        start = energy["kinetic_energy"][0]
        rows.append([f"{a_side} a side", "2, 3 %", *(f"{at(energy, t)['kinetic_energy'] / start / U**2:.4f}" for t, (U, _) in zip(times, exact)),
                     *(f"{at(cell, t)['spin_z'] * pi**2 / 4 / W:.4f}" for t, (_, W) in zip(times, exact)), *cost(run)])
    return markdown("case | bound | energy over theory at 0.5 s | 1 s | 2 s | spin over theory at 0.5 s | 1 s | 2 s | steps | CPU s", rows)


def core_radius(x, v):
    """Core radius c of u = (1 - exp(-r^2/c^2))/(2 pi r), by least squares."""
    keep = np.abs(x) > 1e-6
    radii = np.arange(0.05, 0.4, 1e-4)
    off = [((v[keep] - (1 - np.exp(-x[keep]**2 / c**2)) / (2 * pi * x[keep]))**2).sum() for c in radii]
    return radii[int(np.argmin(off))]


def modes_energy(square_core):
    """Energy of four vortices of alternating sign in a periodic box of 2 m, up to a factor."""
    odd = np.arange(1, 60, 2)
    k2 = pi**2 * np.add.outer(odd**2, odd**2)
    return (np.exp(-k2 * square_core / 2) / k2).sum()


@table("lamb_oseen", "the growing core of a Lamb-Oseen vortex", "1 minute")
def lamb_oseen(m):
    rows, times = [], (0.5, 1, 2, 4)
    for spacing, asked in ((1 / 16, ""), (1 / 32, "1.5 %"), (1 / 64, "")):
        if not m.wanted(round(1 / spacing)):
            continue
        run = flow(m, "lamb_oseen", f"{1 / spacing:.0f}", f"fluid.spacing={spacing}")
        energy, line = run.table("probes/flow.csv"), run.table("probes/across.csv")
        cores, energies = [], []
        for t in times:
            square, now = 0.01 + 4e-3 * t, np.abs(line["time"] - t) < 1e-6
            if m.dry:
                continue
            cores.append(f"{core_radius(line['x'][now] - 0.5, line['velocity_y'][now]) / math.sqrt(square):.4f}")
            energies.append(at(energy, t)["kinetic_energy"] / energy["kinetic_energy"][0] / modes_energy(square) * modes_energy(0.01))
        rows.append([f"1/{1 / spacing:.0f} m", asked, *cores, f"{worst(energies or [1]):.4f}", *cost(run)])
    return markdown("spacing | bound for the core | core over theory at 0.5 s | 1 s | 2 s | 4 s | energy over theory, worst | steps | CPU s",
                    rows)


@table("double_shear_layer", "the double shear layer compared with a spectral method", "2 minutes")
def double_shear_layer(m):
    rows, spectral = [], read_columns(root / folder / "double_shear_layer.csv")
    for a_side in (64, 128):
        if not m.wanted(a_side):
            continue
        run = flow(m, "double_shear_layer", f"{a_side}", f"fluid.spacing={1 / a_side}")
        probe = run.table("probes/flow.csv")
        start = probe["kinetic_energy"][0]
        energy = [at(probe, t)["kinetic_energy"] / start / at(spectral, t)["energy"] for t in (0.5, 0.8, 1)]
        end, exact = at(probe, 1), at(spectral, 1)
        rows.append([f"{a_side} a side", "0.3, 2 %", *(f"{value:.4f}" for value in energy),
                     f"{end['largest_vorticity'] / exact['largest_vorticity']:.3f}",
                     f"{end['mean_square_vorticity'] / exact['mean_square_vorticity']:.3f}", *cost(run)])
    return markdown("case | bound for energy, vorticity | energy over the spectral one at 0.5 s | 0.8 s | 1 s | largest vorticity | "
                    "mean square vorticity | steps | CPU s", rows)


@table("lid_driven_cavity", "the lid-driven cavity compared with a grid solution and with Ghia, Ghia and Shin", "40 minutes")
def lid_driven_cavity(m):
    rows, grid = [], read_columns(root / folder / "lid_driven_cavity.csv")
    published = {profile: read_columns(root / folder / f"ghia_ghia_shin_1982_{profile}.csv") for profile in "uv"}
    for reynolds, end in ((100, 15), (400, 40), (1000, 60)):
        for a_side, asked in ((64, "2 %"), (128, "1 %")):
            if not m.wanted(f"{reynolds}-{a_side}"):
                continue
            run = flow(m, "lid_driven_cavity", f"{reynolds}-{a_side}", f"fluid.spacing={1 / a_side}", f"fluid.viscosity={1000 / reynolds:g}",
                       f"time.end={end}")
            off = {"grid": [], "Ghia": []}
            cells = []
            for profile, column in (("u", "velocity_x"), ("v", "velocity_y")):
                line = run.table(f"probes/{profile}.csv")
                last = line["time"] > end - 0.5
                if m.dry:
                    continue
                values, exact = line[column][last], grid[f"{profile}_{reynolds}"]
                off["grid"].append(np.abs(values - exact).max())
                off["Ghia"].append(np.abs(np.interp(published[profile]["place"], grid["s"], values) - published[profile][f"{reynolds}"]).max())
                cells += [f"{values.min():.4f} ({exact.min():.4f})"] + [f"{values.max():.4f} ({exact.max():.4f})"] * (profile == "v")
            if not m.dry:
                rows.append([f"Re {reynolds}, {a_side} a side", asked, percent(max(off["grid"]), 2), percent(max(off["Ghia"]), 2), *cells,
                             *cost(run)])
    return markdown("case | bound | largest distance from the grid | from Ghia, Ghia and Shin | least u (grid) | least v (grid) | "
                    "largest v (grid) | steps | CPU s", rows)


@table("rest", "water at rest in a column, a closed box and a slot", "1 minute")
def rest(m):
    rows, g = [], theory.gravity
    for words, settings in (("column", []), ("closed box", ["solid.0.max=[0.5,1]"]),
                            ("slot of five spacings", ["block.0.max=[0.15625,1]", "solid.0.max=[0.15625,1.4]",
                                                       "probe.0.from=[0.078125,0.0625]", "probe.0.to=[0.078125,0.9375]"])):
        for sampling in ("lattice", "jittered"):
            run = flow(m, "resting_column", f"{words.split()[0]}-{sampling}", f"block.0.sampling={sampling}", "time.end=10", *settings)
            d, line = run.table(), run.table("probes/up.csv")
            cells = []
            for t in (2, 10):
                now = np.abs(line["time"] - t) < 1e-6
                if m.dry:
                    continue
                off = line["pressure"][now] / (1000 * g) - (1 - line["y"][now])
                off = off - (off.mean() if words == "closed box" else -0.5 / 32)  # exact: 0 at the outermost particles
                cells += [percent(at(d, t)["max_speed"] / math.sqrt(g), 3), percent(np.abs(off).max(), 2)]
            rows.append([f"{words}, {sampling}", "0.5, 1 %", *cells, *cost(run)])
    return markdown("case | bound for speed, pressure | largest speed at 2 s | pressure | at 10 s | pressure | steps | CPU s", rows)


def median_of_three(values):
    """Median of each value and its neighbours: removes single outliers."""
    return np.median([np.r_[values[:1], values[:-1]], values, np.r_[values[1:], values[-1:]]], axis=0)


def wave(time, signal, frequencies):
    """Frequency and amplitude of the strongest sine in a signal, under a sin^2 window."""
    window = np.sin(pi * (time - time[0]) / (time[-1] - time[0]))**2
    parts = [abs((window * (signal - signal.mean()) * np.exp(-2j * pi * f * time)).sum()) for f in frequencies]
    k = int(np.argmax(parts))
    return frequencies[k], 2 * parts[k] / window.sum()


@table("cylinder_stream", "a cylinder in a stream: Strouhal number, drag and lift", "4 hours")
def cylinder_stream(m):
    rows = []
    half = [f"{key}={corner}" for key, corner in (("domain.min", "[-6,-10]"), ("domain.max", "[17,10]"), ("block.0.min", "[-6,-10]"),
                                                  ("block.0.max", "[17,10]"), ("stream.0.min", "[13,-10]"), ("stream.0.max", "[17,10]"))]
    cases = ((100, 10, "5", 0.165, 1.35), (100, 20, "5", 0.165, 1.35), (200, 20, "2.5", 0.197, 1.34))
    for reynolds, across, blocked, strouhal, drag in cases:
        if m.wanted(f"{reynolds}-{across}"):
            run = flow(m, "cylinder_stream", f"{reynolds}-{across}", f"fluid.spacing={1 / across}", f"fluid.viscosity={1000 / reynolds:g}",
                       *(half if blocked == "5" else []))
            if m.dry:
                continue
            force = run.table("probes/force.csv")
            late = force["time"] > 15
            x, y = (median_of_three(force[f"pressure_{c}"] + force[f"viscous_{c}"])[late] / 500 for c in "xy")
            found, lift = wave(force["time"][late], y, np.arange(0.1, 0.3, 1e-4))
            friction = force["viscous_x"][late].mean() / 500
            rows.append([f"Re {reynolds}, {across} across, {blocked} % blocked", "3, 5 %", f"{found:.4f} ({strouhal})",
                         f"{x.mean():.3f} ({drag})", f"{friction:.3f}", f"{lift:.3f}", *cost(run)])
    return markdown("case | bound for Strouhal number, drag | Strouhal number (published) | mean drag (published) | friction part | "
                    "lift amplitude | steps | CPU s", rows)


@table("martin_moyce", "the front of a collapsing column compared with the experiment", "1 minute")
def martin_moyce(m):
    rows, a, experiment = [], 0.05715, read_columns(root / folder / "martin_moyce.csv")
    second = math.sqrt(2 * theory.gravity / a)
    for layers in (40, 80):
        spacing = 2 * a / layers
        run = flow(m, "martin_moyce", f"{layers}", f"fluid.spacing={spacing:.8g}", options=["--export", "points"])
        if m.dry:
            continue
        # The front is the fourth particle: up to three may be drops ahead of it.
        fronts = [(np.sort(run.points(k + 1)[:, 0])[-4] + spacing / 2) / a for k in range(81)]
        times = np.arange(81) / 400 * second
        early = experiment["T"][0] - np.interp(experiment["Z"][0], fronts, times)  # in the experiment a membrane has to burst first
        found = np.interp(experiment["T"] - early, times, fronts)
        rows.append([f"{layers} layers", "5 %", percent(np.abs(found / experiment["Z"] - 1).max(), 1), f"{early:.2f}", *cost(run)])
    return markdown("case | bound | largest distance from the front | time shift [T] | steps | CPU s", rows)
