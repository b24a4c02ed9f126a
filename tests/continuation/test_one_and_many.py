"""The rules by which a curve is walked are the same for one curve and for many side by side."""

import numpy as np
import pytest

from slipfold.continuation.interpolation import (
    arc_between,
    arcs,
    hermite,
    hermite_each,
    polynomial_weights,
)
from slipfold.continuation.point import Point
from slipfold.continuation.step_length import (
    ERROR,
    LONGER,
    Measures,
    drift,
    lengthened,
    place_of_bound,
    shortened,
    shortened_where_lost,
)
from slipfold.continuation.unseen import Expected, expectation_weights, places_between

POWERS = 1e-13
"""Powers of arrays may differ from those of numbers in their last digits."""

EXTRAPOLATED = 1e-9
"""Weights of points up to ten times their spacing away are up to 1e5, and so is what they magnify
of rounding."""


def random(seed=0):
    return np.random.default_rng(seed)


def spread(random, count, least=1e-9, largest=1e3):
    return np.exp(random.uniform(np.log(least), np.log(largest), count))


def test_steps_are_as_long():
    numbers = random()
    distances, angles, drifts, steps = spread(numbers, (4, 200))
    growths = numbers.choice([0.8, LONGER], 200)
    together = Measures.of(distances, angles, drifts, 0.35)
    longer = lengthened(steps, together, growths, 1.0)
    shorter, lost = shortened(steps, together), shortened_where_lost(steps, distances)
    for i in range(200):
        alone = Measures.of(float(distances[i]), float(angles[i]), float(drifts[i]), 0.35)
        step = float(steps[i])
        assert alone.fits == together.fits[i]
        expected = lengthened(step, alone, float(growths[i]), 1.0)
        assert longer[i] == pytest.approx(expected, rel=POWERS)
        assert shorter[i] == pytest.approx(shortened(step, alone), rel=POWERS)
        expected = shortened_where_lost(step, float(distances[i]))
        assert lost[i] == pytest.approx(expected, rel=POWERS)


@pytest.mark.parametrize("moved", [0.0, ERROR, np.inf, np.nan])
def test_a_correction_that_tells_nothing_leaves_a_third_of_the_step(moved):
    assert shortened_where_lost(1.0, moved) == 0.35
    assert shortened_where_lost(np.ones(2), np.array([moved, moved])).tolist() == [0.35, 0.35]


def test_drifts_are_as_large():
    numbers = random()
    values, actual = numbers.normal(size=(20, 3, 5)), numbers.normal(size=(20, 5))
    actual[:5, 2] = np.nan  # a function that is not defined everywhere
    errors = np.abs(actual - values[:, -1])
    together = drift(errors, values, actual, 1e-9)
    alone = [drift(*item, 1e-9) for item in zip(errors, values, actual, strict=True)]
    assert together.tolist() == alone


def test_a_bound_is_reached_at_the_same_place():
    bounds = random().uniform(0.1, 0.9, 10)
    near, far = np.zeros(10), np.ones(10)
    rising = place_of_bound(lambda place: place**2, near, far, bounds, np.ones(10, bool))
    falling = place_of_bound(lambda place: -(place**2), near, far, -bounds, np.zeros(10, bool))
    alone = [place_of_bound(lambda place: place**2, 0.0, 1.0, float(b), True) for b in bounds]
    assert rising.tolist() == falling.tolist() == alone
    assert np.abs(np.sqrt(bounds) - rising).max() < 2**-11


def test_curves_are_interpolated_alike():
    numbers = random()
    where = np.cumsum(numbers.uniform(0.1, 1.0, (6, 3)), axis=1)
    target = where[:, -1] + numbers.uniform(0.1, 1.0, 6)
    values, slopes = numbers.normal(size=(2, 6, 3, 4))
    slopes /= np.linalg.norm(slopes, axis=2)[..., None]
    for count in (1, 2, 3):
        some = where[:, -count:], values[:, -count:], slopes[:, -count:]
        found, along = hermite_each(*some, target)
        for i in range(6):
            points = [
                Point(z, tangent, place, {}, 1, 0.0)
                for place, z, tangent in zip(*(item[i] for item in some), strict=True)
            ]
            expected = hermite(points, float(target[i]))
            np.testing.assert_allclose(found[i], expected[0], rtol=0, atol=EXTRAPOLATED)
            np.testing.assert_allclose(along[i], expected[1], rtol=0, atol=EXTRAPOLATED)
            if count == 2:
                length, _ = arcs(np.diff(values[:, 1:], axis=1)[:, 0], slopes[:, 1], slopes[:, 2])
                assert length[i] == pytest.approx(arc_between(*points), rel=1e-12)


def test_polynomials_of_many_curves_are_those_of_each():
    numbers = random()
    where, targets = (
        np.cumsum(numbers.uniform(0.5, 1, (5, 4)), axis=1),
        numbers.uniform(0, 4, (5, 3)),
    )
    together = polynomial_weights(where, targets)
    assert np.array_equal(
        together, [polynomial_weights(*each) for each in zip(where, targets, strict=True)]
    )
    cubics = (together @ (where**3 - where)[..., None])[..., 0]
    np.testing.assert_allclose(cubics, targets**3 - targets, rtol=0, atol=1e-10)


def test_what_may_vanish_unseen_is_the_same():
    numbers = random(1)
    ends = np.sort(numbers.uniform(0, 1, (300, 2)), axis=1)
    where = np.column_stack([ends[:, 1], ends[:, 0], ends[:, 0] - numbers.uniform(0.1, 1, 300)])
    values = 0.1 * numbers.normal(size=(300, 3, 4)) + numbers.normal(size=(300, 1, 4))
    values[::7, :, 0] = 0.0  # zero everywhere
    values[::5, 1, 1] = np.nan  # not defined everywhere
    grid = places_between(ends[:, 0], ends[:, 1])
    weights = expectation_weights(where, grid, (ends[:, 0], ends[:, 1]), (1, 0))
    together = Expected.of(weights @ values, values[:, 1::-1]).doubtful
    for i in range(300):
        low, high = ends[i].tolist()
        own = places_between(low, high)
        each = expectation_weights(where[i], own, (low, high), (1, 0))
        alone = Expected.of(each @ values[i], values[i, 1::-1])
        assert alone.doubtful.tolist() == together[i].tolist()
        place = alone.doubtful_place(own)
        assert (place is not None) == together[i].any()
        assert place is None or low < place < high
    assert 30 < together.any(axis=1).sum() < 270
