"""A pendulum that turns round: its diagram, orbits and motions go to the page as others do."""

import numpy as np
import pytest

import slipfold as sf
from slipfold.interface.explorer.trajectories import found_again, orbit_view

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
    view = orbit_view(found_again(model, sf.periodic_orbit(model, state=model.start), "g"), "g")
    angle = view["states"]["phi"]
    assert angle[-1] - angle[0] == pytest.approx(-2 * np.pi, abs=1e-5)
    assert np.abs(np.diff(angle)).max() < 0.2
