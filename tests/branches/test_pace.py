"""Equilibria whose eigenvalues become much faster or slower along the branch."""

import math

import numpy as np
import pytest
from scipy.special import ellipk

import slipfold as sf

ALONE = sf.Settings(largest_period=1)
"""Period doublings are not followed."""

FREQUENCY = f"exp({math.log(100)!r}*p)"
"""From 1 rad/s at p = 0 to 100 rad/s at p = 1."""


def oscillator(memory="z - x"):
    """Damping that is negative for 0.02 < p < 0.98, and a state that remembers x."""
    return sf.System(
        name="oscillator",
        parameters={"p": 0.0},
        states={
            "x": "v",
            "v": f"-{FREQUENCY}*(p - 0.02)*(p - 0.98)*v - {FREQUENCY}^2*x - v^3/100",
            "z": f"-({memory})",
        },
    )


MEMORIES = [
    pytest.param(
        memory, span, marks=[] if (memory, span) == ("z - x", (0, 1)) else pytest.mark.long
    )
    for memory in ("z - x", "exp(18*p)*(z - x)", "exp(18*p)*z + exp(17*p)*x")
    for span in ((0, 1), (1, 0))
]
"""What the third state does, and the way through; most of them in `make long`."""


@pytest.mark.parametrize(("memory", "span"), MEMORIES)
def test_the_frequency_grows_a_hundred_times(span, memory):
    # The fast state decays at up to 6.6e7 per second; it changes neither frequency nor damping.
    still = sf.response(oscillator(memory), vary="p", span=span, settings=ALONE).branches[0]
    assert [item.type for item in still.special] == ["HB", "HB"]
    assert sorted(item.value for item in still.special) == pytest.approx([0.02, 0.98], abs=1e-9)
    for point in still.special:
        frequency = math.exp(math.log(100) * point.value)
        assert point.duration == pytest.approx(2 * math.pi / frequency, rel=1e-9)
        assert point.criticality == "supercritical"
        if memory == "z - x":
            # v^3/100 damps the amplitude of x by (3/8) w^2 r^3/100; the vector has unit length.
            length = 1 + frequency**2 + 1 / (1 + frequency**2)
            assert point.coefficient == pytest.approx(-0.015 * frequency / length, rel=1e-8)
    assert still.stopped.kind == "span"


@pytest.mark.parametrize("span", [(0, 1), (1, 0)])
def test_multipliers_are_over_durations_that_keep_pace(span):
    still = sf.response(oscillator(), vary="p", span=span, settings=ALONE).branches[0]
    p = still.parameter
    frequency = np.exp(math.log(100) * p)
    growth = -frequency * (p - 0.02) * (p - 0.98) / 2
    turning = np.sqrt(frequency**2 - growth**2)
    upper = np.array([values[values.imag > 0][0] for values in still.multipliers])
    assert np.angle(upper) / still.durations == pytest.approx(turning, rel=1e-12)
    assert np.log(np.abs(upper)) / still.durations == pytest.approx(growth, rel=1e-9, abs=1e-11)
    assert np.angle(upper).max() < 1
    assert np.all(still.unstable == 2 * (growth > 0))
    assert still.multiplier_uncertainty.max() < 1e-10


def test_a_hopf_point_beside_fast_turning_that_decays():
    # A pair at 1e4 (-1 +- i) per second beside one that turns once a second.
    model = sf.System(
        name="stiff",
        parameters={"c": 0.5},
        states={
            "x": "2*pi*v",
            "v": "-2*pi*x - c*v - v^3",
            "a": "1e4*(-a - b) + x",
            "b": "1e4*(a - b)",
        },
    )
    (hopf,) = sf.response(model, vary="c", span=(0.5, -0.5), settings=ALONE).branches[0].special
    assert hopf.type == "HB"
    assert hopf.value == pytest.approx(0, abs=1e-9)
    assert hopf.duration == pytest.approx(1, rel=1e-9)


def test_the_swings_of_a_pendulum_up_to_near_its_separatrix():
    # A family of centers: the duration is 4 K(sin^2(a/2)) at amplitude a, the parameter stands.
    states = {"q": "v", "v": "c*v - sin(q)"}
    model = sf.System(name="pendulum", parameters={"c": 0.1}, states=states)
    amplitudes = (1.0, 2.0, 3.0, 3.1)
    events = [sf.Event("q", item, stop=item == amplitudes[-1]) for item in amplitudes]
    diagram = sf.response(model, vary="c", span=(-0.1, 0.1), events=events, settings=ALONE)
    family = diagram.branches[1]
    assert [item.type for item in family.special] == ["EVENT"] * 4
    exact = [4 * ellipk(np.sin(item / 2) ** 2) for item in amplitudes]
    assert [item.duration for item in family.special] == pytest.approx(exact, rel=1e-9)
