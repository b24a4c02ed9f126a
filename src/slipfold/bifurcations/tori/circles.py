"""Circles that the flow over a fixed time maps onto themselves: curves of them in a parameter."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any, Self

import numpy as np

from slipfold.arrays import Array
from slipfold.continuation.curve import AlgebraicCurve, Point
from slipfold.continuation.newton import Correction, WholeMatrix
from slipfold.flow.equations import Constants, power_of_two
from slipfold.flow.flow import flow_of
from slipfold.models.model import Model
from slipfold.models.quantities import DURATION


def turned(points: Array, turns: float) -> Array:
    """Return the curve's points some turns farther on. Shapes: points (m, n), m odd.

    >>> import numpy as np
    >>> angles = 2 * np.pi * np.arange(5)[:, None] / 5
    >>> bool(np.allclose(turned(np.cos(angles), 0.1), np.cos(angles + 0.2 * np.pi)))
    True
    """
    orders = np.arange(len(points) // 2 + 1)[:, None]
    series = np.fft.rfft(points, axis=0) * np.exp(2j * np.pi * turns * orders)
    return np.fft.irfft(series, len(points), axis=0)


def slopes(points: Array) -> Array:
    """Return the curve's derivatives by the number of turns at its points, shape (m, n)."""
    orders = np.arange(len(points) // 2 + 1)[:, None]
    return np.fft.irfft(np.fft.rfft(points, axis=0) * 2j * np.pi * orders, len(points), axis=0)


def turning(count: int, turns: float) -> Array:
    """Return the matrix that gives points some turns farther on, shape (m, m)."""
    first = turned(np.eye(count, 1), turns)[:, 0]
    places = np.arange(count)
    return first[(places[:, None] - places) % count]


def resampled(points: Array, count: int) -> Array:
    """Return another odd number of equidistant points of the curve, shape (count, n)."""
    series = np.fft.rfft(points, axis=0)
    kept = np.zeros((count // 2 + 1, points.shape[1]), complex)
    size = min(len(series), len(kept))
    kept[:size] = series[:size]
    return np.fft.irfft(kept, count, axis=0) * (count / len(points))


def tail(points: Array) -> float:
    """Return how large the last tenth of the curve's harmonics are beside the largest of all."""
    sizes = np.abs(np.fft.rfft(points, axis=0)[1:]).max(axis=1)
    last = max(2, len(sizes) // 10)
    return float(sizes[-last:].max() / sizes.max())


MIN_ANGLES, MAX_ANGLES = 21, 201
"""Angles at which a circle is described."""


class TORUS:
    """How finely circles are resolved, and when they are points or break."""

    tail: float = 1e-9  # last harmonics, of the largest, at which there are too few of them
    excess: float = 1e-13  # the same at which there are more than needed
    growth: float = 1.5  # factor by which angles become more, or fewer
    strong: int = 4  # largest denominator of a strong resonance: circles may break there
    broken: float = 1e-8  # last harmonics, of the largest, at which a circle is not resolved
    near_strong: float = 1e-2  # distance from a strong resonance at which circles may break by it
    point: float = 3e-5  # extent, in scaled states, of an orbit: the parameter is off by its square
    collapse: float = 3e-3  # extent from which tori do not come to such an orbit in one step
    # Part of the tangent along the parameter that is left where a fold is located
    fold: float = 1e-6
    same: float = 1e-6  # distance, in spans, of the orbit to which tori shrink from a known point
    phases: int = 12  # phases of a locked orbit at which the parameter is found first
    squeezed: float = 2e-3  # distance from a resonance at which circles are squeezed by it
    history: int = 3  # circles before a resonance from which those beyond are extrapolated
    starts: int = 15  # angles from which perturbations start; means over angles converge fast
    returns: int = 64  # returns over which growth is averaged, after as many for directions to turn
    samples: int = 64  # phases of a forcing period
    corrections: int = 4  # corrections of an extremum by Newton, from the largest sample
    lines: int = 12  # lines of a spectrum that a notebook shows


RESONANCES = tuple(
    sorted({Fraction(p, q) for q in range(2, 13) for p in range(1, q) if 2 * p <= q})
)
"""Rotation numbers at which a circle may be locked, up to a denominator of 12."""


class Circles(AlgebraicCurve):
    r"""Circles that the flow over k periods turns by a part of a turn.

    .. math:: P(u(\theta_j)) = u(\theta_j + \rho), \qquad j = 1, \ldots, m

    for the trigonometric polynomial u through states at m equidistant angles, m odd. Which of its
    states has the angle zero is free; it is held as near as it can be to that of `reference`. Of an
    autonomous model the duration of a period is unknown as well, and so is when the circle is
    passed: on the torus the circle may be shifted along the flow, and is held likewise. An unknown
    has the states, over their scales and :math:`\sqrt m`, the duration over that of `model` if it
    is unknown, the rotation number :math:`\rho` in turns and the parameter over its width.

    Shapes: reference (m, n); `constants` are those at `reference`, of `model` if None.
    """

    odd = ("LP",)

    def __init__(
        self,
        model: Model,
        vary: str,
        width: float,
        period: int,
        reference: Array,
        constants: Constants | None = None,
    ) -> None:
        self.model, self.vary, self.width, self.period = model, vary, width, period
        self.reference, self.count = reference, len(reference)
        self.flow = flow_of(model)
        self._scales = model.state_scales()
        self._sizes = self._scales * np.sqrt(self.count)
        free = {} if model.forced else {DURATION.name: model.values[DURATION.name]}
        self._indices = [model.parameter_index(name) for name in (*free, vary)]
        self._units = np.array([*free.values(), width])
        self.size = reference.size
        kept = [slopes(reference)]
        if free:
            constants = constants or self.flow.constants_of(model)
            kept.append(self.flow.rates(reference, np.zeros(self.count), constants))
        directions = (np.array(kept) / self._sizes).reshape(len(kept), -1)
        self._kept = directions / np.linalg.norm(directions, axis=1)[:, None]

    def described_at(self, z: Array, count: int) -> Self:
        """Return the same at as many angles, with a circle as its reference."""
        reference = resampled(self.states(z), count)
        own = self.model, self.vary, self.width, self.period
        return type(self)(*own, reference, self.constants(z))

    # -- what z means --------------------------------------------------------------------------

    def join(self, states: Array, others: Array) -> Array:
        """Return the unknown of a circle and what is unknown besides. Shapes: states (m, n)."""
        return np.concatenate([(states / self._sizes).ravel(), others])

    def others(self, rotation: float, model: Model) -> Array:
        """Return what is unknown besides a circle."""
        *duration, value = model.vector[self._indices] / self._units
        return np.array([*duration, rotation, value])

    def states(self, z: Array) -> Array:
        """Return the states at the angles, shape (m, n)."""
        return z[: self.size].reshape(self.count, -1) * self._sizes

    def rotation(self, z: Array) -> float:
        """Return the rotation number in turns."""
        return float(z[-2])

    def value(self, z: Array) -> float:
        """Return the value of the parameter."""
        return float(z[-1] * self.width)

    def model_at(self, z: Array) -> Model:
        """Return the model with the parameter, and the duration if it is unknown."""
        names = [self.model.parameters[index].name for index in self._indices]
        free = map(float, self._free(z))
        return self.model.replace(**dict(zip(names, free, strict=True)))

    def place(self, z: Array) -> tuple[float, ...]:
        """Return the value of the parameter."""
        return (self.value(z),)

    def constants(self, z: Array) -> Constants:
        """Evaluate the coefficients of the flow."""
        vector = self.model.vector.copy()
        vector[self._indices] = self._free(z)
        return self.flow.constants(vector, power_of_two(self._scales))

    def _free(self, z: Array) -> Array:
        """Return the parameters that are unknown."""
        return np.delete(z[self.size :], -2) * self._units

    # -- equations -----------------------------------------------------------------------------

    def defect(self, z: Array) -> Array:
        """Return by how much the map leads beside the circle, and how far its angles have moved."""
        zero = np.zeros(self.count)
        ends = self.flow.advance(self.states(z), zero, zero + self.period, self.constants(z))
        return self._apart(z, ends)

    def jacobian(self, z: Array) -> Array:
        """Return all derivatives of the equations, shape (m n + k, m n + k + 1)."""
        return self.linearize(z).jacobian

    def linearize(self, z: Array) -> _Linearized:
        """Return the equations with their derivatives."""
        zero, states, turns = np.zeros(self.count), self.states(z), self.rotation(z)
        constants = self.constants(z)
        along = constants.rates[:, self._indices]
        ends, matrices, by_parameters = self.flow.linearize(
            states, zero, zero + self.period, constants, along
        )
        by_turns = -(slopes(turned(states, turns)) / self._sizes).ravel()
        by_free = (by_parameters * self._units / self._sizes[:, None]).reshape(self.size, -1)
        by_others = np.insert(by_free, -1, by_turns, axis=1)
        return _Linearized(self._apart(z, ends), matrices, turns, by_others, self)

    def blended(self, known: Sequence[_Linearized | None], weights: Array) -> _Linearized | None:
        """Return a weighted sum of derivatives at several circles."""
        whole = [item for item in known if item is not None and item.circles is self]
        if len(whole) < len(known):
            return None

        def mixed(name: str) -> Any:
            return sum(w * getattr(item, name) for w, item in zip(weights, whole, strict=True))

        parts = mixed("matrices"), mixed("turns"), mixed("by_others")
        return _Linearized(whole[-1].defect, *parts, self)

    def residual(self, z: Array, defect: Array) -> float:
        """Return the largest mismatch, in scaled states."""
        return float(np.abs(defect).max()) * float(np.sqrt(self.count))

    def tests(self, z: Array, tangent: Array) -> dict[str, float]:
        """Return what is zero at a fold, where circles vanish, and at each strong resonance."""
        tests = {"LP": float(tangent[-1]), "size": self._size(z)}
        strong = [ratio for ratio in RESONANCES if ratio.denominator <= TORUS.strong]
        return tests | {str(ratio): self.rotation(z) - float(ratio) for ratio in strong}

    def point(self, correction: Correction, arclength: float) -> Point:
        """Return a converged correction as a point, with its derivatives."""
        known = {"curve": self, "linearization": correction.linearization}
        return replace(super().point(correction, arclength), **known)

    def renewed(self, points: Sequence[Point]) -> tuple[Any, list[Point]] | None:
        """Return the last point at as many angles as it needs."""
        last = points[-1]
        count = self.needed(last.z)
        if count == self.count:
            return None
        other = self.described_at(last.z, count)
        states, along = (resampled(self.states(part), count) for part in (last.z, last.tangent))
        row = other.join(along, last.tangent[self.size :])
        guess = other.join(states, last.z[self.size :])
        found = other.nearest(guess, row / np.linalg.norm(row), last.arclength)
        return None if found is None else (other, [found])

    def needed(self, z: Array) -> int:
        """Return at how many angles a circle should be described."""
        size = tail(self.states(z))
        if size > TORUS.tail:
            return min(int(TORUS.growth * self.count) | 1, MAX_ANGLES)
        if size < TORUS.excess:
            return max(int(self.count / TORUS.growth) | 1, MIN_ANGLES)
        return self.count

    def truncation(self, z: Array) -> float:
        """Return how far a circle fails to be invariant between its angles, in scaled states."""
        half, zero = 0.5 / self.count, np.zeros(self.count)
        states, turns = self.states(z), self.rotation(z)
        between = turned(states, half)
        ends = self.flow.advance(between, zero, zero + self.period, self.constants(z))
        return float(np.abs((ends - turned(states, turns + half)) / self._scales).max())

    def _apart(self, z: Array, ends: Array) -> Array:
        apart = (ends - turned(self.states(z), self.rotation(z))) / self._sizes
        moved = self._kept @ (z[: self.size] - (self.reference / self._sizes).ravel())
        return np.append(apart.ravel(), moved)

    def _size(self, z: Array) -> float:
        """Return how large the first harmonic is; below zero beyond where it vanishes."""
        parts = (self.reference / self._scales, self.states(z) / self._scales)
        known, first = (np.fft.rfft(part, axis=0)[1] / self.count for part in parts)
        return float((known.conj() @ first).real / np.linalg.norm(known))


@dataclass(frozen=True, eq=False)
class _Linearized:
    """Mismatch and derivatives, of which those of the map at the angles are stored."""

    defect: Array
    matrices: Array  # of the map by the state at each angle, shape (m, n, n)
    turns: float  # rotation number
    by_others: Array  # of the mismatch by what is unknown besides the circle, shape (m n, k + 1)
    circles: Circles

    @property
    def is_finite(self) -> bool:
        parts = self.defect, self.matrices, self.by_others
        return all(np.isfinite(part).all() for part in parts)

    @property
    def jacobian(self) -> Array:
        """All derivatives, shape (m n + k, m n + k + 1)."""
        kept, scales = self.circles._kept, self.circles._scales
        (m, n, _), (free, size) = self.matrices.shape, kept.shape
        jacobian = np.zeros((size + free, size + free + 1))
        circle, place = jacobian[:size, :size].reshape(m, n, m, n), np.arange(m)
        circle[:] = -turning(m, self.turns)[:, None, :, None] * np.eye(n)[:, None, :]
        circle[place, :, place, :] += self.matrices * (scales / scales[:, None])
        jacobian[:size, size:], jacobian[size:, :size] = self.by_others, kept
        return jacobian

    def bordered(self, row: Array) -> WholeMatrix:
        return WholeMatrix(np.vstack([self.jacobian, row]))
