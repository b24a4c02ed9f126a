"""What files hold of scattered parameters."""

from __future__ import annotations

from slipfold.results.column import REAL, TEXT, Column
from slipfold.results.table import Table

__all__ = ["ENDS", "INDICES", "parameter_table"]

INDICES = {
    "first": "share of the variance that the parameter accounts for by itself",
    "total": "share of the variance that the parameter takes part in",
    "first_error": "half the interval of 95 % confidence of the first index",
    "total_error": "half the interval of 95 % confidence of the total index",
}


ENDS = {"low": "least value of it, where it is cut off", "high": "largest value of it, likewise"}


def parameter_table(indexed: bool, cut: bool) -> Table:
    """What is said of each scattered parameter."""
    more = [Column(key, REAL, text) for key, text in ENDS.items()] if cut else []
    more += [Column(key, REAL, text, "") for key, text in INDICES.items()] if indexed else []
    columns = (
        Column("name", TEXT, "scattered parameter", name="scattered", label=True),
        Column("kind", TEXT, "normal, uniform or lognormal"),
        Column("mean", REAL, "value about which it scatters; the median if lognormal"),
        Column("size", REAL, "standard deviation if normal, half the width if uniform, deviation "
               "of the logarithm if lognormal"),
        Column("gradient", REAL, "derivative of the threshold by it"),
        *more,
    )  # fmt: skip
    return Table(("scattered",), columns, "scatter_")
