r"""
Two masses on a belt: cycles beside each other
===============================================

Two masses with springs, coupled by a third, stand on one belt. Each sticks and slips by Leine's law
:math:`F_i = F_{s,i} / (1 + 3 |v_r|)`, and each shakes the other. Several motions are stable: which
of them comes about is decided by the start.
"""

import matplotlib.pyplot as plt
import numpy as np
from comparison import Comparison

import slipfold as sf

model = sf.Structure(
    np.eye(2),
    K=[[2.2, -1.2], [-1.2, 2.2]],
    names="x1 x2",
    contacts=[
        sf.FrictionContact("x1", sf.RationalStribeck(mu_s=1.0, d=3.0), 1.0, 0.15, name="first"),
        sf.FrictionContact("x2", sf.RationalStribeck(mu_s=1.3, d=3.0), 1.0, 0.15, name="second"),
    ],
)
near = sf.simulate(model, state={"x1": 0.5, "x2": -0.3})
far = sf.simulate(model, state={"x1": 0.9, "x2": 1.2})

# %%
# Displacements over a round of each, and below them what the masses do meanwhile.

fig, axes = plt.subplots(4, 1, figsize=(8, 9), layout="constrained", height_ratios=(3, 1.3, 3, 1.3))
for over, below, motion in zip(axes[::2], axes[1::2], (near, far), strict=True):
    time, states = motion.steady(1, 1500)
    for i, contact in enumerate(("first", "second")):
        over.plot(time, states[:, i], label=f"{contact} mass")
    over.set(xlim=time[[0, -1]], ylabel="displacement in m")
    motion.plot(kind="timeline", ax=below, rounds=1)
axes[2].legend(loc="lower left")
plt.show()

# %%
# Friction over displacement in the shorter cycle; the area of a loop is the work that the belt does
# on the mass in a round.

near.plot(kind="hysteresis")
plt.show()

# %%

table = Comparison()
source = "two methods that share no code"
table.add("period in s", near.settlement.duration, "12.39295176687", source)
for contact, published in (
    ("first", ("2.72270329", "4.07266075")),
    ("second", ("1.56790351", "5.00842914")),
):
    times = sorted(
        item.end - item.begin for item in near.last_round.sticking if item.contact == contact
    )
    for time, value in zip(times, published, strict=True):
        table.add(f"the {contact} sticks, s", time, value, source)
table.add("from the other start: period", far.settlement.duration, "30.78198663869", source)
table
