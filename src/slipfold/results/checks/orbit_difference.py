"""The distance of an orbit from that of collocation, by one step of Newton's method."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array, Complex
from slipfold.collocation_points import gauss_points
from slipfold.errors import BREAKDOWNS
from slipfold.flow.equations import Constants
from slipfold.flow.flow import Flow, flow_of
from slipfold.flow.implicit_steps import StepsEnd, StiffFallback, implicit_trajectory
from slipfold.flow.intervals import MANY, Field, Intervals, LinearPart, newton_step
from slipfold.models.angles import wrap_angles
from slipfold.models.quantities import DURATION
from slipfold.orbits.check import SINGULAR, is_singular, mesh_errors, rests
from slipfold.orbits.meshes import INTERVALS, mesh_copies
from slipfold.orbits.multipliers import multiplier_differences, without_motion
from slipfold.orbits.periodic_orbit import PeriodicOrbit
from slipfold.orbits.uncertainty import SPREAD
from slipfold.results.checks.checked import CHECKS
from slipfold.results.checks.retraced import Retraced, SampledSolution, retrace


def implicit_ends(
    fallback: StiffFallback, starts: Array, begins: Array, ends: Array, **options: Any
) -> Array:
    """Return where implicit steps lead scaled states, NaN from the first that does not arrive.

    Shapes: starts (m, n); begins, ends (m,).
    """
    result = np.full(starts.shape, np.nan)
    for row, (state, begin, end) in enumerate(zip(starts, begins, ends, strict=True)):
        solution = implicit_trajectory(fallback.field, state, begin, end, **options)
        if solution.end is not StepsEnd.ARRIVED:
            break
        result[row] = solution.state
    return result


def implicit_difference(orbit: PeriodicOrbit, flow: Flow) -> Difference | None:
    """Return the error at the ends of parts, over the size; None where the flow is not stiff.

    Each part starts from a node of its own, so that errors do not grow on the way. What decays
    within a part counts less.
    """
    from scipy.linalg import schur  # slow to import

    constants = flow.constants_of(orbit.model)
    if not flow.is_stiff(orbit.state, constants):
        return None
    count = len(orbit.nodes)
    starts = np.arange(0, count, max(1, count // CHECKS.parts))
    nodes = orbit.nodes[starts] / constants.scales
    phases = np.append(starts, count) * (orbit.period / count)
    fallback, following = StiffFallback(flow, constants), np.roll(nodes, -1, axis=0)
    arrived = implicit_ends(fallback, nodes, phases[:-1], phases[1:])
    apart = wrap_angles(arrived - following, orbit.model.angle_periods / constants.scales)
    slopes = fallback.field.jacobians(following, phases[1:]) * np.diff(phases)[:, None, None]
    if not (np.isfinite(apart).all() and np.isfinite(slopes).all()):
        return Difference(np.inf, CHECKS.coarse, "implicit steps")
    slow = 0.0
    for error, slope in zip(apart, slopes, strict=True):
        # Vectors on the left of what does not decay are blind to what does.
        _, basis, count = schur(slope.T, sort=lambda real, _: real > -CHECKS.follows)
        slow = max(slow, float(np.linalg.norm(error @ basis[:, :count])))
    size = max(1.0, float(np.abs(nodes).max()))
    found = [(slow, CHECKS.states), (float(np.abs(apart).max()), CHECKS.coarse)]
    differences = [Difference(value / size, most, "implicit steps") for value, most in found]
    return max(differences, key=lambda difference: difference.excess)


FINER = (1, 2, 4, 8, 16, 32)
"""Times as many pieces that are tried where the two methods seem to differ. What the orbit lacks
is seen on all of them; what rounding adds, where modes are stiff, most on the finest. States are
off by most on the first ones where pieces are long for a perturbation, as when a bubble collapses.
"""


@dataclass(frozen=True)
class Difference:
    """How far two methods are apart, and how far they may be."""

    value: float
    allowed: float = CHECKS.states
    method: str = "quadrature"
    what: str = "states"  # what differs
    unknown: float = 0.0  # difference of multipliers that are too sensitive to count

    @property
    def excess(self) -> float:
        """The difference in units of what is allowed."""
        return self.value / self.allowed


def pieces_of(orbit: PeriodicOrbit) -> int:
    """Return the number of pieces in which an orbit's multipliers are known, 0 if there is none."""
    segments = len(orbit.nodes)
    if orbit.nodes.size > CHECKS.max_unknowns:
        return 0
    phases = np.linspace(0.0, orbit.period, segments, endpoint=False)
    flow = flow_of(orbit.model)
    scales = orbit.model.state_scales()
    field = Field(flow, flow.constants_of(orbit.model), scales, [], LinearPart())
    slopes = field.jacobians(orbit.nodes / scales, phases)
    if not np.isfinite(slopes).all():
        return 0
    fastest = float(np.abs(np.linalg.eigvals(slopes)).max())
    pieces = orbit.period * max(CHECKS.pieces, fastest)
    return int(np.ceil(pieces)) if pieces <= CHECKS.max_pieces else 0


def orbit_differences(orbits: Sequence[PeriodicOrbit], pieces: Sequence[int]) -> list[Difference]:
    """Return how far orbits are from those of collocation; those of one flow are solved together.

    Multipliers that differ by more may differ by their uncertainty. An orbit that cannot be solved
    for is infinitely far.
    """
    alike, compared = defaultdict[int, list[int]](list), dict[int, _OrbitComparison]()
    for i, orbit in enumerate(orbits):
        # Where there are many states, the work is in matrices; nothing is to be solved at rest.
        alone = len(orbit.state) >= MANY or not pieces[i]
        alike[-1 - i if alone else id(flow_of(orbit.model))].append(i)
    for some in alike.values():
        if len(some) > 1:
            known = _differences([orbits[i] for i in some], [pieces[i] for i in some])
            compared.update(zip(some, known, strict=True))
    return [
        _allowed_uncertainty(*given, compared.get(i))
        for i, given in enumerate(zip(orbits, pieces, strict=True))
    ]


def _allowed_uncertainty(
    orbit: PeriodicOrbit, pieces: int, compared: _OrbitComparison | None
) -> Difference:
    try:
        found = orbit_difference(orbit, pieces, compared=compared)
        if found.excess > 1 and found.what == "multipliers":
            found = orbit_difference(orbit, pieces, orbit.multiplier_uncertainty)
    except np.linalg.LinAlgError:
        return Difference(np.inf)
    return found


def orbit_difference(
    orbit: PeriodicOrbit,
    pieces: int,
    uncertainty: Array | float = 0.0,
    compared: _OrbitComparison | None = None,
) -> Difference:
    """Return the largest difference: of states (scaled), duration and multipliers (relative).

    Allowed is what the orbit's residual and the errors of steps can do as its equations are
    conditioned, and of each multiplier its uncertainty, shape (n,), as far as that decides nothing.
    Multipliers that errors of that size change in their third digit are not known: then only the
    states decide, as long as a digit of the multipliers agrees. Of states that differ, the error of
    a mesh is allowed as well if there are as many nodes as such a mesh has: others are by shooting.
    """
    free = _undecided(orbit, uncertainty)
    if rests(orbit.model, orbit.nodes):
        result = orbit.check(CHECKS.states)
        multipliers = Difference(result.multipliers, what="multipliers")
        return _counting(Difference(result.states), multipliers)
    tried = [] if compared is None else [compared]
    for finer in FINER[len(tried) :]:
        if tried and _worst(tried[-1]) <= 1:
            break
        few = finer * pieces * len(orbit.state) <= CHECKS.finest
        if finer > FINER[2] and not (few and tried[-1].states.excess > 1):
            break
        tried += _differences([orbit], [finer * pieces], free)
    states, multipliers = min(tried, key=_worst)[:2]
    # A difference that falls as pieces are halved is one of the polynomials, not of the orbit.
    falls = multipliers.excess > 1 and multipliers.value < 0.01 * tried[0].multipliers.value
    fewest = INTERVALS * mesh_copies(orbit.model, orbit.period)
    if states.excess > 1 and len(orbit.nodes) >= fewest:
        states = replace(states, allowed=max(states.allowed, _allowed_by_meshes(orbit)[0]))
    unknown = multipliers.excess > 1 or multipliers.value > CHECKS.loosest
    if states.excess <= 1 and unknown and not falls:
        beside = _along_branch(orbit, pieces, free, tried[0], states.allowed)
        multipliers = min(multipliers, beside, key=lambda difference: difference.excess)
    return states if falls else _counting(states, multipliers)


def _counting(states: Difference, multipliers: Difference) -> Difference:
    """Return the difference that counts: of multipliers as long as their first digits agree."""
    if CHECKS.loosest < multipliers.value <= min(multipliers.allowed, 0.5):
        return replace(states, unknown=multipliers.value)
    return max(states, multipliers, key=lambda difference: difference.excess)


def _undecided(orbit: PeriodicOrbit, uncertainty: Array | float) -> Array:
    """Return the uncertainties of multipliers as far as they decide nothing, shape (n,)."""
    most = np.maximum(CHECKS.coarse, CHECKS.distance * np.abs(np.abs(orbit.multipliers) - 1))
    return np.minimum(uncertainty, most)


def _worst(compared: _OrbitComparison) -> float:
    return max(compared.states.excess, compared.multipliers.excess)


def _along_branch(
    orbit: PeriodicOrbit,
    pieces: int,
    free: Array,
    compared: _OrbitComparison,
    states_allowed: float,
) -> Difference:
    """Return the difference of multipliers from those of an orbit as near as errors may make it.

    Where the equations leave the place along the branch open, errors are mostly of that place,
    with which multipliers may change at any rate. The place is where the sum of the
    multipliers is that of the orbit: a secant leads there, or as near as rounding permits.
    """
    if compared.open_direction is None:
        return compared.multipliers
    *nodes, duration = compared.open_direction.tolist()
    nodes = np.reshape(nodes, orbit.nodes.shape) * orbit.model.state_scales()
    reach = (
        min(compared.along * max(states_allowed - CHECKS.states, CHECKS.rounding), CHECKS.loosest)
        * compared.size
    )

    def compared_at(place: float) -> _OrbitComparison:
        model = orbit.model
        if not model.forced:
            longer = model.values[DURATION.name] * (1 + place * duration)
            model = model.replace(**{DURATION.name: longer})
        moved = replace(orbit, model=model, nodes=orbit.nodes + place * nodes)
        return _differences([moved], [pieces], free)[0]

    before, place, best = 0.0, 0.01 * reach, compared.multipliers
    allowed = max(best.allowed, SINGULAR)
    for _ in range(CHECKS.secants):
        after = compared_at(place)
        best = min(best, after.multipliers, key=lambda difference: difference.value)
        slope = (after.excess - compared.excess) / (place - before)
        if best.value <= min(best.allowed, allowed) or not (np.isfinite(slope) and slope):
            break
        before, place, compared = place, place - after.excess / slope, after
        if place == before or not abs(place) <= reach:
            break
    return replace(best, allowed=min(best.allowed, allowed))


def _allowed_by_meshes(orbit: PeriodicOrbit) -> tuple[float, Array]:
    """Return the differences of states and multipliers, (n,), that errors of meshes explain.

    Zeros where they are not known. Two meshes differ by a sample of the errors of both.
    """
    try:
        error, of_multipliers = mesh_errors(
            orbit.model, orbit.nodes, orbit.period, orbit.multipliers
        )
    except BREAKDOWNS:
        return 0.0, np.zeros(len(orbit.multipliers))
    error *= SPREAD
    size = max(1.0, float(np.abs(orbit.nodes / orbit.model.state_scales()).max()))
    allowed = error / size if error < CHECKS.loosest * size else 0.0
    return allowed, SPREAD * np.where(np.isfinite(of_multipliers), of_multipliers, 0.0)


def retraced_difference(orbit: PeriodicOrbit) -> Difference:
    """Return how far an orbit fails to satisfy its equations, which takes no derivatives.

    Where no pieces are short enough for that since something decays too fast, it is how far
    implicit steps deviate from it.
    """
    flow = flow_of(orbit.model)
    solution = solution_of(orbit, flow, CHECKS.pieces * orbit.period)
    (retraced,) = retrace(flow, orbit.model.state_scales(), [solution])
    # Where a fast decay is only just resolved, rounding must not choose the method.
    plain = retraced.resolved and retraced.drift <= CHECKS.states
    stiff = None if plain else implicit_difference(orbit, flow)
    return Difference(retraced.drift) if stiff is None else stiff


def balanced_difference(orbit: PeriodicOrbit) -> Difference | None:
    """Return the largest difference from harmonic balance, for which fast modes are nothing.

    None where it does not converge with as many harmonics as there may be.
    """
    if any(orbit.revolutions.values()):
        return None
    found = orbit.harmonic_balance(CHECKS.states, CHECKS.condensed)
    if not found.truncation <= CHECKS.loosest:
        return None
    allowed, method = max(CHECKS.states, found.truncation), "harmonic balance"
    states = Difference(max(found.states, found.duration), allowed, method)
    if states.excess <= 1 < found.multipliers / allowed:
        size = max(1.0, float(np.abs(orbit.multipliers).max()))
        apart = _finite(multiplier_differences(orbit.multipliers, found.floquet) / size)
        free = _undecided(orbit, _allowed_by_meshes(orbit)[1]) / size
        multipliers = _largest(apart, np.maximum(allowed, free), method)
    else:
        multipliers = Difference(float(_finite(found.multipliers)), allowed, method, "multipliers")
    return _counting(states, multipliers)


def solution_of(
    orbit: PeriodicOrbit, flow: Flow, pieces: int, *, slopes: bool = False
) -> SampledSolution:
    """Return the solution between an orbit's nodes, in at least so many pieces."""
    segments = len(orbit.nodes)
    return SampledSolution(
        np.linspace(0.0, orbit.period, segments + 1),
        np.concatenate([orbit.nodes, orbit.nodes[:1]]),
        flow.constants_of(orbit.model),
        -(-pieces // segments),
        slopes,
        orbit.model.angle_periods,
    )


class _OrbitComparison(NamedTuple):
    """An orbit compared with polynomials in pieces."""

    states: Difference  # of states and duration
    multipliers: Difference
    size: float = 1.0  # scaled states are relative to it
    excess: float = 0.0  # real part of the sum of multipliers by this method less the orbit's
    along: float = 0.0  # distance along the branch over the errors that make it
    # Direction of scaled states and duration in which the equations leave the orbit open, if any
    open_direction: Array | None = None


def _differences(
    orbits: Sequence[PeriodicOrbit], pieces: Sequence[int], free: Array | float = 0.0
) -> list[_OrbitComparison]:
    """Compare states, duration and multipliers; several orbits of one flow together.

    Shapes: free (n,), what multipliers may differ by in any case.
    """
    flow, given = flow_of(orbits[0].model), [*zip(orbits, pieces, strict=True)]
    solutions = [solution_of(orbit, flow, count, slopes=True) for orbit, count in given]
    scales = [orbit.model.state_scales() for orbit in orbits]
    retraced = retrace(flow, np.array(scales), solutions)
    found = [_OrbitComparison(Difference(item.drift), Difference(0.0)) for item in retraced]
    known = [i for i, item in enumerate(retraced) if item.complete and item.is_finite]
    whole = [_RetracedOrbit(orbits[i], solutions[i], retraced[i], scales[i], flow) for i in known]
    try:
        compared = _compared(whole, free) if whole else []
    except np.linalg.LinAlgError:  # one is so far from an orbit that nothing can be solved
        if len(given) > 1:
            return [_differences([orbit], [count], free)[0] for orbit, count in given]
        compared = [_OrbitComparison(Difference(np.inf), Difference(0.0))]
    for i, comparison in zip(known, compared, strict=True):
        found[i] = comparison
    return found


@dataclass(frozen=True, eq=False)
class _RetracedOrbit:
    """An orbit that was retraced as a whole, in N pieces."""

    orbit: PeriodicOrbit
    solution: SampledSolution
    retraced: Retraced
    scales: Array  # shape (n,)
    flow: Flow

    @cached_property
    def rates(self) -> Array | None:
        """Rates at the beginnings of a cycle's pieces, shape (N, n); None of a forced orbit."""
        if self.orbit.model.forced:
            return None
        field = Field(self.flow, self.solution.constants, self.scales, [], LinearPart())
        return field.rates(self.retraced.nodes, self.retraced.edges[:-1])


def _compared(whole: Sequence[_RetracedOrbit], free: Array | float) -> list[_OrbitComparison]:
    """Compare orbits with polynomials in pieces, by one step of Newton's method."""
    condensed = np.split(
        _condensed(whole), np.cumsum([len(item.retraced.nodes) for item in whole])[:-1]
    )
    n = condensed[0].shape[1]
    # Each piece has errors of its own.
    known = _multipliers([own[:, :, :n] for own in condensed], [item.rates for item in whole])
    given = zip(whole, condensed, known, strict=True)
    return [_comparison(item, pieces, *found, free) for item, pieces, found in given]


def _comparison(
    whole: _RetracedOrbit, pieces: Array, values: Complex, moved: Array, free: Array | float
) -> _OrbitComparison:
    """Compare one orbit, by the ends of its pieces and by multipliers with their sensitivities."""
    orbit, retraced, own = whole.orbit, whole.retraced, (0 if whole.rates is None else 1)
    anchors = np.searchsorted(retraced.edges, whole.solution.phases[:-1])
    matrices, by_parameters, defects = _between(anchors, pieces)
    rates = None if whole.rates is None else whole.rates[anchors]
    # By either method: a wrong critical multiplier must not make the orbit seem less well known.
    singular = is_singular(orbit.multipliers, own) or is_singular(values, own)
    off = float(np.abs(values[: len(values) - own] - 1).min(initial=np.inf))
    solved = _solved(matrices, by_parameters, defects, rates, off if singular else None)
    step, growth, along = solved.step, solved.growth, solved.along
    size = max(1.0, float(np.abs(orbit.multipliers).max()))
    apart = _finite(multiplier_differences(orbit.multipliers, values) / size)
    errors = orbit.residual / retraced.size + CHECKS.rounding
    # The states by both methods are a step apart, and so are the matrices along them.
    change = CHECKS.slopes + max(step, float(np.abs(defects).max())) / retraced.size
    near = np.abs(orbit.multipliers[:, None] - values) <= apart[:, None] * size + SINGULAR
    sensitive = change * np.where(near, moved, 0.0).max(axis=1) / size
    allowed = np.maximum(np.maximum(max(CHECKS.states, along * errors), free / size), sensitive)
    return _OrbitComparison(
        Difference(float(_finite(step / retraced.size)), max(CHECKS.states, growth * errors)),
        _largest(apart, allowed),
        retraced.size,
        float((values.sum() - orbit.multipliers.sum()).real),
        along,
        solved.open_direction,
    )


def _largest(apart: Array, allowed: Array, method: str = "quadrature") -> Difference:
    """Return the difference of multipliers that counts: where all agree the largest."""
    worst = int((apart if np.all(apart <= allowed) else apart / allowed).argmax())
    return Difference(float(apart[worst]), float(allowed[worst]), method, "multipliers")


def _finite(values: Array | float) -> Array:
    return np.where(np.isfinite(values), values, np.inf)


def _condensed(whole: Sequence[_RetracedOrbit]) -> Array:
    """Return how pieces end: by beginnings, by the unit of time, and what is lacking.

    Returns (N, n, n + 2), the pieces of one orbit after those of the other.
    """
    flow, linear, retraced = whole[0].flow, LinearPart(), [item.retraced for item in whole]
    nodes = np.concatenate([item.nodes for item in retraced])
    stages = np.concatenate([item.stages for item in retraced])
    start = np.concatenate([item.edges[:-1] for item in retraced])
    lengths = np.concatenate([np.diff(item.edges) for item in retraced])
    following = np.concatenate([np.roll(item.nodes, -1, axis=0) for item in retraced])
    which = np.repeat(np.arange(len(whole)), [len(item.nodes) for item in retraced])
    constants = Constants.stacked([item.solution.constants for item in whole])
    count, m, n = stages.shape
    together, parts = max(1, CHECKS.memory // (m * n) ** 2), []
    for first in range(0, count, together):
        rows = slice(first, first + together)
        own = np.repeat(which[rows], m)
        scales = whole[0].scales if len(whole) == 1 else np.array([w.scales for w in whole])[own]
        field = Field(flow, constants.rows(own), scales, [], linear)
        given = Intervals(gauss_points(m), nodes[rows], start[rows], lengths[rows])
        solved = newton_step(field, given, stages[rows])
        by_parameters = np.zeros((len(solved.lengths), n, 1))
        if not whole[0].orbit.model.forced:
            rates = field.rates(stages[rows], solved.phases)
            by_parameters = solved.answered(rates[..., None])[1]
        parts.append(
            np.concatenate([solved.matrices, by_parameters, solved.ends[..., None]], axis=2)
        )
    condensed = np.concatenate(parts)
    angle_periods = np.array([item.orbit.model.angle_periods / item.scales for item in whole])
    condensed[:, :, n + 1] = wrap_angles(condensed[:, :, n + 1] - following, angle_periods[which])
    return condensed


def _between(anchors: NDArray[np.intp], single: Array) -> tuple[Array, Array, Array]:
    """Condense further: what leads from one anchor to the next."""
    n, counts = single.shape[1], np.diff(np.append(anchors, len(single)))
    result = single[anchors]
    for j in range(1, counts.max()):
        some = (counts > j).nonzero()[0]
        piece = single[anchors[some] + j]
        whole = piece[:, :, :n] @ result[some]
        whole[:, :, n:] += piece[:, :, n:]
        result[some] = whole
    return result[:, :, :n], result[:, :, n], result[:, :, n + 1]


class _SolvedStep(NamedTuple):
    """Newton's step, and how much longer steps are than the defects that they remove."""

    step: float  # length
    growth: float  # largest ratio
    along: float  # the same with the place along the branch, on which multipliers depend
    open_direction: Array | None  # direction of anchors and duration that the equations leave open


def _solved(
    matrices: Array, by_parameters: Array, defects: Array, rates: Array | None, off: float | None
) -> _SolvedStep:
    """Solve for the step that leads to the orbit.

    At a fold or branch point the equations see its place along the branch as far off, in the
    critical multiplier, as `off`.

    The step is that of the anchors and the duration, and what of the equations it cannot solve.

    At a fold or branch point, and where integrators' errors alone would move it more than is
    allowed (near a homoclinic orbit), the equations leave the orbit's place along the branch
    open, and near a loop through several saddles how long it stays at each: the step then has no
    part in directions that they can hardly see, nor may they ask for any.
    """
    count, n = defects.shape
    size = count * n
    rows = np.arange(size).reshape(count, n)
    matrix = np.zeros((size + 1, size + 1))
    matrix[rows[:, :, None], rows[:, None, :]] = matrices
    matrix[rows, np.roll(rows, -1, axis=0)] -= 1.0
    right = np.append(-defects.ravel(), 0.0)
    if rates is None:
        matrix[-1, -1] = 1.0
    else:
        matrix[:-1, -1] = by_parameters.ravel()
        matrix[-1, :-1] = rates.ravel() / np.linalg.norm(rates)
    left, values, across = np.linalg.svd(matrix)
    is_open = values * CHECKS.states < CHECKS.rounding
    is_open[-1] |= off is not None
    least = values[-1]
    if off is not None:
        least = min(values[-2], values[-1] / off) if off > CHECKS.states else values[-2]
    values[is_open] = np.inf
    wanted = left.T @ right
    step = across.T @ (wanted / values)
    length = np.max(np.abs([*step, *wanted[is_open]]))
    direction = across[-1] if is_open[-1] else None
    return _SolvedStep(float(length), float(1 / values.min()), float(1 / least), direction)


def _multipliers(
    matrices: Sequence[Array], rates: Sequence[Array | None]
) -> list[tuple[Complex, Array]]:
    """Return the multipliers of each orbit, that of a cycle's direction last, and sensitivities.

    Shapes: matrices (N, n, n) of each, rates (N, n) of cycles.
    """
    given = zip(matrices, rates, strict=True)
    parts = [(np.ones(0), own) if f is None else without_motion(own, f) for own, f in given]
    values, moved = _sensitive_eigenvalues([across for _, across in parts])
    known = zip(matrices, parts, rates, values, moved, strict=True)
    return [
        (own, change) if f is None else _with_motion(own, change, factors, along, f)
        for factors, (along, _), f, own, change in known
    ]


def _with_motion(
    values: Complex, moved: Array, matrices: Array, along: Array, rates: Array
) -> tuple[Complex, Array]:
    """Append the multiplier of a cycle's direction: one, but for errors of rates over the largest.

    Where a cycle nearly rests, as at the saddles of a heteroclinic loop, its direction is rounding.
    Shapes: matrices (N, n, n); along (N,); rates (N, n).
    """
    speeds = np.linalg.norm(rates, axis=1)
    speeds = speeds / speeds.max()
    value = 1.0 + (along * speeds - np.roll(speeds, -1)).sum()
    lengths = np.linalg.norm(matrices, 2, axis=(1, 2))
    return np.append(values, value), np.append(moved, lengths @ speeds)


def _sensitive_eigenvalues(matrices: Sequence[Array]) -> tuple[Complex, Array]:
    r"""Return eigenvalues of products, and by how much relative changes of factors move them.

    With the vectors r and l of an eigenvalue, each propagated through the other factors, that is
    :math:`\sum_j |l_j| |A_j| |r_j| / |l^* r|`. Where growth and decay along an orbit are as strong
    as near a saddle, it is large though no multiplier is.

    Shapes: matrices (N, n, n) of each of k products; returns (k, n), (k, n).
    """
    k, n, longest = len(matrices), matrices[0].shape[1], max(map(len, matrices))
    factors = np.tile(np.eye(n), (longest, k, 1, 1))
    norms = np.zeros((longest, k, 1, 1))
    for i, own in enumerate(matrices):
        factors[: len(own), i] = own
        sizes = np.linalg.svd(own, compute_uv=False).max(axis=1, initial=0.0)
        norms[: len(own), i, 0, 0] = sizes
    before, after = factors.copy(), factors.copy()  # products of factors up to each, and from it
    for j in range(1, longest):
        before[j] = factors[j] @ before[j - 1]
        after[-1 - j] = after[-j] @ factors[-1 - j]
    values, right = np.linalg.eig(before[-1])
    left = np.linalg.inv(right)  # rows; the columns on the right have unit length
    lengths = np.ones((longest, k, n))
    lengths[1:] = np.linalg.norm(before[:-1] @ right, axis=2)
    lengths[:-1] *= np.linalg.norm(left @ after[1:], axis=3)
    lengths[-1] *= np.linalg.norm(left, axis=2)
    moved = (norms[..., 0] * lengths).sum(axis=0)
    return values.astype(complex), np.asarray(moved)
