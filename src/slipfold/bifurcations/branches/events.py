"""The user's events along a branch."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np

from slipfold.arrays import Array
from slipfold.bifurcations.branches.settings import Event
from slipfold.continuation.end import End
from slipfold.continuation.locate import locate
from slipfold.continuation.search import Zeros, slope_at
from slipfold.continuation.traced_curve import Found, MonitorResult, StepInterval, Stop
from slipfold.orbits.extrema import find_extrema
from slipfold.orbits.measures import measure_gradient
from slipfold.orbits.orbit_curve import OrbitPoint, Orbits


@dataclass(frozen=True, eq=False)
class Happened(Found[OrbitPoint]):
    """A user's event that was located."""

    event: Event | None = None


def rate_along(point: OrbitPoint, event: Event) -> float:
    """Return how fast what an event measures changes along a curve, a unit of arclength."""
    orbits = point.curve.orbits
    gradient = measure_gradient(orbits, point.z, event.measure, event.name)
    return float(gradient @ point.tangent)


class _Watch(Zeros[OrbitPoint]):
    """What events of one kind have in common: each has a function that is zero there."""

    def __init__(self, orbits: Orbits, events: Sequence[Event]) -> None:
        super().__init__(orbits)
        self._orbits = orbits
        self._events = events
        self._known: WeakKeyDictionary[OrbitPoint, Array] = WeakKeyDictionary()

    def values(self, point: OrbitPoint) -> Array:
        """Return the functions at a point, computed once."""
        if point not in self._known:
            self._known[point] = self._measured(point)
        return self._known[point]

    def extrapolated(self, points: Sequence[OrbitPoint], weights: Array) -> None:
        """Return None: outputs are known at the points alone."""

    def _measured(self, point: OrbitPoint) -> Array:
        raise NotImplementedError

    def _type(self, event: Event, before: float) -> str:
        raise NotImplementedError

    def located(
        self, known: list[OrbitPoint], a: OrbitPoint, b: OrbitPoint
    ) -> list[Found[OrbitPoint]]:
        """Return the events between two points, or at the second of them."""
        result: list[Found[OrbitPoint]] = []
        for index, event in enumerate(self._events):
            before, after = self.values(a)[index], self.values(b)[index]

            def function(point: OrbitPoint, index: int = index) -> float:
                return float(self.values(point)[index])

            if before * after < 0:
                at = locate(self._orbits, known, a, b, function)
            elif after == 0 != before:
                at = b
            else:
                continue
            slope = slope_at(function, known, at, a, b)
            result.append(Happened(self._type(event, before), at, slope, event=event))
        return result

    def seen(
        self, found: Sequence[Found[OrbitPoint]], interval: StepInterval[OrbitPoint]
    ) -> MonitorResult[OrbitPoint]:
        """Record the events; the first that is to stop the branch does."""
        for item in found:
            event = item.event if isinstance(item, Happened) else None
            if event is not None and event.stop:
                reached = "at an extremum" if event.value is None else f"{event.value:g}"
                reason = f"stopped as requested: {event.measure} of {event.name} is {reached}"
                end = End("event", reason, self._orbits.place(item.point.z))
                return MonitorResult(found, Stop(item.point, end))
        return MonitorResult(found)


class Events(_Watch):
    """Records where outputs or the parameter take the values requested, or ends the branch."""

    def _type(self, event: Event, before: float) -> str:
        return "EVENT"

    def _measured(self, point: OrbitPoint) -> Array:
        """Return by how much what each event measures exceeds the value requested."""
        orbits, z, names = self._orbits, point.z, []
        for event in self._events:
            if event.measure != "parameter" and event.name not in names:
                names.append(event.name)
        if names:
            vector, nodes = orbits.vector(z)[None], orbits.evenly(z)[None]
            extrema = find_extrema(orbits.model, vector, nodes, orbits.period, tuple(names))
        result = []
        for event in self._events:
            assert event.value is not None
            if event.measure == "parameter":
                result.append(orbits.value(z) - event.value)
            else:
                result.append(float(extrema.measured(event.measure, event.name)[0]) - event.value)
        return np.array(result)


class ExtremaAlong(_Watch):
    """Records where what events without a value measure has an extremum, or ends the branch."""

    def watch(self, interval: StepInterval[OrbitPoint]) -> MonitorResult[OrbitPoint]:
        """Return the extrema between two points.

        The first orbit of a branch may have several equal humps, or no amplitude: which of them
        becomes the largest is not defined there.
        """
        return MonitorResult() if interval.leaves else super().watch(interval)

    def _type(self, event: Event, before: float) -> str:
        return "MAX" if before > 0 else "MIN"

    def _measured(self, point: OrbitPoint) -> Array:
        return np.array([rate_along(point, event) for event in self._events])
