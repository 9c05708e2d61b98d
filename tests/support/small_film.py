"""A small run of honey, for scripts that run it under adverse conditions and compare the results."""
TIMES = ("wall_seconds", "cpu_seconds")  # columns that differ from run to run


def film(end, spacing, size, more=""):
    """The scene as text; it ends with its [look], which `more` continues. end: s; spacing: m; size: of a picture, "64, 36"."""
    return f"""
[time]
end = {end}
fps = 40
[domain]
min = [-0.05, -0.01, -0.05]
max = [0.05, 0.06, 0.05]
[fluid]
spacing = {spacing}
viscosity = 50
[[block]]
shape = "box"
min = [-0.012, 0.0, -0.012]
max = [0.012, 0.024, 0.012]
[[emitter]]
position = [0, 0.045, 0]
radius = 6e-3
speed = 0.3
[[solid]]
shape = "plane"
[output]
size = [{size}]
checkpoint_every = 0.001
[look]
samples = 1
{more}"""


def rows(file):
    """The table without the columns of times."""
    lines = [line.split(",") for line in file.read_text().splitlines()]
    kept = [k for k, name in enumerate(lines[0]) if name not in TIMES]
    return [[line[k] for k in kept] for line in lines]
