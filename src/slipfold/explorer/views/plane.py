"""Bifurcations in two parameters as lines, and the regions between them as a raster."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from slipfold.explorer.views.checked import checked_view
from slipfold.explorer.views.labels import axis_of
from slipfold.explorer.views.numbers import number, short
from slipfold.lines import locus_stretches
from slipfold.loci.locus import Locus, LocusPoint, locus_title
from slipfold.loci.region_map import RegionMap
from slipfold.results.locus_diagram import LocusDiagram


def plane_view(found: LocusDiagram) -> dict[str, Any]:
    """Return a bifurcation set as plain data."""
    first, second = found.vary
    return {
        "x": {**axis_of(found.model, first), "span": list(found.window[0])},
        "y": {**axis_of(found.model, second), "span": list(found.window[1])},
        "loci": loci_view(found.loci),
        "checked": checked_view(found.checked),
        "regions": None if found.regions is None else _regions(found.regions),
    }


def loci_view(loci: Iterable[Locus]) -> list[dict[str, Any]]:
    """Return loci as plain data."""
    return [_locus(locus) for locus in loci]


def _locus(locus: Locus) -> dict[str, Any]:
    return {
        "id": locus.id,
        "type": locus.type,
        "period": locus.period,
        "name": locus_title(locus.type, locus.period, locus.kind),
        "stretches": [
            {
                "criticality": line.criticality,
                "x": short(line.points[:, 0]),
                "y": short(line.points[:, 1]),
            }
            for line in locus_stretches(locus)
        ],
        "special": [_special(locus, point) for point in locus.special],
        "begun": {"kind": locus.begun.kind, "reason": locus.begun.reason},
        "stopped": {"kind": locus.stopped.kind, "reason": locus.stopped.reason},
    }


def _special(locus: Locus, point: LocusPoint) -> dict[str, Any]:
    places = [
        f"{name} = {value:.6g} {point.model.parameter(name).unit}".rstrip()
        for name, value in zip(point.vary, point.certain_values, strict=True)
    ]
    name = point.name[0].upper() + point.name[1:]
    return {
        "type": point.type,
        "x": number(point.values[0]),
        "y": number(point.values[1]),
        "sentence": f"{name} on the {locus.type} of period {locus.period} at {', '.join(places)}",
    }


def _regions(regions: RegionMap) -> dict[str, Any]:
    return {
        "x": short(regions.first),
        "y": short(regions.second),
        "labels": np.asarray(regions.labels).tolist(),
        "names": {str(item.id): item.name for item in regions.regions},
        "stable": {str(item.id): list(item.stable) for item in regions.regions if item.known},
        "anchors": {str(item.id): list(item.place) for item in regions.regions},
        "known": {str(item.id): item.known for item in regions.regions},
        "consistent": {str(item.id): item.consistent for item in regions.regions},
    }
