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
# Displacements over a round of each; the bars show when a mass sticks.

fig, both = plt.subplots(2, 1, figsize=(8, 6), layout="constrained")
for axes, motion in zip(both, (near, far), strict=True):
    time, states = motion.steady(1, 1500)
    length = motion.settlement.duration
    for i, contact in enumerate(("first", "second")):
        axes.plot(time - time[0], states[:, i], f"C{i}", label=f"{contact} mass")
        for item in motion.last_round.sticking:
            if item.contact == contact:
                bar = np.array([item.begin, item.end])
                for shift in (0, length):
                    shown = np.clip(bar - shift, 0, length)
                    axes.plot(shown, [-0.85 - 0.12 * i] * 2, f"C{i}", lw=4, solid_capstyle="butt")
    axes.set(ylabel="displacement in m", title=f"a round of {length:.4f} s")
both[0].legend(loc="lower right", bbox_to_anchor=(1, 0.2))
both[1].set(xlabel="time in s")
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
