"""Structures on elastic Coulomb contacts: the memory sees how the normal force changes."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import slipfold as sf
from helpers.dry_friction import belt
from slipfold.models.friction.law import ContactState
from slipfold.models.model import evaluation_of

LAW = sf.Jenkins(mu_k=0.5, kt=20.0, exponent=4, e=1e-3)


def test_the_memory_sees_the_normal_motion_and_its_acceleration():
    load = sf.ContactLoad("y", Ns=2.0, kn=4.0, cn=0.3)
    contact = sf.FrictionContact("x", LAW, load=load, Vd=0.7)
    structure = sf.Structure(
        M=[[2.0, 0.5], [0.5, 1.0]], K=[[3, 1], [1, 5]], names="x y", contacts=contact
    )
    assert not structure.forced
    state = np.array([0.1, -0.2, 0.3, 0.05, 0.6])
    rates = evaluation_of(structure).rates(structure, state)
    normal = 2.0 - 4.0 * state[1] - 0.3 * state[3]
    normal_rate = -4.0 * state[3] - 0.3 * rates[3]
    contact = ContactState((0.7 - state[2],), (state[4],), normal, normal_rate)
    [memory] = LAW.memory_rates(contact, LAW.values)
    assert rates[4] == pytest.approx(memory, rel=1e-12)


def test_an_elastic_contact_that_separates_says_so():
    load = sf.ContactLoad("a", Ns=0.2, kn=1.0)
    lifted = sf.Structure(
        np.eye(2), 0.05 * np.eye(2), [[1, -0.3], [-0.3, 1.2]], names="a b",
        contacts=sf.FrictionContact("b", sf.Jenkins(kt=1), load, Vd=0),
        forcing=sf.HarmonicForce("a", F=1), f=0.1,
    )  # fmt: skip
    with pytest.raises(sf.InputError, match="lost contact: the normal force fell"):
        sf.periodic_orbit(lifted)


def test_an_elastic_contact_loses_the_energy_of_its_closed_form():
    # A mass on a surface at rest, driven hard enough for the contact to give way. Whatever the
    # motion does between its two turning points, the sharp element loses 4 mu N (a - mu N/kt).
    law = sf.Jenkins(mu_k=0.5, kt=20.0, exponent=16)
    model = belt(law, 0.0, 0.2, stiffness=10.0, force=2.0, f=0.6)
    orbit = sf.periodic_orbit(model)
    low, high = orbit.extrema.of("x")

    def rates(t, q):
        force = law.force((-q[1],), 1.0, (q[2],))[0]
        drive = 2.0 * np.cos(2 * np.pi * 0.6 * t)
        return [
            q[1],
            drive - 0.2 * q[1] - 10.0 * q[0] + force,
            *law.memory_rates(ContactState((-q[1],), (q[2],)), law.values),
            -force * q[1],
        ]

    start = [*orbit.nodes[0], 0.0]
    run = solve_ivp(rates, (0, 1 / 0.6), start, "DOP853", rtol=1e-11, atol=1e-13, max_step=0.005)
    assert run.y[:3, -1] == pytest.approx(orbit.nodes[0], abs=1e-8)
    amplitude = (high - low) / 2
    assert amplitude > 2 * 0.5 / 20.0
    assert run.y[3, -1] == pytest.approx(law.energy(amplitude.item()), rel=5e-3)
