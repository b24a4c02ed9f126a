"""Normal form coefficients at points of codimension two.

Formulas of Kuznetsov and Meijer, SIAM J. Sci. Comput. 26 (2005) 1932-1954, and Kuznetsov, Elements
of Applied Bifurcation Theory, 3rd edition, section 8.7 and chapter 9, with the derivatives
``B(u, v)`` and ``C(u, v, w)`` of the stroboscopic map, or of the vector field, in scaled states.
Eigenvectors have unit length.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from slipfold.arrays import Array
from slipfold.orbits.normal_forms.maps import FORMS, FieldMap, MapDerivatives, Vector
from slipfold.orbits.normal_forms.normal_form import (
    critical_vectors,
    hopf_vectors,
    pair_cubic,
    second_lyapunov_coefficient,
    third_form,
)

FORBIDDEN = 1e-8
"""Ratio of the resonant term to the other at 1:4, below which it is zero: rounding leaves 1e-11.

Where an orbit is its own mirror image half a period later, the multiplier of half a period is an
eighth root of one, and the term does not exist."""


def codimension_two_coefficients(
    map_: MapDerivatives, monodromy: Array, kind: str
) -> dict[str, float]:
    r"""Return the coefficients that decide what happens near a point of codimension two.

    Shapes: monodromy (n, n).
    """
    return _FORMS[kind](map_, monodromy) if kind in _FORMS else {}


# -- one critical multiplier -----------------------------------------------------------------------


def cusp_form(map_: MapDerivatives, singular: Array) -> dict[str, float]:
    """Return c of a cusp. Shapes: singular (n, n)."""
    q, p = eigenvectors(singular, 0.0)
    second, third = map_.powers(q.real[None])
    # The quadratic part has no component along q here; the border keeps it so.
    bent = _bordered_solve(-singular, p, q, second[0])
    (mixed,) = map_.second([(q, bent)])
    return {"c": float((p.conj() @ (third[0] + 3 * mixed)).real / 6)}


# -- a double multiplier ---------------------------------------------------------------------------


def double_form(map_: MapDerivatives, singular: Array) -> dict[str, float]:
    """Return a and b of the Bogdanov-Takens form. Shapes: singular (n, n)."""
    q0, q1, p0, p1 = _chain(singular)
    b00, b01 = map_.second([(q0, q0), (q0, q1)])
    return {"a": float((p0 @ b00).real / 2), "b": float((p0 @ b01 + p1 @ b00).real)}


def _second_resonance(map_: MapDerivatives, matrix: Array) -> dict[str, float]:
    identity = np.eye(len(matrix))
    return _odd_double_form(map_, matrix + identity, partial(np.linalg.solve, identity - matrix), 1)


def _odd_double_form(
    map_: MapDerivatives, singular: Array, solve: Callable[[Vector], Vector], sign: int
) -> dict[str, float]:
    """Return c and d of a double multiplier without quadratic terms.

    `solve` solves with what is not singular. Along a chain of a map an h20 is added, of a field
    subtracted. Shapes: singular (n, n).
    """
    q0, q1, p0, p1 = _chain(singular)
    b00, b01 = map_.second([(q0, q0), (q0, q1)])
    h20 = solve(b00)
    h11 = solve(b01 + sign * h20)
    with_h20, with_h11, other_h20 = map_.second([(q0, h20), (q0, h11), (q1, h20)])
    c000 = third_form(map_, q0, q0, q0) + 3 * with_h20
    c001 = third_form(map_, q0, q0, q1) + 2 * with_h11 + other_h20
    return {"c": float((p0 @ c000).real / 6), "d": float((p0 @ c001 + p1 @ c000).real / 2)}


# -- a pair ----------------------------------------------------------------------------------------


def _third_resonance(map_: MapDerivatives, matrix: Array) -> dict[str, float]:
    value = np.exp(2j * np.pi / 3)
    q, p = eigenvectors(matrix, value)
    qq, q_q, bar = map_.second([(q, q), (q, q.conj()), (q.conj(), q.conj())])
    quadratic = np.vdot(p, bar) / 2
    h11 = np.linalg.solve(np.eye(len(q)) - matrix, q_q)
    h20 = _bordered_solve(
        value**2 * np.eye(len(q)) - matrix, p.conj(), q.conj(), qq - 2 * quadratic.conj() * q.conj()
    )
    cubic = pair_cubic(map_, q, p, h11, h20)
    return {"b": float(abs(quadratic)), "c": float((cubic / value).real)}


def _fourth_resonance(map_: MapDerivatives, matrix: Array) -> dict[str, float]:
    q, p = eigenvectors(matrix, 1j)
    qq, q_q = map_.second([(q, q), (q, q.conj())])
    h11 = np.linalg.solve(np.eye(len(q)) - matrix, q_q)
    h20 = np.linalg.solve(-np.eye(len(q)) - matrix, qq)
    cubic = pair_cubic(map_, q, p, h11, h20)
    (with_h02,) = map_.second([(q.conj(), h20.conj())])
    bar = third_form(map_, q.conj(), q.conj(), q.conj()) + 3 * with_h02
    resonant = abs(np.vdot(p, bar) / 6)
    if resonant <= FORBIDDEN * abs(cubic):
        return {"d": float((cubic / 1j).real)}
    ratio = -1j * cubic / resonant
    return {"a": float(ratio.real), "b": float(ratio.imag)}


# -- two different multipliers ---------------------------------------------------------------------


def _fold_flip(map_: MapDerivatives, matrix: Array) -> dict[str, float]:
    (q1, p1), (q2, p2) = eigenvectors(matrix, 1.0), eigenvectors(matrix, -1.0)
    b11, b22, b12 = map_.second([(q1, q1), (q2, q2), (q1, q2)])
    return {
        "a": float(np.vdot(p1, b11).real / 2),
        "b": float(np.vdot(p1, b22).real / 2),
        "e": float(np.vdot(p2, b12).real),
    }


def _fold_torus(map_: MapDerivatives, matrix: Array) -> dict[str, float]:
    values = np.linalg.eigvals(matrix)
    upper = values[values.imag > 0]
    value = upper[np.abs(np.abs(upper) - 1).argmin()]
    (q0, p0), (q1, p1) = eigenvectors(matrix, 1.0), eigenvectors(matrix, complex(value))
    b00, b11, b01 = map_.second([(q0, q0), (q1, q1.conj()), (q0, q1)])
    return {
        "a": float(np.vdot(p0, b00).real / 2),
        "b": float(np.vdot(p0, b11).real),
        "e": float((np.vdot(p1, b01) / value).real),
    }


_FORMS: dict[str, Callable[[MapDerivatives, Array], dict[str, float]]] = {
    "CPC": lambda map_, matrix: cusp_form(map_, matrix - np.eye(len(matrix))),
    "R1": lambda map_, matrix: double_form(map_, matrix - np.eye(len(matrix))),
    "R2": _second_resonance,
    "R3": _third_resonance,
    "R4": _fourth_resonance,
    "LPPD": _fold_flip,
    "LPNS": _fold_torus,
}


# -- linear algebra --------------------------------------------------------------------------------


def eigenvectors(matrix: Array, value: complex) -> tuple[Vector, Vector]:
    """Return the eigenvectors of the eigenvalue nearest to a value.

    Shapes: matrix (n, n); returns q, p (n,).
    """
    q, p, _ = critical_vectors(matrix, lambda values: np.abs(values - value))
    return q, p


def _chain(shifted: Array) -> tuple[Vector, Vector, Vector, Vector]:
    """Eigenvectors and generalized ones of a double eigenvalue zero with one eigenvector.

    ``A q0 = 0, A q1 = q0`` and the same for the transpose with p0 and p1;
    ``<p0, q1> = <p1, q0> = 1`` and ``<p0, q0> = <p1, q1> = 0``.
    """
    left, _, right = np.linalg.svd(shifted)
    q0, p0 = right[-1], left[:, -1]
    q1 = _bordered_solve(shifted, p0, q0, q0).real
    p1 = _bordered_solve(shifted.T, q0, p0, p0).real
    scale = float(p0 @ q1)
    p0, p1 = p0 / scale, p1 / scale
    p1 = p1 - (p1 @ q1) * p0
    return q0.astype(complex), q1.astype(complex), p0.astype(complex), p1.astype(complex)


def _bordered_solve(singular: Vector, left: Vector, right: Vector, side: Vector) -> Vector:
    """Solve a singular system for the solution that has no component along the null vector."""
    n = len(side)
    matrix = np.zeros((n + 1, n + 1), dtype=complex)
    matrix[:n, :n] = singular
    matrix[:n, n] = right if np.iscomplexobj(left) else left
    matrix[n, :n] = left.conj() if np.iscomplexobj(left) else right
    return np.linalg.solve(matrix, np.append(side, 0.0))[:n].astype(complex)


def equilibrium_coefficients(field: FieldMap, kind: str) -> dict[str, float]:
    r"""Return the coefficients that decide what happens near a point of codimension two."""
    return _EQUILIBRIUM_FORMS[kind](field) if kind in _EQUILIBRIUM_FORMS else {}


def _bogdanov_takens(field: FieldMap) -> dict[str, float]:
    """Return the quadratic coefficients; where a symmetry leaves none, the cubic ones."""
    found, matrix = double_form(field, field.jacobian), field.jacobian
    if max(map(abs, found.values())) <= FORMS.symmetric:
        # x' = y and y' = c x^3 + d x^2 y; minimum-norm solutions have the symmetry.
        return _odd_double_form(field, matrix, lambda side: np.linalg.lstsq(-matrix, side)[0], -1)
    sign = -1.0 if found["a"] < 0 else 1.0
    return {name: sign * value for name, value in found.items()}


def _zero_hopf(field: FieldMap) -> dict[str, float]:
    """Return the quadratic coefficients; where a symmetry leaves none, the cubic ones."""
    matrix = field.jacobian
    q0, p0 = eigenvectors(matrix, 0.0)
    q1, p1, value = hopf_vectors(matrix)
    b00, b11, b01 = field.second([(q0, q0), (q1, q1.conj()), (q0, q1)])
    quadratic = {
        "a": float(np.vdot(p0, b00).real / 2),
        "b": float(np.vdot(p0, b11).real),
        "e": float(np.vdot(p1, b01).real),
    }
    if max(map(abs, quadratic.values())) > FORMS.symmetric:
        return quadratic
    # Of a symmetry: x' = p11 x^3 + p12 x |w|^2, w' = i omega w + p21 x^2 w + p22 w |w|^2.
    (b1_1,) = field.second([(q1, q1)])
    identity = np.eye(len(q0))
    h00, h11 = (_bordered_solve(-matrix, p0, q0, side) for side in (b00, b11))
    h01 = _bordered_solve(1j * value.imag * identity - matrix, p1, q1, b01)
    h1_1 = np.linalg.solve(2j * value.imag * identity - matrix, b1_1)
    mixed = field.second([(q0, h00), (q0, h11), (q1.conj(), h01), (q0, h01), (q1, h00)])
    of_x = third_form(field, q0, q0, q0) + 3 * mixed[0]
    by_pair = third_form(field, q0, q1, q1.conj()) + mixed[1] + 2 * mixed[2].real
    by_x = third_form(field, q0, q0, q1) + 2 * mixed[3] + mixed[4]
    return {
        "p11": float(np.vdot(p0, of_x).real / 6),
        "p12": float(np.vdot(p0, by_pair).real),
        "p21": float(np.vdot(p1, by_x).real / 2),
        "p22": pair_cubic(field, q1, p1, h11, h1_1).real,
    }


def _double_hopf(field: FieldMap) -> dict[str, float]:
    """Real parts of the cubic coefficients of both pairs, the faster one first (section 8.6)."""
    matrix, identity = field.jacobian, np.eye(len(field.jacobian))
    values = np.linalg.eigvals(matrix)
    upper = values[values.imag > 0]
    pairs = sorted(upper[np.abs(upper.real).argsort(kind="stable")[:2]], key=lambda w: -w.imag)
    (u, p), (v, r) = (eigenvectors(matrix, complex(value)) for value in pairs)
    first, second = (1j * value.imag for value in pairs)
    uu, vv, u_u, v_v, uv, u_v = field.second(
        [(u, u), (v, v), (u, u.conj()), (v, v.conj()), (u, v), (u, v.conj())]
    )

    def solved(value: complex, side: Vector) -> Vector:
        return np.linalg.solve(value * identity - matrix, side)

    still = solved(0, u_u), solved(0, v_v)
    both, apart = solved(first + second, uv), solved(first - second, u_v)
    mixed = field.second(
        [
            *((u, still[1]), (v, apart), (v.conj(), both)),
            *((v, still[0]), (u, apart.conj()), (u.conj(), both)),
        ]
    )
    by_other = third_form(field, u, v, v.conj()) + sum(mixed[:3])
    by_first = third_form(field, u, u.conj(), v) + sum(mixed[3:])
    return {
        "p11": pair_cubic(field, u, p, still[0], solved(2 * first, uu)).real,
        "p12": float(np.vdot(p, by_other).real),
        "p21": float(np.vdot(r, by_first).real),
        "p22": pair_cubic(field, v, r, still[1], solved(2 * second, vv)).real,
    }


_EQUILIBRIUM_FORMS: dict[str, Callable[[FieldMap], dict[str, float]]] = {
    "CP": lambda field: cusp_form(field, field.jacobian),
    "BT": _bogdanov_takens,
    "ZH": _zero_hopf,
    "HH": _double_hopf,
    "GH": lambda field: {"l2": second_lyapunov_coefficient(field)},
}
