"""What contacts did in a motion, as labelled arrays and in records."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from slipfold.flow.last_round import LastRound
from slipfold.flow.switched.history import Interval
from slipfold.flow.switched.mode import Status
from slipfold.flow.trajectory import Sticking
from slipfold.models.model import Model
from slipfold.results.fields import REAL, TEXT, WHOLE, Axes, Column, Declared, Table
from slipfold.results.labelled_table import Variable
from slipfold.results.saved_table import SavedTable

WORDS = {
    Status.STICK: "stick", Status.FORTH: "slip", Status.BACK: "slip backwards", Status.OPEN: "open",
}  # fmt: skip

TOLD = 4
"""Times of stick that a summary tells of each contact."""

CONTACTS = Table(
    ("contact",),
    (Column("name", TEXT, "name of the contact", name="contact", get=str, label=True),),
)
MODES = Table(
    ("strobe",),
    (
        Column(
            "modes", WHOLE, "what contacts do: 0 stick, 1 slip, -1 slip backwards, 2 open", "",
            ("contact",), name="modes", head=None,
        ),
    ),
    joined=True,
)  # fmt: skip


def _intervals(model: Model) -> Table:
    unit = "" if model.forced else "s"
    since = "forcing periods since the start" if model.forced else "time since the start"
    return Table(
        ("interval",),
        (
            Column("contact", TEXT, "contact that does one thing in an interval"),
            Column("state", TEXT, "what it does: slip, stick or free"),
            Column("begin", REAL, f"begin of the interval, {since}", unit),
            Column("end", REAL, f"end of the interval, {since}", unit),
            Column("work", REAL, "work of friction on the structure", "J"),
            Column("heat", REAL, "heat from friction", "J"),
        ),
        prefix="interval_",
    )


@dataclass(frozen=True)
class Contacts:
    """What contacts did, as an attribute that is None of a motion that always slips."""

    def names(self, key: str) -> set[str]:
        """Return the dimensions of its arrays."""
        return {"contact", "interval"}

    def variables(self, result: Declared, key: str) -> dict[str, Variable]:
        """Return the arrays of what contacts did."""
        sticking: Sticking | None = getattr(result, key)
        if sticking is None:
            return {}
        axes: Axes = {"contact": sticking.contacts}
        return {
            **CONTACTS.variables(sticking.contacts, {}),
            **MODES.variables([sticking], axes),
            **_intervals(result.model).variables(sticking.intervals, {}),
        }

    def read(self, saved: SavedTable, result: Declared, key: str) -> Sticking | None:
        """Return what contacts did."""
        if not {"modes", "contact"} & set(saved.columns):
            return None
        contacts = tuple(str(name) for name in saved.columns["contact"])
        (modes,) = MODES.read(saved, {"contact": contacts}, ...).values()
        modes.setflags(write=False)
        table = _intervals(saved.model)
        intervals = [Interval(**table.read(saved, {}, row)) for row in range(table.count(saved))]
        return Sticking(contacts, np.asarray(modes), tuple(intervals))

    def record(self, result: Declared, key: str) -> None:
        """Return nothing: records hold the last round alone."""


def stick_record(last: LastRound) -> dict[str, Any]:
    """Return what records hold of the times in which contacts stick."""
    return {
        "fraction": last.fraction,
        "count": len(last.sticking),
        "intervals": [
            {"contact": item.contact, "from": item.begin, "to": item.end} for item in last.sticking
        ],
    }


def stick_columns(sticking: Sticking | None) -> dict[str, list[str]]:
    """Return what each contact does at the start of every forcing period, in words."""
    if sticking is None:
        return {}
    return {
        name: [WORDS[Status(int(value))] for value in sticking.modes[:, place]]
        for place, name in enumerate(sticking.contacts)
    }


def stick_text(last: LastRound, unit: str) -> str:
    """Return when contacts stick, counted from the start of the round."""
    names = dict.fromkeys(item.contact for item in last.sticking)
    parts = []
    for name in names:
        own = [item for item in last.sticking if item.contact == name]
        spans = [f"{item.begin:.6g} to {item.end:.6g}" for item in own[:TOLD]]
        more = f" and {len(own) - TOLD} times more" if len(own) > TOLD else ""
        parts.append(f"{name} from {', '.join(spans)}{more}")
    return f"{'; '.join(parts)} ({unit} from its start)"
