"""Forcing far slower than the motion takes as many steps as there are vibrations, not more."""

import numpy as np
import pytest

import slipfold as sf
from slipfold.flow.flow import flow_of


def oscillator(W: float) -> sf.System:
    return sf.System(
        parameters={"W": W, "F": 1.0},
        states={"q": "v", "v": "F*cos(W*t) - q - 0.1*v"},
        forcing={"period": "2*pi/W", "amplitude": "F"},
    )


@pytest.mark.parametrize("W", [1e-3, 1e-4])
def test_a_slow_force_moves_an_oscillator_as_its_spring_lets_it(W):
    exact = 1 / (1 - W**2 + 0.1j * W)
    orbit = sf.periodic_orbit(oscillator(W))
    assert orbit.state == pytest.approx([exact.real, (1j * W * exact).real], rel=1e-9, abs=1e-13)
    assert orbit.extrema.of("q")[1][0] == pytest.approx(abs(exact), rel=1e-9)
    branch = sf.response(oscillator(W), "W", (W, 3 * W)).branches[0]
    assert branch.stopped.kind == "span"


def test_a_motion_of_thousands_of_vibrations_in_a_period_goes_on():
    # Free vibration rings down: it is gone after 0.1 s and the rest is slow.
    motion = sf.simulate(oscillator(2e-4), 17)
    assert motion.settlement.settled
    exact = 1 / (1 - 4e-8 + 2e-5j)
    assert motion.states[-1] == pytest.approx([exact.real, (2e-4j * exact).real], abs=1e-10)


def test_a_pole_still_ends_a_motion():
    model = sf.System(
        parameters={"W": 1e-3}, states={"q": "1 + q^2 + 0*cos(W*t)"}, forcing={"period": "2*pi/W"}
    )
    flow = flow_of(model)
    ends = flow.advance(np.zeros((1, 1)), np.zeros(1), np.ones(1), flow.constants_of(model))
    assert np.isnan(ends).all()
    assert sf.simulate(model, 2).stopped.kind == "singular"
