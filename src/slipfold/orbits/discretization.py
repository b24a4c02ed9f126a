"""Discretizations of orbits, and those that cut an orbit into segments."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Hashable, Mapping
from copy import copy
from dataclasses import dataclass
from math import isfinite
from typing import Self

import numpy as np

from slipfold.arrays import Array, Indices
from slipfold.collocation_points import CollocationPoints, gauss_points, radau_points
from slipfold.continuation.newton import SINGULAR
from slipfold.flow.equations import Constants, power_of_two
from slipfold.flow.flow import Flow, flow_of
from slipfold.models.angles import wrap_angles
from slipfold.models.model import Model

STAGES = 6
"""Points an interval: errors at its ends fall with the 12th power of its length, of Radau points
with the 11th."""


class RADAU:
    """When intervals have Radau points."""

    resolved: float = 6.0  # radians of a vibration in an interval, of which points lose 0.4 percent
    decays: float = 3.0  # exponent in a unit of phase beyond which it is stable for certain
    densest: float = 400.0  # intervals a unit of phase up to which what decays slowly is resolved


STIFF = 200.0
"""Turns of the fastest vibration within a period at which collocation becomes quicker: forty masses
in a chain make fifty; beams of three, four and five elements 190, 300 and 500, where shooting takes
half, four times and ten times as long. Fast decay does not count: friction that is steep at rest is
so for moments only."""


@dataclass(frozen=True, eq=False)
class Scheme:
    """How intervals are solved."""

    points: CollocationPoints  # where the equations are met
    density: float = 0.0  # intervals a unit of phase at least


GAUSS = Scheme(gauss_points(STAGES))


def scheme_for(jacobians: Array, stages: int = STAGES) -> Scheme:
    """Return how intervals are solved, from derivatives of the rates a unit of phase.

    Gauss points carry on what they do not resolve as if nothing damped it: nothing fails where
    nothing is damped, but multipliers of stiff modes come near one, and orbits resonate with them.
    Radau points damp it. They are taken where there are, at all places, fast vibrations that decay;
    those that do not are resolved.

    Shapes: jacobians (q, n, n).
    """
    if not np.isfinite(jacobians).all():
        return Scheme(gauss_points(stages))
    values = np.linalg.eigvals(jacobians)
    turning, decays = np.abs(values.imag), -values.real > RADAU.decays
    density = float(turning[~decays].max(initial=0.0)) / RADAU.resolved
    if density > RADAU.densest or not (decays & (turning > 64 * RADAU.resolved)).any(axis=1).all():
        return Scheme(gauss_points(stages))
    return Scheme(radau_points(stages), density)


def is_stiff(jacobian: Array) -> bool:
    """Whether vibrations are too fast for shooting. Shapes: jacobian (n, n), a unit of phase."""
    if not np.isfinite(jacobian).all():
        return False
    return float(np.abs(np.linalg.eigvals(jacobian).imag).max()) > 2 * np.pi * STIFF


def damps_stiff(jacobian: Array) -> bool:
    """Whether they decay, too, so that Radau points damp them away. Shapes: jacobian (n, n)."""
    return is_stiff(jacobian) and scheme_for(jacobian[None]).points.damps


class Discretization(ABC):
    """How equations of orbits are computed from states at the beginnings of m segments of a period.

    It knows which parameters are free, but no unknown: states and constants go in, and mismatches
    with their derivatives come out, in scaled variables.

    `free` has the free parameters with their scales, in their own units; `edges` are the phases at
    which segments begin and end, shape (m + 1,).
    """

    growing = False
    """Whether multipliers keep their digits beside any that are larger by orders of magnitude."""

    noise = 1e-7
    """What rounding makes of test functions of multipliers."""

    remainder = 1e-9
    """What rounding, or a mesh, makes of the equations."""

    smooth = True
    """Whether orbits are those of one and the same smooth flow."""

    chords = True
    """Whether mismatches cost much less than their derivatives."""

    adapts = False
    """Whether `better` leaves the nodes where they are, so that each orbit may have its own."""

    undefined = SINGULAR
    """Why mismatches may not be finite, as a clause."""

    slips_in_planes = False
    """Whether contacts change what they do on the way and some of them slip in any direction."""

    def __init__(self, model: Model, free: Mapping[str, float], period: int, edges: Array) -> None:
        self.model, self.period = model, period
        self._cut(edges)
        self._free(free)
        self.flow: Flow = flow_of(model)
        self.sizes = model.state_scales()
        self.measure_in(model.step_scales())
        self.flow_scales = power_of_two(self.sizes)

    def _cut(self, edges: Array) -> None:
        self.edges, self.start, self.end = edges, edges[:-1], edges[1:]
        self.segments, self.phase = len(edges) - 1, float(edges[0])
        self._following = (np.arange(self.segments) + 1) % self.segments

    def _free(self, free: Mapping[str, float]) -> None:
        self.free = dict(free)
        self.units = np.array(list(free.values()), dtype=float)
        self.indices = [self.model.parameter_index(name) for name in free]

    def freeing(self, free: Mapping[str, float]) -> Self:
        """Return the same with other free parameters."""
        other = copy(self)
        other._free(free)
        other.measure_in(self.scales)
        return other

    def measure_in(self, scales: Array) -> None:
        """Take scales of the states, shape (n,); residuals are measured in `sizes` nevertheless."""
        self.scales = scales
        self.angle_periods = self.model.angle_periods / scales
        self.revolves = bool(self.angle_periods.any())
        self.ratios = scales[None, :] / scales[:, None]
        self.parameter_units = self.units / scales[:, None]

    def evenly(self, nodes: Array, constants: Constants, count: int = 0) -> Array:
        """Return the states at equidistant phases from that of the first node, shape (M, n).

        There are at least as many as requested, and as nodes. Shapes: nodes (m, n).
        """
        return nodes

    def stage_states(self, nodes: Array, constants: Constants) -> tuple[Array, Array] | None:
        """Return states that an orbit passes through and their phases, (q, n) and (q,), if known.

        They are known without more work and to a few digits less than nodes. Shapes: nodes (m, n).
        """
        return None

    def better(
        self, nodes: Array, constants: Constants, blocks: Array | None = None
    ) -> Discretization | None:
        """Return one that is made for this orbit, None where this one serves as well.

        `blocks` are the transition matrices of the segments, if they are known. Shapes: nodes
        (m, n); blocks (m, n, n).
        """
        return None

    def piece(self, nodes: Array, constants: Constants) -> Hashable:
        """Return what is the same for orbits that depend smoothly on each other.

        Shapes: nodes (m, n).
        """
        return None

    @abstractmethod
    def with_period(self, period: int) -> Self:
        """Return the same for orbits of another period."""

    @abstractmethod
    def with_other_errors(self, nodes: Array, constants: Constants) -> Self:
        """Return the same with other errors at an orbit. Shapes: nodes (m, n)."""

    def shifted(
        self, nodes: Array, constants: Constants, along: Array, rates: Array
    ) -> tuple[Self, Array, Array]:
        """Return the same with other errors, and an orbit and a direction in terms of it.

        Shapes: nodes, along (m, n); rates (k,); returns nodes and direction (m', n).
        """
        other = self.with_other_errors(nodes, constants)
        return other, *self.moved_to(other, nodes, constants, along, rates)

    def apart(self, ends: Array, nodes: Array) -> Array:
        """Return by how much scaled states differ, revolutions of angles left out.

        Shapes: ends, nodes (m, n).
        """
        return wrap_angles(ends - nodes, self.angle_periods)

    @abstractmethod
    def mismatch(self, nodes: Array, constants: Constants) -> Array:
        """Return by how much segments miss the next node, in scaled states, shape (m, n).

        Shapes: nodes (m, n).
        """

    @abstractmethod
    def transitions(self, nodes: Array, constants: Constants) -> tuple[Array, Array, Array]:
        """Return the mismatch and the derivatives of the segments' ends, all in scaled states.

        Shapes: nodes (m, n); returns mismatch (m, n), blocks (m, n, n), along (m, n, k).
        """

    def settled(self, blocks: Array, nodes: Array, constants: Constants) -> Array | None:
        """Return blocks without what decays within a segment, None where they are as good.

        Shapes: blocks (m, n, n); nodes (m, n).
        """
        return None

    def divergence(self, nodes: Array, constants: Constants) -> float | None:
        """Return the integral of the rates' divergence over the orbit, None if it is not at hand.

        Shapes: nodes (m, n).
        """
        return None

    def divergence_slope(self, nodes: Array, constants: Constants) -> tuple[Array, Array] | None:
        """Return the derivatives of that integral by scaled nodes and parameters, (m, n) and (k,).

        None if it is not at hand. Shapes: nodes (m, n).
        """
        return None

    @abstractmethod
    def propagate_to(
        self, nodes: Array, constants: Constants, phases: Array
    ) -> tuple[Indices, Array, Array, Array]:
        """Return the states at any phases, from which node each is reached, and their derivatives.

        Shapes: nodes (m, n); phases (q,); returns which (q,), states (q, n), matrices (q, n, n),
        vectors (q, n, k), nothing scaled.
        """

    @abstractmethod
    def states(self, nodes: Array, constants: Constants, phases: Array) -> Array:
        """Return the states at any phases, shape (q, n). Shapes: nodes (m, n); phases (q,)."""

    def started_near(self, nodes: Array, constants: Constants, wanted: Array) -> Array:
        """Return the nodes of a cycle started where these lie nearest to others.

        Shapes: nodes, wanted (m, n).
        """
        samples = self.samples(nodes, constants, max(256, 8 * self.segments))
        closed, spacing = np.concatenate([samples, samples[:1]]), self.period / len(samples)
        tried: Array = np.arange(len(samples), dtype=float) * spacing
        phases = ((self.start - self.phase)[None] + tried[:, None]) % self.period
        grid = np.append(tried, self.period)
        moved = np.stack([np.interp(phases, grid, column) for column in closed.T], axis=-1)
        apart = self.apart(moved / self.scales, wanted / self.scales)
        later = float(tried[(apart**2).sum(axis=(1, 2)).argmin()])
        for _ in range(4):  # each doubles the digits
            started = self.states(nodes, constants, self.start + later)
            rates = self.rates(started, constants)
            gap = -self.apart(started / self.scales, wanted / self.scales)
            # Near an equilibrium all phases are as near.
            step = float((rates * gap).sum() / (rates * rates).sum())
            if not isfinite(step):
                raise ArithmeticError("a cycle that is not known is nearest to nothing")
            later += min(max(step, -spacing), spacing)
        started = self.states(nodes, constants, self.start + later) / self.scales
        return wanted + self.apart(started, wanted / self.scales) * self.scales

    def samples(self, nodes: Array, constants: Constants, count: int) -> Array:
        """Return states at equidistant phases from that of the first node, at least so many."""
        return self.evenly(nodes, constants, count)

    @abstractmethod
    def curvatures(self, nodes: Array, constants: Constants, vectors: Array) -> tuple[Array, Array]:
        """Return the derivatives of ``blocks @ vectors``, all in scaled states.

        Shapes: nodes (m, n); vectors (r, m, n); returns by_states (r, m, n, n),
        by_parameters (r, m, n, k).
        """

    @abstractmethod
    def cubes(self, nodes: Array, constants: Constants, vectors: Array) -> Array:
        """Return the third derivatives of the segments' ends along vectors, in scaled states.

        Shapes: nodes (m, n); vectors (r, m, n); returns (r, m, n).
        """

    def taken(self, other: Discretization, nodes: Array, constants: Constants) -> Array:
        """Return the nodes of an orbit that has those of another discretization, shape (m, n).

        Shapes: nodes (m', n).
        """
        if np.array_equal(self.edges, other.edges):
            return nodes
        return other.states(nodes, constants, self.start)

    def before(self, phases: Array) -> tuple[Indices, Array]:
        """Return the segments in which phases lie, and the phases brought into the orbit.

        Shapes: phases (q,).
        """
        within = self.phase + (phases - self.phase) % self.period
        which = np.searchsorted(self.edges, within, "right") - 1
        return np.clip(which, 0, self.segments - 1), within

    def moved_to(
        self, other: Discretization, nodes: Array, constants: Constants, along: Array, rates: Array
    ) -> tuple[Array, Array]:
        """Return an orbit and a direction at the phases of another discretization.

        Shapes: nodes, along (m, n); rates (k,); returns nodes and direction (m', n).
        """
        if np.array_equal(self.edges, other.edges):
            return nodes, along
        which, states, matrices, vectors = self.propagate_to(nodes, constants, other.start)
        return states, np.einsum("jab,jb->ja", matrices, along[which]) + vectors @ rates

    def rates(self, nodes: Array, constants: Constants) -> Array:
        """Return the rates at the nodes a forcing period, in scaled states, shape (m, n).

        Shapes: nodes (m, n).
        """
        flow = self.flow_at(nodes, constants)
        return flow.rates(nodes, self.start, constants) / self.scales

    def flow_at(self, nodes: Array, constants: Constants) -> Flow:
        """Return the flow at the first node. Shapes: nodes (m, n)."""
        return self.flow

    def changes(self, nodes: Array, constants: Constants) -> Array:
        """Return the phases at which contacts change, (q,), from that of the first node on.

        Shapes: nodes (m, n).
        """
        return np.empty(0)

    def flows_at(
        self, nodes: Array, constants: Constants, phases: Array
    ) -> list[tuple[Flow, Indices]]:
        """Return the flows at phases, each with the rows of those at which it holds.

        Shapes: nodes (m, n); phases (q,).
        """
        return [(self.flow, np.arange(len(phases)))]

    def scheme(self, nodes: Array, constants: Constants, stages: int = STAGES) -> Scheme:
        """Return how collocation should solve intervals, from the vibrations at some of the nodes.

        Shapes: nodes (m, n).
        """
        some = np.linspace(0, self.segments - 1, 8).astype(int)
        found = self.flow.jacobians(nodes[some], self.start[some], constants)
        return scheme_for(found * self.ratios, stages)

    def changing_rates(self, nodes: Array, constants: Constants) -> tuple[Array, Array, Array]:
        """Return the rates at the first nodes with their derivatives, in scaled variables.

        Shapes: nodes (q, n); returns rates (q, n), slopes (q, n, n), by_parameters (q, n, k).
        """
        at, flow = self.start[: len(nodes)], self.flow_at(nodes, constants)
        rates = flow.rates(nodes, at, constants) / self.scales
        slopes = flow.jacobians(nodes, at, constants) * self.ratios
        by_parameters = flow.parameter_slopes(
            nodes, at, constants, constants.rates[:, self.indices]
        )
        return rates, slopes, by_parameters * self.parameter_units

    def changed(
        self, forward: Array, backward: Array, nodes: Array, constants: Constants
    ) -> tuple[Array, Array, Array]:
        r"""Differentiate the sum of :math:`p_j^T A_j q_j` with respect to the unknown.

        A change of :math:`A_j q_j` is a second derivative of the flow along q_j.

        Shapes: forward q_j, backward p_j (r, m, n); nodes (m, n); returns the gradient (m n + k,),
        q_j and the second derivatives along them (r, m, n, n).
        """
        bent, by_parameters = self.curvatures(nodes, constants, forward)
        along_nodes = np.einsum("rja,rjab->jb", backward, bent).ravel() * np.sqrt(self.segments)
        along_free = np.einsum("rja,rjak->k", backward, by_parameters)
        return np.concatenate([along_nodes, along_free]), forward, bent


Cut = Callable[[Model, Mapping[str, float], int, int], Discretization]
"""Makes a discretization of a model, its free parameters, a period and a number of segments."""
