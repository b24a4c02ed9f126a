r"""
Stuart-Landau oscillator: a Hopf bifurcation in its normal form
===============================================================

.. math::

    x' = r x - w y - x (x^2 + y^2), \qquad y' = w x + r y - y (x^2 + y^2)

Rest is stable for :math:`r < 0`. At :math:`r = 0` a cycle is born whose radius is :math:`\sqrt r`,
whose duration is :math:`2 \pi / w` and whose multiplier is :math:`e^{-4 \pi r / w}`: everything is
known, so everything can be checked.
"""

import math

from comparison import Comparison

import slipfold as sf

model = sf.built_in_models()["stuart-landau"]()
diagram = sf.response(model, vary="r", span=(-0.5, 0.5))
diagram.plot("radius")
print(diagram.summary())

# %%
# The first branch is the equilibrium, the second the cycle that was switched to at the Hopf point
# by itself.

still, cycles = diagram.branches
(hopf,) = still.special
last = cycles.orbit(-1)

table = Comparison()
table.add("Hopf point r", hopf.value, 0.0, "exact")
table.add("duration at the Hopf point", hopf.duration, 2 * math.pi / model.w, "exact")
table.add("radius at r = 0.5", last.extrema.of("radius")[1][0], math.sqrt(0.5), "exact")
table.add("duration at r = 0.5", last.duration, 2 * math.pi / model.w, "exact")
table.add("multiplier at r = 0.5", last.multipliers[1].real, math.exp(-2 * math.pi), "exact")
table.check("cycle at r = 0.5", last)
table
