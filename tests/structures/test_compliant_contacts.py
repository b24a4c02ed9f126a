"""Tabulated springs and normal compliance: closed forms, limits, energy, another method."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import slipfold as sf
from slipfold import FrictionContact, HarmonicForce, Structure

ROWS = np.array([(-2.0, -7.0), (-1.0, -4.0), (0.5, 2.0), (2.0, 3.0)])


def test_a_tabulated_spring_is_its_table():
    spring = sf.TabulatedSpring("x", ROWS, 1.5, e=1e-6)
    model = Structure([[1.0]], None, [[0.0]], names="x", elements=spring)
    places, step = np.array([-3.0, -1.7, 0.0, 1.2, 5.0]), 1e-5
    expected = np.interp(places, *np.array([(-3, -10), *ROWS, (5, 5)]).T)
    # The force is minus the slope of the energy, and the spring loses none.
    sides = [[model.evaluate("energy", [u + h, 0]) for u in places] for h in (step, -step)]
    slope = np.subtract(*sides) / (2 * step)
    np.testing.assert_allclose(slope, 1.5 * expected, rtol=1e-8, atol=1e-8)
    first, last = sf.simulate(model, 4, [2.5, 0.0]).states[[0, -1]]
    assert model.evaluate("energy", last) == pytest.approx(model.evaluate("energy", first))
    same = spring.replace(table=dict(map(tuple, ROWS[::-1])))
    assert same == spring


def test_a_table_of_two_slopes_is_a_gap_spring():
    table = sf.TabulatedSpring("x", [(-1, 0), (0.2, 0), (1, 8)], e=0.05)
    gap = sf.GapSpring("x", k=10, gap=0.2, e=0.05)
    models = [
        Structure([[1.0]], [[0.1]], [[1.0]], names="x", elements=one, f=0.2,
                  forcing=HarmonicForce("x", F=0.5))
        for one in (table, gap)
    ]  # fmt: skip
    orbits = [sf.periodic_orbit(model) for model in models]
    np.testing.assert_allclose(orbits[0].state, orbits[1].state, rtol=1e-9)
    assert table.residual == pytest.approx(10 * 0.025 / 8)


def pad(load, law):
    contact = FrictionContact("x", law, load, Vd=0.5)
    return Structure(np.eye(2), 0.1 * np.eye(2), np.diag([4.0, 0.0]), names="x y",
                     contacts=contact, forcing=HarmonicForce("y", F=0.3, harmonic=1),
                     elements=sf.PolynomialSpring("y", {1: 1.0}), f=0.1)  # fmt: skip


@pytest.mark.parametrize("exponent", [1, 1.5, 2])
def test_compliance_by_scipy(exponent):
    law = sf.Regularized(sf.Coulomb(mu_k=0.4), e=0.1)
    load = sf.ComplianceLoad("y", Ns=0.8, d=0.2, en=0.02, exponent=exponent)
    model = pad(load, law)

    def rates(t, z):
        way = 0.2 - z[1]
        normal = 0.8 * ((way + np.hypot(way, 0.02)) / 0.4) ** exponent
        slip = 0.5 - z[2]
        ax = -4 * z[0] - 0.1 * z[2] + normal * 0.4 * np.tanh(slip / 0.1)
        ay = -z[1] - 0.1 * z[3] + normal + 0.3 * np.cos(2 * np.pi * 0.1 * t)
        return [z[2], z[3], ax, ay]

    start = [0.1, 0.4, 0.0, -0.2]  # apart at first
    other = solve_ivp(rates, (0, 20), start, "DOP853", rtol=1e-12, atol=1e-12).y[:, -1]
    np.testing.assert_allclose(sf.simulate(model, 2, start).states[-1], other, rtol=1e-8)


def test_stiff_compliance_is_a_contact_load_while_it_is_pressed():
    law, start = sf.Coulomb(mu_k=0.3), [0.0, 0.05, 0.0, 0.0]
    soft = pad(sf.ComplianceLoad("y", Ns=5, d=1.0, en=1e-6), law)
    linear = pad(sf.ContactLoad("y", Ns=5, kn=5), law)
    states = [sf.simulate(model, 1, start).states[-1] for model in (soft, linear)]
    np.testing.assert_allclose(*states, rtol=1e-8, atol=1e-10)


def test_a_contact_in_the_plane_that_opens():
    # Its multipliers against differences of trajectories over a period.
    contact = FrictionContact(("x", "z"), sf.Coulomb(mu_k=0.3), sf.ContactLoad("y", Ns=0.5, kn=3.0),
                              Vd=0.3, alpha=0.5)  # fmt: skip
    model = Structure(np.eye(3), 0.2 * np.eye(3), np.diag([1.0, 2.0, 1.5]), names="x y z",
                      contacts=contact, forcing=HarmonicForce("y", F=0.9), f=0.15)  # fmt: skip
    orbit = sf.periodic_orbit(model)
    assert orbit.extrema.of("N")[0] == pytest.approx(0, abs=1e-12)  # a root where it opens
    step, directions = 1e-6, np.eye(6)
    ends = [
        [sf.simulate(model, 1, orbit.state + sign * step * one).states[-1] for one in directions]
        for sign in (1, -1)
    ]
    found = np.linalg.eigvals(np.subtract(*ends).T / (2 * step))
    order = np.argsort(np.abs(found))
    mine = np.asarray(orbit.multipliers)
    expected = mine[np.argsort(np.abs(mine))]
    np.testing.assert_allclose(np.abs(found[order]), np.abs(expected), atol=1e-6)
