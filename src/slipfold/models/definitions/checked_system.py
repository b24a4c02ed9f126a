"""Systems of equations, checked from beginning to end.

The equations must repeat after the forcing period, and after revolutions of the angles. With a
wrong period a search would still end at a trajectory that closes once, but does not repeat.
"""

from __future__ import annotations

import math
import random
from collections.abc import Iterator, Mapping, Sequence
from functools import lru_cache
from typing import Any

import heyoka as hy
import numpy as np

from slipfold.arrays import Array
from slipfold.errors import InputError
from slipfold.models.angles import REVOLUTION
from slipfold.models.definitions.arrays import without_arrays
from slipfold.models.definitions.equations import ContactEquations, SystemEquations
from slipfold.models.definitions.source import Keys, Source, source_of_text
from slipfold.models.definitions.system_file import SystemFile, read_system
from slipfold.models.formulas.grammar import Name, Tree, format_tree, names_in
from slipfold.models.formulas.values import as_symbol
from slipfold.models.friction.contact import normal_name
from slipfold.models.quantities import Parameter, Symbols


def build_system(source: Source, default_name: str = "system") -> SystemEquations:
    """Read a definition and check all of it."""
    source = without_arrays(source)
    equations = SystemEquations(read_system(source, default_name), source)
    result = _why_not_repeated(equations, equations.defaults)
    if result is not None:
        raise source.error(*result)
    _check_contacts(equations, source)
    equations.repeats = _always_repeats(equations)
    return equations


@lru_cache(maxsize=256)
def build_system_of_text(text: str) -> SystemEquations:
    """Read a definition from a TOML text, once."""
    return build_system(source_of_text(text))


def check_values(equations: SystemEquations, values: Mapping[str, float]) -> None:
    """Refuse parameter values with which the equations have no meaning."""
    period = equations.period(values)
    if not (math.isfinite(period) and period > 0):
        raise InputError(
            f"the forcing period {equations.definition.period} is {period:g} s"
            f"{_at(values, equations.cycle)}; it must be positive, so correct the formula or "
            "the parameters in it"
        )
    coefficients = equations.coefficients(values)
    for contact in equations.contacts:
        contact.check(coefficients)
    for key, tree in equations.terms.items():
        given = isinstance(tree, Name) and tree.name not in equations.fixed
        if not given and not math.isfinite(coefficients[key]):
            raise InputError(
                f"{format_tree(tree)} is not a finite number{_at(values, tree)}; change "
                "the parameters in it"
            )
    if not equations.repeats:
        result = _why_not_repeated(equations, values, _at(values))
        if result is not None:
            raise InputError(result[1])


def _check_contacts(equations: SystemEquations, source: Source) -> None:
    """Refuse slips and forces that sticking trajectories cannot use: both must be linear."""
    q, c, phase = equations.symbols
    contacts = equations.contacts
    names = [name for item in contacts for name in (normal_name(item.name), *item.given)]
    given = {name: hy.expression(name) for name in names}
    coefficients = equations.coefficients(equations.defaults)
    rates = {
        name: as_symbol(equations.value(tree, {**q, **given}, c, phase))
        for name, tree in equations.rates.items()
    }

    def slopes_of(part: Any, symbols: Symbols) -> list[Any]:
        return [hy.diff(as_symbol(part), symbol) for symbol in symbols.values()]

    def linear(slopes: list[Any], *varying: str) -> bool:
        return all(set(varying).isdisjoint(hy.get_variables(slope)) for slope in slopes)

    for item in contacts:
        name = item.name
        try:
            item.check(coefficients)
        except InputError as error:
            raise source.error(("contacts", name, "friction"), str(error)) from None
        slip: Keys = ("contacts", name, "slip")
        for part in item.slip(q, c, phase):
            slopes = slopes_of(part, q)
            if not linear(slopes, *q, str(phase)):
                raise source.error(
                    slip,
                    f"the slip of {name} is not linear in the states; give a difference of "
                    "velocities, with parameters as factors",
                )
            if all(slope == hy.expression(0.0) for slope in slopes):
                message = f"the slip of {name} has no state in it; give e.g. Vd - v"
                raise source.error(slip, message)
        for state, rate in rates.items():
            own = {force: given[force] for force in (normal_name(name), *item.given)}
            if not linear(slopes_of(rate, own), *given):
                raise source.error(
                    ("states", state),
                    f"the rate of {state} is not linear in the forces of {name}; add them "
                    "with factors of states and parameters",
                )
        if not _slows(item, dict.fromkeys(given, 0.0), coefficients):
            raise source.error(
                slip,
                f"the friction {name} acts along its slip and so has to slow it, but does not; "
                f"write it into the rates, with the sign that {name} has on what moves",
            )


def _slows(contact: ContactEquations, none: Mapping[str, float], c: Mapping[str, float]) -> bool:
    """Return whether friction acts against its own slip; `none` are all forces, zero."""
    equations = contact.equations
    start = {name: item.start for name, item in equations.definition.states.items()}
    zero = np.array(contact.at_rest(c, 0.0))

    def slip_rates(**forces: float) -> Array:
        at = {**start, **none, **forces}
        rates = {name: equations.value(tree, at, c, 0.0) for name, tree in equations.rates.items()}
        return np.array(contact.slip(rates, c, 0.0)) - zero

    without = slip_rates()
    columns = [slip_rates(**{name: 1.0}) - without for name in contact.given]
    slows = np.linalg.eigvalsh(-(np.array(columns) + np.transpose(columns)) / 2)
    return bool(slows[0] > 0) or not np.isfinite(slows).all()


class REPEATS:
    """Settings of the test that equations repeat after a period or a revolution."""

    samples: int = 6  # states and phases at which it is tested
    # Sizes of the states tested: next to terms of states far larger than those of the model, a
    # forcing would be rounding
    sizes: tuple[float, ...] = (1.0, 1e-5, 0.0)
    tolerance: float = 1e-8  # difference, relative to the largest value, that is more than rounding
    change: float = 0.2  # change of parameters, relative to their size


def _why_not_repeated(
    equations: SystemEquations, values: Mapping[str, float], at: str = ""
) -> tuple[Keys, str] | None:
    """Return the entry that is not periodic, and the message; None if all are."""
    entry = _changed(equations, values, equations.timed, later=1.0)
    if entry is not None:
        what = f"the rate of {entry[1]}" if entry[0] == "states" else f"the output {entry[1]}"
        period = float(equations.period(values))
        return entry, (
            f"{what} does not repeat after the forcing period {equations.definition.period}, "
            f"{period:.6g} s{at}; give a period after which every term with t repeats"
        )
    rates = [("states", name) for name in equations.rates]
    for angle in (name for name, item in equations.definition.states.items() if item.angle):
        entry = _changed(equations, values, rates, angle=angle)
        if entry is not None:
            whose = "its own rate" if entry[1] == angle else f"the rate of {entry[1]}"
            return ("states", angle), (
                f"{angle} is declared an angle, but {whose} is another after a revolution, "
                f"{angle} + 2*pi{at}; write it by sin and cos of {angle}, replace angles that only "
                f"revolve together by one and differences such as d = psi - {angle}, or leave "
                "angle out"
            )
    return None


def _changed(
    equations: SystemEquations,
    values: Mapping[str, float],
    entries: Sequence[Keys],
    later: float = 0.0,
    angle: str = "",
) -> Keys | None:
    """Return the first rate or output that differs later, or after a revolution of an angle."""
    if not entries:
        return None
    coefficients = equations.coefficients(values)
    if not all(map(math.isfinite, (float(equations.period(values)), *coefficients.values()))):
        return None
    for size in REPEATS.sizes:
        points = list(_points(equations.definition, size))
        for table, name in entries:
            tree = (equations.rates if table == "states" else equations.output_trees)[name]
            pairs = []
            for state, phase in points:
                there = {**state, **({angle: state[angle] + REVOLUTION} if angle else {})}
                one = equations.value(tree, state, coefficients, phase)
                other = equations.value(tree, there, coefficients, phase + later)
                if math.isfinite(one) and math.isfinite(other):
                    pairs.append((one, other))
            largest = max((abs(value) for pair in pairs for value in pair), default=0.0)
            if any(abs(one - other) > REPEATS.tolerance * largest for one, other in pairs):
                return table, name
    return None


def _always_repeats(equations: SystemEquations) -> bool:
    """Whether it repeats for other parameter values than the defaults as well."""
    chance = random.Random(1)
    own = equations.definition.own_parameters()
    sets = [
        equations.defaults | {item.name: _moved(item, chance.uniform(-1, 1)) for item in own}
        for _ in range(2)
    ]
    return all(_why_not_repeated(equations, values) is None for values in sets)


def _moved(parameter: Parameter, fraction: float) -> float:
    # A parameter of zero may hide a force: give it some size.
    size = abs(parameter.default) or 1.0
    moved = parameter.default + REPEATS.change * size * fraction
    return min(max(moved, parameter.lower), parameter.upper)


def _points(definition: SystemFile, size: float) -> Iterator[tuple[dict[str, float], float]]:
    """Yield states around the start, and phases; the same ones every time."""
    chance = random.Random(0)
    for _ in range(REPEATS.samples):
        state = {
            name: item.start
            + (REVOLUTION / 2 if item.angle else size * (item.scale or 1.0)) * chance.uniform(-1, 1)
            for name, item in definition.states.items()
        }
        yield state, chance.uniform(0, 1)


def _at(values: Mapping[str, float], tree: Tree | None = None) -> str:
    """List the parameter values at which a message applies, six at most."""
    names = [name for name in values if tree is not None and name in names_in(tree)]
    shown = [f"{name} = {values[name]:g}" for name in names or values]
    more = ", ..." if len(shown) > 6 else ""
    return f" at {', '.join(shown[:6])}{more}" if shown else ""
