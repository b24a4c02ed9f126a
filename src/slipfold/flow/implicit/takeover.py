"""Where implicit steps take a motion over: fast decay, and nothing else, makes others short."""

from __future__ import annotations

from typing import Any

import numpy as np

from slipfold.arrays import Array
from slipfold.flow.dense_motion import DenseMotion
from slipfold.flow.equations import Constants
from slipfold.flow.evaluated import Evaluated
from slipfold.flow.implicit.intervals import Field, solve_intervals
from slipfold.flow.implicit.stage_equations import LinearPart
from slipfold.flow.implicit.steps import MOST, POINTS, End, ImplicitMotion, Watch, implicit_motion

LIMITED = 1.0
"""Decay in a step, as an exponent, from which on it is that short for its sake: Taylor's method of
order 16 is stable up to six or so, and what it resolves it resolves in a few tenths."""


class Takeover:
    """Goes on implicitly from where one motion's integrator is."""

    def __init__(self, flow: Evaluated, constants: Constants) -> None:
        self.field = Field(flow, constants, constants.scales, [], LinearPart())

    def is_due(self, single: Any) -> bool:
        """Whether the integrator's last step was short since something decays fast."""
        state, phase = np.array(single.state)[None], np.array([single.time])
        jacobian = self.field.jacobians(state, phase)[0]
        if not np.isfinite(jacobian).all():
            return False
        values = np.linalg.eigvals(jacobian)
        fastest = values[np.abs(values).argmax()]
        decays = fastest.real < -abs(fastest.imag)
        return bool(decays and abs(single.last_h * fastest) > LIMITED)

    def motion(
        self, single: Any, end: float, *, watch: Watch | None = None, most: int = MOST
    ) -> ImplicitMotion:
        """Return the rest of a motion up to an end."""
        state, phase = np.array(single.state), float(single.time)
        return implicit_motion(self.field, state, phase, end, watch=watch, most=most)

    def period(self, state: Array) -> DenseMotion | None:
        """Return a motion over the first period, None where it does not come to its end.

        Shapes: state (n,).
        """
        known = implicit_motion(self.field, state / self.field.scales, 0.0, 1.0)
        if known.end is not End.ARRIVED or known.polynomials is None:
            return None
        times = known.polynomials.times
        return DenseMotion(times, known.polynomials, self.field.scales, implicit=True)

    def through(self, single: Any, times: Array) -> Array:
        """Return the states of the rest of a motion at some times, NaN where it does not come.

        Shapes: times (p,); returns (p, n).
        """
        states = np.full((len(times), len(single.state)), np.nan)
        known = self.motion(single, float(times[-1]))
        if known.polynomials is not None:
            reached = times <= known.phase
            states[reached] = known.polynomials(times[reached])
        return states

    def matrices(self, motion: DenseMotion, edges: Array) -> Array:
        """Return the derivatives of a motion's scaled states from one of some phases to the next.

        Shapes: edges (m + 1,); returns (m, n, n).
        """
        lengths = np.diff(edges)
        phases = edges[:-1, None] + lengths[:, None] * POINTS.points
        nodes, stages = (
            motion.at(times.ravel()).reshape(*times.shape, -1) / motion.scales
            for times in (edges[:-1], phases)
        )
        return solve_intervals(self.field, POINTS, nodes, edges[:-1], lengths, stages).matrices
