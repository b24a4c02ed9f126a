"""Values of sliding.json but those on loci: handed over, each by two independent methods."""

import numpy as np
import pytest
from scipy.optimize import linear_sum_assignment

from helpers.reference import CASES, DATA, model_values, specials, traced
from slipfold import SlidingOscillator, periodic_orbit


def within(value):
    """Compare to all digits given, which is at least as sharp as 1e-6 relative where it can be."""
    return pytest.approx(float(value), rel=0, abs=value.unit)


@pytest.mark.parametrize("case", CASES, ids=str)
@pytest.mark.parametrize("period", [1, 2])
def test_all_special_points_and_no_others(case, period):
    found = specials(traced(case), period)
    expected = sorted(case.period1 if period == 1 else case.period2, key=lambda item: item[1])
    assert [item[0] for item in found] == [item[0] for item in expected]
    for (_, value, criticality), (_, wanted, *rest) in zip(found, expected, strict=True):
        assert value == within(wanted)
        if rest:
            assert criticality == rest[0]


@pytest.mark.parametrize("case", CASES, ids=str)
def test_no_branch_beyond_period_two(case):
    assert {branch.period for branch in traced(case)} == {1, 2}


@pytest.mark.parametrize("case", CASES, ids=str)
def test_every_special_point_is_complete(case):
    for branch in traced(case):
        for item in branch.special:
            assert (item.criticality is None) == (item.type == "LP")
            assert np.isfinite(item.coefficient)
            assert 0 < item.uncertainty < 1e-9 * abs(item.value)
            # The orbit amplifies an error of its state, about 1e-14, by its largest multiplier.
            largest = max(1.0, np.abs(item.multipliers).max())
            assert np.all(item.multiplier_uncertainty < (1e-10 + 2e-14 * largest) * largest)
            assert item.residual <= 1e-10
            target = {"LP": 1.0, "PD": -1.0}.get(item.type)
            critical = item.critical_multiplier
            if target is None:
                assert abs(critical) == pytest.approx(1, abs=1e-8)
                assert critical.imag > 1e-3
            else:
                assert critical == pytest.approx(target, abs=1e-8)


def same_multipliers(found, expected):
    expected = np.array([complex(*pair) for pair in expected])
    distance = np.abs(found[:, None] - expected[None, :])
    return distance[linear_sum_assignment(distance)].max()


@pytest.mark.parametrize("item", DATA["orbits"], ids=lambda item: str(item["set"]))
def test_orbits_and_their_multipliers(item):
    model = SlidingOscillator(**model_values(item["set"]))
    orbit = periodic_orbit(model, item["period"])
    scales = model.state_scales()
    # Which of the two phases an orbit of period 2 is stored with is a matter of taste.
    states = orbit.nodes[:: len(orbit.nodes) // item["period"]]
    distance = np.abs((states - item["state"]) / scales).max(axis=1)
    assert distance.min() < 1e-9
    assert same_multipliers(orbit.multipliers, item["multipliers"]) < 1e-7
    assert orbit.residual <= 1e-10
    if "determinant" in item:
        determinant = np.prod(orbit.multipliers)
        assert determinant == pytest.approx(item["determinant"], abs=1e-11)
