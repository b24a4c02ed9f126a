"""How contacts are drawn: colours of what they do, thick lines where they stick, readable units."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from types import MappingProxyType

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from slipfold.arrays import Array
from slipfold.errors import InputError
from slipfold.flow.switched.mode import Status
from slipfold.long_term.contacts import ShownContacts

BANDS: Mapping[Status, tuple[str, str, str]] = MappingProxyType(
    {
        Status.STICK: ("sticks", "#0d0887", ""),
        Status.FORTH: ("slips forth", "#f3b27a", ""),
        Status.BACK: ("slips back", "#fbe3cd", ""),
        Status.OPEN: ("open", "#ffffff", "////"),
    }
)
"""Word, colour and hatch of what a contact does; colours differ in lightness too."""

THICK = 3.6
"""Width of a line where the contact sticks."""

STILL = 1e-9
"""Change of a coordinate, over its size, that is none."""

PREFIXES = ((1.0, ""), (1e-3, "m"), (1e-6, "µ"), (1e-9, "n"))


def readable(parts: Iterable[Array], unit: str) -> tuple[float, str]:
    """Return a factor that makes numbers readable, and the unit that they then have.

    >>> readable([np.array([-0.002, 0.001])], "m")
    (1000.0, 'mm')
    """
    if not unit:
        return 1.0, unit
    largest = max((float(np.abs(part).max(initial=0.0)) for part in parts), default=0.0)
    for size, prefix in PREFIXES:
        if largest >= 0.2 * size:
            return 1.0 / size, prefix + unit
    return 1.0, unit


def axis_label(word: str, unit: str) -> str:
    """Return a label with the unit, if there is one."""
    return f"{word} ({unit})" if unit else word


def line(ax: Axes, x: Array, y: Array, status: Status, colour: str) -> None:
    """Draw what a contact does in one piece; a dot where it sticks and nothing changes."""
    if status is Status.STICK:
        still = all(np.ptp(item) <= STILL * np.abs(item).max() for item in (x, y))
        ax.plot(
            x[:1] if still else x,
            y[:1] if still else y,
            "o" if still else "-",
            color=colour,
            linewidth=THICK,
            markersize=THICK + 1,
        )
    else:
        ax.plot(x, y, color=colour, linewidth=1.0, linestyle=":" if status is Status.OPEN else "-")


def legend(ax: Axes, shown: ShownContacts, names: Mapping[str, str]) -> None:
    """Say below the axes what lines mean: names by colour, if there are several, and thick ones."""
    handles = []
    if len(names) > 1:
        handles = [Line2D([], [], color=own, label=name) for name, own in names.items()]
    states = {piece.status for contact in shown.contacts for piece in contact.pieces}
    neutral = next(iter(names.values())) if len(names) == 1 else "0.45"
    if Status.STICK in states:
        handles.append(Line2D([], [], color=neutral, linewidth=THICK, label="sticks"))
    if Status.OPEN in states:
        handles.append(Line2D([], [], color=neutral, linestyle=":", label="open"))
    if handles:
        ax.legend(handles=handles, loc="lower left", bbox_to_anchor=(0, 1), ncols=len(handles))


def with_displacement(shown: ShownContacts) -> ShownContacts:
    """Return contacts whose displacements are known, or say which is not."""
    for contact in shown.contacts:
        if np.isnan(contact.pieces[0].displacement).any():
            raise InputError(
                f"how far {contact.name} has moved does not follow from its equations; kind = "
                "'friction' and 'timeline' do without"
            )
    return shown
