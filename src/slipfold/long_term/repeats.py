"""After how many forcing periods motions repeat, and what they reach in between."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.flow.ensembles import TOGETHER, March
from slipfold.flow.flow import flow_of
from slipfold.models.model import Model
from slipfold.models.turns import without_turns

FLOOR = 1e-8
"""Change in scales, from one response to the next, that errors of steps may make."""

FADES = 1e-5
"""Change in scales over a part of a period below which that part is the period."""

NEAR = 1e-3
"""Distance in scales that a motion may still be away from the response it comes to."""

AROUND = 4.0
"""Distances from a response between which states lie that wind round it."""

SHRINKS = 0.9
"""Ratio of the changes at the end and at the beginning below which they shrink."""


def repeats_of(states: Array, scales: Array, turns: Array, longest: int = 16) -> NDArray[np.int64]:
    """Return after how many states each motion repeats; 0 where that cannot be said.

    The change over a period either is no more than errors of steps, or shrinks by so much that what
    is still to come, a geometric series, is little. A motion that winds round a response on its way
    there nearly repeats after each turn: the period is the shortest after which it is not farther
    away than that. Of one that repeats after two periods, but moves next to nothing in one, that
    movement is still to fade.

    Shapes: states (..., m, n); scales, turns (n,); returns (...).
    """
    count = states.shape[-2]
    found = np.zeros(states.shape[:-2], np.int64)
    changes, left = {}, np.zeros(states.shape[:-2])
    for period in range(1, min(longest, count // 3) + 1):
        apart = without_turns(states[..., period:, :] - states[..., :-period, :], turns) / scales
        change = np.abs(apart).max(axis=-1)
        width = max(change.shape[-1] // 3, 1)
        first, last = change[..., :width].max(axis=-1), change[..., -width:].max(axis=-1)
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = last / first
            rate = ratio ** (period / (change.shape[-1] - width))
            rest = last * rate / (1 - rate)
        settles = (last <= FLOOR) | ((ratio < SHRINKS) & (rest <= NEAR))
        new = settles & (found == 0)
        found[new], left[new] = period, np.where(last <= FLOOR, FLOOR, rest)[new]
        changes[period] = last
    for period in sorted(changes, reverse=True):
        within = (found % period == 0) & (found > 0) & (changes[period] <= AROUND * left)
        found[within] = period
    for period in sorted(changes, reverse=True):
        found[(found > period) & (found % period == 0) & (changes[period] <= FADES)] = period
    return found


def sampled_outputs(model: Model, vary: str, values: Array, states: Array, samples: int) -> Array:
    """Return all outputs at equal intervals of the forcing period that follows each state.

    NaN of a motion that sticks.

    Shapes: values (m,); states (m, n); returns (m, samples, n_outputs).
    """
    flow = flow_of(model)
    parameters = np.tile(model.vector, (len(values), 1))
    parameters[:, [item.name for item in model.parameters].index(vary)] = values
    scales = np.tile(flow.constants_of(model).scales, (len(values), 1))
    found = np.empty((len(values), samples, len(flow.output_names)))
    phases = np.arange(samples) / samples
    for first in range(0, len(values), TOGETHER):
        some = slice(first, first + TOGETHER)
        constants = flow.constants(parameters[some], scales[some])
        between = states[None, some]
        if samples > 1:
            march = March(model, constants)
            between = march.samples(states[some].T, samples).transpose(0, 2, 1)
        for place, phase in enumerate(phases):
            rows = np.full(between.shape[1], phase)
            found[some, place] = flow.outputs(between[place], rows, constants)
    return found


def reached(values: Array, measure: str) -> Array:
    """Return what an output reaches in each period: its extremes lie on parabolas.

    Shapes: values (m, samples), of a period and the first one of the next; returns (m,).
    """
    high, low = _peak(values), -_peak(-values)
    return {"max": high, "min": low, "peak_to_peak": high - low}.get(
        measure, np.maximum(np.abs(high), np.abs(low))
    )


def _peak(values: Array) -> Array:
    rows = np.arange(len(values))
    place = np.clip(values.argmax(axis=1), 1, values.shape[1] - 2)
    before, here, after = (values[rows, place + shift] for shift in (-1, 0, 1))
    bend = before - 2 * here + after
    with np.errstate(divide="ignore", invalid="ignore"):
        top = here - (after - before) ** 2 / (8 * bend)
    inside = (bend < 0) & (np.abs(after - before) <= -2 * bend)
    return np.where(inside, top, values.max(axis=1))
