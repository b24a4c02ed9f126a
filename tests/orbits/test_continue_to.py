"""Orbits carried to other values of parameters, and responses that are started from afar."""

import numpy as np
import pytest

import slipfold as sf
from slipfold.continuation.walk import Failure
from slipfold.flow import batches
from slipfold.flow.scales import measured
from slipfold.orbits.continued import continue_to
from slipfold.orbits.first_orbits import guess_orbit
from slipfold.orbits.kinds import ForcedOrbits


def anything(point):
    return None


def duffing(**values):
    """Beyond its resonance a weak force has a small response, and a strong one only a large one."""
    parameters = {"W": 2.0, "F": 1.0, **values}
    rates = {"q": "v", "v": "F*cos(W*t) - q - q^3 - 0.1*v"}
    forcing = {"period": "2*pi/W", "amplitude": "F"}
    return measured(sf.System(parameters=parameters, states=rates, forcing=forcing))


def rising(model):
    orbits = ForcedOrbits(model, {"F": 1.0})
    return orbits, guess_orbit(orbits, 0.0).z


def test_an_orbit_is_carried_round_the_folds_on_its_way():
    orbits, rest = rising(duffing())
    places = []
    reached = continue_to(orbits, rest, 4.0, lambda point: places.append(point.z[-1]))
    assert orbits.value(reached.z) == 4.0
    assert (np.diff(places) < 0).any()  # back between two folds
    other = continue_to(orbits, reached.z, 0.0, anything)
    assert other.z == pytest.approx(rest, abs=1e-9)


def test_it_is_said_why_an_orbit_does_not_arrive():
    orbits, rest = rising(duffing())
    refused = continue_to(
        orbits, rest, 1.0, lambda point: "too much" if point.z[-1] > 0.1 else None
    )
    assert refused == Failure("limit", "too much")
    start = np.full_like(rest, np.nan)
    assert isinstance(continue_to(orbits, start, 1.0, anything), Failure)


def friction(**values):
    """An oscillator held by dry friction that is 500 times as stiff at rest as it moves."""
    return sf.System(
        parameters={"W": 0.5, **values},
        states={"x": "v", "v": "cos(W*t) - x - 0.5*tanh(v/1e-3)"},
        forcing={"period": "2*pi/W"},
    )


def test_where_the_linear_response_is_far_off_the_motion_is_given_time_to_settle():
    (branch, *_) = sf.response(friction(), "W", (0.5, 0.8)).branches
    assert branch.parameter[[0, -1]] == pytest.approx([0.5, 0.8])
    settled = sf.response(friction(), "W", (0.5, 0.8), settled=True).branches[0]
    assert branch.states[0] == pytest.approx(settled.states[0], abs=1e-8)
    assert sf.periodic_orbit(friction()).state == pytest.approx(settled.states[0], abs=1e-8)


def test_a_hopeless_start_is_given_up_soon(monkeypatch):
    """So slow a plate that the tip would stick at once: orbits found by creeping lead nowhere."""
    calls = []
    arrive = batches.arrive
    monkeypatch.setattr("slipfold.flow.flow.arrive", lambda *some: calls.append(arrive(*some)))
    with pytest.raises(sf.InputError, match=r"no response of period 1 was found at Nd = 0\.9"):
        sf.response(sf.SlidingOscillator(Vd=1e-6), "Nd", (0.9, 0.1))
    assert len(calls) < 50
