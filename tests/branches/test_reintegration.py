"""Orbits close when re-integrated from what is printed, by a program that shares no code.

One shot over the period is asked of orbits whose multipliers stay below a thousand, so that the
last printed digit cannot grow to more than 1e-9. The others are integrated node by node: that every
segment ends where the next begins is the same statement about an orbit, without the growth.
"""

import json

import numpy as np
import pytest

from helpers.by_hand.dense import carry, scales
from helpers.reference import CASES, traced

GROWTH = 1e3


def printed(numbers):
    """Round trip through text with twelve digits behind the first."""
    text = json.dumps([float(f"{number:.12e}") for number in np.ravel(numbers)])
    return np.array(json.loads(text)).reshape(np.shape(numbers))


def mismatch(values, nodes, multipliers, period):
    size = scales(values)
    nodes = printed(nodes)
    if np.abs(multipliers).max() < GROWTH:
        return np.abs((carry(nodes[0], values, 0, period) - nodes[0]) / size).max()
    edges = np.linspace(0, period, len(nodes) + 1)
    ends = [
        carry(node, values, start, end)
        for node, start, end in zip(nodes, edges[:-1], edges[1:], strict=True)
    ]
    return np.abs((ends - np.roll(nodes, -1, axis=0)) / size).max()


@pytest.mark.parametrize("case", CASES, ids=str)
def test_special_points_close(case):
    for branch in traced(case):
        for item in branch.special:
            error = mismatch(item.model.values, item.nodes, item.multipliers, item.period)
            assert error < 1e-8, (item.type, item.value)


@pytest.mark.parametrize("case", CASES, ids=str)
def test_points_of_branches_close(case):
    for branch in traced(case):
        for index in sorted({0, len(branch) // 3, 2 * len(branch) // 3, len(branch) - 1}):
            orbit = branch.orbit(index)
            error = mismatch(orbit.model.values, orbit.nodes, orbit.multipliers, orbit.period)
            assert error < 1e-8, (branch.id, branch.parameter[index])


@pytest.mark.long
@pytest.mark.parametrize("case", CASES, ids=str)
def test_every_point_of_every_branch_closes(case):
    for branch in traced(case):
        for index in range(len(branch)):
            orbit = branch.orbit(index)
            error = mismatch(orbit.model.values, orbit.nodes, orbit.multipliers, orbit.period)
            assert error < 1e-8, (branch.id, branch.parameter[index])
