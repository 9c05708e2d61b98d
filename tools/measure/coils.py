"""Coils compared with slender-thread theory, falling threads, the sewing machine."""
import math

import numpy as np

from . import drawing, theory
from .registry import markdown, off, percent, table
from .runs import attempt, number, read_rows, root


def theory_rows():
    """Rows of scenes/studies/coil_theory.csv by their number."""
    rows = read_rows(root / "scenes/studies/coil_theory.csv")
    return {k: {name: cell if name == "regime" else number(cell) for name, cell in row.items()} for k, row in enumerate(rows, 1)}


def coil(m, row, spacing, turns=7):
    """Last row of the coil probe, and the run, for a coil on a plate. @param row of coil_theory.csv"""
    c = theory_rows()[row]
    f, R, down = c["frequency"], c["radius"], c["fall"] / c["speed"]  # `down` is an upper bound for the time of the fall
    # The plate moves on a circle of the coil's radius, which shrinks to 0 between 0.5 and 1.5 turns after `down`. The drain removes laid
    # thread after 0.6 of a turn.
    circle, phase = f"{R:.6g}*max(0, min(1, ({down + 1.5 / f:.6g}-t)*{f:.6g}))", f"({2 * math.pi * f:.6g}*t)"
    run = m.render("scenes/studies/coil_on_plate.toml", f"coils/row{row}-{spacing:g}-{turns}", f"fluid.spacing={spacing:g}",
                   f"fluid.viscosity={1000 * c['viscosity']:g}", f"emitter[0].speed={c['speed']:g}",
                   f"emitter[0].position=[0, {c['fall']:g}, 0]", f"drain[0].delay={0.6 / f:.6g}", f"time.end={down + turns / f:.6g}",
                   f'solid[0].position=["{circle}*cos{phase}", "0", "{circle}*sin{phase}"]')
    return run.last("probes/coil.csv"), run


def against(p, expected, digits=(3, 2)):
    """Cells of frequency [Hz] and radius [mm]: measured, uncertainty, theory, relative difference."""
    cells = []
    for name, unit, n in (("frequency", 1, digits[0]), ("radius", 1e3, digits[1])):
        value, spread, exact = (unit * x for x in (p[name], p[f"{name}_uncertainty"], expected[name]))
        cells += [f"{value:.{n}f}", f"{spread:.{n}f}", f"{exact:.{n}f}", off(value, exact, 1)]
    return cells


def coil_table(m, cases):
    """Table of coils compared with theory. @param cases tuples (row of coil_theory.csv, spacing [m], turns)"""
    rows = []
    for row, spacing, turns in cases:
        c = theory_rows()[row]

        def measure():
            p, run = coil(m, row, spacing, turns)
            return [*against(p, c), f"{p['turns']:.1f}", f"{run.cpu_seconds:.0f}"]

        if m.wanted(row):
            words = [row, c["regime"], f"{c['speed']:g}", f"{1000 * c['fall']:g}", f"{c['viscosity']:g}"]
            rows.append([*words, *attempt(measure)])
    return markdown("row | regime | speed [m/s] | fall [mm] | viscosity [m^2/s] | frequency [Hz] | +- | theory | off | radius [mm] | +- | "
                    "theory | off | turns | CPU s", rows)


@table("coils", "fourteen coils on a plate, 2 mm, compared with slender-thread theory", "20 minutes")
def coils(m):
    return coil_table(m, [(row, 2e-3, 7) for row in theory_rows()])


fine_turns = {2: 7, 5: 6, 7: 7, 8: 7, 9: 7, 13: 7, 14: 7}


@table("coils_fine", "seven of the coils on a plate, 1.25 mm, compared with slender-thread theory", "half an hour")
def coils_fine(m):
    return coil_table(m, [(row, 1.25e-3, turns) for row, turns in fine_turns.items()])


@table("coils_laid_speed", "speed and thickness of the laid thread", "no time after coils and coils_fine")
def coils_laid_speed(m):
    rows = []
    for row, c in theory_rows().items():
        laid = 2 * math.pi * c["radius"] * c["frequency"]  # theoretical speed of the thread at the contact
        slenderness = 5e-3 * math.sqrt(c["speed"] / laid) / c["radius"]

        def excess(spacing, turns):
            p, _ = coil(m, row, spacing, turns)
            return p["radius"] * p["frequency"] / (c["radius"] * c["frequency"]) - 1

        if m.wanted(row):
            coarse = excess(2e-3, 7)
            fine = percent(excess(1.25e-3, fine_turns[row]), 1) if row in fine_turns else ""
            rows.append([row, f"{slenderness:.2f}", percent(coarse, 1), fine, f"{coarse / slenderness**2:.1f}"])
    return markdown("row | a/R | 2 pi R f/U1 - 1, 2 mm | 2 pi R f/U1 - 1, 1.25 mm | (2 pi R f/U1 - 1)/(a/R)^2, 2 mm", rows)


@table("coils_on_heap", "a coil on its own heap on a sinking plate, by spacing", "4 minutes")
def coils_on_heap(m):
    rows = []
    for spacing in (2.5e-3, 2e-3):
        p = m.render("scenes/studies/steady_coil.toml", f"coils/heap-{spacing:g}", f"fluid.spacing={spacing:g}").last("probes/coil.csv")
        expected = {"frequency": p["theory_frequency"], "radius": p["theory_radius"]}
        rows.append([f"{1000 * spacing:g} mm", f"{1000 * p['fall']:.1f}", *against(p, expected, (2, 1))])
    return markdown("spacing | fall [mm] | frequency [Hz] | +- | theory | off | radius [mm] | +- | theory | off", rows)


@table("honey_coil_qualities", "the coil of scenes/thick_coil.toml at draft, standard and fine", "15 minutes")
def honey_coil_qualities(m):
    rows = []
    for quality, seeds in (("draft", (1, 2, 3)), ("standard", (1, 2, 3)), ("fine", (1,))):
        for seed in seeds:
            if not m.wanted(f"{quality}-{seed}"):
                continue
            run = m.render("scenes/thick_coil.toml", f"coils/thick-{quality}-{seed}", f"seed={seed}", options=["--quality", quality])
            columns = run.table("probes/coil.csv")
            pours = np.isfinite(columns["theory_frequency"])  # theory exists while honey flows
            p = {name: values[pours][-1] if pours.any() else math.nan for name, values in columns.items()}
            if m.dry:
                continue
            expected = {"frequency": p["theory_frequency"], "radius": p["theory_radius"]}
            rows.append([quality, seed, f"{1000 * p['fall']:.1f}", *against(p, expected, (2, 1)), f"{run.report['cpu_seconds']:.0f}"])
    return markdown("quality | seed | fall [mm] | frequency [Hz] | +- | theory | off | radius [mm] | +- | theory | off | CPU s", rows)


@table("coil_convergence", "frequency and radius over theory by spacing, for row 2 of coils", "15 minutes",
       files="docs/pictures/coil_convergence.svg")
def coil_convergence(m):
    points, c = [], theory_rows()[2]
    for spacing in (2.5e-3, 2e-3, 1.5e-3, 1.25e-3):
        p, _ = coil(m, 2, spacing)
        points.append([1e3 * spacing, *(100 * p[name + part] / c[name]
                                        for name in ("frequency", "radius") for part in ("", "_uncertainty"))])
    mm, f, df, R, dR = np.array(points).T

    def draw(axes):
        axes.axhspan(90, 110, color="#eef3e6", lw=0)
        axes.axhline(100, color="#555", lw=1)
        axes.errorbar(mm - 0.015, f, df, fmt="o", color="#1f5fa8", label="frequency")
        axes.errorbar(mm + 0.015, R, dR, fmt="o", color="#b8432f", label="radius")
        axes.set(xlim=(0, 3), ylim=(80, 120), xlabel="particle spacing [mm]; nozzle radius 5 mm",
                 ylabel="coil over slender-thread theory [%]")
        axes.legend(frameon=False, ncols=2)

    m.write("docs/pictures/coil_convergence.svg", drawing.figure(5.8, 3.9, draw))
    return "![Frequency and radius of row 2 over theory against the spacing](../pictures/coil_convergence.svg)"


@table("falling_thread", "a thread that falls 0.25 m: draw, radius and longest link compared with one-dimensional theory", "3 minutes")
def falling_thread(m):
    speed, radius, heights = 0.1, 5e-3, [10, 30, 50, 90, 130, 170, 210, 230]  # m/s, m, mm
    slices = [{"name": f"at_{mm}", "kind": "region", "min": [-0.05, -(mm + 10) / 1e3, -0.05], "max": [0.05, -(mm - 10) / 1e3, 0.05]}
              for mm in heights]
    overlay = m.toml_file("falling_thread/slices", {"seed": 1, "time": {"end": 2.4}, "probe": slices, "output": {"export": ["points"]}})
    run = m.render("scenes/studies/falling_thread.toml", "falling_thread/run", options=["--with", overlay])
    clouds = [] if m.dry else [x[x[:, 1] < 0] for x in map(run.points, range(101, 122))]  # from 2 s on, 50 frames a second
    z, u = theory.falling_thread_speed(0.05, speed, 0.25)
    rows = []
    for mm in heights:
        probe = run.table(f"probes/at_{mm}.csv")
        steady = ~(probe["time"] < 2)
        draw = -probe["velocity_y"][steady].mean() / speed
        expected = 1 / (1 / u[abs(z - mm / 1e3) <= 0.01]).mean() / speed
        a = math.sqrt(probe["mass"][steady].mean() / (1000 * math.pi * 0.02))
        link = max((theory.longest_link(x[x[:, 1] > -(mm + 10) / 1e3]) for x in clouds), default=math.nan) / 2e-3
        rows.append([f"{mm} mm", f"{draw:.2f}", f"{expected:.2f}", f"{a / (radius / math.sqrt(expected)):.3f}", f"{link:.1f} d"])
    return markdown("below the nozzle | draw u/U | theory | radius over theory | longest link", rows)


def sewing_patterns(m, ratios, spacing):
    """Table of the pattern at each ratio of belt speed V to landing speed Uc, from the thread's centroid above the belt in the last 2 s:

    straight if its standard deviation across the belt (z) is at most 1 mm; coils if its frequencies along (x) and across the belt agree
    within 15 %; loops if at some time it moves in the belt's direction faster than V; otherwise meanders."""
    landing, rows = 0.240, []  # m/s, in theory; there the thread is 1.02 times as thick as at the nozzle
    for ratio in filter(m.wanted, ratios):
        V = ratio * landing

        def measure():
            probe = m.render("scenes/studies/sewing_machine_study.toml", f"sewing_machine/{ratio:g}-{spacing:g}", f"fluid.spacing={spacing:g}",
                             f'solid[0].position=["-{V:g}*t", "0", "0"]').table("probes/thread.csv")
            late = ~(probe["time"] < probe["time"][-1] - 2)
            t, x, z = (probe[name][late] for name in ("time", "centroid_x", "centroid_z"))
            fx, fz, back = theory.frequency(t, x), theory.frequency(t, z), max(-np.diff(x) / np.diff(t)) / V
            cells = [f"{1414 * z.std():.1f}", f"{1414 * x.std():.1f}", f"{back:.1f}"]
            if not z.std() > 1e-3:
                return ["", "", *cells, "straight"]
            pattern = "translated coils" if 0.85 * fz < fx < 1.15 * fz else "alternating loops" if back > 1 else "meanders"
            return [f"{fz:.2f}", f"{fx / fz:.2f}" if fz else "", *cells, pattern]

        expected = "coils" if ratio < 0.29 else "loops" if ratio < 0.54 else "meanders" if ratio < 1 else "straight"
        rows.append([f"{ratio:g}", expected, *attempt(measure)])
    return markdown("V/Uc | expected | frequency across [Hz] | frequency along over across | amplitude across [mm] | "
                    "amplitude along [mm] | speed with the belt over V | pattern", rows)


@table("sewing_machine", "the pattern of a thread on a belt, nine speeds", "20 minutes")
def sewing_machine(m):
    return sewing_patterns(m, [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.8, 1.0, 1.2], 2.5e-3)


@table("sewing_machine_coarse", "the pattern of a thread on a belt with 1.5 particles across the nozzle's radius, five speeds", "5 minutes")
def sewing_machine_coarse(m):
    return sewing_patterns(m, [0.2, 0.4, 0.6, 0.8, 1.1], 3.3e-3)
