r"""
Planar friction: damping that depends on direction
===================================================

Friction in the plane acts along the relative velocity :math:`w`, so motion across the slip meets
another damping than motion along it. With a speed-dependent coefficient, normal force :math:`N` and
slip speed :math:`V` in direction :math:`e`, small motions feel the damping matrix

.. math::

    N \left[\mu'(V)\, e e^T + \frac{\mu(V)}{V} (I - e e^T)\right].

Across the slip it is always positive, and large where sliding is slow: this is what an oscillator
regularized component by component would miss.
"""

import math

import matplotlib.pyplot as plt
import numpy as np
from comparison import Comparison

import slipfold as sf

law = sf.Stribeck(mu_s=0.6, mu_k=0.3, vs=0.4)
law.plot()
plt.show()

# %%
# The matrix by formula, and by differences of the force: a check that shares nothing but the law.

speed, normal, alpha = 0.6, 1.5, math.pi / 3
e = np.array([math.cos(alpha), math.sin(alpha)])
damping = law.damping(speed, normal=normal, direction=alpha)


def mu(v: float) -> float:
    return 0.3 + 0.3 * math.exp(-v / 0.4)


def force(v: np.ndarray) -> np.ndarray:
    w = speed * e - v
    r = np.linalg.norm(w)
    return normal * mu(r) * w / r


step = 1e-6
columns = [(force(step * axis) - force(-step * axis)) / (2 * step) for axis in np.eye(2)]
by_differences = -np.array(columns).T

along = normal * -0.3 / 0.4 * math.exp(-speed / 0.4)
across = normal * mu(speed) / speed
exact = along * np.outer(e, e) + across * (np.eye(2) - np.outer(e, e))

table = Comparison()
for i, j in ((0, 0), (0, 1), (1, 1)):
    name = f"damping {'xy'[i]}{'xy'[j]} in N s/m"
    table.add(name, damping[i, j], float(exact[i, j]), "closed form")
    table.add(
        "the same by differences",
        by_differences[i, j],
        float(exact[i, j]),
        "closed form",
        within=1e-8,
    )
table
