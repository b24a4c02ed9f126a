"""What a study found of every case, as plain data."""

from __future__ import annotations

from typing import Any

import numpy as np

from slipfold.errors import InputError
from slipfold.explorer.views.labels import axis_of
from slipfold.explorer.views.numbers import number
from slipfold.results.study import StudyResult
from slipfold.studies.plan import Grid

MOST = 20_000
"""Cases that a browser draws and searches without delay."""


def study_view(found: StudyResult, name: str) -> dict[str, Any]:
    """Return a study of the model that the page knows by a name; None where nothing was found.

    Raises `InputError` if it is too large to be shown.
    """
    if len(found) > MOST:
        raise InputError(
            f"the study has {len(found)} cases and the page shows {MOST} at most; open a smaller "
            "one, or draw it with slipfold plot"
        )
    model, cases = found.model, found.cases
    columns = cases.values(np.arange(len(found))).T
    varied = found.work.record()
    return {
        "model": name,
        "title": repr(found)[1:-1],
        "isGrid": isinstance(cases, Grid),
        "parameters": [
            {**axis_of(model, parameter), "values": column.tolist()}
            for parameter, column in zip(cases.names, columns, strict=True)
        ],
        "quantities": [_quantity(found, item.name) for item in found.quantities],
        "reasons": found.reasons.tolist(),
        "vary": varied.get("vary") if isinstance(varied.get("vary"), str) else None,
        "span": varied.get("span"),
    }


def _quantity(found: StudyResult, name: str) -> dict[str, Any]:
    (item,) = (each for each in found.quantities if each.name == name)
    values = found.values[name]
    known: list[str | float | None]
    if item.kind == "text":
        known = [str(value) or None for value in values]
    else:
        known = [number(value) for value in values]
    return {
        "name": name,
        "label": name,
        "unit": item.unit,
        "doc": item.meaning,
        "isText": item.kind == "text",
        "values": [
            None if reason else value for value, reason in zip(known, found.reasons, strict=True)
        ],
    }
