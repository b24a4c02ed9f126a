"""Loci of equilibria against closed forms: Routh-Hurwitz, Bogdanov-Takens and Bautin."""

import math
import re

import numpy as np
import pytest
import scipy.linalg

import slipfold as sf
from slipfold.bifurcations.loci import bifurcation_set, fan, follow
from slipfold.models.registry import model_named

BOGDANOV_TAKENS = sf.System(
    name="bogdanov-takens",
    parameters={"b1": -0.02, "b2": -1.5},
    states={"x": "y", "y": "b1 + b2*x + x^2 - x*y"},
)
BAUTIN = sf.System(
    name="bautin",
    parameters={"b1": -0.5, "b2": 1.0},
    states={
        "x": "b1*x - y + (b2*(x^2 + y^2) - (x^2 + y^2)^2)*x",
        "y": "x + b1*y + (b2*(x^2 + y^2) - (x^2 + y^2)^2)*y",
    },
)
CUSP = sf.System(
    name="cusp", parameters={"a": -1.0, "b": 1.0}, states={"x": "a + b*x - x^3", "y": "-y"}
)
QUIET = sf.Settings(largest_period=0)


def point_of(model, vary, span, kind, **parameters):
    diagram = sf.response(model, vary=vary, span=span, settings=QUIET, **parameters)
    return next(item.point for item in diagram.special if item.point.type == kind)


def specials(locus, kind):
    return [point for point in locus.special if point.type == kind]


def check_by_scipy(locus, jacobian, kind):
    """The critical eigenvalue from a Jacobian written by hand, beside its own size."""
    for values, state in zip(locus.values, locus.states, strict=True):
        matrix = jacobian(dict(zip(locus.vary, values, strict=True)), state)
        found = scipy.linalg.eigvals(matrix)
        if np.abs(found).max() < 1e-6:  # a double zero parts as the square root of rounding
            continue
        critical = found[np.abs(found.real).argmin()] if kind == "HB" else min(found, key=abs)
        assert abs(critical.real) < 1e-10 * np.linalg.norm(matrix)
        assert (abs(critical.imag) > 0) == (kind == "HB")


def test_lure_hopf_locus_is_a_hyperbola():
    # s^3 + a s^2 + b s + 1: Routh and Hurwitz say a b = 1, with frequency sqrt(b).
    hopf = point_of(model_named("lure"), "a", (1.2, 0.9), "HB")
    found = sf.locus(hopf, ("a", "b"), ((0.3, 3), (0.2, 3)))
    (locus,) = found.loci
    assert (locus.type, locus.kind, locus.special) == ("HB", "equilibrium", ())
    assert {locus.started.kind, locus.stopped.kind} == {"window"}
    assert locus.values.prod(axis=1) == pytest.approx(1, abs=1e-12)
    assert np.abs(locus.eigenvalues.imag).max(axis=1) == pytest.approx(np.sqrt(locus.values[:, 1]))
    assert locus.supercritical.all()
    check_by_scipy(
        locus, lambda p, q: [[0, 1, 0], [0, 0, 1], [-1 + 2 * q[0], -p["b"], -p["a"]]], "HB"
    )


def test_lyapunov_coefficient_along_the_locus_is_that_of_the_branch():
    # The branch takes it from the flow over a time, the locus from the vector field.
    point = point_of(model_named("lure"), "a", (1.2, 0.9), "HB")
    (locus,) = sf.locus(point, ("a", "b"), ((0.5, 1.7), (0.2, 3))).loci
    for row, end in ((0, locus.started), (-1, locus.stopped)):
        a = locus.values[row, 0]
        assert end.values == pytest.approx([a, 1 / a], abs=1e-12)
        there = point_of(model_named("lure"), "a", (a + 0.2, a - 0.1), "HB", b=1 / a)
        assert there.value == pytest.approx(a, abs=1e-10)
        assert locus.coefficient[row] == pytest.approx(there.coefficient, rel=1e-7)


def test_hopf_locus_ends_at_bogdanov_takens():
    # LP: 4 b1 = b2^2; HB: b1 = 0 for b2 < 0, neutral saddles for b2 > 0; a = 1, b = -1.
    point = point_of(BOGDANOV_TAKENS, "b1", (-0.02, 1), "HB")
    hopf, folds = sf.locus(point, ("b1", "b2"), ((-1, 1), (-3, 1))).loci
    assert (hopf.type, folds.type, hopf.period) == ("HB", "LP", 1)
    assert hopf.values[:, 0] == pytest.approx(0, abs=1e-13)
    assert hopf.values[:, 1].max() == pytest.approx(0, abs=1e-12)
    assert hopf.values[:, 1].min() == -3
    assert {hopf.started.kind, hopf.stopped.kind} == {"window", "codimension-2"}
    end = hopf.stopped if hopf.stopped.kind == "codimension-2" else hopf.started
    assert "BT" in end.reason
    assert "neutral saddle" in end.reason
    assert folds.values[:, 0] == pytest.approx(folds.values[:, 1] ** 2 / 4, abs=1e-13)
    for locus in (hopf, folds):
        (double,) = specials(locus, "BT")
        assert double.values == pytest.approx([0, 0], abs=1e-12)
        # The eigenvector (1, 0) has unit length.
        assert double.coefficients == pytest.approx({"a": 1, "b": -1}, abs=1e-7)
        # A double eigenvalue parts as the square root of what is left over.
        assert np.abs(double.eigenvalues).max() < 1e-6
    assert folds.special[0].leads_to == (hopf.id,)
    check_by_scipy(hopf, lambda p, q: [[0, 1], [p["b2"] + 2 * q[0] - q[1], -q[0]]], "HB")
    check_by_scipy(folds, lambda p, q: [[0, 1], [p["b2"] + 2 * q[0] - q[1], -q[0]]], "LP")


def test_bautin_point_and_the_folds_of_cycles_born_there():
    # l1 = b2 but for a positive factor; cycles fold at b1 = -b2^2/4, b2 > 0.
    point = point_of(BAUTIN, "b1", (-0.5, 0.5), "HB")
    hopf, folds = sf.locus(point, ("b1", "b2"), ((-0.5, 1), (-2, 2))).loci
    assert (hopf.kind, folds.type, folds.kind) == ("equilibrium", "LP", "periodic")
    assert hopf.values[:, 0] == pytest.approx(0, abs=1e-14)
    # The eigenvector of unit length is half as long in |z|^2 as the coordinate.
    assert hopf.coefficient == pytest.approx(2 * hopf.values[:, 1], abs=1e-12)
    (general,) = specials(hopf, "GH")
    assert general.values == pytest.approx([0, 0], abs=1e-12)
    assert all(value < 1e-9 for value in general.uncertainty)
    assert general.leads_to == (folds.id,)
    assert general.coefficients == pytest.approx({"l2": -4}, rel=1e-12)
    assert general.duration == pytest.approx(2 * math.pi)
    b1, b2 = folds.values.T
    assert b1 == pytest.approx(-(b2**2) / 4, abs=1e-12)
    assert b2.min() > -1e-12
    assert b2.max() == pytest.approx(math.sqrt(2), abs=1e-12)
    assert np.hypot(*folds.states.T) == pytest.approx(np.sqrt(np.abs(b2) / 2), abs=1e-6)
    assert folds.durations == pytest.approx(2 * math.pi)


def test_second_lyapunov_coefficient_in_bent_coordinates():
    # z' = (b1 + 2i) z + (b2 + 0.7i) z |z|^2 + 0.5 z |z|^4, with u + iv = z; |z|^2 is twice as much
    # for a vector of unit length.
    model = sf.System({
        "name": "bent",
        "parameters": {"b1": -0.5, "b2": 1},
        "formulas": {
            "v": "y - 0.4*x^2 + 0.3*s*x",
            "u": "x + 0.5*v^2",
            "r": "u^2 + v^2",
            "du": "(b1 + b2*r + 0.5*r^2)*u - (2 + 0.7*r)*v",
            "dv": "(b1 + b2*r + 0.5*r^2)*v + (2 + 0.7*r)*u",
            "dx": "du - v*dv",
            "ds": "-s",
        },
        "states": {"x": "dx", "y": "dv + 0.8*x*dx - 0.3*(ds*x + s*dx)", "s": "ds"},
    })  # fmt: skip
    point = point_of(model, "b1", (-0.5, 0.5), "HB")
    (hopf, *_) = sf.locus(point, ("b1", "b2"), ((-0.5, 1), (-2, 2)), switch=False).loci
    (general,) = specials(hopf, "GH")
    assert general.values == pytest.approx([0, 0], abs=1e-10)
    assert general.coefficients == pytest.approx({"l2": 0.5 * 4 / 2}, rel=1e-9)


def test_cusp():
    # Folds of a + b x - x^3: 27 a^2 = 4 b^3, with c = -1 at the cusp.
    point = point_of(CUSP, "a", (-1, 1), "LP")
    (locus,) = sf.locus(point, ("a", "b"), ((-1, 1), (-1, 1.5))).loci
    a, b = locus.values.T
    assert 27 * a**2 == pytest.approx(4 * b**3, abs=1e-12)
    (cusp,) = locus.special
    assert (cusp.type, cusp.name) == ("CP", "cusp")
    assert cusp.values == pytest.approx([0, 0], abs=1e-10)
    assert cusp.coefficients == pytest.approx({"c": -1}, abs=1e-9)


@pytest.mark.parametrize("scale", [1e-3, 1e3])
def test_units_of_time_and_state_do_not_matter(scale):
    # The Lur'e system in another unit of time, its states in another unit each.
    model = sf.System(
        name="lure-scaled",
        parameters={"a": 1.2, "b": 1.0, "w": scale},
        states={
            "x": {"rate": "w*y/10", "scale": 1},
            "y": {"rate": "w*z/10", "scale": 10},
            "z": {"rate": "w*(-a*z - 10*b*y - 100*x + 100*x^2)", "scale": 100},
        },
    )
    point = point_of(model, "a", (1.2, 0.9), "HB")
    (locus,) = sf.locus(point, ("a", "b"), ((0.3, 3), (0.2, 3))).loci
    assert locus.values.prod(axis=1) == pytest.approx(1, abs=1e-12)
    frequency = np.abs(locus.eigenvalues.imag).max(axis=1) / scale
    assert frequency == pytest.approx(np.sqrt(locus.values[:, 1]))


@pytest.mark.long
def test_an_equilibrium_that_branched_off_outside_the_window_is_looked_for():
    # The pitchfork of the Lorenz system is at rho = 1, its Hopf point at
    # s (s + b + 3) / (s - b - 1) with b = 8/3 (Sparrow, The Lorenz Equations, 1982).
    plane, window = ("rho", "sigma"), ((20, 28), (8, 12))
    (locus,) = sf.bifurcation_set(model_named("lorenz"), plane, window, regions=False).loci
    assert locus.type == "HB"
    rho, s = locus.values.T
    np.testing.assert_allclose(rho, s * (s + 8 / 3 + 3) / (s - 8 / 3 - 1), rtol=1e-10)


STEERED = sf.System(
    name="steered",
    parameters={"a": 0.0, "b": 0.0},
    states={
        "x": "x - x^3 + b*y",  # b decides where a motion goes, and plays no part there
        "y": {"rate": "-2*y", "start": 1},
        "u": "(a + x/2)*u - w - (u^2 + w^2)*u",
        "w": "u + (a + x/2)*w - (u^2 + w^2)*w",
    },
)
STEERED_WINDOW = ("a", "b"), ((-1.2, 0.8), (-1.0, 1.5))


def test_all_equilibria_that_motions_settle_on_are_followed(few_lines):
    found = sf.bifurcation_set(STEERED, *STEERED_WINDOW, types="HB", periods=1, regions=False)
    at = sorted(locus.values[:, 0].mean() for locus in found.loci)
    assert at == pytest.approx([-0.5, 0, 0.5], abs=1e-9)
    assert found.missing == ()


@pytest.mark.parametrize("place", [2, pytest.param(40, marks=pytest.mark.long)])  # of the fold
def test_a_fold_of_equilibria_that_no_line_and_no_motion_leads_to_is_followed(place):
    # Motions from x = 0 stay there, and so do equilibria across the window.
    rates = {"x": f"-x*((x - {place})^2 + b^2 - a)"}
    given = sf.System(parameters={"a": 0, "b": 0}, states=rates), ("a", "b"), ((-1, 1), (-0.8, 0.8))
    (fold,) = sf.bifurcation_set(*given, regions=False).loci
    assert fold.values[:, 0] == pytest.approx(fold.values[:, 1] ** 2, abs=1e-12)
    assert fold.values[[0, -1], 1] == pytest.approx([-0.8, 0.8])


def test_refused_points_are_reported_unless_a_locus_passes_them(monkeypatch):
    model = sf.System(parameters={"a": 0, "b": 0}, states={"x": "a + x - x^3", "y": "b - y"})
    start, folds = follow._Loci.start, []

    def refused(loci, curve, z, point):
        folds.append(point.value)
        known = folds[-1] > 0 and sum(fold > 0 for fold in folds) > 1  # all but the first
        return start(loci, curve, z, point) if known else sf.InputError("no start")

    monkeypatch.setattr(follow._Loci, "start", refused)
    monkeypatch.setattr(bifurcation_set, "LINES", (3, 1))
    found = sf.bifurcation_set(model, ("a", "b"), ((-1, 1), (-1, 1)), regions=False)
    (locus,) = found.loci
    assert locus.values[:, 0] == pytest.approx(2 / 27**0.5)
    told = re.compile("the locus of the LP at a = -0.3849, .* was not followed: no start")
    assert found.missing
    assert all(map(told.fullmatch, found.missing))


def test_an_island_of_equilibria_between_lines_is_found():
    rates = {"x": "-x*((x - 2)^2 + 100*((a - 0.8)^2 + (b - 0.75)^2) - 1)"}  # a tenth as wide
    model = sf.System(parameters={"a": 0, "b": 0}, states=rates)
    found = sf.bifurcation_set(model, ("a", "b"), ((-1, 1), (-0.9, 0.9)))
    assert found.regions is None
    assert (
        "No regions: regions exist for forced models only, and system is autonom" in found.summary()
    )
    (fold,) = found.loci
    assert np.hypot(*(fold.values - (0.8, 0.75)).T) == pytest.approx(0.1, abs=1e-12)
    assert fold.closed


def test_cycles_are_followed_from_equilibria_that_no_line_leads_to(monkeypatch):
    # r' = g r with g = a + x - 2.4 + r^2 - r^4: cycles fold at g = 1/4 - r^2 + r^4, r^2 = 1/2.
    monkeypatch.setattr(bifurcation_set, "LINES", (1, 1))
    rates = {"x": "-x*((x - 2)^2 + b^2 - 0.3)", "u": "g*u - w", "w": "u + g*w"}
    formulas = {"g": "a + x - 2.4 + u^2 + w^2 - (u^2 + w^2)^2"}
    model = sf.System(parameters={"a": 0, "b": 0}, formulas=formulas, states=rates)
    given = ("a", "b"), ((-1, 1), (-0.3, 0.3))
    found = sf.bifurcation_set(model, *given, types="LP", periods=1, regions=False)
    for (a, b), side in zip((locus.values.T for locus in found.loci), (-1, 1), strict=True):
        assert a == pytest.approx(0.15 + side * np.sqrt(0.3 - b**2), abs=1e-9)


def test_an_equilibrium_that_cannot_be_followed_is_reported(monkeypatch, tmp_path):
    follow = fan.trace_response

    def refuse(*args, begin=None, **options):
        if begin is not None:
            raise sf.InputError("the equilibrium there is at a fold")
        return follow(*args, **options)

    monkeypatch.setattr(fan, "trace_response", refuse)
    found = sf.bifurcation_set(STEERED, *STEERED_WINDOW, types="HB", periods=1, regions=False)
    assert len(found.loci) == 1
    assert found.missing[0] == (
        "another equilibrium, at a = -0.7, b = -0.375, could not be followed in b: "
        "the equilibrium there is at a fold"
    )
    assert "Another equilibrium, at a = -0.7" in found.summary()
    assert found.to_json()["missing"] == list(found.missing)
    found.save(tmp_path / "found.nc")
    assert sf.load(tmp_path / "found.nc").missing == found.missing


def test_a_locus_that_comes_to_where_nothing_damps_says_so():
    # At c = 0 both frequencies of the squealing structure meet, and all eigenvalues are imaginary.
    hopf = point_of(model_named("squeal"), "mu", (0.7, 0.8), "HB")
    window = ("mu", "c"), ((0.5, 1.0), (0, 0.2))
    (locus,) = sf.locus(hopf, *window, switch=False).loci
    assert locus.values[0] == pytest.approx([0.75, 0], abs=1e-6)
    assert "4 multipliers lie on the unit circle" in locus.started.reason


def test_a_closed_locus_inside_the_window_is_found_from_the_models_own_place(few_lines):
    states = {"x": {"rate": "1 - p^2 - q^2 - x^2", "start": 0.9}}
    sphere = sf.System(parameters={"p": 0.3, "q": 0.2}, states=states)
    (locus,) = sf.locus(sphere, ("p", "q"), ((-2, 2), (-1.5, 1.5)), type="LP").loci
    assert (locus.stopped.kind, len(locus.special)) == ("closed", 4)
    assert np.hypot(*locus.values.T) == pytest.approx(1, abs=1e-12)


def test_a_coefficient_without_a_pole_makes_no_generalized_hopf_point_at_zero_hopf():
    # The pair drives nothing: l1 is the same along p = q^2, and is not defined at p = q = 0.
    states = {"z": {"rate": "p - z^2", "start": 0.7}, "u": "h*u - v", "v": "h*v + u"}
    values, formulas = {"p": 0.5, "q": -1.0}, {"h": "q + z - u^2 - v^2"}
    system = sf.System(parameters=values, formulas=formulas, states=states)
    hopf = point_of(system, "q", (-2, 2), "HB")
    onset, folds = sf.locus(hopf, ("p", "q"), ((-1, 1), (-1, 1))).loci
    assert sorted(item.type for item in onset.special) == ["MIN", "ZH"]
    assert [item.type for item in folds.special] == ["ZH"]
    (smallest,) = specials(onset, "MIN")
    assert (smallest.coefficients, smallest.criticality) == ({}, None)
