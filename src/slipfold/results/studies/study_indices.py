"""What accounts for the variance of what a study found, where its cases were drawn for that."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from slipfold.arrays import Array
from slipfold.design_space.sobol_indices import SALTELLI, SobolIndices, indices_of
from slipfold.errors import InputError
from slipfold.studies.cases import Cases, Rows
from slipfold.studies.work.work import Quantity
from slipfold.text.printed_table import PrintedTable

SHARES = "indices are shares of a variance, and"

CONSTANT = 1e-12
"""Deviation over size of what is the same in all cases but for rounding."""


class Found(Protocol):
    """What a study found, as far as indices want to know."""

    @property
    def cases(self) -> Cases:
        """The cases."""

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """What was found of each."""

    @property
    def values(self) -> Mapping[str, NDArray[Any]]:
        """That by name, a value a case."""

    @property
    def reasons(self) -> NDArray[np.object_]:
        """Why cases failed; empty where they did not."""


def are_told(found: Found) -> bool:
    """Whether cases were drawn so that indices can be told of them."""
    cases = found.cases
    return isinstance(cases, Rows) and (cases.drawn or {}).get("sample") == SALTELLI


def indices_in(found: Found, quantity: str | ArrayLike) -> SobolIndices:
    """Return the indices of a quantity by name, or of a number for each case."""
    if not are_told(found):
        raise InputError(
            f'cases of this study were not drawn for indices; give cases with sample = "{SALTELLI}"'
        )
    if isinstance(quantity, str):
        name, values = quantity, _named(found, quantity)
    else:
        name, values = "the quantity", _given(found, quantity)
    lack = _lack(found, values)
    if lack:
        raise InputError(f"{SHARES} {name} is {lack}")
    if _is_constant(values):
        raise InputError(f"{name} is the same in all cases, so nothing accounts for its variance")
    return _told(found, values)


def _named(found: Found, name: str) -> Array:
    """Return a number that was found, NaN where there is none."""
    items = {item.name: item for item in found.quantities if item.kind != "text"}
    if name not in items:
        raise InputError(f"the study has no number {name!r}; it has {', '.join(items)}")
    values = np.asarray(found.values[name], dtype=float)
    lacking = (found.reasons != "") | (values == items[name].none)
    return np.where(lacking, np.nan, values)


def _given(found: Found, quantity: ArrayLike) -> Array:
    """Return numbers of one's own, NaN where there are none."""
    shape = found.reasons.shape
    try:
        values = np.asarray(quantity)
    except ValueError:  # rows of different lengths
        values = np.empty(0, object)
    if values.dtype.kind not in "biuf" or values.shape != shape:
        what = "words or the like" if values.dtype.kind not in "biuf" else f"shape {values.shape}"
        raise InputError(
            f"the quantity is an array of {what}; give a number for each of the {shape[0]} cases, "
            "or a name"
        )
    return np.where(found.reasons != "", np.nan, values.astype(float))


def _lack(found: Found, values: Array) -> str:
    """Say of how many cases numbers are missing, and why of the first; empty if of none."""
    lost = np.flatnonzero(~np.isfinite(values))
    if not len(lost):
        return ""
    why = str(found.reasons[lost[0]] or found.values.get("reason", {lost[0]: ""})[lost[0]])
    return f"missing in {len(lost)} of {len(values)} cases{'; first: ' if why else ''}{why}"


def _is_constant(values: Array) -> bool:
    return not np.ptp(values) > CONSTANT * np.abs(values).max()


def _told(found: Found, values: Array) -> SobolIndices:
    assert isinstance(found.cases, Rows)
    return indices_of(values, found.cases.names, int((found.cases.drawn or {})["seed"]))


def index_records(found: Found) -> dict[str, Any]:
    """Return the indices of all numbers that differ from case to case, counts aside."""
    return {
        name: {
            parameter: {
                key: float(getattr(item, key)[place])
                for key in ("first", "total", "first_error", "total_error")
            }
            for place, parameter in enumerate(item.names)
        }
        for name, item in _all(found)[0].items()
    }


def index_lines(found: Found) -> list[str]:
    """Return a table of the indices, and why some are not told."""
    known, missing = _all(found)
    if not known:
        return missing
    heads = ["index, first and total", *found.cases.names]
    rows = [[name, *_cells(item)] for name, item in known.items()]
    return ["", *PrintedTable(heads, rows, heads[:1]).text(), *missing]


def _cells(item: SobolIndices) -> Iterator[str]:
    for part in zip(item.first, item.first_error, item.total, item.total_error, strict=True):
        yield "{:.2f} +- {:.2f}, {:.2f} +- {:.2f}".format(*part)


def _all(found: Found) -> tuple[Mapping[str, SobolIndices], list[str]]:
    """Return the indices of all numbers but those that count, and why others have none."""
    known, missing = dict[str, SobolIndices](), dict[str, list[str]]()
    for item in found.quantities if are_told(found) else ():
        if item.kind != "real" or not np.isfinite(found.values[item.name]).any():
            continue
        values = _named(found, item.name)
        lack = _lack(found, values)
        if lack:
            missing.setdefault(f"{SHARES} numbers are {lack}", []).append(item.name)
        elif not _is_constant(values):
            try:
                known[item.name] = _told(found, values)
            except InputError as error:
                missing.setdefault(str(error), []).append(item.name)
    return known, [f"no indices of {', '.join(names)}: {why}" for why, names in missing.items()]
