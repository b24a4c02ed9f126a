r"""
Duffing's oscillator: the folds of a bent resonance, and its backbone
======================================================================

.. math::

    q'' + d q' + k q + g q^3 = F \cos W t

This is example 01 of NLvib, the program that accompanies the book of Krack and Gross on harmonic
balance. The resonance bends to higher frequencies; between two folds there are three responses.
"""

import matplotlib.pyplot as plt
from comparison import Comparison
from scipy.special import ellipk

import slipfold as sf

model = sf.built_in_models()["duffing"]()
diagram = sf.response(model, vary="W", span=(0.5, 1.8))
upper, lower = diagram.branches[0].special
print(diagram.summary())

# %%
# The backbone is the free motion: its frequency over its amplitude. Damping does not matter, since
# negative damping balances it; here it is viscous, so the balance is exact at all amplitudes.

(cycles,) = sf.backbone(model, "q", 3).branches
heights = cycles.extrema.of("q")[1]

axes = diagram.plot("q")
axes.plot(
    2 * 3.141592653589793 / cycles.durations,
    heights,
    ":",
    color="0.4",
    label="backbone",
)
axes.set(title="Response and backbone")
plt.show()

# %%
# With :math:`m = g A^2 / (2 (k + g A^2))` the backbone is exactly
# :math:`W(A) = (\pi / 2) \sqrt{k + g A^2} / K(m)`.

table = Comparison()
nlvib = "NLvib, example 01, continuous time"
table.add("upper fold W", upper.value, "1.269601955546", nlvib)
table.add("there: q at phase 0", upper.state[0], "-0.140434285344", nlvib)
table.add("there: q' at phase 0", upper.state[1], "3.413427245844", nlvib)
table.add("lower fold W", lower.value, "1.115700251771", nlvib)
table.add("there: q at phase 0", lower.state[0], "-1.020826011254", nlvib)
table.add("there: q' at phase 0", lower.state[1], "0.413916481576", nlvib)
for index in (3, 6, -1):
    amplitude = float(heights[index])
    square = 0.1 * amplitude**2
    exact = 3.141592653589793 / 2 * (1 + square) ** 0.5 / ellipk(square / (2 * (1 + square)))
    found = 2 * 3.141592653589793 / cycles.durations[index]
    table.add(f"backbone W at A = {amplitude:.4g}", found, exact, "exact")
table.check("upper fold", upper.orbit)
table.check("lower fold", lower.orbit)
table
