"""The engine on plane curves: what it finds, where it ends, and that it knows nothing of orbits."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.polynomial import Polynomial

from slipfold import End, Newton, Steps
from slipfold.continuation.curve import AlgebraicCurve
from slipfold.continuation.follow import follow, unexplained_reversal
from slipfold.continuation.locate import LostCurveError, locate
from slipfold.continuation.search import Zeros
from slipfold.continuation.settings import Stepping
from slipfold.continuation.traced_curve import MonitorResult, Stop
from slipfold.newton import zero_between


class Polynomials(AlgebraicCurve):
    """p is a polynomial of x."""

    def __init__(self, coefficients):
        self.height = Polynomial(coefficients)
        self.slope = self.height.deriv()

    def defect(self, z):
        return np.array([z[1] - self.height(z[0])])

    def jacobian(self, z):
        return np.array([[-self.slope(z[0]), 1.0]])

    def tests(self, z, tangent):
        return {"fold": tangent[1]}


class Directed(Polynomials):
    """The same; `odd` names the direction of p."""

    odd = ("fold",)


def cubic(height):
    """p = x^3 - h x: two folds, at x = -+sqrt(h / 3), as near to each other as one likes."""
    return Polynomials([0.0, -height, 0.0, 1.0])


class Dipping(Polynomials):
    """A line, along which a function dips below zero between two zeros that lie `apart` from c."""

    noise = 1e-15

    def __init__(self, c, apart):
        super().__init__([0.0, 0.3])
        self.c, self.apart = c, apart

    def tests(self, z, tangent):
        dip = 2 * np.sin((z[0] - self.c) / 2) ** 2 - 2 * np.sin(self.apart / 2) ** 2
        return {"dip": dip}


class Ending(AlgebraicCurve):
    """p = 3 x log(x), which has no points beyond x = 0."""

    beyond = 0

    def defect(self, z):
        self.beyond += z[0] < 0
        with np.errstate(invalid="ignore"):
            return np.array([z[1] - 3 * z[0] * np.log(z[0])])

    def jacobian(self, z):
        return np.array([[-3 - 3 * np.log(z[0]), 1.0]])


class EndInSight(Ending):
    def ahead(self, points):
        return points[-1].z[0] / -points[-1].tangent[0]


class Enlarged(Polynomials):
    """A curve that is described three times as large from behind its second fold."""

    def renewed(self, points):
        last = points[-1]
        if last.z[0] < 1 / np.sqrt(3):
            return None
        larger = [
            replace(item, z=3 * item.z, arclength=3 * item.arclength - 2 * last.arclength)
            for item in points[-3:]
        ]
        return Polynomials(3 * self.height.coef / 3 ** np.arange(4)), larger


class Undescribed(Polynomials):
    """A curve that cannot be described in another way where it ought to be."""

    def renewed(self, points):
        raise np.linalg.LinAlgError("SVD did not converge")


class Imprecise(Polynomials):
    """A curve whose residual no step makes smaller."""

    def residual(self, z, defect):
        return 1e-9


class Reaches:
    """Ends a curve where x has a value."""

    def __init__(self, curve, value):
        self.curve, self.value = curve, value

    def __call__(self, interval):
        def gap(point):
            return point.z[0] - self.value

        if gap(interval.before) * gap(interval.point) > 0:
            return MonitorResult()
        at = locate(self.curve, interval.history, interval.before, interval.point, gap)
        return MonitorResult(stop=Stop(at, End("reached", f"x is {self.value}", tuple(at.z))))


def followed(curve, monitors, **options):
    start = curve.begin([-1.5, curve.height(-1.5)], row=[1, 0])
    return follow(curve, start, [(1, -4.0, 4.0)], monitors, **options)


def test_points_have_a_residual_below_the_tolerance():
    curve, start = Imprecise([0.0, 0.0, 0.0, 1.0]), cubic(0.0).begin([-1.5, -3.375], row=[1, 0])
    loose = Stepping(newton=Newton(tolerance=1e-8))
    assert len(follow(curve, start, [(1, -4.0, 4.0)], settings=loose).points) > 5
    assert len(follow(curve, start, [(1, -4.0, 4.0)]).points) == 1


@pytest.mark.parametrize("height", [1.0, 1e-2, 1e-4])
def test_two_folds_within_a_step(height):
    curve = cubic(height)
    trail = followed(curve, [Zeros(curve)])
    fold = np.sqrt(height / 3)
    assert [item.type for item in trail.found] == ["fold", "fold"]
    # Beside each other the folds are known as well as their common slope, 6 x, allows.
    x = [item.point.z[0] for item in trail.found]
    assert x == pytest.approx([-fold, fold], abs=1e-11 / fold)
    assert trail.end.kind == "window"
    assert trail.end.value == 4.0


def test_a_curve_ends_where_another_description_of_it_breaks_down():
    trail = followed(Undescribed([0.0, -1.0, 0.0, 1.0]), [])
    assert trail.end.kind == "failed"
    assert "the computation broke down (SVD did not converge)" in trail.end.reason


def test_a_defect_of_the_program_ends_no_curve_in_silence():
    with pytest.raises(ValueError, match="empty"):
        followed(cubic(1.0), [lambda interval: min(())])


def test_a_zero_of_a_function_with_a_gap_breaks_down():
    with pytest.raises(ArithmeticError, match="is not known at"):
        zero_between(lambda x: x if abs(x) > 0.2 else np.nan, -1.0, 1.5, 1e-9)


@pytest.mark.parametrize("order", [1, -1])
def test_the_earliest_reason_ends_a_curve(order):
    curve = cubic(1.0)
    monitors = [Reaches(curve, 0.1), Zeros(curve), Reaches(curve, 0.0)][::order]
    trail = followed(curve, monitors)
    assert trail.end.reason == "x is 0.0"
    assert trail.points[-1].z[0] == pytest.approx(0, abs=1e-12)
    assert [item.point.z[0] < 0 for item in trail.found] == [True]


def test_both_directions_are_one_curve():
    curve = cubic(1.0)
    start = curve.begin([0.0, 0.0], row=[1, 0])
    bounds = [(1, -4.0, 4.0)]
    ends = [follow(curve, point, bounds) for point in (start, curve.turned(start))]
    first, last = sorted(trail.points[-1].z[0] for trail in ends)
    assert first == pytest.approx(-last, abs=1e-12)


def test_a_step_whose_inside_is_not_known_is_taken_again_shorter():
    curve, lost = cubic(1.0), []

    def loses(interval):
        length = interval.point.arclength - interval.before.arclength
        if length > 0.05:
            lost.append(length)
            raise LostCurveError("not found")
        return MonitorResult()

    trail = followed(curve, [loses])
    assert lost
    assert trail.end.kind == "window"
    assert np.diff([point.arclength for point in trail.points]).max() <= 0.05


def test_what_lies_farther_away_than_two_points_is_not_between_them():
    curve = Polynomials([0.0])
    curve.height = lambda x: 10 * np.exp(-((20 * x - 10) ** 2))
    curve.slope = lambda x: -40 * (20 * x - 10) * curve.height(x)
    a, b = (curve.begin([x, 0.0], row=[1, 0]) for x in (0.0, 1.0))
    b = replace(b, arclength=1.0)
    with pytest.raises(LostCurveError, match="too sharply"):
        locate(curve, [a, b], a, b, lambda point: point.z[0] - 0.5)


def test_points_stay_in_order_where_a_curve_is_described_in_another_way():
    curve = Enlarged(cubic(1.0).height.coef)
    trail = followed(curve, [Zeros(curve)])
    places = np.array([point.arclength for point in trail.points])
    assert (np.diff(places) > 0).all()
    assert [item.type for item in trail.found] == ["fold", "fold"]
    for item in trail.found:
        after = np.searchsorted(places, item.point.arclength)
        rises = [point.tangent[1] > 0 for point in trail.points[after - 1 : after + 1]]
        assert rises[0] != rises[1]


def test_a_curve_that_begins_on_a_bound_and_leaves_is_a_point_and_rounding_leaves_none():
    curve, bounds = cubic(1.0), [(1, -1.875, 4.0)]
    start = curve.begin([-1.5, -1.875], row=[1, 0])
    trail = follow(curve, curve.turned(start), bounds)
    assert (trail.end.kind, len(trail.points)) == ("window", 1)
    start.z[1] -= 1e-15  # as Newton's method may leave it, where a model may end
    assert follow(curve, start, bounds).points[0].z[1] == -1.875


def test_a_step_that_rounding_swallows_is_none():
    # So far along, a step of 1e-8 leads to the same arclength, and polynomials divided by zero.
    curve = cubic(1.0)
    start = replace(curve.begin([-1.5, -(1.5**3) + 1.5], row=[1, 0]), arclength=1e9)
    trail = follow(curve, start, [(1, -4.0, 4.0)], [Zeros(curve)], first_step=1e-8)
    assert trail.end.kind == "failed"
    assert len(trail.points) == 1


def test_a_step_goes_only_once_beyond_an_end_in_sight():
    blind, curve = Ending(), EndInSight()
    for each in (blind, curve):
        start = each.begin([1.0, 0.0], row=[-1, 0])
        trail = follow(each, start, [(1, -9.0, 9.0)], [Reaches(each, 1e-4)])
        assert trail.points[-1].z == pytest.approx([1e-4, 3e-4 * np.log(1e-4)])
    assert curve.beyond == 1 < blind.beyond


def sees(interval):
    """Watches, and finds nothing."""
    return MonitorResult()


def bounded(curve, monitors, largest=1.0):
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
    curve = Directed(height * polynomial_with(turns))
    trail = bounded(curve, [Zeros(curve)], largest)
    assert [item.point.z[0] for item in trail.found] == pytest.approx(turns, abs=1e-7)
    assert trail.end.kind == "window"


def test_a_point_before_a_turn_is_not_what_turns_there():
    curve = Directed([0.0, -1.0, 0.0, 1.0])
    trail = bounded(curve, [Zeros(curve)])
    first, *others = trail.found
    before = replace(first.point, z=first.point.z - np.array([0.0, 1.0]))
    assert unexplained_reversal(trail) is None
    assert unexplained_reversal(replace(trail, found=[replace(first, point=before), *others]))


@settings(max_examples=8, deadline=None, derandomize=True)
@given(places)
def test_a_fold_that_is_not_listed_is_a_contradiction(halves):
    turns = sorted(half / 2 for half in halves)
    curve = Directed(polynomial_with(turns))
    trail = bounded(curve, [sees], 0.05)
    assert (trail.end.kind, trail.end.early) == ("contradiction", True)
    first = unexplained_reversal(trail)
    assert first.z[0] == pytest.approx(turns[0], abs=0.1)
    assert f"{first.z[-1]:.9g}" in trail.end.reason
    assert trail.end.reason.startswith("reached the end of the window; but at ")
    # One that was found elsewhere explains nothing.
    trail.found = bounded(curve, [Zeros(curve)]).found[1:]
    assert unexplained_reversal(trail) is first


def test_what_only_rounding_changes_is_no_contradiction():
    curve = Directed([0.0])
    trail = bounded(curve, [sees], 0.05)
    noise = np.random.default_rng(0).uniform(-4e-8, 4e-8, len(trail.points))
    for point, error in zip(trail.points, noise, strict=True):
        point.z[1] += error
    assert unexplained_reversal(trail) is None


@pytest.mark.parametrize("apart", [1e-2, 1e-4, 1e-6])
def test_two_zeros_near_each_other_are_found_wherever_they_lie_in_a_step(apart):
    for c in np.linspace(0.4, 2.6, 12):
        line = Dipping(c, apart)
        found = follow(line, line.begin([0, 0], row=[1, 0]), [(0, 0, 3)], [Zeros(line)]).found
        places = [item.point.z[0] for item in found]
        # To 1e-12 of the search, and rounding of places.
        np.testing.assert_allclose(places, [c - apart, c + apart], rtol=0, atol=1e-11)
