"""Doubled orbits that stick: by how much their halves differ, from one node alone."""

import numpy as np
import pytest

import slipfold as sf
from slipfold.branches.closed_branches import asymmetry, close_on_parent
from slipfold.orbits.kinds import orbits_of
from slipfold.orbits.switched_shooting import SwitchedShooting


@pytest.fixture(scope="module")
def doubled():
    """Orbits of two periods that a shaken mass on a belt has, friction falling with speed."""
    law = sf.Stribeck(mu_s=1.0, mu_k=0.5, vs=0.5)
    contact = sf.FrictionContact("x", law, load=0.4, Vd=0.5)
    force = sf.HarmonicForce("x", F=1.0)
    model = sf.Structure(
        [[1.0]], [[0.1]], [[1.0]], names="x", contacts=contact, forcing=force, f=0.08
    )
    settings = sf.Settings(largest_period=2)
    orbit = sf.periodic_orbit(model)
    _, branch = sf.response(orbit, vary="Vd", span=(0.5, 0.51), settings=settings).branches
    return branch


def unknown_of(branch, row, period=2):
    """An orbit of a branch by its one node."""
    orbit = branch.orbit(row)
    orbits = orbits_of(orbit.model, {"Vd": 1.0}, period, 1, by=SwitchedShooting)
    return orbits, orbits.unknown(orbit.nodes[:1], orbit.model)


@pytest.mark.parametrize("row", [1, -1])
def test_halves_differ_by_what_simulated_states_do(doubled, row):
    assert doubled.period == 2
    orbit = doubled.orbit(row)
    motion = sf.simulate(orbit.model, 1, orbit.state)
    apart = (orbit.state - motion.strobe[-1]) / orbit.model.state_scales()
    assert np.abs(apart).max() > 1e-3
    assert asymmetry(*unknown_of(doubled, row)) == pytest.approx(apart, abs=1e-10)


def test_halves_of_an_orbit_gone_round_twice_are_the_same(doubled):
    orbits, z = unknown_of(doubled, 0)
    assert np.abs(asymmetry(orbits, z)).max() < 1e-6
    stop = close_on_parent(orbits, [], None, z)
    assert stop.end.kind == "closed"
    assert "period doubling" in stop.end.reason
