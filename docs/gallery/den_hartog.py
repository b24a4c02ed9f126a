r"""
Den Hartog's oscillator: stops in forced vibration
===================================================

A mass on a spring rubs on the floor and is shaken:

.. math::

    x'' + x = \cos W t - S \operatorname{sgn} x' .

Den Hartog solved it in 1930. Where friction is weak the mass turns without stopping; where it is
strong, or the forcing slow, it stops at both ends until the force on it exceeds the friction.
"""

import math

import matplotlib.pyplot as plt
import numpy as np
from comparison import Comparison
from scipy.optimize import fsolve

import slipfold as sf


def settled(W: float, slip: float, static: float | None = None) -> sf.Simulation:
    law = sf.Coulomb(mu_k=slip, mu_s=static or slip)
    model = sf.Structure(
        [[1.0]],
        K=[[1.0]],
        names="x",
        contacts=sf.FrictionContact("x", law, load=1.0, Vd=0.0),
        forcing=sf.HarmonicForce("x", F=1.0),
        f=W / (2 * math.pi),
    )
    return sf.simulate(model, 300)


# %%
# Friction over displacement, and what the mass does over two forcing periods: it turns without
# stopping, or it stops at both ends, where friction turns over while it rests.

fig, axes = plt.subplots(2, 2, figsize=(9, 5), layout="constrained", height_ratios=(3, 1))
for (over, below), slip in zip(axes.T, (0.2, 0.7), strict=True):
    motion = settled(0.6, slip)
    motion.plot(kind="hysteresis", ax=over)
    motion.plot(kind="timeline", ax=below)
    over.set_xlabel(f"displacement (m), S = {slip}")
plt.show()

# %%
# Without stops, with :math:`V = 1/(1 - W^2)` and
# :math:`U = \sin(\pi/W) / (W (1 + \cos(\pi/W)))`, the amplitude is
# :math:`\sqrt{V^2 - S^2 U^2}`, as long as :math:`S \le |V|/\sqrt{U^2 + W^{-4}}`.

table = Comparison()
for W in (0.6, 0.8, 2.0):
    V = 1 / (1 - W * W)
    U = math.sin(math.pi / W) / (W * (1 + math.cos(math.pi / W)))
    amplitude = math.sqrt(V * V - (0.2 * U) ** 2)
    motion = settled(W, 0.2)
    name = f"W = {W:g}, S = 0.2: largest x"
    table.add(name, motion.last_round.maximum[0], amplitude, "Den Hartog 1930", within=1e-10)

U = math.sin(math.pi / 0.6) / (0.6 * (1 + math.cos(math.pi / 0.6)))
most = 1 / (1 - 0.6**2) / math.hypot(U, 0.6**-2)
for share in (0.999, 1.001):
    print(f"W = 0.6, S = {share * most:.6f}: {settled(0.6, share * most).regime}")

# %%
# With two stops a period the mass leaves its rest at :math:`x` when
# :math:`\cos W t = x - S`, and comes to rest at :math:`-x`. Both conditions are solved for
# :math:`x` and the time that the slip takes.


def misses(unknown: np.ndarray, W: float, S: float) -> list[float]:
    x, length = unknown
    V, start = 1 / (1 - W * W), math.acos(x - S) / W
    end = start + length
    a, b = x - S - V * math.cos(W * start), V * W * math.sin(W * start)
    last = a * math.cos(length) + b * math.sin(length) + S + V * math.cos(W * end)
    speed = b * math.cos(length) - a * math.sin(length) - V * W * math.sin(W * end)
    return [last + x, speed]


for W, slip in ((0.3, 0.2), (0.6, 0.7)):
    motion, name = settled(W, slip), f"W = {W:g}, S = {slip:g}"
    guess = motion.last_round.maximum[0] + 1e-3, math.pi / W * (1 - motion.stuck_fraction) + 1e-3
    x, length = fsolve(misses, guess, (W, slip), xtol=1e-13)
    table.add(f"{name}: largest x", motion.last_round.maximum[0], x, "closed form", within=1e-10)
    time = motion.stuck_fraction * motion.forcing_period
    exact = 2 * (math.pi / W - length)
    table.add(f"{name}: stuck a period, s", time, exact, "closed form", within=1e-9)

# %%
# Static friction may be larger than that in slip.

motion, source = settled(0.6, 0.5, 0.8), "two methods that share no code"
name = "W = 0.6, S = 0.5, static 0.8"
table.add(f"{name}: largest x", motion.last_round.maximum[0], "1.5704484209", source)
time = motion.stuck_fraction * motion.forcing_period
table.add(f"{name}: stuck a period, s", time, "1.427132002", source)
table
