"""Motions through stick and slip computed again by themselves: the check agrees, and can fail."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import slipfold as sf
from helpers.dry_friction import belt, den_hartog, sliding, two_masses
from slipfold.results.checks.switched import _judged
from slipfold.results.checks.trajectories import check_trajectory


@pytest.mark.parametrize(
    ("model", "periods"),
    [(den_hartog(0.35, 0.6), 100), (two_masses(), 40), (sliding(0.9, 0.02), 20)],
    ids=["line", "two contacts", "plane"],
)
def test_a_motion_says_that_it_agrees(model, periods):
    motion = sf.simulate(model, periods)
    checked = motion.checked
    assert [item.method for item in checked.checks] == ["quadrature", "forces", "other steps"]
    assert checked.agree, str(checked)
    assert checked.to <= (1e-8 if model.name == "sliding" else 1e-10)
    assert f"checked: 3 of 3 agree to {checked.to:.0e}" in motion.summary()


def test_a_state_that_does_not_follow_is_seen():
    motion = sf.simulate(den_hartog(0.35, 0.6), 20)
    states = motion.states.copy()
    states[-1] += 1e-7
    wrong = check_trajectory(replace(motion, states=states))
    assert [item.method for item in wrong.disagreeing] == []  # one in twenty is carried again
    states = states.copy()  # a result locks its arrays
    states[1] += 1e-7
    wrong = check_trajectory(replace(motion, states=states))
    assert [item.method for item in wrong.disagreeing] == ["other steps"]


def joint():
    """A small mass that friction holds on a large one, whose displacement has another scale."""
    contact = sf.FrictionContact({"x": 1, "y": -1}, sf.Coulomb(mu_k=0.3), load=1.0, Vd=0.0)
    given = {"names": "x y", "contacts": contact, "forcing": sf.HarmonicForce("x", F=1.0)}
    return sf.Structure(np.diag([1, 0.1]), 0.02 * np.eye(2), [[1.1, -0.1], [-0.1, 0.1]], **given)


@pytest.mark.parametrize(
    ("orbit", "vary", "span"),
    [
        (lambda: sf.periodic_orbit(belt(sf.Coulomb(mu_s=1.0, mu_k=0.5))), "Vd", (0.2, 0.25)),
        (joint, "f", (0.24, 0.32)),
    ],
)
def test_a_branch_that_sticks_says_that_it_agrees(orbit, vary, span):
    checked = sf.response(orbit(), vary=vary, span=span).checked
    assert checked.count
    assert {item.method for item in checked.checks} == {"other steps"}
    assert checked.agree, str(checked)


def test_two_multipliers_that_meet_are_compared_by_their_mean():
    # Differences over 1e-6 have ten digits, so two equal multipliers have five, as at a fold.
    orbit = SimpleNamespace(multipliers=np.array([1, 1, 0.5], dtype=complex))
    for wrong, agrees in ((0.0, True), (1e-5, False)):
        matrix = np.array([[1 + wrong, 1, 0], [-2e-10, 1 + wrong, 0], [0, 0, 0.5]])
        assert (_judged(orbit, matrix).excess < 1) == agrees
