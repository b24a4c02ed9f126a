r"""
The sliding oscillator squeals by itself
=========================================

Without the pulsation of the normal force, steady sliding of the paper's oscillator is an
equilibrium. With a coefficient of friction that falls with speed it loses stability in a Hopf
bifurcation as the plate slows down. The onset is followed in a second parameter; friction across
the slip damps, so the direction of the plate matters.
"""

import matplotlib.pyplot as plt
import numpy as np
from comparison import Comparison
from scipy.optimize import brentq, root

import slipfold as sf

law = sf.Stribeck(mu_s=0.9, mu_k=0.3, vs=0.3)
steady = sf.SlidingOscillator(friction=law).steady()
settings = sf.Settings(largest_period=1)
diagram = sf.response(steady, vary="Vd", span=(0.9, 0.6), settings=settings)
diagram.plot("x")
print(diagram.summary())

# %%
# The onset in the speed of the plate and its direction.

hopf = next(point for point in diagram.branches[0].special if point.type == "HB")
window = {"Vd": (0.3, 1.2), "alpha": (0, np.pi / 2)}
onset = sf.locus(hopf, vary=("Vd", "alpha"), window=window)
onset.plot()
plt.show()

# %%
# The same by SciPy, from equations written by hand: the static point, then the eigenvalues of a
# Jacobian by differences.

k1, k2, f1, f2, z1, z2, kext, length = 317.98, 362.58, 6.12, 6.59, 0.006, 0.0057, 1000, 0.005
m1, m2 = k1 / (2 * np.pi * f1) ** 2, k2 / (2 * np.pi * f2) ** 2
c1, c2 = 4 * np.pi * z1 * m1 * f1, 4 * np.pi * z2 * m2 * f2


def rates(q: np.ndarray, speed: float) -> np.ndarray:
    x, y, vx, vy = q
    spring = 1 - 1 / np.hypot(1 + y, x)
    slip = speed * np.array([0.5, 3**0.5 / 2]) - length * np.array([vx, vy])
    size = np.hypot(*slip)
    drag = (0.3 + 0.6 * np.exp(-size / 0.3)) * slip / size / length
    ax = (drag[0] - c2 * vx - k2 * x - kext * spring * x) / m2
    ay = (drag[1] - c1 * vy - k1 * y - kext * spring * (1 + y)) / m1
    return np.array([vx, vy, ax, ay])


def growth(speed: float) -> float:
    rest = root(rates, [0.1, 0.05, 0, 0], args=(speed,), tol=1e-14).x
    h = 1e-5 * np.array([1, 1, 40, 40])
    columns = [
        (rates(rest + d, speed) - rates(rest - d, speed)) / (2 * d.sum()) for d in np.diag(h)
    ]
    return float(np.linalg.eigvals(np.array(columns).T).real.max())


by_scipy = float(brentq(growth, 0.55, 0.75, xtol=1e-13))
table = Comparison()
table.add("onset of squeal Vd in m/s", hopf.value, by_scipy, "SciPy", within=1e-7)
cycles = diagram.branches[hopf.leads_to - 1]
table.check("a squealing oscillator", cycles.orbit(len(cycles) // 2))
table
