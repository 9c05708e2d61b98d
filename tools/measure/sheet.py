"""A viscous sheet that falls on a floor and folds, as a line in 2D that stretches and bends (Ribe 2003, Phys. Rev. E 68, 036305)."""
import numpy as np

from .registry import table
from .theory import frequency, gravity


class Sheet:
    """Nodes on the sheet's midline, from the slot downward. A segment of length l and thickness h resists stretching with the tension
    4 mu h l'/l. Two neighbouring segments resist bending with the moment (mu h^3/3) (w_2 - w_1)/l, where w are their rates of rotation.
    The velocities v minimise

        sum (4 mu h/l) (t . dv)^2/2 + sum (mu h^3/(3 l)) (w_2 - w_1)^2/2 + sum m (v - v_before)^2/(2 dt) - sum m g . v

    h l of a segment is constant. A node that reaches the floor stays there. The slot keeps the first segment vertical."""

    def __init__(self, viscosity, density, thickness, speed, fall, node=1e-3, kept=12):
        self.mu, self.rho, self.h0, self.speed, self.node, self.kept = viscosity, density, thickness, speed, node, kept
        self.x = np.array([[1e-5, fall - 2 * node], [0, fall - node], [0, fall]])[::-1].copy()  # slot first; not quite straight
        self.v = np.tile([0.0, -speed], (3, 1))
        self.area = np.full(2, thickness * node)
        self.stuck = np.zeros(3, bool)
        self.fall = fall

    def step(self, dt):
        n, dx = len(self.x), np.diff(self.x, axis=0)
        l = np.linalg.norm(dx, axis=1)
        t = dx / l[:, None]
        normal = np.stack([-t[:, 1], t[:, 0]], axis=1)
        h = self.area / l
        matrix, load = np.zeros((2 * n, 2 * n)), np.zeros(2 * n)

        def add(nodes, row, weight):
            """weight (row . v)^2/2 of these nodes' velocities"""
            index = np.array([2 * k + c for k in nodes for c in (0, 1)])
            matrix[np.ix_(index, index)] += weight * np.outer(row, row)

        for k in range(n - 1):
            add((k, k + 1), np.r_[-t[k], t[k]], 4 * self.mu * h[k] / l[k])
        for k in range(n - 2):
            low, high = normal[k] / l[k], normal[k + 1] / l[k + 1]
            add((k, k + 1, k + 2), np.r_[low, -low - high, high], self.mu * (h[k]**3 + h[k + 1]**3) / 6 / ((l[k] + l[k + 1]) / 2))
        mass = self.rho * (np.r_[self.area, 0] + np.r_[0, self.area]) / 2
        matrix[np.arange(2 * n), np.arange(2 * n)] += np.repeat(mass, 2) / dt
        load += np.repeat(mass, 2) * (self.v / dt + [0, -gravity]).ravel()
        fixed = self.stuck.copy()
        fixed[:2] = True
        given = np.zeros((n, 2))
        given[:2] = [0, -self.speed]
        free = np.repeat(~fixed, 2)
        load -= matrix @ given.ravel()
        v = given.ravel()
        v[free] = np.linalg.solve(matrix[np.ix_(free, free)], load[free])
        self.v = v.reshape(-1, 2)
        self.x = self.x + dt * self.v
        self.stuck |= self.x[:, 1] <= 0.5 * np.r_[h, h[-1]]
        if self.x[0, 1] < self.fall - self.node:  # a new segment leaves the slot
            self.x = np.vstack([self.x[0] + [0, self.node], self.x])
            self.v = np.vstack([[0, -self.speed], self.v])
            self.area, self.stuck = np.r_[self.h0 * self.node, self.area], np.r_[False, self.stuck]
        first = int(np.argmax(self.stuck)) if self.stuck.any() else len(self.x)
        last = first + self.kept  # segments that were laid earlier have no effect
        self.x, self.v, self.stuck, self.area = self.x[:last], self.v[:last], self.stuck[:last], self.area[:last - 1]
        self.h = self.area / np.linalg.norm(np.diff(self.x, axis=0), axis=1)

    def at(self, height):
        """x, thickness and speed of the sheet at its first node below a height."""
        k = int(np.argmax(self.x[:, 1] < height))
        return self.x[k, 0], self.h[min(k, len(self.h) - 1)], float(np.hypot(*self.v[k]))


@table("folding_sheet_reference", "a sheet that folds, as a line that stretches and bends", "2 minutes", section=False,
       files="scenes/studies/laboratory/folding_sheet.csv")
def folding_sheet_reference(m):
    """Reference for folding_sheet.toml, 45 mm below the slot, from 1.3 to 4 s. The floor is 2 cm higher than the scene's: the mean height
    of its heap."""
    names, rows, dt = ["viscosity", "frequency", "thickness", "speed"], [], 2e-3
    for viscosity in (50, 100, 200):
        m.say(f"{viscosity} Pa s, in Python")
        sheet, found = Sheet(viscosity, 1000, 6e-3, 0.1, 0.08), []
        for k in range(0 if m.dry else 2000):
            sheet.step(dt)
            if sheet.x[:, 1].min() < 0.035 and k * dt > 1.3:
                found.append((k * dt, *sheet.at(0.035)))
        if found:
            time, place, thickness, speed = np.array(found).T
            values = (viscosity, f"{frequency(time, place):.3f}", f"{thickness.mean():.5f}", f"{speed.mean():.4f}")
            rows.append(dict(zip(names, values)))
    if not m.dry:
        m.write_csv("scenes/studies/laboratory/folding_sheet.csv", names, rows)
