"""Micropolar fluids: curls, vorticity refinement, the cost of spin."""
import math

import numpy as np

from .registry import markdown, percent, table
from .runs import number


@table("curls", "error, order and conservation of every pair of curls with both Laplacians", "2 minutes")
def curls(m):
    percent = {"velocity_error": ".2f", "spin_error": ".2f", "uneven_velocity_error": ".1f", "uneven_spin_error": ".1f"}
    plain = {"velocity_order": ".1f", "spin_order": ".1f", "momentum": ".0e", "angular_momentum": ".0e", "energy": ".0e"}
    rows = [[f"{100 * number(cell):{percent[name]}}" if name in percent else f"{number(cell):{plain[name]}}" if name in plain else cell
             for name, cell in r.items()] for r in m.solver("curls")]
    return markdown("curl u | curl w | Laplacian | error of u [%] | order | error of w [%] | order | uneven: error of u [%] | "
                    "uneven: error of w [%] | momentum | angular momentum | energy", rows)


def three_runs(m, scene, frames, spin, finer):
    """Rows per frame of three runs (coarse, coarse with spin, fine): energy and its part across the stream [J/kg], enstrophy [1/s^2].
    Values after a run has diverged are nan."""
    spinning = ["models.micropolar=notes", "micropolar.xsph_spin=0", "micropolar.xsph_velocity=0", *spin]
    everywhere = {"name": "flow", "kind": "flow", "min": [-9, -9, -9], "max": [9, 9, 9]}
    overlay = m.toml_file("refinement/probe", {"probe": [everywhere], "output": {"export": ["points"]}})
    found = []
    for words, settings in (("coarse", []), ("spin", spinning), ("fine", finer)):
        run = m.render(f"scenes/studies/{scene}.toml", f"refinement/{scene}-{words}", *settings, options=["--with", overlay])
        square, rows = run.table("probes/flow.csv")["mean_square_vorticity"], []
        for frame in range(2, frames + 2):
            if m.dry or frame > len(square):
                rows.append(dict.fromkeys(("energy", "across", "enstrophy"), math.nan))
                continue
            now = run.particles(frame)[1]
            u, v, w = (now[f"velocity_{axis}"] for axis in "xyz")
            rows.append({"energy": (u**2 + v**2 + w**2).mean() / 2, "across": (v**2).mean() / 2, "enstrophy": square[frame - 1] / 2})
        found.append(rows)
    return found


@table("refinement", "a Taylor-Green vortex in 3D: coarse, with spin, fine", "3 minutes")
def refinement(m):
    three = three_runs(m, "vortex_box", 8, ["micropolar.transfer_viscosity=0.8", "micropolar.micro_inertia=2.5e-4"],
                       ["fluid.spacing=0.03125"])
    rows = [[f"{k / 4:.2f}", *(f"{run[k - 1]['energy']:.4f}" for run in three), *(f"{run[k - 1]['enstrophy']:.2f}" for run in three)]
            for k in (1, 2, 3, 4, 6, 8)]
    return markdown("t [s] | energy [J/kg]: coarse | with spin | fine | enstrophy [1/s^2]: coarse | with spin | fine", rows)


@table("refinement_street", "a Karman street: coarse, with spin, fine", "15 minutes")
def refinement_street(m):
    three = three_runs(m, "cylinder_street", 16, ["micropolar.transfer_viscosity=0.024", "micropolar.micro_inertia=4e-6"],
                       ["fluid.spacing=1.66666e-3", "domain.max=[0.22,0.045,0.0066667]", "block[0].max=[0.22,0.04,0.0066667]"])
    rows = []
    for k in range(0, 16, 4):  # means over half a second, in which about 1.5 vortices are shed
        mean = [{name: sum(row[name] for row in run[k:k + 4]) / 4 for name in run[k]} for run in three]
        rows.append([f"{k / 8:.1f} to {k / 8 + 0.5:.1f}", *(f"{1e3 * run['across']:.3f}" for run in mean),
                     *(f"{run['enstrophy']:.0f}" for run in mean)])
    return markdown("t [s] | energy across [mJ/kg]: coarse | with spin | fine | enstrophy [1/s^2]: coarse | with spin | fine", rows)


@table("towed_post", "a post that is towed and stops: coarse, with spin, fine", "4 minutes")
def towed_post(m):
    run = m.render("towed_post", "towed_post", "time.fps=6", options=["--quality", "draft"])
    flows = [run.table(f"panels/{k}/probes/flow.csv") for k in (1, 2, 3)]
    rows = []
    for t in () if m.dry else (0.5, 1, 1.5, 2, 3):
        now = [{name: values[int(np.argmin(np.abs(flow["time"] - t)))] for name, values in flow.items()} for flow in flows]
        rows.append([f"{t:.1f}", *(f"{1e3 * flow['kinetic_energy']:.2f}" for flow in now),
                     *(f"{flow['mean_square_vorticity'] / 2:.2f}" for flow in now)])
    return markdown("t [s] | energy [mJ/m]: coarse | with spin | fine | enstrophy [1/s^2]: coarse | with spin | fine", rows)


@table("spin_cost", "CPU ns per particle-step of 100,000 particles: with spin, without spin, without spin and viscosity", "1 minute")
def spin_cost(m):
    rows = []
    for words, panel in zip(("with spin (`notes`)", "without spin", "without spin and viscosity"),
                            m.render("scenes/studies/spin_cost.toml", "spin_cost", threads=2).panels):
        ns = {name: 1e9 * stage["cpu_seconds"] / panel["particle_steps"] for name, stage in panel["stages"].items() if name != "write"}
        parts = [ns.get("neighbours", 0), ns.get("density", 0), ns.get("pressure", 0), ns.get("viscosity", 0) + ns.get("micropolar", 0)]
        rows.append([words, *(f"{part:.0f}" if part else "" for part in parts), f"{sum(ns.values()):.0f}",
                     f"{panel['particle_steps'] / panel['wall_seconds'] / 1e6:.2f}"])
    return markdown("two threads | neighbours | density | pressure | viscosity and spin | all | million particle-steps per second", rows)


def bessel(n, x):
    """Modified Bessel function I_n of the first kind."""
    angle = np.linspace(0, math.pi, 2001)
    part = np.exp(np.multiply.outer(x, np.cos(angle))) * np.cos(n * angle)
    return (part.sum(-1) - (part[..., 0] + part[..., -1]) / 2) / (len(angle) - 1)  # trapezium rule; the integrand is smooth and periodic


def spin_up_flow(a, kappa, g, torque, radius, r):
    """Steady speed u and spin w at r in a round vessel with zero spin at the wall (docs/physics.md 8)."""
    m = math.sqrt(kappa * (2 * a - kappa) / (a * g))
    at_wall, slope = bessel(0, m * radius), bessel(1, m * radius)
    W = a * torque / (kappa * (2 * a - kappa * 2 * slope / (m * radius * at_wall)))
    return kappa * W / (a * m * at_wall) * (slope * r / radius - bessel(1, m * r)), W * (1 - bessel(0, m * r) / at_wall)


@table("spin_up", "fluid in a round vessel, turned by a torque on its particles, compared with Bessel functions", "2 minutes")
def spin_up(m):
    rows, a, kappa, radius, torque, length = [], 1.2e-4, 6e-5, 0.032, 4e-3, 5.5e-3
    for wall in ("solid", "free"):
        for across in (20, 40, 64) if wall == "solid" else (40,):
            run = m.render("spin_up", f"spin_up/{wall}-{across}", "panel=[]", f"micropolar.wall_spin={wall}", f"fluid.spacing={2 * radius / across:.9g}",
                           "time.fps=1")
            d = run.table("probes/radius.csv")
            end = ~(d["time"] < d["time"][-1])  # in a dry run: all rows
            u, w = spin_up_flow(a, kappa, a * length**2, torque, radius, d["s"][end])
            exact_w = w if wall == "solid" else np.full_like(w, torque / (2 * kappa))
            off = d["velocity_y"][end] - (u if wall == "solid" else 0)
            rows.append(["held by the wall" if wall == "solid" else "free at the wall", across, f"{1e3 * np.nanmax(np.abs(d['velocity_y'][end])):.2f}",
                         f"{1e3 * u.max() if wall == 'solid' else 0:.2f}", percent(np.abs(off).max() / u.max(), 1),
                         percent(np.abs(d["spin_z"][end] - exact_w).max() / exact_w.max(), 1)])
    return markdown("spin | spacings across | largest speed [mm/s] | exact | largest error of u | of w", rows)
