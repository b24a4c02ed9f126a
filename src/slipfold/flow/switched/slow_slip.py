"""How near slip in the plane comes to zero, and how short it is at rest."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from slipfold.arrays import Array
from slipfold.flow.equations import Constants
from slipfold.flow.switched.events import UNIT, Ending
from slipfold.flow.switched.mode import Mode, Status
from slipfold.flow.switched.step_polynomials import SlowPolynomials
from slipfold.flow.switched.switched_flow import Leg, SwitchedFlow


def left_to_touch(
    flow: SwitchedFlow, start: Array, passed: Sequence[tuple[Leg, Mode]], constants: Constants
) -> list[float]:
    """Return least speeds of slow slip, over its size, and squares of the lengths of its stops.

    Of a stop and what follows only the length counts. Shapes: start (n,).
    """
    weights, found = flow.weights(start, constants), list[float]()
    state, stopped, released = start, dict[int, float](), False
    for leg, after in passed:
        slow = leg.mode.index(Status.SLOW) if Status.SLOW in leg.mode else None
        stops = leg.event is not None and leg.event.ending is Ending.STOPS
        if slow is not None and not (leg.released or released or stops):
            again = flow.run(
                leg.mode, state, leg.begin, leg.end, constants, weights, dense=True
            ).polynomials
            assert isinstance(again, SlowPolynomials)
            found += [speed * weights[slow] for speed in _least_speeds(again, len(start))]
        for contact, place in enumerate(flow.quantities.places):
            if place.stop - place.start < 2:
                continue
            if leg.mode[contact] is not Status.STICK and after[contact] is Status.STICK:
                stopped[contact] = leg.end
            elif after[contact] is not Status.STICK and contact in stopped:
                found.append((leg.end - stopped.pop(contact)) ** 2)
        state, released = leg.state, leg.released
    return found


def _least_speeds(slow: SlowPolynomials, n: int) -> list[float]:
    """Return the minima of a speed inside of a leg, in m/s."""
    inner, found = slow.inner, list[float]()
    for begin, end, powers in zip(inner.times, inner.times[1:], inner.tcs[:, n], strict=False):
        slopes = np.polynomial.polynomial.polyder(powers)
        at = np.polynomial.polynomial.polyval(np.array([0.0, end - begin]), slopes)
        if not at[0] < 0 <= at[1]:
            continue
        low, high = 0.0, end - begin
        for _ in range(60):
            middle = 0.5 * (low + high)
            falls = np.polynomial.polynomial.polyval(middle, slopes) < 0
            low, high = (middle, high) if falls else (low, middle)
        found.append(float(np.exp(UNIT * np.polynomial.polynomial.polyval(low, powers))))
    return found
