"""Folds and tori of orbits that stick, as loci: against branches, and against motions beside."""

import numpy as np
import pytest

import slipfold as sf

ROWS = [2, -3]

ALONE = sf.Settings(largest_period=1)


def chain(frequency, speed):
    """Three masses between walls, the first shaken, the last one on a belt."""
    law = sf.Stribeck(mu_s=1.0, mu_k=0.5, vs=0.5)
    stiffness = 2 * np.eye(3) - np.eye(3, k=1) - np.eye(3, k=-1)
    return sf.Structure(
        np.eye(3),
        0.02 * stiffness + 0.02 * np.eye(3),
        stiffness,
        names="x1 x2 x3",
        contacts=sf.FrictionContact("x3", law, load=0.4, Vd=speed),
        forcing=sf.HarmonicForce("x1", F=1.0),
        f=frequency,
    )


def special(kind, speed, first, last, state=None):
    """The points of a type on a branch over frequency."""
    orbit = sf.periodic_orbit(chain(first, speed), state=state)
    branches = sf.response(orbit, vary="f", span=(first, last), settings=ALONE)
    return [item.point for item in branches.special if item.point.type == kind]


@pytest.fixture(scope="module")
def folds():
    """Where two orbits that stick meet and vanish, over frequency and the belt's speed."""
    point, _ = special("LP", 0.3, 0.0875, 0.0835)
    return sf.locus(point, ("f", "Vd"), ((0.06, 0.12), (0.25, 0.35)), switch=False)


@pytest.fixture(scope="module")
def tori():
    """Where an orbit that sticks gives way to a torus."""
    (point,) = special("NS", 0.3, 0.313, 0.318)
    return sf.locus(point, ("f", "Vd"), ((0.2, 0.4), (0.25, 0.35)), switch=False)


def test_every_orbit_on_them_sticks_and_checks_agree(folds, tori):
    for found in (folds, tori):
        (locus,) = found.loci
        assert (locus.started.kind, locus.stopped.kind) == ("window", "window")
        assert (locus.stuck_fraction > 0.1).all()
        assert found.checked.agree, str(found.checked)


@pytest.mark.parametrize("row", ROWS)
def test_folds_are_where_responses_turn(folds, row):
    frequency, speed = folds.loci[0].values[row]
    found = [item.value for item in special("LP", speed, 1.02 * frequency, 0.98 * frequency)]
    assert np.abs(np.array(found) - frequency).min() < 1e-9


@pytest.mark.parametrize("row", ROWS)
def test_tori_are_where_responses_lose_stability(tori, row):
    frequency, speed = tori.loci[0].values[row]
    (found,) = special("NS", speed, 0.995 * frequency, 1.005 * frequency)
    assert found.value == pytest.approx(frequency, abs=1e-9)
