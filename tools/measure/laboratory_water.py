"""Experiments with water: dams, posts, waves, jets, an impact."""
import math

import numpy as np

from . import theory
from .laboratory import between, depth, experiment, force, published, snapshots, spacing, swing

g, rho = theory.gravity, 1000


def arrival(T, p, enough=0.05):
    """First time at which a signal exceeds `enough`."""
    return T[int(np.argmax(p > enough))]


@experiment("dam_pressures")
def dam_pressures(found, one):
    experiment_means, lines = published("dam_pressures"), []
    for height, mean, colour in zip(experiment_means["height"], experiment_means["mean_pressure"], ("C0", "C1", "C2")):
        gauge = one.table(f"probes/at_{1e3 * height:.0f}_mm.csv")
        T, p = gauge["time"] * math.sqrt(g / 0.3), gauge["pressure"] / (rho * g * 0.3)
        if not lines:
            found.add("front meets the wall, t sqrt(g/H)", 2.43, arrival(T, p))
        found.add(f"pressure at {1e3 * height:.0f} mm over rho g H, T = 3.2 to 4.2", mean, between(T, p, 3.2, 4.2))
        lines += [(f"{1e3 * height:.0f} mm", T, p, colour + "-"), (None, [3.2, 4.2], [mean, mean], colour + "--")]
    found.plot("t sqrt(g/H)", "pressure over rho g H", *lines, xlim=(2, 4.8), ylim=(0, 3))


@experiment("dam_disc")
def dam_disc(found, one):
    curve, second, pascal = published("dam_disc"), math.sqrt(0.6 / g), rho * g * 0.6
    gauge = one.table("probes/disc.csv")
    (T, p), (Te, pe) = ((c["time"] / second, c["pressure"] / pascal) for c in (gauge, curve))
    found.add("first pressure of .1 rho g H, t sqrt(g/H)", arrival(Te, pe, 0.1), arrival(T, p, 0.1))
    for start, end in ((2.8, 3.4), (3.4, 5.2)):
        found.add(f"mean pressure over rho g H, T = {start:g} to {end:g}", np.interp(np.linspace(start, end, 50), Te, pe).mean(),
                  between(T, p, start, end))
    found.plot("t sqrt(g/H)", "pressure over rho g H", ("Whorl", T, p, "C0-"), ("experiment", Te, pe, "ko"),
               xlim=(2, 7.3), ylim=(-0.1, 1.6))


@experiment("column_square", {"free of friction": (), "floor that sticks": ("solid[0].slip=no", "fluid.viscosity=1e-3")})
def column_square(found, runs):
    a, lines = 0.05715, []
    second, table = math.sqrt(a / g), published("column_square")

    def reported(name, style):
        known = ~np.isnan(table[name])
        return f"experiment, {name}", table["time"][known] / second, table[name][known] / a, style

    for (words, one), style in zip(runs.items(), ("C0-", "C1-")):
        water, d = one.table("probes/water.csv"), spacing(one)
        T, Z = water["time"] / second, water["front"] / a
        H = np.array([depth(p, 0, 0.2 * a, d) * 2 / a for _, p in snapshots(one)])  # at the wall
        times = np.interp([1.67, 4.11], Z, T)
        found.add(f"speed of the front over sqrt(g a), {words}", 2.44 / (2.71 - 0.97), 2.44 / (times[1] - times[0]))
        found.add(f"height at T = 2.57 over a, {words}", 0.44, np.interp(2.57, T, H))
        lines += [(f"front, {words}", T, Z, style), (f"height, {words}", T, H, style + "-")]
    found.plot("t sqrt(g/a)", "front and height over a", *lines, reported("front", "ko"), reported("height", "k^"), xlim=(0, 6.3), ylim=(0, 6))


@experiment("square_post")
def square_post(found, one):
    curve = published("square_post")
    t, F = force(one, "force", "x")
    F = 2 * F  # on the whole post: the scene contains one half
    found.add("impact (force of 5 N), s", np.interp(5, curve["force"][:8], curve["time"][:8]), arrival(t, F, 5))
    found.add("mean force .5 to .7 s, N", between(curve["time"], curve["force"], 0.5, 0.7), between(t, F, 0.5, 0.7))
    later = t[1] - t[0]
    even = np.arange(0.3, 1.2, later)
    found.add("impulse to 1.2 s, N s", np.interp(even, curve["time"], curve["force"]).sum() * later, F[(t > 0.2) & (t <= 1.2)].sum() * later)
    found.plot("time, s", "force on the post, N", ("Whorl", t, F, "C0-"), ("experiment", curve["time"], curve["force"], "ko"))


def wavenumber(omega, h):
    k = omega**2 / g
    for _ in range(200):
        k = (k + omega**2 / (g * math.tanh(k * h))) / 2
    return k


def height_over_stroke(kh):
    return 2 * (math.cosh(2 * kh) - 1) / (math.sinh(2 * kh) + 2 * kh)


@experiment("wavemaker", {period: [f'solid[2].position=["0.015*(1-cos(2*pi*t/{period}))", "0"]'] for period in (0.8, 0.95, 1.1)})
def wavemaker(found, runs):
    h, points = 0.25, []
    for period, one in runs.items():
        omega = 2 * math.pi / period
        k = wavenumber(omega, h)
        group = omega / k / 2 * (1 + 2 * k * h / math.sinh(2 * k * h))
        places, d = (1.0, 3.0), spacing(one)
        time, depths = zip(*((t, [depth(p, x, 6 * d, d) for x in places]) for t, p in snapshots(one)))
        time, heights = np.array(time), []
        for x, values in zip(places, np.array(depths).T):  # from two periods after the front has passed to the return of its reflection
            steady = (time > x / group + 2 * period) & (time < (10 - x) / group)
            heights.append(2 * swing(time[steady], values[steady], omega))
        points.append((k * h, heights[0] / 0.03, heights[1] / 0.03))
        found.add(f"height over stroke at 1 m, period {period} s", height_over_stroke(k * h), heights[0] / 0.03)
        found.add(f"height at 3 m over height at 1 m, period {period} s", 1, heights[1] / heights[0])
    kh = np.linspace(0.5, 2, 50)
    found.plot("k h", "wave height over stroke", ("linear theory", kh, [height_over_stroke(x) for x in kh], "k-"),
               ("Whorl, 1 m from the piston", *np.array(points).T[:2], "C0o"),
               ("Whorl, 3 m from the piston", *np.array(points).T[[0, 2]], "C1s"))


@experiment("bore")
def bore(found, one):
    h, u = 0.1, 0.7
    ratios = np.linspace(1.01, 3, 20000)
    speeds = np.sqrt(g * h * ratios * (1 + ratios) / 2)
    r, c = (float(np.interp(u, speeds * (1 - 1 / ratios), values)) for values in (ratios, speeds))
    d, x, fronts = spacing(one), np.arange(0.025, 3, 0.05), []
    for t, p in snapshots(one):
        depths = np.array([depth(p, place, 0.05, d) for place in x])
        high = np.flatnonzero(depths > h * (1 + r) / 2)
        if t > 0.6 and len(high):
            k = high[-1]
            fronts.append((t, np.interp(-h * (1 + r) / 2, -depths[k:k + 2], x[k:k + 2]), depths))
    time, place = np.array([(t, f) for t, f, _ in fronts]).T
    behind = (x > 0.7 * time[-1] + 0.1) & (x < place[-1] - 0.3)
    found.add("depth behind the bore over that before it", r, np.mean([depths[behind].mean() / h for _, _, depths in fronts[-5:]]))
    found.add("speed of the bore, m/s", c, np.polyfit(time, place, 1)[0])
    found.plot("x, m", "depth, m", ("Whorl, 1.6 s", x, fronts[-1][2], "C0-"),
               ("theory", [0.7 * 1.6 - 0.035, c * 1.55, c * 1.55, 3], [r * h, r * h, h, h], "k--"), ylim=(0, 0.25))


@experiment("slit")
def slit(found, one):
    head, width, b = 0.3, 0.4, 0.04
    tank = one.table("probes/tank.csv")
    t, h = tank["time"], tank["mass"] / (rho * width)
    late = t > 0.2
    # sqrt(h) falls as c b/W sqrt(g/2) t
    found.add("contraction of the jet", math.pi / (math.pi + 2), -np.polyfit(t[late], np.sqrt(h[late]), 1)[0] * width / b / math.sqrt(g / 2))
    exact = (math.sqrt(head) - math.pi / (math.pi + 2) * b / width * math.sqrt(g / 2) * t)**2
    found.add("depth left after 1.2 s, m", exact[-1], h[-1])
    found.plot("time, s", "depth in the tank, m", ("Whorl", t, h, "C0-"), ("theory", t, exact, "k--"))


@experiment("jet_on_plate", {angle: [f"solid[0].tilt=[0,0,{angle - 90}]"] for angle in (90, 60, 45)})
def jet_on_plate(found, runs):
    b, U, points = 0.04, 1, []
    for angle, one in runs.items():
        (t, x), (_, y) = force(one, "force", "x"), force(one, "force", "y")
        turned = math.radians(angle - 90)
        across = math.sin(turned) * x - math.cos(turned) * y
        points.append((angle, between(t, across, 0.35, 0.6)))
        found.add(f"force across the plate at {angle} degrees, N/m", rho * b * U**2 * math.sin(math.radians(angle)), points[-1][1])
    even = np.linspace(30, 90, 50)
    found.plot("angle of jet and plate, degrees", "force across the plate, N/m",
               ("theory", even, rho * b * U**2 * np.sin(np.radians(even)), "k-"), ("Whorl", *np.array(points).T, "C0o"))


@experiment("wedge_entry")
def wedge_entry(found, one):
    V = 5
    t, F = force(one, "force", "y")
    F = 2 * F  # on both sides: the scene contains one
    rise = 14.139 * rho * V**3
    for start, end in ((0, 0.02), (0.02, 0.04)):
        found.add(f"mean force {1e3 * start:.0f} to {1e3 * end:.0f} ms, N/m", rise * (start + end) / 2, between(t, F, start + 1e-4, end + 1e-4))
    found.plot("time, ms", "force on the wedge, kN/m", ("Whorl", 1e3 * t, F / 1e3, "C0-"), ("theory", [0, 40], [0, rise * 4e-5], "k--"))
