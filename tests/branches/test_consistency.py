"""Every change in the number of unstable multipliers is explained by a special point."""

import numpy as np
import pytest
from hypothesis import given, reject, settings
from hypothesis import strategies as st

from helpers.reference import CASES, traced
from slipfold import InputError, SlidingOscillator
from slipfold.bifurcations.branches.response import trace_response

SPANS = {
    "Nd": (0.0, 0.95),
    "f": (9.0, 14.5),
    "Vd": (1.2, 0.2),
    "mu": (0.0, 0.9),
    "alpha": (0.0, np.pi),
}


def unexplained(branch):
    """Intervals of a branch whose special points do not account for the multipliers."""
    where, unstable = branch.arclength, branch.unstable
    for index in range(len(branch) - 1):
        born = branch.started.kind == "bifurcation" and index == 0
        closing = branch.stopped.kind == "closed" and index == len(branch) - 2
        if born or closing:  # the doubled orbit itself has a multiplier at one
            continue
        between = [
            item for item in branch.special
            if item.type != "EVENT" and where[index] < item.arclength <= where[index + 1]
        ]  # fmt: skip
        pairs = sum(item.type == "NS" for item in between)
        single = len(between) - pairs
        change = abs(int(unstable[index + 1]) - int(unstable[index]))
        if change > single + 2 * pairs or (change - single) % 2:
            yield float(branch.parameter[index]), [item.type for item in between]


def check(branches):
    for branch in branches:
        assert list(unexplained(branch)) == []
        assert np.all(np.diff(branch.arclength) > 0)
        assert np.all(branch.residual <= 1e-10)
        assert np.all(np.diff([item.arclength for item in branch.special]) >= 0)
        for item in branch.special:
            critical = item.critical_multiplier
            size = max(1.0, np.abs(item.multipliers).max())
            assert abs(abs(critical) - 1) < 1e-6 * size
            assert item.residual <= 1e-10


@pytest.mark.parametrize("case", CASES, ids=str)
def test_reference_cases(case):
    check(traced(case))


any_parameters = given(
    vary=st.sampled_from(sorted(SPANS)),
    reverse=st.booleans(),
    f=st.floats(7, 15),
    share=st.floats(0.02, 0.9),
    mu=st.floats(0.1, 0.8),
    alpha=st.floats(0, np.pi),
    Vd=st.floats(0.3, 1.2),
)


@settings(max_examples=6)
@any_parameters
def test_any_parameters(vary, reverse, f, share, mu, alpha, Vd):
    check_response(vary, reverse, f, share, mu, alpha, Vd)


@pytest.mark.long
@settings(max_examples=200)
@any_parameters
def test_many_more_parameters(vary, reverse, f, share, mu, alpha, Vd):
    check_response(vary, reverse, f, share, mu, alpha, Vd)


def check_response(vary, reverse, f, share, mu, alpha, Vd):
    model = SlidingOscillator(f=f, Nd=share, mu=mu, alpha=alpha, Vd=Vd)
    span = SPANS[vary][::-1] if reverse else SPANS[vary]
    try:
        branches = trace_response(model, vary, span)
    except InputError:  # neither end of the span has a response: nothing to check
        reject()
    check(branches)
    assert all(branch.stopped.reason for branch in branches)
