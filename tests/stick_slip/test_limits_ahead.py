"""Branches through stick that come to another limit of their model end there, and say so."""

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.optimize import fsolve

import slipfold as sf

W, DAMPING, FRICTION = 1.5, 0.2, 0.6
PERIOD = 2 * np.pi / W
FIELD = np.array([[0.0, 1.0], [-1.0, -DAMPING]])
LEAST = 0.2
"""What has to be left between the mass and the wall."""

LOCATED = 2e-8
"""Steps below 1e-9 end a branch; the last one tried is up to some times as long, and so is the span
in which A is counted."""


def before_a_wall(wall):
    """A mass on a belt of speed 1, with a wall behind it."""
    return sf.System(
        name="before a wall",
        parameters={"A": 0.1, "W": W},
        states={"x": "v", "v": f"F - x - {DAMPING}*v + A*cos(W*t)"},
        contacts={
            "F": {"slip": "1.0 - v", "normal": "1.0", "friction": sf.Coulomb(FRICTION, FRICTION)}
        },
        forcing={"period": "2*pi/W"},
        outputs={"room": f"{wall} + x"},
        limits={"wall": {"output": "room", "bound": LEAST}},
    )


def slid(state, begin, end, force, amplitude):
    """Where a motion under a constant force is later, in closed form."""
    gain = amplitude / (1 - W**2 + 1j * DAMPING * W)

    def forced(time):
        swing = gain * np.exp(1j * W * time)
        return np.array([force + swing.real, (1j * W * swing).real])

    return forced(end) + expm(FIELD * (end - begin)) @ (state - forced(begin))


def sticks_once(unknown, least):
    """Slip from where friction holds no longer, and along with the belt to there again."""
    x, begin, rest, lowest, amplitude = unknown
    there = slid(np.array([x, 1.0]), begin, rest, FRICTION, amplitude)
    low = slid(np.array([x, 1.0]), begin, lowest, FRICTION, amplitude)
    held = x + DAMPING - amplitude * np.cos(W * begin)
    along = there[0] + PERIOD - (rest - begin)
    return [there[1] - 1, along - x, held - FRICTION, low[0] - least, low[1]]


def turns_twice(unknown, least):
    """Slip one way until it turns, and the other way back to the first turn."""
    x, begin, turn, lowest, amplitude = unknown
    there = slid(np.array([x, 1.0]), begin, turn, FRICTION, amplitude)
    back = slid(there, turn, begin + PERIOD, -FRICTION, amplitude)
    low = slid(np.array([x, 1.0]), begin, lowest, FRICTION, amplitude)
    return [there[1] - 1, back[0] - x, back[1] - 1, low[0] - least, low[1]]


@pytest.mark.parametrize(
    ("wall", "motion", "guess"),
    [
        (0.4, sticks_once, [0.6, 0.9, 4.6, 3.7, 1.0]),
        pytest.param(1.0, turns_twice, [0.6, 1.2, 4.3, 3.7, 1.6], marks=pytest.mark.long),
    ],
)
def test_a_branch_through_stick_ends_at_the_wall(wall, motion, guess):
    (branch,) = sf.response(before_a_wall(wall), vary="A", span=(0.05, 3.0)).branches
    assert (branch.stuck_fraction[-1] > 0) == (motion is sticks_once)
    assert branch.stopped.kind == "limit"
    assert branch.stopped.reason == "wall: room fell to 0.2; the model ends at 0.2"
    unknown, details, _, _ = fsolve(motion, guess, (LEAST - wall,), full_output=True, xtol=1e-13)
    assert np.abs(details["fvec"]).max() < 1e-12
    assert branch.stopped.value == branch.parameter[-1]
    assert branch.stopped.value == pytest.approx(unknown[-1], abs=LOCATED)
    assert branch.extrema.of("x")[0][-1] == pytest.approx(LEAST - wall, abs=LOCATED)
