"""Gentle free surfaces: waves and drops against linear theory and exact solutions."""
import math

import numpy as np

from . import theory
from .registry import markdown, percent, table
from .vortices import cost, flow

pi = math.pi


@table("standing_wave", "a standing wave against linear theory", "1 minute")
def standing_wave(m):
    rows, k = [], 2 * pi / 0.4
    # omega^2 = (g k + sigma k^3/rho) tanh kh with surface tension sigma. At 40 N/m both terms are equal.
    for spacing, tension in ((0.01, 0), (0.005, 0), (0.01, 40), (0.005, 40)):
        if not m.wanted(f"{spacing}-{tension}"):
            continue
        run = flow(m, "standing_wave", f"{spacing}-{tension}", f"fluid.spacing={spacing}", f"fluid.surface_tension={tension}")
        period = 2 * pi / math.sqrt((theory.gravity * k + tension * k**3 / 1000) * math.tanh(k * 0.2))
        words = f"{0.2 / spacing:.0f} layers" + (f", {tension} N/m" if tension else "")
        probe = run.table("probes/crest.csv")
        zeros = theory.zeros(probe["time"], probe["velocity_y"], period / 4)
        if len(zeros) < 11:
            rows.append([words, "5 %" if tension else "2, 5 %", "fewer than five periods", "", *cost(run)])
            continue
        peaks = [np.abs(probe["velocity_y"][(probe["time"] > a) & (probe["time"] < b)]).max() for a, b in zip([-1, *zeros], zeros)]
        decay = math.exp(-2e-4 * k**2 * 5 * period)
        rows.append([words, "5 %" if tension else "2, 5 %", f"{(zeros[10] - zeros[0]) / 5 / period:.4f}",
                     f"{peaks[10] / peaks[0] / decay:.3f}", *cost(run)])
    return markdown("case | bound for period, amplitude | period over theory | amplitude after five periods over theory | steps | CPU s", rows)


def ellipse(times, a=0.15, b=0.15, A=1.0, dt=1e-4):
    """Half-axes of the drop u = (-A x, A y): a' = -A a, b' = A b, A' = A^2 (a^2 - b^2)/(a^2 + b^2)."""
    found, time = [], 0.0

    def rates(s):
        a, b, A = s
        return np.array([-A * a, A * b, A**2 * (a**2 - b**2) / (a**2 + b**2)])

    s = np.array([a, b, A])
    for until in times:
        while time < until - dt / 2:
            s = s + dt * rates(s + dt / 2 * rates(s))
            time += dt
        found.append(s[:2])
    return found


@table("elliptic_drop", "half-axes of a drop that stretches into an ellipse", "1 minute")
def elliptic_drop(m):
    rows, times = [], (0.5, 1, 1.5)
    forms = (("constraint", []), ("projection", ["pressure.form=projection", "fluid.support=3", "models.shifting=none"]))
    for form, settings in forms:
        for words, spacing in (("1160 particles", 0.0078), ("4600 particles", 0.0039)):
            run = flow(m, "elliptic_drop", f"{form}-{spacing}", f"fluid.spacing={spacing}", *settings, options=["--export", "points"])
            cells = []
            for t, exact in zip(times, ellipse(times)):
                if not m.dry:
                    axes = 2 * np.sqrt((run.points(round(20 * t) + 1)[:, :2].astype(float)**2).mean(axis=0))
                    cells.append(", ".join(f"{100 * (axis / e - 1):+.2f} %" for axis, e in zip(axes, exact)))
            energy = run.table()["kinetic_energy"]
            rows.append([f"{form}, {words}", "1.5 %", *cells, f"{energy[-1] / energy[0]:.4f}", *cost(run)])
    return markdown("case | bound | half-axes off theory at 0.5 s | 1 s | 1.5 s (1 : 9) | final over initial energy | steps | CPU s", rows)


@table("swinging_drop", "a drop with surface tension under the projection: pressure, rest and oscillation", "10 minutes")
def swinging_drop(m):
    rows, sigma, rho, radius = [], 0.072, 1000, 5e-3
    space = ["domain.dimensions=3", "domain.gravity=[0,0,0]", "domain.min=[-0.01,-0.01,-0.01]", "domain.max=[0.01,0.01,0.01]",
             "probe.0.min=[0,0,-0.01]", "probe.0.max=[0.01,0.01,0.01]", "probe.1.at=[0,0,0]", 'block.0.velocity=["1.5*x","-3*y","1.5*z"]']
    for words, ways, spacing, settings in (("2D", 1, 4e-4, []), ("2D", 1, 2e-4, []), ("3D", 2, 6.25e-4, space),
                                           ("3D", 2, 4.5e-4, space)):
        if not m.wanted(f"{words}-{spacing}"):
            continue
        still = flow(m, "swinging_drop", f"{words}-{spacing}-still", f"fluid.spacing={spacing}", *settings,
                     f"block.0.velocity={[0] * (ways + 1)}", "time.end=0.1")
        run = flow(m, "swinging_drop", f"{words}-{spacing}", f"fluid.spacing={spacing}", *settings)
        if m.dry:
            continue
        d = still.table()
        count = d["particles"][-1]
        R = math.sqrt(count * spacing**2 / pi) if ways == 1 else (3 * count * spacing**3 / 4 / pi)**(1 / 3)
        probe = still.table("probes/middle.csv")
        late = probe["time"] > 0.05
        inside = probe["pressure"][late].mean() * R / (ways * sigma)
        speed = math.sqrt(2 * d["kinetic_energy"][-1] / (count * rho * spacing**(ways + 1))) * math.sqrt(rho * R / sigma)
        omega = math.sqrt((6 if ways == 1 else 8) * sigma / (rho * R**3))
        probe = run.table("probes/quarter.csv")
        signal = probe["velocity_x"] - probe["velocity_y"]
        zeros = theory.zeros(probe["time"], signal, pi / omega / 2)
        peaks = [np.abs(signal[(probe["time"] > a) & (probe["time"] < b)]).max() for a, b in zip(zeros, zeros[1:])]
        rows.append([f"{words}, R = {R / spacing:.1f} d", f"{inside:.3f}", percent(speed, 1), f"{(zeros[4] - zeros[0]) / 2 * omega / 2 / pi:.3f}",
                     f"{(peaks[3] / peaks[1]):.2f}", *cost(run)])
    return markdown("drop | pressure over theory | speed at rest over sqrt(sigma/(rho R)) | period over theory | amplitude left after a period | "
                    "steps | CPU s", rows)
