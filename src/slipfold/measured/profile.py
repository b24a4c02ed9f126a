"""Intervals of confidence from the profile of the sum of squares: all else fitted at each value."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from slipfold.arrays import Array
from slipfold.measured.descent import best_of_rounds, closest
from slipfold.measured.explanation import Explanation

CLOSE = 1e-2
"""Error of an end where orbits vanish, over its distance from the fitted value."""

REACHED = 0.96
"""Growth of the sum of squares, over that at the ends, from which a parabola gives the end to about
the square of what is left."""

BETTER = 1e-2
"""Decrease of the sum of squares, over the growth at the ends, below which a fit is no better."""

POINTS = 60
"""Points of a profile on one side."""

CHECKS = 3
"""Times that readings are explained anew at its end."""


class Better(Exception):
    """A profile met an explanation that costs less than the fit."""

    def __init__(self, found: Explanation) -> None:
        super().__init__()
        self.found = found


@dataclass(frozen=True, eq=False)
class Profile:
    """The sum of squares about a fit; an interval ends where it has grown by `rise`."""

    best: Explanation
    scale: float
    rise: float
    known: Sequence[Explanation]  # met before: some may lie in other minima
    report: Callable[[Explanation], None]

    def end(self, place: int, way: int, slopes: Array, step: float) -> float:
        """Return the end of the interval of a parameter, downward (-1) or upward (1).

        It is the bound of the parameter where the sum of squares grows no more than that. Raises
        `Better`. `slopes` say how the others change with it at first, `step` is a first step.

        Shapes: slopes (p,).
        """
        inside = [item for item in self.known if self._growth(item) <= self.rise]
        here = max([self.best, *inside], key=lambda item: way * item.values[place])
        for _ in range(CHECKS):
            here = self._followed(here, place, way, slopes, step)
            if here.values[place] == self._bound(place, way):
                break
            again = here.readings.explained(here.model, here)
            if self._growth(again) > 0.9 * self._growth(here):
                break
            here = again  # other orbits explain the readings better there
        value, growth, bound = here.values[place], self._growth(here), self._bound(place, way)
        if growth > REACHED * self.rise:
            value += (value - self.best.values[place]) * (np.sqrt(self.rise / growth) - 1)
        return float(min(value, bound) if way > 0 else max(value, bound))

    def _followed(
        self, here: Explanation, place: int, way: int, slopes: Array, step: float
    ) -> Explanation:
        """Return the last point of a profile that costs no more than it may.

        Where orbits vanish, as at a fold, steps are halved; just beyond readings are explained
        anew, from where the profile goes on if other orbits explain them.
        """
        bound, middle, least = self._bound(place, way), self.best.values[place], CLOSE * step
        over: tuple[float, float] | None = None
        for _ in range(POINTS):
            value = float(here.values[place])
            limit = bound if over is None else over[0]
            room = abs(limit - value)
            if room == 0 or self._growth(here) > REACHED * self.rise:
                break
            if over is not None and room <= max(CLOSE * abs(limit - middle), least):
                break
            length = min(step, room if over is None else self._between(here, over[1], room))
            target = limit if length == room else value + way * length
            there = self._held(here, place, target, slopes)
            if there is None and length > max(CLOSE * abs(target - middle), least):
                step = length / 2
                continue
            if there is None:
                there = self._anew(here, place, target)
            self.report(there)
            growth = self._growth(there)
            if growth > self.rise:
                over = target, growth
            else:
                slopes = (there.values - here.values) / (target - value)
                here, step = there, 2 * length
        return here

    def _bound(self, place: int, way: int) -> float:
        return list(self.best.readings.bounds.values())[place][max(way, 0)]

    def _growth(self, found: Explanation) -> float:
        """Return by how much the sum of squares is above that of the fit."""
        growth = found.cost(self.scale) - self.best.cost(self.scale)
        if growth < -BETTER * self.rise:
            raise Better(found)
        return growth

    def _between(self, here: Explanation, growth: float, room: float) -> float:
        """Return the step to where a parabola through two points has grown by `rise`."""
        inner, middle, outer = np.sqrt(
            np.clip([self._growth(here), (1 + REACHED) / 2 * self.rise, growth], 0, 9 * self.rise)
        )
        return float(np.clip((middle - inner) / (outer - inner), 0.05, 0.95) * room)

    def _held(
        self, here: Explanation, place: int, target: float, slopes: Array
    ) -> Explanation | None:
        """Return the best explanation by the same orbits with a parameter held; None if lost."""
        names, rows = tuple(here.readings.bounds), here.used(self.scale)
        low, high = np.array(list(here.readings.bounds.values())).T
        for rates in (slopes, np.zeros_like(slopes)):
            values = np.clip(here.values + rates * (target - here.values[place]), low, high)
            values[place] = target
            there = here.moved(dict(zip(names, values.tolist(), strict=True)), rows)
            if there is not None:
                return closest(there, names[:place] + names[place + 1 :], self.scale)
        return None

    def _anew(self, here: Explanation, place: int, target: float) -> Explanation:
        """Return the best explanation with a parameter held, of readings explained anew."""
        names = tuple(here.readings.bounds)
        start = here.readings.explained(here.model.replace(**{names[place]: target}))
        return best_of_rounds(start, names[:place] + names[place + 1 :])[0]
