"""Functions of multipliers that vanish at a bifurcation, and derivatives of those of a matrix."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from math import sqrt
from typing import Any

import numpy as np

from slipfold.arrays import Array, Complex, Indices, Mask
from slipfold.orbits.bifurcation_types import BIFURCATION_TYPES, PAIRED
from slipfold.text import NEUTRAL


def floquet_multipliers(monodromy: Array) -> Complex:
    """Return the multipliers, largest modulus first, the upper one of a pair before the lower.

    Shapes: monodromy (..., n, n); returns (..., n).
    """
    values = np.linalg.eigvals(monodromy).astype(complex)
    # Moduli of a pair differ by rounding: compared to twelve digits, pairs stay together.
    modulus = np.abs(values)
    modulus = (modulus / modulus.max(axis=-1, keepdims=True, initial=1e-300)).round(12)
    order = np.lexsort((values.imag, values.real, modulus), axis=-1)[..., ::-1]
    # One set of multipliers is indexed in a tenth of the time.
    return values[order] if values.ndim == 1 else np.take_along_axis(values, order, axis=-1)


def match_multipliers(values: Complex, others: Complex) -> Complex:
    """Return `others` in the order in which they lie nearest `values`.

    Shapes: values, others (n,).
    """
    distance = np.abs(values[:, None] - others[None, :])
    result = np.empty_like(others)
    for _ in values:  # nearest pairs first
        i, j = np.unravel_index(distance.argmin(), distance.shape)
        result[i] = others[j]
        distance[i, :] = np.inf
        distance[:, j] = np.inf
    return result


ORBIT_TESTS = ("PD", "fold", "NS")
"""The test functions of `PRODUCTS` that are monitored along branches of periodic orbits."""

ALIKE = 1e-6
"""Multipliers this near to each other are one that is there more than once."""

SHRUNK = 0.25
"""A product of factors 1 - p is compared with that of 1 - SHRUNK p. Nearer to one, functions turn
less where multipliers far inside the circle do, but give less warning before one is on it."""


def evaluate_tests(
    multipliers: Complex, names: tuple[str, ...] = ORBIT_TESTS, standing: Standing | None = None
) -> dict[str, float]:
    r"""Evaluate the test functions of period doubling, folds and tori.

    ``PD`` has the zeros of det(I + M), ``fold`` those of det(I - M), at folds and branch points
    alike, ``NS`` those of the determinant of I - M (.) M with the bialternate product, the product
    of all :math:`1 - \mu_i \mu_j`: zero at a Neimark-Sacker point and at a neutral saddle, which
    is none (Kuznetsov, Elements of Applied Bifurcation Theory, section 10.2). Of equilibria it is
    called ``HB``.

    Each is :math:`N / \sqrt{N^2 + D^2}`, with the same determinant D of a matrix whose multipliers,
    or their products, are a quarter as large. It is smooth, stays between -1 and 1, and changes
    little where multipliers well inside the circle turn; N alone varies by orders of magnitude.
    What stands is left out.

    Shapes: multipliers (n,).

    >>> evaluate_tests(np.array([-1.0, 0.5]))["PD"]
    0.0
    """
    if standing is not None:
        left = {name: multipliers[standing.left(name, multipliers)] for name in names}
        return {name: float(evaluate_each(own, (name,))[0]) for name, own in left.items()}
    return dict(zip(names, evaluate_each(multipliers, names).tolist(), strict=True))


def evaluate_each(multipliers: Complex, names: tuple[str, ...] = ORBIT_TESTS) -> Array:
    """Evaluate the test functions of several orbits.

    Shapes: multipliers (..., n); returns (..., names).
    """
    none = np.zeros((*multipliers.shape[:-1], 1))  # changes nothing, but no group is empty
    parts, begins, size = [], [], 0
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):  # of products beside a loop
        for name in names:
            begins.append(size)
            parts += [none, PRODUCTS[name](multipliers)]
            size += 1 + parts[-1].shape[-1]
        products = np.concatenate(parts, axis=-1)
        factors = 1 - products
        sizes = np.abs(factors)
        ratios = np.multiply.reduceat(sizes / np.abs(1 - SHRUNK * products), begins, axis=-1)
        turns = np.multiply.reduceat(factors / sizes, begins, axis=-1)
    vanish = np.minimum.reduceat(sizes, begins, axis=-1) == 0
    # Real products of 1 - p beside those of 1 - SHRUNK p, as sines of the angles between them.
    return np.where(vanish, 0.0, np.copysign(np.sin(np.arctan(ratios)), turns.real))


@cache
def _pairs(n: int) -> tuple[Indices, Indices]:
    return np.triu_indices(n, k=1)


def _of_two(multipliers: Complex) -> Complex:
    first, second = _pairs(multipliers.shape[-1])
    return multipliers[..., first] * multipliers[..., second]


PRODUCTS: dict[str, Callable[[Complex], Complex]] = {
    "PD": lambda multipliers: -multipliers,
    "fold": lambda multipliers: multipliers,
    "NS": _of_two,
    "HB": _of_two,
}
"""What is one at each bifurcation."""


@dataclass(frozen=True, eq=False)
class Standing:
    """Multipliers that stay on the unit circle along a part of a curve, as nothing damps a mode.

    A product over all would be zero there, or rounding, whatever the others do. Those at one, as in
    a family of orbits, are not among them: folds and branch points are found by the tangent. Both
    are given as they are at the two ends of the part.
    """

    turning: Complex  # all, shape (2, k)
    flipping: Complex  # those that stay at -1, shape (2, l)
    within: float  # the distance from their places that is rounding

    @staticmethod
    def between(ends: tuple[Complex, Complex], within: float) -> Standing | None:
        """Return what stands at both ends, None if nothing does. Shapes: ends (n,)."""
        on = [values[are_neutral(values, within)] for values in ends]
        if not all(map(len, on)):
            return None
        flips = [values[np.abs(values + 1) <= within] for values in on]
        return Standing(_common(*on), _common(*flips), within)

    def left(self, name: str, multipliers: Complex) -> Indices:
        """Return the places of what a test function is made of. Shapes: multipliers (n,)."""
        known = {"PD": self.flipping, "LP": NOTHING, "BP": NOTHING, "fold": NOTHING}
        return self._without(known.get(name, self.turning), multipliers)

    @staticmethod
    def beside(multiplier: complex, multipliers: Complex) -> Standing | None:
        """Return what stands besides a critical pair, of a point that was located."""
        pair = np.array([multiplier, np.conj(multiplier)])
        others = np.delete(multipliers, np.abs(multipliers[:, None] - pair).argmin(axis=0))
        return Standing.between((others, others), ALIKE)

    def moved(self, multipliers: Complex) -> Standing | None:
        """Return the same as they are at a point; None where they hardly moved on the way there."""
        left = self.moving(multipliers)
        own = match_multipliers(self.turning[0], np.delete(multipliers, left))
        gap = np.abs(multipliers[left, None] - own).min(initial=1.0)
        if np.abs(own - self.turning[0]).max() < DRIFT * gap:
            return None
        return Standing(np.array([own, own]), self.flipping, self.within)

    def moving(self, multipliers: Complex) -> Indices:
        """Return the places of all that do not stand. Shapes: multipliers (n,)."""
        return self._without(self.turning, multipliers)

    def _without(self, known: Complex, multipliers: Complex) -> Indices:
        """Leave out those nearest to known ones. What crosses the circle is on it at one place."""
        left = np.arange(len(multipliers))
        off = np.maximum(np.abs(np.abs(multipliers) - 1), self.within)
        for ends in known.T:
            distance = np.abs(multipliers[left] - ends[:, None]).min(axis=0)
            left = np.delete(left, np.lexsort((distance, off[left]))[0])
        return left


def reciprocal_sums(multipliers: Complex, within: float = ALIKE) -> Complex:
    r"""Return :math:`\mu + 1/\mu` of the multipliers that come in pairs :math:`\mu, 1/\mu`.

    So do all of a reversible or a Hamiltonian system. Shapes: multipliers (n,), returns (k,).

    >>> reciprocal_sums(np.array([2.0, 0.9, 0.5]))
    array([2.5+0.j])
    """
    first, second = _pairs(len(multipliers))
    off, used, sums = np.abs(_of_two(multipliers) - 1), set[int](), list[complex]()
    for k in np.argsort(off)[: np.count_nonzero(off <= within)].tolist():
        if used.isdisjoint(pair := {int(first[k]), int(second[k])}):
            used |= pair
            sums.append(complex(multipliers[list(pair)].sum()))
    return np.array(sums, dtype=complex)


DRIFT = 0.1
"""Part of the gap to others by which multipliers that stand may move before it is noted where."""

NOTHING: Complex = np.empty((2, 0), dtype=complex)
"""No multipliers at either end."""


def are_neutral(multipliers: Complex, within: float = NEUTRAL) -> Mask:
    """Whether each is on the unit circle, as where nothing damps, not at one. Any shape."""
    off, away = np.abs(np.abs(multipliers) - 1), np.abs(multipliers - 1)
    return np.asarray((off <= within) & (away > ALIKE))


def _common(first: Complex, last: Complex) -> Complex:
    """Return the multipliers that are at both of two ends, as at each of them; shape (2, k)."""
    few, many = sorted((first, last), key=len)
    return np.array([few, match_multipliers(few, many)[: len(few)]])


@dataclass(frozen=True, eq=False)
class Degeneracy:
    r"""A number that is zero at a bifurcation, with its derivative."""

    value: float  # smooth function g of the matrix
    # Vectors with :math:`dg = \sum_i p_i^T \, dM \, q_i` where g is zero, each of shape (r, n)
    left: Array
    right: Array

    def propagated(self, blocks: Array) -> tuple[Array, Array]:
        """Propagate the r vectors to the start of each factor of the matrix and back to each end.

        With :math:`M = A_{m-1} ... A_0` a term :math:`p^T dM q` is the sum over the factors of
        :math:`p_j^T dA_j q_j`.

        Shapes: blocks (m, n, n); returns forward q_j, backward p_j (r, m, n).
        """
        forward, backward = [self.right], [self.left]
        for block in blocks[:-1]:
            forward.append(forward[-1] @ block.T)
        for block in blocks[:0:-1]:
            backward.append(backward[-1] @ block)
        return np.array(forward).swapaxes(0, 1), np.array(backward[::-1]).swapaxes(0, 1)


UNKNOWN = Degeneracy(np.nan, np.empty((0, 0)), np.empty((0, 0)))
"""Of a matrix that could not be computed, or has no pair."""


def degeneracy(kind: str, monodromy: Array, pair: tuple[int, int] | None = None) -> Degeneracy:
    r"""Measure how far a matrix is from having a critical multiplier.

    LP and PD: the smallest singular value of :math:`M \mp I`, with the sign of the determinant,
    which makes it smooth. It is the number g of the bordered system

    .. math:: \begin{pmatrix} M \mp I & p \\ q^T & 0 \end{pmatrix}
              \begin{pmatrix} v \\ -g \end{pmatrix} = \begin{pmatrix} 0 \\ 1 \end{pmatrix}

    with the best borders there are, the singular vectors p and q (Kuznetsov, Elements of Applied
    Bifurcation Theory, section 10.3: minimally augmented systems). NS: the product of the critical
    pair less one, from the matrix restricted to the plane of the pair, so that it stays smooth
    where the pair meets on the real axis (R1, R2). HB: the same of an equilibrium. All are divided
    by the size of the matrix. The pair is the critical one if its places are not given.

    Shapes: monodromy (n, n).
    """
    of_a_pair = kind in PAIRED
    found = _pair_degeneracy(monodromy, pair) if of_a_pair else _real_degeneracy(kind, monodromy)
    if found is UNKNOWN:
        return found
    # The matrix is known to a fraction of its largest entry, and so is the number.
    size = sqrt(1 + np.vdot(monodromy, monodromy))
    return Degeneracy(found.value / size, found.left / size, found.right)


def collision(monodromy: Array) -> Degeneracy:
    r"""Measure how far the two pairs next to each other on the unit circle are from meeting.

    With the trace and the determinant of the matrix on the plane of their upper multipliers,

    .. math:: g = 4 - t^2 / d = -(\mu_1 - \mu_2)^2 / (\mu_1 \mu_2)

    is real: for :math:`\mu_{1,2} = e^{i(a \pm b)}`, :math:`4 \sin^2 b`. The plane is smooth
    where they meet, unlike either of them.

    Shapes: monodromy (n, n).
    """
    multipliers = floquet_multipliers(monodromy)
    upper = multipliers[multipliers.imag > 0]
    first, second = _pairs(len(upper))
    a, b = upper[first], upper[second]
    if not len(a):
        return UNKNOWN
    # Both lie on the circle, or they are images of each other in it: of several, the next two.
    images = np.abs(np.abs(a * b) - 1) < ALIKE
    nearest = int(np.where(images, np.abs(a - b), np.inf).argmin())
    restricted, dual, basis = _on_plane(monodromy, a[nearest] + b[nearest], a[nearest] * b[nearest])
    trace, determinant = np.trace(restricted), np.linalg.det(restricted)
    value = 4 - trace**2 / determinant
    # The derivatives of trace and determinant by the matrix on the plane.
    by_entries = (trace * np.linalg.inv(restricted) - 2 * np.eye(2)) * trace / determinant
    rows, columns = by_entries @ dual, basis.T
    size = sqrt(1 + np.vdot(monodromy, monodromy))
    left, right = np.vstack([rows.real, -rows.imag]), np.vstack([columns.real, columns.imag])
    return Degeneracy(float(value.real) / size, left / size, right)


def critical_pair(multipliers: Complex) -> tuple[int, int] | None:
    """Return the places of the two multipliers whose product is nearest to one.

    Complex pairs count, and real ones that lie together as two that just met do.

    Shapes: multipliers (n,).
    """
    first, second = np.triu_indices(len(multipliers), k=1)
    a, b = multipliers[first], multipliers[second]
    real = (a.imag == 0) & (b.imag == 0)
    # Two that were complex a step before lie no farther apart.
    possible = np.where(real, np.abs(a - b) < 0.5, a == b.conj())
    if not possible.any():
        return None
    distance = np.where(possible, np.abs(1 - a * b), np.inf)
    nearest = int(distance.argmin())
    return int(first[nearest]), int(second[nearest])


def angles_on_circle(multipliers: Complex) -> Array:
    """Return the angles of the complex pairs on the unit circle, one a pair.

    Two that meet are known to the root of rounding, others to rounding.

    Shapes: multipliers (n,).
    """
    upper = multipliers[multipliers.imag > ALIKE]
    off, gaps = np.abs(np.abs(upper) - 1), np.abs(np.subtract.outer(upper, upper))
    meets = np.count_nonzero(gaps < ALIKE, axis=1) > 1
    return np.angle(upper[(off <= NEUTRAL) | (meets & (off < ALIKE))])


def critical_places(kind: str, multipliers: Complex, standing: Standing | None = None) -> Indices:
    """Return the places of the multipliers that make an orbit critical, none of what stands.

    Shapes: multipliers (n,).
    """
    if standing is not None:
        left = standing.left(kind, multipliers)
        return left[critical_places(kind, multipliers[left])]
    if kind in PAIRED:
        return np.array(critical_pair(multipliers) or (), dtype=np.int64)
    if kind not in BIFURCATION_TYPES:
        return np.empty(0, dtype=np.int64)
    target = BIFURCATION_TYPES[kind].critical
    return np.array([np.abs(multipliers - target).argmin()], dtype=np.int64)


def others_of(kind: str, multipliers: Complex, standing: Standing | None = None) -> Indices:
    """Return the places of what neither makes an orbit critical nor stands, in their order."""
    every = np.arange(len(multipliers))
    moving = every if standing is None else standing.moving(multipliers)
    return np.setdiff1d(moving, critical_places(kind, multipliers, standing))


def _real_degeneracy(kind: str, monodromy: Array) -> Degeneracy:
    shift = -1.0 if kind == "LP" else 1.0
    matrix = monodromy + shift * np.eye(len(monodromy))
    left, values, right = np.linalg.svd(matrix)
    sign = np.sign(np.linalg.det(left @ right))
    return Degeneracy(float(sign * values[-1]), sign * left[:, -1:].T, right[-1:])


def _pair_degeneracy(monodromy: Array, pair: tuple[int, int] | None) -> Degeneracy:
    multipliers = floquet_multipliers(monodromy)
    pair = pair or critical_pair(multipliers)
    if pair is None:
        return UNKNOWN
    total = (multipliers[pair[0]] + multipliers[pair[1]]).real
    product = (multipliers[pair[0]] * multipliers[pair[1]]).real
    restricted, dual, basis = _on_plane(monodromy, total, product)
    return Degeneracy(product - 1.0, product * np.linalg.inv(restricted) @ dual, basis.T)


def _on_plane(monodromy: Array, total: Any, product: Any) -> tuple[Any, Any, Any]:
    """Return a matrix on the plane of two multipliers, also where they coincide.

    With a basis of the plane and the rows that give a vector's part in it. Their sum and product
    say which two; complex ones give complex results. Shapes: (2, 2), rows (2, n), basis (n, 2).
    """
    # The quadratic polynomial of the two is singular on their plane.
    polynomial = monodromy @ monodromy - total * monodromy + product * np.eye(len(monodromy))
    u, _, v = np.linalg.svd(polynomial)
    left, basis = u[:, -2:].conj().T, v[-2:].conj().T
    dual = np.linalg.inv(left @ basis) @ left
    return dual @ monodromy @ basis, dual, basis
