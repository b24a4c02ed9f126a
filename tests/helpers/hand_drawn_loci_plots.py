"""Loci and regions that are made up, for figures and texts: nothing is integrated."""

from types import SimpleNamespace

import numpy as np

from slipfold import End, Locus, LocusPoint, Region, RegionCheck, RegionMap, SlidingOscillator
from slipfold.orbits.bifurcation_types import CODIMENSION_TWO

WINDOW = ((12.0, 13.0), (0.0, 0.4))


def drawn_locus_point(kind, values, arclength, *, name=None, vary=("f", "Nd"), coefficients=None):
    return LocusPoint(
        type=kind,
        name=name or (CODIMENSION_TWO[kind].title if kind in CODIMENSION_TWO else kind),
        model=SlidingOscillator(**dict(zip(vary, values, strict=True))),
        vary=vary,
        values=values,
        uncertainty=(1e-12, 2e-13),
        period=1,
        nodes=np.zeros((1, 4)),
        multipliers=np.array([-1, 0.5, 0.3, 0.2], dtype=complex),
        residual=0.0,
        arclength=arclength,
        coefficients=coefficients or {},
    )


def drawn_locus(
    kind,
    values,
    special=(),
    *,
    coefficient=None,
    arclength=None,
    period=1,
    number=1,
    started="window",
    stopped="window",
    reason="left the window",
    vary=("f", "Nd"),
):
    values = np.array(values, dtype=float).reshape(-1, 2)
    count = len(values)
    if coefficient is None:
        coefficient = np.full(count, np.nan if kind == "LP" else 1.0)
    if arclength is None:
        arclength = np.linspace(0.0, 1.0, count)
    place = tuple(values[-1]) if count else (np.nan, np.nan)
    return Locus(
        id=number,
        type=kind,
        period=period,
        parent=None,
        model=SlidingOscillator(),
        vary=vary,
        values=values,
        nodes=np.zeros((count, 1, 4)),
        multipliers=np.zeros((count, 4), dtype=complex),
        coefficient=np.array(coefficient, dtype=float),
        residual=np.zeros(count),
        arclength=np.array(arclength, dtype=float),
        special=tuple(special),
        started=End(started, "left the window", tuple(values[0]) if count else place),
        stopped=End(stopped, reason, place),
    )


def valley(*, number=1):
    """A PD of period 1, lowest at 12.5 Hz; subcritical below 12.4 Hz, supercritical above."""
    f = np.array([12.0, 12.2, 12.35, 12.45, 12.6, 12.8, 13.0])
    special = [
        drawn_locus_point("GPD", (12.4, 0.06), 0.4),
        drawn_locus_point("MIN", (12.5, 0.05), 0.5, name="smallest Nd", coefficients={"b": 2.0}),
    ]
    coefficient = np.where(f < 12.4, -1.0, 1.0)
    values = np.column_stack([f, 0.05 + (f - 12.5) ** 2])
    return drawn_locus(
        "PD", values, special, coefficient=coefficient, arclength=f - 12, number=number
    )


def drawn_fold(*, number=2):
    """An LP of period 2 from the GPD of `valley` to the left."""
    values = np.column_stack([np.linspace(12.4, 12.0, 5), np.linspace(0.06, 0.1, 5)])
    return drawn_locus("LP", values, period=2, started="codimension-2", number=number)


def drawn_torus(*, number=3, special=()):
    """An NS of period 2 above the valley, which ends at a limit of the model."""
    values = np.column_stack([np.linspace(12.6, 12.7, 5), np.linspace(0.4, 0.2, 5)])
    reason = "spring collapsed: l/L fell to 0.0001"
    return drawn_locus(
        "NS",
        values,
        special,
        coefficient=-np.ones(5),
        period=2,
        number=number,
        stopped="limit",
        reason=reason,
    )


def drawn_regions(*, cells=60, agrees=True):
    """Period 1 below the valley, period 2 above it, on a coarse raster."""
    first, second = (np.linspace(low, high, 2 * cells + 1)[1::2] for low, high in WINDOW)
    above = second[:, None] > 0.05 + (first - 12.5) ** 2
    checks = [
        RegionCheck((12.5, 0.02), "rest", 1, True, "settled on 1"),
        RegionCheck((12.5, 0.02), "period 1", 1, True, "settled on 1"),
    ]
    beyond = (RegionCheck((12.5, 0.3), "rest", 0, agrees, "not settled"),)
    regions = (
        Region(1, (2,), float(above.mean()), (12.5, 0.3), True, beyond),
        Region(2, (1,), float(1 - above.mean()), (12.5, 0.02), True, tuple(checks)),
    )
    return RegionMap(first, second, np.where(above, 1, 2).astype(np.int64), regions)


def locus_diagram(*loci, regions=None, vary=("f", "Nd"), window=WINDOW):
    return SimpleNamespace(
        model=SlidingOscillator(), vary=vary, window=window, loci=loci, regions=regions
    )
