"""A system of equations, read and checked from beginning to end; all models of it share it.

It must repeat after its forcing period, and after whole turns of its angles. Nothing else would
notice: with a wrong period a search still ends at a motion that closes once, but does not
repeat.
"""

from __future__ import annotations

import math
import random
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache, partial

from slipfold.errors import InputError
from slipfold.models.definitions.arrays import without_arrays
from slipfold.models.definitions.declared_contacts import (
    DeclaredContact,
    check_contacts,
    declared_contacts,
)
from slipfold.models.definitions.definition import Definition, read_definition, write_definition
from slipfold.models.definitions.equations import SystemEquations, build_system_equations
from slipfold.models.definitions.source import Keys, Source, source_of_text
from slipfold.models.formulas.grammar import Tree, format_tree, names_in
from slipfold.models.formulas.values import as_symbol
from slipfold.models.output import Expression, Limit, Output, Symbols
from slipfold.models.parameter import DURATION, Parameter
from slipfold.models.turns import TURN

SAMPLES = 6

SIZES = (1.0, 1e-5, 0.0)
"""Sizes of the states looked at: next to terms of states far larger than those of the model, a
forcing would be rounding."""

TOLERANCE = 1e-8
"""Difference that is no rounding, as a share of the largest value."""

CHANGE = 0.2
"""How far parameters are moved, as a share of their size."""


def why_not_repeated(
    definition: Definition, equations: SystemEquations, values: Mapping[str, float], at: str = ""
) -> tuple[Keys, str] | None:
    """Return the entry that differs a period or a whole turn of an angle later, and what to say."""

    def changed(entries: Sequence[tuple[str, str]], *turned: str) -> tuple[str, str] | None:
        moved = dict.fromkeys(turned, TURN)
        return _changed(definition, equations, values, entries, moved, 0.0 if turned else 1.0)

    entry = changed(equations.timed)
    if entry is not None:
        what = f"the rate of {entry[1]}" if entry[0] == "states" else f"the output {entry[1]}"
        period = float(equations.period(values))
        return entry, (
            f"{what} does not repeat after the forcing period {definition.period}, {period:.6g} s"
            f"{at}; give a period after which every term with t repeats"
        )
    rates = [("states", name) for name in equations.rates]
    angles = tuple(item.state.name for item in definition.states if item.state.angle)
    for angle in angles:
        found = changed(rates, angle)
        if found is not None:
            # States with which all rates repeat if they turn with the angle.
            single = [(item.state.name,) for item in definition.states if item.state.name != angle]
            others = tuple(name for name in angles if name != angle)
            turning = (names for names in (*single, others) if not changed(rates, angle, *names))
            return ("states", angle), _unturned(angle, found[1], next(turning, ()), at)
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
    return all(why_not_repeated(definition, equations, values) is None for values in sets)


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


@dataclass(frozen=True, eq=False)
class BuiltSystem:
    """A definition with all that follows from it."""

    definition: Definition  # names, formulas and their meaning
    text: str  # the definition as TOML, always the same for the same definition
    equations: SystemEquations  # the formulas taken apart
    contacts: tuple[DeclaredContact, ...]  # where friction acts
    # Whether forcing and angles repeat whatever the parameters; else each set is to be checked
    repeats: bool
    outputs: tuple[Output, ...]  # quantities of interest
    limits: tuple[Limit, ...]  # where it is valid

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """Parameters of the definition, and the duration that autonomous models have."""
        return self.definition.parameters + (() if self.definition.period else (DURATION,))

    def rates(self, q: Symbols, c: Symbols, phase: Expression) -> dict[str, Expression]:
        """Return the rates of all states as symbols."""
        names = self.equations.rates
        return {name: as_symbol(self.equations.rate(name, q, c, phase)) for name in names}

    def check(self, values: Mapping[str, float]) -> None:
        """Refuse parameter values with which the equations have no meaning."""
        period = self.equations.period(values)
        if not (math.isfinite(period) and period > 0):
            raise InputError(
                f"the forcing period {self.definition.period} is {period:g} s"
                f"{_at(values, self.equations.cycle)}; it must be positive, so correct the formula "
                "or the parameters in it"
            )
        coefficients = self.equations.coefficients(values)
        for contact in self.equations.contacts:
            contact.check(coefficients)
        term = self.equations.not_finite(values)
        if term is not None:
            raise InputError(
                f"{format_tree(term)} is not a finite number{_at(values, term)}; change the "
                "parameters in it"
            )
        if not self.repeats:
            found = why_not_repeated(self.definition, self.equations, values, _at(values))
            if found is not None:
                raise InputError(found[1])


def build_system(source: Source, default_name: str = "system") -> BuiltSystem:
    """Read a definition and check all of it."""
    source = without_arrays(source)
    definition = read_definition(source, default_name)
    equations = build_system_equations(definition, source)
    defaults = {item.name: item.default for item in (*definition.parameters, DURATION)}
    found = why_not_repeated(definition, equations, defaults)
    if found is not None:
        raise source.error(*found)
    check_contacts(definition, equations, source)
    outputs = tuple(
        Output(item.name, partial(_output, equations, item.name), item.unit, item.doc, item.label)
        for item in definition.outputs
    )
    contacts = declared_contacts(equations)
    outputs += tuple(output for item in contacts for output in item.outputs)
    limits = (*definition.limits, *(limit for item in contacts for limit in item.limits))
    text, repeats = write_definition(definition), always_repeats(definition, equations)
    return BuiltSystem(definition, text, equations, contacts, repeats, outputs, limits)


@lru_cache(maxsize=256)
def build_system_of_text(text: str) -> BuiltSystem:
    """Read a definition from a TOML text, once."""
    return build_system(source_of_text(text))


def _output(
    equations: SystemEquations, name: str, q: Symbols, c: Symbols, phase: Expression
) -> Expression:
    return as_symbol(equations.output(name, q, c, phase))


def _unturned(angle: str, state: str, partners: tuple[str, ...], at: str) -> str:
    whose = "its own rate" if state == angle else f"the rate of {state}"
    if partners:
        whose = f"the rate of {state}"
        several = len(partners) > 1
        names = f"states {' and '.join(partners)}" if several else f"state {partners[0]}"
        differences = "differences such as" if several else "the difference"
        return (
            f"{angle} and {' and '.join(partners)} only turn together: {whose} changes when "
            f"{angle} alone makes a whole turn{at}; replace the {names} by {differences} "
            f"d = {partners[0]} - {angle}, and declare {angle} the only angle"
        )
    return (
        f"{angle} is declared an angle, but {whose} is another after a whole turn, "
        f"{angle} + 2*pi{at}; write it by sin and cos of {angle}, or leave angle out"
    )


def _at(values: Mapping[str, float], tree: Tree | None = None) -> str:
    """Say at which parameter values: those in a formula, if it has any, and a few at most."""
    names = [name for name in values if tree is not None and name in names_in(tree)]
    shown = [f"{name} = {values[name]:g}" for name in names or values]
    more = ", ..." if len(shown) > 6 else ""
    return f" at {', '.join(shown[:6])}{more}" if shown else ""
