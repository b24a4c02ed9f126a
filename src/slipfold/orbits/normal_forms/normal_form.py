"""Normal form coefficients of fixed points and equilibria where one parameter is critical."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.newton import Rule, correct_many, solve_each
from slipfold.orbits.bifurcation_types import BIFURCATION_TYPES, PAIRED
from slipfold.orbits.linearization import Linearization
from slipfold.orbits.normal_forms.maps import FieldMap, JetMap, ReturnChain, ReturnMap
from slipfold.orbits.orbit_curve import OrbitPoint, Orbits

Vector = NDArray[Any]

QUADRATIC = ("LP", "transcritical")
"""Kinds whose coefficient is of second order; the others are of third."""


MULTIPLIER_ERROR = 1e-3
"""Distance of the map's own critical multiplier from where it was located, beyond which growth on
the way round has taken the digits of the map, and of all that follows from it."""


class MapDerivatives(Protocol):
    """Second and third derivatives B and C of a map, in scaled states."""

    def rescaled(self, monodromy: Array) -> Array:
        """Return the map's matrix in its scales."""

    def powers(self, directions: Array) -> tuple[Array, Array]:
        """Return B(v, v) and C(v, v, v) for real directions, each of shape (r, n)."""

    def second(self, pairs: list[tuple[Vector, Vector]]) -> list[Vector]:
        """Return B(u, v) for complex vectors."""


def _distance(kind: str) -> Callable[[Vector], Array]:
    """Return the function of the multipliers that is smallest for the critical one."""
    if kind in PAIRED:
        return lambda values: np.where(values.imag > 0, np.abs(np.abs(values) - 1), np.inf)
    target = BIFURCATION_TYPES[kind if kind in BIFURCATION_TYPES else "BP"].critical
    return lambda values: np.abs(values - target)


def normal_form(orbits: Orbits, point: OrbitPoint, kind: str) -> tuple[float, str | None]:
    """Return the coefficient of a bifurcation's normal form and its criticality.

    An error of linear algebra says that the map is not known well enough.
    """
    linearization = point.linearization or orbits.linearize(point.z)
    map_: JetMap | ReturnMap = (
        ReturnMap(orbits, point.z, orbits.scales)
        if orbits.free_phase
        else JetMap(orbits, point.z, orbits.constants(point.z))
    )
    matrix = map_.rescaled(linearization.product)
    # Scales that were found, or are those where the branch began, must not be seen in it.
    ratios = orbits.scales / orbits.model_at(point.z).unit_scales()
    if not _distance(kind)(np.linalg.eigvals(matrix).astype(complex)).min() < MULTIPLIER_ERROR:
        if not orbits.free_phase or kind not in ("PD", "NS"):
            raise np.linalg.LinAlgError(f"the map has lost the multiplier of its {kind}")
        multipliers = orbits.multipliers(point)
        critical = complex(multipliers[np.argmin(_distance(kind)(multipliers))])
        chain = ReturnChain(orbits, point.z, orbits.scales)
        coefficient, size = chain.form(kind, critical, ratios)
        return normalized(kind, coefficient, size), criticality_of(kind, coefficient)
    if kind == "LP":
        coefficient = fold_coefficient(map_, matrix, map_.mapped(_parameter_pull(linearization)))
    else:
        coefficient = critical_coefficient(map_, matrix, kind)
    if isinstance(map_, ReturnMap):
        size = mean_length(map_, matrix, linearization.product, kind, ratios)
    else:
        size = critical_length(matrix, kind, ratios)
    return normalized(kind, coefficient, size), criticality_of(kind, coefficient)


def critical_length(matrix: Array, kind: str, ratios: Array) -> float:
    """Return the length of the unit critical vector in other scales.

    Shapes: matrix (n, n); ratios (n,).
    """
    return float(np.linalg.norm(critical_vectors(matrix, _distance(kind))[0] * ratios))


def normalized(kind: str, coefficient: float, size: float) -> float:
    """Return a coefficient for a critical vector so many times as long."""
    return coefficient / (size if kind in QUADRATIC else size**2)


def mean_length(map_: ReturnMap, matrix: Array, product: Array, kind: str, ratios: Array) -> float:
    """Return the root mean square, round a cycle, of its unit critical vector.

    Shapes: matrix (n - 1, n - 1); product (n, n); ratios (n,).
    """
    q, _, value = critical_vectors(matrix, _distance(kind))
    return map_.length(q, value, product, ratios)


def critical_coefficient(map_: MapDerivatives, monodromy: Array, kind: str) -> float:
    """Return the coefficient that tells soft from hard. Shapes: monodromy (n, n)."""
    return _FORMS[kind](map_, monodromy)


SYMMETRIC = 1e-7
"""Quadratic coefficients below this, in scaled states, are rounding: of a pitchfork."""

DEGENERATE = 1e-12
"""Coefficients below this, in scaled states, are rounding: neither soft nor hard."""


def criticality_of(kind: str, coefficient: float) -> str | None:
    """Return ``"supercritical"`` or ``"subcritical"``; None where it is not defined."""
    if kind in QUADRATIC or not abs(coefficient) > DEGENERATE:  # or it is not a number
        return None
    soft = BIFURCATION_TYPES[kind].soft if kind in BIFURCATION_TYPES else -1.0
    return "supercritical" if coefficient * soft > 0 else "subcritical"


def _parameter_pull(linearization: Linearization) -> Array:
    """Derivative of the map with respect to the parameter, in the orbits' scaled states."""
    pull = np.zeros(linearization.along.shape[1])
    for block, along in zip(linearization.blocks, linearization.along[:, :, -1], strict=True):
        pull = block @ pull + along
    return pull


def fold_coefficient(map_: MapDerivatives, matrix: Array, pull: Array) -> float:
    """Return the quadratic coefficient of a fold. Shapes: matrix (n, n); pull (n,)."""
    q, p, _ = critical_vectors(matrix, _distance("LP"))
    second, _ = map_.powers(q.real[None])
    return float(0.5 * (p.real @ second[0]) * np.sign(p.real @ pull))


def _transcritical(map_: MapDerivatives, matrix: Array) -> float:
    q, p, _ = critical_vectors(matrix, _distance("BP"))
    second, _ = map_.powers(q.real[None])
    return float(0.5 * (p.real @ second[0]))


def _pitchfork(map_: MapDerivatives, matrix: Array) -> float:
    """Cubic coefficient on the center manifold, where the quadratic one is zero by symmetry."""
    q, p, _ = critical_vectors(matrix, _distance("BP"))
    second, third = map_.powers(q.real[None])
    n = len(q)
    bordered = np.block([[np.eye(n) - matrix, p.real[:, None]], [p.real[None], np.zeros((1, 1))]])
    bent = np.linalg.solve(bordered, np.append(second[0], 0.0))[:n]
    (mixed,) = map_.second([(q, bent.astype(complex))])
    return float(p.real @ (third[0] + 3 * mixed.real) / 6)


def _crossing(map_: MapDerivatives, matrix: Array) -> float:
    """Cubic coefficient of a branch point if it is a pitchfork, NaN of a transcritical one."""
    return np.nan if abs(_transcritical(map_, matrix)) > SYMMETRIC else _pitchfork(map_, matrix)


def _doubling(map_: MapDerivatives, matrix: Array) -> float:
    q, p, _ = critical_vectors(matrix, _distance("PD"))
    second, third = map_.powers(q.real[None])
    bent = np.linalg.solve(np.eye(len(q)) - matrix, second[0])
    (mixed,) = map_.second([(q, bent.astype(complex))])
    return float(p.real @ (third[0] + 3 * mixed.real) / 6)


def _torus(map_: MapDerivatives, matrix: Array) -> float:
    q, p, value = critical_vectors(matrix, _distance("NS"))
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
    # 2 B(q, still) + B(conj q, double), of half as many products of real vectors.
    mixed = map_.second(
        [(a.astype(complex), 2 * still + double), (b.astype(complex), 1j * (2 * still - double))]
    )
    inner = np.vdot(p, cubic + sum(mixed))
    return float(0.5 * (value.conjugate() / abs(value) * inner).real)


_FORMS: dict[str, Callable[[MapDerivatives, Array], float]] = {
    "PD": _doubling,
    "NS": _torus,
    "BP": _crossing,
    "transcritical": _transcritical,
    "pitchfork": _pitchfork,
}


def critical_vectors(
    matrix: Array, distance: Callable[[Vector], Array]
) -> tuple[Vector, Vector, complex]:
    """Return the eigenvectors of the eigenvalue that lies nearest to where it should.

    Shapes: matrix (n, n); distance (n,); returns q, p (n,).
    """
    values, vectors = np.linalg.eig(matrix)
    index = int(np.argmin(distance(values)))
    value, q = complex(values[index]), vectors[:, index].astype(complex)
    # A real eigenvector is returned real; a complex one with orthogonal real and imaginary parts.
    q = q * np.exp(-0.5j * np.angle(np.sum(q * q)))
    q /= np.linalg.norm(q)
    others, left = np.linalg.eig(matrix.T)
    p = left[:, np.argmin(np.abs(others - value))].astype(complex).conj()
    return q, p / np.vdot(q, p), value


def pair_cubic(map_: MapDerivatives, q: Vector, p: Vector, h11: Vector, h20: Vector) -> complex:
    """Return the cubic coefficient of a pair. Shapes: h11, h20 (n,)."""
    with_h11, with_h20 = map_.second([(q, h11), (q.conj(), h20)])
    inner = third_form(map_, q, q, q.conj()) + 2 * with_h11 + with_h20
    return complex(np.vdot(p, inner) / 2)


def third_form(map_: MapDerivatives, u: Vector, v: Vector, w: Vector) -> Vector:
    """Return C(u, v, w) for complex vectors, by polarization of the cubic form."""
    result = np.zeros(len(u), dtype=complex)
    parts = [
        (factor_u * factor_v * factor_w, a, b, c)
        for factor_u, a in ((1, u.real), (1j, u.imag))
        for factor_v, b in ((1, v.real), (1j, v.imag))
        for factor_w, c in ((1, w.real), (1j, w.imag))
        if a.any() and b.any() and c.any()
    ]
    sums = [a + s * b + t * c for _, a, b, c in parts for s in (1, -1) for t in (1, -1)]
    cubes = map_.powers(np.array(sums))[1]
    for i, (factor, *_) in enumerate(parts):
        plus_plus, plus_minus, minus_plus, minus_minus = cubes[4 * i : 4 * i + 4]
        result += factor / 24 * (plus_plus - plus_minus - minus_plus + minus_minus)
    return result


AMPLITUDES = 0.05 / 2.0 ** np.arange(6)
"""Largest amplitudes of successive evaluations, in scaled states: the higher powers fade, until
rounding takes over."""

FRACTIONS = np.array([0.55, 0.7, 0.85, 1.0])
"""Amplitudes of one evaluation, over the largest."""

AGREEMENT = 1e-2
"""Share by which the two that agree best may differ."""

TIMES = 17
"""Times of a cycle: eight harmonics of amplitudes up to 0.05 leave 1e-12."""

LARGEST = 1500
"""Unknowns up to which equations round a cycle are solved densely."""

RULE = Rule(close=1e-12, iterations=12)


def quintic_coefficient(orbits: Orbits, point: OrbitPoint, scales: Array) -> float | None:
    r"""Return e of the normal form :math:`\eta \to -\eta + b \eta^3 + e \eta^5` where b is zero.

    An orbit of twice the period with the amplitude a along the critical vector q exists if the map
    is shifted by :math:`\tau q` in one period and by :math:`-\tau q` in the next, with
    :math:`\tau = -(b a^3 + e a^5 + ...)` (the reduction of Lyapunov and Schmidt).
    """
    amplitudes = np.multiply.outer(AMPLITUDES, FRACTIONS)
    shifts = _shifts(orbits, point, scales, amplitudes.ravel()).reshape(amplitudes.shape)
    # tau / a^3 = -(b + e a^2 + ...): b is what was left over of it.
    return _slope(amplitudes, -shifts / amplitudes**3)


def _slope(amplitudes: Array, values: Array) -> float | None:
    """Return how values change with the square of an amplitude; None if that is not known.

    Shapes: (k, 4).
    """
    found = solve_each(amplitudes[:, :, None] ** np.array([0, 2, 4, 6]), values)[:, 1]
    pairs = [(a, b) for a, b in pairwise(found.tolist()) if b and not np.isnan(a / b)]
    best = min(pairs, key=lambda pair: abs(pair[0] / pair[1] - 1), default=None)
    if best is None or abs(best[0] / best[1] - 1) > AGREEMENT:
        return None
    return best[1]


def _shifts(orbits: Orbits, point: OrbitPoint, scales: Array, amplitudes: Array) -> Array:
    """Newton's method for both states and the shift at given amplitudes, shape (k,)."""
    n, constants = len(scales), orbits.constants(point.z)
    matrix = point.monodromy * (orbits.scales / scales)[:, None] / (orbits.scales / scales)
    right, left, _ = critical_vectors(matrix, lambda values: np.abs(values + 1))
    q, p = right.real, left.real
    center = orbits.nodes(point.z)[0] / scales
    away = amplitudes[:, None] * q
    no_parameter = np.zeros((len(constants.values), 0))
    jacobian = np.zeros((2 * n + 1, 2 * n + 1))
    jacobian[:n, n : 2 * n] = jacobian[n : 2 * n, :n] = -np.eye(n)
    jacobian[:n, -1], jacobian[n : 2 * n, -1] = q, -q
    jacobian[-1, :n], jacobian[-1, n : 2 * n] = p / 2, -p / 2

    def steps(some: NDArray[np.int64], unknown: Array) -> Array:
        states, shifts = unknown[:, :-1].reshape(-1, 2, n), unknown[:, -1:]
        start = np.full(2 * len(some), orbits.phase)
        ends, blocks, _ = orbits.flow.linearize(
            (states * scales).reshape(-1, n), start, start + orbits.period, constants, no_parameter
        )
        images = ends.reshape(-1, 2, n) / scales
        slopes = (blocks * scales / scales[:, None]).reshape(-1, 2, n, n)
        matrices = np.tile(jacobian, (len(some), 1, 1))
        matrices[:, :n, :n], matrices[:, n : 2 * n, n : 2 * n] = slopes[:, 0], slopes[:, 1]
        residual = [
            images[:, 0] - states[:, 1] + shifts * q,
            images[:, 1] - states[:, 0] - shifts * q,
            ((states[:, 0] - states[:, 1]) @ p / 2 - amplitudes[some])[:, None],
        ]
        return solve_each(matrices, -np.concatenate(residual, axis=1))

    guesses = np.column_stack([center + away, center - away, np.zeros(len(amplitudes))])
    return correct_many(steps, guesses, RULE).z[:, -1]


def equilibrium_form(orbits: Orbits, point: OrbitPoint, kind: str) -> tuple[float, str | None]:
    """Return the coefficient of an equilibrium's bifurcation and its criticality."""
    field = FieldMap(orbits, point.z)
    ratios = orbits.scales / orbits.model_at(point.z).unit_scales()
    if kind == "HB":
        coefficient = first_lyapunov_coefficient(field)
        size = float(np.linalg.norm(hopf_vectors(field.jacobian)[0] * ratios))
        return normalized(kind, coefficient, size), criticality_of(kind, coefficient)
    # The map x -> x + f(x) has the equilibrium as its fixed point and the field's derivatives.
    matrix = np.eye(len(orbits.scales)) + field.jacobian
    if kind == "LP":
        coefficient = fold_coefficient(field, matrix, field.pull)
    else:
        coefficient = critical_coefficient(field, matrix, kind)
    size = critical_length(matrix, kind, ratios)
    return normalized(kind, coefficient, size), criticality_of(kind, coefficient)


def first_lyapunov_coefficient(field: FieldMap) -> float:
    """Return l1 of a Hopf point: below zero stable cycles emanate, above it unstable ones."""
    matrix = field.jacobian
    q, p, value = hopf_vectors(matrix)
    identity = np.eye(len(q))
    qq, q_q = field.second([(q, q), (q, q.conj())])
    h11 = -np.linalg.solve(matrix, q_q)
    h20 = np.linalg.solve(2j * value.imag * identity - matrix, qq)
    return float(pair_cubic(field, q, p, h11, h20).real / value.imag)


def second_lyapunov_coefficient(field: FieldMap) -> float | None:
    r"""Return l2 of a generalized Hopf point, Re(c2) over the frequency.

    The normal form is :math:`w' = i \omega w + c_1 w |w|^2 + c_2 w |w|^4` (Kuznetsov, section 8.3).
    A cycle with the first harmonic a q exists if the critical modes are damped by
    :math:`Re(c_1) a^2 + Re(c_2) a^4 + ...` as well (the reduction of Lyapunov and Schmidt).
    """
    q, p, value = hopf_vectors(field.jacobian)
    if TIMES * len(q) > LARGEST:
        return None
    amplitudes = np.multiply.outer(AMPLITUDES, FRACTIONS)
    damping = _damping(field, q, p, value.imag, amplitudes.ravel()).reshape(amplitudes.shape)
    slope = _slope(amplitudes, damping / amplitudes**2)
    return None if slope is None else slope / value.imag


def _damping(field: FieldMap, q: Vector, p: Vector, frequency: float, amplitudes: Array) -> Array:
    """Return by how much critical modes are damped where cycles have some amplitudes, shape (k,).

    Newton's method for the states at equidistant times, the frequency and the damping.
    """
    n, count = len(q), TIMES * len(q)
    turn = np.exp(2j * np.pi * np.arange(TIMES) / TIMES)
    orders = np.fft.fftfreq(TIMES, 1 / TIMES)
    slopes = np.fft.ifft(1j * orders[:, None] * np.fft.fft(np.eye(TIMES), axis=0), axis=0).real
    by_time = np.kron(slopes, np.eye(n))
    critical = np.kron(np.eye(TIMES), 2 * np.outer(q, p.conj()).real)
    harmonic = np.kron(turn.conj(), p.conj()) / TIMES
    center = np.tile(field.center, TIMES)

    def steps(some: NDArray[np.int64], unknown: Array) -> Array:
        away, (turns, damped) = unknown[:, :-2], unknown[:, -2:].T[:, :, None]
        rates, jacobians = field.rates((center + away).reshape(-1, n))
        matrices = np.zeros((len(some), count + 2, count + 2))
        matrices[:, :count, :count] = turns[:, :, None] * by_time + damped[:, :, None] * critical
        blocks = matrices[:, :count, :count].reshape(-1, TIMES, n, TIMES, n)
        each = np.arange(TIMES)
        blocks[:, each, :, each] -= jacobians.reshape(-1, TIMES, n, n).swapaxes(0, 1)
        moved, lost = away @ by_time.T, away @ critical.T
        matrices[:, :count, -2], matrices[:, :count, -1] = moved, lost
        matrices[:, -2, :count], matrices[:, -1, :count] = harmonic.real, harmonic.imag
        left = turns * moved - rates.reshape(-1, count) + damped * lost
        first = away @ harmonic - amplitudes[some]
        residual = np.column_stack([left, first.real, first.imag])
        return solve_each(matrices, -residual)

    shape = 2 * np.real(turn[:, None] * q).ravel()
    guesses = amplitudes[:, None] * np.append(shape, [0.0, 0.0])
    guesses[:, -2] = frequency
    return correct_many(steps, guesses, RULE).z[:, -1]


def hopf_vectors(matrix: Array) -> tuple[Vector, Vector, complex]:
    """Critical vectors of the pair of eigenvalues that is nearest to the imaginary axis."""
    return critical_vectors(
        matrix, lambda values: np.where(values.imag > 0, np.abs(values.real), np.inf)
    )
