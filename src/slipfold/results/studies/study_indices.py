"""What accounts for the variance of what a study found, where its cases were drawn for that."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from slipfold.design_space.sobol_indices import SALTELLI, SobolIndices, indices_of
from slipfold.errors import InputError
from slipfold.studies.cases import Cases, Rows
from slipfold.studies.work.work import Quantity
from slipfold.text.printed_table import PrintedTable

__all__ = ["are_told", "index_lines", "index_records", "indices_in"]

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
    known = {item.name: item.kind for item in found.quantities}
    name = quantity if isinstance(quantity, str) else "the quantity"
    if isinstance(quantity, str) and known.get(quantity, "text") == "text":
        numbers = ", ".join(name for name, kind in known.items() if kind != "text")
        raise InputError(f"the study has no number {quantity!r}; it has {numbers}")
    given = found.values[quantity] if isinstance(quantity, str) else quantity
    values = np.where(found.reasons == "", np.asarray(given, dtype=float), np.nan)
    lost = np.flatnonzero(~np.isfinite(values))
    if len(lost):
        why = str(found.reasons[lost[0]] or found.values.get("reason", {lost[0]: ""})[lost[0]])
        raise InputError(
            f"indices are shares of a variance, and {name} is missing in {len(lost)} of "
            f"{len(values)} cases{'; first: ' if why else ''}{why}"
        )
    if not np.ptp(values) > CONSTANT * np.abs(values).max():
        raise InputError(f"{name} is the same in all cases, so nothing accounts for its variance")
    assert isinstance(found.cases, Rows)
    return indices_of(values, found.cases.names, int((found.cases.drawn or {})["seed"]))


def index_records(found: Found) -> dict[str, Any]:
    """Return the indices of all numbers that differ from case to case, as plain data."""
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
    known, missing = {}, dict[str, None]()
    if are_told(found):
        for item in found.quantities:
            if item.kind != "real" or not np.isfinite(found.values[item.name]).any():
                continue
            try:
                known[item.name] = indices_in(found, item.name)
            except InputError as error:
                if "the same in all cases" not in str(error):
                    missing[f"no indices of {item.name}: {error}"] = None
    return known, [*missing]
