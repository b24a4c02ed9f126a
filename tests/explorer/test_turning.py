"""A pendulum that turns round: its diagram, orbits and motions go to the page as others do."""

import numpy as np
import pytest

import slipfold as sf
from slipfold.explorer.messages import SimulationRequest
from slipfold.explorer.trajectories import orbit_view, stream_simulation

PENDULUM = """
name = "driven pendulum"
[parameters]
g = 1.35
[states]
phi = { rate = "w", angle = true, start = -0.048 }
w = { rate = "-w/2 - sin(phi) + g*cos(2*t/3)", start = 0.763 }
[forcing]
period = "3*pi"
"""


def test_an_orbit_ends_a_turn_later():
    model = sf.System(PENDULUM)
    view = orbit_view(sf.periodic_orbit(model, state=model.start), "g")
    angle = view["states"]["phi"]
    assert angle[-1] - angle[0] == pytest.approx(-2 * np.pi, abs=1e-5)
    assert np.abs(np.diff(angle)).max() < 0.2


def test_a_motion_is_told_with_its_turns():
    pieces = []
    request = SimulationRequest(kind="simulation", id=1, model="driven pendulum", periods=200)
    stream_simulation(sf.System(PENDULUM), request, pieces.append)
    assert "phi turns round once, backwards" in pieces[-1]["verdict"]
    angles = [value for piece in pieces[:-1] for value in piece["states"]["phi"]]
    assert np.abs(angles).max() < 3 * np.pi  # each period begins within half a turn of zero
