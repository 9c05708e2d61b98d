"""Experiments with thick fluids: swelling jets, folding sheets, puddles, drums, balls."""
import math

import numpy as np

from . import theory
from .laboratory import between, experiment, force, published, snapshots, spacing

g, rho, pi = theory.gravity, 1000, math.pi
coupled, split = ["models.pressure=coupled"], ["models.pressure=ppe", "models.viscosity=full"]
both_models = {"coupled": coupled, "ppe and full": split}


@experiment("die_swell", {"plane": (), "round": ()}, scene="die_swell_{}")
def die_swell(found, runs):
    lines = []
    for (shape, one), ratio, style in zip(runs.items(), (1.186, 1.127), ("C0-", "C1-")):
        places = np.arange(0.5, 2.6, 0.1)  # distances from the end of the die, in die widths
        *_, (_, p) = snapshots(one)
        width = 0.01
        ratios = []
        for x in places:  # area of the jet over that of the die = piston speed over jet speed
            here = np.abs(p["x"] - x * width) < 0.15 * width
            area = 0.02 / np.hypot(p["velocity_x"], p["velocity_y"])[here].mean() if here.sum() > 10 else math.nan
            ratios.append(area if shape == "plane" else math.sqrt(area))
        found.add(f"thickness of the {shape} jet over that of the die", ratio, np.nanmean([r for x, r in zip(places, ratios) if 1 < x < 2]))
        lines += [(f"Whorl, {shape}", places, ratios, style), (f"published, {shape}", [0.5, 2.5], [ratio, ratio], style + "-")]
    found.plot("distance from the die over its width", "thickness over the die's", *lines, ylim=(0.9, 1.4))


@experiment("folding_sheet", {viscosity: [f"fluid.viscosity={viscosity}"] for viscosity in (50, 100, 200)})
def folding_sheet(found, runs):
    """Frequency of folding, thickness and speed of the sheet, all from the particles 45 mm below the slot."""
    sheet, lines = published("folding_sheet"), []
    for (viscosity, one), *exact, style in zip(runs.items(), sheet["frequency"], sheet["thickness"], sheet["speed"], ("C0-", "C1-", "C2-")):
        d, rows = spacing(one), []
        for t, p in snapshots(one):
            here = np.abs(p["y"] - 0.055) < 0.003
            if t > 1 and here.sum() > 10:
                rows.append((t, p["x"][here].mean(), here.sum() * d**2 / 0.006, np.hypot(p["velocity_x"], p["velocity_y"])[here].mean()))
        time, place, thickness, speed = np.array(rows).T
        measured = (theory.frequency(time, place), thickness.mean(), speed.mean())

        def length(frequency, h, U):
            return U / (2 * frequency) / (viscosity / rho * h**2 * U / g)**0.25 if frequency else math.nan

        found.add(f"folds a second to each side, {viscosity} Pa s", exact[0], measured[0])
        found.add(f"length of a fold over (nu h^2 U/g)^(1/4), {viscosity} Pa s", length(*exact), length(*measured))
        lines.append((f"{viscosity} Pa s", time, 1e3 * place, style))
    found.plot("time, s", "place of the sheet, mm", *lines)


@experiment("hanging_sheet")
def hanging_sheet(found, one):
    fall, nu = 0.1, 0.1
    below, exact = theory.falling_thread_speed(4 / 3 * nu, 0.1, fall)  # Trouton viscosity: 4 nu for a sheet, 3 nu for a thread
    places = np.arange(0.005, 0.1, 0.005)
    late = [p for t, p in snapshots(one) if t > 1.3]
    depths, down = (np.concatenate([p[name] for p in late]) for name in ("y", "velocity_y"))
    speeds = np.array([-down[np.abs(fall - depths - z) < 0.003].mean() for z in places])
    for z in (0.045, 0.08):
        found.add(f"speed {1e3 * z:.0f} mm below the slot, m/s", np.interp(z, below, exact), np.interp(z, places, speeds))
    found.plot("distance from the slot, m", "speed, m/s", ("Whorl", places, speeds, "C0-"), ("theory", below, exact, "k--"), ylim=(0, 0.6))


@experiment("slump")
def slump(found, one):
    nu, area = 0.02, 0.0036
    heap = one.table("probes/heap.csv")
    time, front = heap["time"], heap["front"]
    exact = 1.411 * (g * area**3 / (3 * nu) * time)**0.2
    for t in (2, 8):
        found.add(f"front at {t} s, m", np.interp(t, time, exact), np.interp(t, time, front))
    late = time > 2
    found.add("exponent of time", 0.2, np.polyfit(np.log(time[late]), np.log(front[late]), 1)[0])
    found.plot("time, s", "front, m", ("Whorl", time, front, "C0-"), ("theory", time[1:], exact[1:], "k--"), ylim=(0, 0.25))


@experiment("fed_puddle", both_models)
def fed_puddle(found, runs):
    nu, Q, lines = 0.005, pi * 0.01**2 * 0.025, []
    for (words, one), style in zip(runs.items(), ("C0-", "C1-")):
        d, time, radius = spacing(one), [], []
        for t, p in snapshots(one):
            r, around = np.hypot(p["x"], p["z"]), np.arctan2(p["z"], p["x"])
            low = p["y"] < 2 * d
            parts = [r[low & (np.floor(8 * (around + pi) / pi) == k)] for k in range(16)]  # sectors
            if all(len(part) for part in parts):
                time.append(t)
                radius.append(np.mean([part.max() for part in parts]) + d / 2)
        time, radius = np.array(time), np.array(radius)
        late = time > time[-1] / 3
        exact = 0.715 * (g * Q**3 / (3 * nu))**0.125 * np.sqrt(time)
        found.add(f"radius at {time[-1]:g} s, {words}, m", exact[-1], radius[-1])
        found.add(f"exponent of time, {words}", 0.5, np.polyfit(np.log(time[late]), np.log(radius[late]), 1)[0])
        lines.append((f"Whorl, {words}", time, radius, style))
    found.plot("time, s", "radius of the puddle, m", *lines, ("theory", time, exact, "k--"))


def bessel_zeros(count):
    """Zeros of J1 by McMahon's expansion, within 2e-4."""
    b = (np.arange(1, count + 1) + 0.25) * pi
    return b - 3 / (8 * b) + 36 / (1536 * b**3)


slab = ["domain.dimensions=3", "domain.min=[-0.06,-0.06,-0.0125]", "domain.max=[0.06,0.06,0.0125]", "domain.periodic=[false,false,true]",
        "domain.gravity=[0,0,0]", "fluid.spacing=2.5e-3", "block[0].from=[0,0,-0.0125]", "block[0].to=[0,0,0.0125]",
        "solid[0].from=[0,0,-0.1]", "solid[0].to=[0,0,0.1]"]


@experiment("drum", {"plane, coupled": coupled, "plane, ppe and full": split, "slab, coupled": slab + coupled})
def drum(found, runs):
    R, nu, lines = 0.05, 1e-3, []
    zeros = bessel_zeros(60)

    def spun_up(t):
        return 1 - 8 * (np.exp(-nu * np.outer(t, zeros**2) / R**2) / zeros**2).sum(axis=1)

    for (words, one), style in zip(runs.items(), ("C0-", "C1-", "C2-")):
        d = one.table()
        *_, (_, p) = snapshots(one)
        inertia = rho * spacing(one)**(2 if "plane" in words else 3) * len(p["x"]) * R**2 / 2
        turned = d["angular_momentum_z"] / (4 * inertia)
        for t in (0.1, 0.5):
            found.add(f"angular momentum over a rigid body's at {t} s, {words}", spun_up([t])[0], np.interp(t, d["time"], turned))
        lines.append((f"Whorl, {words}", d["time"], turned, style))
    even = np.linspace(0, 0.5, 100)
    found.plot("time, s", "angular momentum, rigid body 1", *lines, ("theory", even, spun_up(even), "k--"), ylim=(0, 1.05))


@experiment("couette", both_models)
def couette(found, runs):
    a, b, omega, mu, lines = 0.025, 0.05, 4, 5, []
    B = omega / (1 / a**2 - 1 / b**2)

    def exact(r):
        return B * (1 / r - r / b**2)

    for (words, one), style in zip(runs.items(), ("C0o", "C1s")):
        line = one.table("probes/across.csv")
        last = line["time"] > 0.99
        r, u = line["x"][last], line["velocity_y"][last]
        found.add(f"speed in the middle of the gap, {words}, m/s", exact(0.0375), np.interp(0.0375, r, u))
        for name in ("inner", "outer"):
            solid = one.table(f"probes/{name}.csv")
            found.add(f"torque on the {name} cylinder, {words}, N m/m", 4 * pi * mu * B, abs(between(solid["time"], solid["torque_z"], 0.5, 1)))
        lines.append((f"Whorl, {words}", r, u, style))
    even = np.linspace(a, b, 50)
    found.plot("r, m", "speed, m/s", *lines, ("theory", even, exact(even), "k-"))


def hasimoto(c):
    """Drag on a ball of a cubic lattice over that on a single ball at the same mean velocity; c: volume fraction of the balls."""
    return 1 / (1 - 1.7601 * c**(1 / 3) + c - 1.5593 * c**2)


@experiment("balls", {radius: [f"solid[0].radius={radius}"] for radius in (0.015, 0.02, 0.025)})
def balls(found, runs):
    side, mu, points = 0.1, 100, []
    for radius, one in runs.items():
        d, c = one.table(), 4 * pi / 3 * (radius / side)**3
        U = d["momentum_x"][-1] / (rho * side**3)
        pushed = 0.5 * rho * side**3 * (1 - c)
        # Hasimoto's drag includes the force of the driving pressure on the ball
        points.append((c, pushed / (1 - c) / (6 * pi * mu * radius * U)))
        found.add(f"drag over 6 pi mu a U, radius {1e3 * radius:.0f} mm", hasimoto(c), points[-1][1])
        found.add(f"force on the ball over that on the fluid, radius {1e3 * radius:.0f} mm", 1,
                  between(*force(one, "force", "x"), 0.15, 0.2) / pushed)
    even = np.linspace(0.005, 0.08, 50)
    found.plot("share of the balls in the volume", "drag over 6 pi mu a U", ("theory", even, hasimoto(even), "k-"),
               ("Whorl", *np.array(points).T, "C0o"))
