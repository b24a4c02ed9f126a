"""Responses in one parameter at random places of a plane, held against the loci in two.

Every special point of a response lies on a locus; every crossing of a locus with the line of a
response is one of its special points, unless its orbit is connected with none that was followed.
"""

import dataclasses

import numpy as np
import pytest

from helpers.bifurcation_sets import PLANES, compare, compared_at, response, whole_set

SEED = 20260103
FORCE = ("f", "Nd")


def random_places(plane, count):
    rng = np.random.default_rng(SEED)
    return rng.uniform(*np.transpose(PLANES[plane]), size=(count, 2))


def compared(plane, count):
    """Comparisons on lines through random places, in turn along either parameter."""
    loci = whole_set(plane).loci
    places = enumerate(random_places(plane, count))
    return [compared_at(plane, loci, number % 2, place) for number, place in places]


def check(plane, count, points):
    results = compared(plane, count)
    assert None not in results  # there is a response on every line
    assert [item for result in results for item in result.off] == []
    assert [item for result in results for item in result.missing] == []
    assert sum(result.points for result in results) >= points


# The first of the three hundred places of the long tests.
def test_places_in_the_plane_of_frequency_and_force():
    check(FORCE, 3, points=6)


LARGE = {
    ("f", "Nd"): 600,
    ("Vd", "Nd"): 350,
    ("alpha", "Nd"): 300,
    ("mu", "Nd"): 320,
    ("Ns", "Nd"): 330,
}


@pytest.mark.long
@pytest.mark.parametrize("plane", LARGE, ids=",".join)
def test_three_hundred_places(plane):
    check(plane, 300, LARGE[plane])


# -- the check itself --------------------------------------------------------------------------


@pytest.fixture(scope="module")
def line():
    """A line in Nd with a PD and a fold of period 1 and a fold of period 2."""
    branches = response("Nd", PLANES[FORCE][1], (("f", 12.2),))
    assert sum(len(branch.special) for branch in branches) == 3
    return branches


def test_a_locus_that_is_not_in_the_set_is_noticed(line):
    loci = whole_set(FORCE).loci
    for locus in loci:
        rest = [item for item in loci if item is not locus]
        found = compare(FORCE, rest, 0, 12.2, line)
        expected = locus.type in ("PD", "LP")  # no torus on this line
        assert len(found.off) == expected
        assert found.missing == found.excused == ()


def test_a_special_point_that_was_missed_is_noticed(line):
    loci = whole_set(FORCE).loci
    for index, branch in enumerate(line):
        for point in branch.special:
            rest = tuple(item for item in branch.special if item is not point)
            changed = list(line)
            changed[index] = dataclasses.replace(branch, special=rest)
            found = compare(FORCE, loci, 0, 12.2, changed)
            assert found.off == found.excused == ()
            (name,) = found.missing
            assert name.startswith(f"{point.type} of period {point.period}")
