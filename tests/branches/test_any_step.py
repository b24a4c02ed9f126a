"""Nothing missed and nothing invented, whatever the step, the tolerance and the direction."""

from itertools import product

import pytest

from helpers.reference import CASES, specials, traced

ALL = list(product((0.005, 0.02, 0.1, 1.0), (1e-10, 1e-6), (False, True)))
PAIRS = [
    *((0.02, 1e-10, False), (0.02, 1e-6, True)),
    *((0.1, 1e-10, True), (0.1, 1e-6, False)),
    *((1.0, 1e-10, False), (1.0, 1e-6, True)),
]
"""Any two of step, tolerance and direction meet in every way; the shortest steps take long."""


def combinations():
    """All of each case; in every run one of the pairs, in turn."""
    for number, case in enumerate(CASES):
        for item in ALL:
            # The last two are the only ones over the frequency.
            often = item == PAIRS[number % 6] and number in (1, 4, 8)
            yield pytest.param(*item, case, marks=[] if often else pytest.mark.long)


def last_response(case):
    """A value of Nd a little before the branch of period 1 ends; a descent can start there."""
    main = traced(case)[0]
    return 0.97 * (main.stopped.value if main.stopped.kind == "limit" else case.span[1])


def way(case, backward):
    if not backward:
        return case.span
    # From 0.98 N a span is followed from its other end where no response exists, which would
    # be the same run again: descend from where there is one.
    return case.reverse if case.vary == "f" else (last_response(case), 0.0)


@pytest.mark.parametrize(
    ("largest", "tolerance", "backward", "case"), list(combinations()), ids=str
)
def test_same_special_points(largest, tolerance, backward, case):
    span = way(case, backward)
    low, high = sorted(span)
    found = [
        item for item in specials(traced.__wrapped__(case, span, largest, tolerance))
        if low <= item[1] <= high
    ]  # fmt: skip
    expected = [item for item in specials(traced(case)) if low <= item[1] <= high]
    assert [item[::2] for item in found] == [item[::2] for item in expected]
    for item, other in zip(found, expected, strict=True):
        assert item[1] == pytest.approx(other[1], abs=1e-8)


def test_a_span_without_response_at_its_start_is_followed_from_its_end():
    case = CASES[0]
    branches = traced(case, case.reverse)
    assert "from its other end" in branches[0].started.reason
    assert specials(branches) == specials(traced(case))
