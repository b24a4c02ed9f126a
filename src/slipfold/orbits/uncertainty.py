"""How far an orbit and its multipliers can be trusted: computed again, and what rounding can do."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Hashable, Mapping, Sequence
from contextlib import suppress
from typing import Any, NamedTuple

import numpy as np

from slipfold.arrays import Array, Complex
from slipfold.continuation.newton import NEWTON, correct
from slipfold.errors import BREAKDOWNS, InputError
from slipfold.models.model import Model
from slipfold.orbits.continued import (
    ROUNDING,
    by_mesh_shooting,
    hold_parameter,
    on_mesh,
    parameter_rounding,
)
from slipfold.orbits.discretization import RADAU, Cut, damps_stiff
from slipfold.orbits.kinds import Equilibria, ForcedOrbits, orbits_at
from slipfold.orbits.modal_shooting import shooting_for
from slipfold.orbits.multipliers import product
from slipfold.orbits.orbit_batch import EXACTLY, OrbitBatch
from slipfold.orbits.orbit_curve import OrbitCurve, OrbitPoint
from slipfold.orbits.shooting import SEGMENT_GROWTH, Shooting, growth_within
from slipfold.orbits.test_functions import floquet_multipliers, match_multipliers

SPREAD = 2.0
"""Two computations differ by a sample of both their errors; one twice as large is no surprise."""


def multiplier_rounding(monodromy: Array, multipliers: Complex, size: float = 1.0) -> Array:
    r"""Return what rounding of the monodromy matrix can do to each multiplier, shape (n,).

    An eigenvalue with left and right vectors l, r moves by :math:`|l| |r| / |l^* r|` times the
    change of the matrix, n roundings of its norm, or of `size` if that is more; where that grows
    without bound, two eigenvalues meet and part like the square root of the change.
    """
    change = len(monodromy) * ROUNDING * max(size, float(np.linalg.norm(monodromy, 2)))
    try:
        values, right = np.linalg.eig(monodromy)
    except np.linalg.LinAlgError:
        return np.full(len(multipliers), np.inf)
    with np.errstate(all="ignore"):  # where two eigenvectors are one, lengths overflow
        try:
            left = np.linalg.inv(right)  # rows; the columns on the right have unit length
            lengths = np.linalg.norm(left, axis=1)
        except np.linalg.LinAlgError:
            lengths = np.full(len(right), np.inf)
        moved = np.fmin(change * lengths, np.sqrt(change))
    nearest = np.abs(multipliers[:, None] - values[None, :]).argmin(axis=1)
    return np.asarray(moved[nearest], dtype=float)


def multiplier_change(
    values: Complex, others: Complex, monodromy: Array, size: float = 1.0
) -> Array:
    """Return how uncertain multipliers are that were computed twice, shape (n,)."""
    change = np.abs(values - match_multipliers(values, others))
    return SPREAD * change + multiplier_rounding(monodromy, values, size)


def change_at(point: OrbitPoint, again: OrbitPoint | Again) -> Array:
    """Return how uncertain the multipliers of a point are that was computed twice, shape (n,)."""
    orbits = point.curve.orbits
    size = orbits.fastest(point.z) if isinstance(orbits, Equilibria) else 1.0
    return multiplier_change(point.multipliers, again.multipliers, point.monodromy, size)


def recomputed(curve: OrbitCurve, point: OrbitPoint) -> tuple[OrbitPoint | None, float]:
    """Compute a point of a curve with other errors in every step, or smaller ones if possible.

    Also what rounding can do to its last parameter. None if that fails: nothing is known then.
    """
    try:
        exact = by_mesh_shooting(curve, point)
        if exact is None:
            other, guess, row = curve.shifted(point.z, point.tangent)
            correction = correct(other, guess, row)
            if not correction.converged:
                return None, np.inf
            again, bordered = other.point(correction, point.arclength), correction.bordered
        else:
            _, again = exact
            if again.linearization is None:  # a cycle of no amplitude
                return None, np.inf
            bordered = again.linearization.bordered(again.tangent)
        return again, parameter_rounding(bordered, again.z)
    except BREAKDOWNS:
        return None, np.inf


AGAIN = 1e-10
"""Residual of a point that is computed again, before its last correction."""


class Again(NamedTuple):
    """A point of a curve that was computed with other errors in every step."""

    value: float  # the last parameter, scaled
    multipliers: Complex
    tests: dict[str, float]
    rounding: float  # what rounding can do to that parameter


Request = tuple[OrbitPoint, Array | None]
"""A point of a branch that is to be computed again, or whose multipliers are wanted beside it."""


def answers_of(requests: Mapping[int, Request]) -> dict[int, Any]:
    """Answer requests by number, with `Again` or multipliers; orbits that are alike at once.

    None where a point cannot be computed again, an error where there are no multipliers.
    """
    answers, alike = dict[int, Any](), defaultdict[tuple[Hashable, bool], list[int]](list)
    for number, (point, beside) in requests.items():
        alike[what_is_common(point), beside is None].append(number)
    for (kind, again), numbers in alike.items():
        points = [requests[number][0] for number in numbers]
        with suppress(*BREAKDOWNS):  # one may break down: each is asked for by itself then
            if kind is not None and again:
                answers |= zip(numbers, _shot_again(points), strict=True)
            elif kind is not None:
                z = np.array([requests[number][1] for number in numbers])
                batch = OrbitBatch.of_branches([point.curve for point in points])
                found = batch.multipliers(np.arange(len(z)), z)  # NaN where not known
                known = zip(numbers, found, strict=True)
                answers |= {number: own for number, own in known if np.isfinite(own).all()}
    return answers | {i: _answer(*requests[i]) for i in requests.keys() - answers.keys()}


def what_is_common(point: OrbitPoint) -> Hashable:
    """Return what orbits have in common that one batch computes, None of those it does not."""
    curve, part = point.curve, point.linearization
    by_shooting = isinstance(curve, ForcedOrbits) and type(curve.by) is Shooting
    if not by_shooting or len(curve.free) > 1 or curve.standing is not None:
        return None
    if part is not None and growth_within(part.blocks) >= SEGMENT_GROWTH:  # shooting over a mesh
        return None
    return curve.flow, curve.vary, curve.width, curve.period, curve.segments, curve.phase


def _answer(point: OrbitPoint, beside: Array | None) -> Any:
    try:
        if beside is not None:
            return point.curve.eigenvalues(beside, point.curve.linearize(beside))
        again, rounding = recomputed(point.curve, point)
    except BREAKDOWNS as error:
        return error
    return None if again is None else Again(again.z[-1], again.multipliers, again.tests, rounding)


def _shot_again(points: Sequence[OrbitPoint]) -> list[Again | None]:
    """Compute forced orbits again in one batch, in turn where Newton's method does not end."""
    batch = OrbitBatch.of_branches([point.curve for point in points])
    z, tangents = (np.array([getattr(p, name) for p in points]) for name in ("z", "tangent"))
    other, guesses, rows = batch.shifted(z, tangents)
    found = other.correct(np.arange(len(z)), guesses, rows, NEWTON.still, np.inf, EXACTLY)
    residuals = other.misses(np.arange(len(z)), found.part.missed)
    answers = list[Again | None]()
    for row, point in enumerate(points):
        if not (found.found[row] and residuals[row] <= AGAIN):
            answers.append(_answer(point, None))
            continue
        again = found.point(row, point.curve, point.arclength, float(residuals[row]))
        rounding = parameter_rounding(again.linearization.bordered(again.tangent), again.z)
        answers.append(Again(again.z[-1], again.multipliers, again.tests, rounding))
    return answers


def multiplier_uncertainty(
    model: Model,
    parameters: Array,
    nodes: Array,
    period: int,
    multipliers: Complex,
    cut: Cut | None = None,
) -> Array:
    """Return how much each multiplier moves when the monodromy matrix is computed again.

    The second computation has segments that begin elsewhere, or intervals of other lengths, so that
    every step falls elsewhere. In exact arithmetic the multipliers are the same. As for branches,
    the motion from which searches start says whether vibrations are too fast for shooting.

    Shapes: parameters (n_orbits, n_parameters); nodes (n_orbits, m, n_states); multipliers
    (n_orbits, n_states); returns (n_orbits, n_states).
    """
    cut, result = cut or shooting_for(model), np.full(multipliers.shape, np.inf)
    by = cut(model, {model.parameters[0].name: 1.0}, period, nodes.shape[1])
    constants = [by.flow.constants(values, by.flow_scales) for values in parameters]
    unresolved = np.exp(-RADAU.decays * period)
    for row, (own, values) in enumerate(zip(nodes, constants, strict=True)):
        jacobian = by.flow.jacobians(model.start[None], np.zeros(1), values)[0]
        damps = cut is Shooting and damps_stiff(jacobian)
        if damps:
            try:
                monodromy = _by_collocation(model, parameters[row], own, period)
            except InputError:  # no mesh fits
                continue
        else:
            fitting = by.better(own, values) or by
            other, own, _ = fitting.shifted(own, values, np.zeros(own.shape), np.zeros(1))
            blocks = other.transitions(own, values)[1]
            settled = other.settled(blocks, own, values)
            monodromy = product(blocks if settled is None else settled)
        if np.isfinite(monodromy).all():
            others = floquet_multipliers(monodromy)
            result[row] = multiplier_change(multipliers[row], others, monodromy)
        if damps:  # Radau points damp away what an interval does not resolve.
            damped = np.abs(multipliers[row]) < unresolved
            result[row, damped] = np.maximum(result[row, damped], unresolved)
    return result


def _by_collocation(model: Model, parameters: Array, nodes: Array, period: int) -> Array:
    """Return the monodromy matrix of an orbit by collocation, on a finer mesh than one that fits.

    Shapes: parameters (n_p,); nodes (m, n); returns (n, n).
    """
    names = [parameter.name for parameter in model.parameters]
    own = model.replace(**dict(zip(names, parameters.tolist(), strict=True)))
    shot = orbits_at(own, period, len(nodes))
    orbits, z = on_mesh(shot, shot.unknown(nodes, own))
    other, finer, _ = orbits.shifted(z, hold_parameter(len(z) - 1))
    return product(other.by.transitions(other.nodes(finer), other.constants(finer))[1])
