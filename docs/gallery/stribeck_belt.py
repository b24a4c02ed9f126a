r"""
A mass on a belt: squeal by falling friction
=============================================

.. math::

    x'' + c x' + x = -\operatorname{sgn}(v_r) \left[m_d + m_d (r - 1) e^{-|v_r| / v_0}\right],
    \qquad v_r = x' - v_d

Friction that falls with speed works against damping. Steady sliding is an equilibrium; as the belt
slows down it loses stability in a Hopf bifurcation, here subcritical: squeal begins with a jump.
The branch of cycles ends where the mass would stick.
"""

import math

import matplotlib.pyplot as plt
from comparison import Comparison

import slipfold as sf

model = sf.built_in_models()["stribeck"]()
diagram = sf.response(model, vary="vd", span=(2, 0.9))
diagram.plot("x")
print(diagram.summary())

# %%

hopf = next(point for point in diagram.branches[0].special if point.type == "HB")
print(hopf.criticality)

# %%
# The exact value is :math:`v_0 \ln((r - 1) m_d / (v_0 c))`.

table = Comparison()
exact = model.v0 * math.log((model.r - 1) * model.md / (model.v0 * model.c))
table.add("Hopf point vd", hopf.value, exact, "exact")
table.add("the same", hopf.value, "1.151292546497", "Stender and Hoffmann 2022 (bSTAB)")
table.check("cycle beside sticking", diagram.branches[1].orbit(-2))

# %%
# Where the mass sticks the same system is a structure with a contact: its friction is exact, and
# the motion goes on through stick and slip.

law = sf.Stribeck(mu_s=model.r * model.md, mu_k=model.md, vs=model.v0)
contact = sf.FrictionContact("x", law, load=1.0, Vd=1.0)
squeal = sf.simulate(sf.Structure([[1.0]], [[model.c]], [[1.0]], names="x", contacts=contact))
fig, (left, right) = plt.subplots(1, 2, figsize=(9, 3.8), layout="constrained")
squeal.plot(kind="hysteresis", ax=left)
squeal.plot(kind="friction", ax=right)
plt.show()

# %%

squeal.plot(kind="timeline", ax=plt.figure(figsize=(7, 1.8), layout="constrained").add_subplot())
plt.show()

# %%

table.add("stick-slip at vd = 1: period", squeal.settlement.duration, "6.4313827982", "two methods")

# %%
# On a faster belt this cycle ends where it touches zero slip, beside one that only slips. Where it
# does is a curve in the plane of belt speed and kinetic friction: to its left squeal sticks.

contact = sf.FrictionContact("x", law, load=1.0, Vd=1.5)
belt = sf.Structure([[1.0]], [[model.c]], [[1.0]], names="x", contacts=contact)
cycles = sf.response(sf.periodic_orbit(belt, state={"x": 2.0}), vary="Vd", span=(1.5, 1.9))
(end,) = cycles.special
table.add("end of stick-slip: vd", end.point.value, "1.836600972208", "bSTAB")
ends = sf.locus(end, ("Vd", "mu_k"), ((1.0, 2.5), (0.2, 0.9)))
ends.plot()
plt.show()

# %%

table
