"""Whether a system repeats after its forcing period, and after whole turns of its angles.

Nothing else would notice: with a wrong period a search still ends at a motion that closes once, but
does not go on like that.
"""

from __future__ import annotations

import math
import random
from collections.abc import Iterator, Mapping, Sequence

from slipfold.models.definitions.definition import Definition
from slipfold.models.definitions.equations import SystemEquations
from slipfold.models.parameter import DURATION, Parameter
from slipfold.models.turns import TURN

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
    return _changed(definition, equations, values, equations.timed, {}, 1.0)


def find_unturned(
    definition: Definition, equations: SystemEquations, values: Mapping[str, float]
) -> tuple[str, str, tuple[str, ...]] | None:
    """Return an angle, the state whose rate differs after a whole turn of it, and its partners.

    Partners are states that make all rates repeat if they turn with the angle.
    """
    rates = [("states", name) for name in equations.rates]

    def changed(*turned: str) -> tuple[str, str] | None:
        moved = dict.fromkeys(turned, TURN)
        return _changed(definition, equations, values, rates, moved, 0.0)

    angles = tuple(item.state.name for item in definition.states if item.state.angle)
    for angle in angles:
        found = changed(angle)
        if found is not None:
            single = [(item.state.name,) for item in definition.states if item.state.name != angle]
            others = tuple(name for name in angles if name != angle)
            together = (names for names in (*single, others) if changed(angle, *names) is None)
            return angle, found[1], next(together, ())
    return None


def _changed(
    definition: Definition,
    equations: SystemEquations,
    values: Mapping[str, float],
    entries: Sequence[tuple[str, str]],
    moved: Mapping[str, float],
    later: float,
) -> tuple[str, str] | None:
    """Return the first rate or output that differs where states are moved and phases later."""
    if not entries:
        return None
    period = float(equations.period(values))
    coefficients = equations.coefficients(values)
    if not (math.isfinite(period) and all(map(math.isfinite, coefficients.values()))):
        return None
    for size in SIZES:
        points = list(_points(definition, size))
        for table, name in entries:
            function = equations.rate if table == "states" else equations.output
            pairs = []
            for state, phase in points:
                there = {key: value + moved.get(key, 0.0) for key, value in state.items()}
                one = function(name, state, coefficients, phase)
                other = function(name, there, coefficients, phase + later)
                if math.isfinite(one) and math.isfinite(other):
                    pairs.append((one, other))
            largest = max((abs(value) for pair in pairs for value in pair), default=0.0)
            if any(abs(one - other) > TOLERANCE * largest for one, other in pairs):
                return table, name
    return None


def always_repeats(definition: Definition, equations: SystemEquations) -> bool:
    """Tell whether it repeats for other parameter values than the defaults as well."""
    chance = random.Random(1)
    sets = [
        {DURATION.name: DURATION.default}
        | {item.name: _moved(item, chance.uniform(-1, 1)) for item in definition.parameters}
        for _ in range(2)
    ]
    return all(
        find(definition, equations, values) is None
        for values in sets
        for find in (find_unrepeated, find_unturned)
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
            item.state.name: item.start
            + (TURN / 2 if item.state.angle else size * (item.scale or 1.0)) * chance.uniform(-1, 1)
            for item in definition.states
        }
        yield state, chance.uniform(0, 1)
