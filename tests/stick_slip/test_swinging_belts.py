"""Counter-bodies whose velocity is a function of time: what sticks is accelerated with them."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import slipfold as sf


def swinging(spring=0.0, amplitude=1.0, f=0.2):
    """A mass on a table that swings, in units in which its weight is one."""
    return sf.System(
        parameters={"f": f, "A": amplitude, "k": spring, "mu": 0.5},
        states={"x": "v", "v": "F - k*x"},
        contacts={
            "F": {
                "slip": "A*cos(2*pi*f*t) - v",
                "normal": "1",
                "friction": {"law": "Coulomb", "mu_s": "1.2*mu", "mu_k": "mu"},
            }
        },
        forcing={"period": "1/f"},
    )


def test_what_sticks_swings_with_the_table():
    model = swinging(amplitude=0.4, f=0.1)  # it needs 0.4 * 0.2 pi of 0.6
    motion = sf.simulate(model, 3, [0.0, 0.4])
    assert [item.state for item in motion.sticking.intervals] == ["stick"]
    time, states = motion.sample(per_period=64)
    rate = 0.2 * math.pi
    assert states[:, 1] == pytest.approx(0.4 * np.cos(rate * time), abs=1e-14)
    assert states[:, 0] == pytest.approx(0.4 / rate * np.sin(rate * time), abs=1e-12)
    held = motion.output("F", per_period=64)[1]
    assert held == pytest.approx(-0.4 * rate * np.sin(rate * time), abs=1e-13)
    assert motion.output("F_slip", per_period=64)[1] == pytest.approx(0, abs=1e-14)
    # What the table puts in comes back: kinetic energy and nothing else
    (one,) = motion.sticking.intervals
    assert one.heat == 0
    assert one.work == pytest.approx(0, abs=1e-12)


def test_it_lets_go_where_its_inertia_is_more_than_friction_holds():
    rate = 0.4 * math.pi
    motion = sf.simulate(swinging(), 1, [0.0, 1.0])
    stick, slip, *_ = motion.sticking.intervals
    assert (stick.state, slip.state) == ("stick", "slip")
    release = math.asin(0.6 / rate) / rate
    assert stick.end == pytest.approx(release * 0.2, abs=1e-14)
    # By hand: the table is slower, kinetic friction slows the mass until it is as slow
    before = np.cos(rate * release)
    stop = slip.end * motion.forcing_period
    assert math.cos(rate * stop) == pytest.approx(before - 0.5 * (stop - release), abs=1e-13)


def test_against_an_integration_from_event_to_event_by_scipy():
    model, rate = swinging(spring=1.0), 0.4 * math.pi

    def table(t):
        return math.cos(rate * t)

    def needed(t, x):
        return -rate * math.sin(rate * t) + x

    t, y, sign = 0.0, np.array([0.0, 0.0]), 1.0
    states = [y]
    for end in 5.0 * np.arange(1, 7):
        while t < end:
            if sign:
                found = solve_ivp(
                    lambda t, y, s=sign: (y[1], 0.5 * s - y[0]),
                    (t, end), y, method="DOP853", rtol=1e-13, atol=1e-14,
                    events=zero(lambda t, y, s=sign: s * (table(t) - y[1])), max_step=0.05,
                )  # fmt: skip
            else:
                found = solve_ivp(
                    lambda t, y: (table(t), -rate * math.sin(rate * t)),
                    (t, end), y, method="DOP853", rtol=1e-13, atol=1e-14,
                    events=zero(lambda t, y: 0.6 - abs(needed(t, y[0]))), max_step=0.05,
                )  # fmt: skip
            t, y = found.t[-1], found.y[:, -1]
            if found.status == 1:
                y[1] = table(t)
                force = needed(t, y[0])
                sign = math.copysign(1.0, force) if abs(force) > 0.6 - 1e-9 else 0.0
        states.append(y)
    motion = sf.simulate(model, 6, [0.0, 0.0])
    assert {item.state for item in motion.sticking.intervals} == {"stick", "slip"}
    assert motion.states == pytest.approx(np.array(states), abs=1e-9)


def zero(function):
    function.terminal, function.direction = True, -1
    return function
