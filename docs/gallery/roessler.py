r"""
Roessler system: a cascade of period doublings, and cycles inside the attractor
================================================================================

.. math::

    x' = -y - z, \qquad y' = x + a y, \qquad z' = b + z (x - c)

From the cycle at :math:`c = 2.5` one call follows the whole cascade. At :math:`c = 5.7` the
attractor is chaotic, and the branches of the cascade, long unstable, are among the cycles that
span it.
"""

from comparison import Comparison

import slipfold as sf

model = sf.built_in_models()["roessler"]()
cycle = sf.periodic_orbit(model.replace(c=2.5))
diagram = sf.response(cycle, vary="c", span=(2.5, 5.7))
diagram.plot("x")
print(diagram.summary())

# %%
# The equilibria meet in a fold at :math:`c^2 = 4 a b`.

still = sf.response(
    model.replace(c=1.0), vary="c", span=(1, 0.2), settings=sf.Settings(largest_period=1)
)
fold = next(p for p in still.branches[0].special if p.type == "LP")

single, double = diagram.branches[0].orbit(-1), diagram.branches[1].orbit(-1)
doublings = [p.value for b in diagram.branches for p in b.special if p.type == "PD"]
# The source's own multiplier of the flow's direction is 1.000000003 instead of one.
source = "Cvitanovic et al., ChaosBook"
table = Comparison()
table.add("fold of equilibria c", fold.value, 2 * (model.a * model.b) ** 0.5, "exact")
table.add("c = 5.7, cycle 1: duration", single.duration, "5.88108845586", source, within=1e-9)
table.add("its multiplier", single.multipliers[0].real, "-2.403953527", source, within=1e-8)
table.add("c = 5.7, cycle 01: duration", double.duration, "11.7586260717", source, within=1e-9)
table.add("its multiplier", double.multipliers[0].real, "-3.512006980", source, within=1e-8)
ratio = (doublings[-2] - doublings[-3]) / (doublings[-1] - doublings[-2])
table.add("ratio of the last doublings", ratio, "4.669201609", "Feigenbaum 1978", within=0.15)
table.check("cycle 1 at c = 5.7", single)
table.check("cycle 01 at c = 5.7", double)
table
