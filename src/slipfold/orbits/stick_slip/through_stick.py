"""Orbits through stick and slip that go on where contacts come to their limits."""

from __future__ import annotations

from typing import TypeVar

from slipfold.flow.switched.mode_equations import contacts_of
from slipfold.orbits.discretisations.switched_shooting import SwitchedShooting
from slipfold.orbits.limits import limit_margins, limit_met
from slipfold.orbits.orbit_curve import OrbitCurve
from slipfold.orbits.orbit_point import OrbitPoint

C = TypeVar("C", bound=OrbitCurve)


def through_stick(
    curve: C, point: OrbitPoint, before: OrbitPoint | None
) -> tuple[C, OrbitPoint] | None:
    """Return a curve through stick and slip instead of one that ends at a limit, and its point.

    None where the limit, told by the point before, is none of a contact that may stick.
    """
    orbits = curve.orbits
    beyond = {name for contact in contacts_of(orbits.model) for name in contact.limits}
    limits = orbits.model.limits
    if not beyond or not limits:
        return None
    earlier = None if before is None else limit_margins(before.curve.orbits, before.z)
    if limits[limit_met(limit_margins(orbits, point.z), earlier)].name not in beyond:
        return None
    by = SwitchedShooting(orbits.model, orbits.by.free, orbits.period)
    other = curve.described_by(by)
    again = other.retaken(point)
    if again is None:
        return None
    renewed = other.renewed([again])
    return (other, again) if renewed is None else (renewed[0], renewed[1][0])
