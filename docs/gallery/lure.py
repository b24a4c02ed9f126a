r"""
Lur'e's control system: Hopf, then a doubled cycle
===================================================

.. math::

    x''' + a x'' + b x' + x - x^2 = 0

The tutorial of MatCont, which BifurcationKit.jl repeats. From the equilibrium at large :math:`a`
one command finds the Hopf point, the cycle that emanates there, its period doubling, and the
doubled cycle.
"""

from comparison import Comparison

import slipfold as sf

model = sf.built_in_models()["lure"]()
diagram = sf.response(model, vary="a", span=(1.2, 0.55), settings=sf.Settings(largest_period=2))
diagram.plot("x")
print(diagram.summary())

# %%

hopf = diagram.branches[0].special[0]
doubling = next(point for point in diagram.branches[1].special if point.type == "PD")
smallest = min(doubling.multipliers.real, key=abs)
source = "MatCont manual; collocation and integration"
table = Comparison()
table.add("Hopf point a", hopf.value, 1.0, "exact")
table.add("first Lyapunov coefficient", hopf.coefficient, "-0.3", "MatCont manual", within=1e-9)
table.add("period doubling a", doubling.value, "0.6303020061596", source)
table.add("its duration", doubling.duration, "6.3640713394414", source)
table.add("its smallest multiplier", smallest, "-0.01811007", source)
table.check("cycle at its doubling", doubling.orbit)
table
