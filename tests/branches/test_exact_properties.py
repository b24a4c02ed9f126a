"""The four exact properties of the sliding oscillator, on whole branches."""

import math

import numpy as np
import pytest

from helpers.reference import CASES, specials, traced
from slipfold import SlidingOscillator
from slipfold.bifurcations.branches.response import trace_response

MIRROR = np.array([-1.0, 1.0, -1.0, 1.0])


def same_specials(one, two, factor=1.0):
    assert len(one) == len(two)
    for (kind, value, side), (other_kind, other, other_side) in zip(one, two, strict=True):
        assert (kind, side) == (other_kind, other_side)
        assert value == pytest.approx(factor * other, rel=1e-10)


@pytest.mark.parametrize("f", [12.5, 12.2])
def test_friction_and_normal_force_act_by_their_product(f):
    one = traced(CASES[0] if f == 12.5 else CASES[1])
    two = trace_response(SlidingOscillator(f=f, mu=0.25, Ns=2.0), "Nd", (0, 1.96))
    same_specials(specials(one), specials(two), 0.5)
    for left, right in zip(one, two, strict=True):
        assert left.stopped.kind == right.stopped.kind
        assert 2 * left.stopped.value == pytest.approx(right.stopped.value, rel=1e-7)
        for a, b in zip(left.special, right.special, strict=True):
            assert a.state == pytest.approx(b.state, rel=1e-8, abs=1e-9)
            growth = np.abs(a.multipliers).max()
            assert a.multipliers == pytest.approx(b.multipliers, abs=1e-9 * growth)
            assert a.coefficient == pytest.approx(b.coefficient, rel=1e-6)


def test_coefficients_along_different_parameters_agree():
    # A normal form belongs to the map, not to the parameter that led there.
    case = CASES[9]
    for branch in traced(case):
        for item in branch.special:
            if branch.period == 1:
                model = SlidingOscillator(f=item.value)
                (along_force,) = [
                    other
                    for one in trace_response(model, "Nd", (0.05, 0.15))
                    for other in one.special
                    if other.type == item.type and abs(other.value - 0.1) < 1e-6
                ]
                assert along_force.value == pytest.approx(0.1, abs=1e-9)
                assert along_force.coefficient == pytest.approx(item.coefficient, rel=1e-6)
    backward = {item.value: item for one in traced(case, case.reverse) for item in one.special}
    for branch in traced(case):
        for item in branch.special:
            other = min(backward.values(), key=lambda one: abs(one.value - item.value))
            assert np.sign(other.coefficient) == np.sign(item.coefficient) or item.type == "LP"
            # Whichever copy of an orbit of period two it is.
            assert abs(other.coefficient) == pytest.approx(abs(item.coefficient), rel=1e-6)


@pytest.mark.parametrize("alpha", [math.pi / 3, 0.4])
def test_mirrored_direction_mirrors_the_branches(alpha):
    one = trace_response(SlidingOscillator(f=12.5, alpha=alpha), "Nd", (0, 0.6))
    two = trace_response(SlidingOscillator(f=12.5, alpha=math.pi - alpha), "Nd", (0, 0.6))
    same_specials(specials(one), specials(two))
    for left, right in zip(one, two, strict=True):
        for a, b in zip(left.special, right.special, strict=True):
            states = b.nodes[:: len(b.nodes) // b.period] * MIRROR / a.model.state_scales()
            distance = np.abs(states - a.state / a.model.state_scales()).max(axis=1)
            assert distance.min() < 1e-8


def test_a_turn_of_the_direction_is_symmetric_about_the_vertical():
    branches = trace_response(SlidingOscillator(f=12.5, Nd=0.1), "alpha", (0.0, math.pi))
    values = np.array([item[1] for item in specials(branches)])
    kinds = [item[0] for item in specials(branches)]
    assert kinds == ["PD", "NS", "NS", "PD"]
    assert values + values[::-1] == pytest.approx(math.pi, abs=1e-10)
    assert branches[1].stopped.kind == "closed"


@pytest.mark.parametrize("case", CASES[:2] + CASES[8:], ids=str)
def test_determinant_is_positive_and_nearly_constant_along_the_branch(case):
    # exp of the integral of the trace: damping alone, friction's share and structure's.
    for branch in traced(case):
        growth = np.abs(branch.multipliers).max(axis=1)
        determinant = np.prod(branch.multipliers, axis=1)
        calm = growth < 100
        assert np.all(np.abs(determinant[calm].imag) < 1e-9)
        assert np.all(determinant[calm].real > 0)
        assert np.all(determinant[calm].real < 1)


def test_vertical_motion_of_an_upright_plate_leaves_x_at_rest():
    main, child = trace_response(SlidingOscillator(f=12.5, alpha=math.pi / 2), "Nd", (0, 0.1))
    assert np.max(np.abs(main.nodes[:, :, 0])) < 1e-9
    # The doubled branch is where x wakes up.
    assert [item.type for item in main.special] == ["PD"]
    assert np.max(np.abs(child.nodes[-1, :, 0])) > 0.05
