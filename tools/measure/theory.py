"""Exact solutions for comparison; analysis of signals and point clouds."""
import numpy as np

gravity = 9.81


def falling_thread_speed(nu, speed, fall):
    """Speed u(z) of a steady thread that falls freely and is removed without tension at z = fall: (distances z below the nozzle [m], speeds
    [m/s]).

    u a^2 is constant and 3 nu (u'/u)' + g/u - u' = 0 (Trouton 1906 with inertia). It is integrated upward, which is stable.
    Bisection finds the speed at the end that gives `speed` at the nozzle."""
    steps = 2500
    h = fall / steps

    def integrate(end):
        u, s = end, 0.0  # s = u'/u
        speeds = [u]
        for _ in range(steps):
            um, sm = u - h / 2 * u * s, s - h / 2 * (u * s - gravity / u) / (3 * nu)
            u, s = u - h * um * sm, s - h * (um * sm - gravity / um) / (3 * nu)
            if u <= 0:
                return [0.0]
            speeds.append(u)
        return speeds

    low, high = speed, 100 * speed
    for _ in range(50):
        middle = (low + high) / 2
        low, high = (middle, high) if integrate(middle)[-1] < speed else (low, middle)
    return np.linspace(0, fall, steps + 1), np.array(integrate(high)[::-1])


def frequency(time, signal):
    """Frequency of a signal that oscillates about its mean, from its upward crossings of the mean. Oscillations below 0.2 standard
    deviations are noise. 0 if there are fewer than two crossings."""
    mean, noise = signal.mean(), 0.2 * signal.std()
    ups, below = [], False
    for t, s in zip(time, signal - mean):
        if s < -noise:
            below = True
        elif below and s > noise:
            ups.append(t)
            below = False
    return (len(ups) - 1) / (ups[-1] - ups[0]) if len(ups) > 1 else 0.0


def zeros(time, signal, apart):
    """Times at which a signal changes sign, interpolated linearly. A zero less than `apart` after the previous one is left out."""
    found = []
    for t0, t1, a, b in zip(time, time[1:], signal, signal[1:]):
        if a * b < 0 and (zero := t0 + (t1 - t0) * a / (a - b)) > (found[-1] + apart if found else 0):
            found.append(zero)
    return found


def longest_link(points):
    """Longest edge of the minimum spanning tree of the points (Prim). A gap in a thread makes it long."""
    left = np.ones(len(points), bool)
    nearest, at, longest = np.full(len(points), np.inf), 0, 0.0
    for _ in range(len(points) - 1):
        left[at] = False
        nearest = np.minimum(nearest, np.linalg.norm(points - points[at], axis=1))
        at = int(np.argmin(np.where(left, nearest, np.inf)))
        longest = max(longest, nearest[at])
    return longest
