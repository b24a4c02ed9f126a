r"""What modes answer to forces that are polynomials in time, in closed form.

A mode :math:`\ddot m + d \dot m + \omega^2 m = f` of any frequency and damping is solved exactly,
so that an interval may last many of its vibrations.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.collocation_points import CollocationPoints, gauss_points


class SERIES:
    """What gives the integrals; rounding costs two digits at most."""

    nodes: int = 28  # points through which answers to an impulse are interpolated
    far: float = 10.0  # largest exponent of these: far^N N!/(2N)!, their error, is 4e-18
    apart: float = 3.0  # smallest exponent of sums of derivatives of the force over its powers


Some = NDArray[np.inexact]
"""Real numbers; complex ones where derivatives by dampings are taken."""


@dataclass(frozen=True, eq=False)
class Moments:
    """Integrals of the polynomials through s points, up to each point and the end of an interval.

    Places are the points, then the end: s + 1.
    """

    places: Array  # shape (s + 1,)
    nodes: Array  # of interpolation, shape (N,)
    # Of the polynomials L_i through these: int_0^c L_i(c - t) l_k(t) dt, shape (N, s + 1, s)
    through: Array
    begun: Array  # derivatives 0 to s - 1 at the beginning, shape (s, s)
    reached: Array  # the same at the places, shape (s, s + 1, s)
    slopes: Array  # first derivatives at the points, shape (s, s)

    @staticmethod
    @cache
    def of(points: CollocationPoints) -> Moments:
        """Return the integrals of a rule."""
        s, places = len(points.points), np.append(points.points, 1.0)
        between = gauss_points(SERIES.nodes)
        fine = gauss_points((s + SERIES.nodes) // 2)  # exact
        at = places[:, None] * fine.points  # (s + 1, q)
        values = legendre.legvander(2 * at - 1, s - 1) @ points.transform  # (s + 1, q, s)
        left = legendre.legvander(2 * (places[:, None] - at) - 1, SERIES.nodes - 1)
        weights = places[:, None] * fine.weights
        through = np.einsum("jq,jqi,jqk->ijk", weights, left @ between.transform, values)
        found = np.zeros((s, s + 2, s))
        for order in range(s):
            for k, column in enumerate(points.transform.T):
                derived = legendre.legder(column, order) * 2.0**order if order else column
                found[order, :, k] = legendre.legval(2 * np.append(0.0, places) - 1, derived)
        slopes = found[1, 1:-1] if s > 1 else np.zeros((s, s))
        nodes = between.points
        return Moments(places, nodes, through, found[:, 0].copy(), found[:, 1:].copy(), slopes)


class ModalAnswers:
    """Motions of r modes on m intervals: from a state at the beginning, and to polynomial forces.

    Shapes: lengths (m,) in seconds; squares, dampings (r,).
    """

    def __init__(
        self, points: CollocationPoints, lengths: Array, squares: Array, dampings: Some
    ) -> None:
        self.points, self.moments = points, Moments.of(points)
        self.lengths, self.squares = lengths, squares
        h = lengths[:, None]
        # Of modes with an interval as the unit of time, shape (m, r)
        self._stiffness, self._damping = squares * h**2, dampings * h
        self._dampings = dampings

    @cached_property
    def _impulse(self) -> tuple[Some, Some]:
        r"""Answers to a unit impulse at places and nodes, and their rates, (m, r, s + 1 + N).

        They are :math:`e^{-dt/2} \sin(\nu t)/\nu` and its derivative, with the hyperbolic sine for
        what is damped more than critically.
        """
        c = np.concatenate([self.moments.places, self.moments.nodes])
        half, kind = self._damping[..., None] / 2, self._damping.dtype
        turning = self._stiffness[..., None] - half**2
        if (turning.real > 0).all():
            nu = np.sqrt(turning)
            decay, angle = np.exp(-half * c), nu * c
            answer = decay * np.sin(angle) / nu
            return answer, decay * np.cos(angle) - half * answer
        nu = np.sqrt(np.where(turning.real > 0, turning, -turning) + 0 * half)
        nu = np.where(nu == 0, np.asarray(1e-150, dtype=kind), nu)  # critical: t itself
        angle, over = nu * c, turning.real <= 0
        # Decay of the slower of two exponentials, without cancellation
        slower = np.where(over, -self._stiffness[..., None] / np.where(over, half + nu, 1), -half)
        decay = np.exp(slower * c)
        faster = np.expm1(np.where(over, -2 * angle, 0))
        odd = np.where(over, -faster / 2, np.sin(np.where(over, 0, angle)))
        even = np.where(over, 1 + faster / 2, np.cos(np.where(over, 0, angle)))
        answer = decay * odd / nu
        return answer, decay * even - half * answer

    @property
    def _free(self) -> tuple[Some, Some]:
        """The same at the places alone, shape (m, r, s + 1)."""
        answer, rate = (part[..., : len(self.moments.places)] for part in self._impulse)
        return answer, rate

    @cached_property
    def transitions(self) -> tuple[Some, ...]:
        """Displacement by displacement and rate, rate by both, at the places, (m, r, s + 1)."""
        impulse, rate = self._free
        h = self.lengths[:, None, None]
        return (
            rate + self._damping[..., None] * impulse,
            impulse * h,
            -self.squares[:, None] * h * impulse,
            rate,
        )

    @cached_property
    def forced(self) -> tuple[Some, Some]:
        """Displacements and rates at the ends, to forces at the points, each (m, r, s)."""
        shape = (*self._stiffness.shape, len(self.points.points))
        moved, moving = (np.zeros(shape, dtype=self._damping.dtype) for _ in range(2))
        for part in self._parts:
            some = part.modes
            for result, ends in zip((moved, moving), part.ends(), strict=True):
                result[:, some] += ends * part.mask[..., None]
        h = self.lengths[:, None, None]
        return moved * h**2, moving * h

    def motions(self, by_displacement: Array, by_rate: Array) -> Some:
        """Return weighted sums over the modes of the same at the points, (m, c, s, s).

        Only sums are formed of what there is of each mode at each point. Shapes: weights (c, r).
        """
        m, s = len(self.lengths), len(self.points.points)
        h = self.lengths[:, None, None]
        result = np.zeros((m, len(by_rate), s, s), dtype=self._damping.dtype)
        for part in self._parts:
            weights = (
                part.mask[:, None] * (h**2 * by_displacement[:, part.modes]),
                part.mask[:, None] * (h * by_rate[:, part.modes]),
            )
            result += part.sums(*weights)
        return result

    @cached_property
    def _parts(self) -> list[_Near | _Far | _Split]:
        """The modes by what gives their integrals, which may differ between intervals."""
        theta, half = self._stiffness, self._damping.real / 2
        nu = np.sqrt(np.abs(theta - half**2))
        over = theta < half**2
        vibration = np.sqrt(np.abs(theta))  # below zero only if `over`: rounding of a free mode
        slow = np.where(over, theta / np.maximum(half + nu, 1e-300), vibration)
        fast = np.where(over, half + nu, vibration)
        near = fast <= SERIES.far
        far = ~near & (slow > SERIES.apart)
        kinds = ((_Near, near), (_Far, far), (_Split, ~near & ~far))
        found = []
        for kind, mask in kinds:
            modes = np.flatnonzero(mask.any(axis=0))
            if len(modes):
                found.append(kind(self, modes, mask[:, modes]))
        return found


@dataclass(frozen=True, eq=False)
class _Part:
    """Integrals of some modes on those intervals where one of three forms serves.

    `mask`, shape (m, q), says where it does; elsewhere numbers are finite, and mean nothing.
    """

    answers: ModalAnswers
    modes: NDArray[np.intp]  # shape (q,)
    mask: NDArray[np.bool_]

    @property
    def stiffness(self) -> Array:
        """Squares of frequencies with an interval as the unit of time, shape (m, q)."""
        return np.where(self.mask, self.answers._stiffness[:, self.modes], self._harmless[0])

    @property
    def damping(self) -> Some:
        """Dampings with an interval as the unit of time, shape (m, q)."""
        return np.where(self.mask, self.answers._damping[:, self.modes], self._harmless[1])

    _harmless = 0.0, 0.0
    """Stiffness and damping where another form serves."""


class _Near(_Part):
    """Answers to an impulse are nearly polynomials in time."""

    @property
    def _nodes(self) -> tuple[Some, Some]:
        """These answers and their rates at the nodes, shape (m, q, N)."""
        count = len(self.answers.moments.places)
        answer, rate = (part[:, self.modes, count:] for part in self.answers._impulse)
        return answer, rate

    def ends(self) -> list[Some]:
        """Displacements and rates at the ends, each (m, q, s)."""
        return [part @ self.answers.moments.through[:, -1] for part in self._nodes]

    def sums(self, by_displacement: Array, by_rate: Array) -> Some:
        """Weighted sums over modes at the points. Shapes: (m, c, q) to (m, c, s, s)."""
        moved, moving = self._nodes
        through = self.answers.moments.through[:, :-1]
        found = (by_displacement @ moved + by_rate @ moving) @ through.reshape(len(through), -1)
        return np.asarray(found.reshape(*found.shape[:2], *through.shape[1:]))


class _Far(_Part):
    """Derivatives of the force over powers of the exponent: a polynomial, and what it leaves.

    The particular solution is a polynomial; a free motion makes up for its initial values.
    """

    _harmless = 4 * SERIES.far**2, 0.0

    @cached_property
    def _polynomials(self) -> tuple[Some, Some]:
        """Displacement and rate by derivatives of the force, shape (s, m, q)."""
        theta, delta = self.stiffness, self.damping
        q = np.empty((len(self.answers.points.points), *theta.shape), dtype=delta.dtype)
        p = np.zeros_like(q)
        q[0], inverse = 1 / theta, -1 / theta
        for order in range(1, len(q)):
            q[order] = (delta * q[order - 1] + p[order - 1]) * inverse
            p[order] = q[order - 1]
        return q, p

    @cached_property
    def _begun(self) -> list[Some]:
        """Displacements and rates of the polynomials at the beginnings, each (m, q, s)."""
        begun = self.answers.moments.begun
        return [_combined(part, begun) for part in self._polynomials]

    @cached_property
    def _left(self) -> tuple[Some, Some, Some, Some]:
        """Displacements and rates at the places by those at beginnings, (m, q, s + 1)."""
        impulse, rate = (
            np.where(self.mask[..., None], item[:, self.modes], 0.0) for item in self.answers._free
        )
        theta, delta = self.stiffness[..., None], self.damping[..., None]
        return rate + delta * impulse, impulse, -theta * impulse, rate

    def ends(self) -> list[Some]:
        """Displacements and rates at the ends, each (m, q, s)."""
        reached = self.answers.moments.reached[:, -1]
        moved, moving = (_combined(part, reached) for part in self._polynomials)
        q, p = self._begun
        qq, qp, pq, pp = (item[..., -1:] for item in self._left)
        return [moved - qq * q - qp * p, moving - pq * q - pp * p]

    def sums(self, by_displacement: Array, by_rate: Array) -> Some:
        """Weighted sums over modes at the points. Shapes: (m, c, q) to (m, c, s, s)."""
        moved, moving = self._polynomials
        parts = (by_displacement @ moved[..., None] + by_rate @ moving[..., None])[..., 0]
        result = _combined(parts, self.answers.moments.reached[:, :-1])
        qq, qp, pq, pp = (np.swapaxes(item[..., :-1], 1, 2)[:, None] for item in self._left)
        q, p = (item[:, None] for item in self._begun)
        by_q, by_p = by_displacement[:, :, None], by_rate[:, :, None]
        return result - (by_q * qq + by_p * pq) @ q - (by_q * qp + by_p * pp) @ p


class _Split(_Part):
    """Strongly damped modes: a slow exponential and a fast one, interpolated and summed."""

    _harmless = 1.0, 4 * SERIES.far

    @cached_property
    def _answers(self) -> list[Some]:
        """Displacements and rates at all places, each (m, q, s + 1, s)."""
        theta, delta = self.stiffness, self.damping
        nu = np.sqrt(delta**2 / 4 - theta)
        fast = -(delta / 2 + nu)
        slow = theta / fast
        moments = self.answers.moments
        through = moments.through
        by_slow = np.exp(slow[..., None] * moments.nodes) @ through.reshape(len(through), -1)
        by_slow = by_slow.reshape(*slow.shape, *through.shape[1:])
        weights = fast ** -(np.arange(len(moments.begun))[:, None, None] + 1.0)
        begun = _combined(weights, moments.begun)
        decay = np.exp(fast[..., None] * moments.places)
        by_fast = decay[..., None] * begun[:, :, None]
        by_fast = by_fast - _combined(weights, moments.reached)
        slow, fast = slow[..., None, None], fast[..., None, None]
        gap = slow - fast
        return [(by_slow - by_fast) / gap, (slow * by_slow - fast * by_fast) / gap]

    def ends(self) -> list[Some]:
        """Displacements and rates at the ends, each (m, q, s)."""
        return [part[:, :, -1] for part in self._answers]

    def sums(self, by_displacement: Array, by_rate: Array) -> Some:
        """Weighted sums over modes at the points. Shapes: (m, c, q) to (m, c, s, s)."""
        moved, moving = (part[:, :, :-1] for part in self._answers)
        found = np.einsum("mcq,mqjk->mcjk", by_displacement, moved)
        return np.asarray(found + np.einsum("mcq,mqjk->mcjk", by_rate, moving))


def _combined(parts: Some, moments: Array) -> Some:
    """Return sums over the first axis of products. Shapes: (p, ...), (p, ...)."""
    rows = parts.reshape(len(parts), -1).T
    return (rows @ moments.reshape(len(parts), -1)).reshape(*parts.shape[1:], *moments.shape[1:])
