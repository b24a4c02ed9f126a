r"""
A chain of ten masses with a friction contact at its end
=========================================================

Ten equal masses and springs; the last one slides on a belt. Friction falls with the belt's speed,
and the mode that is damped least begins to squeal first. Twenty states, the same three lines.
"""

import numpy as np
from comparison import Comparison
from scipy.linalg import eigvals
from scipy.optimize import brentq

import slipfold as sf

n, k = 10, 100.0
stiffness = k * (2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1))
stiffness[-1, -1] = k
damping = 0.05 * np.eye(n) + 0.0005 * stiffness
belt = sf.FrictionContact("q10", sf.Stribeck(mu_s=0.5, mu_k=0.3, vs=0.4), load=10.0, Vd=3.0)
chain = sf.Structure(np.eye(n), damping, stiffness, contacts=belt)
# By shooting, which ends where the last mass would begin to stick: branches are long beyond.
settings = sf.Settings(largest_period=1, discretization="shooting")
diagram = sf.response(chain, vary="Vd", span=(3, 0.8), settings=settings)
diagram.plot("q10")
print(diagram.summary())

# %%
# The first loss of stability by SciPy: eigenvalues of the chain with the damping that steady slip
# gives its last mass.


def growth(speed: float) -> float:
    c = damping.copy()
    c[-1, -1] += -10 * 0.2 / 0.4 * np.exp(-speed / 0.4)
    return float(eigvals(np.block([[np.zeros((n, n)), np.eye(n)], [-stiffness, -c]])).real.max())


hopf = next(p for p in diagram.branches[0].special if p.type == "HB")
first = diagram.branches[0].states[0]
drag = 10 * (0.3 + 0.2 * np.exp(-3 / 0.4))
table = Comparison()
table.add(
    "onset of squeal Vd in m/s", hopf.value, float(brentq(growth, 0.8, 3, xtol=1e-14)), "SciPy"
)
table.add("displacement of the end at Vd = 3 m/s, in m", first[9], 10 * drag / k, "closed form")
cycles = diagram.branches[hopf.leads_to - 1]
table.check("vibration of 20 states", cycles.orbit(len(cycles) // 2))
table
