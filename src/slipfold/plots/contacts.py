"""Contacts: their friction law, force, path and status over time."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from itertools import pairwise
from types import MappingProxyType

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from slipfold.arrays import Array
from slipfold.errors import InputError
from slipfold.flow.contact_trajectory import ContactPhase, ContactTrajectory
from slipfold.flow.modes import Status
from slipfold.flow.trajectory import Trajectory
from slipfold.long_term.contacts import ContactRounds, find_contacts
from slipfold.models.friction.law import FrictionLaw
from slipfold.orbits.periodic_orbit import PeriodicOrbit
from slipfold.plots.style import axes_or_new, palette

BANDS: Mapping[Status, tuple[str, str, str]] = MappingProxyType(
    {
        Status.STICK: ("sticks", "#0d0887", ""),
        Status.FORTH: ("slips forth", "#f3b27a", ""),
        Status.BACK: ("slips back", "#fbe3cd", ""),
        Status.OPEN: ("open", "#ffffff", "////"),
    }
)
"""Word, color and hatch of what a contact does; colors differ in lightness too."""

THICK = 3.6
"""Width of a line where the contact sticks."""

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


def line(ax: Axes, x: Array, y: Array, status: Status, color: str) -> None:
    """Draw what a contact does in one piece; a dot where it sticks and nothing changes."""
    if status is Status.STICK:
        # Changes of a coordinate by rounding are none.
        still = all(np.ptp(item) <= 1e-9 * np.abs(item).max() for item in (x, y))
        ax.plot(
            x[:1] if still else x,
            y[:1] if still else y,
            "o" if still else "-",
            color=color,
            linewidth=THICK,
            markersize=THICK + 1,
        )
    else:
        ax.plot(x, y, color=color, linewidth=1.0, linestyle=":" if status is Status.OPEN else "-")


def legend(ax: Axes, shown: ContactRounds, names: Mapping[str, str]) -> None:
    """Say below the axes what lines mean: names by color, if there are several, and thick ones."""
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


def with_displacement(shown: ContactRounds) -> ContactRounds:
    """Return contacts whose displacements are known, or say which is not."""
    for contact in shown.contacts:
        if np.isnan(contact.pieces[0].displacement).any():
            raise InputError(
                f"how far {contact.name} has moved does not follow from its equations; kind = "
                "'friction' and 'timeline' do without"
            )
    return shown


def draw_path(
    motion: Trajectory | PeriodicOrbit,
    contact: str | None = None,
    ax: Axes | None = None,
    *,
    rounds: int = 1,
) -> Axes:
    """Draw where contacts in a plane go, as seen in space; thick where they stick.

    An arrow shows which way the moving surface moves.
    """
    shown = _planar(find_contacts(motion, contact, rounds))
    return _draw_place(shown, ax, moving=False)


def draw_track(
    motion: Trajectory | PeriodicOrbit,
    contact: str | None = None,
    ax: Axes | None = None,
    *,
    rounds: int = 3,
) -> Axes:
    """Draw the track of contacts in a plane on the moving surface; dots where they stick."""
    return _draw_place(_planar(find_contacts(motion, contact, rounds)), ax, moving=True)


def _planar(shown: ContactRounds) -> ContactRounds:
    for contact in shown.contacts:
        if contact.directions < 2:
            raise InputError(
                f"{contact.name} slides along a line, so it has no path in a plane; kind = "
                "'hysteresis' and 'timeline' show what it does"
            )
    return with_displacement(shown)


def _draw_place(shown: ContactRounds, ax: Axes | None, *, moving: bool) -> Axes:
    ax = axes_or_new(ax)
    names = [contact.name for contact in shown.contacts]
    colors = dict(zip(names, palette(len(names)), strict=True))
    places = {
        contact.name: [
            piece.displacement - (shown.seconds(piece)[:, None] * piece.plate if moving else 0.0)
            for piece in contact.pieces
        ]
        for contact in shown.contacts
    }
    factor, unit = readable((place for own in places.values() for place in own), shown.units[0])
    for contact in shown.contacts:
        color = colors[contact.name]
        for piece, place in zip(contact.pieces, places[contact.name], strict=True):
            line(ax, factor * place[:, 0], factor * place[:, 1], piece.status, color)
        if not moving:
            _show_plate(ax, contact)
    ax.set_aspect("equal", adjustable="datalim")
    ax.margins(0.08)
    on = " on the moving surface" if moving else ""
    ax.set_xlabel(axis_label(f"x{on}", unit))
    ax.set_ylabel(axis_label(f"y{on}", unit))
    legend(ax, shown, colors)
    return ax


def _show_plate(ax: Axes, contact: ContactTrajectory) -> None:
    """Draw in a corner which way the moving surface moves."""
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
    return _draw_force(shown, ax, "displacement", shown.units[0], lambda piece: piece.displacement)


def draw_friction_force(
    motion: Trajectory | PeriodicOrbit,
    contact: str | None = None,
    ax: Axes | None = None,
    *,
    rounds: int = 1,
) -> Axes:
    """Draw friction over slip velocity, in the plane along each direction; thick where it sticks.

    Slip is the velocity of the moving surface relative to the body, friction acts on the body.
    """
    shown = find_contacts(motion, contact, rounds)
    return _draw_force(shown, ax, "slip velocity", shown.units[1], lambda piece: piece.slip)


def _draw_force(
    shown: ContactRounds,
    ax: Axes | None,
    word: str,
    unit: str,
    over: Callable[[ContactPhase], Array],
) -> Axes:
    pieces = [piece for contact in shown.contacts for piece in contact.pieces]
    along, unit = readable((over(piece) for piece in pieces), unit)
    up, force = readable((piece.friction for piece in pieces), shown.units[2])
    names = [name for name, _ in _lines(shown)]
    colors = dict(zip(names, palette(len(names)), strict=True))
    ax = axes_or_new(ax)
    for name, parts in _lines(shown):
        for (before, axis), (after, _) in pairwise(parts):
            ends = [
                (along * over(before)[-1, axis], up * before.friction[-1, axis]),
                (along * over(after)[0, axis], up * after.friction[0, axis]),
            ]
            ax.plot(*zip(*ends, strict=True), color=colors[name], linewidth=0.5, alpha=0.5)
    # What sticks lies on top: along a law it is a short stretch between long ones.
    for stuck in (False, True):
        for name, parts in _lines(shown):
            for piece, axis in parts:
                if (piece.status is Status.STICK) is stuck:
                    x, y = along * over(piece)[:, axis], up * piece.friction[:, axis]
                    line(ax, x, y, piece.status, colors[name])
    ax.margins(0.05)
    ax.set_xlabel(axis_label(word, unit))
    ax.set_ylabel(axis_label("friction force", force))
    legend(ax, shown, colors)
    return ax


def _lines(shown: ContactRounds) -> Iterator[tuple[str, list[tuple[ContactPhase, int]]]]:
    """Yield each component of each contact with its name."""
    for contact in shown.contacts:
        own = f"{contact.name}, " if len(shown.contacts) > 1 else ""
        for axis in range(contact.directions):
            along = "along " + "xy"[axis] if contact.directions > 1 else ""
            name = (own + along).removesuffix(", ") or contact.name
            yield name, [(piece, axis) for piece in contact.pieces]


def draw_timeline(
    motion: Trajectory | PeriodicOrbit,
    contact: str | None = None,
    ax: Axes | None = None,
    *,
    rounds: int = 2,
) -> Axes:
    """Draw what each contact does over time, one row each.

    It slips forth where the moving surface moves forwards relative to it, along its direction.
    """
    shown = find_contacts(motion, contact, rounds, per_period=1)
    ax = axes_or_new(ax)
    planar = all(item.directions > 1 for item in shown.contacts)
    seen = set[Status]()
    for row, item in enumerate(shown.contacts):
        for piece in item.pieces:
            time, (_, color, hatch) = shown.time(piece), BANDS[piece.status]
            seen.add(piece.status)
            ax.barh(
                row,
                time[-1] - time[0],
                0.62,
                left=time[0],
                color=color,
                hatch=hatch,
                edgecolor="0.5",
                linewidth=0.0,
            )
        ends = shown.time(item.pieces[0])[0], shown.time(item.pieces[-1])[-1]
        ax.barh(row, ends[1] - ends[0], 0.62, left=ends[0], fill=False, linewidth=0.6)
        ax.set_xlim(*ends)
    ax.set_ylim(len(shown.contacts) - 0.4, -0.6)
    ax.set_yticks(range(len(shown.contacts)), [item.name for item in shown.contacts])
    ax.tick_params(axis="y", which="both", length=0)
    ax.minorticks_off()
    ax.set_xlabel("time (forcing periods)" if shown.model.forced else "time (s)")
    ax.ticklabel_format(axis="x", useOffset=False)
    ax.locator_params(axis="x", nbins=5)  # long runs have long numbers
    handles = [
        Patch(
            facecolor=color,
            hatch=hatch,
            edgecolor="0.5",
            linewidth=0.6,
            label="slips" if planar and status is Status.FORTH else word,
        )
        for status, (word, color, hatch) in BANDS.items()
        if status in seen
    ]
    ax.legend(handles=handles, loc="lower left", bbox_to_anchor=(0, 1), ncols=len(handles))
    return ax


SLOPE = "#9c4a1a"
"""Color of the slope and of its axis."""


def draw_friction(
    law: FrictionLaw, ax: Axes | None = None, color: str = "black", *, fastest: float | None = None
) -> Axes:
    """Draw the friction coefficient in steady slip, and its slope on an axis of its own.

    Where friction falls with the speed, and so feeds vibration, the ground is shaded. What a
    contact at rest can bear is a bar at zero speed.
    """
    end = 6.0 * law.typical_speed if fastest is None else fastest
    if not (np.isfinite(end) and end > 0):
        raise InputError(f"fastest = {fastest} m/s is no speed; give a positive number")
    speeds = _speeds(end)
    coefficient, slope = np.asarray(law.coefficient(speeds)), np.asarray(law.slope(speeds))
    ax = axes_or_new(ax)
    ax.fill_between(
        speeds,
        0,
        1,
        where=slope < -1e-6 * coefficient.max() / end,
        transform=ax.get_xaxis_transform(),
        color="#f3e3d6",
        linewidth=0,
        zorder=0,
    )
    ax.plot(speeds, coefficient, color=color, linewidth=1.4)
    if law.sticks:
        # Half of the bar would lie outside the axes.
        ax.plot([0, 0], [0, law.stiction], color=color, linewidth=3, clip_on=False)
    ax.set_xlim(0, end)
    ax.set_ylim(0, 1.15 * max(float(coefficient.max()), law.stiction) or 1.0)
    ax.set_xlabel("slip speed (m/s)")
    ax.set_ylabel(r"friction coefficient $\mu$")
    ax.set_title(law.label)
    _draw_slope(ax, speeds, slope)
    return ax


def _draw_slope(ax: Axes, speeds: Array, slope: Array) -> None:
    beside = ax.twinx()
    beside.plot(speeds, slope, color=SLOPE, linewidth=1.0, linestyle=(0, (4.5, 2.0)))
    low, high = min(float(slope.min()), 0.0), max(float(slope.max()), 0.0)
    # The rise of a regularized law would dwarf all else: what few speeds reach is cut off.
    usual = np.quantile(np.interp(np.linspace(0, speeds[-1], 401), speeds, slope), 0.95)
    if high > 4.0 * max(usual, -low):
        high = max(2 * float(usual), -low)
    margin = 0.1 * (high - low) or 0.1
    beside.set_ylim(low - margin, high + margin)
    beside.axhline(0.0, color=SLOPE, linewidth=0.5)
    beside.set_ylabel(r"slope d$\mu$/d$v$ (s/m), dashed", color=SLOPE)
    beside.tick_params(axis="y", which="both", colors=SLOPE)
    ax.tick_params(axis="y", which="both", right=False)


def _speeds(end: float) -> Array:
    """Return speeds from 0 to the end, dense near 0, where regularized laws rise."""
    return np.unique(
        np.concatenate([np.linspace(0.0, end, 401), np.geomspace(1e-6 * end, end, 400)])
    )
