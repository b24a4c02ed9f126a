"""Windows in which contacts may begin to stick: responses and trajectories there."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from slipfold.arrays import Array
from slipfold.bifurcations.branches.branch import Branch
from slipfold.bifurcations.branches.special_point import SpecialPoint
from slipfold.bifurcations.loci.fan import (
    FanLine,
    ends_in_stick,
    follow_line,
    is_expensive,
    slips_in_planes,
)
from slipfold.bifurcations.loci.isolated import ISOLATED
from slipfold.bifurcations.loci.locus import Locus, lines_between
from slipfold.bifurcations.loci.region_map import Region, RegionCheck
from slipfold.bifurcations.loci.window import Plane, Window
from slipfold.errors import InputError
from slipfold.flow.modes import MET, contacts_of
from slipfold.flow.settlement import CONVERGENCE
from slipfold.flow.simulate import simulate
from slipfold.flow.trajectory import last_round
from slipfold.models.angles import distances
from slipfold.models.model import Model
from slipfold.orbits.bifurcation_types import BIFURCATION_TYPES
from slipfold.orbits.test_functions import critical_places


class STAYS:
    """What counts as stick in a window, and how many responses and trajectories are followed."""

    # Distance of ends, in widths of the window, that are one
    same: float = 1e-6
    # Fraction of the time below which nothing sticks yet: a grazing contact rests for an instant
    none_stuck: float = 1e-5
    # Distance from a locus, in widths of the window, within which a response ends on it
    on_locus: float = 0.01
    # Forcing periods after which a trajectory is tested for a steady state
    rounds: tuple[int, ...] = (64, 256, 1024)
    # Distance from a periodic response that counts as steady, in scaled states
    steady: float = 1e-7
    # Periods of the responses that labels speak of
    periods: tuple[int, ...] = (1, 2)
    # Places of a piece at which trajectories are examined: of two there is no majority
    places: int = 3


def without_duplicates(loci: Sequence[Locus], window: Window) -> tuple[Locus, ...]:
    """Return loci without those of grazing that coincide in the plane with one before."""
    kept, numbers = list[Locus](), dict[int, int]()
    for locus in loci:
        twin = next((other for other in kept if _coincide(other, locus, window)), None)
        if twin is None:
            kept.append(locus)
            numbers[locus.id] = len(kept)
        else:
            numbers[locus.id] = numbers[twin.id]
    return tuple(_renumbered(item, numbers) for item in kept)


def _coincide(one: Locus, other: Locus, window: Window) -> bool:
    """Whether two loci of grazing have both ends in common."""
    if one.type not in MET or (one.type, one.period) != (other.type, other.period):
        return False
    low, high = np.transpose(window)
    ends = np.array([[item.started.values, item.stopped.values] for item in (one, other)])
    places = (ends - low) / (high - low)
    ways = (places[1], places[1][::-1])
    return any(float(np.abs(places[0] - way).max()) < STAYS.same for way in ways)


def _renumbered(locus: Locus, numbers: dict[int, int]) -> Locus:
    """Return a locus that names itself and others by their new numbers."""
    special = tuple(
        replace(point, leads_to=tuple(numbers[number] for number in point.leads_to))
        for point in locus.special
    )
    parent = None if locus.parent is None else numbers[locus.parent]
    return replace(locus, id=numbers[locus.id], parent=parent, special=special)


WHOLE = ("span", "closed")
"""Kinds of ends at which a response is known as far as it goes."""


ALONG_LINES, IN_THE_PLANE = 8, 4
"""Responses that are followed, evenly spread over the lines that come to stick: each takes four
times as long as in slip, of contacts in the plane seconds; a locus is met by several lines."""


def follow_sticking(plane: Plane, lines: list[FanLine]) -> Iterator[Branch]:
    """Add the stick-slip responses of lines that reach stick, and return them."""
    if not contacts_of(plane.model):
        return
    # Those that end at stick in slip, or have no response in slip
    coming = [
        number
        for number, line in enumerate(lines)
        if not line.branches
        or any(ends_in_stick(branch, row) for branch in line.branches for row in (0, -1))
    ]
    most = IN_THE_PLANE if slips_in_planes(plane.model) else ALONG_LINES
    some = np.linspace(0, len(coming) - 1, min(len(coming), most)).round().astype(int)
    for number in (coming[place] for place in some):
        line = lines[number]
        middle = plane.place(line.vary, sum(plane.span(line.vary)) / 2, line.value)
        plane.report("responses", number, len(lines), middle, "through stick")
        found = follow_line(plane, line.vary, line.value, through_stick=True)
        sticking = tuple(item for item in found.branches if item.stuck_fraction is not None)
        failure = found.failure or line.failure
        lines[number] = replace(line, sticking=sticking, failure=failure)
        yield from sticking
        if lines[number].interrupted:
            return


def points_in_stick(branch: Branch, every: bool = False) -> Iterator[SpecialPoint]:
    """Yield the special points of a branch where it has come to stick, or to turn.

    Unless every one is wanted, changes of contacts count only where a response begins to stick at
    all, or turns back: others change nothing that labels of regions say, and may be hundreds.
    """
    for point in branch.special:
        if not point.stuck_fraction >= 0:
            continue
        if point.type in MET:
            begins = point.stuck_fraction < STAYS.none_stuck or _turns_back(branch, point)
            if is_expensive(branch) or not (every or begins):
                continue
        yield point


def _turns_back(branch: Branch, point: SpecialPoint) -> bool:
    """Whether the parameter goes back from a point on."""
    after = int(np.searchsorted(branch.arclength, point.arclength, "right"))
    sides = branch.parameter[max(after - 2, 0)], branch.parameter[min(after + 1, len(branch) - 1)]
    return bool(np.prod(np.array(sides) - point.value) > 0)


def changes_in_stick(line: FanLine) -> Iterator[float]:
    """Yield where stable responses through stick begin, end or lose their stability."""
    for branch in line.sticking:
        for point in points_in_stick(branch):
            others = np.delete(point.multipliers, critical_places(point.type, point.multipliers))
            changes = point.type in BIFURCATION_TYPES or _turns_back(branch, point)
            if changes and (np.abs(others) <= 1).all():
                yield point.value
        if branch.stopped.kind not in WHOLE and branch.stable[-1]:
            yield branch.stopped.value


def unfinished(plane: Plane, line: FanLine, loci: Sequence[Locus]) -> Iterator[str]:
    """Yield where and why responses through stick were given up inside the window.

    Those that end on a locus are left out: other responses begin there.
    """
    low, high = np.transpose(plane.window)
    for branch in line.sticking:
        end = branch.stopped
        place = np.array(plane.place(line.vary, end.value, line.value))
        inside = (low < place).all() and (place < high).all()
        if end.kind not in WHOLE and inside and not _lies_on_one(place, loci, plane.size):
            pairs = zip(plane.names, place, strict=True)
            at = ", ".join(f"{name} = {value:.6g}" for name, value in pairs)
            yield f"a response through stick was followed no farther than {at}: {end.reason}"


def _lies_on_one(place: Array, loci: Sequence[Locus], size: Array) -> bool:
    lines = (line for locus in loci for line in lines_between(locus))
    gaps = (np.linalg.norm((line - place) / size, axis=1) for line in lines)
    return any((gap < STAYS.on_locus).any() for gap in gaps)


def stable_states_near(line: FanLine, value: float) -> Iterator[Array]:
    """Yield a state of each stable segment near a value, from which trajectories settle.

    Shapes: (n_states,).
    """
    for branch in line.sticking:
        parameter, edges = branch.parameter, np.flatnonzero(np.diff(branch.stable)) + 1
        for rows in np.split(np.arange(len(branch)), edges):
            if branch.stable[rows[0]] and np.ptp([*parameter[rows], value]) <= np.ptp(
                parameter[rows]
            ):
                yield branch.nodes[rows[np.abs(parameter[rows] - value).argmin()], 0]


Place = tuple[float, float]


class Settled(NamedTuple):
    """The attractor of a trajectory."""

    period: int  # in forcing periods; 0 if it does not repeat itself, or has ended
    states: Array  # of the last stroboscopic samples, the latest last, shape (period or 1, n)
    note: str
    # Fraction of the last period in which a contact sticks; NaN if slip does not come to zero
    fraction: float = np.nan

    @property
    def state(self) -> Array:
        """The last state."""
        return np.asarray(self.states[-1])

    @property
    def stops(self) -> bool:
        """Whether slip reaches zero."""
        return not np.isnan(self.fraction)

    @property
    def counts(self) -> bool:
        """Whether it is a response that stops, of a period that labels speak of."""
        return self.stops and self.period in STAYS.periods


def settle(model: Model, state: Array) -> Settled:
    """Return the attractor that a trajectory from a state converges to. Shapes: state (n,)."""
    before, last = 0, CONVERGENCE.max_period
    for count in STAYS.rounds:
        trajectory = simulate(model, count, state, tolerance=STAYS.steady, kept=last)
        state = trajectory.states[-1]
        if trajectory.stopped is not None:
            break
        # What approaches period 1 from either side in turn repeats itself in two periods sooner.
        if trajectory.settlement.settled and trajectory.settlement.period in (1, before):
            break
        before = trajectory.settlement.period or 0
    period, note = trajectory.settlement.period or 0, trajectory.settlement.message
    states = trajectory.states[-max(period, 1) :]
    shown = None if trajectory.stopped is not None else last_round(trajectory)
    if shown is None or trajectory.sticking is None:
        return Settled(period, states, note)
    begin = trajectory.periods - max(period, 1)
    changes = any(item.end > begin for item in trajectory.sticking.intervals[:-1])
    stops = changes or shown.fraction > 0
    return Settled(period, states, note, shown.fraction if stops else np.nan)


def sticking_orbits(
    plane: Plane, places: Sequence[Place], seeds: Sequence[Sequence[Array]]
) -> tuple[list[list[Settled]], bool]:
    """Return the stable responses that stop at each place, and whether places agree.

    Trajectories start from rest and from states of the responses found there; their attractor at
    one place is tried at the others: inside a region it exists at all.
    """
    at = [plane.at(place) for place in places]
    seen = list[list[Settled]]()
    for each, states in zip(at, seeds, strict=True):
        seen.append([])
        for found in (settle(each, each.start), *(_settle_from(each, state) for state in states)):
            _add(each, found, seen[-1])
    for i, each in enumerate(at):
        for other in [item for others in seen[:i] + seen[i + 1 :] for item in others]:
            if _periods(seen[i]).count(other.period) < max(
                _periods(others).count(other.period) for others in seen
            ):
                _add(each, _settle_from(each, other.state), seen[i])
    return seen, all(_periods(found) == _periods(seen[0]) for found in seen)


def _settle_from(model: Model, state: Array) -> Settled:
    """Settle from a state of another place, which may be none that can be started from."""
    try:
        return settle(model, state)
    except InputError as error:
        return Settled(0, state[None], str(error))


def _add(model: Model, found: Settled, known: list[Settled]) -> None:
    """Add an attractor unless it is known or of a period that labels leave out."""
    if not found.counts:
        return
    alike = (other.states for other in known if other.period == found.period)
    if not any((distances(model, each, found.state) < ISOLATED.same).any() for each in alike):
        known.append(found)


def _periods(found: Sequence[Settled]) -> list[int]:
    return sorted(item.period for item in found)


def add_sticking(
    plane: Plane, region: Region, places: Sequence[Place], seeds: Sequence[Sequence[Array]]
) -> tuple[Region, list[Settled]]:
    """Return a region with the stable responses in it that stick, and these."""
    every = np.linspace(0, len(places) - 1, min(STAYS.places, len(places))).round().astype(int)
    of = [places[i] for i in every], [seeds[i] for i in every]
    seen, agree = sticking_orbits(plane, *of)
    most = max(seen, key=len, default=[])
    fractions = [one.fraction for found in seen for one in found]
    periods = tuple(_periods(most))
    label = replace(
        region,
        stable=tuple(sorted([*region.stable, *periods])),
        sticking=periods,
        stuck=(min(fractions), max(fractions)) if fractions else (0.0, 0.0),
        consistent=region.consistent and agree,
    )
    return label, most


def sticking_checks(
    plane: Plane, region: Region, responses: Sequence[Settled]
) -> tuple[RegionCheck, ...]:
    """Let trajectories settle well inside a region, from rest and from its responses that stick."""
    at = plane.at(region.place)
    rest = settle(at, at.start)
    known = region.sticking if rest.stops else region.slipping
    agrees = rest.period not in STAYS.periods or rest.period in known
    checks = [RegionCheck(region.place, "rest", rest.period, agrees, rest.note)]
    for item in responses:
        found = _settle_from(at, item.state)
        same = found.stops and found.period == item.period
        note = found.note if found.stops else f"{found.note}, and always slips"
        checks.append(RegionCheck(region.place, f"period {item.period}", found.period, same, note))
    return tuple(checks)
