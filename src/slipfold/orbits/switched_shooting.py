"""Shooting through stick and slip: orbits whose contacts change what they do on the way."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.flow.contact_state import Undecided
from slipfold.flow.equations import Constants
from slipfold.flow.flow import Flow
from slipfold.flow.hybrid_flow import SmoothPhase, hybrid_flow_of
from slipfold.flow.hybrid_trajectory import Broken, first_mode, smooth_phases
from slipfold.flow.linearized_trajectory import (
    EventMargin,
    Least,
    LinearizedTrajectory,
    grazing_distances,
    least_near,
    linearized_trajectory,
)
from slipfold.flow.modes import CONTACT, Ending, Mode, Status, UndeterminedMode, reported_mode
from slipfold.models.model import Model
from slipfold.orbits.shooting import SEGMENTS, Shooting

DIFFERENCED = 1e-4
"""Step of differences of first derivatives, in scaled states."""

DIFFERENCED_TWICE = 1e-3
"""That of second differences: rounding of 1e-12 is 1e-6 then, and so is what they leave out."""

NEUTRAL = 1e-3
"""Distance of a multiplier from one within which an orbit may rest anywhere."""

RESTING = (
    "the contact{name} of {model} sticks for good, so it may rest anywhere in a range and no orbit "
    "is isolated; choose values at which it slips, or replace the contact by a stiff spring"
)

SAMPLES = 256
"""Samples a phase at which the friction that is left is looked at first."""

ALONE = 1e-9
"""Error of rates, as a fraction, up to which a displacement moves a contact alone."""

LITTLE = 1e-4
"""Slip in scaled states below which residuals leave open where a contact rests: what it comes back
by has one over this as weight."""

NEARBY = 0.01
"""Part of a period within which a change of a contact is the one that is meant."""

WAYS = (Status.FORTH, Status.BACK)

Piece = tuple[tuple[Mode, ...], ...]
"""What contacts do in turn, by groups between which the order makes no difference."""

Passed = list[tuple[SmoothPhase, Mode]]
"""The smooth phases of a trajectory, each with the mode that follows."""


Span = tuple[float, float, Mode]


def joined(spans: Iterable[Span], period: int) -> list[Span]:
    """Join successive intervals of one mode, those at either end of the period too."""
    found = list[Span]()
    for begin, end, mode in spans:
        if found and found[-1][2] == mode:
            found[-1] = (found[-1][0], end, mode)
        else:
            found.append((begin, end, mode))
    if len(found) > 1 and found[0][2] == found[-1][2]:
        _, end, mode = found.pop(0)
        found[-1] = (found[-1][0], end + period, mode)
    return found


def in_turn(found: list[Mode]) -> tuple[Mode, ...]:
    """Return modes in their order, wherever the period starts."""
    return min((tuple(found[i:] + found[:i]) for i in range(len(found))), default=())


class Resting(NamedTuple):
    """Contacts along lines that stick throughout a period, and come back after it.

    Each may rest anywhere in a range: its displacement is an unknown without an equation. The one
    in the middle of the range is taken, where friction has as much left in either direction: where
    the contact begins to slip the range is a point. With one sign, what a contact comes back by and
    where it has less left vanish together only there, not where it slips one way alone.
    """

    contacts: list[int]
    displaced: Array  # derivatives of their displacements by scaled states, shape (k, n)
    states: Array  # what displaces each alone, shape (n, k)
    weights: Array  # of what contacts come back by, zero of those that do not slip, shape (k,)

    def left(self, blocks: Array) -> Array:
        """Return what perturbations become that leave contacts where they rest."""
        held = self.weights == 0
        return np.asarray(blocks - self.states[:, held] @ (self.displaced[held] @ blocks))


def _lowest(values: Array) -> NDArray[np.bool_]:
    """Return which values none beside them is below."""
    falls = np.diff(values, prepend=np.inf, append=np.inf)
    return (falls[:-1] <= 0) & (falls[1:] >= 0)


def _least(near: list[tuple[float, Least, Array, int]], size: float) -> Least:
    """Return the least of margins near their smallest samples, each with what it may fall to."""
    result = None
    for below, sampled, phases, at in sorted(near, key=lambda item: item[0]):
        if result is None or below < result.value - CONTACT.slack * size:
            found = least_near(sampled, phases, at)
            result = found if result is None or found.value < result.value else result
    assert result is not None
    return result


class SwitchedShooting(Shooting):
    """The flow through all modes of a model over a period, from one node.

    The mode at the node follows from its state: contacts at rest stick if friction can hold them.
    One segment is enough, since friction damps perturbations. A node at which the mode changes has
    no tangent.

    `phase` is that of the node.
    """

    def __init__(
        self,
        model: Model,
        free: Mapping[str, float],
        period: int = 1,
        segments: int = 1,
        phase: float = 0.0,
    ) -> None:
        assert segments == 1
        super().__init__(model, free, period, segments, phase)
        self._known = dict[tuple[bytes, bytes, float, float], Passed]()
        self._linear: tuple[object, list[int], LinearizedTrajectory] | None = None
        self.switched = hybrid_flow_of(model)
        self.slips_in_planes = any(len(contact.slip) == 2 for contact in self.switched.contacts)

    smooth = False

    def mismatch(self, nodes: Array, constants: Constants) -> Array:
        """Return by how much the orbit misses its beginning, and contacts where they may rest."""
        missed, rest = super().mismatch(nodes, constants), self.resting(nodes, constants)
        return missed if rest is None else self._placed(rest, nodes, constants, missed)[0]

    def transitions(self, nodes: Array, constants: Constants) -> tuple[Array, Array, Array]:
        """Return the same with derivatives, all in scaled states."""
        missed, blocks, along = super().transitions(nodes, constants)
        rest = self.resting(nodes, constants)
        if rest is None:
            return missed, blocks, along
        passed, directions = self.round(nodes, constants), constants.rates[:, self.indices]
        linearized = self._linearized(nodes[0], passed, constants)
        n, weights = len(self.scales), rest.weights[:, None]
        ends = np.hstack([blocks[0] - np.eye(n), along[0]])
        missed, least, sizes = self._placed(rest, nodes, constants, missed)
        slopes = np.zeros((len(least), ends.shape[1]))
        for row, one in enumerate(least):
            if one is not None:
                slopes[row] = one.slopes(linearized, passed[one.part][0], directions)
        slopes = (slopes[1::2] - slopes[::2]) * [*self.scales, *self.units] / sizes[:, None]
        slopes = rest.states @ (slopes + weights * (rest.displaced @ ends))
        return missed, blocks + slopes[:, :n], along + slopes[:, n:]

    def settled(self, blocks: Array, nodes: Array, constants: Constants) -> Array | None:
        """Return what perturbations become that leave contacts where they rest."""
        rest = self.resting(nodes, constants)
        if rest is None:
            return None
        own, weights = rest.displaced @ blocks, rest.weights[:, None]
        left = np.where(weights > 0, (own + weights * rest.displaced) / (1 + weights), 0.0)
        return np.asarray(blocks + rest.states @ (left - own))

    def resting(self, nodes: Array, constants: Constants) -> Resting | None:
        """Return contacts along lines that stick throughout the period, or nearly so.

        Their displacements have slip as the rate, and are not what friction changes at once.
        Shapes: nodes (1, n).
        """
        flow, places = self.switched, self.switched.quantities.places
        passed = [part for part, _ in self.round(nodes, constants)]
        modes, stuck = [part.reported_mode for part in passed], {Status.STICK}
        at = nodes[0], float(self.start[0]), constants
        plate, does = flow.quantities.at(*at).plate, map(set, zip(*modes, strict=True))
        ways = {
            which: own
            for which, (own, place) in enumerate(zip(does, places, strict=False))
            if place.stop - place.start == 1
            and stuck <= own <= stuck | {*WAYS}
            and (own == stuck or not plate[place.start])
        }
        if not ways:
            return None
        slips = flow.slips.at(*at, np.empty((len(constants.values), 0)))[0] * self.scales
        slips = slips[[places[which].start for which in ways]]
        free = flow.of((Status.FORTH,) * len(places))
        rates = free.jacobians(nodes[:1], self.start[:1], constants)[0] * self.ratios
        displaced = np.linalg.lstsq(rates.T, slips.T, rcond=None)[0].T
        held = sorted({i for mode in modes for i in flow.mode(mode).held_at(constants)})
        wrong = np.hstack([displaced @ rates - slips, displaced[:, held]])
        wrong = np.abs(wrong).max(axis=1) / np.abs(slips).max(axis=1)
        lengths = np.linalg.norm(displaced, axis=1)  # zero where displacements are no states
        displaced /= np.maximum(lengths, np.finfo(float).tiny)[:, None]
        ends = np.array([nodes[0], *(part.state for part in passed)]) / self.scales
        moved = np.abs(displaced @ np.diff(ends, axis=0).T).sum(axis=1)
        slip = np.array([own != stuck for own in ways.values()])
        rests = (wrong < ALONE) & (moved < LITTLE)
        if not rests.any():
            return None
        displaced, weights = displaced[rests], np.where(slip, 1 / LITTLE, 0.0)[rests]
        contacts = np.array([*ways])[rests].tolist()
        return Resting(contacts, displaced, np.linalg.pinv(displaced), weights)

    def _placed(
        self, rest: Resting, nodes: Array, constants: Constants, missed: Array
    ) -> tuple[Array, list[Least | None], Array]:
        """Return the mismatch with the distances of contacts from where they are to rest.

        Also where friction has least left, forth and back in turn, None of contacts that slip so,
        and its size. Shapes: nodes, missed (1, n); returns (1, n), 2 k of them, (k,).
        """
        system = self.switched.system(nodes[0], constants, energies=False)
        passed, flow = [part for part, _ in self.round(nodes, constants)], self.switched
        state = system.held(passed[0].mode, nodes[0], passed[0].begin)
        near = defaultdict[tuple[int, Status], list[tuple[float, Least, Array, int]]](list)
        for number, part in enumerate(passed):
            mode, count = part.reported_mode, int(SAMPLES * (part.end - part.begin)) + 3
            phases = np.linspace(part.begin, part.end, count)
            if part.end > part.begin:
                states = flow.of(mode).along(state[None], phases[None], constants)[0]
                for event in flow.mode(mode).events:
                    if event.ending is Ending.YIELDS and event.which in rest.contacts:
                        margin = EventMargin(flow, mode, event, constants)
                        values = margin.values(states, phases)
                        below = values - np.abs(np.diff(values, 2)).max() / 4
                        for at in np.flatnonzero(_lowest(values)):
                            found = float(values[at]), margin, number, state, float(phases[at])
                            item = float(below[at]), Least(*found), phases, int(at)
                            near[event.which, event.towards].append(item)
            state = part.state
        slips = {(which, part.reported_mode[which]) for part in passed for which in rest.contacts}
        ways = [(which, way) for which in rest.contacts for way in WAYS]
        sizes = 1 / system.weights[len(system.places) :][rest.contacts]
        least = [
            None if way in slips else _least(near[way], size)
            for way, size in zip(ways, sizes.repeat(2), strict=True)
        ]
        left = np.array([0.0 if one is None else one.value for one in least])
        offsets = (left[1::2] - left[::2]) / sizes + rest.weights * (rest.displaced @ missed[0])
        return missed + rest.states @ offsets, least, sizes

    def piece(self, nodes: Array, constants: Constants) -> Piece:
        """Return the modes of the contacts in their order over the period, wherever it starts.

        Shapes: nodes (m, n).
        """
        groups = self.switched.groups(constants)
        spans = (self.spans(nodes, constants, group) for group in groups)
        return tuple(in_turn([mode for *_, mode in found]) for found in spans)

    def stuck_fraction(self, nodes: Array, constants: Constants) -> float:
        """Return the fraction of the period in which a contact sticks. Shapes: nodes (m, n)."""
        spans = self.spans(nodes, constants)
        return sum(end - begin for begin, end, mode in spans if Status.STICK in mode) / self.period

    def spans(
        self, nodes: Array, constants: Constants, group: Sequence[int] | None = None
    ) -> list[Span]:
        """Return the intervals of the modes of all or some contacts: begin, end, and the mode.

        The last one may continue beyond the end of the orbit. Shapes: nodes (m, n).
        """
        found = list[Span]()
        for part, _ in self.round(nodes, constants):
            mode = reported_mode(part.mode)
            mode = mode if group is None else tuple(mode[contact] for contact in group)
            found.append((part.begin, part.end, mode))
        return joined(found, self.period)

    def rests(self, nodes: Array, constants: Constants) -> str | None:
        """Say that a contact in the plane sticks for good at any place, None if none does.

        Shapes: nodes (m, n).
        """
        modes = [mode for *_, mode in self.spans(nodes, constants)]
        rest = self.resting(nodes, constants)
        for which, contact in enumerate(self.switched.contacts):
            known = rest is not None and which in rest.contacts
            if not known and modes and all(mode[which] is Status.STICK for mode in modes):
                _, blocks, _ = self.transitions(nodes, constants)
                if np.abs(np.linalg.eigvals(blocks[0]) - 1).min() < NEUTRAL:
                    name = "" if contact.name == "contact" else f" {contact.name}"
                    return RESTING.format(name=name, model=self.model.name)
        return None

    def grazing_margin(self, nodes: Array, constants: Constants) -> float | None:
        """Return a margin that vanishes where slip in the plane begins or ceases to reach zero.

        It is the minimum speed, over its scale, or the square of the shortest stuck interval, or of
        what a stop leaves unused of friction. None where no slip is slow. Shapes: nodes (m, n).
        """
        system = self.switched.system(nodes[0], constants, energies=False)
        return min(grazing_distances(system, nodes[0], self.round(nodes, constants)), default=None)

    def holds_more(self, nodes: Array, values: Constants, which: int | slice, phase: float) -> bool:
        """Whether contacts have more static friction than kinetic. Shapes: nodes (m, n)."""
        state = self.states(nodes, values, np.array([phase]))[0]
        now = self.switched.quantities.at(state, phase, values)
        more = np.array(now.holding) > (1 + CONTACT.slack) * np.array(now.starting)
        return bool(more[which].all())

    def slowest_end(self, nodes: Array, constants: Constants, how: Ending) -> float | None:
        """Return the slowest rate a phase at which contacts on a line are released, or stop.

        At a release it is the growth of the force that friction lacks, over the margin at the
        beginning of the stop; at a stop that of slip, over its scale. None where none ends so.
        Shapes: nodes (m, n).
        """
        found, none, before = list[float](), np.empty((len(constants.values), 0)), nodes[0]
        system = self.switched.system(nodes[0], constants, energies=False)
        for part, _ in self.round(nodes, constants):
            event = part.event
            if (
                event is not None
                and event.ending is how
                and (part.mode[event.which] is Status.STICK) == (how is Ending.YIELDS)
                and len(self.switched.contacts[event.which].slip) == 1
            ):
                mode = self.switched.mode(reported_mode(part.mode))
                slopes, which = mode.slopes_of(event)
                size = 1 / system.weights[event.which]
                if how is Ending.YIELDS:
                    size = slopes.values(before[None], np.array([part.begin]), constants)[0, which]
                rates = mode.flow.rates(part.state[None], np.array([part.end]), constants)[0]
                by_state, by_phase, _ = slopes.at(part.state, part.end, constants, none)
                found.append(abs(float((by_state[which] @ rates + by_phase[which]) / size)))
            before = part.state
        return min(found, default=None)

    def better(
        self, nodes: Array, constants: Constants, blocks: Array | None = None
    ) -> SwitchedShooting | None:
        """Return one whose node is far from all changes of modes, None if that of this one is.

        A node at which the mode changes has no tangent. Shapes: nodes (m, n).
        """
        spans = self.spans(nodes, constants)
        if len(spans) < 2:
            return None
        away = [
            abs((begin - self.phase + 0.5 * self.period) % self.period - 0.5 * self.period)
            for begin, _, _ in spans
        ]
        longest = max(end - begin for begin, end, _ in spans)
        if min(away) > 0.05 * longest:
            return None
        begin, end, _ = max(spans, key=lambda span: span[1] - span[0])
        return self._starting_at(0.5 * (begin + end))

    def _starting_at(self, phase: float) -> SwitchedShooting:
        return SwitchedShooting(self.model, self.free, self.period, phase=phase % self.period)

    def with_other_errors(self, nodes: Array, constants: Constants) -> SwitchedShooting:
        """Return the same orbit from another node, so that all integration steps differ."""
        spans = self.spans(nodes, constants)
        begin, end, _ = max(spans, key=lambda span: span[1] - span[0])
        places = begin + (end - begin) * np.array([0.3, 0.7])
        apart = np.abs((places - self.phase + self.period / 2) % self.period - self.period / 2)
        return self._starting_at(float(places[apart.argmax()]))

    def evenly(self, nodes: Array, constants: Constants, count: int = 0) -> Array:
        """Return the states at equidistant phases from zero, shape (M, n)."""
        count = max(count, SEGMENTS)
        phases: Array = np.arange(count, dtype=float) * (self.period / count)
        return self.states(nodes, constants, phases)

    def samples(self, nodes: Array, constants: Constants, count: int) -> Array:
        """Return half as many states, at equidistant phases from that of the node."""
        phases: Array = np.arange(count // 2, dtype=float) * (2 * self.period / count)
        return self.states(nodes, constants, self.phase + phases)

    def flow_at(self, nodes: Array, constants: Constants) -> Flow:
        """Return the flow of the mode at the node. Shapes: nodes (1, n)."""
        system = self.switched.system(nodes[0], constants, energies=False)
        return self.switched.of(reported_mode(first_mode(system, nodes[0], float(self.start[0]))))

    def changes(self, nodes: Array, constants: Constants) -> Array:
        """Return the phases at which contacts change, shape (q,)."""
        return np.array([part.end for part, _ in self.round(nodes, constants)])

    def flows_at(
        self, nodes: Array, constants: Constants, phases: Array
    ) -> list[tuple[Flow, NDArray[np.intp]]]:
        """Return the flows of the modes at phases, each with the rows of those it holds at."""
        parts = self.round(nodes, constants)
        if not parts:
            return super().flows_at(nodes, constants, phases)
        ends, modes = np.array([part.end for part, _ in parts]), [part.mode for part, _ in parts]
        which = np.minimum(np.searchsorted(ends, self.before(phases)[1]), len(parts) - 1)
        named = np.array([str(reported_mode(modes[place])) for place in which])
        return [
            (self.switched.of(modes[which[rows[0]]]), rows)
            for rows in (np.flatnonzero(named == name) for name in np.unique(named))
        ]

    def curvatures(self, nodes: Array, constants: Constants, vectors: Array) -> tuple[Array, Array]:
        """Return the derivatives of ``blocks @ vectors``, all in scaled states: by differences."""
        bent, by_parameters = list[Array](), list[Array]()
        units = self.units / self.scales[:, None]
        for vector in vectors:
            step = DIFFERENCED / np.linalg.norm(vector) * vector * self.scales
            sides = [
                self.propagate(nodes + sign * step, self.start, self.end, constants)[1:]
                for sign in (1, -1)
            ]
            over = np.linalg.norm(vector) / (2 * DIFFERENCED)
            bent.append((sides[0][0] - sides[1][0]) * self.ratios * over)
            by_parameters.append((sides[0][1] - sides[1][1]) * units * over)
        return np.array(bent), np.array(by_parameters)

    def cubes(self, nodes: Array, constants: Constants, vectors: Array) -> Array:
        """Return the third derivatives of ends along vectors, in scaled states.

        By differences over a step and half of it, extrapolated; NaN if contacts do something else
        there.
        """
        found = list[Array]()
        for vector in vectors:
            over = np.linalg.norm(vector) / DIFFERENCED_TWICE
            sides = [nodes + sign / over * vector * self.scales for sign in (1, 0.5, 0, -0.5, -1)]
            # The third derivative jumps where changes swap in contacts that only springs couple
            modes = ([mode for *_, mode in self.spans(side, constants)] for side in sides)
            same = len({in_turn(each) for each in modes}) == 1
            ends = (self.propagate(side, self.start, self.end, constants) for side in sides)
            slopes = np.array(
                [((end[1] * self.ratios) @ vector[..., None])[..., 0] for end in ends]
            )
            weights = np.array([-1.0, 16.0, -30.0, 16.0, -1.0]) / 3
            found.append(np.tensordot(weights, slopes, 1) * (over**2 if same else np.nan))
        return np.array(found)

    # -- trajectories --------------------------------------------------------------------------

    def passed(self, start: Array, begin: float, end: float, constants: Constants) -> Passed:
        """Propagate a state from one phase to another; empty where it cannot continue.

        Shapes: start (n,).
        """
        if not (np.isfinite(start).all() and np.isfinite(constants.values).all()):
            return []
        key = start.tobytes(), constants.values.tobytes(), begin, end
        if key not in self._known:
            try:
                found = self.motion(start, begin, end, constants)
            except (Broken, Undecided, UndeterminedMode):
                found = []
            # Slip that begins just before the end is known beyond it only.
            complete = bool(found) and found[-1][0].end <= end
            while len(self._known) >= 8:  # a point of a curve looks at its own several times
                del self._known[next(iter(self._known))]
            self._known[key] = found if complete else []
        return self._known[key]

    def round(self, nodes: Array, constants: Constants) -> Passed:
        """Return the smooth phases of an orbit from its node on. Shapes: nodes (1, n)."""
        return self.passed(nodes[0], float(self.start[0]), float(self.end[0]), constants)

    def motion(self, start: Array, begin: float, end: float, constants: Constants) -> Passed:
        """Do the same; raise an error where a trajectory cannot continue. Shapes: start (n,)."""
        system = self.switched.system(start, constants, energies=False)
        mode = first_mode(system, start, begin)
        return list(smooth_phases(system, mode, system.held(mode, start, begin), end, begin=begin))

    def states(self, nodes: Array, constants: Constants, phases: Array) -> Array:
        """Return the states at any phases, shape (q, n), those of a smooth phase in one batch."""
        passed = self.round(nodes, constants)
        if not passed or any(part.released or Status.SLOW in part.mode for part, _ in passed):
            return super().states(nodes, constants, phases)
        _, within = self.before(phases)
        first = passed[0][0]
        start = self.switched.held(first.mode, nodes[0], first.begin, constants)
        result = np.empty((len(phases), len(start)))
        for part, _ in passed:
            some = np.flatnonzero((within >= part.begin) & (within <= part.end))
            at, which = np.unique([part.begin, *within[some]], return_inverse=True)
            known = start[None]
            if len(at) > 1:
                known = self.switched.of(part.mode).along(known, at[None], constants)[0]
            result[some], start = known[which[1:]], part.state
        return result

    def ends(self, nodes: Array, begin: Array, end: Array, constants: Constants) -> Array:
        """Propagate states, each from a phase to another, shape (m, n)."""
        ends = np.full(nodes.shape, np.nan)
        for place, node in enumerate(nodes):
            passed = self.passed(node, float(begin[place]), float(end[place]), constants)
            if passed:
                ends[place] = passed[-1][0].state
        return ends

    def _linearized(
        self, node: Array, passed: Passed, constants: Constants
    ) -> LinearizedTrajectory:
        """Return the derivatives of a trajectory, those of the last one again."""
        if self._linear is None or self._linear[:2] != (passed, self.indices):
            system = self.switched.system(node, constants, energies=False)
            along = constants.rates[:, self.indices]
            found = linearized_trajectory(system, node, passed, along)
            self._linear = passed, self.indices, found
        return self._linear[2]

    def phase_of(
        self, nodes: Array, constants: Constants, contact: int, near: float
    ) -> tuple[float, Array | None]:
        """Return when a contact changes near a phase, with the derivatives by unknowns.

        None of these where it does not by itself. Shapes: nodes (1, n); returns (n + k,).
        """
        passed, half = self.round(nodes, constants), self.period / 2
        away = {
            number: abs((part.end - near + half) % self.period - half)
            for number, (part, _) in enumerate(passed)
            if part.event is not None and part.event.which == contact
        }
        which = min(away, key=away.__getitem__, default=0)
        if not away or away[which] > NEARBY * self.period:
            return near, None
        late = self._linearized(nodes[0], passed, constants).begins[which + 1][1]
        return passed[which][0].end, late * [*self.scales, *self.units]

    def propagate(
        self, nodes: Array, begin: Array, end: Array, constants: Constants
    ) -> tuple[Array, Array, Array]:
        """Propagate states with their derivatives, unscaled."""
        (m, n), k = nodes.shape, len(self.indices)
        ends, matrices = np.full((m, n), np.nan), np.full((m, n, n), np.nan)
        vectors = np.full((m, n, k), np.nan)
        for place, node in enumerate(nodes):
            passed = self.passed(node, float(begin[place]), float(end[place]), constants)
            if passed:
                found = self._linearized(node, passed, constants)
                ends[place] = passed[-1][0].state
                matrices[place], vectors[place] = found.matrix, found.vectors
        return ends, matrices, vectors
