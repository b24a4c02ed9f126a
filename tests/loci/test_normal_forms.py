"""Coefficients at points of codimension two, of normal forms disguised by a change of coordinates.

The coefficients are those of the form itself but for the length of the critical vectors, which
are of unit length in the coordinates that are seen, and for their sign.
"""

import numpy as np
import pytest
from scipy.linalg import block_diag

from helpers.polynomial_map import DisguisedMap, times
from slipfold.orbits.normal_forms.codimension_two import codimension_two_coefficients
from slipfold.orbits.normal_forms.normal_form import critical_vectors, quintic_coefficient

SEEDS = range(4)
STABLE = np.array([0.4, -0.7])


def disguised(form, critical, seed):
    """The map of a form in its critical coordinates, and the lengths of their vectors."""
    rng = np.random.default_rng(seed)
    k = len(critical)

    def whole(w):
        rest = [factor * item for factor, item in zip(STABLE, w[k:], strict=True)]
        # Besides, critical and stable coordinates act on each other where no form forbids it.
        rest[0] = rest[0] + 0.6 * times(w[0], w[-1])
        return [*form(w[:k]), *rest]

    return DisguisedMap(whole, block_diag(critical, np.diag(STABLE)), rng)


def length(map_, column):
    return np.linalg.norm(map_.basis[:, column])


def pair_length(map_, column):
    """Length of the complex vector t of y = z t + conj(z t) with z = u + i v."""
    u, v = map_.basis[:, column], map_.basis[:, column + 1]
    return np.linalg.norm((u - 1j * v) / 2)


def coefficients(map_, kind):
    return codimension_two_coefficients(map_, map_.matrix, kind)


def same_but_for_sign(found, expected, odd):
    """Compare; the coefficients named change their signs together with the critical vector."""
    assert set(found) == set(expected)
    sign = np.sign(found[odd[0]] * expected[odd[0]])
    for name, value in expected.items():
        factor = sign if name in odd else 1.0
        assert factor * found[name] == pytest.approx(value, rel=1e-8)


def cube(w):
    return times(times(w, w), w)


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("c", [0.8, -1.7])
def test_cusp(seed, c):
    map_ = disguised(lambda w: [w[0] + c * cube(w[0])], np.eye(1), seed)
    assert coefficients(map_, "CPC") == pytest.approx({"c": c / length(map_, 0) ** 2}, rel=1e-8)


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize(("a", "b"), [(0.7, 1.3), (-0.4, 0.9)])
def test_first_resonance(seed, a, b):
    def form(w):
        return [w[0] + w[1], w[1] + a * times(w[0], w[0]) + b * times(w[0], w[1])]

    map_ = disguised(form, np.array([[1.0, 1.0], [0.0, 1.0]]), seed)
    size = length(map_, 0)
    found = coefficients(map_, "R1")
    same_but_for_sign(found, {"a": a / size, "b": b / size}, ("a", "b"))


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize(("c", "d"), [(0.7, 1.3), (-0.4, 0.9), (1.1, -2.0)])
def test_second_resonance(seed, c, d):
    def form(w):
        square = times(w[0], w[0])
        return [-w[0] + w[1], -w[1] + c * times(square, w[0]) + d * times(square, w[1])]

    map_ = disguised(form, np.array([[-1.0, 1.0], [0.0, -1.0]]), seed)
    size = length(map_, 0) ** 2
    expected = {"c": c / size, "d": d / size}
    assert coefficients(map_, "R2") == pytest.approx(expected, rel=1e-8)


def rotation(value):
    return np.array([[value.real, -value.imag], [value.imag, value.real]])


def complex_form(function):
    """Coordinates u, v of z = u + i v under a map of z and its conjugate."""

    def form(w):
        z = w[0] + 1j * w[1]
        image = function(z, z.conj())
        return [image.real, image.imag]

    return form


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize(("b", "c"), [(0.8 - 0.3j, 0.5 + 0.7j), (0.2j, -1.1 + 0.4j)])
def test_third_resonance(seed, b, c):
    value = np.exp(2j * np.pi / 3)
    form = complex_form(
        lambda z, bar: value * z + b * times(bar, bar) + c * times(times(z, z), bar)
    )
    map_ = disguised(form, rotation(value), seed)
    size = pair_length(map_, 0)
    expected = {"b": abs(b) / size, "c": (c / value).real / size**2}
    assert coefficients(map_, "R3") == pytest.approx(expected, rel=1e-8)


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize(("c", "d"), [(0.9 + 0.2j, 0.5j), (-0.3 + 1.4j, 0.7 - 0.6j)])
def test_fourth_resonance(seed, c, d):
    form = complex_form(lambda z, bar: 1j * z + c * times(times(z, z), bar) + d * cube(bar))
    ratio = -1j * c / abs(d)
    map_ = disguised(form, rotation(1j), seed)
    expected = {"a": ratio.real, "b": ratio.imag}
    assert coefficients(map_, "R4") == pytest.approx(expected, rel=1e-8)


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize(("a", "b", "e"), [(0.6, -1.2, 0.9), (-0.5, -0.4, 1.5)])
def test_fold_flip(seed, a, b, e):
    def form(w):
        first = w[0] + a * times(w[0], w[0]) + b * times(w[1], w[1])
        return [first, -w[1] + e * times(w[0], w[1])]

    map_ = disguised(form, np.diag([1.0, -1.0]), seed)
    fold, flip = length(map_, 0), length(map_, 1)
    expected = {"a": a / fold, "b": b * fold / flip**2, "e": e / fold}
    same_but_for_sign(coefficients(map_, "LPPD"), expected, ("a", "b", "e"))


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize(("a", "b", "e"), [(0.6, -1.2, 0.9 + 0.4j), (-0.5, 0.8, -1.1j)])
def test_fold_and_torus(seed, a, b, e):
    value = np.exp(0.9j)

    def form(w):
        z = w[1] + 1j * w[2]
        image = value * z + e * times(w[0].astype(complex), z)
        first = w[0] + a * times(w[0], w[0]) + b * times(z, z.conj()).real
        return [first, image.real, image.imag]

    map_ = disguised(form, block_diag(1.0, rotation(value)), seed)
    fold, pair = length(map_, 0), pair_length(map_, 1)
    expected = {"a": a / fold, "b": b * fold / pair**2, "e": (e / value).real / fold}
    same_but_for_sign(coefficients(map_, "LPNS"), expected, ("a", "b", "e"))


@pytest.mark.parametrize("kind", ["CH", "PDNS", "NSNS", "MIN"])
def test_no_coefficients_where_none_are_defined(kind):
    map_ = disguised(lambda w: [w[0]], np.eye(1), 0)
    assert coefficients(map_, kind) == {}


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("e", [0.8, -1.7])
def test_generalized_period_doubling(seed, e):
    def form(w):
        return [-w[0] + e * times(cube(w[0]), times(w[0], w[0]))]

    map_ = disguised(form, [[-1.0]], seed)
    expected = e / length(map_, 0) ** 4
    assert quintic_coefficient(map_, map_.matrix) == pytest.approx(expected, rel=1e-8)


def test_a_double_eigenvalue_with_one_eigenvector_is_no_warning():
    # As at a Bogdanov-Takens point, where the other product of vectors is exactly zero.
    q, *_ = critical_vectors(np.array([[0.0, 1.0], [0.0, 0.0]]), np.abs)
    assert np.linalg.norm(q) == pytest.approx(1)
