"""Cost of a step and memory by the number of particles, and what ten million particles would take."""
import numpy as np

from . import theory
from .registry import markdown, table

counts = (16_000, 65_000, 250_000, 1_000_000, 2_000_000)
steps = 20


def scene(name, count):
    """A scene of about `count` particles: steps of 0.2 d over the speed (g L)^(1/2) or u0, so that all sizes take the same share of a
    spacing, and 20 of them."""
    if name == "dam":  # a column twice as high as wide falls into a tank
        d, speed = (2 * 0.4**3 / count) ** (1 / 3), (theory.gravity * 0.8)**0.5
        parts = {"models": {"pressure": "ppe", "viscosity": "xsph"}, "block": [{"shape": "box", "min": [0, 0, 0], "max": [0.4, 0.8, 0.4]}],
                 "solid": [{"shape": "box", "min": [0, 0, 0], "max": [1.6, 1.2, 0.4], "container": True}],
                 "domain": {"min": [-0.1, -0.1, -0.1], "max": [1.7, 1.3, 0.5]}, "fluid": {"spacing": d, "viscosity": 0}}
    elif name == "honey":  # a cube sinks on a plate
        d, speed = (0.2**3 / count) ** (1 / 3), (theory.gravity * 0.2)**0.5
        parts = {"models": {"pressure": "coupled"}, "block": [{"shape": "box", "min": [-0.1, 0, -0.1], "max": [0.1, 0.2, 0.1]}],
                 "solid": [{"shape": "plane", "normal": [0, 1, 0]}], "domain": {"min": [-0.4, -0.1, -0.4], "max": [0.4, 0.3, 0.4]},
                 "fluid": {"spacing": d, "viscosity": 100}}
    else:  # Taylor-Green cells in a periodic box with spin, curl u/2 at the start
        cells = 2 * round((count / 2) ** (1 / 3) / 2)
        d, speed = 1 / cells, 1
        parts = {"models": {"pressure": "ppe", "viscosity": "full", "micropolar": "eringen"},
                 "micropolar": {"transfer_viscosity": 0.1},
                 "block": [{"shape": "box", "min": [0, 0, 0], "max": [1, 1, 2], "spin": ["0", "0", "2*pi*sin(2*pi*x)*sin(2*pi*y)"],
                            "velocity": ["sin(2*pi*x)*cos(2*pi*y)", "-cos(2*pi*x)*sin(2*pi*y)", "0"]}],
                 "domain": {"min": [0, 0, 0], "max": [1, 1, 2], "periodic": [True, True, True], "gravity": [0, 0, 0]},
                 "fluid": {"spacing": d, "viscosity": 1}}
    step = 0.2 * d / speed
    return {"name": name, "time": {"end": steps * step, "fps": 1 / (steps * step), "max_step": step}, **parts}


def speed_up(m, name):
    """Wall time on one thread over that on two, for 250,000 particles."""
    one, two = (m.render(m.toml_file(f"growth/{name}-threads", scene(name, 250_000)), f"growth/{name}-threads-{k}", threads=k).report
                for k in (1, 2))
    return one["wall_seconds"] / two["wall_seconds"]


@table("growth", f"cost of a step and memory of a dam, a cube of honey and vortices, 16,000 to 2,000,000 particles, {steps} steps on one thread; what "
                 "a second of ten million particles would take", "40 minutes, 3 GB, an idle machine")
def growth(m):
    rows, films = [], []
    for name in ("dam", "honey", "vortices"):
        found, large = [], 1e7
        for count in counts:
            if m.wanted(f"{name}-{count}"):
                r = m.render(m.toml_file(f"growth/{name}-{count}", scene(name, count)), f"growth/{name}-{count}-run")
                found.append((r.report["particles"], r.microseconds, r.iterations_per_step, r.report["peak_memory_bytes"]))
        if not found:
            continue
        particles, cost, iterations, memory = map(np.array, zip(*found))
        further = [np.nan, *(np.diff(memory) / np.diff(particles))]
        rows += [[name, f"{n:,.0f}", f"{us:.2f}", f"{i:.1f}", f"{b / 1e6:.0f}", f"{more:.0f}" if more == more else ""]
                 for n, us, i, b, more in zip(particles, cost, iterations, memory, further)]
        if len(found) == len(counts) and not m.dry:
            slope = np.polyfit(np.log(particles[-3:]), np.log(cost[-3:]), 1)[0]
            us = cost[-1] * (large / particles[-1])**slope
            a_second = 0.5 / scene(name, large)["time"]["max_step"]  # steps of 0.4 d over the speed
            gain = speed_up(m, name)
            parallel = 2 - 2 / gain  # share of the work that a second thread halves (Amdahl's law)
            hours = a_second * large * us / 3.6e9
            films.append([name, f"{slope:+.2f}", f"{us:.1f}", f"{(memory[-1] + further[-1] * (large - particles[-1])) / 1e9:.1f}", f"{a_second:.0f}",
                          f"{gain:.2f}", *(f"{hours * (1 - parallel + parallel / cores):.0f}" for cores in (2, 16))])
    sizes = markdown("flow | particles | us per particle-step | iterations per step | peak memory, MB | bytes per further particle", rows)
    if not films:
        return sizes
    return (sizes + "\n\nTen million particles, from the slope of the last three sizes and the speed-up by a second thread:\n\n" +
            markdown("flow | exponent of the cost | us per particle-step | memory, GB | steps a second | speed-up by two threads | hours per simulated "
                     "second, 2 cores | 16 cores", films))


@table("law_costs", "cost of a cube of honey with a yield stress, a flow index and heat, beside the same cube without them", "10 minutes, an idle machine")
def law_costs(m):
    base = {"name": "cube", "time": {"end": 0.1, "fps": 10}, "domain": {"min": [-0.1, -0.02, -0.1], "max": [0.1, 0.12, 0.1]},
            "fluid": {"spacing": 2.4e-3, "viscosity": 50, "density": 1400},
            "block": [{"shape": "box", "min": [-0.03, 0, -0.03], "max": [0.03, 0.06, 0.03]}], "solid": [{"shape": "plane"}]}
    power = {"spacing": 2.4e-3, "density": 1400, "yield_stress": 20, "consistency": 50, "flow_index": 0.5}
    cases = {"50 Pa s": {}, "yield stress of 20 Pa": {"fluid": {**base["fluid"], "yield_stress": 20}},
             "the same with flow index 0.5": {"fluid": power},
             "50 Pa s at 300 K on a plate of 350 K": {"block": [{**base["block"][0], "temperature": 300}], "heat": {"conductivity": 0.4, "capacity": 2000},
                                                     "solid": [{"shape": "plane", "temperature": 350}]}}
    rows = []
    for k, (name, parts) in enumerate(cases.items()):
        runs = [m.render(m.toml_file(f"law_costs/{k}", {**base, **parts}), f"law_costs/{k}-{again}", threads=1) for again in range(3)]
        r = min(runs, key=lambda run: run.microseconds)
        cost = r.microseconds
        first = cost if k == 0 else first
        rows.append([name, f"{r.report['steps']:.0f}", f"{r.iterations_per_step:.0f}", f"{cost:.1f}", f"{cost / first:.2f}"])
    return markdown("fluid | steps | iterations per step | us per particle-step | ratio", rows)
