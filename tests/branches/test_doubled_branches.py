"""Branches of doubled period: how they hang together, close and double again."""

from functools import cache

import numpy as np
import pytest

from helpers.by_hand.dense import carry, scales
from helpers.long_tests import long_except
from helpers.reference import CASES, traced
from slipfold import Settings, SlidingOscillator
from slipfold.bifurcations.branches.response import trace_response

CASCADES = [
    ({"f": 11.9035, "mu": 0.5095, "alpha": 2.4239, "Vd": 1.0922}, "Nd", (0.0, 0.98)),
    ({"Nd": 0.2813, "mu": 0.562, "alpha": 2.8958, "Vd": 0.7932}, "f", (15.0, 8.0)),
    ({"f": 12.0803, "Nd": 0.9258, "alpha": 0.1181, "Vd": 0.6949}, "mu", (1.0, 0.0)),
]


@cache
def cascade(index, reverse=False, **options):
    """A cascade; its branches are immutable, so that tests share them."""
    values, vary, span = CASCADES[index]
    return trace_response(
        SlidingOscillator(**values), vary, span[::-1] if reverse else span, **options
    )


@pytest.mark.parametrize("case", CASES, ids=str)
def test_every_doubling_leads_to_a_branch_and_back(case):
    check_links(traced(case))


def check_links(branches, largest_period=8):
    by_id = {branch.id: branch for branch in branches}
    assert list(by_id) == list(range(1, len(branches) + 1))
    reached = set()
    for branch in branches:
        for item in branch.special:
            if item.type == "PD" and 2 * branch.period <= largest_period:
                child = by_id[item.leads_to]
                assert child.parent == branch.id
                assert child.period == 2 * branch.period
                reached.add(child.id)
                ends = (child.started.value, child.stopped.value)
                assert min(abs(value - item.value) for value in ends) < 1e-9
            else:
                assert item.leads_to is None
    assert reached == set(by_id) - {1}
    assert branches[0].parent is None


@pytest.mark.parametrize("case", CASES[8:], ids=str)
@pytest.mark.parametrize("backward", [False, True])
def test_frequency_response_closes_on_both_doublings(case, backward):
    main, child = traced(case, case.reverse if backward else None)
    assert child.stopped.kind == "closed"
    assert [item.leads_to for item in main.special] == [2, 2]
    begin, end = (item.value for item in main.special)
    assert child.started.value == pytest.approx(begin, abs=1e-10)
    assert child.stopped.value == pytest.approx(end, abs=1e-10)
    assert child.parameter[[0, -1]] == pytest.approx([begin, end], abs=1e-9)
    # Its ends are the parent's orbits, twice around.
    half = child.nodes.shape[1] // 2
    for index in (0, -1):
        assert child.nodes[index, :half] == pytest.approx(child.nodes[index, half:], abs=1e-8)


@pytest.mark.parametrize("index", long_except([0, 1, 2], [0]))
@pytest.mark.parametrize("reverse", [False, True])
def test_cascades(index, reverse):
    branches = cascade(index, reverse)
    check_links(branches)
    assert {branch.period for branch in branches} >= {1, 2, 4}
    for branch in branches:
        size = branch.model.state_scales()
        for item in branch.special:
            values = item.model.values
            edges = np.linspace(0, item.period, len(item.nodes) + 1)
            ends = [
                carry(node, values, start, end)
                for node, start, end in zip(item.nodes, edges[:-1], edges[1:], strict=True)
            ]
            error = (ends - np.roll(item.nodes, -1, axis=0)) / scales(values)
            assert np.abs(error).max() < 1e-8
        if branch.period > 1 and len(branch) > 3:
            middle = branch.nodes[len(branch) // 2]
            apart = np.abs((middle - np.roll(middle, len(middle) // 2, axis=0)) / size).max()
            assert apart > 1e-5


@pytest.mark.parametrize("index", long_except([0, 1, 2], [0]))
def test_cascades_do_not_depend_on_the_direction(index):
    def found(branches, period):
        return sorted(
            (item.value, item.type)
            for branch in branches
            if branch.period == period
            for item in branch.special
        )

    forward, backward = cascade(index), cascade(index, reverse=True)
    for period in (1, 2, 4):
        one, two = found(forward, period), found(backward, period)
        assert [item[1] for item in one] == [item[1] for item in two]
        assert [item[0] for item in one] == pytest.approx([item[0] for item in two], rel=1e-8)


@pytest.mark.parametrize("period", [2, 4])
def test_motion_settles_to_a_stable_orbit_of_a_cascade(period):
    orbits = [
        branch.orbit(index)
        for branch in cascade(0)
        if branch.period == period
        for index in np.flatnonzero(branch.stable)
    ]
    orbit = min(orbits, key=lambda item: np.abs(item.multipliers).max())
    values, size = orbit.model.values, scales(orbit.model.values)
    growth = np.abs(orbit.multipliers).max()
    state, rounds = orbit.state + 1e-3 * size, 16
    for _ in range(rounds):
        state = carry(state, values, 0, period)
    assert np.abs((state - orbit.state) / size).max() < 0.05 * growth**rounds + 1e-9


@pytest.mark.parametrize("largest", [1, 2, 4])
def test_largest_period_is_kept(largest):
    branches = cascade(0, settings=Settings(largest_period=largest))
    assert max(branch.period for branch in branches) == largest
    check_links(branches, largest)
