r"""
A pin on a disc
================

A pin is pressed on a turning disc. It can move along the slip and across it. Friction that falls
with speed feeds the motion along the slip; across it, friction always damps. Built from matrices
and a planar friction contact.
"""

import math

import numpy as np
from comparison import Comparison

import slipfold as sf

m, c, k = 0.05, 0.4, 2000.0
law = sf.Stribeck(mu_s=0.6, mu_k=0.3, vs=0.4)
pin = sf.Structure(
    m * np.eye(2),
    c * np.eye(2),
    np.diag([k, 1.3 * k]),
    names=("u", "w"),
    contacts=sf.FrictionContact(("u", "w"), law, load=5.0, Vd=2.0),
)
diagram = sf.response(pin, vary="Vd", span=(2, 0.2))
diagram.plot("u")
print(diagram.summary())

# %%
# Motion along the slip has the damping :math:`c + N \mu'(V)`, which is zero at
# :math:`V = v_s \ln(N (\mu_s - \mu_k) / (c v_s))`. At rest the pin is displaced by the drag.

hopf = next(p for p in diagram.branches[0].special if p.type == "HB")
first = diagram.branches[0].states[0]
table = Comparison()
table.add(
    "onset of squeal Vd in m/s", hopf.value, 0.4 * math.log(5 * 0.3 / (c * 0.4)), "closed form"
)
table.add("duration there in s", hopf.duration, 2 * math.pi * math.sqrt(m / k), "closed form")
drag = 5 * (0.3 + 0.3 * math.exp(-2 / 0.4))
table.add("displacement at Vd = 2 m/s, in m", first[0], drag / k, "closed form")
cycles = diagram.branches[hopf.leads_to - 1]
slipping = np.flatnonzero(
    ~(np.nan_to_num(cycles.stuck_fraction) > 0)
)  # the others stick, further on
table.check("vibration half way", cycles.orbit(slipping[len(slipping) // 2]))
table
