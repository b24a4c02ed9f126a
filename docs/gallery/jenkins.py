r"""
Jenkins element: what a joint dissipates
=========================================

A spring of stiffness :math:`k_t` in series with a Coulomb slider of limit :math:`\mu N`. In a
motion of amplitude :math:`a > \mu N / k_t` it sticks and slips in turn. Its first harmonic acts as
a complex stiffness :math:`k' + i k''`, and a cycle dissipates :math:`4 \mu N (a - \mu N / k_t)`.
"""

import matplotlib.pyplot as plt
import numpy as np
from comparison import Comparison

import slipfold as sf

law = sf.Jenkins(mu_k=1.0, kt=20.0)
amplitude = 0.2

# %%
# The element along a harmonic path. The first cycle begins at no force, so the last of two counts.
# The path is sampled finely; the force is exact on it.

phase = np.linspace(0, 4 * np.pi, 80001)
path = amplitude * np.cos(phase)
force = law.along(path, normal=1.0)
path, force, phase = path[40000:], force[40000:], phase[40000:]

axes = plt.figure().add_subplot()
axes.plot(path, force)
axes.set(xlabel="displacement in m", ylabel="force in N", title="Hysteresis of a Jenkins element")
plt.show()

# %%
# The sampled loop gives the same integrals as the closed forms, up to the sampling.

lost = abs(np.trapezoid(force, path))
real = abs(np.trapezoid(force * np.cos(phase), phase)) / (np.pi * amplitude)

source = "Krack and Gross 2019; closed form"
table = Comparison()
table.add("k' in N/m", law.stiffness(amplitude), "3.910022189558", source)
table.add("k'' in N/m", law.loss_stiffness(amplitude), "4.774648292757", source)
table.add("energy a cycle in J", law.energy(amplitude), "0.6", source, within=1e-12)
table.add("k' of the sampled loop", real, "3.910022189558", source, within=1e-6)
table.add("energy of the sampled loop", lost, "0.6", source, within=1e-6)
table
