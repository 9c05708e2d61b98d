"""Effect of the length of the time step on a flow."""
from .registry import markdown, percent, table


def by_model_and_step(m, scene, cases, options=()):
    """Table of energy and angular momentum of a rotating free body. @param cases tuples (model, longest steps [s], settings)"""
    rows = []
    for model, steps, settings in cases:
        for step in steps:
            run = m.render(f"scenes/{scene}.toml", f"{scene.split('/')[-1]}/{model.replace(' ', '_')}-{step}", *settings, f"time.max_step={step}",
                           options=options, threads=1)
            d = run.table()
            energy, turning = d["kinetic_energy"], d["angular_momentum_z"]
            rows.append([model, f"{1e3 * float(step):g}", f"{run.report['steps']:.0f}", f"{energy[-1] / energy[0]:.4f}",
                         f"{turning[-1] / turning[0] - 1:+.0e}", f"{run.report['cpu_seconds']:.1f}"])
    return markdown("model | longest step, ms | steps | energy after 0.5 s | change of angular momentum | CPU s", rows)


projection = ["models.pressure=ppe", "models.viscosity=full", "pressure.form=projection"]
coupled, ppe_and_full = ["models.pressure=coupled"], ["models.pressure=ppe", "models.viscosity=full"]


@table("turning_cylinder", "a rotating free cylinder: energy and angular momentum by model and step", "2 minutes")
def turning_cylinder(m):
    steps = ("5e-3", "2.5e-3", "1.25e-3")
    return by_model_and_step(m, "studies/turning_cylinder", [("coupled", steps, coupled), ("ppe and full", steps, ppe_and_full),
                                                             ("projection and full", steps, projection),
                                                             ("wcsph and full", steps[:1], ["models.pressure=wcsph", "models.viscosity=full"])])


@table("rotating_drop", "scenes/rotating_drop.toml, draft, to 0.5 s: energy and angular momentum by model and step", "2 minutes")
def rotating_drop(m):
    steps = ("10e-3", "5e-3", "2.5e-3")
    return by_model_and_step(m, "rotating_drop", [("coupled", steps, coupled), ("ppe and full", steps, ppe_and_full)],
                             ["--until", 0.5, "--quality", "draft"])


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
