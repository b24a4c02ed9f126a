"""Normal forms of the stroboscopic map: whether a bifurcation is soft or hard.

Formulas of Kuznetsov, Elements of Applied Bifurcation Theory, 3rd edition, section 5.4.2, and
Kuznetsov and Meijer, SIAM J. Sci. Comput. 26 (2005) 1932-1954, with the map's derivatives
``B(u, v)`` and ``C(u, v, w)`` from Taylor jets of the flow along directions.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slipfold.branches.point import Point
from slipfold.flow.flow import Constants
from slipfold.orbits.boundary_value_problem import PeriodicProblem
from slipfold.orbits.shooting import Shooting

__all__ = ["StroboscopicMap", "critical_coefficient", "criticality_of", "normal_form"]

Array = NDArray[np.float64]
Vector = NDArray[Any]


class StroboscopicMap:
    """Derivatives of the map over one period of an orbit, in scaled states.

    Parameters
    ----------
    problem
        How the orbit is described.
    z
        The orbit.
    constants
        Coefficients of the flow there.
    scales
        Scales of the states; those of the problem if None.
    """

    def __init__(
        self, problem: Shooting, z: Array, constants: Constants, scales: Array | None = None
    ) -> None:
        self._flow = problem.flow
        self._state = problem.nodes(z)[0]
        self._constants = constants
        self._scales = problem.scales if scales is None else scales
        self.rescaling = problem.scales / self._scales
        self._start = problem.phase
        self._end = problem.phase + problem.period

    def rescaled(self, monodromy: Array) -> Array:
        """Return a monodromy matrix in the map's scales.

        Parameters
        ----------
        monodromy
            In the scales of the boundary-value problem, shape (n, n).
        """
        return monodromy * self.rescaling[:, None] / self.rescaling

    def powers(self, directions: Array) -> tuple[Array, Array]:
        """Return B(v, v) and C(v, v, v) for real directions.

        Parameters
        ----------
        directions
            Shape (m, n).

        Returns
        -------
        second, third : ndarray, shape (m, n)
            The forms.
        """
        jets = self._flow.jet(
            self._state, self._start, self._end, self._constants, directions * self._scales
        )
        return jets[:, 1] / self._scales, jets[:, 2] / self._scales

    def second(self, pairs: list[tuple[Vector, Vector]]) -> list[Vector]:
        """Return B(u, v) for complex vectors, by polarisation.

        Parameters
        ----------
        pairs
            Vectors of shape (n,).
        """
        parts = [
            (place, factor, left, right)
            for place, (u, v) in enumerate(pairs)
            for factor, left, right in (
                (1, u.real, v.real),
                (-1, u.imag, v.imag),
                (1j, u.real, v.imag),
                (1j, u.imag, v.real),
            )
            if left.any() and right.any()
        ]
        result = [np.zeros(len(self._scales), dtype=complex) for _ in pairs]
        if not parts:  # a symmetric orbit has no quadratic terms
            return result
        sizes = [(np.linalg.norm(left), np.linalg.norm(right)) for _, _, left, right in parts]
        sums = [
            left / a + sign * right / b
            for (_, _, left, right), (a, b) in zip(parts, sizes, strict=True)
            for sign in (1, -1)
        ]
        squares = self.powers(np.array(sums))[0]
        for i, ((place, factor, _, _), (a, b)) in enumerate(zip(parts, sizes, strict=True)):
            result[place] += factor * a * b / 4 * (squares[2 * i] - squares[2 * i + 1])
        return result


def normal_form(problem: PeriodicProblem, point: Point, kind: str) -> tuple[float, str | None]:
    """Return the coefficient of a bifurcation's normal form and its criticality.

    Parameters
    ----------
    problem
        The boundary-value problem.
    point
        The located orbit.
    kind
        ``"PD"``, ``"NS"`` or ``"LP"``.

    Returns
    -------
    coefficient : float
        Of the map's normal form, with eigenvectors of unit length in scaled states: cubic b of
        PD, real part d of NS, quadratic a of LP. The eigenvector of LP points where the orbit
        moves as the parameter grows: with a < 0 the two orbits exist above the fold's value of
        the parameter, with a > 0 below it.
    criticality : str or None
        ``"supercritical"`` or ``"subcritical"`` for PD (b > 0, b < 0) and NS (d < 0, d > 0).
    """
    # The orbit's own scales: those of a branch in f are the scales where it began, and a
    # coefficient must not depend on that.
    own = problem.model.replace(**{problem.vary: problem.value(point.z)}).state_scales()
    map_ = StroboscopicMap(problem, point.z, problem.constants(point.z), own)
    matrix = map_.rescaled(point.monodromy)
    if kind == "LP":
        pull = _parameter_pull(problem, point) * map_.rescaling
        return _fold(map_, matrix, pull), None
    coefficient = critical_coefficient(map_, matrix, kind)
    return coefficient, criticality_of(kind, coefficient)


def critical_coefficient(map_: StroboscopicMap, monodromy: Array, kind: str) -> float:
    """Return the coefficient that tells soft from hard.

    Parameters
    ----------
    map_
        The map.
    monodromy
        Monodromy matrix in the map's scales, shape (n, n).
    kind
        ``"PD"`` or ``"NS"``.

    Raises
    ------
    numpy.linalg.LinAlgError
        Where a second multiplier is critical and there is no such coefficient.
    """
    return _FORMS[kind](map_, monodromy)


def criticality_of(kind: str, coefficient: float) -> str | None:
    """Return ``"supercritical"`` or ``"subcritical"``; None where it is not defined.

    Parameters
    ----------
    kind
        ``"LP"``, ``"PD"`` or ``"NS"``.
    coefficient
        Of its normal form.
    """
    if kind == "LP" or not np.isfinite(coefficient):
        return None
    soft = coefficient > 0 if kind == "PD" else coefficient < 0
    return "supercritical" if soft else "subcritical"


def _parameter_pull(problem: PeriodicProblem, point: Point) -> Array:
    """Derivative of the map with respect to the parameter, in the problem's scaled states."""
    linearisation = problem.linearise(point.z)
    pull = np.zeros(linearisation.along.shape[1])
    for block, along in zip(linearisation.blocks, linearisation.along[:, :, 0], strict=True):
        pull = block @ pull + along
    return pull


def _fold(map_: StroboscopicMap, matrix: Array, pull: Array) -> float:
    q, p, _ = _critical_vectors(matrix, lambda values: np.abs(values - 1))
    second, _ = map_.powers(q.real[None])
    return float(0.5 * (p.real @ second[0]) * np.sign(p.real @ pull))


def _doubling(map_: StroboscopicMap, matrix: Array) -> float:
    q, p, _ = _critical_vectors(matrix, lambda values: np.abs(values + 1))
    second, third = map_.powers(q.real[None])
    bent = np.linalg.solve(np.eye(len(q)) - matrix, second[0])
    (mixed,) = map_.second([(q, bent.astype(complex))])
    return float(p.real @ (third[0] + 3 * mixed.real) / 6)


def _torus(map_: StroboscopicMap, matrix: Array) -> float:
    q, p, value = _critical_vectors(
        matrix, lambda values: np.where(values.imag > 0, np.abs(np.abs(values) - 1), np.inf)
    )
    a, b = q.real, q.imag
    second, third = map_.powers(np.array([a, b, a + b, a - b]))
    aa, bb = second[0], second[1]
    ab = (second[2] - second[3]) / 4
    aaa, bbb = third[0], third[1]
    aab = (third[2] - third[3]) / 6 - bbb / 3
    abb = (third[2] + third[3]) / 6 - aaa / 3
    cubic = aaa + abb + 1j * (aab + bbb)  # C(q, q, conj q)
    identity = np.eye(len(a))
    still = np.linalg.solve(identity - matrix, aa + bb).astype(complex)
    double = np.linalg.solve(value**2 * identity - matrix, aa - bb + 2j * ab).astype(complex)
    with_still, with_double = map_.second([(q, still), (q.conj(), double)])
    inner = np.vdot(p, cubic + 2 * with_still + with_double)
    return float(0.5 * (value.conjugate() / abs(value) * inner).real)


_FORMS: dict[str, Callable[[StroboscopicMap, Array], float]] = {
    "PD": _doubling,
    "NS": _torus,
}


def _critical_vectors(
    matrix: Array, distance: Callable[[Vector], Array]
) -> tuple[Vector, Vector, complex]:
    """Right eigenvector of unit length, left one with <p, q> = 1, and their eigenvalue."""
    values, vectors = np.linalg.eig(matrix)
    index = int(np.argmin(distance(values)))
    value, q = complex(values[index]), vectors[:, index].astype(complex)
    # A real eigenvector is returned real; a complex one with orthogonal real and imaginary parts.
    q = q * np.exp(-0.5j * np.angle(np.sum(q * q)))
    q /= np.linalg.norm(q)
    others, left = np.linalg.eig(matrix.T)
    p = left[:, np.argmin(np.abs(others - value))].astype(complex).conj()
    return q, p / np.vdot(q, p), value
