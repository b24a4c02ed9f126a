"""The sliding oscillator written by hand, in meters and seconds, with no code of the package.

Everything is analytic, so that complex steps differentiate it to rounding.
"""

import numpy as np
from scipy.integrate import solve_ivp

BASE = {
    "k1": 317.98,
    "zeta1": 0.006,
    "f1": 6.12,
    "k2": 362.58,
    "zeta2": 0.0057,
    "f2": 6.59,
    "kext": 1000.0,
    "L": 5e-3,
    "f": 12.5,
    "Nd": 0.0,
    "Ns": 1.0,
    "mu": 0.5,
    "alpha": np.pi / 3,
    "Vd": 0.6,
}


def rhs(time, state, p):
    """Rates of (x/L, y/L, d(x/L)/dt, d(y/L)/dt): equations (1)-(7) as the design page has them."""
    L, Vd, alpha = p["L"], p["Vd"], p["alpha"]
    x, y, vx, vy = (L * component for component in state)
    m1 = p["k1"] / (2 * np.pi * p["f1"]) ** 2
    m2 = p["k2"] / (2 * np.pi * p["f2"]) ** 2
    c1 = 4 * np.pi * p["zeta1"] * m1 * p["f1"]
    c2 = 4 * np.pi * p["zeta2"] * m2 * p["f2"]
    length = np.sqrt((L + y) ** 2 + x**2)
    wx, wy = Vd * np.cos(alpha) - vx, Vd * np.sin(alpha) - vy
    speed = np.sqrt(wx**2 + wy**2)
    friction = p["mu"] * (p["Ns"] + p["Nd"] * np.cos(2 * np.pi * p["f"] * time))
    spring = p["kext"] * (length - L) / length
    ax = (friction * wx / speed - c2 * vx - p["k2"] * x - spring * x) / m2
    ay = (friction * wy / speed - c1 * vy - p["k1"] * y - spring * (L + y)) / m1
    return np.array([vx, vy, ax, ay]) / L


def integrate(state, p, periods=1.0):
    """State after some forcing periods, by SciPy."""
    end = periods / p["f"]
    # A complex state tells solve_ivp to keep the imaginary part that a parameter brings in.
    start = np.asarray(state) + 0 * sum(p.values())
    return end_of(lambda s, q: end * rhs(s * end, q, p), 1.0, start, atol=1e-14)


def end_of(rates, duration, start, *given, atol=1e-12):
    """Return the last state of a trajectory, by SciPy; `given` follows time and state."""
    exact = {"method": "DOP853", "rtol": 1e-12, "atol": atol}
    return solve_ivp(rates, (0.0, duration), start, args=given or None, **exact).y[:, -1]
