"""Reference solutions of 2D flows by spectral and grid methods: the tables in scenes/studies/benchmarks."""
import numpy as np

from .registry import table

folder = "scenes/studies/benchmarks"


# Double shear layer

def double_shear_layer(n, nu=1e-4, thickness=1 / 30, across=0.05, times=np.linspace(0, 1.2, 13)):
    """Rows (time, energy over the initial energy, largest vorticity, mean square vorticity).

    Solves the vorticity equation on n x n Fourier modes. The highest third of the modes is 0, against aliasing of the products. Time steps
    are Runge-Kutta of fourth order, with the exact viscous decay as integrating factor. The box is 1 x 1; initially
    u = tanh((y - 1/4)/thickness) below the middle and tanh((3/4 - y)/thickness) above, v = across sin 2 pi (x + 1/4)."""
    k = 2 * np.pi * np.fft.fftfreq(n, 1 / n)
    kx, ky = k[:, None], k[None, : n // 2 + 1].copy()
    ky[0, -1] = abs(ky[0, -1])
    square = kx**2 + ky**2
    inverse = np.divide(1, square, where=square > 0, out=np.zeros_like(square))
    kept = (np.abs(kx) < 2 * np.pi * n / 3) & (ky < 2 * np.pi * n / 3)
    x, y = np.meshgrid(np.arange(n) / n, np.arange(n) / n, indexing="ij")
    u = np.where(y < 0.5, np.tanh((y - 0.25) / thickness), np.tanh((0.75 - y) / thickness))
    v = across * np.sin(2 * np.pi * (x + 0.25))
    vorticity = np.where(kept, 1j * kx * np.fft.rfft2(v) - 1j * ky * np.fft.rfft2(u), 0)

    def velocity(w):
        return np.fft.irfft2(1j * ky * inverse * w), np.fft.irfft2(-1j * kx * inverse * w)

    def advection(w):
        u, v = velocity(w)
        return -np.where(kept, np.fft.rfft2(u * np.fft.irfft2(1j * kx * w) + v * np.fft.irfft2(1j * ky * w)), 0)

    def measured(w):
        u, v = velocity(w)
        at_points = np.fft.irfft2(w)
        return (u**2 + v**2).mean() / 2, np.abs(at_points).max(), (at_points**2).mean()

    dt = 0.5 / n
    half = np.exp(-nu * square * dt / 2)
    rows, time, start = [], 0.0, measured(vorticity)[0]
    for until in times:
        while time < until - dt / 2:
            a = advection(vorticity)
            b = advection(half * (vorticity + dt / 2 * a))
            c = advection(half * vorticity + dt / 2 * b)
            d = advection(half * (half * vorticity + dt * c))
            vorticity = half * (half * (vorticity + dt / 6 * a) + dt / 3 * (b + c)) + dt / 6 * d
            time += dt
        energy, largest, square_mean = measured(vorticity)
        rows.append((until, energy / start, largest, square_mean))
    return np.array(rows)


@table("double_shear_layer_reference", "the double shear layer by a spectral method", "2 minutes", section=False,
       files=f"{folder}/double_shear_layer.csv")
def double_shear_layer_reference(m):
    m.say("160 x 160 and 240 x 240 Fourier modes, in Python")
    if m.dry:
        return
    coarse, fine = (double_shear_layer(n) for n in (160, 240))
    m.say(f"differences of the two: energy {abs(coarse[:, 1] - fine[:, 1]).max():.0e}, largest vorticity "
          f"{abs(coarse[:, 2] / fine[:, 2] - 1).max():.0e}")
    names = ["time", "energy", "largest_vorticity", "mean_square_vorticity"]
    m.write_csv(f"{folder}/double_shear_layer.csv", names,
                [dict(zip(names, (f"{t:.1f}", f"{e:.5f}", f"{w:.3f}", f"{q:.3f}"))) for t, e, w, q in fine])


# Lid-driven cavity

def differences(n, gather):
    """Points s_0 ... s_n on [0, 1], and matrices (n-1) x (n+1) of the first and second derivative at s_1 ... s_(n-1), of second order.
    s = q - gather sin(2 pi q)/(2 pi) for q in uniform steps, so the points are denser at both ends."""
    q = np.arange(2 * n + 1) / (2 * n)
    s = q - gather * np.sin(2 * np.pi * q) / (2 * np.pi)
    slope = (1 - gather * np.cos(2 * np.pi * q)) / n  # ds per step in q, at the points and between them
    first, second = np.zeros((n - 1, n + 1)), np.zeros((n - 1, n + 1))
    for k in range(n - 1):
        here, below, above = slope[2 * k + 2], slope[2 * k + 1], slope[2 * k + 3]
        first[k, k:k + 3] = [-0.5 / here, 0, 0.5 / here]
        second[k, k:k + 3] = [1 / (below * here), -1 / (below * here) - 1 / (above * here), 1 / (above * here)]
    return s[::2], first, second


class Cavity:
    """Steady flow in a unit square whose lid y = 1 moves with unit speed along x: stream function p and vorticity w on n x n cells,

        lap p + w = 0,  p_y w_x - p_x w_y = nu lap w,  p = 0 at the walls, and there w = -2 (p_1 + h u_wall)/h^2 (Thom 1933)

    Solved by Newton's method. The linear systems are block-tridiagonal, with one block per line of constant y, and solved directly."""

    def __init__(self, n, gather=0.7):
        self.n = n
        self.s, self.first, self.second = differences(n, gather)
        self.h = self.s[1]
        self.p, self.w = np.zeros((n + 1, n + 1)), np.zeros((n + 1, n + 1))  # [x, y]

    def set_walls(self):
        p, w, h = self.p, self.w, self.h
        w[0, :], w[-1, :] = -2 * p[1, :] / h**2, -2 * p[-2, :] / h**2
        w[:, 0], w[:, -1] = -2 * p[:, 1] / h**2, -2 * (p[:, -2] + h) / h**2

    def newton_step(self, nu):
        """Returns the largest change of the stream function."""
        n, m, d, dd = self.n, self.n - 1, self.first, self.second
        p, w = self.p, self.w
        self.set_walls()
        inner = slice(1, n)
        px, py, wx, wy = d @ p[:, inner], p[inner] @ d.T, d @ w[:, inner], w[inner] @ d.T
        lap_p, lap_w = dd @ p[:, inner] + p[inner] @ dd.T, dd @ w[:, inner] + w[inner] @ dd.T
        residual = np.concatenate([-(lap_p + w[inner, inner]), -(py * wx - px * wy - nu * lap_w)])  # [2 m, lines]
        wall = -2 / self.h**2  # derivative of w at a wall by the adjacent p
        ends = np.zeros((n + 1, m))
        ends[0, 0] = ends[-1, -1] = wall
        inverses, carried = [], []
        for j in range(m):  # line y_(j+1)
            u, v = py[:, j, None], -px[:, j, None]
            block = np.zeros((2 * m, 2 * m))
            block[:m, :m] = dd[:, inner] + dd[j, j + 1] * np.eye(m)
            block[:m, m:] = np.eye(m)
            block[m:, :m] = -wy[:, j, None] * d[:, inner] + np.diag(d[j, j + 1] * wx[:, j]) + (u * d - nu * dd) @ ends
            block[m:, m:] = (u * d - nu * dd)[:, inner] + np.diag(v[:, 0] * d[j, j + 1]) - nu * dd[j, j + 1] * np.eye(m)
            below, above = (self.neighbour_line(j, side, nu, wx[:, j], v[:, 0]) for side in (j, j + 2))
            if j == 0:
                block[m:, :m] += np.diag(wall * below[2])
            if j == m - 1:
                block[m:, :m] += np.diag(wall * above[2])
            right = residual[:, j].copy()
            if j > 0:
                block -= left_times(below, times_right(inverses[-1], above_before))
                right -= left_times(below, inverses[-1] @ carried[-1])
            inverses.append(np.linalg.inv(block))
            carried.append(right)
            above_before = above
        change = np.zeros((2 * m, m))
        for j in reversed(range(m)):
            right = carried[j]
            if j < m - 1:
                right = right - left_times(self.neighbour_line(j, j + 2, nu, wx[:, j], -px[:, j]), change[:, j + 1])
            change[:, j] = inverses[j] @ right
        p[inner, inner] += change[:m]
        w[inner, inner] += change[m:]
        self.set_walls()
        return np.abs(change[:m]).max()

    def neighbour_line(self, j, other, nu, wx, v):
        """Coupling of line j to line `other`, as diagonals: (p in the first equation, p in the second, w in the second)."""
        first, second = self.first[j, other], self.second[j, other]
        return np.full(self.n - 1, second), first * wx, first * v - nu * second

    def solve(self, reynolds):
        for _ in range(20):
            if self.newton_step(1 / reynolds) < 1e-12:
                return
        raise ArithmeticError(f"the cavity at Re {reynolds} does not converge")

    def profiles(self, at):
        """u(y) on x = 1/2 and v(x) on y = 1/2, at the coordinates `at`."""
        slope = np.full(self.n + 1, np.nan)
        middle = self.n // 2
        slope[1:-1] = self.first @ self.p[middle, :]
        slope[0], slope[-1] = 0, 1
        across = np.zeros(self.n + 1)
        across[1:-1] = -self.first @ self.p[:, middle]
        return interpolated(self.s, slope, at), interpolated(self.s, across, at)


def left_times(line, matrix):
    """The block of neighbour_line() times a vector or matrix."""
    m = len(line[0])
    a, b, c = line if matrix.ndim == 1 else (part[:, None] for part in line)
    return np.concatenate([a * matrix[:m], b * matrix[:m] + c * matrix[m:]])


def times_right(matrix, line):
    m = len(line[0])
    return np.concatenate([matrix[:, :m] * line[0] + matrix[:, m:] * line[1], matrix[:, m:] * line[2]], axis=1)


def interpolated(x, f, at):
    """Values of f at the coordinates `at`, by the polynomial of degree five through the six nearest points."""
    found = []
    for place in at:
        k = min(max(np.searchsorted(x, place) - 3, 0), len(x) - 6)
        nodes, values = x[k:k + 6], f[k:k + 6]
        weights = [np.prod([(place - b) / (a - b) for b in nodes if b != a]) for a in nodes]
        found.append(float(np.dot(weights, values)))
    return np.array(found)


def cavity_profiles(reynolds, at, cells=(64, 96)):
    """By Reynolds number: u(y) and v(x), extrapolated from two grids of second order, and the largest difference of the two grids."""
    found = {}
    grids = [Cavity(n) for n in cells]
    for re in reynolds:
        for grid in grids:
            grid.solve(re)
        coarse, fine = (np.array(grid.profiles(at)) for grid in grids)
        ratio = (cells[1] / cells[0])**2
        found[re] = (fine * ratio - coarse) / (ratio - 1), abs(fine - coarse).max()
    return found


@table("lid_driven_cavity_reference", "the lid-driven cavity on grids of 64 and 96 cells a side, extrapolated", "2 minutes", section=False,
       files=f"{folder}/lid_driven_cavity.csv")
def lid_driven_cavity_reference(m):
    m.say("64 x 64 and 96 x 96 cells, in Python")
    if m.dry:
        return
    at, numbers = np.arange(65) / 64, (100, 400, 1000)
    found = cavity_profiles(numbers, at)
    names = ["s", *(f"{c}_{re}" for re in numbers for c in "uv")]
    rows = []
    for k, s in enumerate(at):
        values = [found[re][0][c][k] for re in numbers for c in (0, 1)]
        rows.append(dict(zip(names, [f"{s:.6f}", *(f"{value + 0:.5f}" for value in values)])))
    for re in numbers:
        m.say(f"Re {re}: the two grids differ by at most {found[re][1]:.1e}")
    m.write_csv(f"{folder}/lid_driven_cavity.csv", names, rows)
