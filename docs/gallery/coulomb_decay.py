r"""
Free vibration on a rough floor: it ends
=========================================

A mass on a spring, let go on a floor with Coulomb friction,

.. math::

    m x'' + k x = -\mu N \operatorname{sgn} x' ,

swings about :math:`\pm \mu N/k` in turn. Every half cycle takes :math:`\pi \sqrt{m/k}` as without
friction, and the amplitude falls by :math:`2 \mu N/k`: along a straight line, not exponentially.
At the first turn with :math:`|x| \le \mu_s N/k` the mass stays for ever.
"""

import math

import matplotlib.pyplot as plt
import numpy as np
from comparison import Comparison

import slipfold as sf

mass, stiffness, load, mu, start = 0.25, 4.0, 2.0, 0.05, 0.52
model = sf.Structure(
    [[mass]],
    K=[[stiffness]],
    names="x",
    contacts=sf.FrictionContact("x", sf.Coulomb(mu_k=mu, mu_s=mu), load=load, Vd=0.0),
)
motion = sf.simulate(model, state={"x": start})
print(motion.settlement.message)

# %%

drop, half = 2 * mu * load / stiffness, math.pi * math.sqrt(mass / stiffness)
turns = math.ceil((start - drop / 2) / drop)
time = np.linspace(0, (turns + 2) * half, 1200)

axes = plt.figure(layout="constrained").add_subplot()
axes.plot(time, motion.at(time)[:, 0])
for sign in (1, -1):
    axes.plot([0, turns * half], [sign * start, sign * (start - turns * drop)], "k--", lw=0.8)
axes.axhspan(-drop / 2, drop / 2, alpha=0.15, label="here friction holds the spring")
axes.set(xlabel="time in s", ylabel="x in m", title="The envelope is straight")
axes.legend()
plt.show()

# %%
# When it slips, which way, and where it stays:

axes = plt.figure(figsize=(7, 1.8), layout="constrained").add_subplot()
motion.plot(kind="timeline", ax=axes)
plt.show()

# %%

table = Comparison()
for turn in range(1, turns + 1):
    exact = (-1) ** turn * (start - turn * drop)
    x = float(motion.at(turn * half)[0])
    table.add(f"x at turn {turn} in m", x, exact, "exact", within=1e-12)
(rest,) = (item for item in motion.sticking.intervals if item.state == "stick")
table.add("it stops after, s", rest.begin, turns * half, "exact", within=1e-12)
table.add("speed then", float(motion.at(rest.begin + half)[1]), 0.0, "exact", within=1e-300)
lost = stiffness / 2 * (start**2 - (start - turns * drop) ** 2)
heat = sum(item.heat for item in motion.sticking.intervals)
table.add("heat from friction in J", heat, lost, "exact", within=1e-12)
table
