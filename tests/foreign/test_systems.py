"""Systems of other fields, in both discretizations, against points that SciPy found.

`systems/` has the equations, each with its source; `points.json` is written by `write_points.py`,
which shares no code with what is tested. A system that shows a defect is added here.
"""

import json
from collections import Counter

import numpy as np
import pytest

from helpers.foreign_systems import POINTS, cases
from helpers.points_by_scipy import points_near

KNOWN = json.loads(POINTS.read_text())

QUICK = {
    *("brusselator-1", "galloping-0", "langford-0", "parametric_resonator-0", "measles-0"),
    *("harvester-0", "turning_pendulum-0", "shimmy-0"),
}
"""Those that every run of the tests includes; the others take longer, or are like them."""

RUNS = [
    pytest.param(
        case,
        by,
        id=f"{case}-{by}",
        marks=[] if str(case) in QUICK and by == case.methods[0] else pytest.mark.long,
    )
    for case in cases()
    for by in case.methods
]


@pytest.mark.parametrize(("case", "by"), RUNS)
def test_what_there_is_is_found_and_nothing_else(case, by):
    diagram, known = case.response(by), KNOWN[str(case)]
    width = abs(diagram.span[1] - diagram.span[0])
    found = sorted(
        (branch.period, item.type, item.value, item.uncertainty)
        for branch in diagram.branches
        for item in branch.special
    )
    points = sorted((period, kind, *rest) for kind, period, *rest in known["points"])
    assert [item[:2] for item in found] == [item[:2] for item in points]
    for (_, kind, value, uncertainty), (*_, expected, spread) in zip(found, points, strict=True):
        allowed = 3 * (uncertainty + spread) + 1e-10 * width
        assert value == pytest.approx(expected, rel=0, abs=allowed), kind
    assert Counter(branch.stopped.kind for branch in diagram.branches) == Counter(known["ends"])
    for check in diagram.checked.checks:
        assert check.agrees, check
    for branch in diagram.branches:
        assert min(diagram.span) - 1e-9 * width <= branch.parameter.min()
        assert branch.parameter.max() <= max(diagram.span) + 1e-9 * width
        assert np.isfinite(branch.multipliers).all()


@pytest.mark.long
@pytest.mark.parametrize("case", [item for item in cases() if KNOWN[str(item)]["points"]], ids=str)
def test_the_points_are_those_that_scipy_finds(case):
    found = points_near(case, case.response(case.methods[0]))
    for ours, written in zip(found, KNOWN[str(case)]["points"], strict=True):
        assert ours[:2] == written[:2]
        assert ours[2] == pytest.approx(written[2], rel=1e-12, abs=10 * written[3])


@pytest.mark.long
@pytest.mark.parametrize("largest", [0.03, 0.3])
@pytest.mark.parametrize("case", [item for item in cases() if str(item) in QUICK], ids=str)
def test_the_step_decides_on_nothing(case, largest):
    from slipfold import Steps

    diagram = case.response(case.methods[0], steps=Steps(largest=largest))
    found = Counter((item.type, own.period) for own in diagram.branches for item in own.special)
    assert found == Counter((kind, period) for kind, period, *_ in KNOWN[str(case)]["points"])
