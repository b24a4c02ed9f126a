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


@dataclass(frozen=True)
class SeriesRule:
    """Which of two series gives the integrals; rounding costs either two digits at most."""

    powers: int = 36  # terms of the series in powers of the exponent
    far: float = 5.0  # largest exponent of it: the last term is 1e-16 of the first
    apart: float = 3.0  # smallest exponent of the other: a sum of derivatives, over its powers
    enough: float = 1e-18  # terms below it are left out


SERIES = SeriesRule()


@dataclass(frozen=True, eq=False)
class Moments:
    """Integrals of the polynomials through s points, up to each point and the end of an interval.

    Places are the points, then the end: s + 1.
    """

    places: Array  # shape (s + 1,)
    # Of powers of the time left: int_0^c (c - t)^p l_k(t) dt, shape (powers, (s + 1) s)
    powers: Array
    begun: Array  # derivatives 0 to s - 1 at the beginning, shape (s, s)
    reached: Array  # the same at the places, shape (s, (s + 1) s)
    slopes: Array  # first derivatives at the points, shape (s, s)

    @staticmethod
    @cache
    def of(points: CollocationPoints) -> Moments:
        """Return the integrals of a rule."""
        s, places = len(points.points), np.append(points.points, 1.0)
        fine = gauss_points(s + SERIES.powers // 2 + 2)
        at = places[:, None] * fine.points  # (s + 1, q)
        values = legendre.legvander(2 * at - 1, s - 1) @ points.transform  # (s + 1, q, s)
        left = places[:, None] * (1 - fine.points)
        weights = places[:, None] * fine.weights
        powers = np.arange(SERIES.powers)[:, None, None]
        moments = np.einsum("pjq,jqk->pjk", weights * left**powers, values)
        found = np.zeros((s, s + 2, s))
        for order in range(s):
            for k, column in enumerate(points.transform.T):
                derived = legendre.legder(column, order) * 2.0**order if order else column
                found[order, :, k] = legendre.legval(2 * np.append(0.0, places) - 1, derived)
        reached = found[:, 1:].reshape(s, -1)
        slopes = found[1, 1:-1] if s > 1 else np.zeros((s, s))
        return Moments(
            places, moments.reshape(SERIES.powers, -1), found[:, 0].copy(), reached, slopes
        )


class ModalAnswers:
    """Motions of r modes on m intervals: from a state at the beginning, and to polynomial forces.

    Shapes: lengths (m,) in seconds; squares, dampings (r,).
    """

    def __init__(
        self,
        points: CollocationPoints,
        lengths: Array,
        squares: Array,
        dampings: NDArray[np.inexact],
    ) -> None:
        self.points, self.moments = points, Moments.of(points)
        self.lengths, self.squares = lengths, squares
        h = lengths[:, None]
        # Of modes with an interval as the unit of time, shape (m, r)
        self._stiffness, self._damping = squares * h**2, dampings * h
        self._dampings = dampings

    @cached_property
    def _free(self) -> tuple[NDArray[np.inexact], NDArray[np.inexact]]:
        r"""Answers to a unit impulse at the places, and their rates, shape (m, r, s + 1).

        They are :math:`e^{-dt/2} \sin(\nu t)/\nu` and its derivative, with the hyperbolic sine for
        what is damped more than critically.
        """
        c = self.moments.places
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

    @cached_property
    def transitions(self) -> tuple[NDArray[np.inexact], ...]:
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
    def forced(self) -> tuple[NDArray[np.inexact], NDArray[np.inexact]]:
        """Displacements and rates at the places, to forces at the points: (m, r, s + 1, s)."""
        s = len(self.points.points)
        theta, delta = self._stiffness, self._damping
        half = delta.real / 2
        nu = np.sqrt(np.abs(theta - half**2))
        over = theta < half**2
        slow = np.where(over, theta / np.maximum(half + nu, 1e-300), np.sqrt(theta))
        fast = np.where(over, half + nu, np.sqrt(theta))
        near, far = fast <= SERIES.far, slow > SERIES.apart
        shape = (*theta.shape, s + 1, s)
        moved = np.empty(shape, dtype=delta.dtype), np.empty(shape, dtype=delta.dtype)
        for some, series in ((near, self._near), (~near & far, self._far)):
            if some.any():
                for result, part in zip(moved, series(some), strict=True):
                    result[some] = part.reshape(-1, s + 1, s)
        if (mixed := ~near & ~far).any():
            for result, part in zip(moved, self._split(mixed), strict=True):
                result[mixed] = part.reshape(-1, s + 1, s)
        h = self.lengths[:, None, None, None]
        return moved[0] * h**2, moved[1] * h

    def _near(self, some: NDArray[np.bool_]) -> tuple[NDArray[np.inexact], NDArray[np.inexact]]:
        """Powers of the exponent: the answer to an impulse as a series in time."""
        theta, delta = self._stiffness[some], self._damping[some]
        largest = max(float(theta.max()) ** 0.5, float(np.abs(delta).max()))
        terms = np.cumprod(np.append(1.0, max(largest, 1e-3) / np.arange(1, SERIES.powers)))
        count = int((terms > SERIES.enough).sum())
        series = np.zeros((count + 1, len(theta)), dtype=delta.dtype)
        series[1] = 1.0
        for p in range(1, count):
            series[p + 1] = -(delta * series[p] + theta * series[p - 1] / p) / (p + 1)
        moments = self.moments.powers[:count]
        rates = series[1:] * np.arange(1, count + 1)[:, None]
        return series[:count].T @ moments, rates.T @ moments

    def _far(self, some: NDArray[np.bool_]) -> tuple[NDArray[np.inexact], NDArray[np.inexact]]:
        """Derivatives of the force over powers of the exponent: a polynomial, and what it leaves.

        The particular solution is a polynomial; a free motion makes up for its initial values.
        """
        theta, delta = self._stiffness[some], self._damping[some]
        s = len(self.points.points)
        q = np.empty((s, len(theta)), dtype=delta.dtype)
        p = np.empty((s, len(theta)), dtype=delta.dtype)
        q[0], p[0] = 1 / theta, 0.0
        for order in range(1, s):
            q[order] = -(delta * q[order - 1] + p[order - 1]) / theta
            p[order] = q[order - 1]
        begun, reached = self.moments.begun, self.moments.reached
        start_q, start_p = (item.T @ begun for item in (q, p))
        impulse, rate = (item[some][:, :, None] for item in self._free)
        free_q = rate + delta[:, None, None] * impulse
        shape = (len(theta), s + 1, s)
        displaced = (q.T @ reached).reshape(shape)
        displaced = displaced - free_q * start_q[:, None] - impulse * start_p[:, None]
        moving = (p.T @ reached).reshape(shape)
        moving = moving + theta[:, None, None] * impulse * start_q[:, None]
        return displaced, moving - rate * start_p[:, None]

    def _split(self, some: NDArray[np.bool_]) -> tuple[NDArray[np.inexact], NDArray[np.inexact]]:
        """Strongly damped modes: a slow exponential and a fast one, each by its own series."""
        theta, delta = self._stiffness[some], self._damping[some]
        nu = np.sqrt(delta**2 / 4 - theta)
        fast = -(delta / 2 + nu)
        slow = theta / fast
        s, moments = len(self.points.points), self.moments
        orders = np.arange(SERIES.powers)[:, None]
        factorials = np.cumprod(np.append(1.0, np.arange(1, SERIES.powers)))[:, None]
        by_slow = (slow**orders / factorials).T @ moments.powers
        weights = fast ** -(np.arange(s)[:, None] + 1.0)
        begun, reached = weights.T @ moments.begun, weights.T @ moments.reached
        decay = np.exp(fast[:, None] * moments.places)
        by_fast = decay[..., None] * begun[:, None] - reached.reshape(-1, s + 1, s)
        by_fast = by_fast.reshape(len(theta), -1)
        gap = (slow - fast)[:, None]
        return (
            (by_slow - by_fast) / gap,
            (slow[:, None] * by_slow - fast[:, None] * by_fast) / gap,
        )
