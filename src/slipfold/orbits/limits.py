"""How far an orbit stays from where its model ends."""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

from slipfold.orbits.extrema import refine_minimum
from slipfold.orbits.orbit_curve import Orbits

__all__ = ["broken_limit", "limit_margins", "limit_met", "loses_equations"]

Array = NDArray[np.float64]

SAMPLES = 48
"""Samples a forcing period of the first look."""

BESIDE = 0.01
"""Distance from an orbit, in typical sizes, within which equations are tried: samples may lie that
far from where it comes nearest to a singularity."""


def limit_margins(orbits: Orbits, z: Array) -> Array:
    """Return by how much each watched output stays above its bound over the orbit.

    The first look is at states that are known anyway, the second samples the orbit evenly. Between
    samples an output may be lower by what its slope allows, or its bend, an eighth of which is the
    fall of a parabola below its lowest sample; where that could matter, its minimum over the
    continuous orbit is found.

    Returns shape (n_limits,).
    """
    limits = orbits.model.limits
    if not limits:
        return np.empty(0)
    if not orbits.by.smooth:  # a motion that meets a limit ends there: an orbit has met none
        return np.full(len(limits), np.inf)
    flow, constants = orbits.flow, orbits.constants(z)
    columns = [flow.output_index(limit.output) for limit in limits]
    bounds = np.array([limit.bound for limit in limits])
    known = orbits.by.passed_through(orbits.nodes(z), constants)
    if known is not None and len(known[1]) >= SAMPLES * orbits.period:
        values = flow.outputs(*known, constants)[:, columns]
        fall = np.abs(values - np.roll(values, 1, axis=0)).max(axis=0)
        if (values.min(axis=0) - fall >= 2 * bounds).all():
            return np.asarray(values.min(axis=0) - bounds)
    nodes = orbits.evenly(z)
    grid = _grid(len(nodes), orbits.period)
    phases, spacing = grid.ravel(), orbits.period / grid.size
    samples = flow.along(nodes, grid, constants).reshape(grid.size, -1)
    values = flow.outputs(samples, phases, constants)[:, columns]
    lowest = values.min(axis=0)
    closed = np.concatenate([values[-1:], values, values[:1]])
    steps = closed[1:] - closed[:-1]
    bends = steps[1:] - steps[:-1]
    fall = np.minimum(np.abs(steps).max(axis=0), np.abs(bends).max(axis=0))
    for i in (lowest - fall < 2 * bounds).nonzero()[0]:
        before = [int(values[:, i].argmin()) - 1]  # -1 is the last sample: the orbit is closed
        lowest[i] = refine_minimum(
            flow,
            constants,
            samples[before],
            phases[before],
            spacing,
            np.array([columns[i]]),
            np.ones(1),
        )[0]
    return lowest - bounds


def limit_met(margins: Array, before: Array | None) -> int:
    """Return the number of the limit that a curve ends at, by its margins there and shortly before.

    Of that next to nothing is left of what was left, in whatever units; none may be known before.
    """
    return int((margins / (np.ones(len(margins)) if before is None else before)).argmin())


def loses_equations(orbits: Orbits, z: Array) -> bool:
    """Whether the equations have no value somewhere beside an orbit."""
    if not orbits.by.smooth:
        return False
    flow, constants, nodes = orbits.flow, orbits.constants(z), orbits.evenly(z)
    grid = _grid(len(nodes), orbits.period)
    samples = flow.along(nodes, grid, constants).reshape(grid.size, -1)
    around = BESIDE * np.diag(orbits.scales)
    return not all(
        np.isfinite(flow.rates(samples + step, grid.ravel(), constants)).all()
        for step in (*around, *-around)
    )


@cache
def _grid(segments: int, period: int) -> Array:
    """Phases of the first look, shape (segments, samples on each)."""
    each = -(-SAMPLES * period // segments)
    spacing = period / (segments * each)
    phases: Array = np.arange(segments * each, dtype=float) * spacing
    return phases.reshape(segments, each)


def broken_limit(orbits: Orbits, z: Array) -> str | None:
    """Return the sentence of a limit that an orbit breaks, None if it breaks none."""
    for limit, margin in zip(orbits.model.limits, limit_margins(orbits, z), strict=True):
        if not margin > 0:
            return limit.reason.format(value=margin + limit.bound)
    return None
