"""Whether the forcing of a system repeats after the period that is given for it.

Nothing else would notice: with a wrong period a search still ends at a motion that closes once, but
does not go on like that.
"""

from __future__ import annotations

import math
import random
from collections.abc import Iterator, Mapping

from slipfold.models.definitions.definition import Definition
from slipfold.models.definitions.equations import SystemEquations
from slipfold.models.parameter import Parameter

__all__ = ["always_repeats", "find_unrepeated"]

SAMPLES = 6

SIZES = (1.0, 1e-5, 0.0)
"""Sizes of the states looked at: beside terms of states far larger than those of the model, a
forcing would be rounding."""

TOLERANCE = 1e-8
"""Difference that is no rounding, as a share of the largest value."""

CHANGE = 0.2
"""How far parameters are moved, as a share of their size."""


def find_unrepeated(
    definition: Definition, equations: SystemEquations, values: Mapping[str, float]
) -> tuple[str, str] | None:
    """Return table and name of a rate or output that differs one period later."""
    if not equations.timed:
        return None
    period = float(equations.period(values))
    coefficients = equations.coefficients(values)
    if not (math.isfinite(period) and all(map(math.isfinite, coefficients.values()))):
        return None
    for size in SIZES:
        points = list(_points(definition, size))
        for table, name in equations.timed:
            function = equations.rate if table == "states" else equations.output
            pairs = []
            for state, phase in points:
                now, later = (function(name, state, coefficients, phase + k) for k in (0, 1))
                if math.isfinite(now) and math.isfinite(later):
                    pairs.append((now, later))
            largest = max((abs(value) for pair in pairs for value in pair), default=0.0)
            if any(abs(now - later) > TOLERANCE * largest for now, later in pairs):
                return table, name
    return None


def always_repeats(definition: Definition, equations: SystemEquations) -> bool:
    """Tell whether the forcing repeats for other parameter values than the defaults as well."""
    chance = random.Random(1)
    return all(
        find_unrepeated(
            definition,
            equations,
            {item.name: _moved(item, chance.uniform(-1, 1)) for item in definition.parameters},
        )
        is None
        for _ in range(2)
    )


def _moved(parameter: Parameter, share: float) -> float:
    # A parameter of zero may hide a force: give it some size.
    size = abs(parameter.default) or 1.0
    moved = parameter.default + CHANGE * size * share
    return min(max(moved, parameter.lower), parameter.upper)


def _points(definition: Definition, size: float) -> Iterator[tuple[dict[str, float], float]]:
    """States around the start and phases; the same ones every time."""
    chance = random.Random(0)
    for _ in range(SAMPLES):
        state = {
            item.state.name: item.start + size * (item.scale or 1.0) * chance.uniform(-1, 1)
            for item in definition.states
        }
        yield state, chance.uniform(0, 1)
