"""Tori as arrays, in records and in words."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from slipfold.continuation.end import End
from slipfold.models.model import Model
from slipfold.orbits.extrema import Extrema
from slipfold.results.fields import (
    REAL,
    TEXT,
    TRUTH,
    WHOLE,
    Column,
    Part,
    Table,
    axes_of,
    meaning_of,
)
from slipfold.results.records import SavedTable
from slipfold.results.tables import Variable
from slipfold.text.printed_table import with_unit
from slipfold.tori.torus_branch import Locked, TorusBranch

LASTING = "duration of a round, after which the circle lies on itself"

OWNER = ("torus", "branch of tori it lies on")


def _tori(vary: str, unit: str, *, forced: bool) -> Table:
    """Table of branches of tori."""
    return Table(
        ("torus",),
        (
            Column("id", WHOLE, "number of the branch of tori", name="torus", label=True,
                   record=True),
            Column("kind", get=lambda tori: "torus", record=True),
            Column("period", WHOLE, "in forcing periods", "", record=True),
            Column("parent", WHOLE, "branch that they were born from", record=True),
            Column("points", get=len, record=True),
            Column("values", get=lambda tori: tori.parameter, record=True),
            *(
                Column(name, record=True)
                for name in ("rotation", "frequency", "stable", "growth", "growth_error")
            ),
            *(() if forced else (Column("durations", record=True),)),
            Column("truncation", record=True),
            Column("omitted", record=True),
            Column("minimum", get=lambda tori: _by_name(tori.extrema, 0), record=True),
            Column("maximum", get=lambda tori: _by_name(tori.extrema, 1), record=True),
            Column("special", get=_folds, record=True),
            Column("locked", get=_locked, record=True),
            Column("begun", get=lambda tori: _end(tori.begun), record=True),
            Column("stopped", get=lambda tori: _end(tori.stopped), record=True),
            Column("stopped.kind", TEXT, "why they end there, in one word",
                   name="torus_stopped_kind"),
            Column("stopped.reason", TEXT, "why they end there", name="torus_stopped_reason"),
            Column("stopped.value", REAL, f"{vary} where they end", unit,
                   name="torus_stopped_value"),
        ),
        "torus_",
    )  # fmt: skip


def _points(model: Model, vary: str) -> Table:
    """Return the table of the tori on a branch."""
    parameter = model.parameter(vary)
    return Table(
        ("torus_point",),
        (
            Column("parameter", REAL, meaning_of(parameter), parameter.unit, label=True,
                   head=vary),
            Column("rotation", REAL, "turns of the circle over the period", ""),
            Column("frequency", REAL, "modulation frequency", "Hz", derived=True,
                   head="modulation"),
            *(() if model.forced else (Column("durations", REAL, LASTING, "s", head=None),)),
            Column("circles", REAL, "states at phase zero at equal angles of the circle", None,
                   ("angle", "state"), head=None),
            Column("stable", TRUTH, "whether the torus attracts for certain", derived=True,
                   head=None),
            Column("growth", REAL, "largest exponent across the torus over the period", "",
                   head="growth across"),
            Column("growth_error", REAL, "estimated error of torus_growth", "",
                   head="error of growth"),
            Column("truncation", REAL, "how far circles fail to be invariant, in scaled states",
                   ""),
            Column("omitted", WHOLE, "circles left out after it, which fail to be invariant", "",
                   head=None),
            Column("extrema.minimum", REAL, "minimum over the whole torus", None, ("output",),
                   name="torus_minimum", head="min"),
            Column("extrema.maximum", REAL, "maximum over the whole torus", None, ("output",),
                   name="torus_maximum", head="max"),
        ),
        "torus_",
        OWNER,
        joined=True,
    )  # fmt: skip


def _turns(vary: str, unit: str) -> Table:
    """Where branches of tori turn round."""
    return Table(("fold",), (Column("value", REAL, f"{vary} where tori turn round", unit,
                                    get=lambda value: value),), "fold_", OWNER)  # fmt: skip


def _resonances(vary: str, unit: str) -> Table:
    """Resonances that tori pass."""
    return Table(
        ("resonance",),
        (
            Column("ratio", TEXT, "rotation number", get=lambda item: str(item.ratio)),
            Column("first", REAL, f"{vary} at the last torus before it", unit),
            Column("last", REAL, f"{vary} at the first torus after it", unit),
            Column("low", REAL, f"{vary} from which motion is locked", unit),
            Column("high", REAL, f"{vary} up to which motion is locked", unit),
        ),
        "resonance_",
        OWNER,
    )


@dataclass(frozen=True)
class Tori(Part):
    """Branches of tori as an attribute of a diagram."""

    doc = "Branches of quasi-periodic tori from Neimark-Sacker points, if they were requested."

    def variables(self, result: Any, key: str) -> dict[str, Variable]:
        """Return the arrays of tori; none if there are no tori."""
        tori: Sequence[TorusBranch] = getattr(result, key)
        if not tori:
            return {}
        model, vary = result.model, result.vary
        unit, ids = model.parameter(vary).unit, [each.id for each in tori]
        axes = {**axes_of(model), "angle": [""] * max(each.circles.shape[1] for each in tori)}
        folds = [value for each in tori for value in each.folds]
        locked = [item for each in tori for item in each.locked]
        return {
            **_tori(vary, unit, forced=model.forced).variables(tori, axes),
            **_points(model, vary).variables(tori, axes, ids),
            **_turns(vary, unit).variables(
                folds, axes, [each.id for each in tori for _ in each.folds]
            ),
            **_resonances(vary, unit).variables(
                locked, axes, [each.id for each in tori for _ in each.locked]
            ),
        }

    def read(self, saved: SavedTable, result: Any, key: str) -> tuple[TorusBranch, ...]:
        """Return the tori; none if there are none."""
        if not {"torus", "torus_period"} & set(saved.columns):
            return ()
        model, vary, axes = saved.model, result.vary, axes_of(saved.model)
        unit, outputs = model.parameter(vary).unit, tuple(saved.columns["output"].tolist())
        tori = _tori(vary, unit, forced=model.forced)
        points, turns, resonances = (
            _points(model, vary),
            _turns(vary, unit),
            _resonances(vary, unit),
        )
        found = []
        for row, number in enumerate(saved.columns["torus"].tolist()):
            fields = tori.read(saved, axes, row)
            fields |= points.read(saved, axes, points.rows(saved)[number])
            fields["extrema"] = Extrema(outputs, **fields["extrema"])
            fields["stopped"] = End(*fields["stopped"].values())
            most = int(np.isfinite(fields["circles"][:, :, 0]).sum(axis=1).max())
            fields["circles"] = fields["circles"][:, :most]
            folds = [turns.read(saved, axes, at)["value"] for at in turns.rows(saved)[number]]
            locked = [resonances.read(saved, axes, at) for at in resonances.rows(saved)[number]]
            ratios = [item | {"ratio": Fraction(item["ratio"])} for item in locked]
            fields |= {"folds": tuple(folds), "locked": tuple(Locked(**each) for each in ratios)}
            found.append(TorusBranch(model=model, vary=vary, **fields))
        return tuple(found)

    def record(self, result: Any, key: str) -> list[dict[str, Any]]:
        """Return a record of each branch of tori."""
        table = _tori(result.vary, "", forced=result.model.forced)
        return [table.record(each) for each in getattr(result, key)]


def torus_sentence(tori: TorusBranch) -> str:
    """Describe tori: their origin, stability and modulation, and why they end."""
    unit, vary = tori.model.parameter(tori.vary).unit, tori.vary

    def at(value: float) -> str:
        return with_unit(f"{vary} = {value:.8g}", unit)

    head = f"Tori {tori.id} (period {tori.period}, {len(tori)} points)"
    origin = f"are born on branch {tori.parent}" if tori.parent else "begin where a motion settles"
    parts = [f"{head} {origin}, at {at(tori.parameter[0])}"]
    if len(tori) > 1:
        hertz = np.abs(tori.frequency)
        low, high = hertz.min(), hertz.max()
        attracting = int(tori.stable[1:].sum())
        count = len(tori) - 1
        words = {0: "none of them attracts", count: "all attract"}
        parts.append(words.get(attracting, f"{attracting} of {count} attract"))
        parts.append(f"they are modulated at {low:.4g} to {high:.4g} Hz")
    parts += [f"they turn round at {at(value)}" for value in tori.folds]
    if tori.locked:
        parts.append(f"they pass the resonances {', '.join(map(_resonance, tori.locked))}")
    if tori.omitted.any():
        left = tori.omitted.sum()
        parts.append(f"circles left out, which fail to be invariant by more than 1e-8: {left}")
    return f"{'; '.join(parts)}; they stop at {at(tori.stopped.value)}: {tori.stopped.reason}"


def _resonance(item: Locked) -> str:
    """Say where motion is locked."""
    if not item.low < item.high:
        return str(item.ratio)
    return f"{item.ratio} (locked from {item.low:.10g} to {item.high:.10g})"


def _by_name(extrema: Extrema, side: int) -> dict[str, Any]:
    return {name: extrema.of(name)[side] for name in extrema.names}


def _folds(tori: TorusBranch) -> list[dict[str, Any]]:
    return [{"type": "LP", "value": value} for value in tori.folds]


def _locked(tori: TorusBranch) -> list[dict[str, Any]]:
    return [
        {
            "ratio": str(item.ratio),
            "first": item.first,
            "last": item.last,
            "low": item.low,
            "high": item.high,
        }
        for item in tori.locked
    ]


def _end(end: End) -> dict[str, Any]:
    return {"kind": end.kind, "reason": end.reason, "value": end.value}
