"""Resonances: the interval in which tori are locked to an orbit, and the tori beyond it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np

from slipfold.arrays import Array
from slipfold.bifurcations.tori.circles import (
    RESONANCES,
    TORUS,
    Circles,
    resampled,
    slopes,
    tail,
    turned,
)
from slipfold.continuation.curve import Point
from slipfold.continuation.interpolation import lagrange
from slipfold.continuation.traced_curve import TracedCurve
from slipfold.models.angles import wrap_angles
from slipfold.newton import Rule, find_root

RULE = Rule(close=1e-12, iterations=12)


def locked_interval(before: Point, after: Point, ratio: Fraction) -> tuple[float, float] | None:
    r"""Return the ends of the interval in which orbits lie on the torus; None if none was found.

    An orbit that closes after q returns is looked for at each phase of the circle, with the
    parameter free: :math:`P^q(u; \lambda) = u` and u on a line across the circle. As the phase goes
    round, the parameter goes to and fro: its extremes are the folds of the locked orbits, where
    the resonance tongue ends.
    """
    from scipy.optimize import minimize_scalar

    near = min(before, after, key=lambda each: abs(each.curve.rotation(each.z) - float(ratio)))
    circles = near.curve
    if not circles.model.forced:
        return None
    orbits = _LockedOrbits(circles, circles.states(near.z), ratio.denominator)
    turns = [point.curve.rotation(point.z) for point in (before, after)]
    ends = [point.curve.value(point.z) for point in (before, after)]
    fraction = (float(ratio) - turns[0]) / (turns[1] - turns[0])
    guess, farthest = ends[0] + fraction * (ends[1] - ends[0]), 2 * abs(ends[1] - ends[0])
    phases = np.arange(TORUS.phases) / (TORUS.phases * ratio.denominator)
    values = np.array([orbits.value(phase, guess, farthest) for phase in phases])
    if np.isnan(values).any():
        return None
    result = []
    for sign in (1.0, -1.0):
        best, worst = phases[(sign * values).argmin()], float((sign * values).max())
        around = best - phases[1], best + phases[1]
        refined = minimize_scalar(
            lambda phase, sign=sign, worst=worst: np.nan_to_num(
                sign * orbits.value(phase, guess, farthest), nan=worst
            ),
            bounds=around,
            method="bounded",
            options={"xatol": 1e-5 * phases[1]},
        )
        result.append(float(sign * min(refined.fun, (sign * values).min())))
    return result[0], result[1]


@dataclass(frozen=True, eq=False)
class _LockedOrbits:
    """Orbits near a circle that close after some returns."""

    circles: Circles
    states: Array  # of the circle, shape (m, n)
    returns: int

    def value(self, phase: float, guess: float, farthest: float) -> float:
        """Return the parameter at which one lies at a phase of the circle; NaN if none is near."""
        circles = self.circles
        model, scales = circles.model, circles.model.state_scales()
        start = turned(self.states, phase)
        normal = slopes(start)[0] / scales
        normal /= np.linalg.norm(normal)
        index = [model.parameter_index(circles.vary)]

        def step(z: Array) -> Array:
            state, value = z[:-1] * scales, float(z[-1]) * circles.width
            if not abs(value - guess) <= farthest:
                return np.full_like(z, np.nan)
            constants = circles.flow.constants_of(model.replace(**{circles.vary: value}))
            zero, along = np.zeros(1), constants.rates[:, index]
            ends, matrices, by_parameters = circles.flow.linearize(
                state[None], zero, zero + circles.period * self.returns, constants, along
            )
            apart = wrap_angles(ends[0] - state, model.angle_periods) / scales
            matrix = np.zeros((len(z), len(z)))
            matrix[:-1, :-1] = matrices[0] * (scales / scales[:, None]) - np.eye(len(state))
            matrix[:-1, -1] = by_parameters[0][:, 0] * circles.width / scales
            matrix[-1, :-1] = normal
            missed = np.append(apart, normal @ ((state - start[0]) / scales))
            if not np.isfinite(matrix).all():
                return np.full_like(z, np.nan)
            return np.asarray(np.linalg.lstsq(matrix, -missed, rcond=None)[0])

        z = find_root(step, np.append(start[0] / scales, guess / circles.width), RULE)
        value = np.nan if z is None else float(z[-1]) * circles.width
        return value if abs(value - guess) <= farthest else np.nan


BEYOND = (1.0, 2.0, 0.5)
"""Multiples of that distance at which a circle is searched on the other side."""


def past_resonance(traced: TracedCurve[Point]) -> tuple[Circles, Point] | None:
    """Return a circle on the other side of the resonance at which tori ended.

    Near the resonance the states accumulate where the locked orbits will be, and harmonics grow. An
    earlier circle is not affected yet, and is extrapolated across by the rotation number. In the
    same way a strong resonance may be passed at which only the angles on the circle are free.
    """
    if traced.end is None or traced.end.kind not in ("broken", "failed", "resonance"):
        return None
    last = traced.points[-1]
    away = {ratio: last.curve.rotation(last.z) - float(ratio) for ratio in RESONANCES}
    ratio = min(away, key=lambda each: abs(away[each]))
    if abs(away[ratio]) > TORUS.squeezed:
        return None
    rotation = float(ratio)
    # The last circle may lie on it, or to either side by rounding.
    apart = [point for point in traced.points if abs(point.z[-2] - rotation) > TORUS.squeezed]
    side = float(np.sign(apart[-1].z[-2] - rotation)) if apart else 0.0
    known = [point for point in apart if side * (point.z[-2] - rotation) > 0][-TORUS.history :]
    for times in BEYOND if len(known) > 1 else ():
        result = _at(known, rotation - side * times * TORUS.squeezed, -side)
        if result is not None:
            length = abs(result.z[-1] - last.z[-1]) + abs(result.z[-2] - last.z[-2])
            return result.curve, replace(result, arclength=last.arclength + length)
    return None


def _at(known: list[Point], rotation: float, side: float) -> Point | None:
    """Return the circle of a rotation number as others let expect it."""
    last = known[-1].curve
    circles = last.described_at(known[-1].z, last.count)
    unknowns = []
    for point in known:
        states = resampled(point.curve.states(point.z), circles.count)
        unknowns.append(circles.join(states, point.z[point.curve.size :]))
    others = np.array(unknowns)
    guess = lagrange(others[:, -2].tolist(), rotation) @ others
    row = np.zeros(len(guess))
    row[-2] = side
    found = circles.nearest(guess, row)
    resolved = found is not None and tail(circles.states(found.z)) <= 1e3 * TORUS.tail
    return found if resolved else None
