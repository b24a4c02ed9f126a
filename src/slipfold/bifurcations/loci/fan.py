"""Responses along lines through the window, on which loci are detected, and where they graze."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from slipfold.arrays import Array
from slipfold.bifurcations.branches.branch import Branch
from slipfold.bifurcations.branches.make_branch import bare
from slipfold.bifurcations.branches.response import trace_response
from slipfold.bifurcations.branches.special_point import SpecialPoint
from slipfold.bifurcations.branches.start import Begin
from slipfold.bifurcations.loci.locus_equations import LocusEquations
from slipfold.bifurcations.loci.window import Plane
from slipfold.continuation.newton import Correction, correct
from slipfold.continuation.traced_curve import Found
from slipfold.errors import BREAKDOWNS, InputError
from slipfold.flow.modes import GRAZED, contacts_of, limits_of_contacts
from slipfold.models.angles import distances
from slipfold.models.equilibria import equilibria_in, search_equilibrium
from slipfold.models.model import Model
from slipfold.orbits.find import attractor_from
from slipfold.orbits.kinds import orbits_of
from slipfold.orbits.limits import limit_margins, limit_met
from slipfold.orbits.marginal import MarginalShooting
from slipfold.orbits.orbit_curve import Orbits
from slipfold.orbits.switched_shooting import SwitchedShooting
from slipfold.progress import Observer, Progress

BranchEnd = tuple[Branch, int]
"""A branch with its first row, 0, or its last, -1."""


class FAN:
    """Rules for the responses from which a bifurcation set begins."""

    # Distance in scaled variables within which the grazing point lies. A branch in slip ends at
    # 1e-4 of its size; where slip falls steeply the distance goes as the root of that
    near: float = 0.05
    # Difference of an orbit's halves, in scaled states, below which they are one
    same_halves: float = 1e-4
    # How far a response is followed beyond the window, in its widths
    beyond: float = 0.25
    # The same where the parameter scales the forcing: a period doubling above the window may send
    # its branch back below itself
    beyond_quiet: float = 4.0
    # Distance of equilibria, in sizes of the states, that are one
    same_rest: float = 1e-6
    same_place: float = 1e-9  # difference of values, in widths of the window, that is rounding
    starts: int = 32  # states from which Newton's method looks for equilibria
    around: float = 3.0  # their largest distance from the model's own, in scales


class GrazingEnds:
    """The grazing points near which responses of a set end; each is searched for once."""

    def __init__(self, plane: Plane) -> None:
        self._plane = plane
        self.points = dict[BranchEnd, SpecialPoint]()

    def near(self, branches: Sequence[Branch]) -> Iterator[SpecialPoint]:
        """Yield the grazing points near the ends of branches."""
        ends = [(branch, row) for branch in branches for row in (0, -1)]
        for branch, row in ends:
            if ends_in_stick(branch, row) and not is_expensive(branch):
                grazing = _grazing_near(branch, row, self._plane)
                if grazing is not None:
                    self.points[branch, row] = grazing
                    yield grazing


def is_expensive(branch: Branch) -> bool:
    """Whether the locus takes too long: ten seconds a point for doubled orbits in the plane.

    Other slip soon is slow there as well, and equations are stiff.
    """
    return slips_in_planes(branch.model) and branch.period > 1


def slips_in_planes(model: Model) -> bool:
    """Whether contacts of a model slip in the plane: orbits through stick take seconds there."""
    return any(len(contact.slip) == 2 for contact in contacts_of(model))


def ends_in_stick(branch: Branch, row: int = -1) -> bool:
    """Whether a branch in slip ends, or begins, where a contact begins to stick or opens."""
    slips = branch.kind == "periodic" and branch.stuck_fraction is None
    if not slips or branch.ends[row].kind != "limit" or not len(branch):
        return False
    try:
        model = branch.orbit(row).model
    except InputError:  # it ends where parameters contradict each other: there is no model
        return False
    beyond = limits_of_contacts(model)
    if not beyond:
        return False
    before = _margins(branch, 1 if row == 0 else -2) if len(branch) > 1 else None
    return model.limits[limit_met(_margins(branch, row), before)].name in beyond


def _margins(branch: Branch, row: int) -> Array:
    """Return by how much an orbit of a branch keeps each limit."""
    model = branch.orbit(row).model
    orbits = orbits_of(model, {branch.vary: 1.0}, branch.period, branch.nodes.shape[1])
    return limit_margins(orbits, orbits.unknown(branch.nodes[row], model))[0]


def _grazing_near(branch: Branch, row: int, plane: Plane) -> SpecialPoint | None:
    """Return the grazing point just beyond the end of a branch in slip, None if Newton finds none.

    It lies at the same value of the parameter that the branch does not follow.
    """
    last = branch.orbit(row)
    # A small window does not make the way to it long.
    widths = {
        name: max(high - low, abs(last.model.values[name]))
        for name, (low, high) in zip(plane.names, plane.window, strict=True)
    }
    orbits = orbits_of(last.model, widths, branch.period, 1, by=SwitchedShooting)
    z = orbits.unknown(last.nodes[:1], last.model)
    fixed = np.zeros(len(z))
    fixed[len(z) - 2 + (1 - plane.names.index(branch.vary))] = 1.0
    found = [_corrected(orbits, z, fixed, kind) for kind in GRAZED]
    near = [item for item in found if item is not None]
    if not near:
        return None
    kind, curve, grazed = min(near, key=lambda item: item[2].distance)
    return _as_point(branch, row, kind, curve, grazed)


def _corrected(
    orbits: Orbits, z: Array, fixed: Array, kind: str
) -> tuple[str, LocusEquations, Correction] | None:
    """Return a grazing point, None where none is near."""
    by = orbits.by
    assert isinstance(by, SwitchedShooting)
    try:
        grazing = MarginalShooting.at(by, orbits.nodes(z), orbits.constants(z), kind)
        if grazing is None:
            return None
        curve = LocusEquations(orbits.described_by(grazing), kind)
        guess = curve.orbits.adopt(orbits, z)
        correction = correct(curve, guess, fixed, reach=FAN.near)
    except BREAKDOWNS:
        return None
    if not correction.converged or correction.distance > FAN.near:
        return None
    if _repeats(curve.orbits, correction.z):
        return None
    return kind, curve, correction


def _repeats(orbits: Orbits, z: Array) -> bool:
    """Whether an orbit of an even period is one of half the period, gone round twice."""
    if orbits.period % 2:
        return False
    nodes = orbits.evenly(z)
    halves = distances(orbits.model, nodes, np.roll(nodes, len(nodes) // 2, axis=0))
    return bool(halves.max() < FAN.same_halves)


def _as_point(
    branch: Branch, row: int, kind: str, curve: LocusEquations, correction: Correction
) -> SpecialPoint:
    """Return a grazing point as what a locus starts from, at the arclength of the end near it."""
    point = curve.point(correction, float(branch.arclength[row]))
    own = replace(point, curve=curve.orbits)
    found = bare(Found(kind, own, np.inf), np.inf, np.inf)
    value = found.model.values[branch.vary]
    return replace(found, vary=branch.vary, value=value, stuck_fraction=0.0)


FRACTIONS = ((0.5, 0.5), *product((0.25, 0.75), repeat=2))
"""Places in the window, in its widths, where motions may settle on other equilibria."""


@dataclass(frozen=True, eq=False)
class FanLine:
    """A response across the window, in one parameter at a value of the other."""

    vary: str  # name of the parameter followed
    fixed: str  # name of the other
    value: float
    branches: tuple[Branch, ...]  # the response; empty if there is none
    failure: str = ""  # why there is none
    sticking: tuple[Branch, ...] = ()  # the response continued through stick, if it sticks

    @property
    def interrupted(self) -> bool:
        """Whether the response was interrupted."""
        return any(branch.interrupted for branch in (*self.branches, *self.sticking))


def follow_fan(plane: Plane, counts: tuple[int, int]) -> Iterator[FanLine]:
    """Follow responses across a window, first in the second parameter, then in the first."""
    done = 0
    for count, (fixed, vary) in zip(counts, (plane.names, plane.names[::-1]), strict=True):
        across = plane.span(fixed)
        middle = sum(across) / 2
        # Lines at the edges of the window meet loci that are tangent to them. They come last: at
        # the lowest frequencies orbits are the stiffest.
        values = np.linspace(*across, count) if count > 1 else [middle]
        for value in sorted(values, key=lambda each: abs(each - middle)):

            def report(
                progress: Progress, value: float = float(value), vary: str = vary, done: int = done
            ) -> None:
                found = progress.values
                text = f"period {found['period']}, {found['points']} points"
                if progress.total is not None:
                    text += f", {progress.stage} {progress.done} of {progress.total}"
                at = plane.place(vary, found["parameter"], value)
                plane.report("responses", done, sum(counts), at, text)

            line = follow_line(plane, vary, float(value), report)
            yield line
            if line.interrupted:
                return
            done += 1


def follow_line(
    plane: Plane,
    vary: str,
    value: float,
    observer: Observer | None = None,
    *,
    through_stick: bool = False,
) -> FanLine:
    """Follow one response; what keeps it from existing is data, not an error.

    It begins and ends outside the window, at zero where the parameter scales the forcing, so that
    branches that emanate outside are known inside.
    """
    (fixed,) = (name for name in plane.names if name != vary)
    low, high = extended(plane.model, vary, plane.span(vary))
    failure = ""

    def follow(first: float, last: float, *, through_stick: bool) -> tuple[Branch, ...]:
        return trace_response(
            plane.at(plane.place(vary, first, value)),
            vary,
            (first, last),
            settings=plane.settings,
            observer=observer,
            through_stick=through_stick,
        )

    for first, last in ((low, high), (high, low)):
        try:
            branches = follow(first, last, through_stick=through_stick)
        except InputError as error:
            failure = failure or str(error)
            continue
        if first == low and ends_in_stick(branches[0]):  # from the other end it may as well
            with suppress(InputError):
                others = follow(high, low, through_stick=False)
                branches += others if ends_in_stick(others[0]) else ()
        return FanLine(vary, fixed, value, branches)
    return FanLine(vary, fixed, value, (), failure)


def follow_settled(plane: Plane, lines: Sequence[FanLine]) -> Iterator[FanLine]:
    """Follow equilibria that motions settle on and that are not those on the lines.

    Where they branched off outside the window, or exist only inside it, no line across the window
    leads to them. The model's own place comes last.
    """
    known = [plane.model.start] if any(line.branches for line in lines) else []
    own = [plane.model.values[name] for name in plane.names]
    places = [np.array(plane.window)[:, 0] + each * plane.size for each in FRACTIONS]
    for place in [*places, *([np.array(own)] if plane.contains(own) else [])]:
        there = plane.at(place)
        text = "a motion that may settle on another equilibrium"
        plane.report("responses", 0, None, place, text)
        state = None
        with suppress(InputError):
            state = attractor_from(there)
        if isinstance(state, np.ndarray) and _is_another(there, state, known):
            known.append(state)
            for vary, fixed in (plane.names[::-1], plane.names):
                yield _through(plane, there, state, vary, fixed)


def at_rest(plane: Plane, counts: tuple[int, int]) -> Iterator[FanLine]:
    """Follow equilibria across a window, also those that Newton's method finds off the lines."""
    lines: list[FanLine] = []
    for line in follow_fan(plane, counts):
        lines.append(line)
        yield line
    for place in product(*(np.linspace(*across, max(counts)) for across in plane.window)):
        model = plane.at(np.array(place))
        away = np.random.default_rng(0).uniform(-1, 1, (FAN.starts, len(model.start)))
        around = model.start + FAN.around * away * model.state_scales()
        for state in equilibria_in(model, around):
            if not any(_passes(line, plane, model, state) for line in lines):
                for vary, fixed in (plane.names[::-1], plane.names):
                    line = _through(plane, model, state, vary, fixed)
                    if not line.branches:  # it is singular, as in a family, in both directions
                        break
                    lines.append(line)
                    yield line


def with_cycles(plane: Plane, line: FanLine) -> FanLine:
    """Follow the equilibria of a line again, and the cycles from their Hopf points."""
    (branch, *_), middle = line.branches, len(line.branches[0]) // 2
    return _through(plane, branch.orbit(middle).model, branch.states[middle], line.vary, line.fixed)


def _passes(line: FanLine, plane: Plane, model: Model, state: Array) -> bool:
    """Whether an equilibrium lies on a line through the same place."""
    low, high = plane.span(line.fixed)
    if abs(line.value - model.values[line.fixed]) > FAN.same_place * (high - low):
        return False
    near = [
        branch.states[i + 1]
        for branch in line.branches
        if branch.kind == "equilibrium"
        for i in np.flatnonzero(np.diff(branch.parameter > model.values[line.vary]))
    ]
    return not _is_another(model, state, near)


def _is_another(model: Model, state: Array, known: Sequence[Array]) -> bool:
    """Whether an equilibrium is none of those that are found from known states."""
    found = [search_equilibrium(model, near) for near in known]
    apart = (distances(model, other, state) for other in found if other is not None)
    return all(item > FAN.same_rest for item in apart)


def _through(plane: Plane, model: Model, state: Array, vary: str, fixed: str) -> FanLine:
    """Follow an equilibrium across the window in one parameter."""
    begin = Begin(model.values[vary], state=state)
    span, value = extended(model, vary, plane.span(vary)), model.values[fixed]
    try:
        branches = trace_response(model, vary, span, settings=plane.settings, begin=begin)
    except InputError as error:
        at = f"{fixed} = {value:.6g}, {vary} = {begin.value:.6g}"
        failure = f"another equilibrium, at {at}, could not be followed in {vary}: {error}"
        return FanLine(vary, fixed, value, (), failure)
    return FanLine(vary, fixed, value, branches)


def extended(model: Model, vary: str, span: tuple[float, float]) -> tuple[float, float]:
    """Return how far beyond a window responses across it are followed."""
    low, high = span
    parameter, width = model.parameter(vary), high - low
    if model.forcing_amplitude == vary:
        return min(0.0, low), min(high + FAN.beyond_quiet * width, parameter.upper)
    # A bound itself may be excluded. Zero is one as well: what is damping, friction or mass inside
    # the window is none beyond zero, and families of cycles that fill the plane may wait there.
    lowest = max(parameter.lower, 0.0) if low >= 0 else parameter.lower
    highest = min(parameter.upper, 0.0) if high <= 0 else parameter.upper
    lower = low - min(FAN.beyond * width, 0.5 * (low - lowest))
    upper = high + min(FAN.beyond * width, 0.5 * (highest - high))
    return lower, upper
