r"""
A forced Duffing oscillator with two wells: period doubling to chaos
=====================================================================

.. math::

    x'' + 0.3 x' - x + x^3 = F \cos 1.2 t

Small motions stay in one well. As the force grows their period doubles again and again; the steps
shrink by Feigenbaum's number, for oscillators as for maps.
"""

from comparison import Comparison
from scipy.optimize import brentq

import slipfold as sf

model = sf.System.from_toml("""
name = "two wells"
[parameters]
F = { value = 0.2, doc = "amplitude of the force" }
d = { value = 0.3, doc = "damping" }
w = { value = 1.2, unit = "rad/s", above = 0, doc = "frequency of the force" }
[states]
x = { rate = "v", start = 1 }
v = "F*cos(w*t) - d*v + x - x^3"
[forcing]
period = "2*pi/w"
""")
motion = sf.simulate(model, periods=200)
well = sf.periodic_orbit(model, state=motion.states[-1])
diagram = sf.response(well, vary="F", span=(0.2, 0.31), settings=sf.Settings(largest_period=32))
diagram.plot("x")
print(diagram.summary())
doublings = [p for b in diagram.branches for p in b.special if p.type == "PD" and b.period < 32]

# %%
# A check that shares no code: where the motion's multiplier is -1, by SciPy alone.

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import root

period = 2 * np.pi / 1.2


def rates(t, y, force):
    x, v, *m = y
    a = np.array([[0, 1], [1 - 3 * x * x, -0.3]])
    return [v, force * np.cos(1.2 * t) - 0.3 * v + x - x**3, *(a @ np.reshape(m, (2, 2))).ravel()]


def shot(state, force):
    y0 = [*state, 1, 0, 0, 1]
    y = solve_ivp(rates, (0, period), y0, "DOP853", args=(force,), rtol=1e-12, atol=1e-13).y[:, -1]
    return y[:2], y[2:].reshape(2, 2)


def multiplier_plus_one(force):
    state = root(lambda s: shot(s, force)[0] - s, doublings[0].state, tol=1e-12).x
    return np.linalg.det(shot(state, force)[1] + np.eye(2))


by_scipy = brentq(
    multiplier_plus_one, doublings[0].value - 1e-4, doublings[0].value + 1e-4, xtol=1e-13
)

table = Comparison()
table.add("first doubling F", doublings[0].value, float(by_scipy), "SciPy: DOP853, brentq")
steps = np.diff([p.value for p in doublings])
for i, ratio in enumerate(steps[:-1] / steps[1:]):
    table.add(
        f"ratio of steps {i + 1} and {i + 2}",
        ratio,
        "4.669201609",
        "Feigenbaum 1978",
        within=0.8 / 2**i,
    )
for point in doublings[:3]:
    table.check(f"doubling of period {point.period}", point.orbit)
table
