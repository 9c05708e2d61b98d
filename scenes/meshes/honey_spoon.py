"""Writes honey_spoon.obj, the spoon of honey_jar.toml: python3 honey_spoon.py > honey_spoon.obj"""
from math import cos, hypot, pi, sin

around = 40  # points on each ring


def rings(profile, place):
    """Points of rings round an axis, for each (radius, height) of the profile; place: (angle, radius, height) to a point."""
    return [[place(2 * pi * k / around, r, y) for k in range(around)] for r, y in profile]


def closed(rows, first_vertex):
    """Faces between neighbouring rings, and a lid on each end."""
    at = lambda row, k: first_vertex + row * around + k % around
    faces = [[at(i, k), at(i, k + 1), at(i + 1, k + 1), at(i + 1, k)] for i in range(len(rows) - 1) for k in range(around)]
    last = len(rows) - 1
    return faces + [[at(0, k) for k in reversed(range(around))], [at(last, k) for k in range(around)]]


def bowl(width=0.019, depth=0.015, wall=0.0035, stretch=1.2):
    """The lower half of an ellipsoid with a round rim, longer along x; its rim is at y = 0."""
    n = 14
    outer = [(width * sin(pi / 2 * i / n), -depth * cos(pi / 2 * i / n)) for i in range(1, n)]
    rim = [(width - wall / 2 + wall / 2 * cos(a), wall / 2 * sin(a)) for a in (pi * i / 8 for i in range(9))]
    inner = [((width - wall) * sin(pi / 2 * i / n), -(depth - wall) * cos(pi / 2 * i / n)) for i in reversed(range(1, n))]
    return rings(outer + rim + inner, lambda angle, r, y: (stretch * r * cos(angle), y, r * sin(angle)))


def handle(path=((0.021, -0.002), (0.034, 0.001), (0.036, 0.03), (0.07, 0.13)), thick=0.0036, steps=40):
    """A rod along a Bezier curve in the plane z = 0, thicker and round at its upper end."""
    rows = []
    for i in range(steps + 1):
        t = i / steps
        weights = ((1 - t)**3, 3 * t * (1 - t)**2, 3 * t * t * (1 - t), t**3)
        slopes = (-3 * (1 - t)**2, 3 * (1 - t) * (1 - 3 * t), 3 * t * (2 - 3 * t), 3 * t * t)
        x, y = (sum(w * p[c] for w, p in zip(weights, path)) for c in (0, 1))
        dx, dy = (sum(w * p[c] for w, p in zip(slopes, path)) for c in (0, 1))
        length = hypot(dx, dy)
        r = thick * (1 + 0.4 * t) * min(1, ((1.02 - t) / 0.05)**0.5)
        rows.append([(x + r * cos(a) * dy / length, y - r * cos(a) * dx / length, r * sin(a))
                     for a in (2 * pi * k / around for k in range(around))])
    return rows


print("# A wooden spoon with a round bowl [m]")
vertex = 1
for rows in (bowl(), handle()):
    for row in rows:
        for point in row:
            print("v", *(f"{c:.5f}" for c in point))
    for face in closed(rows, vertex):
        print("f", *face)
    vertex += len(rows) * around
