"""Where a contact goes that slides in a plane: in space, and on the counter-body."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes

from slipfold.errors import InputError
from slipfold.flow.switched.contact_motion import ContactMotion
from slipfold.flow.trajectory import Trajectory
from slipfold.long_term.contacts import ShownContacts, find_contacts
from slipfold.orbits.periodic_orbit import PeriodicOrbit
from slipfold.plots.axes import axes_or_new
from slipfold.plots.contact_style import axis_label, legend, line, readable, with_displacement
from slipfold.plots.style import palette

TRACKED = 3
"""Rounds of a track that are drawn by default: it does not close."""


def draw_path(
    motion: Trajectory | PeriodicOrbit,
    contact: str | None = None,
    ax: Axes | None = None,
    *,
    rounds: int = 1,
) -> Axes:
    """Draw where contacts in a plane go, as seen in space; thick where they stick.

    An arrow shows which way the counter-body moves.
    """
    shown = _planar(find_contacts(motion, contact, rounds))
    return _draw(shown, ax, moving=False)


def draw_track(
    motion: Trajectory | PeriodicOrbit,
    contact: str | None = None,
    ax: Axes | None = None,
    *,
    rounds: int = TRACKED,
) -> Axes:
    """Draw the track that contacts in a plane leave on the counter-body; dots where they stick."""
    return _draw(_planar(find_contacts(motion, contact, rounds)), ax, moving=True)


def _planar(shown: ShownContacts) -> ShownContacts:
    for contact in shown.contacts:
        if contact.directions < 2:
            raise InputError(
                f"{contact.name} slides along a line, so it has no path in a plane; kind = "
                "'hysteresis' and 'timeline' show what it does"
            )
    return with_displacement(shown)


def _draw(shown: ShownContacts, ax: Axes | None, *, moving: bool) -> Axes:
    ax = axes_or_new(ax)
    names = [contact.name for contact in shown.contacts]
    colours = dict(zip(names, palette(len(names)), strict=True))
    places = {
        contact.name: [
            piece.displacement - (shown.seconds(piece)[:, None] * piece.plate if moving else 0.0)
            for piece in contact.pieces
        ]
        for contact in shown.contacts
    }
    factor, unit = readable((place for own in places.values() for place in own), shown.units[0])
    for contact in shown.contacts:
        colour = colours[contact.name]
        for piece, place in zip(contact.pieces, places[contact.name], strict=True):
            line(ax, factor * place[:, 0], factor * place[:, 1], piece.status, colour)
        if not moving:
            _show_plate(ax, contact)
    ax.set_aspect("equal", adjustable="datalim")
    ax.margins(0.08)
    on = " on the counter-body" if moving else ""
    ax.set_xlabel(axis_label(f"x{on}", unit))
    ax.set_ylabel(axis_label(f"y{on}", unit))
    legend(ax, shown, colours)
    return ax


def _show_plate(ax: Axes, contact: ContactMotion) -> None:
    """Draw in a corner which way the counter-body moves."""
    velocity = contact.pieces[0].plate[0]
    speed = float(np.hypot(*velocity))
    if speed == 0:
        return
    tail = -24.0 * velocity / speed
    ax.annotate(
        "",
        xy=(0.94, 0.94 if velocity[1] >= 0 else 0.8),
        xycoords="axes fraction",
        xytext=(tail[0], tail[1]),
        textcoords="offset points",
        arrowprops={"arrowstyle": "->", "color": "0.35", "linewidth": 0.9},
    )
