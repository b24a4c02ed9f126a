"""Tori as arrays, in records and in words."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from slipfold.bifurcations.tori.torus_branch import Locked, TorusBranch
from slipfold.continuation.end import End
from slipfold.orbits.extrema import Extrema
from slipfold.results.fields import REAL, TEXT, TRUTH, WHOLE, Column, Items, ResultPart, axes_of
from slipfold.results.records import SavedTable
from slipfold.results.tables import Variable
from slipfold.text import kind_text, with_unit

LASTING = "duration of a round, after which the circle lies on itself"

RESONANCE_ENDS = {
    "first": "at the last torus before it",
    "last": "at the first torus after it",
    "low": "from which trajectories are locked",
    "high": "up to which trajectories are locked",
}

OWNER = ("torus", "branch of tori it lies on")


def _by_name(extrema: Extrema, side: int) -> dict[str, Any]:
    return {name: extrema.of(name)[side] for name in extrema.names}


RESONANCES = Items("resonance", (
    Column("ratio", TEXT, "rotation number", get=lambda item: str(item.ratio), record=True),
    *(
        Column(name, REAL, f"{{vary.name}} {where}", "{vary}", record=True)
        for name, where in RESONANCE_ENDS.items()
    ),
), "resonance_", owner=OWNER)  # fmt: skip
"""Resonances that tori pass."""

FOLDS = Items("fold", (
    Column("value", REAL, "{vary.name} where tori have a fold", "{vary}", get=float),
), "fold_", owner=OWNER)  # fmt: skip

TORI = (
    Column("id", WHOLE, "number of the branch of tori", name="torus", label=True, record=True),
    Column("kind", get=lambda tori: "torus", record=True),
    Column("period", WHOLE, "in forcing periods", "", record=True),
    Column("parent", WHOLE, "branch that they emanate from", record=True),
    Column("points", get=len, record=True),
    Column("values", get=lambda tori: tori.parameter, record=True),
    *(
        Column(name, record=True)
        for name in ("rotation", "frequency", "stable", "growth", "growth_error")
    ),
    Column("durations", record=True, when="cycle"),
    Column("truncation", record=True),
    Column("omitted", record=True),
    Column("minimum", get=lambda tori: _by_name(tori.extrema, 0), record=True),
    Column("maximum", get=lambda tori: _by_name(tori.extrema, 1), record=True),
    Column("special", get=lambda tori: [{"type": "LP", "value": value} for value in tori.folds],
           record=True),
    Column("locked", record=True,
           get=lambda tori: [RESONANCES.record_of(item) for item in tori.locked]),
    *(Column(f"started.{part}", record=True) for part in ("kind", "reason", "value")),
    Column("stopped.kind", TEXT, "why they end there, in one word", record=True,
           name="torus_stopped_kind"),
    Column("stopped.reason", TEXT, "why they end there", record=True, name="torus_stopped_reason"),
    Column("stopped.value", REAL, "{vary.name} where they end", "{vary}", record=True,
           name="torus_stopped_value"),
)  # fmt: skip
"""What is said of a branch of tori."""

POINT = (
    Column("parameter", REAL, "{vary}", "{vary}", label=True, head="{vary}"),
    Column("rotation", REAL, "revolutions of the circle over the period", ""),
    Column("frequency", REAL, "modulation frequency", "Hz", derived=True, head="modulation"),
    Column("durations", REAL, LASTING, "s", head=None, when="cycle"),
    Column("circles", REAL, "states at phase zero at equal angles of the circle", None,
           ("angle", "state"), head=None),
    Column("stable", TRUTH, "whether the torus attracts for certain", derived=True, head=None),
    Column("growth", REAL, "largest exponent across the torus over the period", "",
           head="growth across"),
    Column("growth_error", REAL, "estimated error of torus_growth", "", head="error of growth"),
    Column("truncation", REAL, "how far circles fail to be invariant, in scaled states", ""),
    Column("omitted", WHOLE, "circles left out after it, which fail to be invariant", "",
           head=None),
    Column("extrema.minimum", REAL, "minimum over the whole torus", None, ("output",),
           name="torus_minimum", head="min"),
    Column("extrema.maximum", REAL, "maximum over the whole torus", None, ("output",),
           name="torus_maximum", head="max"),
)  # fmt: skip
"""What is said of a torus."""


def _table(result: Any) -> Items:
    """Return the table of tori, with their points, folds and resonances."""
    columns, points = (
        [item for item in part if not (item.when and result.model.forced)] for part in (TORI, POINT)
    )
    rows = Items("torus_point", points, "torus_", owner=OWNER, joined=True)
    owned = {"folds": FOLDS, "locked": RESONANCES}
    return Items("torus", columns, "torus_", rows=rows, owned=owned).bound(result)


@dataclass(frozen=True)
class ToriList(ResultPart):
    """Branches of tori as an attribute of a diagram."""

    doc = "Branches of quasi-periodic tori from Neimark-Sacker points, if they were requested."

    def variables(self, result: Any, key: str) -> dict[str, Variable]:
        """Return the arrays of tori; none if there are no tori."""
        tori: Sequence[TorusBranch] = getattr(result, key)
        if not tori:
            return {}
        longest = max(each.circles.shape[1] for each in tori)
        return _table(result).arrays(tori, {**axes_of(result), "angle": [""] * longest})

    def read(self, saved: SavedTable, result: Any, key: str) -> tuple[TorusBranch, ...]:
        """Return the tori; none if there are none."""
        if not {"torus", "torus_period"} & set(saved.columns):
            return ()
        model, vary = saved.model, result.vary
        outputs, found = tuple(saved.columns["output"].tolist()), []
        for fields in _table(result).all_fields(saved, axes_of(result)):
            fields["extrema"] = Extrema(outputs, **fields["extrema"])
            fields["stopped"] = End(*fields["stopped"].values())
            angles = np.isfinite(fields["circles"][:, :, 0]).sum(axis=1)
            fields["circles"] = fields["circles"][:, : int(angles.max())]
            fields["folds"] = tuple(each["value"] for each in fields["folds"])
            fields["locked"] = tuple(
                Locked(**each | {"ratio": Fraction(each["ratio"])}) for each in fields["locked"]
            )
            found.append(TorusBranch(model=model, vary=vary, **fields))
        return tuple(found)

    def record(self, result: Any, key: str) -> list[dict[str, Any]]:
        """Return a record of each branch of tori."""
        table = _table(result)
        return [table.record_of(each) for each in getattr(result, key)]


def torus_sentence(tori: TorusBranch) -> str:
    """Describe tori: their origin, stability and modulation, and why they end."""
    unit, vary = tori.model.parameter(tori.vary).unit, tori.vary

    def at(value: float) -> str:
        return with_unit(f"{vary} = {value:.8g}", unit)

    of = kind_text("periodic", tori.period, tori.model.forced)
    head = f"Tori {tori.id} of {of} ({len(tori)} points)"
    origin = f"emanate from branch {tori.parent}" if tori.parent else "begin on an attractor"
    parts = [f"{head} {origin}, at {at(tori.parameter[0])}"]
    if len(tori) > 1:
        hertz = np.abs(tori.frequency)
        low, high = hertz.min(), hertz.max()
        attracting = int(tori.stable[1:].sum())
        count = len(tori) - 1
        words = {0: "none of them attracts", count: "all attract"}
        parts.append(words.get(attracting, f"{attracting} of {count} attract"))
        parts.append(f"they are modulated at {low:.4g} to {high:.4g} Hz")
    parts += [f"they have a fold at {at(value)}" for value in tori.folds]
    if tori.locked:
        parts.append(f"they pass the resonances {', '.join(map(_resonance, tori.locked))}")
    if tori.omitted.any():
        left = tori.omitted.sum()
        parts.append(f"circles left out, which fail to be invariant by more than 1e-8: {left}")
    return f"{'; '.join(parts)}; they stop at {at(tori.stopped.value)}: {tori.stopped.reason}"


def _resonance(item: Locked) -> str:
    """Say where trajectories are locked to an orbit."""
    if not item.low < item.high:
        return str(item.ratio)
    return f"{item.ratio} (locked from {item.low:.10g} to {item.high:.10g})"
