"""Experiments with thick fluids: swelling jets, folding sheets, puddles, drums, balls."""
import math

import numpy as np

from . import theory
from .laboratory import Found, between, curves, experiment, force, published, run, snapshots, spacing

g, rho, pi = theory.gravity, 1000, math.pi


coupled, split = ["models.pressure=coupled"], ["models.pressure=ppe", "models.viscosity=full"]


@experiment("die_swell")
def die_swell(m):
    found, lines = Found(), []
    for shape, ratio, style in (("plane", 1.186, "C0-"), ("round", 1.127, "C1-")):
        one = run(m, f"die_swell_{shape}")
        found.runs.append(one)
        if m.dry:
            continue
        places = np.arange(0.5, 2.6, 0.1)  # from the end of the die, in its widths
        *_, (_, p) = snapshots(one)
        width = 0.01
        ratios = []
        for x in places:  # the piston's speed over that of the jet
            here = np.abs(p["x"] - x * width) < 0.15 * width
            area = 0.02 / np.hypot(p["velocity_x"], p["velocity_y"])[here].mean() if here.sum() > 10 else math.nan
            ratios.append(area if shape == "plane" else math.sqrt(area))
        found.add(f"thickness of the {shape} jet over that of the die", ratio, np.nanmean([r for x, r in zip(places, ratios) if 1 < x < 2]))
        lines += [(f"Whorl, {shape}", places, ratios, style), (f"published, {shape}", [0.5, 2.5], [ratio, ratio], style + "-")]
    found.draw = lambda axes: curves(axes, "distance from the die over its width", "thickness over the die's", *lines, ylim=(0.9, 1.4))
    return found


@experiment("folding_sheet")
def folding_sheet(m):
    """Folds from the sheet's place 45 mm below the slot, and its thickness and speed there."""
    found, sheet, lines = Found(), published("folding_sheet"), []
    for viscosity, *exact, style in zip(*(sheet[name] for name in ("viscosity", "frequency", "thickness", "speed")), ("C0-", "C1-", "C2-")):
        one = run(m, "folding_sheet", f"fluid.viscosity={viscosity:g}", name=f"{viscosity:g}")
        found.runs.append(one)
        if m.dry:
            continue
        d, rows = spacing(one), []
        for t, p in snapshots(one):
            here = np.abs(p["y"] - 0.055) < 0.003
            if t > 1 and here.sum() > 10:
                rows.append((t, p["x"][here].mean(), here.sum() * d**2 / 0.006, np.hypot(p["velocity_x"], p["velocity_y"])[here].mean()))
        time, place, thickness, speed = np.array(rows).T
        measured = (theory.frequency(time, place), thickness.mean(), speed.mean())

        def length(frequency, h, U):
            return U / (2 * frequency) / (viscosity / rho * h**2 * U / g)**0.25 if frequency else math.nan

        found.add(f"folds a second to each side, {viscosity:g} Pa s", exact[0], measured[0])
        found.add(f"length of a fold over (nu h^2 U/g)^(1/4), {viscosity:g} Pa s", length(*exact), length(*measured))
        lines.append((f"{viscosity:g} Pa s", time, 1e3 * place, style))
    found.draw = lambda axes: curves(axes, "time, s", "place of the sheet, mm", *lines)
    return found


@experiment("hanging_sheet")
def hanging_sheet(m):
    found, fall, nu = Found(), 0.1, 0.1
    one = run(m, "hanging_sheet")
    found.runs.append(one)
    if m.dry:
        return found
    below, exact = theory.falling_thread_speed(4 / 3 * nu, 0.1, fall)  # a sheet resists with 4 nu where a thread does with 3
    places = np.arange(0.005, 0.1, 0.005)
    late = [p for t, p in snapshots(one) if t > 1.3]
    depths, down = (np.concatenate([p[name] for p in late]) for name in ("y", "velocity_y"))
    speeds = np.array([-down[np.abs(fall - depths - z) < 0.003].mean() for z in places])
    for z in (0.045, 0.08):
        found.add(f"speed {1e3 * z:.0f} mm below the slot, m/s", np.interp(z, below, exact), np.interp(z, places, speeds))
    found.draw = lambda axes: curves(axes, "distance from the slot, m", "speed, m/s", ("Whorl", places, speeds, "C0-"), ("theory", below, exact, "k--"),
                                     ylim=(0, 0.6))
    return found


@experiment("slump")
def slump(m):
    found, nu, area = Found(), 0.02, 0.0036
    one = run(m, "slump")
    found.runs.append(one)
    if m.dry:
        return found
    heap = one.table("probes/heap.csv")
    time, front = heap["time"], heap["front"]
    exact = 1.411 * (g * area**3 / (3 * nu) * time)**0.2
    for t in (2, 8):
        found.add(f"front at {t} s, m", np.interp(t, time, exact), np.interp(t, time, front))
    late = time > 2
    found.add("power of time", 0.2, np.polyfit(np.log(time[late]), np.log(front[late]), 1)[0])
    found.draw = lambda axes: curves(axes, "time, s", "front, m", ("Whorl", time, front, "C0-"), ("theory", time[1:], exact[1:], "k--"),
                                     ylim=(0, 0.25))
    return found


@experiment("fed_puddle")
def puddle(m):
    found, nu, Q, lines = Found(), 0.005, pi * 0.01**2 * 0.025, []
    for words, settings, style in (("coupled", coupled, "C0-"), ("ppe and full", split, "C1-")):
        one = run(m, "fed_puddle", *settings, name=words.split()[0])
        found.runs.append(one)
        if m.dry:
            continue
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
        found.add(f"power of time, {words}", 0.5, np.polyfit(np.log(time[late]), np.log(radius[late]), 1)[0])
        lines.append((f"Whorl, {words}", time, radius, style))
    found.draw = lambda axes: curves(axes, "time, s", "radius of the puddle, m", *lines, ("theory", time, exact, "k--"))
    return found


def bessel_zeros(count):
    """Of J1, by McMahon's expansion: within 2e-4."""
    b = (np.arange(1, count + 1) + 0.25) * pi
    return b - 3 / (8 * b) + 36 / (1536 * b**3)


@experiment("drum")
def drum(m):
    found, R, nu, lines = Found(), 0.05, 1e-3, []
    zeros = bessel_zeros(60)

    def spun_up(t):
        return 1 - 8 * (np.exp(-nu * np.outer(t, zeros**2) / R**2) / zeros**2).sum(axis=1)

    slab = ["domain.dimensions=3", "domain.min=[-0.06,-0.06,-0.0125]", "domain.max=[0.06,0.06,0.0125]", "domain.periodic=[false,false,true]",
            "domain.gravity=[0,0,0]", "fluid.spacing=2.5e-3", "block[0].from=[0,0,-0.0125]", "block[0].to=[0,0,0.0125]",
            "solid[0].from=[0,0,-0.1]", "solid[0].to=[0,0,0.1]"]
    for words, settings, style in (("plane, coupled", coupled, "C0-"), ("plane, ppe and full", split, "C1-"), ("slab, coupled", slab + coupled, "C2-")):
        one = run(m, "drum", *settings, name=words.replace(", ", "-").replace(" ", "_"))
        found.runs.append(one)
        if m.dry:
            continue
        d = one.table()
        *_, (_, p) = snapshots(one)
        inertia = rho * spacing(one)**(2 if "plane" in words else 3) * len(p["x"]) * R**2 / 2
        turned = d["angular_momentum_z"] / (4 * inertia)
        for t in (0.1, 0.5):
            found.add(f"angular momentum over a rigid body's at {t} s, {words}", spun_up([t])[0], np.interp(t, d["time"], turned))
        lines.append((f"Whorl, {words}", d["time"], turned, style))
    even = np.linspace(0, 0.5, 100)
    found.draw = lambda axes: curves(axes, "time, s", "angular momentum, rigid body 1", *lines, ("theory", even, spun_up(even), "k--"),
                                     ylim=(0, 1.05))
    return found


@experiment("couette")
def couette(m):
    found, a, b, omega, mu, lines = Found(), 0.025, 0.05, 4, 5, []
    B = omega / (1 / a**2 - 1 / b**2)

    def exact(r):
        return B * (1 / r - r / b**2)

    for words, settings, style in (("coupled", coupled, "C0o"), ("ppe and full", split, "C1s")):
        one = run(m, "couette", *settings, name=words.split()[0])
        found.runs.append(one)
        if m.dry:
            continue
        line = one.table("probes/across.csv")
        last = line["time"] > 0.99
        r, u = line["x"][last], line["velocity_y"][last]
        found.add(f"speed in the middle of the gap, {words}, m/s", exact(0.0375), np.interp(0.0375, r, u))
        for name in ("inner", "outer"):
            solid = one.table(f"probes/{name}.csv")
            found.add(f"torque on the {name} cylinder, {words}, N m/m", 4 * pi * mu * B, abs(between(solid["time"], solid["torque_z"], 0.5, 1)))
        lines.append((f"Whorl, {words}", r, u, style))
    even = np.linspace(a, b, 50)
    found.draw = lambda axes: curves(axes, "r, m", "speed, m/s", *lines, ("theory", even, exact(even), "k-"))
    return found


def hasimoto(c):
    """Drag on a ball of a cubic lattice over that on one alone at the same mean velocity; c: the balls' share of the volume."""
    return 1 / (1 - 1.7601 * c**(1 / 3) + c - 1.5593 * c**2)


@experiment("balls")
def balls(m):
    found, side, mu, points = Found(), 0.1, 100, []
    for radius in (0.015, 0.02, 0.025):
        one = run(m, "balls", f"solid[0].radius={radius}", name=f"{1e3 * radius:.0f}")
        found.runs.append(one)
        if m.dry:
            continue
        d, c = one.table(), 4 * pi / 3 * (radius / side)**3
        U = d["momentum_x"][-1] / (rho * side**3)
        pushed = 0.5 * rho * side**3 * (1 - c)
        # Hasimoto's drag counts what a pressure that drives the fluid does to the ball, too
        points.append((c, pushed / (1 - c) / (6 * pi * mu * radius * U)))
        found.add(f"drag over 6 pi mu a U, radius {1e3 * radius:.0f} mm", hasimoto(c), points[-1][1])
        found.add(f"force on the ball over that on the fluid, radius {1e3 * radius:.0f} mm", 1,
                  between(*force(one, "force", "x"), 0.15, 0.2) / pushed)
    even = np.linspace(0.005, 0.08, 50)
    found.draw = lambda axes: curves(axes, "share of the balls in the volume", "drag over 6 pi mu a U", ("theory", even, hasimoto(even), "k-"),
                                     ("Whorl", *np.array(points).T, "C0o"))
    return found
