r"""
Two belts: stick-slip without forcing
======================================

A mass on a spring stands on a belt that moves at speed :math:`v`,

.. math::

    x'' + x = F(v - x') ,

and is carried along until the spring tears it off. Either static friction exceeds that in slip,
:math:`F_s > F_k`, or friction falls with the slip speed as in Leine's law
:math:`F = F_s / (1 + 3 |v_r|)`. What looks like the same cycle lasts until quite different times.
"""

import math

import matplotlib.pyplot as plt
from comparison import Comparison

import slipfold as sf

coulomb = sf.Coulomb(mu_s=1.0, mu_k=0.5)
leine = sf.RationalStribeck(mu_s=1.0, d=3.0)


def belt(law: sf.FrictionLaw, speed: float, damping: float = 0.0) -> sf.Simulation:
    contact = sf.FrictionContact("x", law, load=1.0, Vd=speed)
    return sf.simulate(sf.Structure([[1.0]], [[damping]], [[1.0]], names="x", contacts=contact))


# %%
# Friction over displacement, and over the velocity of the belt relative to the mass; thick where
# the mass sticks. Above Coulomb's law, below Leine's.

fig, axes = plt.subplots(2, 2, figsize=(9, 7), layout="constrained")
for (left, right), law in zip(axes, (coulomb, leine), strict=True):
    motion = belt(law, 0.2)
    motion.plot(kind="hysteresis", ax=left)
    motion.plot(kind="friction", ax=right)
    left.set_ylabel(f"friction force (N), {law.title}")
plt.show()

# %%
# Under Coulomb's law, with :math:`D = F_s - F_k`, slip lasts :math:`2 (\pi - \arctan(D/v))` and
# stick :math:`2 D/v`.

table = Comparison()
drop, v = 0.5, 0.2
motion = belt(coulomb, v)
(stuck,) = motion.last_round.sticking
slips, sticks = 2 * (math.pi - math.atan(drop / v)), 2 * drop / v
round_trip = motion.settlement.duration
table.add("Coulomb: period in s", round_trip, slips + sticks, "exact", within=1e-10)
table.add("stuck, s", stuck.end - stuck.begin, sticks, "exact", within=1e-10)
largest = 0.5 + math.hypot(drop, v)
table.add("largest x", motion.last_round.maximum[0], largest, "exact", within=1e-10)
damped = belt(coulomb, v, damping=0.1).settlement.duration
table.add("with damping 0.1: period", damped, "8.38379742099", "two methods")

# %%

motion = belt(leine, 0.2)
(stuck,) = motion.last_round.sticking
source = "Leine et al. 1998, to more digits"
table.add("Leine: period in s", motion.settlement.duration, "12.001031294830", source)
slips = motion.settlement.duration - (stuck.end - stuck.begin)
table.add("slips, s", slips, "4.295999525480", source)
table.add("largest x", motion.last_round.maximum[0], "1.133944676442", source)
table.add("v = 0.3: period", belt(leine, 0.3).settlement.duration, "9.953457266154", source)
table
