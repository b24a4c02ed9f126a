r"""
An electronic circuit: fold, branch point, torus and period doubling of cycles
===============================================================================

.. math::

    r x' &= -(b + n) x + b y - a_3 x^3 + b_3 (y - x)^3 \\
    y' &= b x - (b + g) y - z - b_3 (y - x)^3, \qquad z' = y

The circuit of Freire, Rodriguez-Luis, Gamero and Ponce; demo ``tor`` of AUTO. The cycle born at a
Hopf point folds and loses its symmetry at a branch point; on the branch that leaves there lie a
Neimark-Sacker point and a period doubling. One call finds them all.
"""

import numpy as np
from comparison import Comparison

import slipfold as sf

model = sf.built_in_models()["freire"]()
settings = sf.Settings(largest_period=1)
diagram = sf.response(model, vary="n", span=(-0.55, -0.62), settings=settings)
diagram.plot("x")
print(diagram.summary())

# %%
# The Hopf point is exact by Routh and Hurwitz: with the Jacobian at rest, whose characteristic
# polynomial is :math:`\lambda^3 + c_2 \lambda^2 + c_1 \lambda + c_0`, it is where
# :math:`c_2 c_1 = c_0`.

from scipy.optimize import brentq


def routh(n: float) -> float:
    jacobian = np.array(
        [
            [-(model.b + n) / model.r, model.b / model.r, 0],
            [model.b, -(model.b + model.g), -1],
            [0, 1, 0],
        ]
    )
    _, c2, c1, c0 = np.poly(jacobian)
    return c2 * c1 - c0


def special(kind: str, branch: sf.Branch) -> sf.SpecialPoint:
    return next(point for point in branch.special if point.type == kind)


still, cycles = diagram.branches[:2]
hopf, fold, crossing = special("HB", still), special("LP", cycles), special("BP", cycles)
other = next(
    branch for branch in diagram.branches[2:] if any(p.type == "NS" for p in branch.special)
)
torus, doubling = special("NS", other), special("PD", other)

auto = "AUTO, demo tor"
both = "collocation and integration, 13 digits"
table = Comparison()
table.add(
    "Hopf point n", hopf.value, float(brentq(routh, -0.6, -0.58, xtol=1e-15)), "Routh-Hurwitz"
)
table.add("fold of cycles n", fold.value, "-0.584335", auto)
table.add("its duration", fold.duration, "8.42647", auto)
table.add("branch point n", crossing.value, "-0.587029", auto)
table.add("its duration", crossing.duration, "8.68967", auto)
table.add("Neimark-Sacker n", torus.value, "-0.5916501950321", both)
table.add("its duration", torus.duration, "8.794151746402", both)
table.add("its multiplier, real part", torus.critical_multiplier.real, "0.82017809", both)
table.add("imaginary part", torus.critical_multiplier.imag, "0.5721083", both)
table.add("period doubling n", doubling.value, "-0.6149552211380", both)
table.add("its duration", doubling.duration, "9.266303320566", both)
for name, point in (("fold", fold), ("torus", torus), ("doubling", doubling)):
    table.check(name, point.orbit)
table
