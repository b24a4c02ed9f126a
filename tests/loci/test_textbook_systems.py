"""Loci of textbook systems: closed forms, and conditions solved by SciPy with code by hand."""

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import mathieu_a, mathieu_b

from helpers.bifurcation_sets import bifurcations, locus_crossings
from helpers.oscillator_loci import (
    cusp_equations,
    duffing,
    resonance_equations,
    solve,
    stroboscopic,
    van_der_pol,
)
from helpers.textbook_models import Decoupled, Duffing, Mathieu, Torus, VanDerPol
from slipfold.bifurcations.branches.response import trace_response
from slipfold.bifurcations.loci.bifurcation_set import find_bifurcation_set
from slipfold.bifurcations.loci.follow import follow_loci


def loci_of(model, vary, span, plane, window, kind, switch=False):
    points = bifurcations(trace_response(model, vary, span), kind)
    assert points
    return follow_loci(points, plane, window, switch=switch)


def nudged(item):
    """A guess a little beside a special point, so that nothing is handed on."""
    return np.array([*item.state, *item.values]) * [1.001, 0.999, 1.0005, 0.998]


# -- Duffing -----------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def folds():
    window = ((0.9, 1.6), (0.01, 0.3))
    loci = loci_of(Duffing(), "w", (0.8, 1.6), ("w", "a"), window, "LP")
    (found,) = loci  # both folds of the response belong to one locus, joined at the cusp
    return found


def test_folds_of_the_duffing_oscillator_join_in_a_cusp(folds):
    assert [item.type for item in folds.special] == ["CPC"]
    (item,) = folds.special
    by_hand = solve(cusp_equations, duffing, nudged(item))
    assert item.values == pytest.approx(by_hand[2:], abs=1e-9)
    assert item.state == pytest.approx(by_hand[:2], abs=1e-6)
    assert item.values == pytest.approx((1.04417423, 0.05393111), abs=1e-8)
    # No fold exists below the cusp, so the hysteresis begins there.
    assert folds.values[:, 1].min() >= item.values[1] - 1e-12
    assert folds.values[:, 0].min() >= item.values[0] - 1e-12


def test_folds_by_hand(folds):
    for index in range(0, len(folds), 5):
        w, a = folds.values[index]
        image, matrix = stroboscopic(duffing, folds.states[index], w, a)
        assert image.real == pytest.approx(folds.states[index], abs=1e-9)
        assert abs(np.linalg.det(matrix - np.eye(2))) < 1e-9


# -- van der Pol -------------------------------------------------------------------------------

TONGUE = ((0.85, 1.15), (0.1, 0.4))


@pytest.fixture(scope="module")
def tongue():
    plane = ("w", "a")
    return loci_of(VanDerPol(), "w", (1.0, 1.2), plane, TONGUE, "NS", switch=True)


def special(loci, kind, name):
    return [p for item in loci if item.type == kind for p in item.special if p.type == name]


def assert_on_folds(tongue, name, equations, expected):
    """The points of a type on the loci of folds are those found by hand and published."""
    items = sorted(special(tongue, "LP", name), key=lambda p: p.values)
    for item, known in zip(items, expected, strict=True):
        by_hand = solve(equations, van_der_pol, nudged(item))
        assert item.values == pytest.approx(by_hand[2:], abs=1e-8)
        assert item.values == pytest.approx(known, abs=1e-8)
        assert item.state == pytest.approx(by_hand[:2], abs=1e-6)
    return items


def test_torus_of_the_van_der_pol_oscillator_ends_in_strong_resonances(tongue):
    expected = [(0.94934198, 0.19240059), (1.04940458, 0.20741108)]
    items = assert_on_folds(tongue, "R1", resonance_equations, expected)
    ends = [
        end for item in tongue if item.type == "NS"
        for end in (item.started, item.stopped) if end.kind == "codimension-2"
    ]  # fmt: skip
    for item in items:  # the torus ends where the fold has its resonance
        gaps = [np.abs(np.subtract(end.values, item.values)).max() for end in ends]
        assert min(gaps) < 1e-8


def test_cusps_of_the_van_der_pol_oscillator(tongue):
    expected = [(0.94043917, 0.21146913), (1.05620733, 0.22404823)]
    assert_on_folds(tongue, "CPC", cusp_equations, expected)


# -- Mathieu -----------------------------------------------------------------------------------


def test_doubling_of_the_mathieu_equation():
    window = ((1.8, 2.2), (0.01, 0.4))
    (found,) = loci_of(Mathieu(), "h", (0.0, 0.1), ("w", "h"), window, "PD")
    for w, h in ((2.0, 0.0400008749895), (1.9, 0.2014699309238)):
        (crossing,) = locus_crossings(found, 0, w)
        assert crossing.values[1] == pytest.approx(h, abs=1e-11)
    assert sorted(item.name for item in found.special) == [
        "generalized period doubling",
        "smallest h",
    ]
    for item in found.special:
        assert item.values == pytest.approx((2.0, 0.04), abs=1e-3)
    # About rest the coefficient is linear in that of the cubic term: its sign turns all over.
    (other,) = loci_of(Mathieu(g=-2.0), "h", (0.0, 0.1), ("w", "h"), window, "PD")
    for w in (1.85, 1.95, 2.01, 2.1):
        (one,), (two,) = (locus_crossings(item, 0, w) for item in (found, other))
        assert one.values == pytest.approx(two.values, abs=1e-11)
        assert two.coefficient == pytest.approx(-2 * one.coefficient, rel=1e-7)
        assert {one.criticality, two.criticality} == {"subcritical", "supercritical"}


@pytest.mark.parametrize("w", [1.93, 2.07])
def test_doubling_without_damping_is_a_resonance_at_a_characteristic_value(w):
    # With t = 2 s/w it is x'' + (4/w^2)(1 + h cos 2 s) x = 0: Mathieu's a = 4/w^2, q = -2 h/w^2.
    value = mathieu_a if w < 2 else mathieu_b
    exact = brentq(lambda h: value(1, 2 * h / w**2) - 4 / w**2, 0.01, 0.4, xtol=1e-14)
    window = ((-0.03, 0.03), (0.01, 0.3))
    (found,) = loci_of(Mathieu(w=w), "h", (0.0, 0.3), ("z", "h"), window, "PD")
    # Nothing but the sign of the damping tells one side from the other.
    assert sorted(item.type for item in found.special) == ["MIN", "R2"]
    for item in found.special:
        assert item.values == pytest.approx((0, exact), abs=1e-10)
    resonance = next(item for item in found.special if item.type == "R2")
    assert resonance.multipliers == pytest.approx(-1, abs=1e-6)
    for z in (0.005, 0.02):
        (left,), (right,) = (locus_crossings(found, 0, side * z) for side in (-1, 1))
        assert left.values[1] == pytest.approx(right.values[1], abs=1e-11)


# -- the normal form of a torus ----------------------------------------------------------------


def torus_locus(plane, window, **values):
    (found,) = loci_of(Torus(**values), "m", (-0.5, 0.4), plane, window, "NS")
    return found


def test_resonances_of_the_torus_normal_form_are_exact():
    found = torus_locus(("m", "v"), ((-0.5, 0.5), (0.5, 2.9)))
    assert np.abs(found.values[:, 0]).max() < 1e-12
    assert sorted(found.values[[0, -1], 1]) == pytest.approx([0.5, 2.9], abs=1e-12)
    exact = np.exp(1j * found.values[:, 1])
    assert found.multipliers[:, 0] == pytest.approx(exact, abs=1e-8)
    # |z| goes to |z| (1 - n |z|^2), and a unit eigenvector has |z|^2 = 2 |w|^2.
    assert found.coefficient == pytest.approx(-2.0, rel=1e-8)
    resonances = {item.type: item for item in found.special if item.type in ("R3", "R4")}
    assert resonances["R4"].values == pytest.approx((0, np.pi / 2), abs=1e-11)
    assert resonances["R3"].values == pytest.approx((0, 2 * np.pi / 3), abs=1e-11)
    # It has no resonant terms, which a quotient would be infinite by.
    assert resonances["R4"].coefficients == {"d": pytest.approx(-2.0, rel=1e-7)}
    assert resonances["R3"].coefficients["b"] == pytest.approx(0, abs=1e-8)
    assert resonances["R3"].coefficients["c"] == pytest.approx(-2.0, rel=1e-7)


def test_chenciner_point_of_the_torus_normal_form_is_exact():
    found = torus_locus(("m", "n"), ((-0.5, 0.5), (-1.0, 1.5)))
    (item,) = (p for p in found.special if p.type == "CH")
    assert item.values == pytest.approx((0, 0), abs=1e-11)
    assert found.coefficient == pytest.approx(-2 * found.values[:, 1], abs=1e-8)
    assert np.array_equal(found.supercritical, found.values[:, 1] > 0)


def test_a_neutral_saddle_has_no_locus():
    found = find_bifurcation_set(Decoupled(), ("r", "a"), ((0.5, 1.5), (0.1, 0.5)), regions=False)
    assert found.loci == ()
