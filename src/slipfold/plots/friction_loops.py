"""The friction force of contacts over displacement, and over slip velocity."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import pairwise

from matplotlib.axes import Axes

from slipfold.arrays import Array
from slipfold.flow.switched.contact_motion import ContactPiece
from slipfold.flow.switched.mode import Status
from slipfold.flow.trajectory import Trajectory
from slipfold.long_term.contacts import ShownContacts, find_contacts
from slipfold.orbits.periodic_orbit import PeriodicOrbit
from slipfold.plots.axes import axes_or_new
from slipfold.plots.contact_style import axis_label, legend, line, readable, with_displacement
from slipfold.plots.style import palette


def draw_hysteresis(
    motion: Trajectory | PeriodicOrbit,
    contact: str | None = None,
    ax: Axes | None = None,
    *,
    rounds: int = 1,
) -> Axes:
    """Draw friction over displacement, in the plane along each direction; thick where it sticks.

    The area of a loop is the work that friction does in a round.
    """
    shown = with_displacement(find_contacts(motion, contact, rounds))
    return _draw(shown, ax, "displacement", shown.units[0], lambda piece: piece.displacement)


def draw_friction_force(
    motion: Trajectory | PeriodicOrbit,
    contact: str | None = None,
    ax: Axes | None = None,
    *,
    rounds: int = 1,
) -> Axes:
    """Draw friction over slip velocity, in the plane along each direction; thick where it sticks.

    Slip is the velocity of the counter-body relative to the body, friction acts on the body.
    """
    shown = find_contacts(motion, contact, rounds)
    return _draw(shown, ax, "slip velocity", shown.units[1], lambda piece: piece.slip)


def _draw(
    shown: ShownContacts,
    ax: Axes | None,
    word: str,
    unit: str,
    over: Callable[[ContactPiece], Array],
) -> Axes:
    pieces = [piece for contact in shown.contacts for piece in contact.pieces]
    along, unit = readable((over(piece) for piece in pieces), unit)
    up, force = readable((piece.friction for piece in pieces), shown.units[2])
    names = [name for name, _ in _lines(shown)]
    colours = dict(zip(names, palette(len(names)), strict=True))
    ax = axes_or_new(ax)
    for name, parts in _lines(shown):
        for (before, axis), (after, _) in pairwise(parts):
            ends = [
                (along * over(before)[-1, axis], up * before.friction[-1, axis]),
                (along * over(after)[0, axis], up * after.friction[0, axis]),
            ]
            ax.plot(*zip(*ends, strict=True), color=colours[name], linewidth=0.5, alpha=0.5)
    # What sticks lies on top: along a law it is a short stretch between long ones.
    for stuck in (False, True):
        for name, parts in _lines(shown):
            for piece, axis in parts:
                if (piece.status is Status.STICK) is stuck:
                    x, y = along * over(piece)[:, axis], up * piece.friction[:, axis]
                    line(ax, x, y, piece.status, colours[name])
    ax.margins(0.05)
    ax.set_xlabel(axis_label(word, unit))
    ax.set_ylabel(axis_label("friction force", force))
    legend(ax, shown, colours)
    return ax


def _lines(shown: ShownContacts) -> Iterator[tuple[str, list[tuple[ContactPiece, int]]]]:
    """Yield each component of each contact with its name."""
    for contact in shown.contacts:
        own = f"{contact.name}, " if len(shown.contacts) > 1 else ""
        for axis in range(contact.directions):
            along = "along " + "xy"[axis] if contact.directions > 1 else ""
            name = (own + along).removesuffix(", ") or contact.name
            yield name, [(piece, axis) for piece in contact.pieces]
