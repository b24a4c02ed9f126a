"""A limit means the same whatever is subtracted from what it watches."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import slipfold as sf
from slipfold.bifurcations.branches.ends import failure_reason
from slipfold.continuation.walk import Failure
from slipfold.orbits.kinds import orbits_of

FLOOR = -0.36
SPAN = (0.005, 0.4)
SHIFTS = [0.0, -FLOOR, 1.0]
"""Added to x and to its bound, which is below zero, zero, and above it then."""

LOCATED = 1e-9
"""Arclength, in spans and typical sizes, to which branches are cut where a limit is met."""

SINGLE = sf.Settings(largest_period=1)


def escaping(shift):
    return sf.System(
        name="escape",
        parameters={"F": 0.01, "c": 0.3, "W": 0.95},
        states={"x": "v", "v": "F*sin(W*t) - c*v - x + x^2"},
        outputs={"room": f"x + {shift!r}"},
        forcing={"period": "2*pi/W", "amplitude": "F"},
        limits={"floor": {"output": "room", "bound": FLOOR + shift}},
    )


@pytest.fixture(scope="module")
def branches():
    return [
        sf.response(escaping(shift), "F", SPAN, settings=SINGLE).branches[0] for shift in SHIFTS
    ]


def test_branches_end_at_the_same_place(branches):
    width = SPAN[1] - SPAN[0]
    for branch in branches:
        assert branch.stopped.kind == "limit"
        same = pytest.approx(branches[0].stopped.value, abs=2 * LOCATED * width)
        assert branch.stopped.value == same


def test_motions_of_another_method_touch_the_limit_where_branches_end(branches):
    for branch in branches:
        force, start = branch.stopped.value, branch.orbit(-1).nodes[0]

        def rates(t, y, force=force):
            x, v = y
            return [v, force * np.sin(0.95 * t) - 0.3 * v - x + x * x]

        def turns(t, y):
            return y[1]

        period = 2 * np.pi / 0.95
        found = solve_ivp(
            rates, (0, period), start, method="DOP853", rtol=1e-12, atol=1e-13, events=turns
        )
        # x moves by less than ten times what F does, in spans, there.
        assert found.y_events[0][:, 0].min() == pytest.approx(FLOOR, abs=10 * LOCATED)


def test_a_curve_lost_beside_the_limit_is_lost_because_of_it(branches):
    for branch in branches[:2]:
        points = {-1: "limit", 0: "failed"}
        for index, expected in points.items():
            orbit = branch.orbit(index)
            orbits = orbits_of(orbit.model, {"F": 1.0}, 1, len(orbit.nodes))
            z = orbits.unknown(orbit.nodes, orbit.model)
            tangent = np.eye(1, len(z), len(z) - 1)[0]
            last = SimpleNamespace(z=z, tangent=tangent, multipliers=orbit.multipliers)
            kind, _ = failure_reason(orbits, last, Failure("failed", "Newton's method failed"))
            assert kind == expected
