"""Experiments and exact flows: docs/reports/laboratory.md, its table and its plots."""
import csv
import io
import math
from dataclasses import dataclass, field

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
    """What an experiment gave: rows of the table, runs, and a plot."""

    rows: list = field(default_factory=list)  # (quantity with unit, published, measured)
    runs: list = field(default_factory=list)
    draw: object = None  # of axes

    def add(self, quantity, published, measured):
        self.rows.append((quantity, published, measured))


def experiment(name):
    """Decorator of a function of a Measurement that returns what was Found."""

    def register(make):
        experiments[name] = make
        return make

    return register


def run(m, scene, *settings, name="", **keys):
    return m.render(f"{folder}/{scene}.toml", f"laboratory/{scene}{name and '-' + name}", *settings, options=["--export", "points"], **keys)


def published(name):
    return read_columns(root / folder / f"{name}.csv")


def snapshots(one):
    """Times and particles of all exported frames."""
    for k in range(1, len(list((one.folder / "points").glob("*.ply"))) + 1):
        yield one.particles(k)


def spacing(one):
    return one.scene["fluid"]["spacing"]


def force(one, name, axis):
    """Time and force of the fluid on a solid along an axis, mean since the last row [N]."""
    probe = one.table(f"probes/{name}.csv")
    kinds = [kind for kind in ("pressure", "viscous", "contact") if f"{kind}_{axis}" in probe]
    return probe["time"], sum(probe[f"{kind}_{axis}"] for kind in kinds)


def between(time, values, start, end):
    """Mean over a span of time."""
    return values[(time >= start) & (time <= end)].mean()


def depth(particles, x, width, d):
    """Depth of water in a column of that width: the area of its particles over the width."""
    return (np.abs(particles["x"] - x) < width / 2).sum() * d**2 / width


def swing(time, values, omega):
    """Amplitude of the fundamental of a signal: least squares beside a level that drifts and the second harmonic."""
    waves = [f(k * omega * time) for k in (1, 2) for f in (np.cos, np.sin)]
    found, *_ = np.linalg.lstsq(np.stack([*waves, np.ones_like(time), time], axis=1), values, rcond=None)
    return math.hypot(found[0], found[1])


def curves(axes, xlabel, ylabel, *lines, legend=True, **limits):
    """@param lines (label, x, y, style)"""
    for label, x, y, style in lines:
        axes.plot(x, y, style, label=label, linewidth=1.3, markersize=4)
    axes.set(xlabel=xlabel, ylabel=ylabel, **limits)
    if legend:
        axes.legend(frameon=False, fontsize=9)


def digits(value):
    return f"{value:.4g}" if abs(value) < 1e4 else f"{value:.0f}"


@table("laboratory", "published experiments and exact flows: --only NAME for one", "25 minutes", keeps_rows=True,
       files=f"{file}, docs/pictures/laboratory/*.svg")
def laboratory(m):
    unknown = [name for name in m.only if name not in experiments and "*" not in name]
    if unknown:
        raise MeasureError(f"no experiment {unknown[0]}; there are {', '.join(experiments)}")
    measured = {}
    for name, make in experiments.items():
        if not m.wanted(name):
            continue
        try:
            found = make(m)
        except RunFailed as error:
            measured[name] = [dict(zip(columns, (name, str(error), "", "", "", "")))]
            continue
        if m.dry:
            continue
        size = sum(one.report["particle_steps"] / one.report["steps"] for one in found.runs) / len(found.runs)
        seconds = sum(one.cpu_seconds for one in found.runs)
        measured[name] = [dict(zip(columns, (name, quantity, digits(right), digits(value), f"{size:.0f}", f"{seconds:.1f}")))
                          for quantity, right, value in found.rows]
        if found.draw:
            m.write(f"docs/pictures/laboratory/{name}.svg", drawing.figure(5.2, 3.1, found.draw))
    if m.dry:
        return None
    old = read_rows(m.into / file) if (m.into / file).exists() else []
    kept = [row for name in experiments for row in measured.get(name, [row for row in old if row["experiment"] == name])]
    text = io.StringIO()
    csv.DictWriter(text, columns, lineterminator="\n").writeheader()
    csv.DictWriter(text, columns, lineterminator="\n").writerows(kept)
    m.write(file, text.getvalue().encode())
    lines, last = [], None
    for row in kept:
        first = row["experiment"] != last
        last = row["experiment"]
        lines.append([last if first else "", row["quantity"], row["published"], row["measured"],
                      off(number(row["measured"]), number(row["published"])) if row["published"] else "",
                      row["particles"] if first else "", row["seconds"] if first else ""])
    return markdown("experiment | quantity | published | Whorl | off by | particles, mean of a run | CPU s", lines)
