"""What the length of the time step does to a flow."""
from .registry import markdown, percent, table


@table("turning_cylinder", "a free cylinder that turns: energy and angular momentum by model and step", "2 minutes")
def turning_cylinder(m):
    models = {
        "coupled": ["models.pressure=coupled"],
        "ppe and full": ["models.pressure=ppe", "models.viscosity=full"],
        "wcsph and full": ["models.pressure=wcsph", "models.viscosity=full"],
    }
    rows = []
    for name, settings in models.items():
        for step in ("5e-3", "2.5e-3", "1.25e-3") if name != "wcsph and full" else ("5e-3",):
            run = m.render("scenes/studies/turning_cylinder.toml", f"turning_cylinder/{name.replace(' ', '_')}-{step}", *settings,
                           f"time.max_step={step}", threads=1)
            d = run.table()
            energy, turning = d["kinetic_energy"], d["angular_momentum_z"]
            rows.append([name, f"{1e3 * float(step):g}", f"{run.report['steps']:.0f}", f"{energy[-1] / energy[0]:.4f}",
                         f"{turning[-1] / turning[0] - 1:+.0e}", f"{run.report['cpu_seconds']:.1f}"])
    return markdown("model | longest step, ms | steps | energy after 0.5 s | change of angular momentum | CPU s", rows)


@table("dam_steps", "scenes/dam_break.toml, draft, to 0.6 s: density and energy by CFL number", "2 minutes")
def dam_steps(m):
    rows = []
    for cfl in (0.2, 0.4, 0.6, 0.8, 1.2):
        run = m.render("scenes/dam_break.toml", f"dam_steps/{cfl:g}", f"time.cfl={cfl:g}", options=["--until", 0.6, "--quality", "draft"],
                       threads=1)
        d, r = run.table(), run.report
        energy = d["kinetic_energy"] + d["potential_energy"]
        rows.append([f"{cfl:g}", f"{r['steps']:.0f}", percent(d["density_error_mean"][1:].mean(), 4), percent(d["density_error_max"].max(), 2),
                     f"{energy[-1]:.2f}", f"{r['cpu_seconds']:.1f}"])
    return markdown("CFL | steps | mean density error | largest | energy at 0.6 s, J | CPU s", rows)


@table("rotating_drop", "scenes/rotating_drop.toml, draft, to 0.5 s: energy and angular momentum by model and step", "2 minutes")
def rotating_drop(m):
    rows = []
    for name, settings in (("coupled", ["models.pressure=coupled"]), ("ppe and full", ["models.pressure=ppe", "models.viscosity=full"])):
        for step in ("10e-3", "5e-3", "2.5e-3"):
            run = m.render("scenes/rotating_drop.toml", f"rotating_drop/{name.replace(' ', '_')}-{step}", *settings, f"time.max_step={step}",
                           options=["--until", 0.5, "--quality", "draft"], threads=1)
            d = run.table()
            energy, turning = d["kinetic_energy"], d["angular_momentum_z"]
            rows.append([name, f"{1e3 * float(step):g}", f"{run.report['steps']:.0f}", f"{energy[-1] / energy[0]:.4f}",
                         f"{turning[-1] / turning[0] - 1:+.0e}", f"{run.report['cpu_seconds']:.1f}"])
    return markdown("model | longest step, ms | steps | energy after 0.5 s | change of angular momentum | CPU s", rows)
