r"""
Van der Pol's oscillator: free, and torn from its forcing
==========================================================

.. math::

    x'' - \mu (1 - x^2) x' + x = a \cos w t

Free, it has one cycle for every :math:`\mu > 0`. A force near its own frequency entrains it, until
a Neimark-Sacker bifurcation lets go.
"""

from comparison import Comparison

import slipfold as sf

free = sf.built_in_models()["vanderpol-free"]()
cycle = sf.periodic_orbit(free)
diagram = sf.response(cycle, vary="mu", span=(1, 10))
axes = diagram.plot("x")

# %%
# Under a force the response is entrained between two Neimark-Sacker points.

forced = sf.built_in_models()["vanderpol"]()
entrained = sf.response(forced, vary="w", span=(1, 1.3))
entrained.plot("x")
print(entrained.summary())

# %%

torus = next(point for point in entrained.branches[0].special if point.type == "NS")
source = "two integrators, 13 digits"
table = Comparison()
table.add("free, mu = 1: duration", cycle.duration, "6.663286859323", source)
table.add("free, mu = 1: amplitude", cycle.extrema.of("x")[1][0], "2.008619860875", source)
table.add("free, mu = 1: multiplier", cycle.multipliers[1].real, "8.596950640e-4", source)
table.add("forced: NS at w", torus.value, "1.086728948108", source)
table.add("forced: real part of its multiplier", torus.critical_multiplier.real, "0.915559", source)
table.add("forced: imaginary part", torus.critical_multiplier.imag, "0.402185", source)
table.check("free, mu = 1", cycle)
table.check("forced, at the NS", torus.orbit)
table
