"""Cases that users and reviewers stumbled over."""

from dataclasses import replace

import numpy as np
import pytest

import slipfold as sf
from slipfold.bifurcations.branches.response import trace_response
from slipfold.bifurcations.loci.fan import ends_in_stick
from slipfold.models.registry import model_named

WINDOW = {"f": (11.5, 13.5), "Nd": (0.0, 0.98)}


def special(frequency, kind, period):
    diagram = sf.response(sf.SlidingOscillator(), vary="Nd", span=(0, 0.98), f=frequency)
    return next(
        item.point
        for item in diagram.special
        if item.point.type == kind and item.branch.period == period
    )


def test_a_fold_followed_to_its_birth_finds_the_period_doubling_it_was_born_at():
    found = sf.locus(special(12.2, "LP", 2), ("f", "Nd"), WINDOW)
    assert [(locus.type, locus.period) for locus in found.loci] == [("LP", 2), ("PD", 1)]
    fold, doubling = found.loci
    (birth,) = [point for point in doubling.special if point.type == "GPD"]
    # tests/reference/loci.json
    assert birth.values == pytest.approx((12.436208469546, 0.042015324815), abs=1e-10)
    ends = [end for end in (fold.started, fold.stopped) if end.kind == "codimension-2"]
    assert [end.values for end in ends] == [birth.values]
    assert birth.leads_to == (fold.id,)


@pytest.mark.long
def test_folds_of_ever_longer_cycles_end_beside_a_homoclinic_orbit():
    # Jansen and Rit (1995): SciPy finds a saddle 1e-7 from the last cycle, with 28.7 and -30.1/s.
    states = {
        "x": "u",
        "y": "v",
        "z": "w",
        "u": "1625*sigmoid(0.56*(y - z - 6)) - 200*u - 1e4*x",
        "v": "325*(p + 4*C*sigmoid(0.56*(C*x - 6))) - 200*v - 1e4*y",
        "w": "1375*C*sigmoid(0.56*(C*x/4 - 6)) - 100*w - 2500*z",
    }
    model = sf.System(parameters={"p": 390, "C": 137}, states=states)
    alone = sf.Settings(largest_period=1)
    _, cycles, _ = sf.response(model, vary="p", span=(390, -50), settings=alone).branches
    window = ("p", "C"), ((95, 160), (130.5, 137.1))
    (folds,) = sf.locus(cycles.special[1], *window, switch=False).loci
    (end,) = (end for end in (folds.started, folds.stopped) if end.kind == "homoclinic")
    assert "the cycle nears a homoclinic orbit" in end.reason


def test_the_fifth_order_coefficient_at_a_birth_says_where_the_fold_lies():
    # Near the point b = -2 e a^2 on the fold, with the amplitude a of the doubled orbit.
    found = sf.locus(special(12.5, "PD", 1), ("f", "Nd"), WINDOW)
    doubling, fold = found.loci
    (birth,) = [point for point in doubling.special if point.type == "GPD"]
    halves = fold.nodes[:, :4] - fold.nodes[:, 4:]
    scales = fold.model.state_scales()
    amplitude = 0.5 * np.linalg.norm(halves[:, 0] / scales, axis=1)
    near = int(np.flatnonzero((amplitude > 0.002) & (amplitude < 0.03))[0])
    frequency = fold.values[near, 0]
    order = np.argsort(doubling.values[:, 0])
    known = np.append(doubling.values[order, 0], birth.values[0])
    coefficients = np.append(doubling.coefficient[order], 0.0)
    side = np.argsort(known)
    b = np.interp(frequency, known[side], coefficients[side])
    assert b < 0 < birth.coefficients["e"]
    ratio = -b / (2 * birth.coefficients["e"] * amplitude[near] ** 2)
    assert 0.3 < ratio < 3  # the projection on the critical vector is not made here


def test_two_stable_responses_of_one_period_are_distinguished_from_one(few_lines):
    window = {"W": (0.8, 1.6), "F": (0.01, 0.3)}
    plane = sf.bifurcation_set(model_named("duffing"), ("W", "F"), window)
    kinds = {region.stable: region for region in plane.regions.regions}
    assert set(kinds) == {(1,), (1, 1)}
    assert kinds[1, 1].name == "2 of period 1"
    assert len(kinds[1, 1].checks) == 3
    assert all(check.agrees for region in kinds.values() for check in region.checks)


def test_a_response_that_ends_where_no_model_is_ends_in_no_stick():
    # Rounding may put the last point of one that loses contact at Nd = Ns itself.
    branch, *_ = trace_response(sf.SlidingOscillator(Ns=0.2), "Nd", (0.15, 0.2))
    assert branch.stopped.kind == "limit"
    parameter = branch.parameter.copy()
    parameter[-1] = 0.2
    assert not ends_in_stick(replace(branch, parameter=parameter))
