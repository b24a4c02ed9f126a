"""Loci as plain data for JSON: the schema slipfold.locus/1 of the command line."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from slipfold.loci.locus import Locus, LocusEnd, LocusPoint, hopf_duration
from slipfold.loci.region_map import Region
from slipfold.results.checked_parts import checked_record
from slipfold.results.criticality import criticalities
from slipfold.results.locus_table import SCHEMA
from slipfold.results.record import number, numbers, pairs, record_head

if TYPE_CHECKING:
    from slipfold.results.locus_diagram import LocusDiagram

__all__ = ["locus_record"]


def locus_record(diagram: LocusDiagram) -> dict[str, Any]:
    """Return loci, special points and regions."""
    regions = diagram.regions
    return {
        **record_head(SCHEMA, diagram.model),
        "plane": list(diagram.vary),
        "window": [numbers(span) for span in diagram.window],
        "interrupted": diagram.interrupted,
        "loci": [_locus_record(locus) for locus in diagram.loci],
        "regions": None if regions is None else [_region_record(each) for each in regions.regions],
        **checked_record(diagram.checked),
    }


def _locus_record(locus: Locus) -> dict[str, Any]:
    return {
        "id": locus.id,
        "type": locus.type,
        "kind": locus.kind,
        "period": locus.period,
        "parent": locus.parent,
        "points": len(locus),
        "values": [numbers(pair) for pair in locus.values],
        "criticality": None if locus.type == "LP" else criticalities(locus),
        "coefficient": numbers(locus.coefficient),
        "durations": None if locus.model.forced else _durations(locus),
        "eigenvalues": None
        if locus.eigenvalues is None
        else [pairs(values) for values in locus.eigenvalues],
        "special": [_point_record(point) for point in locus.special],
        "begun": _end_record(locus.begun),
        "stopped": _end_record(locus.stopped),
    }


def _durations(locus: Locus) -> list[float | None]:
    """Periods of the orbits in seconds; of Hopf points, those of the cycles born there."""
    if locus.durations is not None:
        return numbers(locus.period * locus.durations)
    values = () if locus.eigenvalues is None else locus.eigenvalues
    return [number(hopf_duration(each)) for each in values]


def _end_record(end: LocusEnd) -> dict[str, Any]:
    return {"kind": end.kind, "reason": end.reason, "values": numbers(end.values)}


def _point_record(point: LocusPoint) -> dict[str, Any]:
    coefficients = {name: number(value) for name, value in point.coefficients.items()}
    return {
        "type": point.type,
        "name": point.name,
        "values": numbers(point.values),
        "uncertainty": numbers(point.uncertainty),
        "state": numbers(point.state),
        "multipliers": pairs(point.multipliers),
        "eigenvalues": None if point.eigenvalues is None else pairs(point.eigenvalues),
        "duration": number(point.duration),
        "coefficients": coefficients,
        "coefficient": next(iter(coefficients.values()), None),
        "leads_to": list(point.leads_to),
    }


def _region_record(region: Region) -> dict[str, Any]:
    return {
        "id": region.id,
        "stable": list(region.stable),
        "name": region.name,
        "known": region.known,
        "share": number(region.share),
        "place": numbers(region.place),
        "consistent": region.consistent,
        "checks": [
            {
                "values": numbers(check.values),
                "start": check.start,
                "settled": check.settled,
                "agrees": check.agrees,
                "note": check.note,
            }
            for check in region.checks
        ],
    }
