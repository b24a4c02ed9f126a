"""Regions of a plane: to arrays and back, and to records."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from slipfold.loci.region_map import Region, RegionCheck, RegionMap, RegionMotion
from slipfold.models.model import Model
from slipfold.results.fields import (
    TEXT,
    TRUTH,
    WHOLE,
    Column,
    Owners,
    Part,
    Table,
    axes_of,
    meaning_of,
)
from slipfold.results.records import SavedTable
from slipfold.results.tables import Variable

CHECKS = Table(
    ("check",),
    (
        Column("values", meaning="values of the parameters", dimensions=("parameter",),
               name="check_value", record=True),
        Column("start", TEXT, "rest, or period of the orbit near which it started", record=True),
        Column("settled", WHOLE, "period it settled to, in forcing periods, 0: none", "",
               record=True),
        Column("agrees", TRUTH, "whether that fits the label of the region", record=True),
        Column("note", TEXT, "what happened", record=True),
    ),
    "check_",
    ("region", "region it lies in"),
)  # fmt: skip

MOTIONS = Table(
    ("motion",),
    (
        Column("values", meaning="values of the parameters", dimensions=("parameter",),
               name="motion_value", record=True),
        Column("kind", TEXT, "what the trajectory does", record=True),
        Column("period", WHOLE, "period in forcing periods, 0 for none", "", record=True),
        Column("exponent", meaning="largest Lyapunov exponent, where it was needed",
               unit="1/forcing period", optional=True, record=True),
    ),
    "motion_",
    ("region", "region it lies in"),
)  # fmt: skip

REGIONS = Table(
    ("region",),
    (
        Column("id", WHOLE, "number of the region", name="region", label=True, record=True),
        Column("stable", WHOLE, "periods of the stable responses, 0: no more", "", ("stable",),
               record=True),
        Column("sticking", WHOLE, "periods of those that stick, 0: no more", "", ("sticking",),
               record=True),
        Column("stuck", meaning="smallest and largest fraction of the time in which those stick",
               unit="", dimensions=("bound",), record=True),
        Column("name", TEXT, record=True),
        Column("known", TRUTH, record=True),
        Column("share", meaning="fraction of the area of the window", unit="", record=True),
        Column("place", meaning="values of the parameters well inside", dimensions=("parameter",),
               record=True),
        Column("consistent", TRUTH, "whether all responses across it agree on its label",
               record=True),
        Column("checks", get=lambda region: [CHECKS.record(check) for check in region.checks],
               record=True),
        Column("regimes", record=True),
        Column("motions", get=lambda region: [MOTIONS.record(motion) for motion in region.motions],
               record=True),
    ),
    "region_",
)  # fmt: skip


OWNERS = Owners(REGIONS, owned={"checks": CHECKS, "motions": MOTIONS})


def _cells(model: Model, vary: tuple[str, str]) -> tuple[Table, ...]:
    """The axes of the plane, and which region a cell belongs to."""
    axes = []
    for axis, name in zip(("first", "second"), vary, strict=True):
        parameter = model.parameter(name)
        values = Column(axis, meaning=meaning_of(parameter), unit=parameter.unit, label=True)
        axes.append(Table((axis,), (values,), joined=True))
    about = "region that the cell belongs to, 0: not known"
    labels = Column("labels", WHOLE, about, name="region_of_cell")
    return *axes, Table(("second", "first"), (labels,), joined=True)


@dataclass(frozen=True)
class Regions(Part):
    """The regions of a plane as an attribute, which may be None."""

    doc = "Which stable responses exist where; None if that was not requested."

    def variables(self, result: Any, key: str) -> dict[str, Variable]:
        """Return the regions with their names, units and meanings."""
        regions: RegionMap | None = getattr(result, key)
        if regions is None:
            return {}
        axes, variables = axes_of(result.model, result.vary), dict[str, Variable]()
        for table in _cells(result.model, result.vary):
            variables |= table.variables([regions], axes)
        variables |= OWNERS.variables(regions.regions, axes)
        return variables

    def record(self, result: Any, key: str) -> list[dict[str, Any]] | None:
        """Return a record of each region; None if they were not requested."""
        regions: RegionMap | None = getattr(result, key)
        return None if regions is None else [REGIONS.record(item) for item in regions.regions]

    def read(self, saved: SavedTable, result: Any, key: str) -> RegionMap | None:
        """Return the regions."""
        if not {"region", "region_of_cell"} & set(saved.columns):
            return None
        axes = axes_of(saved.model, result.vary)
        first, second, cells = _cells(saved.model, result.vary)
        fields = first.read(saved, axes, ...) | second.read(saved, axes, ...)
        fields |= cells.read(saved, {**axes, **fields}, ...)
        labels, count = fields["labels"], REGIONS.count(saved)
        if labels.size and not 0 <= labels.min() <= labels.max() <= count:
            raise ValueError("region_of_cell names a region that there is not")
        regions = []
        for told in OWNERS.read(saved, axes):
            told["checks"] = tuple(RegionCheck(**each) for each in told["checks"])
            told["motions"] = tuple(RegionMotion(**each) for each in told["motions"])
            regions.append(Region(**told))
        return RegionMap(**fields, regions=tuple(regions))
