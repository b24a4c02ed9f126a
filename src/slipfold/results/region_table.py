"""Regions of a plane to labelled arrays and back."""

from __future__ import annotations

import numpy as np

from slipfold.loci.region_map import Region, RegionCheck, RegionMap
from slipfold.models.model import Model
from slipfold.results.columns import (
    Columns,
    integers,
    named_parameter,
    padded_integers,
    reals,
    stacked,
    texts,
)
from slipfold.results.labelled_table import Variable
from slipfold.results.saved_table import SavedTable

__all__ = ["REGION_LABELS", "read_regions", "region_variables"]

REGION_LABELS = ("first", "second", "region", "region_of_check")
"""Variables that label cells, regions and checks rather than hold results."""


def region_variables(
    regions: RegionMap, model: Model, vary: tuple[str, str]
) -> dict[str, Variable]:
    """Return the regions with their names, units and meanings."""
    return _cells(regions, model, vary) | _regions(regions) | _checks(regions)


def _cells(regions: RegionMap, model: Model, vary: tuple[str, str]) -> dict[str, Variable]:
    variables: dict[str, Variable] = {}
    axes = zip(("first", "second"), vary, (regions.first, regions.second), strict=True)
    for axis, name, values in axes:
        parameter = model.parameter(name)
        columns = Columns(axis)
        columns.add(axis, values, named_parameter(parameter), parameter.unit)
        variables |= columns.variables
    columns = Columns("second")
    about = "region that the cell belongs to, 0: not known"
    columns.add("region_of_cell", regions.labels, about, None, "first")
    return variables | columns.variables


def _regions(regions: RegionMap) -> dict[str, Variable]:
    items = regions.regions
    columns = Columns("region")
    add = columns.add
    add("region", integers(item.id for item in items), "number of the region")
    stable = padded_integers(item.stable for item in items)
    add("region_stable", stable, "periods of the stable responses, 0: no more", "", "stable")
    add("region_share", reals(item.share for item in items), "share of the area of the window", "")
    places = stacked((np.array(item.place) for item in items), (2,))
    add("region_place", places, "values of the parameters well inside", None, "parameter")
    agree = np.array([item.consistent for item in items], dtype=bool)
    add("region_consistent", agree, "whether all responses across it agree on its label")
    return columns.variables


def _checks(regions: RegionMap) -> dict[str, Variable]:
    rows = [(item.id, check) for item in regions.regions for check in item.checks]
    checks = [check for _, check in rows]
    columns = Columns("check")
    add = columns.add
    add("region_of_check", integers(number for number, _ in rows), "region it lies in")
    values = stacked((np.array(check.values) for check in checks), (2,))
    add("check_value", values, "values of the parameters", None, "parameter")
    starts = texts(check.start for check in checks)
    add("check_start", starts, "rest, or period of the orbit near which it started")
    settled = integers(check.settled for check in checks)
    add("check_settled", settled, "period it settled to, in forcing periods, 0: none", "")
    agree = np.array([check.agrees for check in checks], dtype=bool)
    add("check_agrees", agree, "whether that fits the label of the region")
    add("check_note", texts(check.note for check in checks), "what happened")
    return columns.variables


def read_regions(saved: SavedTable) -> RegionMap:
    """Make the regions again from their arrays."""
    columns = saved.columns
    first, second, labels = (columns[name] for name in ("first", "second", "region_of_cell"))
    if labels.shape != (len(second), len(first)):
        raise ValueError(f"region_of_cell has the shape {labels.shape}")
    checks = saved.rows("check", "region_of_check")
    numbers = columns["region"].tolist()
    if labels.size and not 0 <= labels.min() <= labels.max() <= len(numbers):
        raise ValueError("region_of_cell names a region that there is not")
    regions = tuple(
        _region(saved, row, tuple(_check(saved, int(each)) for each in checks[number]))
        for row, number in enumerate(numbers)
    )
    return RegionMap(first, second, labels, regions)


def _region(saved: SavedTable, row: int, checks: tuple[RegionCheck, ...]) -> Region:
    columns = saved.columns
    return Region(
        id=int(columns["region"][row]),
        stable=saved.integers("region_stable", row),
        share=float(columns["region_share"][row]),
        place=saved.pair("region_place", row),
        consistent=bool(columns["region_consistent"][row]),
        checks=checks,
    )


def _check(saved: SavedTable, row: int) -> RegionCheck:
    columns = saved.columns
    return RegionCheck(
        values=saved.pair("check_value", row),
        start=str(columns["check_start"][row]),
        settled=int(columns["check_settled"][row]),
        agrees=bool(columns["check_agrees"][row]),
        note=str(columns["check_note"][row]),
    )
