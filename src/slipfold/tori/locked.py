"""The interval of the parameter in which motion on tori is locked to an orbit."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from slipfold.arrays import Array
from slipfold.models.turns import without_turns
from slipfold.newton import Rule, find_root
from slipfold.tori.circles import CirclePoint, Circles
from slipfold.tori.harmonics import slopes, turned

PHASES = 12
"""Phases of a locked orbit on its circle at which the parameter is found first."""

RULE = Rule(close=1e-12, iterations=12)


def locked_interval(
    before: CirclePoint, after: CirclePoint, ratio: Fraction
) -> tuple[float, float] | None:
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
    share = (float(ratio) - turns[0]) / (turns[1] - turns[0])
    guess, farthest = ends[0] + share * (ends[1] - ends[0]), 2 * abs(ends[1] - ends[0])
    phases = np.arange(PHASES) / (PHASES * ratio.denominator)
    values = np.array([orbits.value(phase, guess, farthest) for phase in phases])
    if np.isnan(values).any():
        return None
    found = []
    for sign in (1.0, -1.0):
        best = phases[(sign * values).argmin()]
        around = best - phases[1], best + phases[1]
        refined = minimize_scalar(
            lambda phase, sign=sign: np.nan_to_num(
                sign * orbits.value(phase, guess, farthest), nan=np.inf
            ),
            bounds=around,
            method="bounded",
            options={"xatol": 1e-5 * phases[1]},
        )
        found.append(float(sign * min(refined.fun, (sign * values).min())))
    return found[0], found[1]


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
            ends, matrices, pulls = circles.flow.linearise(
                state[None], zero, zero + circles.period * self.returns, constants, along
            )
            apart = without_turns(ends[0] - state, model.whole_turns) / scales
            matrix = np.zeros((len(z), len(z)))
            matrix[:-1, :-1] = matrices[0] * (scales / scales[:, None]) - np.eye(len(state))
            matrix[:-1, -1] = pulls[0][:, 0] * circles.width / scales
            matrix[-1, :-1] = normal
            missed = np.append(apart, normal @ ((state - start[0]) / scales))
            if not np.isfinite(matrix).all():
                return np.full_like(z, np.nan)
            return np.asarray(np.linalg.lstsq(matrix, -missed, rcond=None)[0])

        z = find_root(step, np.append(start[0] / scales, guess / circles.width), RULE)
        value = np.nan if z is None else float(z[-1]) * circles.width
        return value if abs(value - guess) <= farthest else np.nan
