"""What stands behind the options of continuation."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from slipfold.cli.parsing import parse_number, parse_whole

if TYPE_CHECKING:
    from slipfold.branches.settings import Settings


def parse_settings(
    max_step: str | None = None,
    tolerance: str | None = None,
    max_points: str | None = None,
    largest_period: str | None = None,
    discretisation: str | None = None,
) -> Settings:
    """Read the options of continuation.

    >>> parse_settings(max_step="0.2").steps.largest
    0.2
    """
    from slipfold.branches.settings import Settings
    from slipfold.continuation.settings import Newton, Steps

    newton, steps, settings = Newton(), Steps(), Settings()
    if tolerance is not None:
        newton = replace(newton, tolerance=parse_number(tolerance, "--tolerance"))
    if max_step is not None:
        steps = replace(steps, largest=parse_number(max_step, "--max-step"))
    if max_points is not None:
        steps = replace(steps, points=parse_whole(max_points, "--max-points"))
    if largest_period is not None:
        whole = parse_whole(largest_period, "--largest-period", least=0)
        settings = replace(settings, largest_period=whole, snaking_period=whole)
    if discretisation is not None:
        settings = replace(settings, discretisation=discretisation)
    return replace(settings, newton=newton, steps=steps)
