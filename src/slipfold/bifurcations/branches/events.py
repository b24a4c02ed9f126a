"""The user's events along a branch or a locus."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from weakref import WeakKeyDictionary

import numpy as np

from slipfold.arrays import Array
from slipfold.bifurcations.branches.settings import Event
from slipfold.continuation.end import End
from slipfold.continuation.locate import ZERO, locate
from slipfold.continuation.search import Zeros, slope_at
from slipfold.continuation.traced_curve import Found, Monitor, MonitorResult, StepInterval, Stop
from slipfold.errors import InputError
from slipfold.models.model import Model
from slipfold.orbits.bifurcation_types import EXTREMUM_TYPES
from slipfold.orbits.continued import ROUNDING, parameter_rounding
from slipfold.orbits.extrema import AVERAGED, find_extrema
from slipfold.orbits.measures import mean_of, measure_gradient
from slipfold.orbits.orbit_curve import OrbitCurve, OrbitPoint
from slipfold.orbits.uncertainty import SPREAD


@dataclass(frozen=True, eq=False)
class Happened(Found[OrbitPoint]):
    """A user's event that was located."""

    event: Event = field(kw_only=True)

    @property
    def name(self) -> str:
        """What has which value there, or what is largest or smallest."""
        if self.event.value is not None:
            return f"{self.event} = {self.event.value:g}"
        return f"{EXTREMUM_TYPES[self.type].title} {self.event}"

    def model_of(self, model: Model) -> Model:
        """Return the model of the point, with exactly the value of a parameter."""
        event = self.event
        if event.measure != "parameter" or event.value is None:
            return model
        return model.replace(**{event.name: event.value})

    def distance_from(self, again: OrbitPoint) -> float:
        """Return the arclength by which it moves when its orbit is computed again."""
        event, point, slope, rounding = self.event, self.point, self.slope, 0.0
        if event.measure == "parameter":
            return ZERO.close
        if event.value is None:
            one, other = (rate_along(each, event) for each in (point, again))
        else:  # extrema are found at the phases of the same nodes
            orbits, watch = point.curve.orbits, Events(point.curve, [event])
            again = replace(point, z=orbits.adopt(again.curve.orbits, again.z))
            one, other = (float(watch.values(each)[0]) for each in (point, again))
            gradient = measure_gradient(orbits, point.z, event.measure, event.name)
            slope = float(gradient @ point.tangent)  # just below an extremum no secant is it
            rounding = ROUNDING * abs(event.value)
            if (part := point.linearization) is not None:
                bordered = part.bordered(point.tangent)
                rounding += parameter_rounding(bordered, point.z, row=gradient)
        change = SPREAD * abs(other - one) + abs(one) + rounding
        return ZERO.close + change / max(abs(slope), 1e-300)


def rate_along(point: OrbitPoint, event: Event) -> float:
    """Return how fast what an event measures changes along a curve, a unit of arclength."""
    orbits = point.curve.orbits
    gradient = measure_gradient(orbits, point.z, event.measure, event.name)
    return float(gradient @ point.tangent)


class _Watch(Zeros[OrbitPoint]):
    """What events of one kind have in common: each has a function that is zero there."""

    noise = 0.0  # outputs have any unit, and more digits than multipliers

    def __init__(self, curve: OrbitCurve, events: Sequence[Event]) -> None:
        super().__init__(curve)
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
                at = locate(self.curve, known, a, b, function)
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
            if event and event.stop:
                reached = "at an extremum" if event.value is None else f"{event.value:g}"
                reason = f"stopped as requested: {event.measure} of {event.name} is {reached}"
                end = End("event", reason, self.curve.place(item.point.z))
                return MonitorResult(found, Stop(item.point, end))
        return MonitorResult(found)


class Events(_Watch):
    """Records where outputs or a parameter take the values requested, or ends the curve."""

    def _type(self, event: Event, before: float) -> str:
        return "EVENT"

    def _measured(self, point: OrbitPoint) -> Array:
        """Return by how much what each event measures exceeds the value requested."""
        orbits, z, names = point.curve.orbits, point.z, []
        for event in self._events:
            if event.measure not in (*AVERAGED, "parameter") and event.name not in names:
                names.append(event.name)
        if names:
            vector, nodes = orbits.vector(z)[None], orbits.evenly(z)[None]
            extrema = find_extrema(orbits.model, vector, nodes, orbits.period, tuple(names))
        result = []
        for event in self._events:
            assert event.value is not None
            if event.measure == "parameter":
                place = orbits.model.parameter_index(event.name)
                result.append(float(orbits.vector(z)[place]) - event.value)
            elif event.measure in AVERAGED:
                result.append(mean_of(orbits, z, event.measure, event.name) - event.value)
            else:
                result.append(float(extrema.measured(event.measure, event.name)[0]) - event.value)
        return np.array(result)


class ExtremaAlong(_Watch):
    """Records where what events without a value measure has an extremum, or ends the curve."""

    def __call__(self, interval: StepInterval[OrbitPoint]) -> MonitorResult[OrbitPoint]:
        """Return the extrema between two points.

        The first orbit of a branch may have several equal local extrema, or no amplitude: which of
        them becomes the largest is not defined there.
        """
        return MonitorResult() if interval.leaves else super().__call__(interval)

    def _type(self, event: Event, before: float) -> str:
        return "MAX" if before > 0 else "MIN"

    def _measured(self, point: OrbitPoint) -> Array:
        return np.array([rate_along(point, event) for event in self._events])


def events_on(curve: OrbitCurve, events: Sequence[Event]) -> list[Monitor[OrbitPoint]]:
    """Return the monitors that locate events along a curve."""
    valued = [event for event in events if event.value is not None]
    extrema = [event for event in events if event.value is None]
    monitors: list[Monitor[OrbitPoint]] = [Events(curve, valued)] * bool(valued)
    return [*monitors, *[ExtremaAlong(curve, extrema)] * bool(extrema)]


def check_events(events: Sequence[Event], varied: Sequence[str], outputs: Sequence[str]) -> None:
    """Refuse events on what does not vary, or is no output."""
    for event in events:
        if event.measure == "parameter":
            if event.name not in varied:
                raise InputError(
                    f"event on parameter {event.name!r} cannot occur; the response varies "
                    f"{' and '.join(varied)}"
                )
        elif event.name not in outputs:
            raise InputError(
                f"no output {event.name!r} for an event; there are {', '.join(outputs)}"
            )
