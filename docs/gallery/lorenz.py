r"""
Lorenz system: pitchfork, Hopf, and period doublings at large Rayleigh numbers
===============================================================================

.. math::

    x' = \sigma (y - x), \qquad y' = x (\rho - z) - y, \qquad z' = x y - \beta z

Rest loses stability at a branch point, :math:`\rho = 1`. The two states that leave there become
unstable in a subcritical Hopf bifurcation; their cycles run into a homoclinic orbit.
"""

from comparison import Comparison

import slipfold as sf

model = sf.built_in_models()["lorenz"]()
settings = sf.Settings(largest_period=1)
diagram = sf.response(model, vary="rho", span=(0.5, 30), settings=settings)
diagram.plot("x")
print(diagram.summary())

# %%
# At :math:`\rho = 350` there is one stable symmetric cycle. Downwards it loses its symmetry at a
# branch point; the asymmetric cycles double their period again and again.

cycle = sf.periodic_orbit(model.replace(rho=350))
cascade = sf.response(cycle, vary="rho", span=(350, 214))
cascade.plot("x")
print(cascade.summary())

# %%
# The shortest unstable cycle in the attractor at Lorenz's own :math:`\rho = 28`, from a state on
# it.

orbit = sf.periodic_orbit(model, state=[-13.763610682134, -19.578751942452, 27], duration=1.56)

table = Comparison()
pitchfork = next(p for p in diagram.branches[0].special if p.type == "BP")
hopf = next(p for b in diagram.branches for p in b.special if p.type == "HB")
sigma, beta = model.sigma, model.beta
exact = sigma * (sigma + beta + 3) / (sigma - beta - 1)
table.add("branch point rho", pitchfork.value, 1.0, "exact")
table.add("Hopf point rho", hopf.value, exact, "exact")
table.add(
    "loss of symmetry rho", cascade.branches[0].special[0].value, "313", "Sparrow 1982", within=0.5
)
# Each doubling occurs on the cycle and on its mirror image.
doublings = sorted({round(p.value, 9) for _, p in cascade.special if p.type == "PD"}, reverse=True)
table.add("cycle AB at rho = 28: duration", orbit.duration, "1.55865221071617", "Viswanath 2003")
ratio = (doublings[-3] - doublings[-2]) / (doublings[-2] - doublings[-1])
table.add("ratio of the last doublings", ratio, "4.669201609", "Feigenbaum 1978", within=0.1)
table.check("cycle AB", orbit)
table.check("loss of symmetry", cascade.branches[0].special[0].orbit)
table
