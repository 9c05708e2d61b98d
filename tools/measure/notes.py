"""The systems as printed in the source papers: density as source, full viscosity, micropolar system, gate."""
import math

import numpy as np

from . import theory
from .registry import markdown, percent, table
from .runs import Run
from .vortices import spinning

pi = math.pi


@table("published_viscosity", "decay of a shear wave with full viscosity, by support, uncorrected and with corrected gradients", "1 minute")
def published_viscosity(m):
    rows, nu = [], 0.1
    for support in (2, 2.5, 3, 4):
        cells = []
        for corrected in ("false", "true"):
            for across in (16, 32):
                run = m.render("scenes/studies/shear_wave.toml", f"notes/viscosity-{support}-{corrected}-{across}", f"fluid.support={support}",
                               f"fluid.spacing={1 / across}", f"viscosity.correction={corrected}")
                d = run.table()
                decay = math.log(d["kinetic_energy"][0] / d["kinetic_energy"][-1])
                cells.append(f"{decay / (2 * nu * (2 * pi)**2 * d['time'][-1]):.3f}")
        rows.append([f"{support:g} d", *cells])
    return markdown("support | uncorrected, 16 per wavelength | 32 | corrected gradients, 16 per wavelength | 32", rows)


@table("published_pressure", "water at rest with the density as source, by share of the correction and multigrid cycle", "3 minutes")
def published_pressure(m):
    rows, depth = [], 0.2
    for correction in (0.1, 1):
        for cycle in ("v_cycle", "additive"):
            run = m.render("scenes/studies/published_pressure.toml", f"notes/pressure-{correction}-{cycle}", f"pressure.correction={correction}",
                           f"pressure.cycle={cycle}")
            d, low = run.table(), run.table("probes/low.csv")
            late = d["time"] >= 1
            weight = 1000 * theory.gravity * (depth - 0.04)
            rows.append([f"{correction:g}", cycle.replace("_", "-"), percent(d["max_speed"][late].mean() / math.sqrt(theory.gravity * depth), 1),
                         f"{low['pressure'][low['time'] >= 1].mean() / weight:.3f}", percent(d["density_error_mean"][late].mean(), 2),
                         f"{run.iterations_per_step:.1f}", f"{run.report['lost_particles']:.0f}"])
    return markdown("share of correction | cycle | largest speed over sqrt(g H) | pressure over rho g h | mean density error | iterations per step | "
                    "particles lost", rows)


@table("notes_vortices", "the micropolar system of the source: every pair of curls, both Laplacians, with and without XSPH", "3 minutes")
def notes_vortices(m):
    rows, curls = [], ("symmetric", "difference", "difference_own_density")
    for of_u in curls:
        for of_w in curls:
            cells = []
            for laplacian, support in (("brookshaw", 2), ("monaghan", 4)):
                for smoothing in (0, 0.125):
                    run = m.render("scenes/studies/notes_vortices.toml", f"notes/vortices-{of_u}-{of_w}-{laplacian}-{smoothing}",
                                   "models.notes=amended", f"micropolar.curl_velocity={of_u}", f"micropolar.curl_spin={of_w}",
                                   f"viscosity.laplacian={laplacian}", f"fluid.support={support}", f"micropolar.xsph_spin={smoothing}",
                                   f"micropolar.xsph_velocity={0.002 if smoothing else 0}", "domain.max=[4,4,1]", "block.0.max=[4,4,1]")
                    d = run.table()
                    exact = np.array([U**2 for U, _ in spinning(0.5, 0.8, 0.5, 2, pi / 2, d["time"])])
                    off = np.abs(d["kinetic_energy"] / d["kinetic_energy"][0] - exact).max()
                    cells.append(percent(off, 1))
            rows.append([of_u, of_w, *cells])
    return markdown("curl u | curl w | brookshaw, no XSPH | with XSPH | monaghan, no XSPH | with XSPH", rows)


@table("gate", "a sheet of water that falls onto a floor, with and without the gate at solids", "1 minute")
def gate(m):
    rows, spacing, frames = [], 0.01, 500
    both = m.render("scenes/studies/gate.toml", "notes/gate", f"time.fps={frames}", options=["--export", "points"])
    for panel, words in enumerate(("weakly compressible, always", "weakly compressible, gate 0.1", "incompressible, always",
                                   "incompressible, gate 0.1"), 1):
        run = Run(both.folder / f"panels/{panel}", m.dry)
        d = run.table()
        if m.dry:
            continue
        heights = [np.sort(run.points(k + 1)[:, 1]) / spacing for k in range(frames + 1)]
        lowest = np.array([h[0] for h in heights])
        fall = d["momentum_y"] / d["momentum_y"][1] * d["time"][1]  # time in which a free fall gains this momentum
        felt = lowest[np.argmax(fall < 0.98 * d["time"])]
        rest = np.mean([h[h < h[0] + 0.5].mean() for h in heights[-frames // 10:]])
        rows.append([words, f"{felt:.2f} d", f"{lowest.min():.2f} d", f"{rest:.2f} d", f"{d['max_speed'][-1]:.3f}"])
    return markdown("pressure, floor | height of onset | lowest height | height at rest | largest speed at 1 s [m/s]", rows)
