r"""
Chaos at a grazing
==================

A mass on a belt of speed 1 whose friction falls and rises again, under a weak force:

.. math::

    x'' + x = C(1 - x') + F \cos W t, \qquad
    C(v) = \tfrac32 \operatorname{sgn} v - \tfrac32 v + 0.45\, v^3

Its orbit of period 4 slips all the time. Where its slip first reaches zero it becomes unstable at
once, and what follows is chaos: no cascade of period doublings comes before.
"""

import math

import matplotlib.pyplot as plt
import numpy as np
from comparison import Comparison

import slipfold as sf

turn = 2 * math.pi
slowest = math.sqrt(1.5 / (3 * 0.45))
law = sf.CubicStribeck(mu_s=1.5, mu_m=1.5 - slowest, vm=slowest)
contact = sf.FrictionContact("x", law, load=1.0, Vd=1.0)
force = sf.HarmonicForce("x", F=0.1)
mass = sf.Structure([[1.0]], None, [[1.0]], names="x", contacts=contact, forcing=force)

# %%
# The branch of period 2 that a trajectory converges to, and what doubles on it.

start = {"f": 1.72 / turn, "x": 0.0}
diagram = sf.response(mass, "f", (1.66 / turn, 1.73 / turn), start=start, settled=True)
diagram.plot("x")
print(diagram.summary())

# %%
# At a GRAZE the derivative of the return map jumps. At the one of the branch of period 2 a
# multiplier of 1.85 becomes one of -1.26; none passes -1. Still the branch of period 4 begins
# there, which ends at the PD, and from its own GRAZE to this one leads a branch of period 8.

single, double, fourfold = diagram.branches
early, late = (
    next(point for point in branch.special if point.type == "GRAZE") for branch in (single, double)
)
print(early.leads_to, late.leads_to)

# %%
# Above the grazing of the orbit of period 4 trajectories converge to it. Below, they do not.

table = Comparison()
source = "di Bernardo, Kowalczyk and Nordmark 2003"
table.add("slip of period 4 reaches zero: W", turn * late.value, "1.7077997", source)
end = "where the branch of period 4 begins"
table.add("period 8 closes: f", fourfold.stopped.value, early.value, end, within=1e-9)

state = double.orbit(int(np.abs(double.parameter - late.value).argmin())).state
for frequency in (1.7079, 1.7077):
    print(frequency, sf.lyapunov(mass, state=state, f=frequency / turn))

# %%
# States once a forcing period, from W = 1.715 down to 1.685: the doubling, the grazing, and bands
# of chaos that widen in proportion to the distance from it.

swept = sf.sweep(
    mass, "f", (1.715 / turn, 1.685 / turn), points=41, runs=("up",), starts=0, state=state
)
swept.plot("vx")
plt.show()

# %%

table
