"""The estimate of what a structure costs, against what it does cost."""

import numpy as np
import pytest

from slipfold import CubicSpring, HarmonicForce, ProportionalDamping, Structure
from slipfold.flow.flow import flow_of


def chain(size):
    k = 100.0 * (2 * np.eye(size) - np.eye(size, k=1) - np.eye(size, k=-1))
    return Structure(
        np.eye(size),
        ProportionalDamping(0.1, 0.001),
        k,
        elements=CubicSpring(f"q{size}", k3=10.0),
        forcing=HarmonicForce("q1", F=1.0),
    )


@pytest.mark.parametrize("size", [13, 30])
def test_large_structures_carry_a_few_derivatives_at_a_time(size):
    model = chain(size)
    cost = model.cost()
    parts = [flow_of(model)._code.variations(*counts) for counts in ((4, 0), (0, 1))]
    compiled = sum(len(part.decomposition) for part in parts)
    assert cost.equations == sum(len(part.state) for part in parts)
    assert cost.runs == -(-2 * size // 4)
    assert compiled / 1.6 < cost.products < 1.6 * compiled


def test_running_grows_with_the_square_of_the_size():
    small, large = (chain(size).cost() for size in (40, 80))
    assert 3.5 < large.period_seconds / small.period_seconds < 4.5
    assert "560 differential equations" in str(small)
