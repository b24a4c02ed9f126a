"""Contacts: their friction law, force, path and status over time."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import pairwise
from types import MappingProxyType
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from slipfold.arrays import Array
from slipfold.errors import InputError
from slipfold.flow.contact_trajectory import ContactPhase
from slipfold.flow.modes import Status
from slipfold.flow.trajectory import Trajectory
from slipfold.long_term.contacts import ContactRounds, find_contacts
from slipfold.models.friction.law import FrictionLaw
from slipfold.orbits.periodic_orbit import PeriodicOrbit
from slipfold.plots.style import add_title, axes_or_new, palette

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

FORCE = "friction force"

Solution = Trajectory | PeriodicOrbit

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


Curve = tuple[str, list[tuple[Array, Array, Status]]]
"""Name of a curve, and coordinates and status of its pieces."""


def _draw(
    shown: ContactRounds,
    ax: Axes | None,
    curves: Sequence[Curve],
    words: tuple[str, str],
    units: tuple[str, str],
) -> Axes:
    """Draw curves, thick where contacts stick; a dot where nothing changes meanwhile.

    In the plane of a contact both axes have one scale; otherwise jumps are joined by faint lines.
    """
    ax, plane = axes_or_new(ax), words[0].startswith("x")
    pieces = [(*piece, place) for place, (_, own) in enumerate(curves) for piece in own]
    across, up = [x for x, *_ in pieces], [y for _, y, *_ in pieces]
    (x_factor, x_unit), (y_factor, y_unit) = (
        readable(across + up if plane else values, unit)
        for values, unit in zip((across, up), units, strict=True)
    )
    colors = palette(len(curves))
    for color, (_, own) in zip(colors, curves, strict=True):
        for before, after in () if plane else pairwise(own):
            ax.plot(
                x_factor * np.append(before[0][-1], after[0][0]),
                y_factor * np.append(before[1][-1], after[1][0]),
                color=color, linewidth=0.5, alpha=0.5,
            )  # fmt: skip
    # What sticks lies on top: along a law it is a short segment between long ones.
    for x, y, status, place in sorted(pieces, key=lambda piece: piece[2] is Status.STICK):
        sticks = status is Status.STICK
        # Changes of a coordinate by rounding are none.
        still = sticks and all(np.ptp(item) <= 1e-9 * np.abs(item).max() for item in (x, y))
        style = "o" if still else ":" if status is Status.OPEN else "-"
        count = 1 if still else len(x)
        ax.plot(
            x_factor * x[:count], y_factor * y[:count], style, color=colors[place],
            linewidth=THICK if sticks else 1.0, markersize=THICK + 1,
        )  # fmt: skip
    if plane:
        ax.set_aspect("equal", adjustable="datalim")
    ax.margins(0.08 if plane else 0.05)
    ax.set_xlabel(axis_label(words[0], x_unit))
    ax.set_ylabel(axis_label(words[1], y_unit))
    _legend(ax, shown, dict(zip((name for name, _ in curves), colors, strict=True)))
    return ax


def _legend(ax: Axes, shown: ContactRounds, names: Mapping[str, str]) -> None:
    """Say above the axes what lines mean: names by color, if there are several, and thick ones."""
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


def with_displacement(shown: ContactRounds, *, planar: bool = False) -> ContactRounds:
    """Return contacts whose displacements are known, in the plane if so; or say which is not."""
    for contact in shown.contacts:
        if planar and contact.directions < 2:
            raise InputError(
                f"{contact.name} slides along a line, so it has no path in a plane; kind = "
                "'hysteresis' and 'timeline' show what it does"
            )
        if np.isnan(contact.pieces[0].displacement).any():
            raise InputError(
                f"how far {contact.name} has moved does not follow from its equations; kind = "
                "'friction' and 'timeline' do without"
            )
    return shown


def draw_path(
    solution: Solution, contact: str | None = None, ax: Axes | None = None, *, rounds: int = 1
) -> Axes:
    """Draw where contacts in a plane go, as seen in space; thick where they stick.

    An arrow shows which way the moving surface moves.
    """
    shown = with_displacement(find_contacts(solution, contact, rounds), planar=True)
    ax = _draw(shown, ax, _places(shown, moving=False), ("x", "y"), (shown.units[0],) * 2)
    for own in shown.contacts:
        velocity = own.pieces[0].plate[0]
        if velocity.any():
            tail = -24.0 * velocity / np.hypot(*velocity)
            ax.annotate(
                "", (0.94, 0.94 if velocity[1] >= 0 else 0.8), xycoords="axes fraction",
                xytext=(tail[0], tail[1]), textcoords="offset points",
                arrowprops={"arrowstyle": "->", "color": "0.35", "linewidth": 0.9},
            )  # fmt: skip
    return ax


def draw_track(
    solution: Solution, contact: str | None = None, ax: Axes | None = None, *, rounds: int = 3
) -> Axes:
    """Draw the track of contacts in a plane on the moving surface; dots where they stick."""
    shown = with_displacement(find_contacts(solution, contact, rounds), planar=True)
    words = "x on the moving surface", "y on the moving surface"
    return _draw(shown, ax, _places(shown, moving=True), words, (shown.units[0],) * 2)


def _places(shown: ContactRounds, *, moving: bool) -> list[Curve]:
    """Return where contacts are in the plane, in space or on the moving surface."""
    curves = list[Curve]()
    for contact in shown.contacts:
        pieces = []
        for piece in contact.pieces:
            surface = shown.seconds(piece)[:, None] * piece.plate if moving else 0.0
            x, y = (piece.displacement - surface).T
            pieces.append((x, y, piece.status))
        curves.append((contact.name, pieces))
    return curves


def draw_hysteresis(
    solution: Solution, contact: str | None = None, ax: Axes | None = None, *, rounds: int = 1
) -> Axes:
    """Draw friction over displacement, in the plane along each direction; thick where it sticks.

    The area of a loop is the work that friction does in a round.
    """
    shown = with_displacement(find_contacts(solution, contact, rounds))
    curves = _forces(shown, lambda piece: piece.displacement)
    return _draw(shown, ax, curves, ("displacement", FORCE), (shown.units[0], shown.units[2]))


def draw_friction_force(
    solution: Solution, contact: str | None = None, ax: Axes | None = None, *, rounds: int = 1
) -> Axes:
    """Draw friction over slip velocity, in the plane along each direction; thick where it sticks.

    Slip is the velocity of the moving surface relative to the body, friction acts on the body.
    """
    shown = find_contacts(solution, contact, rounds)
    curves = _forces(shown, lambda piece: piece.slip)
    return _draw(shown, ax, curves, ("slip velocity", FORCE), (shown.units[1], shown.units[2]))


def _forces(shown: ContactRounds, over: Callable[[ContactPhase], Array]) -> list[Curve]:
    """Return friction along each direction of each contact."""
    curves = list[Curve]()
    for contact in shown.contacts:
        own = f"{contact.name}, " if len(shown.contacts) > 1 else ""
        for axis in range(contact.directions):
            along = "along " + "xy"[axis] if contact.directions > 1 else ""
            name = (own + along).removesuffix(", ") or contact.name
            pieces = contact.pieces
            curves.append(
                (name, [(over(p)[:, axis], p.friction[:, axis], p.status) for p in pieces])
            )
    return curves


def draw_timeline(
    solution: Solution, contact: str | None = None, ax: Axes | None = None, *, rounds: int = 2
) -> Axes:
    """Draw what each contact does over time, one row each.

    It slips forth where the moving surface moves forwards relative to it, along its direction.
    """
    shown = find_contacts(solution, contact, rounds, per_period=1)
    ax = axes_or_new(ax)
    planar = all(item.directions > 1 for item in shown.contacts)
    seen = set[Status]()
    for row, item in enumerate(shown.contacts):
        for piece in item.pieces:
            time, (_, color, hatch) = shown.time(piece), BANDS[piece.status]
            seen.add(piece.status)
            bar: dict[str, Any] = {"color": color, "hatch": hatch, "edgecolor": "0.5"}
            ax.barh(row, time[-1] - time[0], 0.62, left=time[0], linewidth=0.0, **bar)
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
    # Dense near 0, where regularized laws rise
    speeds = np.concatenate([np.linspace(0.0, end, 401), np.geomspace(1e-6 * end, end, 400)])
    speeds = np.unique(speeds)
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
    add_title(ax, law.label)
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
