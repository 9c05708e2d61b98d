"""Runs of whorl and whorl_solver_tables, kept in out/measure, and readers of their files."""
import csv
import io
import json
import os
import shlex
import shutil
import subprocess
import sys
import time
import tomllib
from collections import defaultdict
from fnmatch import fnmatchcase
from pathlib import Path

import numpy as np

from .registry import MeasureError, write_file

root = Path(__file__).resolve().parents[2]
drawing_stages = ("surface", "draw", "export", "write", "encode")  # first words of their names ("export mesh")


class RunFailed(MeasureError):
    pass


class Unknown(float):
    """Placeholder for measured values in a dry run: nan, any entry of it is Unknown, and iteration over it is empty."""

    def __new__(cls, *_):
        return super().__new__(cls, "nan")

    def __getitem__(self, _):
        return self

    get = __getitem__

    def __iter__(self):
        return iter(())

    items = values = __iter__


def words_of(command):
    """The command as typed in the top folder of the repository."""
    return shlex.join(str(part).replace(f"{root}/", "") for part in command)


def newer(file, than):
    return not Path(than).exists() or Path(file).stat().st_mtime >= Path(than).stat().st_mtime


def number(text):
    """Number of a CSV cell; nan if it is empty."""
    return float(text) if text not in (None, "") else float("nan")


def read_rows(path):
    with open(path, newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def read_columns(path):
    """The columns of a CSV file of numbers, by name; an empty cell is nan."""
    rows = read_rows(path)
    return {name: np.array([number(row[name]) for row in rows]) for name in (rows[0] if rows else ())}


def toml(value, top=True):
    """A dict as TOML: inline tables below the first level."""
    if isinstance(value, dict):
        pairs = [f"{json.dumps(key)} = {toml(part, False)}" for key, part in value.items()]
        return "\n".join(pairs) + "\n" if top else "{ " + ", ".join(pairs) + " }"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(toml(part, False) for part in value) + "]"
    return json.dumps(str(value) if isinstance(value, Path) else value)


class Run:
    """Reader of a run folder."""

    def __init__(self, folder, dry=False):
        self.folder, self.dry = Path(folder), dry
        files = sorted(self.folder.glob("panels/*/run.json")) or [self.folder / "run.json"]
        self.panels = [Unknown()] if dry else [json.loads(file.read_text()) for file in files]
        self.report = self.panels[0]

    def table(self, name="diagnostics.csv"):
        """Columns of a CSV file as arrays, by name."""
        return defaultdict(lambda: np.full(3, np.nan)) if self.dry else read_columns(self.folder / name)

    def last(self, name="diagnostics.csv"):
        """Last row, by column."""
        return Unknown() if self.dry else {column: values[-1] for column, values in self.table(name).items()}

    def particles(self, frame):
        """Time of an exported frame, and its particles as columns by property. All properties have four bytes."""
        header, _, body = next((self.folder / "points").glob(f"*.{frame:04d}.ply")).read_bytes().partition(b"end_header\n")
        names = [line.split()[-1].decode() for line in header.split(b"\n") if line.startswith(b"property ")]
        columns = np.frombuffer(body, "<f4").reshape(-1, len(names)).astype(float)
        return float(header.split(b" time ")[1].split()[0]), dict(zip(names, columns.T))

    def points(self, frame):
        """Positions of an exported frame."""
        particles = self.particles(frame)[1]
        return np.stack([particles[axis] for axis in "xyz"], axis=1).astype("<f4")

    @property
    def scene(self):
        """Resolved scene: every key with its value."""
        return Unknown() if self.dry else tomllib.loads(min(self.folder.glob("**/scene.resolved.toml")).read_text())

    @property
    def iterations_per_step(self):
        return sum(self.report["iterations_per_step"].values())

    @property
    def microseconds(self):
        """CPU time per particle-step [us]."""
        return 1e6 * self.report["cpu_seconds"] / self.report["particle_steps"]

    @property
    def cpu_seconds(self):
        """CPU time of all panels."""
        return sum(panel["cpu_seconds"] for panel in self.panels)

    @property
    def drawing_seconds(self):
        """CPU time of the drawing stages, all panels."""
        return self.stage_seconds(*drawing_stages)

    @property
    def simulation_seconds(self):
        """CPU time of all other stages, all panels."""
        names = {name.split()[0] for panel in self.panels for name in panel["stages"]}
        return self.stage_seconds(*names.difference(drawing_stages))

    def stage_seconds(self, *stages):
        """CPU time of the stages whose names begin with these words, all panels."""
        return Unknown() if self.dry else sum(
            stage["cpu_seconds"] for panel in self.panels for name, stage in panel["stages"].items() if name.split()[0] in stages)


class Measurement:
    """Runs the commands that a table's function needs. Results stay in out/measure and are reused, unless `again`."""

    def __init__(self, program=None, again=False, dry=False, only=(), settings=(), into=root, writes=True, say=None):
        self.program = Path(program or os.environ.get("WHORL") or root / "build/release/whorl").absolute()
        self.again, self.dry, self.only, self.settings, self.into = again, dry, only, list(settings), Path(into)
        self.writes = writes and not dry and not settings  # whether pages, their images and their CSV files are written
        self.out = root / ("out/measure/try" if settings else "out/measure")
        self.say = say or (lambda text: print(text, file=sys.stderr, flush=True))
        self.ready = set()

    def wanted(self, name):
        return not self.only or any(fnmatchcase(str(name), pattern) for pattern in self.only)

    # Programs

    def build(self, target, preset="release"):
        """Builds a target, once per Measurement; returns the build folder."""
        if (preset, target) not in self.ready:
            self.ready.add((preset, target))
            self.call(["bash", root / "tools/build.sh", preset, target])
        return root / "build" / preset

    def call(self, command, log=None, environment=None):
        """Runs a command; returns its standard output. @param log file for the command and its output"""
        command, line = [str(part) for part in command], words_of(command)
        self.say(line)
        if self.dry:
            return ""
        start = time.monotonic()
        done = subprocess.run(command, cwd=root, env={**os.environ, **(environment or {})}, text=True,
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        if log:
            write_file(log, f"{'failed: ' * (done.returncode != 0)}{line}\n{done.stdout}{done.stderr}".encode())
        if done.returncode != 0:
            last = (done.stderr or done.stdout).strip().splitlines()[-1:] or ["no message"]
            raise RunFailed(f"failed ({done.returncode}): {last[0].removeprefix('whorl: ')}")
        self.say(f"    {time.monotonic() - start:.1f} s")
        return done.stdout

    def whorl(self, *arguments, **keys):
        if not self.program.is_file() and self.program == root / "build/release/whorl":
            self.build("whorl")
        return self.call([self.program, *arguments], **keys)

    def kept(self, result, log, command):
        """Whether this command has already made `result` from the current scene files."""
        if self.again or self.dry or not result.exists() or not log.exists():
            return False
        files = [root / part for part in map(str, command) if part.endswith(".toml")]
        with open(log, encoding="utf-8") as text:
            same = text.readline().rstrip("\n") == words_of(command) and all(newer(log, file) for file in files)
        if same:
            old = "" if newer(log, command[0]) else ", though the program has changed since (--again repeats it)"
            self.say(f"{result.relative_to(self.out)}: kept{old}")
        return same

    # Results

    def render(self, scene, name, *settings, options=(), threads=1, images=False):
        """Runs a scene into out/measure/NAME. @param settings "key=value" @param options of whorl render"""
        folder = self.out / name
        log = folder.with_name(folder.name + ".log")
        command = ["render", scene, *["--no-images"] * (not images), "--quiet", "--threads", threads, "--out", folder, "--overwrite", *options,
                   *self.sets(settings)]
        if not self.kept(folder / "run.json", log, [self.program, *command]):
            self.whorl(*command, log=log)
        return Run(folder, self.dry)

    def sets(self, settings):
        return [word for setting in (*settings, *self.settings) for word in ("--set", setting)]

    def plan(self, scene, *settings, options=(), threads=1, images=False):
        """Prediction of whorl plan."""
        text = self.whorl("plan", scene, *["--no-images"] * (not images), "--threads", threads, "--json", *options, *self.sets(settings))
        return Unknown() if self.dry else json.loads(text)

    def toml_file(self, name, keys):
        """Writes a scene, part of a scene or a study as out/measure/NAME.toml."""
        file, content = self.out / f"{name}.toml", toml(keys).encode()
        if not self.dry and not (file.exists() and file.read_bytes() == content):
            write_file(file, content)
        return file

    def study(self, name, keys):
        """Rows of whorl tradeoff for the study with these keys. Its points stay in out/measure/NAME."""
        folder = self.out / name
        if self.again and not self.dry:
            shutil.rmtree(folder / "points", ignore_errors=True)
        keys = {"set": [], **keys}
        keys["set"] = [*keys["set"], *self.settings]
        file = self.toml_file(f"{name}/study", keys)
        self.whorl("tradeoff", file, "--all", "--threads", 1, "--jobs", 1, "--out", folder, log=folder / "log")
        return [] if self.dry else read_rows(folder / "tradeoff.csv")

    def point(self, name, *words):
        """Run of the study point whose folder name contains all these words."""
        found = [f for f in sorted((self.out / name / "points").glob("*/")) if all(word in f.name for word in words)]
        return Run(found[0] if found else "", self.dry)

    def solver(self, *arguments, name=None):
        """Rows that whorl_solver_tables prints, kept in out/measure/solver."""
        name = "solver/" + (name or "-".join(str(argument).lstrip("-") for argument in arguments))
        file, log = self.out / f"{name}.csv", self.out / f"{name}.log"
        command = [root / "build/release/tools/measure/solver/whorl_solver_tables", *arguments]
        if not self.kept(file, log, command):
            self.build("whorl_solver_tables")
            text = self.call(command, log=log)
            if not self.dry:
                write_file(file, text.encode())
        return [] if self.dry else read_rows(file)

    def write(self, path, content):
        """Writes a file of the documentation, if `writes`. @param path relative to the top of the repository"""
        if self.writes:
            write_file(self.into / path, content)

    def write_csv(self, path, columns, rows):
        text = io.StringIO()
        csv.writer(text, lineterminator="\n").writerows([columns, *([row[name] for name in columns] for row in rows)])
        self.write(path, text.getvalue().encode())


def read_scene(scene):
    return tomllib.loads((root / scene).read_text())


def attempt(measure):
    """Cells that measure() returns, or the message if a run failed."""
    try:
        return measure()
    except RunFailed as error:
        return [str(error)]
