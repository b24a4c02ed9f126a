"""Criticality along a locus in words."""

from __future__ import annotations

from slipfold.branches.normal_form import criticality_of
from slipfold.loci.locus import CODIMENSION_TWO, COEFFICIENT, Locus, LocusPoint

__all__ = ["criticalities", "point_criticality"]


def criticalities(locus: Locus) -> list[str | None]:
    """Return whether the bifurcation is super- or subcritical at each point of a locus.

    Parameters
    ----------
    locus
        The locus.

    Returns
    -------
    list of str or None
        ``"supercritical"``, ``"subcritical"``, or None where that has no meaning or is not known:
        folds, and points where the normal form degenerates.
    """
    return [criticality_of(locus.type, float(value)) for value in locus.coefficient]


def point_criticality(locus: Locus, point: LocusPoint) -> str | None:
    """Return whether the bifurcation is super- or subcritical at an extremum of a locus.

    Parameters
    ----------
    locus
        The locus.
    point
        A special point of it. At points of codimension two the word has no meaning.
    """
    name = COEFFICIENT.get(locus.type, "")
    if point.type in CODIMENSION_TWO or name not in point.coefficients:
        return None
    return criticality_of(locus.type, point.coefficients[name])
