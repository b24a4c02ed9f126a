"""Points of codimension two by their names, and the loci that begin and end there.

Published values are those of the demos of AUTO-07p and of the tests of BifurcationKit.jl
(`test/hopf_codim_2/lorenz84.jl` and `COModel.jl`); the rest are closed forms.
"""

from functools import lru_cache
from math import pi, sqrt

import numpy as np
import pytest

import slipfold as sf
from helpers.long_tests import long_except
from slipfold.bifurcations.loci import bifurcation_set, fan

WHOLE = sf.Settings(largest_period=1)
QUIET = sf.Settings(largest_period=0)

REACTION = sf.System(
    name="ab",
    parameters={"p1": 0.0, "p2": 14.0, "p3": 3.0},
    states={"u1": "-u1 + p1*(1 - u1)*exp(u2)", "u2": "-u2 + p1*p2*(1 - u1)*exp(u2) - p3*u2"},
)
CIRCUIT = sf.System(
    name="tor",
    parameters={"nu": -0.62, "beta": 0.5, "gamma": -0.6, "r": 0.6, "a3": 0.328578, "b3": 0.933578},
    states={
        "x": "(-(beta + nu)*x + beta*y - a3*x^3 + b3*(y - x)^3)/r",
        "y": "beta*x - (beta + gamma)*y - z - b3*(y - x)^3",
        "z": "y",
    },
)
ATMOSPHERE = sf.System(
    name="lorenz-84",
    parameters={
        "F": 3.0,
        "T": 0.04,
        "alpha": 0.25,
        "beta": 1.0,
        "gamma": 0.987,
        "delta": 1.04,
        "G": 0.25,
    },
    states={
        "X": {"rate": "-Y^2 - Z^2 - alpha*X + alpha*F - gamma*U^2", "start": 2.979},
        "Y": {"rate": "X*Y - beta*X*Z - Y + G", "start": -0.0387},
        "Z": {"rate": "beta*X*Y + X*Z - Z", "start": 0.0582},
        "U": {"rate": "-delta*U + gamma*U*X + T", "start": -0.0211},
    },
)
OXIDATION = sf.System(
    name="co-oxidation",
    parameters={"q1": 2.5, "q2": 0.6, "q3": 10.0, "q4": 0.0675, "q5": 1.0, "q6": 0.1, "k": 0.4},
    states={
        "x": {"rate": "2*q1*(1 - x - y - s)^2 - 2*q5*x^2 - q3*x*y", "start": 0.07},
        "y": {"rate": "q2*(1 - x - y - s) - q6*y - q3*x*y", "start": 0.2},
        "s": {"rate": "q4*(1 - x - y - s) - k*q4*s", "start": 0.5},
    },
)
ZERO_HOPF = sf.System(
    name="zero-hopf",
    parameters={"b1": -0.25, "b2": -0.2, "s": 1.0, "e": -1.0},
    states={
        "w": {"rate": "b1 + w^2 + s*(u^2 + v^2)", "start": -0.5},
        "u": "(b2 + e*w + w^2)*u - v",
        "v": "u + (b2 + e*w + w^2)*v",
    },
)
TWO_MODES = sf.System(
    name="two-modes",
    parameters={"a": -0.5, "b": 0.3, "p": 0.6, "q": 0.4},
    states={
        "x": "a*x - y - x*(x^2 + y^2 + p*(u^2 + v^2))",
        "y": "x + a*y - y*(x^2 + y^2 + p*(u^2 + v^2))",
        "u": "b*u - sqrt(2)*v - u*(u^2 + v^2 + q*(x^2 + y^2))",
        "v": "sqrt(2)*u + b*v - v*(u^2 + v^2 + q*(x^2 + y^2))",
    },
)


@lru_cache
def response_of(model, vary, span, settings):
    return sf.response(model, vary=vary, span=span, settings=settings)


def points_of(model, vary, span, kind, settings=QUIET):
    diagram = response_of(model, vary, span, settings)
    return [item.point for item in diagram.special if item.point.type == kind]


def named(loci, kind):
    """Values of the points of a type on some loci."""
    return [point.values for locus in loci for point in locus.special if point.type == kind]


def of_type(found, kind, orbits="periodic"):
    return [locus for locus in found.loci if (locus.type, locus.kind) == (kind, orbits)]


@pytest.mark.long
def test_hopf_points_alone_need_no_cycles(monkeypatch):
    # Cycles of the circuit snake to homoclinic orbits: a minute for a window, and three seconds
    # without them.
    followed = []
    follow = fan.trace_response

    def seen(*args, **options):
        branches = follow(*args, **options)
        followed.extend(branch.kind for branch in branches)
        return branches

    monkeypatch.setattr(fan, "trace_response", seen)
    found = sf.locus(CIRCUIT, ("nu", "beta"), ((-0.62, -0.58), (0.55, 0.65)), type="HB")
    assert set(followed) == {"equilibrium"}
    assert {locus.type for locus in found.loci} == {"HB"}
    assert (-0.6, 0.6) in [
        tuple(np.round(values, 9).tolist()) for values in named(found.loci, "ZH")
    ]


def test_folds_of_the_reaction_end_at_its_bautin_point():
    # AUTO's demo ab. The response begins where nothing couples the states, at p1 = 0, and finds
    # their sizes a thousand times too large.
    folds = points_of(REACTION, "p1", (0, 0.5), "LP", WHOLE)
    plane = ("p1", "p2"), ((0.14, 0.43), (10, 15))
    found = sf.locus(folds, *plane)
    (cycles,), (hopf,) = of_type(found, "LP"), of_type(found, "HB", "equilibrium")
    assert named([hopf], "GH") == [pytest.approx((0.2789854, 11.0158491), abs=1e-7)]
    end = next(end for end in (cycles.started, cycles.stopped) if end.kind == "codimension-2")
    assert end.values == pytest.approx((0.2789854, 11.0158491), abs=1e-7)
    assert end.reason.startswith("the locus ends at GH, generalized Hopf")
    assert cycles.special == ()
    assert next(item for item in hopf.special if item.type == "GH").leads_to == (cycles.id,)
    assert not of_type(found, "BP")


def test_equilibria_of_the_oxidation():
    found = sf.locus(
        points_of(OXIDATION, "q2", (0.6, 1.9), "HB")[:1],
        ("q2", "k"),
        ((0.6, 1.9), (0.1, 2.2)),
        switch=False,
    )
    first, second = sorted(named(found.loci, "GH"))
    assert first == pytest.approx((0.8913, 0.2325), abs=1e-4)
    assert second == pytest.approx((0.924255, 0.305879), abs=1e-6)
    doubles = sorted(named(found.loci, "BT"))
    assert doubles[0] == pytest.approx((1.161199, 0.7223392), abs=1e-6)
    assert doubles[1] == pytest.approx((1.417628, 0.971397), abs=1e-6)


def test_equilibria_of_the_atmosphere():
    hopf = points_of(ATMOSPHERE, "F", (3.0, 1.0), "HB")
    plane = ("F", "T"), ((1.2, 3.0), (-0.01, 0.07))
    loci = sf.locus(hopf, *plane, switch=False).loci
    assert len(loci) == 2
    # Both loci of Hopf points pass the double one.
    assert named(loci, "HH") == [pytest.approx((2.533221, 0.0262739), abs=1e-6)] * 2
    assert named(loci, "GH") == [pytest.approx((2.37636, 0.0501974), abs=1e-5)]
    folds = sf.locus(points_of(ATMOSPHERE, "F", (3.0, 1.0), "LP"), *plane, switch=False).loci
    assert sorted(named(folds, "ZH"), key=lambda values: values[1]) == [
        pytest.approx((1.2834193, sign * 1.2654e-4), abs=1e-7) for sign in (-1, 1)
    ]
    assert named(folds, "CP") == [pytest.approx((1.2782833, 0), abs=1e-6)]
    (double,) = (point for point in folds[0].special if point.type == "BT")
    assert double.values == pytest.approx((1.4467167, 0.0209402), abs=1e-6)
    assert double.coefficients == pytest.approx({"a": 0.2144233, "b": 0.6065146}, rel=1e-5)


@lru_cache
def tori_of_the_atmosphere():
    hopf = points_of(ATMOSPHERE, "F", (3.0, 1.0), "HB")
    return sf.locus(hopf[1:2], ("F", "T"), ((2.46, 2.56), (0.0245, 0.045)))


def test_tori_of_the_atmosphere_begin_at_the_double_hopf_point():
    found = tori_of_the_atmosphere()
    tori, hopf = of_type(found, "NS"), of_type(found, "HB", "equilibrium")
    assert (len(tori), len(hopf)) == (2, 2)
    doubles = [item for locus in hopf for item in locus.special if item.type == "HH"]
    double = min(doubles, key=lambda item: max(item.uncertainty))
    place = double.values
    for mirrored in doubles:  # mirror images share one place
        gap = np.abs(np.subtract(mirrored.values, place))
        assert (gap < 1e-8 + 3 * np.array(mirrored.uncertainty)).all()
        assert gap.max() < 1e-5
    frequencies = sorted(value for value in double.eigenvalues.imag if value > 1e-3)
    for locus in tori:
        assert any(locus.started.values == pytest.approx(item.values, abs=1e-7) for item in doubles)
        assert locus.parent in [item.id for item in hopf]
    assert sorted(2 * pi / locus.durations[0] for locus in tori) == pytest.approx(
        frequencies, rel=1e-5
    )


def test_tori_of_two_modes_begin_at_their_double_hopf_point():
    # Cycles of the first mode, of radius sqrt(a), let the second grow where b > q a; the other way
    # round where a > p b.
    hopf = points_of(TWO_MODES, "a", (-0.5, 0.5), "HB")
    found = sf.locus(hopf, ("a", "b"), ((-1, 1), (-1, 1)))
    assert [locus.type for locus in found.loci] == ["HB", "HB", "NS", "NS"]
    for locus, along in zip(found.loci[:2], (0, 1), strict=True):
        assert locus.values[:, along] == pytest.approx(0, abs=1e-12)
        (double,) = locus.special
        assert (double.type, double.values) == ("HH", pytest.approx((0, 0), abs=1e-9))
        assert {3, 4} < set(double.leads_to)
        assert locus.id not in double.leads_to
    slopes = {2 * pi: 0.4, sqrt(2) * pi: 1 / 0.6}
    for locus in found.loci[2:]:
        a, b = locus.values.T
        assert min(a.min(), b.min()) > -1e-9
        assert max(a.max(), b.max()) == 1
        slope = slopes[min(slopes, key=lambda item: abs(item - locus.durations[-1]))]
        assert b == pytest.approx(slope * a, abs=1e-9)


def test_two_modes_in_bent_coordinates_have_the_coefficients_of_their_form():
    # r1' = r1 (a - r1^2 - 0.6 r2^2) turns at 1.5, r2' = r2 (b - 0.4 r1^2 - r2^2) at 1; each mode is
    # seen with squares of the other. The critical vectors are (1, -i)/sqrt(2): twice the numbers.
    model = sf.System({
        "name": "bent",
        "parameters": {"a": -0.5, "b": -0.3},
        "formulas": {
            "u": "x - 0.3*z*w + 0.2*z^2",
            "v": "y - 0.4*w^2",
            "p": "z - 0.5*u*v",
            "q": "w + 0.3*u^2 - 0.2*v^2",
            "du": "u*(a - u^2 - v^2 - 0.6*(p^2 + q^2)) - 1.5*v",
            "dv": "v*(a - u^2 - v^2 - 0.6*(p^2 + q^2)) + 1.5*u",
            "dp": "p*(b - 0.4*(u^2 + v^2) - p^2 - q^2) - q",
            "dq": "q*(b - 0.4*(u^2 + v^2) - p^2 - q^2) + p",
            "dz": "dp + 0.5*(du*v + u*dv)",
            "dw": "dq - 0.6*u*du + 0.4*v*dv",
        },
        "states": {
            "x": "du + 0.3*(dz*w + z*dw) - 0.4*z*dz",
            "y": "dv + 0.8*w*dw",
            "z": "dz",
            "w": "dw",
        },
    })  # fmt: skip
    hopf = points_of(model, "a", (-0.5, 0.5), "HB")
    found = sf.locus(hopf, ("a", "b"), ((-1, 1), (-1, 1)), switch=False)
    (double,) = found.loci[0].special
    assert (double.type, double.values) == ("HH", pytest.approx((0, 0), abs=1e-9))
    expected = {"p11": -2, "p12": -1.2, "p21": -0.8, "p22": -2}
    assert double.coefficients == pytest.approx(expected, rel=1e-7)


@pytest.mark.parametrize("s", long_except([1.0, -1.0], [1.0]))
@pytest.mark.parametrize("e", [1.0, -1.0])
def test_tori_begin_at_a_zero_hopf_point_by_its_signs(s, e):
    # Kuznetsov, Elements of Applied Bifurcation Theory, section 8.5, without what breaks the
    # rotation: cycles with w = 0 and radius rho at b2 = 0, b1 = -s rho^2, whose pair has the
    # exponents +-i rho sqrt(-2 s e). With s e > 0 they are saddles.
    model = ZERO_HOPF.replace(s=s, e=e)
    folds = points_of(model, "b1", (-0.25, 0.2), "LP")
    found = sf.locus(folds, ("b1", "b2"), ((-0.1, 0.1), (-0.25, 0.25)))
    (hopf,) = of_type(found, "HB", "equilibrium")
    (both,) = (point for point in hopf.special if point.type == "ZH")
    assert both.values == pytest.approx((0, 0), abs=1e-10)
    # The null vector may have either sign; of a pair's vector of unit length 2 s |z|^2 = s r^2.
    sign = np.sign(both.coefficients["a"])
    expected = {"a": sign, "b": 2 * s * sign, "e": e * sign}
    assert both.coefficients == pytest.approx(expected, abs=1e-9)
    tori = of_type(found, "NS")
    assert len(tori) == (1 if s * e < 0 else 0)
    for locus in tori:
        b1, b2 = locus.values.T
        assert b2 == pytest.approx(0, abs=1e-10)
        assert (-s * b1 > -1e-12).all()
        rho = np.sqrt(np.abs(b1))
        assert np.hypot(*locus.states[:, 1:].T) == pytest.approx(rho, abs=1e-7)
        cosine = np.cos(2 * pi * rho * sqrt(2))
        assert np.sort(locus.multipliers.real, axis=1)[:, 0] == pytest.approx(cosine, abs=1e-6)
        # A fourth and a third of a turn.
        assert named([locus], "R4") == [pytest.approx((-s / 32, 0), abs=1e-9)]
        assert named([locus], "R3") == [pytest.approx((-s / 18, 0), abs=1e-9)]


def test_zero_hopf_point_of_a_symmetry():
    # AUTO's demo tor. At the origin an eigenvalue is zero where beta + nu = 0, and then the others
    # are +-i w where beta = -gamma = 0.6, with w^2 = 1 - beta^2/r = 0.4.
    (origin, *_) = points_of(CIRCUIT, "nu", (-0.62, -0.57), "HB")
    found = sf.locus(origin, ("nu", "beta"), ((-0.9, -0.4), (0.3, 0.9)))
    hopf = found.loci[0]
    (point,) = (item for item in hopf.special if item.type == "ZH")
    assert point.values == pytest.approx((-0.6, 0.6), abs=1e-9)
    assert sorted(point.eigenvalues.imag) == pytest.approx([-sqrt(0.4), 0, sqrt(0.4)], abs=1e-7)
    assert point.eigenvalues.real == pytest.approx(0, abs=1e-9)
    assert [item.type for item in hopf.special] == ["GH", "MAX", "ZH", "BT"]
    # The other equilibria branch off where nu + beta = 0, and have a Hopf locus of their own from
    # there to where the pair is zero too, nu^2 = 0.6.
    (crossed,) = of_type(found, "BP", "equilibrium")
    assert crossed.values.sum(axis=1) == pytest.approx(0, abs=1e-10)
    other = next(locus for locus in of_type(found, "HB", "equilibrium") if locus is not hopf)
    ends = sorted(end.values for end in (other.started, other.stopped))
    assert ends[1] == pytest.approx((-0.6, 0.6), abs=1e-9)
    assert ends[0] == pytest.approx((-sqrt(0.6), sqrt(0.6)), abs=1e-6)
    assert [item.type for item in other.special][-1] == "BT"


def test_a_hopf_locus_ends_where_its_equilibria_become_symmetric():
    # x^2 = m and b = 1.5 m: at m = 0 its equilibria are those with x = 0, whose pair is not zero.
    turn = "b - 1.5*x^2 - 0.2*(y^2 + z^2)"
    model = sf.System(
        parameters={"m": 0.1, "b": -0.2},
        states={
            "x": {"rate": "x*(m - x^2 + 0.5*(y^2 + z^2))", "start": 0.3},
            "y": f"y*({turn}) - 2*z",
            "z": f"z*({turn}) + 2*y",
        },
    )
    hopf = points_of(model, "b", (-0.2, 0.3), "HB")
    (locus,) = sf.locus(hopf, ("m", "b"), ((-0.2, 0.2), (-0.3, 0.3)), switch=False).loci
    (end,) = (end for end in (locus.started, locus.stopped) if end.kind == "codimension-2")
    assert end.reason.startswith("the locus ends at ZH, where its orbits become symmetric")
    assert end.values == pytest.approx((0, 0), abs=1e-9)
    assert locus.values[:, 1] == pytest.approx(1.5 * locus.values[:, 0], abs=1e-9)


@pytest.mark.long
def test_folds_of_cycles_start_at_a_generalized_hopf_point_of_any_scale(monkeypatch):
    # The neural mass model of Tsodyks and Markram, as in BifurcationKit's tutorial but with
    # alpha = 1.5. Steps of 0.003 from the GH at J = 2.97 fail; 0.012 was tried and not taken.
    def of_equilibria(plane, counts):
        still = plane.settings.largest_period == 0
        return fan.follow_fan(plane, counts) if still else iter(())

    monkeypatch.setattr(bifurcation_set, "follow_fan", of_equilibria)
    monkeypatch.setattr(bifurcation_set, "LINES", (3, 1))
    monkeypatch.setattr(bifurcation_set, "follow_settled", lambda *given: iter(()))
    monkeypatch.setattr(bifurcation_set, "with_cycles", lambda plane, line: line)
    model = sf.System(
        parameters={"E0": -2.0, "J": 3.07},
        formulas={"S": "1.5*log(1 + exp((J*u*x*E + E0)/1.5))"},
        states={
            "E": {"rate": "(S - E)/0.013", "start": 0.238616},
            "x": {"rate": "(1 - x)/0.2 - u*x*E", "start": 0.982747},
            "u": {"rate": "(0.3 - u)/1.5 + 0.3*(1 - u)*E", "start": 0.367876},
        },
    )
    window = (-2.2, -1.0), (2.5, 4.0)
    found = bifurcation_set.find_bifurcation_set(model, ("E0", "J"), window, regions=False)
    bautin = [point for locus in found.loci for point in locus.special if point.type == "GH"]
    folds = [locus for locus in found.loci if locus.kind == "periodic"]
    assert len(bautin) == len(folds) == 3
    assert {locus.stopped.kind for locus in folds} == {"window"}


SYMMETRIC_PAIR = sf.System(
    name="pitchfork and Hopf",
    parameters={"m": 0.1, "b": -0.2},
    formulas={"r2": "y^2 + z^2", "g": "b - 1.5*x^2 + 0.6*r2 - 0.2*r2^2"},
    states={"x": "x*(m - x^2 + 0.5*r2)", "y": "g*y - 2*z", "z": "2*y + g*z"},
)
"""Cycles with x^2 = m + r2/2, g = 0 and x^2 = 0.6 r2 - 0.4 r2^2 have a pair on the unit circle."""


@pytest.mark.long
def test_tori_begin_at_a_zero_hopf_point_of_a_symmetry():
    window = ((-0.5, 0.5), (-0.5, 0.5))
    found = sf.locus(SYMMETRIC_PAIR, ("m", "b"), window)
    # No locus is followed again as its own mirror image.
    kinds = sorted((locus.type, locus.kind) for locus in found.loci)
    assert kinds == [
        ("BP", "equilibrium"),
        ("BP", "periodic"),
        ("HB", "equilibrium"),
        ("HB", "equilibrium"),
        ("LP", "periodic"),
        ("NS", "periodic"),
    ]
    (tori,) = of_type(found, "NS")
    point = next(p for locus in found.loci for p in locus.special if p.type == "ZH")
    assert tori.id in point.leads_to
    assert tori.started.values == pytest.approx((0, 0), abs=1e-9)
    # With unit vectors x' = -x^3 + x |w|^2 / 2 (y + iz = w) is as it stands, but r2 = 2 |w|^2.
    assert point.coefficients == pytest.approx({"p11": -1, "p12": 1, "p21": -1.5, "p22": 1.2})
    m, b = tori.values.T
    r2 = (b - m) / 0.2  # m = r2/10 - 0.4 r2^2 and b = 0.3 r2 - 0.4 r2^2
    assert m == pytest.approx(0.1 * r2 - 0.4 * r2**2, abs=1e-9)
    assert [p.values for p in tori.special if p.type == "MAX"] == [
        pytest.approx((0.00625, 0.03125), abs=1e-9),
        pytest.approx((-0.01875, 0.05625), abs=1e-9),
    ]


@pytest.mark.parametrize(("kind", "back", "own"), [("LP", 1, 0), ("BP", 0, 1)])
def test_a_fold_that_meets_a_pitchfork_is_no_bogdanov_takens_point(kind, back, own):
    # Folds at m = 0, pitchforks at m = -b^2: both kinds of vectors are null at the origin. Nor is
    # it a degenerate pitchfork where the cubic coefficient, of y^3 alone, has no pole.
    model = sf.System(
        parameters={"m": -0.2, "b": -0.1},
        states={
            "x": {"rate": f"m + x^2 + {back}*y^2", "start": -0.4},
            "y": f"y*(b - x - {own}*y^2)",
        },
    )
    start, *_ = points_of(model, "m", (-0.2, 0.1), kind, sf.Settings(largest_period=0))
    (locus,) = sf.locus(start, ("m", "b"), ((-0.5, 0.5), (-0.5, 0.5)), switch=False).loci
    (point,) = (item for item in locus.special if item.type not in ("MIN", "MAX"))
    assert (point.type, point.name) == ("LPBP", "fold and branch point")
    assert point.values == pytest.approx((0, 0), abs=1e-9)
    assert {end.kind for end in (locus.started, locus.stopped)} == {"window"}


@pytest.mark.long
def test_symmetric_cycles_of_the_circuit_fold_and_lose_symmetry_at_one_point():
    # Of AUTO's demo tor: tori lead from the zero-Hopf point to there, and nothing is listed twice.
    found = sf.locus(CIRCUIT, ("nu", "beta"), ((-0.65, -0.55), (0.4, 0.65)))
    ends = []
    for kind in ("LP", "BP", "NS"):
        (locus,) = of_type(found, kind)
        ends += [item for item in locus.special if item.type == "LPBP"]
    (tori,) = of_type(found, "NS")
    *others, (place, error) = ((np.array(item.values), np.array(item.uncertainty)) for item in ends)
    for other, uncertain in others:
        assert max(uncertain.max(), error.max()) < 1e-7
        assert (abs(other - place) < 3 * (uncertain + error)).all()
    assert tori.started.values == pytest.approx((-0.6, 0.6), abs=1e-9)
    assert tori.stopped.values == ends[2].values
    assert [item.type for item in tori.special] == ["MAX", "LPBP"]


def test_a_bogdanov_takens_point_of_a_symmetry_has_the_coefficients_of_its_form():
    # x'' = m x + b x' - x^3 - x^2 x'/2, whose other equilibria have Hopf points at b = m/2.
    states = {"x": "y", "y": "m*x + b*y - x^3 - 0.5*x^2*y"}
    model = sf.System(parameters={"m": -0.3, "b": -0.1}, states=states)
    given = points_of(model, "b", (-0.15, 0.1), "HB")
    given += points_of(model.replace(b=0.02), "m", (-0.3, 0.1), "HB")
    found = sf.locus(given, ("m", "b"), ((-0.35, 0.1), (-0.15, 0.1)))
    _, other = of_type(found, "HB", "equilibrium")  # its images have none of their own
    assert other.values[:, 1] == pytest.approx(0.5 * other.values[:, 0], abs=1e-9)
    points = [(p.values, p.coefficients) for x in found.loci[:2] for p in x.special]
    double_zero = pytest.approx((0, 0), abs=1e-9), pytest.approx({"c": -1, "d": -0.5})
    assert points == [double_zero] * 2


def test_what_is_found_in_both_directions_from_the_start_counts_once():
    # Folds at m = b^2/4: followed from the smallest m, where it also is a Bogdanov-Takens point.
    states = {"x": {"rate": "y", "start": -0.54}, "y": "m + b*x + x^2 - x*y"}
    model = sf.System(parameters={"m": -0.3, "b": 0.0}, states=states)
    (start,) = points_of(model, "m", (-0.3, 0.1), "LP", sf.Settings(largest_period=0))
    (locus,) = sf.locus(start, ("m", "b"), ((-0.5, 0.5), (-0.5, 0.5)), switch=False).loci
    assert sorted(point.type for point in locus.special) == ["BT", "MIN"]
