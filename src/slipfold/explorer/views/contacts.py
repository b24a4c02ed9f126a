"""What contacts do at the end of a motion, as plain data: the last rounds, from event to event."""

from __future__ import annotations

from typing import Any

import numpy as np

from slipfold.errors import InputError
from slipfold.explorer.views.numbers import short
from slipfold.flow import flow_of
from slipfold.flow.last_round import LastRound, last_round
from slipfold.flow.switched.contact_motion import ContactPiece
from slipfold.flow.switched.mode import Status
from slipfold.flow.switched.mode_equations import contacts_of
from slipfold.flow.trajectory import Trajectory
from slipfold.long_term.contacts import ShownContacts, find_contacts
from slipfold.models.sliding_oscillator import SlidingOscillator

SAMPLES = 128
"""Samples a period, or a round of a cycle, and at most what makes MOST_SAMPLES of all."""

MOST_SAMPLES = 4096

WORDS = {Status.STICK: "stick", Status.FORTH: "forth", Status.BACK: "back", Status.OPEN: "open"}


def contacts_view(motion: Trajectory) -> dict[str, Any] | None:
    """Return what contacts do in the last rounds; None if there are none, or no round."""
    if not contacts_of(motion.model) or motion.periods == 0:
        return None
    try:
        shown = find_contacts(motion, per_period=SAMPLES)
    except InputError:
        return None
    model, flow = shown.model, flow_of(motion.model)
    length = shown.contacts[0].end
    count = max(round(length), 1)
    each = min(2 * SAMPLES, MOST_SAMPLES // count)
    values = motion.steady_outputs(count, each)
    last = values[:1] if shown.repeats else values[-1:]
    values = np.concatenate([values, last])
    columns = {
        name: short(values[:, i])
        for i, name in enumerate(flow.output_names)
        if np.isfinite(values[:, i]).all()
    }
    names = [state.name for state in model.states]
    period = flow.constants_of(model).period
    return {
        "t": short(np.linspace(0.0, length * period, len(values))),
        "states": {name: columns[name] for name in names},
        "outputs": {name: column for name, column in columns.items() if name not in names},
        "period": count,
        "mechanism": {"kind": "sliding"} if isinstance(model, SlidingOscillator) else None,
        "contacts": [
            {
                "name": contact.name,
                "plate": contact.pieces[0].plate[0].tolist(),
                "units": list(shown.units),
                "pieces": [_piece(shown, piece) for piece in contact.pieces],
            }
            for contact in shown.contacts
        ],
        "words": _words(motion, shown, last_round(motion)),
    }


def _piece(shown: ShownContacts, piece: ContactPiece) -> dict[str, Any]:
    known = not np.isnan(piece.displacement).any()
    return {
        "state": WORDS[piece.status],
        "t": (shown.unit * piece.phase).tolist(),
        "slip": [short(column) for column in piece.slip.T],
        "friction": [short(column) for column in piece.friction.T],
        "displacement": [short(column) for column in piece.displacement.T] if known else None,
    }


def _words(motion: Trajectory, shown: ShownContacts, last: LastRound | None) -> str:
    """Return in a sentence what contacts do in a round."""
    if last is None:
        return ""
    if last.stuck and motion.sticking is not None:
        return "It is stuck: all contacts stick all the time."
    round_name = "round" if shown.repeats else "period"
    if not last.sticking:
        return f"It always slips in its last {round_name}."
    counts = {item.contact: 0 for item in last.sticking}
    for item in last.sticking:
        counts[item.contact] += 1
    told = " and ".join(f"{name} sticks {_times(count)}" for name, count in counts.items())
    share = f"{100 * last.fraction:.3g}\u202f% of the time"
    return f"In its last {round_name} {told}, {share}."


def _times(count: int) -> str:
    return {1: "once", 2: "twice"}.get(count, f"{count} times")
