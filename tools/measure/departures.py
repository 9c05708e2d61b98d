"""Cost and benefit of each departure from the source notes as printed (docs/physics.md, section 14)."""
import math

import numpy as np

from . import drawing, theory
from .registry import markdown, percent, table
from .runs import read_scene
from .vortices import spinning

pi = math.pi
printed = "models.notes=as_printed"
note_2, note_3 = "scenes/studies/published_pressure.toml", "scenes/studies/notes_vortices.toml"


def viscosity(m):
    """A free rotating cylinder of syrup, which strains: exactly 0.985 of its energy is left."""
    rows = []
    for words, settings in (("as printed", [printed, "models.viscosity=full_assembled"]),
                            ("V_i in the Jacobian, load T", ["models.viscosity=full_assembled", "viscosity.penalty=0"]),
                            ("and a penalty", ["models.viscosity=full_assembled"]),
                            ("the same without a matrix", ["models.viscosity=full", "viscosity.correction=false"]),
                            ("corrected gradients (default)", ["models.viscosity=full"])):
        run = m.render("scenes/studies/turning_cylinder.toml", f"departures/viscosity-{len(rows)}", "models.pressure=none", "time.end=0.1",
                       *settings)
        d = run.table()
        energy = d["kinetic_energy"] / d["kinetic_energy"][0]
        turning = d["angular_momentum_z"] / d["angular_momentum_z"][0]
        rows.append([words, f"{energy[-1]:.4f}", f"{turning[-1]:.4f}", f"{run.iterations_per_step:.1f}", f"{run.report['cpu_seconds']:.1f}"])
    return markdown("first note | energy left after 0.1 s | angular momentum left | iterations per step | CPU s", rows)


def pressure(m):
    rows, depth, column = [], 0.2, read_scene(note_2)
    for words, settings in (("as printed", [printed]), ("solved rows alone", ["pressure.correction=1", "pressure.damping=0"]),
                            ("and a share of 0.1", ["pressure.damping=0"]), ("or damping", ["pressure.correction=1"]),
                            ("share and damping (default of the source)", []), ("and additive levels", ["pressure.cycle=additive"]),
                            ("the constraint (default)", [])):
        scene = m.toml_file("departures/column", {**column, "pressure": {}}) if "constraint" in words else note_2
        run = m.render(scene, f"departures/pressure-{len(rows)}", *settings)
        d, low = run.table(), run.table("probes/low.csv")
        late = d["time"] >= 1
        weight = 1000 * theory.gravity * (depth - 0.04)
        rows.append([words, percent(d["max_speed"][late].mean() / math.sqrt(theory.gravity * depth), 1),
                     f"{low['pressure'][low['time'] >= 1].mean() / weight:.3f}", percent(d["density_error_mean"][late].mean(), 2),
                     f"{run.iterations_per_step:.1f}", f"{run.report['lost_particles']:.0f}", f"{run.report['cpu_seconds']:.1f}"])
    return markdown("second note | largest speed over sqrt(g H) | pressure over rho g h | mean density error | iterations per step | particles lost "
                    "| CPU s", rows)


def free_ball(m, end):
    """Scene file of a free, weightless, rotating ball of the third note's fluid."""
    scene = read_scene(note_3)
    return m.toml_file(f"departures/ball-{end}", {
        **scene, "name": "ball", "time": {"end": end, "fps": 10}, "fluid": {**scene["fluid"], "spacing": 0.2},
        "domain": {"min": [-3, -3, -3], "max": [3, 3, 3], "gravity": [0, 0, 0]}, "pressure": {**scene["pressure"], "background_pressure": 0},
        "block": [{"shape": "sphere", "position": [0, 0, 0], "radius": 1, "velocity": ["-0.2*y", "0.2*x", "0"]}]})


def micropolar(m):
    rows, amended, ball = [], "models.notes=amended", free_ball(m, 2)
    seen, damped = "micropolar.co_rotating=true", "pressure.sound_damping=1"
    for words, settings in (("as printed", []), ("lattice factors, symmetric weights, XSPH of the step's start", [amended]),
                            ("and no XSPH", [amended, "micropolar.xsph_velocity=0", "micropolar.xsph_spin=0"]),
                            ("or curl u - 2 w seen from the particle", [amended, seen]), ("or sound damping", [amended, damped]),
                            ("both, and the split Laplacian at surfaces (default)", [amended, seen, damped, "viscosity.laplacian=auto"])):
        run, free = (m.render(of, f"departures/{name}-{len(rows)}", *settings) for of, name in ((note_3, "vortices"), (ball, "ball")))
        d, b = run.table(), free.table()
        exact = np.array([U**2 for U, _ in spinning(0.5, 0.8, 0.5, 2, pi / 2, d["time"])])
        energy, turning = b["kinetic_energy"] + b["spin_energy"], b["angular_momentum_z"]
        rows.append([words, percent(np.abs(d["kinetic_energy"] / d["kinetic_energy"][0] - exact).max(), 2), f"{energy[-1] / energy[0]:.3f}",
                     f"{turning[-1] / turning[0]:.3f}", f"{run.report['cpu_seconds']:.1f}"])
    return markdown("third note | vortices: energy off the two equations | free ball after 2 s: energy | angular momentum | CPU s (vortices)", rows)


@table("departures", "cost and benefit of each departure from the notes as printed: error, energy, time", "5 minutes")
def departures(m):
    return "\n\n".join((viscosity(m), pressure(m), micropolar(m)))


@table("energy_budget", "the energy of a rotating free ball: as printed, with the safe form, with eringen", "1 minute",
       files="docs/pictures/energy_budget.svg")
def energy_budget(m):
    safe = ["models.notes=amended", "micropolar.co_rotating=true", "pressure.sound_damping=1", "viscosity.laplacian=auto"]
    forms = {"as printed": [], "notes, safe form (default)": safe, "eringen": [*safe, "models.micropolar=eringen"]}
    runs = {words: m.render(free_ball(m, 6), f"departures/budget-{k}", *forms[words]).table() for k, words in enumerate(forms)}
    rows = []

    def parts(d):
        """Flow energy, spin energy, dissipation (viscosity, exchange and XSPH) and other work, each over the initial energy."""
        taken = d["viscous_dissipation"] + d["exchange_dissipation"] + d["smoothing_dissipation"]
        work = d["pressure_work"] + d["moves_work"]
        return [part / d["kinetic_energy"][0] for part in (d["kinetic_energy"], d["spin_energy"], taken, work)]

    def draw(axes):
        for colour, width, (words, d) in zip(("C3", "C0", "C2"), (1.5, 3, 1.5), runs.items()):
            flow, spin, taken, work = parts(d)
            for line, values in (("-", flow + spin), ("--", taken), (":", flow + spin + taken - work)):
                axes.plot(d["time"], values, line, color=colour, linewidth=width, label=words if line == "-" else None)
        for line, words in (("-", "flow + spin"), ("--", "dissipated"), (":", "their sum less other work")):
            axes.plot([], [], line, color="black", label=words)
        axes.set(xlabel="t [s]", ylabel="over the energy at the start", ylim=(-4, 5))
        axes.legend(frameon=False)

    for words, d in runs.items():
        rows.append([words, *(f"{part[-1]:.3f}" for part in parts(d)), f"{(d['energy_error'] / d['kinetic_energy'][0])[-1]:.0e}"])
    if not m.dry:
        m.write("docs/pictures/energy_budget.svg", drawing.figure(6.4, 3.9, draw))
    return "![Energy of a free ball over time](../pictures/energy_budget.svg)\n\n" + markdown(
        "form | flow after 6 s | spin | dissipated | other work | remainder", rows)
