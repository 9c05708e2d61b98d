"""Whorl beside SPlisHSPlasH: three flows by both programs, cost against error."""
import json
import math
import os
import re
import resource
from pathlib import Path
from statistics import median
from types import SimpleNamespace

import numpy as np

from . import drawing, theory
from .registry import MeasureError, markdown, percent, table
from .runs import write_file

g, rho = theory.gravity, 1000
repeats = 3  # runs of each case; the programs take turns, and the tables show medians
unit_box = "".join(f"v {x} {y} {z}\n" for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)) + "".join(
    f"f {a} {b} {c}\n" for a, b, c in ((1, 2, 4), (1, 4, 3), (5, 7, 8), (5, 8, 6), (1, 5, 6), (1, 6, 2), (3, 4, 8), (3, 8, 7), (1, 3, 7), (1, 7, 5),
                                       (2, 6, 8), (2, 8, 4)))


class Flow:
    """A flow as a scene of either program. Both start from the same lattice of particles."""
    gravity, frames, room_is_closed = g, 3, True

    def scene(self):
        low, high = self.block
        return {"name": "peer", "time": {"end": self.until, "fps": self.frames / self.until},
                "domain": {"min": [x - 0.05 for x in self.room[0]], "max": [x + 0.1 for x in self.room[1]], "gravity": [0, -self.gravity, 0]},
                "fluid": {"spacing": self.spacing, "viscosity": self.viscosity}, "models": self.models,
                "block": [{"shape": "box", "min": low, "max": high, "velocity": self.velocity}],
                "solid": [self.solid], "output": {"export": ["points"]}}

    def lattice(self):
        axes = [np.arange(low + self.spacing / 2, high, self.spacing) for low, high in zip(*self.block)]
        return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)

    def start_velocity(self, x):
        return np.zeros_like(x)

    def peer_files(self, folder, case, settings):
        """Writes the scene of SPlisHSPlasH (DFSPH, volume maps at walls), the particles and the walls; returns the scene's file.
        @param settings keys of "Configuration" that differ"""
        low, high = self.room
        solver = {"minIterations": 2, "maxIterations": 100, "maxError": 0.05, "maxIterationsV": 100, "maxErrorV": 0.1}
        scene = {"Configuration": {"particleRadius": self.spacing / 2, "simulationMethod": 4, "gravitation": [0, -self.gravity, 0],
                                   "timeStepSize": 1e-3, "cflMethod": 1, "cflFactor": 1.0, "cflMaxTimeStepSize": 5e-3, "boundaryHandlingMethod": 2,
                                   "enableVTKExport": True, "dataExportFPS": self.frames / self.until, "particleAttributes": "density;velocity",
                                   **settings, "DFSPH": {**solver, **settings.get("DFSPH", {})}},
                 "Materials": [{"id": "Fluid", "density0": rho, **self.material}],
                 "RigidBodies": [{"geometryFile": "box.obj", "translation": [(a + b) / 2 for a, b in zip(low, high)], "rotationAxis": [1, 0, 0],
                                  "rotationAngle": 0, "scale": [b - a for a, b in zip(low, high)], "isDynamic": False, "isWall": self.room_is_closed,
                                  "mapInvert": self.room_is_closed, "mapThickness": 0.0, "mapResolution": [30, 30, 30]}],
                 "FluidModels": [{"id": "Fluid", "particleFile": "start.pda", "translation": [0, 0, 0], "rotationAxis": [1, 0, 0],
                                  "rotationAngle": 0, "scale": [1, 1, 1]}]}
        x = self.lattice()
        rows = "".join("%.9g %.9g %.9g %.9g %.9g %.9g\n" % (*a, *b) for a, b in zip(x, self.start_velocity(x)))
        write_file(folder / "box.obj", unit_box.encode())
        write_file(folder / "start.pda", f"ATTRIBUTES\nposition velocity\nTYPES\nV V\nNUMBER_OF_PARTICLES: {len(x)}\nBEGIN DATA\n{rows}".encode())
        write_file(folder / f"scene_{case}.json", json.dumps(scene, indent=1).encode())
        return folder / f"scene_{case}.json"


class Dam(Flow):
    until, frames, viscosity, velocity = 0.3, 6, 0, ["0", "0", "0"]
    models = {"pressure": "ppe", "viscosity": "xsph"}
    room, block = ([0, 0, 0], [0.64, 0.5, 0.16]), ([0, 0, 0], [0.16, 0.32, 0.16])
    solid = {"shape": "box", "min": room[0], "max": room[1], "container": True}
    cases = [["time.cfl=0.4"], ["time.cfl=0.8", "pressure.tolerance=3e-3"]]
    material = {"viscosityMethod": 1, "Standard viscosity": {"viscosity": 0.01}}
    peer_cases = [{"DFSPH": {"maxError": 0.1}}, {"DFSPH": {"maxError": 0.02}}, {"cflFactor": 0.5, "DFSPH": {"maxError": 0.02}}]
    error_name, digits = "mean density error", 4

    def __init__(self, spacing, peer_cases=3):
        self.spacing, self.peer_cases = spacing, self.peer_cases[:peer_cases]

    def error(self, frames):
        return np.mean([np.maximum(p["density"] / rho - 1, 0).mean() for p in frames[1:]])


class Block(Flow):
    """A block of 1000 Pa s sinks on a plate without friction. The weight of what lies above a layer strains it at that weight over 3 mu, so the
    layer at Z of a block of height H is at y = ln((1 + a H)/(1 + a (H - Z)))/a after the time t, a = rho g t/(3 mu)."""
    until, spacing, viscosity, velocity, room_is_closed = 0.3, 2.5e-3, 1000, ["0", "0", "0"], False
    models = {"pressure": "coupled"}
    room, block = ([-0.07, -0.02, -0.07], [0.07, 0, 0.07]), ([-0.02, 0, -0.02], [0.02, 0.08, 0.02])
    solid = {"shape": "plane", "normal": [0, 1, 0], "slip": "free"}
    cases = [["time.max_step=5e-3"], ["time.max_step=1e-3"]]
    material = {"viscosityMethod": 6, "Weiler et al. 2018": {"viscosity": 1, "viscosityBoundary": 0, "viscoMaxIter": 10000, "viscoMaxError": 1e-5}}
    peer_cases = [{"timeStepSize": step, "cflMaxTimeStepSize": step} for step in (1e-3, 2.5e-4, 1e-4)]
    error_name, digits = "error of the top layer's descent", 1

    def error(self, frames):
        first, last = frames[0]["y"], frames[-1]["y"]
        top, height, a = first > 0.08 - self.spacing, 0.08, rho * g * self.until / (3 * self.viscosity)
        start = height - self.spacing / 2
        exact = math.log((1 + a * height) / (1 + a * (height - start))) / a - start
        return (last[top].mean() - first[top].mean()) / exact - 1


class Vortex(Flow):
    """A Taylor-Green cell between walls without friction turns once: E/E0 = exp(-4 nu k^2 t)."""
    until, spacing, viscosity, gravity, frames = 1.0, 4e-3, 0.1, 0, 2
    velocity = ["0.2*sin(10*pi*x)*cos(10*pi*y)", "-0.2*cos(10*pi*x)*sin(10*pi*y)", "0"]
    models = {"pressure": "ppe", "viscosity": "full"}
    room = block = ([0, 0, 0], [0.1, 0.1, 0.048])
    solid = {"shape": "box", "min": room[0], "max": room[1], "container": True, "slip": "free"}
    cases = [[], ["time.cfl=0.2"]]
    material = {"viscosityMethod": 1, "Standard viscosity": {"viscosity": 1e-4, "viscosityBoundary": 0}}
    peer_cases = [{}, {"cflFactor": 0.5, "DFSPH": {"maxError": 0.01, "maxErrorV": 0.02}}]
    error_name, digits = "error of the energy", 1

    def start_velocity(self, x):
        a, b = 10 * np.pi * x[:, 0], 10 * np.pi * x[:, 1]
        return 0.2 * np.stack([np.sin(a) * np.cos(b), -np.cos(a) * np.sin(b), 0 * a], axis=1)

    def error(self, frames):
        energies = [sum((p[f"velocity_{axis}"] ** 2).sum() for axis in "xyz") for p in frames]
        return energies[-1] / energies[0] / math.exp(-4 * 1e-4 * (10 * np.pi)**2 * self.until) - 1


flows = {"dam_16k": Dam(8e-3), "dam_49k": Dam(5.47e-3, peer_cases=2), "sinking_block": Block(), "closed_vortex": Vortex()}


# Runs

def by_id(columns):
    order = np.argsort(columns["id"])
    return {name: values[order] for name, values in columns.items()}


def whorl_run(m, flow, name, settings, k):
    run = m.render(m.toml_file(f"peer/{name}", flow.scene()), f"peer/{name}-{'-'.join(settings)}-{k}", *settings)
    frames = [] if m.dry else [by_id(run.particles(frame)[1]) for frame in range(1, flow.frames + 2)]
    return SimpleNamespace(frames=frames, cpu=run.report["cpu_seconds"], steps=run.report["steps"], iterations=run.iterations_per_step)


def vtk_columns(file):
    """Particles of a legacy VTK file of SPlisHSPlasH by property: big-endian numbers after a line that names them."""
    data, columns = file.read_bytes(), {}
    for header, kind in ((rb"POINTS (\d+) float\n", ">f4"), (rb"SCALARS id unsigned_int 1\nLOOKUP_TABLE id_table\n", ">u4"),
                         (rb"\ndensity 1 (\d+) float\n", ">f4"), (rb"\nvelocity 3 (\d+) float\n", ">f4")):
        found = re.search(header, data)
        count = int(found[1]) if found.groups() else len(columns["x"])
        wide = 3 if header.startswith((b"POINTS", rb"\nvelocity")) else 1
        values = np.frombuffer(data, kind, wide * count, found.end()).reshape(count, wide).astype(float)
        names = {b"P": "xyz", b"S": ["id"], b"d": ["density"], b"v": [f"velocity_{axis}" for axis in "xyz"]}[header.replace(rb"\n", b"")[:1]]
        columns.update(zip(names, values.T))
    return by_id(columns)


def peer_cpu(m, program, scene, folder, until):
    """CPU time [s] of a run of SPlisHSPlasH on one thread, its set-up included."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    m.call([program, scene, "--no-gui", "--output-dir", folder, "--stopAt", until], log=folder / "log.txt",
           environment={"OMP_NUM_THREADS": "1"})
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def peer_run(m, program, flow, name, settings, case, k):
    """Run of SPlisHSPlasH, or None where it has not been run. Its set-up is measured by a run of one step and subtracted."""
    if m.dry:
        return None
    scene = flow.peer_files(m.out / "peer/SPlisHSPlasH" / name, case, settings)  # all cases of a flow share the cache of the walls
    folder = scene.parent / f"{case}-{k}"
    kept = folder / "cost.json"
    if program and (m.again or not kept.exists()):
        start = min(peer_cpu(m, program, scene, folder / "start", 1e-9) for _ in range(2))  # the first run fills the cache of the walls
        cost = {"cpu": peer_cpu(m, program, scene, folder / "run", flow.until) - start}
        write_file(kept, json.dumps(cost).encode())
    if not kept.exists():
        return None
    text = (folder / "run/log.txt").read_text()
    means = {key: float(value) for key, value in re.findall(r"Average number: (.+?): ([-+.\de]+)", text)}
    files = sorted((folder / "run/vtk").glob("*.vtk"), key=lambda file: int(re.findall(r"\d+", file.stem)[-1]))
    return SimpleNamespace(frames=[vtk_columns(file) for file in files], cpu=json.loads(kept.read_text())["cpu"],
                           steps=flow.until / means["Time step size"], iterations=sum(v for key, v in means.items() if "terations" in key))


def words_for(settings):
    return ", ".join(f"{key.rsplit('.')[-1]} {value}" for key, value in (s.split("=") for s in settings)) or "defaults"


def peer_words(settings):
    flat = {**{k: v for k, v in settings.items() if k != "DFSPH"}, **settings.get("DFSPH", {})}
    return ", ".join(f"{key} {value:g}" for key, value in flat.items() if key != "timeStepSize") or "cflFactor 1, maxError 0.05"


@table("peer", "Whorl and SPlisHSPlasH: a dam break, a sinking block, a closed vortex; cost and error. The environment variable SPLISHSPLASH names its "
               "program SPHSimulator; without it its scenes are written into out/measure/peer/SPlisHSPlasH", "2 hours, an idle machine",
       files="docs/studies/peer_*.svg")
def peer(m):
    program, rows = os.environ.get("SPLISHSPLASH"), []
    if program and not Path(program).is_file():
        raise MeasureError(f'SPLISHSPLASH names "{program}", which is not a file; it must be the program SPHSimulator')
    for name, flow in flows.items():
        if not m.wanted(name):
            continue
        ours, theirs = [[] for _ in flow.cases], [[] for _ in flow.peer_cases]
        for k in range(repeats):
            for runs, settings in zip(ours, flow.cases):
                runs.append(whorl_run(m, flow, name, settings, k))
            for case, (runs, settings) in enumerate(zip(theirs, flow.peer_cases)):
                runs.append(peer_run(m, program, flow, name, settings, case, k))
        count, fronts = len(flow.lattice()), {"Whorl": [], "SPlisHSPlasH": []}
        for kind, words, runs in (*(("Whorl", words_for(s), r) for s, r in zip(flow.cases, ours)),
                                  *(("SPlisHSPlasH", peer_words(s), r) for s, r in zip(flow.peer_cases, theirs))):
            if m.dry or not all(runs):
                rows.append([name, kind, words, *["not run"] * 6])
                continue
            run, cpu = runs[0], median(r.cpu for r in runs)
            error = flow.error(run.frames)
            largest = max(p["density"].max() / rho - 1 for p in run.frames[1:])
            fronts[kind].append((cpu / flow.until, abs(error)))
            rows.append([name, kind, words, f"{run.steps:.0f}", f"{run.iterations:.1f}", f"{1e6 * cpu / (run.steps * count):.2f}",
                         f"{cpu / flow.until:.1f}", f"{error * 100:+.{flow.digits}f} %", percent(largest, 1)])

        def draw(axes):
            for (label, points), style in zip(fronts.items(), ("C0o-", "C1s--")):
                if points:
                    axes.loglog(*zip(*points), style, label=label)
            axes.set_xlabel("CPU s a simulated second")
            axes.set_ylabel(flow.error_name)
            axes.legend()

        if not m.dry and fronts["SPlisHSPlasH"]:
            m.write(f"docs/studies/peer_{name}.svg", drawing.figure(4, 3, draw))
    return markdown("flow | program | settings | steps | iterations | us per particle-step | CPU s per simulated s | error | largest density", rows)
