"""How finely a motion that nothing forces is to be kept: by its own time, not by a second."""

from __future__ import annotations

import math

import numpy as np

from slipfold.arrays import Array
from slipfold.flow.flow import flow_of
from slipfold.models.evaluation import evaluation_of
from slipfold.models.model import Model
from slipfold.models.parameter import DURATION

EXPLORED = 500
"""Steps of the integrator from which the pace of a motion is taken: ten rounds of a smooth one."""

INTERVALS = 20
"""Intervals that these make: a round is about two of them."""

LONGEST = 8.0
"""Intervals this many times as long are divided: the integrator's steps within are bounded."""

FASTEST = 12.0
"""Angle, or growth, of the fastest eigenvalue in an interval at most: a motion that begins small
takes longer steps at first than later."""

FARTHEST = 1e4
"""Times of the fastest rate that are explored: a motion that slows down sets no pace."""


def paced(model: Model, state: Array, periods: int | None) -> tuple[Model, int | None]:
    """Return an autonomous model whose ``duration`` suits its motion, and how many it lasts."""
    unit = model.values[DURATION.name]
    natural = _natural(model, state)
    if periods is None and unit == DURATION.default:
        return model.replace(**{DURATION.name: natural}), None
    return divided(model, periods, math.ceil(unit / natural) if unit > LONGEST * natural else 1)


def divided(model: Model, periods: int | None, parts: int = 8) -> tuple[Model, int | None]:
    """Return an autonomous model with a part of its ``duration``, and how many these are."""
    if parts == 1:
        return model, periods
    shorter = model.replace(**{DURATION.name: model.values[DURATION.name] / parts})
    return shorter, None if periods is None else periods * parts


def _natural(model: Model, state: Array) -> float:
    """Return a time of which a motion has two or so a round, rounded to 1, 2 or 5."""
    scales = model.state_scales()
    jacobian = evaluation_of(model).jacobian(model, state) * (scales / scales[:, None])
    if not np.isfinite(jacobian).all():
        return DURATION.default
    values = np.linalg.eigvals(jacobian)
    fastest = float(np.abs(values).max())
    if not fastest > 0:
        return DURATION.default
    flow = flow_of(model.replace(**{DURATION.name: 1.0}))
    constants = flow.constants_of(model.replace(**{DURATION.name: 1.0}))
    motion = flow.dense(state, constants, FARTHEST / fastest, EXPLORED)
    if motion is not None and motion.implicit:  # what decays at once sets no pace
        slower = np.abs(values[values.real > -np.abs(values.imag)])
        fastest = float(slower.max(initial=0.0)) or fastest
        motion = flow.dense(state, constants, FARTHEST / fastest, EXPLORED)
    if motion is None:
        return DURATION.default
    return rounded_down(min(motion.end / INTERVALS, FASTEST / fastest))


def rounded_down(length: float) -> float:
    """Return the next shorter length that is 1, 2 or 5 with a power of ten."""
    magnitude = 10.0 ** math.floor(math.log10(length))
    return magnitude * max(step for step in (1, 2, 5) if step * magnitude <= length * 1.000001)
