"""The same loci, special points and ends, whatever the step, the tolerance and the start."""

from functools import lru_cache

import numpy as np
import pytest

from helpers.bifurcation_sets import PLANES, bifurcations, response
from slipfold import Newton, Settings, Steps
from slipfold.bifurcations.loci.follow import follow_loci

PLANE = ("f", "Nd")
WINDOW = PLANES[PLANE]
SPAN = (0.0, 0.98)
LONG = pytest.mark.long

STARTS = {
    ("PD", 1): [12.2, 12.9],
    ("LP", 1): [12.2, 12.3],
    ("LP", 2): [12.0, 12.3],
    ("NS", 2): [12.5],
}
"""Values of f at which responses in Nd have special points that belong to one locus."""


def starting_points(kind, period):
    """Special points on one locus; at f = 12.5 both of a torus."""
    for f in STARTS[kind, period]:
        branches = response("Nd", SPAN, (("f", f),))
        yield from (p for p in bifurcations(branches, kind) if p.period == period)


@lru_cache
def expected(kind, period):
    """The locus from the first point alone, as it is followed usually."""
    point = next(starting_points(kind, period))
    (found,) = follow_loci([point], PLANE, WINDOW, switch=False)
    return found


def named(locus):
    # Rounded: mirror images share one value to the last digit or two.
    items = [(p.name, p.values) for p in locus.special]
    return sorted(items, key=lambda item: tuple(round(value, 6) for value in item[1]))


def check_same(found, other, close=1e-8):
    """Compare special points and ends, in either direction of travel."""
    assert [name for name, _ in named(found)] == [name for name, _ in named(other)]
    for (_, values), (_, others) in zip(named(found), named(other), strict=True):
        assert values == pytest.approx(others, abs=close)
    ends = sorted((e.values, e.kind) for e in (found.started, found.stopped))
    others = sorted((e.values, e.kind) for e in (other.started, other.stopped))
    assert [kind for _, kind in ends] == [kind for _, kind in others]
    for (values, kind), (known, _) in zip(ends, others, strict=True):
        # Next to orbits of half the period a locus ends a short step before.
        assert values == pytest.approx(known, abs=2e-4 if kind == "codimension-2" else close)


@pytest.mark.parametrize(
    ("kind", "period"), [pytest.param(*of, marks=LONG if of[0] == "LP" else ()) for of in STARTS]
)
def test_from_another_point_of_it(kind, period):
    points = list(starting_points(kind, period))
    assert len(points) > 1
    # All together they are one locus, not several; it begins at the first that is given.
    (found,) = follow_loci(points[::-1], PLANE, WINDOW, switch=False)
    check_same(found, expected(kind, period))


OFTEN = [(0.1, 1e-10), (0.5, 1e-6), (1.0, 1e-12)]


def steps_and_tolerances():
    """All for each locus; in every run one of PD and of NS, in turn."""
    for number, locus in enumerate(STARTS):
        for item in [*OFTEN, (0.02, 1e-10), (0.02, 1e-6), (0.1, 1e-6)]:
            often = item == OFTEN[number % 3] and locus[0] != "LP"
            yield pytest.param(*locus, *item, marks=() if often else LONG)


@pytest.mark.parametrize(("kind", "period", "largest", "tolerance"), list(steps_and_tolerances()))
def test_at_any_step_and_tolerance(kind, period, largest, tolerance):
    point = next(starting_points(kind, period))
    settings = Settings(newton=Newton(tolerance=tolerance), steps=Steps(largest=largest))
    (found,) = follow_loci([point], PLANE, WINDOW, settings=settings, switch=False)
    check_same(found, expected(kind, period))


def test_a_closed_locus_closes():
    # At Nd = 0.1 N the response doubles for directions across, near the internal resonance.
    plane, window = ("f", "alpha"), ((11.5, 13.5), (0.0, np.pi))
    branches = response("alpha", (0.0, np.pi), (("Nd", 0.1), ("f", 12.5)))
    point, *_ = bifurcations(branches, "PD")
    settings = Settings(steps=Steps(largest=0.5))
    (found,) = follow_loci([point], plane, window, switch=False, settings=settings)
    assert found.closed
    assert found.started.kind == found.stopped.kind == "closed"
    assert found.values[0] == pytest.approx(found.values[-1], abs=0.2)
    # It encloses the place where the threshold is least: one smallest and one largest of each.
    turns = sorted(p.name for p in found.special if p.type in ("MIN", "MAX"))
    assert {"smallest f", "largest f", "smallest alpha", "largest alpha"} <= set(turns)
    for name in ("f", "alpha"):
        some = [p.type for p in found.special if p.name.endswith(f" {name}")]
        assert some.count("MIN") == some.count("MAX")
    # Mirror images: every special point has its own.
    for point in found.special:
        f, alpha = point.values
        image = (f, np.pi - alpha)
        assert any(
            p.values == pytest.approx(image, abs=1e-7) for p in found.special
            if p.type == point.type or {p.type, point.type} == {"MIN", "MAX"}
        )  # fmt: skip
