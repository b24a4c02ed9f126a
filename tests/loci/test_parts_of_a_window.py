"""A part of a window holds what the whole has there, though its responses see less of the plane."""

import numpy as np
import pytest

from helpers.bifurcation_sets import crossings, whole_set
from slipfold.loci.bifurcation_set import find_bifurcation_set
from slipfold.models import SlidingOscillator

FORCE = ("f", "Nd")

PARTS = [
    # The doubling that leads to the orbits of this fold lies above it.
    ((11.7, 12.2), (0.05, 0.13)),
    ((12.0, 12.3), (0.05, 0.1)),
    pytest.param(((12.45, 12.55), (0.04, 0.2)), marks=pytest.mark.long),
    pytest.param(((13.0, 13.5), (0.4, 0.9)), marks=pytest.mark.long),
    pytest.param(((12.05, 12.35), (0.4, 0.9)), marks=pytest.mark.long),
]


def inside(values, window, margin=0.0):
    return all(
        low + margin * (high - low) <= value <= high - margin * (high - low)
        for value, (low, high) in zip(values, window, strict=True)
    )


@pytest.mark.parametrize("window", PARTS, ids=str)
def test_part_of_the_plane_of_frequency_and_force(window):
    whole = whole_set(FORCE)
    part = find_bifurcation_set(SlidingOscillator(), FORCE, window, regions=False)
    for f in np.linspace(*window[0], 5)[1:-1]:
        expected, found = (
            sorted(
                (item.locus.type, item.locus.period, item.values[1])
                for item in crossings(loci, 0, f)
                if inside(item.values, window)
            )
            for loci in (whole.loci, part.loci)
        )
        assert [item[:2] for item in found] == [item[:2] for item in expected]
        for item, other in zip(found, expected, strict=True):
            assert item[2] == pytest.approx(other[2], abs=1e-9)
    for point in (p for item in whole.loci for p in item.special):
        if inside(point.values, window, 0.01):
            others = [p for item in part.loci for p in item.special if p.name == point.name]
            assert any(p.values == pytest.approx(point.values, abs=1e-8) for p in others)
