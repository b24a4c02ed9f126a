"""Loci of branch points: of equilibria, forced orbits and cycles, and where there is none."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from slipfold import Settings, System, locus, response
from slipfold.bifurcations.branches.stops import stop_standing
from slipfold.bifurcations.loci.locus_equations import LocusEquations
from slipfold.bifurcations.loci.special_points import SpecialPoints
from slipfold.continuation.newton import correct
from slipfold.continuation.traced_curve import StepInterval, TracedCurve
from slipfold.orbits.eigenvalues import Cayley
from slipfold.orbits.kinds import Equilibria

WINDOW = ((-1.0, 1.0), (-1.0, 1.0))


def line(rate, mu=-0.5, b=0.0):
    """An autonomous model of one state."""
    return System(name="line", parameters={"mu": mu, "b": b}, states={"x": rate})


def branch_point(model, vary="mu", span=(-0.6, 0.6), kind="BP"):
    diagram = response(model, vary=vary, span=span)
    return next(item.point for item in diagram.special if item.point.type == kind)


def types(curve):
    return [point.type for point in curve.special if point.type not in ("MIN", "MAX")]


def test_a_pitchfork_of_equilibria_turns_hard_where_its_cubic_vanishes():
    point = branch_point(line("mu*x + b*x^3 - x^5", b=-0.5))
    found = locus(point, ("mu", "b"), WINDOW)
    crossing, folds = found.loci
    assert (crossing.type, crossing.kind, types(crossing)) == ("BP", "equilibrium", ["DP"])
    assert np.abs(crossing.values[:, 0]).max() < 1e-12
    assert np.ptp(crossing.values[:, 1]) == 2.0
    (turn,) = (item for item in crossing.special if item.type == "DP")
    assert turn.values == pytest.approx((0, 0), abs=1e-9)
    (same,) = folds.special  # they begin there, and are drawn once
    assert (same.type, folds.started.kind, folds.stopped.kind) == ("DP", "codimension-2", "window")
    assert (np.diff(folds.values[:, 1]) > 0).all()
    assert max(*turn.uncertainty, *same.uncertainty) < 1e-9
    assert crossing.coefficient == pytest.approx(crossing.values[:, 1], abs=1e-9)
    assert (crossing.supercritical == (crossing.values[:, 1] < 0)).all()


def test_the_folds_of_a_hard_pitchfork_end_where_it_turns_soft():
    fold = branch_point(line("mu*x + b*x^3 - x^5", b=0.8), kind="LP")
    found = locus(fold, ("mu", "b"), WINDOW)
    folds, crossing = found.loci
    assert (folds.type, crossing.type, types(folds)) == ("LP", "BP", ["DP"])
    mu, b = folds.values.T
    assert mu == pytest.approx(-(b**2) / 4, abs=1e-9)
    # The equations of folds hold on along the branch points: those know where it is.
    for curve in (crossing, folds):
        (turn,) = (item for item in curve.special if item.type == "DP")
        assert turn.values == pytest.approx((0, 0), abs=1e-9)
        assert max(turn.uncertainty) < 1e-9
    assert folds.started.values == tuple(folds.values[0]) == turn.values
    assert np.abs(crossing.values[:, 0]).max() < 1e-12
    assert found.checked.disagreeing == ()


def test_folds_end_at_a_degenerate_pitchfork_wherever_rounding_leads_beside_it():
    orbits = Equilibria(line("mu*x + b*x^3 - x^5"), {"mu": 1.0, "b": 1.0}, Cayley())
    folds, at = LocusEquations(orbits, "LP"), orbits.join(np.array([[0.03]]), (-(0.03**4), 0.0018))
    before = folds.point(correct(folds, at, np.array([-1.0, 0, 0])), 0.0)
    # The equations are met to all digits from there to all branch points next to it.
    lost = replace(before, z=orbits.join(np.array([[4e-5]]), (0.0, -4e-9)), arclength=0.03)
    result = SpecialPoints(folds)(StepInterval(TracedCurve(folds, [before]), lost, 4))
    assert [item.type for item in result.found] == ["DP"]
    assert np.abs(result.stop.end.values).max() < 1e-9


def test_a_transcritical_point_has_a_locus_and_no_criticality():
    point = branch_point(line("(mu - b^2)*x - x^2"))
    (crossing,) = locus(point, ("mu", "b"), WINDOW).loci
    mu, b = crossing.values.T
    assert mu == pytest.approx(b**2, abs=1e-12)
    assert np.isnan(crossing.coefficient).all()
    assert {item.type for item in crossing.special} == {"MIN"}


def test_a_locus_that_stands_still_ends_by_name():
    # Every x rests at mu = b = 0, all of them folds.
    (folds,) = locus(branch_point(line("b + mu*x")), ("mu", "b"), WINDOW).loci
    assert np.abs(folds.values).max() < 1e-12
    for end in (folds.started, folds.stopped):
        assert end.kind == "family"
        assert end.reason.startswith("the locus stands still at mu = 0, b = 0: ")


@pytest.mark.parametrize(
    ("along", "growth", "kind", "words"),
    [
        (0.0, 0.0, "family", "are all critical there"),
        (0.0, 0.1, "duration", "cycles take ever longer there, 1 to 1.9 s"),
        (0.5, 0.0, None, ""),
    ],
)
def test_a_locus_stands_still_for_one_of_two_reasons(along, growth, kind, words):
    orbits = SimpleNamespace(
        kind="periodic",
        free_phase=True,
        varied=("a", "b"),
        durations=lambda points: np.array([point.z[0] for point in points]),
    )
    points = [
        SimpleNamespace(z=np.array([1 + growth * i, 0.2, 0.3]), tangent=np.array([1, along, 0]))
        for i in range(10)
    ]
    curve = SimpleNamespace(orbits=orbits, place=lambda z: tuple(z[-2:]))
    traced = SimpleNamespace(curve=curve, points=points[:-1])
    stop = stop_standing(SimpleNamespace(traced=traced, point=points[-1])).stop
    assert (stop and stop.end.kind) == kind
    assert words in (stop.end.reason if stop else "")


def test_what_an_imperfection_parts_has_no_locus():
    point = branch_point(line("mu*x - x^2 + b"))
    found = locus(point, ("mu", "b"), WINDOW)
    (folds,) = found.loci
    mu, b = folds.values.T
    assert folds.type == "LP"
    assert b == pytest.approx(-(mu**2) / 4, abs=1e-12)
    assert "isolated in the plane" in found.missing[0]
    assert "isolated in the plane" in found.summary()
    assert np.abs(folds.values).max(axis=1).min() < 1e-9
    assert found.checked.disagreeing == ()


def test_cycles_that_leave_a_plane():
    circle = "(1 - x^2 - y^2)"
    model = System(
        name="circle",
        parameters={"mu": -0.5, "b": 0.3},
        states={"x": f"{circle}*x - y", "y": f"{circle}*y + x", "z": "(mu - b^2)*z - z^3"},
    )
    diagram = response(model, vary="mu", span=(-0.6, 0.6), start={"x": 1, "y": 0.1})
    point = next(item.point for item in diagram.special if item.point.type == "BP")
    (crossing,) = locus(point, ("mu", "b"), WINDOW).loci
    mu, b = crossing.values.T
    assert (crossing.type, crossing.kind) == ("BP", "periodic")
    assert mu == pytest.approx(b**2, abs=1e-10)
    assert crossing.supercritical.all()


def test_symmetric_orbits_lose_their_symmetry_where_half_a_period_says():
    model = System(
        name="hardening",
        parameters={"F": 1.0, "c": 0.2},
        states={"q": "v", "v": "F*cos(t) - c*v - q - q^3"},
        forcing={"period": "2*pi"},
    )
    settings = Settings(largest_period=1)
    diagram = response(model, vary="F", span=(0, 6), settings=settings)
    point = next(item.point for item in diagram.special if item.point.type == "BP")
    crossing = locus(point, ("F", "c"), ((0, 6), (0.1, 0.4)), switch=False).loci[0]
    assert crossing.type == "BP"
    assert len(crossing) > 5
    for i in range(0, len(crossing), 5):
        end, multipliers = half_a_period(*crossing.values[i], crossing.states[i])
        assert end == pytest.approx(crossing.states[i], abs=1e-9)
        assert np.abs(multipliers + 1).min() < 1e-8


def half_a_period(force, damping, state):
    """The map over half a period with x -> -x taken along, and its multipliers."""

    def rates(t, y):
        x, v, dx, dv = y[0], y[1], y[2:4], y[4:6]
        pull = force * np.cos(t) - damping * v - x - x**3
        return np.concatenate([[v, pull], dv, -damping * dv - (1 + 3 * x * x) * dx])

    start = np.concatenate([state, [1, 0], [0, 1]])
    end = solve_ivp(rates, (0, np.pi), start, method="DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
    return -end[:2], np.linalg.eigvals(-end[2:].reshape(2, 2))


def test_doublings_that_cross_branch_points_are_named_for_them():
    """Two systems side by side: a pitchfork at mu = 0, and Mathieu's equation with its doubling."""
    model = System(
        name="beside",
        parameters={"mu": -0.5, "b": 0.8},
        states={"x": "mu*x - x^3", "y": "v", "v": "-0.04*v - (b - 0.4*cos(2*t))*y - y^3"},
        forcing={"period": "pi"},
    )
    settings = Settings(largest_period=1)
    diagram = response(model, vary="b", span=(0.5, 1.0), settings=settings)
    doubling = next(item.point for item in diagram.special if item.point.type == "PD")
    found = locus(doubling, ("mu", "b"), ((-1.0, 1.0), (0.5, 1.0)), settings=settings)
    doublings, crossing, *more = found.loci
    assert (doublings.type, crossing.type, more) == ("PD", "BP", [])
    assert types(doublings) == types(crossing) == ["BPPD"]
    (corner,) = (item for item in doublings.special if item.type == "BPPD")
    assert corner.values == pytest.approx((0, doubling.value), abs=1e-9)


def test_extrema_of_a_circle_of_branch_points_are_its_own():
    states = {"x": "x*(1 - p^2 - q^2 + q*x^2 - x^4)"}
    point = branch_point(System(parameters={"p": -2.0, "q": 0.1}, states=states), "p", (-2, 0))
    (curve,) = locus(point, ("p", "q"), ((-2, 2), (-1.5, 1.5)), switch=False).loci
    extrema = [item for item in curve.special if item.type in ("MIN", "MAX")]
    places = np.array([item.values for item in extrema])
    assert sorted(np.abs(np.round(places)).tolist()) == [[0, 1], [0, 1], [1, 0], [1, 0]]
    bounds = 3 * np.array([item.uncertainty for item in extrema])
    assert (np.abs(places - np.round(places)) < bounds).all()
