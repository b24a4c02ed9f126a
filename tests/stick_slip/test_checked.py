"""Motions through stick and slip computed again by themselves: the check agrees, and can fail."""

from dataclasses import replace

import numpy as np
import pytest

import slipfold as sf
from helpers.dry_friction import belt, den_hartog, sliding, two_masses
from slipfold.checks.motions import check_motion
from slipfold.checks.switched import hold_legs, switched_difference
from slipfold.flow.contact_motion import dense_legs
from slipfold.flow.flow import flow_of
from slipfold.flow.switched_flow import switched_flow_of


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
    strobe = motion.strobe.copy()
    strobe[-1] += 1e-7
    wrong = check_motion(replace(motion, strobe=strobe))
    assert [item.method for item in wrong.disagreeing] == []  # one in twenty is carried again
    strobe = strobe.copy()  # a result locks its arrays
    strobe[1] += 1e-7
    wrong = check_motion(replace(motion, strobe=strobe))
    assert [item.method for item in wrong.disagreeing] == ["other steps"]


def test_legs_of_another_motion_and_another_friction_are_seen():
    model, start = den_hartog(0.35, 0.6), np.array([1.1, 0.0])
    flow, constants = switched_flow_of(model), flow_of(model).constants_of(model)
    weights = flow.weights(start, constants)
    mode = sf.simulate(model, 1, start).sticking.mode(0)
    passed = list(dense_legs(model, start, mode, 1.0))
    right = hold_legs(flow, passed, start, constants, weights)
    assert right.drift < 1e-12
    assert right.forces < 1e-12
    for name, value in {"F": 1.001, "mu_k": 0.599}.items():
        other = flow_of(model).constants_of(model.replace(**{name: value}))
        assert hold_legs(flow, passed, start, other, weights).drift > 1e-5
    # Held by 0.599 of the normal force what sticks goes beyond it, and lets go later than it may.
    less = flow_of(model).constants_of(model.replace(mu_s=0.599, mu_k=0.5))
    assert hold_legs(flow, passed, start, less, weights).forces > 1e-4
    # A leg that ends elsewhere than the next begins
    moved = [replace(leg, state=leg.state + 1e-6) for leg in passed]
    assert hold_legs(flow, moved, start, constants, weights).drift > 1e-7


@pytest.mark.parametrize(
    "model",
    [den_hartog(0.35, 0.6), belt(sf.Coulomb(mu_s=1.0, mu_k=0.5)), sliding(0.9, 0.02)],
    ids=["forced", "cycle", "plane"],
)
def test_an_orbit_is_what_other_steps_and_motions_beside_it_say(model):
    orbit = sf.periodic_orbit(model)
    assert orbit.sticking
    assert switched_difference(orbit).excess <= 1
    wrong = replace(orbit, multipliers=orbit.multipliers + 1e-5)
    assert switched_difference(wrong).excess > 1
    moved = replace(orbit, nodes=orbit.nodes + 1e-5 * orbit.model.state_scales())
    assert switched_difference(moved).excess > 1


def test_a_branch_that_sticks_says_that_it_agrees():
    cycle = sf.periodic_orbit(belt(sf.Coulomb(mu_s=1.0, mu_k=0.5)))
    checked = sf.response(cycle, vary="Vd", span=(0.2, 0.25)).checked
    assert checked.count
    assert {item.method for item in checked.checks} == {"other steps"}
    assert checked.agree, str(checked)
