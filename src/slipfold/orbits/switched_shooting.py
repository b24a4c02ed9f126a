"""Shooting through stick and slip: orbits whose contacts change what they do on the way."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from slipfold.arrays import Array
from slipfold.flow.contact_state import Undecided
from slipfold.flow.equations import Constants
from slipfold.flow.hybrid_flow import SmoothPhase, hybrid_flow_of
from slipfold.flow.hybrid_trajectory import Broken, first_mode, smooth_phases
from slipfold.flow.linearized_trajectory import left_to_touch, linearized_trajectory
from slipfold.flow.modes import Ending, Mode, Status, Undetermined, shown
from slipfold.models.model import Model
from slipfold.orbits.shooting import SEGMENTS, Shooting

NEAR = 0.05
"""Fraction of the longest span without a change that a node keeps away from any."""

DIFFERENCED = 1e-4
"""Step of differences of first derivatives, in scaled states."""

Passed = list[tuple[SmoothPhase, Mode]]
"""The smooth_phases of a trajectory, each with the mode that follows."""


class SwitchedShooting(Shooting):
    """The flow through all modes of a model over m segments of a period.

    What contacts do at a node follows from its state: at rest they stick if friction can hold them.
    One segment is enough, since friction takes more from perturbations than it adds; a node at
    which something changes has no tangent, and the fewer there are the better.

    `phase` is that of the first node.
    """

    def __init__(
        self,
        model: Model,
        free: Mapping[str, float],
        period: int = 1,
        segments: int = 1,
        phase: float = 0.0,
    ) -> None:
        super().__init__(model, free, period, segments, phase)
        self.switched = hybrid_flow_of(model)
        self.slips_in_planes = any(len(contact.slip) == 2 for contact in self.switched.contacts)

    smooth = False

    def piece(self, nodes: Array, constants: Constants) -> tuple[Mode, ...]:
        """Return what contacts do in turn on the way round, wherever it starts.

        Shapes: nodes (m, n).
        """
        found = [mode for _, _, mode in self.spans(nodes, constants)]
        if len(found) < 2:
            return tuple(found)
        return min(tuple(found[i:] + found[:i]) for i in range(len(found)))

    def stuck_fraction(self, nodes: Array, constants: Constants) -> float:
        """Return the fraction of the period in which a contact sticks. Shapes: nodes (m, n)."""
        spans = self.spans(nodes, constants)
        return sum(end - begin for begin, end, mode in spans if Status.STICK in mode) / self.period

    def spans(self, nodes: Array, constants: Constants) -> list[tuple[float, float, Mode]]:
        """Return when on the way round contacts do what: phases of begin and end, and the mode.

        The last one may continue beyond the end of the orbit. Shapes: nodes (m, n).
        """
        found = list[tuple[float, float, Mode]]()
        for node, begin, end in zip(nodes, self.start, self.end, strict=True):
            for leg, _ in self.passed(node, begin, end, constants):
                mode = shown(leg.mode)
                if found and found[-1][2] == mode:
                    found[-1] = (found[-1][0], leg.end, mode)
                else:
                    found.append((leg.begin, leg.end, mode))
        if len(found) > 1 and found[0][2] == found[-1][2]:
            _, end, mode = found.pop(0)
            found[-1] = (found[-1][0], end + self.period, mode)
        return found

    def left_to_touch(self, nodes: Array, constants: Constants) -> float | None:
        """Return what vanishes where slip in the plane begins or ceases to touch zero.

        That is the least speed, over its size, or the square of the shortest stuck interval. None
        where no slip is slow. Shapes: nodes (m, n).
        """
        found = list[float]()
        for node, begin, end in zip(nodes, self.start, self.end, strict=True):
            system = self.switched.system(node, constants)
            found += left_to_touch(system, node, self.passed(node, begin, end, constants))
        return min(found, default=None)

    def slowest_release(self, nodes: Array, constants: Constants) -> float | None:
        """Return how fast, at least, what friction lacks to hold a contact grows where it lets go.

        In what it has at the beginning of the stop, a phase. None where none lets go along a line.
        Shapes: nodes (m, n).
        """
        found, none = list[float](), np.empty((len(constants.values), 0))
        for node, begin, end in zip(nodes, self.start, self.end, strict=True):
            before = node
            for leg, _ in self.passed(node, begin, end, constants):
                event = leg.event
                if event is not None and event.ending is Ending.YIELDS and not event.scaled:
                    mode = self.switched.mode(shown(leg.mode))
                    slopes, which = mode.slopes_of(event)
                    phase = np.array([leg.end])
                    size = slopes.values(before[None], np.array([leg.begin]), constants)[0, which]
                    rates = mode.flow.rates(leg.state[None], phase, constants)[0]
                    by_state, by_phase, _ = slopes.at(leg.state, leg.end, constants, none)
                    rate = float(by_state[which] @ rates + by_phase[which])
                    found.append(abs(rate) / float(abs(size)))
                before = leg.state
        return min(found, default=None)

    def better(self, nodes: Array, constants: Constants) -> SwitchedShooting | None:
        """Return one whose node is far from all changes, None if that of this one is.

        A node that a change passes by has no tangent there. Shapes: nodes (m, n).
        """
        spans = self.spans(nodes, constants)
        if len(spans) < 2 or self.segments > 1:
            return None
        away = [
            abs((begin - self.phase + 0.5 * self.period) % self.period - 0.5 * self.period)
            for begin, _, _ in spans
        ]
        longest = max(end - begin for begin, end, _ in spans)
        if min(away) > NEAR * longest:
            return None
        return self._begun_at(_middle(max(spans, key=lambda span: span[1] - span[0])))

    def _begun_at(self, phase: float) -> SwitchedShooting:
        start = phase % 1.0
        return SwitchedShooting(self.model, self.free, self.period, self.segments, start)

    def shifted(
        self, nodes: Array, constants: Constants, along: Array, rates: Array
    ) -> tuple[SwitchedShooting, Array, Array]:
        """Return the same started elsewhere: all steps between changes then are others."""
        spans = self.spans(nodes, constants)
        begin, end, _ = max(spans, key=lambda span: span[1] - span[0])
        places = begin + (end - begin) * np.array([0.3, 0.7])
        apart = np.abs((places - self.phase + 0.5) % 1.0 - 0.5)
        other = self._begun_at(float(places[apart.argmax()]))
        return other, *self.moved_to(other, nodes, constants, along, rates)

    def evenly(self, nodes: Array, constants: Constants, count: int = 0) -> Array:
        """Return the states at equidistant phases from zero, shape (M, n)."""
        count = max(count, SEGMENTS)
        phases: Array = np.arange(count, dtype=float) * (self.period / count)
        return self.states(nodes, constants, phases)

    def samples(self, nodes: Array, constants: Constants, count: int) -> Array:
        """Return states at equidistant phases from that of the first node: fewer, as they cost."""
        phases: Array = np.arange(count // 2, dtype=float) * (2 * self.period / count)
        return self.states(nodes, constants, self.phase + phases)

    def rates(self, nodes: Array, constants: Constants) -> Array:
        """Return the rates at the nodes a forcing period, in scaled states, shape (m, n)."""
        return self._rates(nodes, self.start, constants) / self.scales

    def changing_rates(self, nodes: Array, constants: Constants) -> tuple[Array, Array, Array]:
        """Return the rates at the first nodes with their derivatives, in scaled variables."""
        at, along = self.start[: len(nodes)], constants.rates[:, self.indices]
        modes = [self._mode(node, phase, constants) for node, phase in zip(nodes, at, strict=True)]
        flows = [self.switched.of(mode) for mode in modes]
        one = [(node[None], at[i : i + 1], constants) for i, node in enumerate(nodes)]
        slopes = np.array([flow.jacobians(*args)[0] for flow, args in zip(flows, one, strict=True)])
        pulls = np.array(
            [flow.pulls(*args, along)[0] for flow, args in zip(flows, one, strict=True)]
        )
        return self.rates(nodes, constants), slopes * self.ratios, pulls * self.pull_units

    def curvatures(self, nodes: Array, constants: Constants, vectors: Array) -> tuple[Array, Array]:
        """Return the derivatives of ``blocks @ vectors``, all in scaled states: by differences."""
        bent, pulled = list[Array](), list[Array]()
        units = self.units / self.scales[:, None]
        for vector in vectors:
            step = DIFFERENCED / np.linalg.norm(vector) * vector * self.scales
            sides = [
                self.carried(nodes + sign * step, self.start, self.end, constants)[1:]
                for sign in (1, -1)
            ]
            over = np.linalg.norm(vector) / (2 * DIFFERENCED)
            bent.append((sides[0][0] - sides[1][0]) * self.ratios * over)
            pulled.append((sides[0][1] - sides[1][1]) * units * over)
        return np.array(bent), np.array(pulled)

    def cubes(self, nodes: Array, constants: Constants, vectors: Array) -> Array:
        """Return the third derivatives of the segments' ends along vectors: by differences."""
        found = np.empty_like(vectors)
        for place, vector in enumerate(vectors):
            size = float(np.linalg.norm(vector))
            step = DIFFERENCED / size * vector * self.scales
            blocks = [
                self.carried(nodes + share * step, self.start, self.end, constants)[1]
                for share in (1, 0, -1)
            ]
            bend = (blocks[0] - 2 * blocks[1] + blocks[2]) * self.ratios
            found[place] = np.einsum("jab,jb->ja", bend, vector) * (size / DIFFERENCED) ** 2
        return found

    # -- trajectories --------------------------------------------------------------------------

    def passed(self, start: Array, begin: float, end: float, constants: Constants) -> Passed:
        """Carry a state from one phase to another; nothing where it cannot continue.

        Shapes: start (n,).
        """
        if not (np.isfinite(start).all() and np.isfinite(constants.values).all()):
            return []
        try:
            found = self.motion(start, begin, end, constants)
        except (Broken, Undecided, Undetermined):
            return []
        # Slip that begins just before the end is known beyond it only.
        return found if found[-1][0].end <= end else []

    def motion(self, start: Array, begin: float, end: float, constants: Constants) -> Passed:
        """Do the same; an error tells why a trajectory cannot continue. Shapes: start (n,)."""
        system = self.switched.system(start, constants)
        mode = first_mode(system, start, begin)
        return list(smooth_phases(system, mode, system.held(mode, start, begin), end, begin=begin))

    def _mode(self, state: Array, phase: float, constants: Constants) -> Mode:
        return shown(first_mode(self.switched.system(state, constants), state, phase))

    def _rates(self, nodes: Array, phases: Array, constants: Constants) -> Array:
        found = np.full(nodes.shape, np.nan)
        for place, (node, phase) in enumerate(zip(nodes, phases, strict=True)):
            flow = self.switched.of(self._mode(node, float(phase), constants))
            found[place] = flow.rates(node[None], np.array([phase]), constants)[0]
        return found

    def ends(self, nodes: Array, begin: Array, end: Array, constants: Constants) -> Array:
        """Carry states, each from a phase to another, shape (m, n)."""
        ends = np.full(nodes.shape, np.nan)
        for place, node in enumerate(nodes):
            passed = self.passed(node, float(begin[place]), float(end[place]), constants)
            if passed:
                ends[place] = passed[-1][0].state
        return ends

    def carried(
        self, nodes: Array, begin: Array, end: Array, constants: Constants
    ) -> tuple[Array, Array, Array]:
        """Carry states with their derivatives, nothing scaled."""
        (m, n), along = nodes.shape, constants.rates[:, self.indices]
        ends, matrices = np.full((m, n), np.nan), np.full((m, n, n), np.nan)
        vectors = np.full((m, n, along.shape[1]), np.nan)
        for place, node in enumerate(nodes):
            passed = self.passed(node, float(begin[place]), float(end[place]), constants)
            if passed:
                system = self.switched.system(node, constants)
                found = linearized_trajectory(system, node, passed, along)
                ends[place] = passed[-1][0].state
                matrices[place], vectors[place] = found.matrix, found.vectors
        return ends, matrices, vectors


def _middle(span: tuple[float, float, Mode]) -> float:
    return 0.5 * (span[0] + span[1])
