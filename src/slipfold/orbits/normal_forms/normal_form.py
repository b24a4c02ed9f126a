"""Normal form coefficients of fixed points and equilibria where one parameter is critical."""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from functools import partial
from typing import Any, TypeVar

import numpy as np

from slipfold.arrays import Array
from slipfold.continuation.locate import corrected_together
from slipfold.errors import BREAKDOWNS
from slipfold.orbits.bifurcation_types import BIFURCATION_TYPES, PAIRED
from slipfold.orbits.kinds import Equilibria
from slipfold.orbits.linearization import Linearization
from slipfold.orbits.normal_forms.maps import (
    FORMS,
    FieldMap,
    JetMap,
    MapDerivatives,
    Request,
    ReturnChain,
    ReturnMap,
    SegmentMap,
    Vector,
    answers_of,
    pair_terms,
)
from slipfold.orbits.orbit_curve import OrbitPoint, Orbits

T = TypeVar("T")

QUADRATIC = ("LP", "transcritical")
"""Kinds whose coefficient is of second order; the others are of third."""


def _distance(kind: str, known: complex | None = None) -> Callable[[Vector], Array]:
    """Return the function of the multipliers that is smallest for the critical one.

    That one has to be known where others lie on the circle as well.
    """
    if known is not None:
        return lambda values: np.abs(values - known)
    if kind in PAIRED:
        return lambda values: np.where(values.imag > 0, np.abs(np.abs(values) - 1), np.inf)
    target = BIFURCATION_TYPES[kind if kind in BIFURCATION_TYPES else "BP"].critical
    return lambda values: np.abs(values - target)


Form = Generator[Request, Any, T]
"""A computation that is sent the derivatives of maps that it requests."""

Critical = tuple[Vector, Vector, complex]
"""Right and left eigenvector of a critical eigenvalue, and this."""

Coefficient = Form[tuple[float, str | None]]
"""Finds the coefficient of a bifurcation of a branch, and its criticality."""


def solved_forms(forms: Sequence[Form[T]]) -> list[Any]:
    """Return what forms find, or the errors they end with; all requests are answered together."""
    with np.errstate(over="ignore", invalid="ignore"):  # along a canard all numbers are left
        return corrected_together(forms, answers_of, BREAKDOWNS)


def normal_form(orbits: Orbits, point: OrbitPoint, kind: str) -> Coefficient:
    """Find the coefficient of a bifurcation's normal form and its criticality.

    An error of linear algebra says that the map is not known well enough.
    """
    linearization = point.linearization or orbits.linearize(point.z)
    map_: JetMap | ReturnMap | SegmentMap = JetMap(orbits, point.z)
    if orbits.free_phase:
        map_ = ReturnMap(orbits, point.z, orbits.scales)
    elif not orbits.by.smooth:  # jets are of one flow
        map_ = SegmentMap(orbits, point.z, linearization)
    matrix = map_.rescaled(linearization.product)
    # Scales that were found, or are those where the branch began, must not be seen in it.
    ratios = orbits.scales / orbits.model_at(point.z).unit_scales()
    known = None
    if orbits.standing is not None and kind in PAIRED:
        known = complex(point.multipliers[point.critical(kind)[0]])
    distance = _distance(kind, known)
    if not distance(np.linalg.eigvals(matrix).astype(complex)).min() < FORMS.lost:
        if not orbits.free_phase or kind != "PD":
            raise np.linalg.LinAlgError(f"the map has lost the multiplier of its {kind}")
        return _judged(kind, *ReturnChain(orbits, point.z, orbits.scales).doubling(ratios))
    q, p, value = critical = critical_vectors(matrix, distance)
    coefficient = yield from _FORMS[kind](map_, matrix, critical)
    if kind == "LP":
        coefficient *= float(np.sign(p.real @ map_.mapped(_parameter_pull(linearization))))
    if isinstance(map_, ReturnMap):
        size = map_.length(q, value, linearization.product, ratios)
    else:
        size = stroboscopic_length(orbits, point, q, ratios)
    return _judged(kind, coefficient, size)


def stroboscopic_length(orbits: Orbits, point: OrbitPoint, vector: Vector, ratios: Array) -> float:
    """Return the root mean square of a critical vector where the map takes it, in other scales.

    An orbit of p forcing periods is p points of the stroboscopic map, any of which may be the
    first. Shapes: vector, ratios (n,).
    """
    whole = np.ceil(orbits.phase) + np.arange(orbits.period)
    lengths = [np.linalg.norm(vector * ratios)] if whole[0] == orbits.phase else []
    phases = whole[len(lengths) :]
    if len(phases):
        nodes = orbits.nodes(point.z)
        which, _, matrices, _ = orbits.by.propagate_to(nodes, orbits.constants(point.z), phases)
        vectors = [vector]
        for block in (point.linearization or orbits.linearize(point.z)).factors[:-1]:
            vectors.append(block @ vectors[-1])
        for node, matrix in zip(which, matrices, strict=True):
            unscaled = matrix @ (vectors[node] * orbits.scales)
            lengths.append(np.linalg.norm(unscaled / orbits.scales * ratios))
    return float(np.sqrt(np.mean(np.square(lengths))))


def _judged(kind: str, coefficient: float, size: float) -> tuple[float, str | None]:
    """Return a coefficient for a critical vector so many times as long, and the criticality."""
    normalized = coefficient / (size if kind in QUADRATIC else size**2)
    return normalized, criticality_of(kind, coefficient)


def mean_length(map_: ReturnMap, matrix: Array, product: Array, kind: str, ratios: Array) -> float:
    """Return the root mean square, round a cycle, of its unit critical vector.

    Shapes: matrix (n - 1, n - 1); product (n, n); ratios (n,).
    """
    q, _, value = critical_vectors(matrix, _distance(kind))
    return map_.length(q, value, product, ratios)


def critical_coefficient(
    map_: MapDerivatives, monodromy: Array, kind: str, known: complex | None = None
) -> float:
    """Return the coefficient whose sign decides the criticality. Shapes: monodromy (n, n)."""

    def form() -> Form[float]:
        critical = critical_vectors(monodromy, _distance(kind, known))
        return (yield from _FORMS[kind](map_, monodromy, critical))

    (found,) = solved_forms([form()])
    if isinstance(found, Exception):
        raise found
    return float(found)


def criticality_of(kind: str, coefficient: float) -> str | None:
    """Return ``"supercritical"`` or ``"subcritical"``; None where it is not defined."""
    if kind in QUADRATIC or not abs(coefficient) > FORMS.degenerate:  # or it is not a number
        return None
    soft = BIFURCATION_TYPES[kind].soft if kind in BIFURCATION_TYPES else -1.0
    return "supercritical" if coefficient * soft > 0 else "subcritical"


def _parameter_pull(linearization: Linearization) -> Array:
    """Derivative of the map with respect to the parameter, in the orbits' scaled states."""
    pull = np.zeros(linearization.along.shape[1])
    for block, along in zip(linearization.blocks, linearization.along[:, :, -1], strict=True):
        pull = block @ pull + along
    return pull


def _quadratic(map_: MapDerivatives, _matrix: Array, critical: Critical) -> Form[float]:
    """Coefficient of second order; that of a fold has the sign of the parameter's pull as well."""
    q, p, _ = critical
    second, _ = yield map_, "powers", q.real[None]
    return float(0.5 * (p.real @ second[0]))


def _pitchfork(map_: MapDerivatives, matrix: Array, critical: Critical) -> Form[float]:
    """Cubic coefficient on the center manifold, where the quadratic one is zero by symmetry."""
    q, p, _ = critical
    n = len(q)
    bordered = np.block([[np.eye(n) - matrix, p.real[:, None]], [p.real[None], np.zeros((1, 1))]])

    def solve(second: Array) -> Array:
        return np.linalg.solve(bordered, np.append(second, 0.0))[:n]

    return (yield from _cubic(map_, q, p, solve))


def _crossing(map_: MapDerivatives, matrix: Array, critical: Critical) -> Form[float]:
    """Cubic coefficient of a branch point if it is a pitchfork, NaN of a transcritical one."""
    quadratic = yield from _quadratic(map_, matrix, critical)
    if abs(quadratic) > FORMS.symmetric:
        return np.nan
    return (yield from _pitchfork(map_, matrix, critical))


def _doubling(map_: MapDerivatives, matrix: Array, critical: Critical) -> Form[float]:
    q, p, _ = critical
    return (yield from _cubic(map_, q, p, partial(np.linalg.solve, np.eye(len(q)) - matrix)))


def _cubic(
    map_: MapDerivatives, q: Vector, p: Vector, solve: Callable[[Array], Array]
) -> Form[float]:
    """Cubic coefficient on the center manifold, whose bend `solve` gives."""
    second, third = yield map_, "powers", q.real[None]
    (mixed,) = yield map_, "second", [(q, solve(second[0]).astype(complex))]
    return float(p.real @ (third[0] + 3 * mixed.real) / 6)


def _torus(map_: MapDerivatives, matrix: Array, critical: Critical) -> Form[float]:
    q, p, value = critical
    a, b = q.real, q.imag
    second, third = yield map_, "powers", np.array([a, b, a + b, a - b])
    even, odd, cubic = pair_terms(second, third)
    identity = np.eye(len(a))
    still = np.linalg.solve(identity - matrix, even).astype(complex)
    double = np.linalg.solve(value**2 * identity - matrix, odd).astype(complex)
    # 2 B(q, still) + B(conj q, double), of half as many products of real vectors.
    real, imaginary = 2 * still + double, 1j * (2 * still - double)
    mixed = yield map_, "second", [(a.astype(complex), real), (b.astype(complex), imaginary)]
    inner = np.vdot(p, cubic + sum(mixed))
    return float(0.5 * (value.conjugate() / abs(value) * inner).real)


_FORMS: dict[str, Callable[[MapDerivatives, Array, Critical], Form[float]]] = {
    "PD": _doubling,
    "NS": _torus,
    "BP": _crossing,
    "LP": _quadratic,
    "transcritical": _quadratic,
    "pitchfork": _pitchfork,
}


def critical_vectors(matrix: Array, distance: Callable[[Vector], Array]) -> Critical:
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
    with np.errstate(divide="ignore", invalid="ignore"):  # a double eigenvalue with one eigenvector
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


def quintic_coefficient(map_: JetMap, matrix: Array) -> float:
    r"""Return e of the normal form :math:`\eta \to -\eta + b \eta^3 + e \eta^5` where b is zero.

    An orbit x(a) of twice the period with the amplitude a along the critical vector q exists if the
    map is shifted by :math:`\tau q` in one period and by :math:`-\tau q` in the next,
    :math:`P(x(a)) + \tau q = x(-a)` with :math:`\tau = -(b a^3 + e a^5 + ...)` (the reduction of
    Lyapunov and Schmidt). Powers of a give :math:`x = x_0 + a q + a^2 h_2 + ...` one by one.

    Shapes: matrix (n, n).
    """
    right, left, _ = critical_vectors(matrix, _distance("PD"))
    q, p = right.real, left.real
    identity, curve = np.eye(len(q)), [q]
    for order in (2, 3, 4):
        forced = map_.along_curve(np.array(curve))
        if order % 2:
            bordered = np.block([[matrix + identity, q[:, None]], [p[None], np.zeros((1, 1))]])
            curve.append(np.linalg.solve(bordered, np.append(-forced, 0.0))[:-1])
        else:
            curve.append(np.linalg.solve(identity - matrix, forced))
    return float(p @ map_.along_curve(np.array(curve)))


def equilibrium_form(orbits: Orbits, point: OrbitPoint, kind: str) -> Coefficient:
    """Find the coefficient of an equilibrium's bifurcation and its criticality."""
    field = FieldMap(orbits, point.z)
    ratios = orbits.scales / orbits.model_at(point.z).unit_scales()
    if kind == "HB":
        frequency = None
        if orbits.standing is not None:
            assert isinstance(orbits, Equilibria)
            critical = point.multipliers[point.critical(kind)[0]]
            frequency = orbits.frequency(point.z, critical)
        coefficient = first_lyapunov_coefficient(field, frequency)
        size = float(np.linalg.norm(hopf_vectors(field.jacobian, frequency)[0] * ratios))
        return _judged(kind, coefficient, size)
    # The map x -> x + f(x) has the equilibrium as its fixed point and the field's derivatives.
    matrix = np.eye(len(orbits.scales)) + field.jacobian
    critical = critical_vectors(matrix, _distance(kind))
    coefficient = yield from _FORMS[kind](field, matrix, critical)
    if kind == "LP":
        coefficient *= float(np.sign(critical[1].real @ field.pull))
    size = float(np.linalg.norm(critical[0] * ratios))
    return _judged(kind, coefficient, size)


def first_lyapunov_coefficient(field: FieldMap, frequency: float | None = None) -> float:
    """Return l1 of a Hopf point: below zero stable cycles emanate, above it unstable ones."""
    matrix = field.jacobian
    q, p, value = hopf_vectors(matrix, frequency)
    identity = np.eye(len(q))
    qq, q_q = field.second([(q, q), (q, q.conj())])
    h11 = -np.linalg.solve(matrix, q_q)
    h20 = np.linalg.solve(2j * value.imag * identity - matrix, qq)
    return float(pair_cubic(field, q, p, h11, h20).real / value.imag)


def second_lyapunov_coefficient(field: FieldMap) -> float:
    r"""Return l2 of a generalized Hopf point, Re(c2) over the frequency.

    The normal form is :math:`w' = i \omega w + c_1 w |w|^2 + c_2 w |w|^4` (Kuznetsov, section 8.3).
    A cycle with the first harmonic a q exists if the critical modes are damped by
    :math:`Re(c_1) a^2 + Re(c_2) a^4 + ...` as well (the reduction of Lyapunov and Schmidt). Powers
    of a give its states :math:`x_1 a + x_2 a^2 + ...`, and damping and frequency, one by one.
    """
    matrix = field.jacobian
    q, p, value = hopf_vectors(matrix)
    turn = np.exp(2j * np.pi * np.arange(FORMS.times) / FORMS.times)
    orders = np.fft.fftfreq(FORMS.times, 1 / FORMS.times)
    critical = 2 * np.outer(q, p.conj()).real
    curves = 2 * np.real(turn[:, None] * q)[:, None]  # x_1 at each time, shape (FORMS.times, 1, n)
    changes: dict[int, complex] = {}  # damping and change of the frequency, by power of a
    for order in range(2, 6):
        series = np.fft.fft(field.along_curves(curves), axis=0) / FORMS.times
        for power, change in changes.items():
            earlier = np.fft.fft(curves[:, order - power - 1], axis=0) / FORMS.times
            series -= change.imag * 1j * orders[:, None] * earlier
            series -= change.real * earlier @ critical.T
        if order % 2:
            change = changes[order - 1] = complex(p.conj() @ series[1])
            series[1] -= change * q
            series[-1] = series[1].conj()
        states = np.zeros_like(series)
        for place in range(FORMS.times // 2):  # of real functions the others are conjugate
            shifted = 1j * orders[place] * value.imag * np.eye(len(q)) - matrix
            if place == 1:
                bordered = np.block([[shifted, q[:, None]], [p.conj()[None], np.zeros((1, 1))]])
                states[1] = np.linalg.solve(bordered, np.append(series[1], 0.0))[:-1]
            else:
                states[place] = np.linalg.solve(shifted, series[place])
            states[-place] = states[place].conj() if place else states[0].real
        added = np.fft.ifft(states, axis=0).real * FORMS.times
        curves = np.concatenate([curves, added[:, None]], axis=1)
    return changes[4].real / value.imag


def hopf_vectors(matrix: Array, frequency: float | None = None) -> tuple[Vector, Vector, complex]:
    """Critical vectors of the pair of eigenvalues that is nearest to the imaginary axis.

    Of several that are equally near, that of a frequency in rad/s.
    """
    if frequency is not None:
        return critical_vectors(matrix, lambda values: np.abs(values - 1j * frequency))
    return critical_vectors(
        matrix, lambda values: np.where(values.imag > 0, np.abs(values.real), np.inf)
    )
