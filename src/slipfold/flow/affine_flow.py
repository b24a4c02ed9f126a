r"""Rates that are affine in the states, solved in closed form.

In each mode of its contacts a linear structure with Coulomb's friction has such rates,

.. math:: x' = A x + \sum_h b_h e^{2 \pi i h t},

so that all modes of vibration, however fast, are exact, and so are their derivatives. In the basis
of eigenvectors of A all follows from divided differences of the exponential function.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import heyoka as hy
import numpy as np

from slipfold.arrays import Array, Complex
from slipfold.flow.equations import Constants, Equations
from slipfold.flow.flow import Flow
from slipfold.models.quantities import Expression


class AFFINE:
    """When rates are solved in closed form."""

    states: int = 8  # fewer are linearized in less time by an integrator, unless they are fast
    # Largest eigenvalue a period above which rates are fast: responses take as long by both methods
    # at 20,000, and an integrator gives up a segment of a period at 27,000
    fast: float = 1.5e4
    condition: float = 1e4  # of eigenvectors: four of sixteen digits
    first: int = 16  # phases at which forcing is sampled first
    most: int = 256  # the same at most: twice the highest harmonic of structures, and more
    left_out: float = 2e-15  # harmonics that rounding may make, over the largest
    missed: float = 1e-12  # forcing that harmonics do not give, over its size
    resonant: float = 0.01  # distance a phase of exponents whose quotients are taken together
    apart: float = 0.5  # difference of exponents above which quotients lose no digits
    terms: int = 18  # of power series for smaller differences


BETWEEN = np.array([0.137, 7.731])
"""Phases at which harmonics are tested, the second beyond a period."""


def is_affine(functions: Sequence[Expression], equations: Equations) -> bool:
    """Whether functions are affine in the states with slopes that parameters alone change."""
    moving = {str(symbol) for symbol in (*equations.states, equations.phase)}
    slopes = hy.diff_tensors(list(functions), diff_args=list(equations.states), diff_order=1)
    return all(
        moving.isdisjoint(hy.get_variables([slope]))
        for slope in np.asarray(slopes.jacobian).ravel()
    )


class Harmonics(NamedTuple):
    """Functions of the phase as sums of few harmonics."""

    exponents: Complex  # 2 pi i h, shape (H,)
    values: Complex  # shape (H, q)

    def at(self, phases: Array) -> Array:
        """Return the functions, shape (p, q). Shapes: phases (p,)."""
        return np.asarray((np.exp(phases[:, None] * self.exponents) @ self.values).real)


EigenBasis = tuple[Complex, Complex, Complex]
"""Eigenvalues (n,), eigenvectors in columns (n, n), and the inverse of these."""


def harmonics_of(
    function: Callable[[Array], Array], units: Array, floor: Array | float
) -> Harmonics | None:
    """Return the harmonics of functions, None if there are too many or they are not periodic.

    The function maps phases (p,) to values (p, k, n): k vectors, whose components are compared in
    `units`, shape (n,), with the largest of their own vector, or with `floor`, shape (k,), since
    what a contact that sticks takes upon itself leaves rounding errors.
    """
    count = AFFINE.first
    while count <= AFFINE.most:
        values = function(np.concatenate([np.arange(count) / count, BETWEEN])) / units
        size = np.maximum(np.abs(values).max(axis=(0, 2)), floor)[:, None]
        found = np.fft.fft(values[:count], axis=0) / count
        kept = np.flatnonzero((np.abs(found) > AFFINE.left_out * size).any(axis=(1, 2)))
        orders = np.where(kept > count // 2, kept - count, kept)
        result = Harmonics(
            2j * np.pi * orders, (found[kept] * units).reshape(len(kept), size.size * len(units))
        )
        gaps = np.abs(result.at(BETWEEN).reshape(values[count:].shape) / units - values[count:])
        if (gaps <= AFFINE.missed * size).all():
            return result
        count *= 2
    return None


def divided(one: Complex, other: Complex) -> Complex:
    """Return the divided difference of the exponential function at two exponents."""
    swapped = one.real > other.real
    low, high = np.where(swapped, other, one), np.where(swapped, one, other)
    return np.asarray(np.exp(high) * _quotient(low - high))


def _quotient(z: Complex) -> Complex:
    """Return (e^z - 1)/z."""
    safe = np.where(z == 0, 1.0, z)
    return np.where(z == 0, 1.0, np.expm1(safe) / safe)


def twice_divided(one: Complex, other: Complex, last: Complex) -> Complex:
    """Return the same at three exponents, of which the second is near the last."""
    u, v = np.broadcast_arrays(one - last, other - last)
    near = np.abs(u - v) < AFFINE.apart
    gap = np.where(near, 1.0, u - v)
    far = (_quotient(u) - _quotient(v)) / gap
    u, v = np.where(near, u, 0.0), np.where(near, v, 0.0)
    series, power, factor = np.zeros_like(u), np.ones_like(u), 0.5
    sums = np.ones_like(u)  # of all products of powers of one order
    for order in range(1, AFFINE.terms):
        series = series + factor * sums
        power = power * v
        sums = u * sums + power
        factor /= order + 2
    return np.asarray(np.exp(last) * np.where(near, series, far))


@dataclass(frozen=True, eq=False)
class AffineSolutions:
    """All solutions of affine rates at some values of the parameters."""

    values: Complex  # eigenvalues a phase, shape (n,)
    shapes: Complex  # eigenvectors, shape (n, n)
    into: Complex  # their inverse
    forcing: Harmonics  # in the basis of eigenvectors
    answers: Complex  # to the forcing where it is not resonant, zero elsewhere, shape (H, n)
    resonant: tuple[tuple[int, int], ...]  # harmonic and eigenvalue of the other pairs
    units: Array  # sizes of rates, shape (n,)

    @staticmethod
    def of(eigen: EigenBasis, period: float, forcing: Harmonics, units: Array) -> AffineSolutions:
        """Return the solutions from eigenvalues a second, vectors and inverse."""
        values, shapes, into = eigen
        values = values * period
        pushed = forcing.values @ into.T
        gaps = forcing.exponents[:, None] - values
        resonant = np.abs(gaps) < AFFINE.resonant
        answers = np.where(resonant, 0.0, pushed / np.where(resonant, 1.0, gaps))
        pairs = tuple((int(h), int(j)) for h, j in np.argwhere(resonant) if pushed[h, j] != 0)
        forced = Harmonics(forcing.exponents, pushed)
        return AffineSolutions(values, shapes, into, forced, answers, pairs, units)

    def motions(self, first: Complex, begin: Array, times: Array) -> Complex:
        """Return solutions in the basis of eigenvectors at times after their beginnings.

        Shapes: first (m, n); begin (m,); times (m, p); returns (m, p, n).
        """
        exponents, z = self.forcing.exponents, times[..., None]
        started = np.exp(begin[:, None] * exponents)  # (m, H)
        free = first - started @ self.answers
        result = np.exp(self.values * z) * free[:, None]
        result += (started[:, None] * np.exp(exponents * z)) @ self.answers
        for h, j in self.resonant:
            push = self.forcing.values[h, j] * started[:, h, None]
            result[..., j] += push * times * divided(self.values[j] * times, exponents[h] * times)
        return result

    def rates(self, motions: Complex, phases: Array) -> Complex:
        """Return the rates of solutions. Shapes: motions (p, n); phases (p,)."""
        pushes = np.exp(phases[:, None] * self.forcing.exponents) @ self.forcing.values
        return self.values * motions + pushes

    def transitions(self, times: Array) -> Array:
        """Return derivatives by the first states. Shapes: times (m,); returns (m, n, n)."""
        decay = np.exp(times[:, None] * self.values)
        return np.asarray(((self.shapes * decay[:, None]) @ self.into).real)

    def along(
        self, first: Complex, begin: Array, times: Array, turned: Array, pushed: Harmonics
    ) -> Array:
        """Return derivatives along changes of the parameters.

        Shapes: first (m, n); begin, times (m,); turned (k, n, n), the changes of A; pushed
        (H', k n), those of the forcing; returns (m, n, k).
        """
        k, n, _ = turned.shape
        values, exponents, z = self.values, self.forcing.exponents, times[:, None]
        changes = self.into @ turned @ self.shapes  # (k, n, n)
        started = np.exp(begin[:, None] * exponents)
        free = first - started @ self.answers
        by_free = times[:, None, None] * divided((values * z)[:, :, None], (values * z)[:, None, :])
        result = np.einsum("kij,mij,mj->mik", changes, by_free, free)
        by_forcing = z[:, None] * divided(
            (values * z)[:, None], (exponents[:, None] * z[:, None])
        )  # (m, H, n)
        forced = np.einsum("kij,hj->hik", changes, self.answers)
        result += np.einsum("mh,mhi,hik->mik", started, by_forcing, forced)
        for h, j in self.resonant:
            twice = z**2 * twice_divided(values * z, values[j] * z, exponents[h] * z)
            push = self.forcing.values[h, j] * started[:, h]
            result += (push[:, None] * twice)[:, :, None] * changes[:, :, j].T
        own = (pushed.values.reshape(-1, k, n) @ self.into.T).transpose(0, 2, 1)  # (H', n, k)
        by_own = z[:, None] * divided(
            (values * z)[:, None], (pushed.exponents[:, None] * z[:, None])
        )
        started = np.exp(begin[:, None] * pushed.exponents)
        result += np.einsum("mh,mhi,hik->mik", started, by_own, own)
        return np.asarray((self.shapes @ result).real)


@lru_cache(maxsize=16)
def _largest_modulus(matrix: bytes, n: int) -> float:
    """Return the largest modulus of the eigenvalues of a matrix, shape (n, n)."""
    return float(np.abs(np.linalg.eigvals(np.frombuffer(matrix).reshape(n, n))).max())


class AffineFlow(Flow):
    """The flow of affine rates; where they are not forced by few harmonics it is integrated."""

    def __init__(self, equations: Equations) -> None:
        super().__init__(equations)
        self._forget()

    def _forget(self) -> None:
        self._known: tuple[Constants | None, AffineSolutions | None] = None, None
        self._fast: tuple[Constants | None, bool] = None, False

    def takes_many_steps(self, constants: Constants) -> bool:
        """Whether an integrator would take many steps a period, as fast decay needs."""
        known, fast = self._fast
        if known is not constants:
            fast = constants.values.ndim == 1 and self._fastest(constants) > AFFINE.fast
            self._fast = constants, fast
        return fast

    def _fastest(self, constants: Constants) -> float:
        """Return the largest modulus of the eigenvalues a phase, zero if it is not large."""
        n, scales, period = self.dimension, constants.scales, constants.period
        states = np.concatenate([np.zeros((1, n)), np.diag(scales)])
        rates = self.rates(states, np.zeros(n + 1), constants.in_a_second) / scales
        matrix = rates[1:] - rates[0]
        bound = float(np.abs(matrix).sum(axis=1).max()) * period
        if not AFFINE.fast < bound < np.inf:
            return 0.0
        return _largest_modulus(matrix.tobytes(), n) * period

    def solutions(self, constants: Constants) -> AffineSolutions | None:
        """Return all solutions, None where no closed form has enough digits."""
        known, found = self._known
        if known is not constants:
            found = self._solve(constants)
            self._known = constants, found
        return found

    def _closed(self, constants: Constants) -> AffineSolutions | None:
        """Return all solutions where they take less time than an integrator; None elsewhere."""
        if self.dimension < AFFINE.states and not self.takes_many_steps(constants):
            return None
        return self.solutions(constants)

    def _solve(self, constants: Constants) -> AffineSolutions | None:
        n = self.dimension
        if constants.values.ndim > 1:
            return None
        matrix = self.jacobians(np.zeros((1, n)), np.zeros(1), constants.in_a_second)[0]
        eigen = _eigenvectors(matrix.tobytes(), n)
        # Rates that states of the size of their scales cause
        units = np.maximum(constants.scales, constants.period * np.abs(matrix) @ constants.scales)
        forcing = self._forcing(constants, units)
        if eigen is None or forcing is None:
            return None
        return AffineSolutions.of(eigen, constants.period, forcing, units)

    def _forcing(self, constants: Constants, units: Array) -> Harmonics | None:
        """Return the rates of states that are zero, in units of shape (n,)."""
        n = self.dimension
        return harmonics_of(
            lambda at: self.rates(np.zeros((len(at), n)), at, constants)[:, None], units, 1.0
        )

    def advance(self, states: Array, start: Array, end: Array, constants: Constants) -> Array:
        """Propagate states from one phase to another."""
        if self._closed(constants) is None:
            return super().advance(states, start, end, constants)
        return self.along(states, np.stack([start, end], axis=1), constants)[:, 1]

    def along(self, states: Array, phases: Array, constants: Constants) -> Array:
        """Propagate states along phases of their own."""
        found = self._closed(constants)
        if found is None:
            return super().along(states, phases, constants)
        begin = phases[:, 0]
        moved = found.motions(states @ found.into.T, begin, phases - begin[:, None])
        return np.asarray((moved @ found.shapes.T).real)

    def trajectory(
        self, state: Array, constants: Constants, grid: Array, *, patient: bool = True
    ) -> Array:
        """Propagate one state along a grid of phases."""
        if self._closed(constants) is None:
            return super().trajectory(state, constants, grid, patient=patient)
        return self.along(state[None], grid[None], constants)[0]

    def linearize(
        self, states: Array, start: Array, end: Array, constants: Constants, directions: Array
    ) -> tuple[Array, Array, Array]:
        """Propagate states and their derivatives from one phase to another."""
        found = self._closed(constants) if directions.ndim == 2 else None
        pushed = None if found is None else self._pushes(constants, directions, found.units)
        if found is None or pushed is None:
            return super().linearize(states, start, end, constants, directions)
        first, times, n = states @ found.into.T, end - start, self.dimension
        ends = (found.motions(first, start, times[:, None])[:, 0] @ found.shapes.T).real
        units = constants.scales
        around = np.concatenate([np.zeros((1, n)), np.diag(units)])
        slopes = self.parameter_slopes(around, np.zeros(n + 1), constants, directions)
        turned = ((slopes[1:] - slopes[0]) / units[:, None, None]).transpose(2, 1, 0)
        vectors = found.along(first, start, times, turned, pushed)
        return ends, found.transitions(times), vectors

    def _pushes(self, constants: Constants, directions: Array, units: Array) -> Harmonics | None:
        """Return the changes of the forcing, shape (H, k n)."""
        n = self.dimension

        def changes(phases: Array) -> Array:
            zeros = np.zeros((len(phases), n))
            found = self.parameter_slopes(zeros, phases, constants, directions)
            return found.transpose(0, 2, 1)

        sizes = np.abs(constants.values)[:, None]  # a change of as much is one of all rates
        relative = np.divide(np.abs(directions), sizes, np.zeros(directions.shape), where=sizes > 0)
        return harmonics_of(changes, units, relative.max(axis=0))


@lru_cache(maxsize=128)  # a branch in the frequency needs one for each mode of contacts
def _eigenvectors(entries: bytes, n: int) -> EigenBasis | None:
    """Return eigenvalues, eigenvectors and their inverse; None where they have too few digits."""
    from scipy.linalg import matrix_balance  # slow to import

    matrix = np.frombuffer(entries).reshape(n, n)
    if not np.isfinite(matrix).all():
        return None
    balanced, (sizes, _) = matrix_balance(matrix, permute=False, separate=True)
    try:
        values, vectors = np.linalg.eig(balanced)
        inverse = np.linalg.inv(vectors)
    except np.linalg.LinAlgError:
        return None
    if not np.linalg.norm(vectors, 2) * np.linalg.norm(inverse, 2) < AFFINE.condition:
        return None
    shapes, into = sizes[:, None] * vectors, inverse / sizes
    return values.astype(complex), shapes.astype(complex), into.astype(complex)


def flow_of_rates(equations: Equations) -> Flow:
    """Return the flow of equations, in closed form if they are affine."""
    if not is_affine(equations.field, equations):
        return Flow(equations)
    return AffineFlow(equations)
