"""Criticality along a locus in words."""

from __future__ import annotations

import numpy as np

from slipfold.loci.locus import CODIMENSION_TWO, COEFFICIENT, Locus, LocusPoint
from slipfold.normal_forms.normal_form import criticality_of


def criticalities(locus: Locus) -> list[str | None]:
    """Return whether the bifurcation is super- or subcritical at each point of a locus."""
    return [_in_words(locus, float(value)) for value in locus.coefficient]


def point_criticality(locus: Locus, point: LocusPoint) -> str | None:
    """Return whether the bifurcation is super- or subcritical at an extremum of a locus."""
    name = COEFFICIENT.get(locus.type, "")
    if point.type in CODIMENSION_TWO or name not in point.coefficients:
        return None
    return _in_words(locus, point.coefficients[name])


def _in_words(locus: Locus, coefficient: float) -> str | None:
    """Judge a coefficient beside the others, whatever the units of the states."""
    size = float(np.nan_to_num(np.abs(locus.coefficient)).max(initial=0.0))
    return criticality_of(locus.type, coefficient / (size or 1.0))
