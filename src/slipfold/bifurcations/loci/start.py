"""Starts of loci: at points of branches, at given points, and at points of codimension two."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from slipfold.arrays import Array, Complex
from slipfold.bifurcations.branches.closed_branches import (
    asymmetry,
    half_orbit,
    meets_image,
    rests_at,
)
from slipfold.bifurcations.branches.settings import Settings
from slipfold.bifurcations.branches.special_point import SpecialPoint
from slipfold.bifurcations.loci.locus_equations import LOCUS, LocusEquations
from slipfold.bifurcations.loci.make_locus import plane_of
from slipfold.bifurcations.loci.special_points import SpecialPoints
from slipfold.continuation.curve_set import Start
from slipfold.continuation.end import End
from slipfold.continuation.follow import follow
from slipfold.continuation.newton import correct
from slipfold.continuation.step_length import STEP
from slipfold.continuation.traced_curve import Found, MonitorResult, StepInterval, Stop
from slipfold.continuation.walk import Failure, first_point
from slipfold.errors import BREAKDOWNS, NUMERICAL, InputError, breakdown
from slipfold.flow.modes import GRAZED
from slipfold.models.model import Model
from slipfold.orbits.bifurcation_types import (
    CODIMENSION_TWO,
    DOUBLED,
    PAIRED,
    TWO_PAIRS,
    CodimensionTwoType,
)
from slipfold.orbits.check import rests
from slipfold.orbits.continued import fitted, on_mesh
from slipfold.orbits.critical import (
    critical_direction,
    crossing_gap,
    doubled_orbit,
    hopf_cycle,
)
from slipfold.orbits.eigenvalues import Cayley
from slipfold.orbits.kinds import Equilibria, orbits_of
from slipfold.orbits.marginal import MarginalShooting
from slipfold.orbits.modal_shooting import shooting_for
from slipfold.orbits.normal_forms.codimension_two import eigenvectors, equilibrium_coefficients
from slipfold.orbits.normal_forms.maps import FieldMap
from slipfold.orbits.orbit_curve import OrbitPoint, Orbits
from slipfold.orbits.shooting import SEGMENTS
from slipfold.orbits.switched_shooting import SwitchedShooting
from slipfold.orbits.test_functions import ALIKE, floquet_multipliers
from slipfold.orbits.uncertainty import recomputed


@dataclass(frozen=True, eq=False)
class LocusStart(Start[OrbitPoint]):
    """Where a locus is to be followed from."""

    # Whether its orbits are there those of half the period, passed twice, or equilibria
    doubled: bool = False
    # Type of the point of codimension two that it passes there; empty if it passes none
    crosses: str = ""
    step: float = LOCUS.first_step  # length of the first step
    # Orbits by which it is known, where another locus of its type passes its first point
    beside: tuple[Array, ...] = ()


def regular_start(
    curve: LocusEquations, z: Array, settings: Settings, crosses: str = ""
) -> LocusStart:
    """Return a point of a locus with both its directions."""
    try:
        point = _regular_point(curve, z, settings)
    except NUMERICAL as error:  # rounding decides whether a matrix is singular
        several = ""
        with suppress(*NUMERICAL):
            several = undamped(curve, floquet_multipliers(curve.orbits.linearize(z).monodromy))
        raise _no_locus(curve, z, several or breakdown(error)) from None
    both = _rising_first(point, curve.turned(point))
    step = STEP.emanating if crosses else LOCUS.first_step
    return LocusStart(curve, both, departs=bool(crosses), crosses=crosses, step=step)


def _regular_point(curve: LocusEquations, z: Array, settings: Settings) -> OrbitPoint:
    linearized = curve.linearize(z)
    if not np.isfinite(linearized.jacobian).all():
        raise _no_locus(curve, z, "its orbit cannot be integrated")
    jacobian = linearized.jacobian
    if _is_singular(curve, jacobian, z):
        several = undamped(curve, floquet_multipliers(linearized.monodromy))
        raise _no_locus(curve, z, several or "neither of them moves it")
    right = np.linalg.svd(jacobian)[2]
    newton = settings.newton
    correction = correct(curve, z, right[-1], newton.tolerance, newton.iterations)
    if not correction.converged or correction.distance > LOCUS.moved:
        reason = correction.failure or "Newton's method leads to another orbit"
        raise _no_locus(curve, z, reason)
    return curve.point(correction, 0.0)


def undamped(curve: LocusEquations, multipliers: Complex) -> str:
    """Say how many multipliers are critical, if they are more than a locus is of."""
    on_circle = int(np.count_nonzero(np.abs(np.abs(multipliers) - 1) < ALIKE))
    if on_circle <= (2 if curve.condition in PAIRED else 1) + curve.orbits.free_phase:
        return ""
    return (
        f"{on_circle} multipliers lie on the unit circle there, as where nothing damps, and which "
        "of them crosses it is not defined"
    )


def _rising_first(point: OrbitPoint, turned: OrbitPoint) -> tuple[OrbitPoint, OrbitPoint]:
    """Begin where the parameters rise together: the sign of a singular vector is arbitrary."""
    rises = float(point.tangent[-2:].sum())
    return (point, turned) if rises >= 0 else (turned, point)


def _is_singular(curve: LocusEquations, jacobian: Array, z: Array) -> bool:
    """Whether no curve is defined: neither parameter, changed by its window or itself, matters."""
    effects = np.linalg.norm(jacobian[:, -2:], axis=0)
    if float((effects * np.maximum(np.abs(z[-2:]), 1.0)).max()) < LOCUS.undefined:
        return True
    # A rate that changes fast holds its state as well as any other.
    scaled = jacobian / np.maximum(1.0, np.linalg.norm(jacobian, axis=1, keepdims=True))
    scaled[:, -2:] /= np.linalg.norm(scaled[:, -2:], axis=0).max()
    if curve.orbits.by.growing:  # what grows on the way round makes it as good as singular
        return False
    values = np.linalg.svd(scaled, compute_uv=False)
    return bool(values[len(z) - 2] < LOCUS.undefined * values[0])


def _no_locus(curve: LocusEquations, z: Array, reason: str) -> InputError:
    first, second = plane_of(curve.orbits)
    a, b = curve.place(z)
    return InputError(
        f"the {curve.condition} at {first} = {a:.6g}, {second} = {b:.6g} has no locus in {first} "
        f"and {second}: {reason}; choose other parameters or another special point"
    )


def passing(
    curve: LocusEquations, found: Found, types: Sequence[str], settings: Settings
) -> Iterator[LocusStart]:
    """Return the loci of other types that pass a point of codimension two, or end there."""
    point, orbits = found.point, curve.orbits
    for other in _type_of(found).through:
        if other == curve.condition or other not in types:
            continue
        try:
            start = regular_start(LocusEquations(orbits, other), point.z, settings, found.type)
        except InputError:
            continue
        if found.type in DOUBLED and other in PAIRED:
            yield from _complex_side(start, settings)
        else:
            yield start


def of_each_pair(curve: LocusEquations, z: Array, settings: Settings) -> Iterator[LocusStart]:
    """Return the two loci of a type that cross where two pairs are critical.

    There the equations do not say which of the pairs they mean: at a point beside it they do.
    """
    newton = settings.newton
    for along in curve.pair_tangents(z):
        tangent = along if along[-2:].sum() >= 0 else -along  # its sign is arbitrary
        guess = z + LOCUS.aside * tangent
        given = {"tolerance": newton.tolerance, "iterations": newton.iterations}
        point = curve.nearest(guess, tangent, reach=LOCUS.aside / 2, **given)
        if point is not None:
            yield LocusStart(curve, _rising_first(point, curve.turned(point)))


def _complex_side(start: LocusStart, settings: Settings) -> Iterator[LocusStart]:
    """Return the direction in which a pair that meets on the real axis is complex."""
    sides = []
    for point in start.points:
        first = first_point(start.curve, point, STEP.emanating, settings)
        if not isinstance(first, Failure) and is_complex(first):
            sides.append(point)
    if sides:
        yield replace(start, points=tuple(sides), crosses="")


def is_complex(point: OrbitPoint) -> bool:
    """Whether the critical pair of a point of a torus locus is complex."""
    tests = point.tests
    return tests["BT"] > 0 if "BT" in tests else tests["R1"] > 0 < tests["R2"]


FIRST_STEPS = (STEP.emanating, 4 * STEP.emanating, 16 * STEP.emanating, 64 * STEP.emanating)
"""First steps that are tried: equations of folds vanish with the third power of the amplitude."""


def starts_at(
    traced: LocusEquations, found: Found, types: Sequence[str], settings: Settings
) -> Iterator[LocusStart]:
    """Return the loci of some types that begin or pass at a point of codimension two, but its own.

    Through LPPD, LPNS, PDNS, BT, ZH, R1 and R2 pass loci of two types, of which that of pairs ends
    at BT, R1 and R2; through HH and NSNS two of the same type. Folds of cycles emanate at GH, of
    doubled orbits at GPD; tori of cycles at HH, one locus for each pair, and at ZH, where other
    cycles branch off of symmetric ones as well; tori of doubled orbits at R2.
    """
    point, orbits, condition = found.point, found.point.curve.orbits, traced.condition
    # A point may be described by the equations of another locus that passes there.
    curve = LocusEquations(orbits, condition)
    if (found.type, condition) == ("DP", "BP"):
        yield from _leaving_along(orbits, "LP", point, "DP", settings)
        return
    if found.type in TWO_PAIRS:
        yield from of_each_pair(curve, point.z, settings)
    yield from passing(curve, found, types, settings)
    crossed = crossing_gap(orbits, point.z) < LOCUS.vanishes
    if found.type == "ZH" and crossed and "HB" in types:
        yield from _leaving_along(orbits, "HB", point, "", settings)
    for kind, pair in _type_of(found).emanating:
        on_locus = found.type == "R2" and condition == "NS"
        if kind not in types or on_locus or (kind == "BP" and not crossed):
            continue
        first = _emanating(point, pair)
        if found.type == "ZH" and crossed and kind == "NS":
            mixed = _mixed(orbits, point.z, first)
            if mixed is None:
                continue
            first = mixed
        yield from _emanating_from(first, kind, settings)


def _type_of(found: Found) -> CodimensionTwoType:
    """Return the type of a point of codimension two; of an extremum, that nothing passes."""
    return CODIMENSION_TWO.get(found.type, CodimensionTwoType("extremum", ()))


def _emanating(point: OrbitPoint, pair: int) -> OrbitPoint:
    orbits = point.curve.orbits
    if isinstance(orbits, Equilibria):
        return hopf_cycle(orbits, point.z, point.residual, pair=pair)
    return doubled_orbit(orbits, point.z, point.residual)


def _mixed(orbits: Orbits, z: Array, cycle: OrbitPoint) -> OrbitPoint | None:
    """Return cycles off the symmetric states at a zero-Hopf point that are critical for tori.

    Of x' = x (m + p11 x^2 + p12 r^2) and r' = r (b + p21 x^2 + p22 r^2), equilibria with x and r
    have a pair on the imaginary axis where p11 x^2 + p22 r^2 = 0 and p11 p22 > p12 p21.
    """
    field = FieldMap(orbits, z)
    cubic = equilibrium_coefficients(field, "ZH")
    if "p11" not in cubic:
        return None
    own = cubic["p11"] * cubic["p22"]
    if not cubic["p12"] * cubic["p21"] < own < 0:
        return None
    still = eigenvectors(field.jacobian, 0.0)[0].real
    still *= np.sign(still[np.abs(still).argmax()])  # of two images always the same one
    count, moved = cycle.curve.segments, cycle.tangent.copy()
    # The cycle's nodes are Re(q exp(i t)), of length sqrt(count / 2), and its r is a half.
    moved[: cycle.curve.size] += np.tile(
        still * np.sqrt(-cubic["p22"] / cubic["p11"] / (2 * count)), count
    )
    return replace(cycle, tangent=moved / np.linalg.norm(moved))


def _emanating_from(first: OrbitPoint, condition: str, settings: Settings) -> Iterator[LocusStart]:
    """Return the locus of orbits that emanate at a point, unless it leads to their parents."""
    curve = LocusEquations(first.curve, condition)
    start = _leaving(curve, first)
    if start is None:
        return
    for step in FIRST_STEPS:
        after = first_point(curve, start, step, settings)
        if isinstance(after, Failure):
            continue
        if np.linalg.norm(asymmetry(first.curve, after.z)) < 0.5 * STEP.emanating:
            continue
        if step < FIRST_STEPS[-1] and not _is_resolved(start, after):
            continue
        if condition != "NS" or is_complex(after):
            yield LocusStart(curve, (start,), departs=True, doubled=True, step=step)
        return


def _is_resolved(start: OrbitPoint, after: OrbitPoint) -> bool:
    """Whether the change of parameters along the first step is more than rounding.

    Parameters change with the square of the amplitude: the tangent has twice the slope of the
    chord. A second computation finds the same change.
    """
    step = after.z - start.z
    change = float(np.linalg.norm(step[-2:]))
    bent = 0.5 * float(np.linalg.norm(step)) * after.tangent[-2:] - step[-2:]
    if not np.linalg.norm(bent) < LOCUS.resolved * change:
        return False
    again, _ = recomputed(after.curve, after)
    if again is None:
        return False
    return float(np.linalg.norm(again.z[-2:] - after.z[-2:])) < LOCUS.resolved * change


def _leaving_along(
    orbits: Orbits, condition: str, point: OrbitPoint, crosses: str, settings: Settings
) -> Iterator[LocusStart]:
    """Return the locus that leaves an orbit of a symmetry along the vector that breaks it.

    Half of it mirrors the other. Its equations hold on all orbits of the symmetry as well.
    """
    tangent = np.append(critical_direction(orbits, point.z), np.zeros(2))
    curve = LocusEquations(orbits, condition)
    start = _leaving(curve, replace(point, tangent=tangent))
    if start is None:
        return
    after = first_point(curve, start, STEP.emanating, settings)
    if (
        not isinstance(after, Failure)
        and abs(float((after.z - point.z) @ tangent)) > 0.5 * STEP.emanating
    ):
        images = after.z, 2 * point.z - after.z
        yield LocusStart(curve, (start,), departs=True, crosses=crosses, beside=images)


def _leaving(curve: LocusEquations, at: OrbitPoint) -> OrbitPoint | None:
    """Return the first point of a locus that leaves another one, where its equations are singular.

    None if its orbit cannot be integrated.
    """
    part = curve.orbits.linearize(at.z)
    if not np.isfinite(part.blocks).all():
        return None
    return curve.derived_point(at.z, at.tangent, 0.0, at.monodromy, at.residual, part)


# -- where they end ---------------------------------------------------------------------------


def parents_of(curve: LocusEquations, reached: OrbitPoint, settings: Settings) -> LocusStart | None:
    """Return the locus of the parents at which a locus ends, from what it ended on.

    That is one of its own orbits, or the point of theirs that those emanate at.
    """
    own, other = curve.orbits, reached.curve.orbits
    if (own.kind, own.period) == (other.kind, other.period):
        return _parent_start(curve, reached, settings)
    try:
        return regular_start(reached.curve, reached.z, settings)
    except InputError:
        return None


def _parent_start(
    curve: LocusEquations, point: OrbitPoint, settings: Settings
) -> LocusStart | None:
    """Return the period doubling, change of contacts or Hopf point that an orbit shrinks to."""
    orbits = curve.orbits
    if rests_at(orbits, point.z):
        resting, nodes = Equilibria(orbits.model, orbits.varied, Cayley()), orbits.nodes(point.z)
        z = resting.join(nodes.mean(axis=0, keepdims=True), orbits.values(point.z))
        parent = LocusEquations(resting, "HB")
    else:
        half, z = half_orbit(orbits, point.z)
        parent = LocusEquations(half, "PD" if curve.is_spectral else curve.condition)
    try:
        return regular_start(parent, z, settings)
    except InputError:
        return None


def ends_at_parent(
    interval: StepInterval[OrbitPoint], settings: Settings
) -> MonitorResult[OrbitPoint]:
    """End a locus where its orbits shrink to those that they emanate at.

    Newton's method is singular there, the more so the higher the order to which equations vanish:
    the point of codimension two from which they emanate is searched on the locus of the parents.
    """
    if interval.leaves:
        return MonitorResult()
    curve = interval.traced.curve
    before, here = (
        float(np.linalg.norm(asymmetry(curve.orbits, item.z)))
        for item in (interval.before, interval.point)
    )
    if here < min(before, LOCUS.near_parent):
        stop = ends_beside_parent(curve, interval.point, settings)
        if stop is not None:
            return MonitorResult(stop=stop)
    result = meets_image(interval, partial(_at_parent, curve))
    if result.stop is None:
        return result
    named = ends_beside_parent(curve, result.stop.point, settings)
    return MonitorResult(stop=named or result.stop)


def _at_parent(curve: LocusEquations, last: OrbitPoint, meeting: object) -> Stop[OrbitPoint]:
    """Return the end of a locus where the halves of its orbits become the same."""
    reason = f"the locus ends where its orbits {_shrinking(curve.orbits, last.z)}"
    return Stop(last, End("codimension-2", reason, curve.place(last.z)), reached=last)


def _shrinking(orbits: Orbits, z: Array) -> str:
    rests = rests_at(orbits, z)
    return "shrink to an equilibrium" if rests else "become those of half the period"


def ends_beside_parent(
    curve: LocusEquations, last: OrbitPoint, settings: Settings
) -> Stop[OrbitPoint] | None:
    """Return the end of a locus at the point of codimension two that its orbits emanate at.

    None if there is no such point near its last orbit.
    """
    apart = float(np.linalg.norm(asymmetry(curve.orbits, last.z)))
    kinds = {
        name for name, item in CODIMENSION_TWO.items() if curve.condition in dict(item.emanating)
    }
    try:
        start = _parent_start(curve, last, settings) if kinds else None
        found = (
            None if start is None else _nearest(start, kinds, LOCUS.parent * apart, last, settings)
        )
        return None if found is None else _end(curve, last, found)
    except BREAKDOWNS:
        return None


def _nearest(
    start: LocusStart, kinds: set[str], reach: float, last: OrbitPoint, settings: Settings
) -> Found | None:
    """Return the nearest point of some types on a locus, if one is within reach."""
    curve = start.curve
    first = start.points[0]
    count = len(first.z)
    bounds = [(i, first.z[i] - reach, first.z[i] + reach) for i in (count - 2, count - 1)]
    few = replace(settings, steps=replace(settings.steps, points=LOCUS.parent_points))
    found = [
        item
        for point in start.points
        for item in follow(
            curve,
            point,
            bounds,
            [SpecialPoints(curve)],
            settings=few,
            first_step=reach / LOCUS.parent_points,
        ).found
        if item.type in kinds
    ]
    free = last.z[-2:]
    return min(
        found, key=lambda item: float(np.linalg.norm(item.point.z[-2:] - free)), default=None
    )


def _end(curve: LocusEquations, last: OrbitPoint, found: Found) -> Stop[OrbitPoint] | None:
    """Return the end of a locus at a point of its parents, with the orbit that both share."""
    orbits = curve.orbits
    pairs = {pair for kind, pair in _type_of(found).emanating if kind == curve.condition}
    firsts = [_emanating(found.point, pair) for pair in sorted(pairs)]
    adopted = [orbits.in_phase(orbits.adopt(item.curve, item.z), last.z) for item in firsts]
    gaps = [float(np.linalg.norm(z - last.z)) for z in adopted]
    nearest = int(np.argmin(gaps))
    point = _leaving(curve, replace(firsts[nearest], z=adopted[nearest], tangent=last.tangent))
    if point is None or not gaps[nearest] < LOCUS.parent * LOCUS.near_parent:
        return None
    beyond = replace(point, arclength=last.arclength + gaps[nearest])
    name = CODIMENSION_TWO[found.type].title
    reason = (
        f"the locus ends at {found.type}, {name}, where its orbits {_shrinking(orbits, last.z)}"
    )
    end = End("codimension-2", reason, found.point.curve.place(found.point.z))
    return Stop(last, end, beyond, reached=found.point)


GIVING_WAY = (0.0, 1e-4, -1e-4, 3e-4, -3e-4, 1e-3, -1e-3)
"""Shares of its scale by which a parameter is changed to leave slip in the plane."""


def as_unknown(
    point: SpecialPoint, model: Model, plane: Mapping[str, float], settings: Settings
) -> tuple[Orbits, Array]:
    """Return what the locus of a special point consists of, and the point as one of them.

    It is of the discretization that the branch used last, unless settings ask for one: shooting
    gives an orbit at eight phases, collocation at more.
    """
    if not np.isnan(point.stuck_fraction):
        return _through_stick(point, model, plane)
    if rests(point.model, point.nodes):
        resting = Equilibria(model, plane, Cayley())
        return resting, resting.unknown(point.nodes[:1], point.model)
    chosen = settings.discretization
    if chosen == "shooting" or (chosen == "automatic" and len(point.nodes) <= SEGMENTS):
        orbits = orbits_of(model, plane, point.period, SEGMENTS, by=shooting_for(model))
        every, rest = divmod(len(point.nodes), SEGMENTS)
        if rest:
            raise InputError(
                f"the special point is given at {len(point.nodes)} phases, not {SEGMENTS}; "
                "compute it again"
            )
        return fitted(orbits, orbits.unknown(point.nodes[::every], point.model))
    return on_a_mesh(orbits_of(model, plane, point.period, SEGMENTS), point)


def _through_stick(
    point: SpecialPoint, model: Model, plane: Mapping[str, float]
) -> tuple[Orbits, Array]:
    """Return a special point as an orbit through stick and slip, past its grazing if it has one."""
    orbits = orbits_of(model, plane, point.period, 1, by=SwitchedShooting)
    z = orbits.unknown(point.nodes[:1], point.model)
    assert isinstance(orbits.by, SwitchedShooting)
    by: SwitchedShooting | None
    if point.type in GRAZED:
        by, z = _grazing(orbits, orbits.by, z, point.type)
    elif point.type == "STICK":
        by = MarginalShooting.at(orbits.by, orbits.nodes(z), orbits.constants(z), "STICK")
        if by is None:
            raise InputError("the orbit at this STICK turns nowhere; compute it again")
    else:
        by = orbits.by.better(orbits.nodes(z), orbits.constants(z))
    if by is None:
        return orbits, z
    other = orbits.described_by(by)
    return other, other.adopt(orbits, z)


def _grazing(
    orbits: Orbits, known: SwitchedShooting, z: Array, kind: str
) -> tuple[MarginalShooting, Array]:
    """Return what passes the grazing of an orbit, and the orbit, or one with a little slip left.

    In the plane the equations are singular where slip vanishes, so the last parameter is moved.
    """
    for fraction in GIVING_WAY if known.slips_in_planes else (0.0,):
        near = z.copy()
        near[-1] += fraction
        by = MarginalShooting.at(known, orbits.nodes(near), orbits.constants(near), kind)
        if by is not None:
            return by, near
    if kind != "GRAZE" or known.slips_in_planes:
        raise InputError(f"the orbit at this {kind} grazes nothing; compute it again")
    reason = "slip only just stops there and is held, which the equations of loci do not describe"
    raise _no_locus(LocusEquations(orbits, kind), z, reason)


def on_a_mesh(shot: Orbits, point: SpecialPoint) -> tuple[Orbits, Array]:
    """Return a special point as an orbit by collocation, on a mesh that fits it."""
    orbits = orbits_of(shot.model, shot.varied, point.period, len(point.nodes))
    return on_mesh(orbits, orbits.unknown(point.nodes, point.model))
