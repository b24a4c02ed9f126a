r"""
Damped Mathieu equation: a spring whose stiffness pulses
=========================================================

.. math::

    x'' + 2 z x' + (1 + h \cos w t) x + g x^3 = 0

Rest doubles its period where the pulsation is strong enough; the cubic spring, which the boundary
does not feel, bounds what grows. This is parametric resonance at its simplest, and what the sliding
oscillator's normal force does to its horizontal motion.
"""

from comparison import Comparison

import slipfold as sf

model = sf.built_in_models()["mathieu"]()
diagram = sf.response(model, vary="h", span=(0, 0.3))
diagram.plot("x")
print(diagram.summary())

# %%
# The tongue: the boundary in both parameters.

doubling = diagram.branches[0].special[0]
tongue = sf.locus(doubling, vary=("w", "h"), window={"w": (1.5, 2.5), "h": (0, 1)})
tongue.plot()

# %%

detuned = sf.response(model.replace(w=1.9), vary="h", span=(0, 0.3))
source = "Hill's determinant and integration, 13 digits"
table = Comparison()
table.add("PD at z = 0.01, w = 2: h", doubling.value, "0.0400008749895", source)
table.add(
    "PD at z = 0.01, w = 1.9: h", detuned.branches[0].special[0].value, "0.2014699309238", source
)
table.check("doubled orbit at h = 0.3", diagram.branches[1].orbit(-1))
table
