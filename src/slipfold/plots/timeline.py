"""What contacts do over time: bands of stick, slip forth and back, and flight."""

from __future__ import annotations

from matplotlib.axes import Axes
from matplotlib.patches import Patch

from slipfold.flow.switched.mode import Status
from slipfold.flow.trajectory import Trajectory
from slipfold.long_term.contacts import find_contacts
from slipfold.orbits.periodic_orbit import PeriodicOrbit
from slipfold.plots.axes import axes_or_new
from slipfold.plots.contact_style import BANDS

HEIGHT = 0.62
"""Height of a band, over the distance of two."""


def draw_timeline(
    motion: Trajectory | PeriodicOrbit,
    contact: str | None = None,
    ax: Axes | None = None,
    *,
    rounds: int = 2,
) -> Axes:
    """Draw what each contact does over time, one row each.

    It slips forth where the counter-body moves forwards relative to it, along its direction.
    """
    shown = find_contacts(motion, contact, rounds, per_period=1)
    ax = axes_or_new(ax)
    planar = all(item.directions > 1 for item in shown.contacts)
    seen = set[Status]()
    for row, item in enumerate(shown.contacts):
        for piece in item.pieces:
            time, (_, colour, hatch) = shown.time(piece), BANDS[piece.status]
            seen.add(piece.status)
            ax.barh(
                row,
                time[-1] - time[0],
                HEIGHT,
                left=time[0],
                color=colour,
                hatch=hatch,
                edgecolor="0.5",
                linewidth=0.0,
            )
        ends = shown.time(item.pieces[0])[0], shown.time(item.pieces[-1])[-1]
        ax.barh(row, ends[1] - ends[0], HEIGHT, left=ends[0], fill=False, linewidth=0.6)
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
            facecolor=colour,
            hatch=hatch,
            edgecolor="0.5",
            linewidth=0.6,
            label="slips" if planar and status is Status.FORTH else word,
        )
        for status, (word, colour, hatch) in BANDS.items()
        if status in seen
    ]
    ax.legend(handles=handles, loc="lower left", bbox_to_anchor=(0, 1), ncols=len(handles))
    return ax
