"""Textbook systems with known answers; values and sources in shared/reference/textbook.md."""

from functools import cache

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from helpers.textbook_models import Duffing, Mathieu, Pitchfork, Torus, VanDerPol
from helpers.toy_models import LinearOscillator
from slipfold import Settings, Steps
from slipfold.bifurcations.branches.response import trace_response


def traced(model, vary, span, largest=0.5):
    return trace_response(model, vary, span, settings=Settings(steps=Steps(largest=largest)))


def types(branch):
    return [item.type for item in branch.special]


@pytest.mark.parametrize(("largest", "span"), [(0.1, (0.8, 1.6)), (1.0, (1.6, 0.8))])
def test_folds_of_the_duffing_oscillator(span, largest):
    (branch,) = traced(Duffing(), "w", span, largest)
    assert types(branch) == ["LP", "LP"]
    low, high = sorted(branch.special, key=lambda item: item.value)
    assert high.value == pytest.approx(1.269601955546, abs=2e-12)
    assert high.state == pytest.approx([-0.140434285344, 3.413427245844], abs=1e-9)
    assert np.abs(high.multipliers).min() == pytest.approx(0.780792, abs=1e-6)
    # The list of textbook values has 2.871529 and 1.085018, samples next to the extrema.
    assert high.orbit.extrema.of("q")[1] == pytest.approx(by_scipy(high), abs=1e-9)
    assert low.value == pytest.approx(1.115700251771, abs=2e-12)
    assert low.state == pytest.approx([-1.020826011254, 0.413916481576], abs=1e-9)
    assert low.orbit.extrema.of("q")[1] == pytest.approx(by_scipy(low), abs=1e-9)


def by_scipy(item):
    """Largest q of a Duffing orbit: where q' falls through zero, by an event of SciPy's."""
    w, (k, g, d, a) = item.value, (1.0, 0.1, 0.05, 0.18)

    def rates(t, s):
        return [s[1], a * np.cos(w * t) - d * s[1] - k * s[0] - g * s[0] ** 3]

    def turning(t, s):
        return s[1]

    turning.direction = -1
    end = 2 * np.pi / w
    run = solve_ivp(rates, (0, end), item.state, "DOP853", rtol=1e-12, atol=1e-13, events=turning)
    return run.y_events[0][:, 0].max()


def test_a_fold_turns_the_branch():
    (branch,) = traced(Duffing(), "w", (0.8, 1.6))
    turns = np.flatnonzero(np.diff(np.sign(np.diff(branch.parameter))))
    assert len(turns) == 2
    inside = (branch.parameter > 1.13) & (branch.parameter < 1.25)
    assert {0, 1} == set(branch.unstable[inside])


@pytest.mark.parametrize(("w", "h"), [(2.0, 0.0400008749895), (1.9, 0.2014699309238)])
@pytest.mark.parametrize("g", [1.0, -1.0])
def test_doubling_of_the_damped_mathieu_equation(w, h, g):
    main, child = traced(Mathieu(w=w, g=g), "h", (0.0, 1.5 * h))
    assert types(main) == ["PD"]
    assert main.special[0].value == pytest.approx(h, abs=1e-12)
    assert child.period == 2
    assert child.parent == 1
    assert main.special[0].leads_to == child.id
    # The cubic term decides to which side the doubled orbits go, at first: where it nearly
    # vanishes they turn round after 5e-3 of arclength.
    side = np.sign(child.parameter[1] - h)
    assert (main.special[0].criticality == "supercritical") == (side > 0)


@pytest.mark.parametrize(("largest", "span"), [(0.1, (1.2, 1.0)), (1.0, (1.0, 1.2))])
def test_torus_of_the_forced_van_der_pol_oscillator(span, largest):
    (branch,) = traced(VanDerPol(), "w", span, largest)
    assert types(branch) == ["NS"]
    item = branch.special[0]
    assert item.value == pytest.approx(1.086728948108, abs=2e-12)
    assert item.critical_multiplier == pytest.approx(0.915559 + 0.402185j, abs=1e-6)
    # Outside the tongue the oscillator keeps its own frequency: a stable torus.
    assert item.criticality == "supercritical"


@pytest.mark.parametrize(
    ("n", "span"), [(1.0, (-0.5, 0.4)), (-1.0, (0.5, -0.4)), (0.3, (0.5, -0.4))]
)
def test_normal_form_of_a_torus_is_exact(n, span):
    # |z| becomes |z| (1 - n |z|^2) at m = 0; a unit eigenvector has |z|^2 = 2 |w|^2.
    (branch,) = traced(Torus(n=n), "m", span)
    assert types(branch) == ["NS"]
    item = branch.special[0]
    assert abs(item.value) < 1e-12
    assert item.critical_multiplier == pytest.approx(np.exp(1j), abs=1e-12)
    assert item.coefficient == pytest.approx(-2 * n, rel=1e-10)
    assert item.criticality == ("supercritical" if n > 0 else "subcritical")


@cache
def pitchfork_by_short_steps():
    return traced(Pitchfork(), "k", (1.0, -1.0), 0.005)[0].special[0].value


@pytest.mark.parametrize(
    ("largest", "span"), [(0.1, (1.0, -1.0)), (1.0, (-1.0, 1.0)), (1.0, (0.3, -0.2))]
)
def test_pitchfork_is_a_branch_point(span, largest):
    branch, other = traced(Pitchfork(), "k", span, largest)
    assert types(branch) == ["BP"]
    assert branch.special[0].leads_to == other.id
    item = branch.special[0]
    assert item.critical_multiplier == pytest.approx(1.0, abs=1e-9)
    assert item.criticality == "supercritical"
    assert branch.stopped.kind == "span"
    # Rest loses stability a little below k = 0, where the parametric force holds it up:
    # b^2/(2 w^2) = 0.005 to lowest order.
    assert item.value == pytest.approx(-0.005, abs=1e-4)
    assert item.value == pytest.approx(pitchfork_by_short_steps(), abs=1e-10)
    assert np.all(np.abs(branch.states) < 1e-12)


@pytest.mark.parametrize("vary", ["f", "a", "zeta", "f0"])
def test_linear_oscillator_has_its_closed_form_everywhere(vary):
    span = {"f": (0.5, 1.8), "a": (0.0, 2.0), "zeta": (0.3, 0.02), "f0": (0.7, 1.6)}[vary]
    (branch,) = traced(LinearOscillator(), vary, span)
    assert branch.special == ()
    assert branch.parameter[[0, -1]] == pytest.approx(span, rel=1e-15)
    for index in range(len(branch)):
        model = branch.orbit(index).model
        amplitude = model.response_amplitude()
        w = 2 * np.pi * model.f
        exact = [amplitude.real, (1j * w * amplitude).real]
        assert branch.states[index] == pytest.approx(exact, abs=1e-11)
        assert branch.extrema.of("x")[1][index] == pytest.approx(abs(amplitude), abs=1e-11)
