"""A parameter that changes its direction along a curve has an extremum that was located."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.polynomial import Polynomial

from slipfold import Steps
from slipfold.continuation.curve import AlgebraicCurve
from slipfold.continuation.follow import follow, unexplained_reversal
from slipfold.continuation.search import Zeros
from slipfold.continuation.settings import Stepping
from slipfold.continuation.traced_curve import MonitorResult


class Polynomials(AlgebraicCurve):
    """p is a polynomial of x; `odd` names the direction of p."""

    odd = ("fold",)

    def __init__(self, coefficients):
        self.height = Polynomial(coefficients)
        self.slope = self.height.deriv()

    def defect(self, z):
        return np.array([z[1] - self.height(z[0])])

    def jacobian(self, z):
        return np.array([[-self.slope(z[0]), 1.0]])

    def tests(self, z, tangent):
        return {"fold": tangent[1]}


class Sees:
    """Watches, and finds nothing."""

    def watch(self, stretch):
        return MonitorResult()


def followed(curve, monitors, largest=1.0):
    start = curve.begin([-2.0, curve.height(-2.0)], row=[1, 0])
    stepping = Stepping(steps=Steps(largest=largest))
    return follow(curve, start, [(0, -2.0, 2.0)], monitors, settings=stepping)


def polynomial_with(places):
    """A polynomial whose derivative vanishes at some places; it is at most one on the curve."""
    found = Polynomial.fromroots(places).integ()
    return found.coef / np.abs(found(np.linspace(-2, 2, 33))).max()


places = st.lists(st.integers(-3, 3), min_size=2, max_size=4, unique=True)


@settings(max_examples=15, deadline=None, derandomize=True)
@given(places, st.sampled_from([0.1, 1.0]), st.sampled_from([0.5, 5.0]))
def test_cubics_and_quintics_have_all_their_folds(halves, largest, height):
    turns = sorted(half / 2 for half in halves)
    curve = Polynomials(height * polynomial_with(turns))
    trail = followed(curve, [Zeros(curve)], largest)
    assert [item.point.z[0] for item in trail.found] == pytest.approx(turns, abs=1e-7)
    assert trail.end.kind == "window"


@settings(max_examples=8, deadline=None, derandomize=True)
@given(places)
def test_a_fold_that_is_not_listed_is_a_contradiction(halves):
    turns = sorted(half / 2 for half in halves)
    curve = Polynomials(polynomial_with(turns))
    trail = followed(curve, [Sees()], 0.05)
    assert (trail.end.kind, trail.end.early) == ("contradiction", True)
    first = unexplained_reversal(trail)
    assert first.z[0] == pytest.approx(turns[0], abs=0.1)
    assert f"{first.z[-1]:.9g}" in trail.end.reason
    assert trail.end.reason.startswith("reached the end of the window; but at ")
    # One that was found elsewhere explains nothing.
    trail.found = followed(curve, [Zeros(curve)]).found[1:]
    assert unexplained_reversal(trail) is first


def test_what_only_rounding_changes_is_no_contradiction():
    curve = Polynomials([0.0])
    trail = followed(curve, [Sees()], 0.05)
    noise = np.random.default_rng(0).uniform(-4e-8, 4e-8, len(trail.points))
    for point, error in zip(trail.points, noise, strict=True):
        point.z[1] += error
    assert unexplained_reversal(trail) is None
