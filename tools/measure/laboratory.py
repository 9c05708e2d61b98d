"""Experiments and exact flows: docs/reports/laboratory.md, its table and its plots."""
import math
from dataclasses import dataclass, field
from typing import Callable

import numpy as np

from . import drawing
from .registry import MeasureError, markdown, off, table
from .runs import RunFailed, number, read_columns, read_rows, root

folder = "scenes/studies/laboratory"
file = "docs/studies/laboratory.csv"
columns = ["experiment", "quantity", "published", "measured", "particles", "seconds"]
experiments = {}


@dataclass
class Found:
    """Results of an experiment: rows of the table, and a plot."""

    rows: list = field(default_factory=list)  # (quantity with unit, published, measured)
    draw: Callable | None = None  # draw(axes)

    def add(self, quantity, published, measured):
        self.rows.append((quantity, published, measured))

    def plot(self, xlabel, ylabel, *lines, **limits):
        """@param lines (label, x, y, style)"""

        def draw(axes):
            for label, x, y, style in lines:
                axes.plot(x, y, style, label=label, linewidth=1.3, markersize=4)
            axes.set(xlabel=xlabel, ylabel=ylabel, **limits)
            axes.legend(frameon=False, fontsize=9)

        self.draw = draw


@dataclass
class Experiment:
    measure: Callable
    variants: dict
    scene: str

    def render(self, m):
        """Renders every variant: {variant: run}."""
        runs = {}
        for variant, settings in self.variants.items():
            scene = self.scene.format(variant)
            name = scene + ("-" + str(variant).replace(", ", "-").replace(" ", "_") if settings else "")
            runs[variant] = m.render(f"{folder}/{scene}.toml", f"laboratory/{name}", *settings, options=["--export", "points"])
        return runs


def experiment(name, variants={None: ()}, scene=None):
    """Decorator: registers measure(found, run), or measure(found, {variant: run}) if there are variants. It fills `found`.
    @param variants {variant: settings} @param scene name of the scene file if it differs from `name`; {} is replaced by the variant"""

    def register(measure):
        experiments[name] = Experiment(measure, variants, scene or name)
        return measure

    return register


def published(name):
    return read_columns(root / folder / f"{name}.csv")


def snapshots(one):
    """Times and particles of all exported frames."""
    for k in range(1, len(list((one.folder / "points").glob("*.ply"))) + 1):
        yield one.particles(k)


def spacing(one):
    return one.scene["fluid"]["spacing"]


def force(one, name, axis):
    """Times [s] of a probe's rows, and force of the fluid on the solid along an axis [N], mean since the previous row."""
    probe = one.table(f"probes/{name}.csv")
    return probe["time"], sum(probe[f"{kind}_{axis}"] for kind in ("pressure", "viscous", "contact"))


def between(time, values, start, end):
    """Mean of values between two times."""
    return values[(time >= start) & (time <= end)].mean()


def depth(particles, x, width, d):
    """Depth of water at x [m]: area of the particles in a column of this width, divided by the width. @param d spacing"""
    return (np.abs(particles["x"] - x) < width / 2).sum() * d**2 / width


def swing(time, values, omega):
    """Amplitude of the fundamental of a signal, fitted by least squares together with the second harmonic and a linear drift."""
    waves = [f(k * omega * time) for k in (1, 2) for f in (np.cos, np.sin)]
    found, *_ = np.linalg.lstsq(np.stack([*waves, np.ones_like(time), time], axis=1), values, rcond=None)
    return math.hypot(found[0], found[1])


def digits(value):
    return f"{value:.4g}" if abs(value) < 1e4 else f"{value:.0f}"


@table("laboratory", "published experiments and exact flows: --only NAME for one", "25 minutes", keeps_rows=True,
       files=f"{file}, docs/pictures/laboratory/*.svg")
def laboratory(m):
    unknown = [name for name in m.only if name not in experiments and "*" not in name]
    if unknown:
        raise MeasureError(f"no experiment {unknown[0]}; use one of {', '.join(experiments)}")
    measured = {}
    for name, one in experiments.items():
        if not m.wanted(name):
            continue
        try:
            runs = one.render(m)
        except RunFailed as error:
            measured[name] = [dict.fromkeys(columns, "") | {"experiment": name, "quantity": str(error)}]
            continue
        if m.dry:
            continue
        found = Found()
        one.measure(found, runs.get(None, runs))
        size = sum(run.report["particle_steps"] / run.report["steps"] for run in runs.values()) / len(runs)
        seconds = sum(run.cpu_seconds for run in runs.values())
        measured[name] = [dict(zip(columns, (name, quantity, digits(right), digits(value), f"{size:.0f}", f"{seconds:.1f}")))
                          for quantity, right, value in found.rows]
        m.write(f"docs/pictures/laboratory/{name}.svg", drawing.figure(5.2, 3.1, found.draw))
    if m.dry:
        return None
    old = read_rows(m.into / file) if (m.into / file).exists() else []
    kept = [row for name in experiments for row in measured.get(name, [row for row in old if row["experiment"] == name])]
    m.write_csv(file, columns, kept)
    lines, last = [], None
    for row in kept:
        first = row["experiment"] != last
        last = row["experiment"]
        lines.append([last if first else "", row["quantity"], row["published"], row["measured"],
                      off(number(row["measured"]), number(row["published"])) if row["published"] else "",
                      row["particles"] if first else "", row["seconds"] if first else ""])
    return markdown("experiment | quantity | published | Whorl | off by | particles, mean of a run | CPU s", lines)
