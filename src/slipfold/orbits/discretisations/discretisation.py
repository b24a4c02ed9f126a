"""What a discretisation of orbits is made of, whatever its equations."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Hashable, Mapping
from copy import copy
from typing import Self

import numpy as np

from slipfold.arrays import Array
from slipfold.flow import Flow, flow_of
from slipfold.flow.equations import Constants
from slipfold.flow.scaled import power_of_two
from slipfold.models.model import Model


class Discretisation(ABC):
    """How equations of orbits are computed from states at some phases.

    It knows which parameters are free, but no unknown: states and constants go in, and mismatches
    with their derivatives come out, in scaled variables.

    `free` has the free parameters with their scales, in their own units; `segments` is the number m
    of phases.
    """

    growing = False
    """Whether multipliers keep their digits beside any that are larger by orders of magnitude."""

    noise = 1e-9
    """What rounding makes of test functions of multipliers."""

    smooth = True
    """Whether orbits are those of one and the same smooth flow."""

    slips_in_planes = False
    """Whether contacts change what they do on the way and some of them slip in any direction."""

    phase = 0.0
    """Phase of the first node."""

    def __init__(
        self, model: Model, free: Mapping[str, float], period: int = 1, segments: int = 1
    ) -> None:
        self.model = model
        self.period = period
        self.segments = segments
        self._free(free)
        self.flow: Flow = flow_of(model)
        self.measure_in(model.state_scales())
        self.flow_scales = power_of_two(self.scales)

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
        """Take scales of the states, shape (n,)."""
        self.scales = scales
        self.turns = self.model.whole_turns / scales
        self.ratios = scales[None, :] / scales[:, None]
        self.pull_units = self.units / scales[:, None]

    def taken(self, other: Discretisation, nodes: Array, constants: Constants) -> Array:
        """Return the nodes of an orbit that has those of another discretisation, shape (m, n).

        Shapes: nodes (m', n).
        """
        return nodes

    def evenly(self, nodes: Array, constants: Constants, count: int = 0) -> Array:
        """Return the states at equidistant phases from that of the first node, shape (M, n).

        There are at least as many as asked for, and as nodes. Shapes: nodes (m, n).
        """
        return nodes

    def passed_through(self, nodes: Array, constants: Constants) -> tuple[Array, Array] | None:
        """Return states that an orbit passes through and their phases, (q, n) and (q,), if known.

        They are known without more work, one after the other, and to a few digits less than nodes.
        Shapes: nodes (m, n).
        """
        return None

    def moved_to(
        self, other: Discretisation, nodes: Array, constants: Constants, along: Array, rates: Array
    ) -> tuple[Array, Array]:
        """Return an orbit and a direction at the phases of another discretisation.

        Shapes: nodes, along (m, n); rates (k,); returns nodes and direction (m', n).
        """
        return nodes, along

    def better(self, nodes: Array, constants: Constants) -> Discretisation | None:
        """Return one that is made for this orbit, None where this one serves as well.

        Shapes: nodes (m, n).
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
    def shifted(
        self, nodes: Array, constants: Constants, along: Array, rates: Array
    ) -> tuple[Self, Array, Array]:
        """Return the same with other errors, and an orbit and a direction in terms of it.

        Shapes: nodes, along (m, n); rates (k,); returns nodes and direction (m, n).
        """
