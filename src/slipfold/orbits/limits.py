"""How far an orbit stays from where its model ends."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache

import numpy as np

from slipfold.arrays import Array, Indices
from slipfold.flow.contact_state import Undecided
from slipfold.flow.equations import Constants
from slipfold.flow.flow import Flow
from slipfold.flow.hybrid_trajectory import Broken
from slipfold.flow.modes import UndeterminedMode
from slipfold.models.quantities import Limit
from slipfold.orbits.collocation import Collocation
from slipfold.orbits.extrema import refine_minimum
from slipfold.orbits.orbit_curve import OrbitPoint, Orbits
from slipfold.orbits.switched_shooting import SwitchedShooting


class LIMIT:
    """The search for where an orbit is nearest to a limit."""

    samples: int = 48  # a forcing period, of the first look
    near: float = 0.01  # fraction of scales, or of a swing: orbits of maps move a thousandth of it
    ahead: float = 1e-6  # arclength beyond the last orbit, a thousand times the shortest step
    distance: float = 1e-3  # of its limit from that orbit, in scales: the root of `ahead` at most


def far_above(bounds: Array, swings: Array) -> Array:
    """Return what outputs that swing by so much have to stay above to be far from their bounds.

    Bounds above zero lie a little before a singularity at zero: twice the bound is far from it. Any
    others are values like any other, and what is far is judged by how much the output changes.

    Shapes: bounds (n_limits,); swings (..., n_limits), as is what is returned.
    """
    return np.asarray(bounds + np.where(bounds > 0, bounds, LIMIT.near * swings))


def limit_margins(orbits: Orbits, z: Array) -> tuple[Array, Array]:
    """Return by how much each watched output stays above its bound, and margins far from it.

    The first look is at states that are known, the second samples the orbit evenly. Where an output
    could be lower between samples, by its slope or its bend, its minimum over the continuous orbit
    is computed as closely as it takes to see that it is far above the bound.

    Each has the shape (n_limits,).
    """
    limits = orbits.model.limits
    if not limits:
        return np.empty(0), np.empty(0)
    if not orbits.by.smooth:  # a trajectory that meets a limit ends there: an orbit has met none
        return np.full(len(limits), np.inf), np.zeros(len(limits))
    flow, constants = orbits.flow, orbits.constants(z)
    known = orbits.by.stage_states(orbits.nodes(z), constants)
    if known is not None and len(known[1]) >= LIMIT.samples * orbits.period:
        columns, bounds = _watched(flow, limits)
        values = flow.outputs(*known, constants)[:, columns]
        fall = np.abs(values - np.roll(values, 1, axis=0)).max(axis=0)
        far = far_above(bounds, np.ptp(values, axis=0))
        if (values.min(axis=0) - fall >= far).all():
            return np.asarray(values.min(axis=0) - bounds), far - bounds
    margins, rooms = many_margins(flow, constants, limits, orbits.evenly(z)[None], orbits.period)
    return margins[0], rooms[0]


def margins_at(point: OrbitPoint) -> Array:
    """Return the margins of a point's orbit, computed once: near a singularity that takes long."""
    known = vars(point)
    if "margins" not in known:
        known["margins"], _ = limit_margins(point.curve.orbits, point.z)
    return np.asarray(known["margins"])


def many_margins(
    flow: Flow, constants: Constants, limits: Sequence[Limit], nodes: Array, period: int
) -> tuple[Array, Array]:
    """Return the same of many orbits of a period in slip, from states at equidistant phases.

    Shapes: constants of one or of k orbits; nodes (k, m, n); returns (k, n_limits) each.
    """
    count, segments, n = nodes.shape
    columns, bounds = _watched(flow, limits)
    grid = _grid(segments, period)
    phases, spacing = grid.ravel(), period / grid.size
    each = constants.repeated(segments)
    samples = flow.along(nodes.reshape(-1, n), np.concatenate([grid] * count), each)
    at = np.concatenate([phases] * count)
    values = flow.outputs(samples.reshape(-1, n), at, constants.repeated(grid.size))[:, columns]
    samples, values = samples.reshape(count, -1, n), values.reshape(count, -1, len(limits))
    lowest, far = values.min(axis=1), far_above(bounds, np.ptp(values, axis=1))
    closed = np.concatenate([values[:, -1:], values, values[:, :1]], axis=1)
    steps = closed[:, 1:] - closed[:, :-1]
    bends = steps[:, 1:] - steps[:, :-1]
    fall = np.minimum(np.abs(steps).max(axis=1), np.abs(bends).max(axis=1))
    rows, near = (lowest - fall < far).nonzero()
    if len(rows):
        before = values[rows, :, near].argmin(axis=1) - 1  # -1 is the last sample: it is closed
        lowest[rows, near] = refine_minimum(
            flow,
            constants.rows(rows),
            samples[rows, before],
            phases[before],
            spacing,
            columns[near],
            np.ones(len(rows)),
            far[rows, near],
        )
    return np.asarray(lowest - bounds), far - bounds


def _watched(flow: Flow, limits: Sequence[Limit]) -> tuple[Indices, Array]:
    """Return the columns of outputs that limits watch, and their bounds."""
    columns = [flow.output_index(limit.output) for limit in limits]
    return np.array(columns, dtype=np.int64), np.array([limit.bound for limit in limits])


def limit_met(margins: Array, before: Array | None) -> int:
    """Return the number of the limit that a curve ends at, by its margins there and shortly before.

    Of that next to nothing is left of what was left, in whatever units; none may be known before.
    """
    return int((margins / (np.ones(len(margins)) if before is None else before)).argmin())


def is_singular_near(orbits: Orbits, z: Array) -> bool:
    """Whether the equations have no value somewhere beside an orbit."""
    if not orbits.by.smooth:
        return False
    flow, constants = orbits.flow, orbits.constants(z)
    if isinstance(orbits.by, Collocation):  # explicit steps may not come through what is stiff
        samples, phases = orbits.by.stage_states(orbits.nodes(z), constants)
        if not np.isfinite(samples).all():  # where nothing but the nodes is found again
            samples, phases = orbits.nodes(z), orbits.by.start
    else:
        nodes = orbits.evenly(z)
        grid = _grid(len(nodes), orbits.period)
        samples, phases = flow.along(nodes, grid, constants).reshape(grid.size, -1), grid.ravel()
    around = LIMIT.near * np.diag(orbits.scales)
    return not all(
        np.isfinite(flow.rates(samples + step, phases, constants)).all()
        for step in (*around, *-around)
    )


@cache
def _grid(segments: int, period: int) -> Array:
    """Phases of the first look, shape (segments, samples on each)."""
    each = -(-LIMIT.samples * period // segments)
    spacing = period / (segments * each)
    phases: Array = np.arange(segments * each, dtype=float) * spacing
    return phases.reshape(segments, each)


def broken_limit(orbits: Orbits, z: Array) -> str | None:
    """Return the sentence of a limit that an orbit breaks, None if it breaks none."""
    for limit, margin in zip(orbits.model.limits, limit_margins(orbits, z)[0], strict=True):
        if not margin > 0:
            return limit.reason.format(value=margin + limit.bound)
    return None


def limit_ahead(orbits: Orbits, last: OrbitPoint) -> str | None:
    """Return the sentence of the limit that orbits meet just beyond the last one, None if none.

    No orbit meets it, and so nothing along the curve changes its sign. But a trajectory from where
    the next orbit is expected does.
    """
    by, expected = orbits.by, last.z + LIMIT.ahead * last.tangent
    if not isinstance(by, SwitchedShooting) or not by.switched.limits:
        return None
    nodes, constants = orbits.nodes(expected), orbits.constants(expected)
    try:
        by.motion(nodes[0], float(by.start[0]), float(by.end[0]), constants)
    except Broken as broken:
        return broken.stop.reason if _is_at_limit(broken, orbits, last) else None
    except (Undecided, UndeterminedMode):
        return None
    return None


def _is_at_limit(broken: Broken, orbits: Orbits, last: OrbitPoint) -> bool:
    """Whether a trajectory ends at a limit near the last orbit."""
    by, part = orbits.by, broken.part
    assert isinstance(by, SwitchedShooting)
    if part is None or broken.stop.kind not in {limit.name for limit in by.switched.limits}:
        return False
    at = np.array([part.end])
    state = by.states(orbits.nodes(last.z), orbits.constants(last.z), at)[0]
    return float(np.linalg.norm((part.state - state) / by.scales)) < LIMIT.distance
