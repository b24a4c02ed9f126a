"""A system of equations, read and checked from beginning to end; all models of it share it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache, partial

from slipfold.errors import InputError
from slipfold.models.definitions.array_entries import without_arrays
from slipfold.models.definitions.declared_contacts import (
    check_contacts,
    contact_limits,
    contact_outputs,
)
from slipfold.models.definitions.definition import Definition
from slipfold.models.definitions.equations import SystemEquations, build_system_equations
from slipfold.models.definitions.named_formulas import parse_formulas
from slipfold.models.definitions.reader import read_definition
from slipfold.models.definitions.repetition import (
    always_repeats,
    find_unrepeated,
    find_unturned,
)
from slipfold.models.definitions.source import Source, source_of_text
from slipfold.models.definitions.toml_writer import write_definition
from slipfold.models.formulas.tree import Tree, format_tree, names_in
from slipfold.models.formulas.values import as_symbol
from slipfold.models.output import Expression, Limit, Output, Symbols
from slipfold.models.parameter import DURATION, Parameter


@dataclass(frozen=True, eq=False)
class BuiltSystem:
    """A definition with all that follows from it."""

    definition: Definition  # names, formulas and their meaning
    text: str  # the definition as TOML, always the same for the same definition
    equations: SystemEquations  # the formulas taken apart
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
            entry = find_unrepeated(self.definition, self.equations, values)
            if entry is not None:
                raise InputError(_unrepeated(self.definition, entry, period, _at(values)))
            unturned = find_unturned(self.definition, self.equations, values)
            if unturned is not None:
                raise InputError(_unturned(*unturned, _at(values)))


def build_system(source: Source, default_name: str = "system") -> BuiltSystem:
    """Read a definition and check all of it."""
    source = without_arrays(source)
    definition = read_definition(source, default_name)
    equations = build_system_equations(definition, parse_formulas(definition, source), source)
    defaults = {item.name: item.default for item in (*definition.parameters, DURATION)}
    entry = find_unrepeated(definition, equations, defaults)
    if entry is not None:
        period = float(equations.period(defaults))
        raise source.error(entry, _unrepeated(definition, entry, period, ""))
    unturned = find_unturned(definition, equations, defaults)
    if unturned is not None:
        raise source.error(("states", unturned[0]), _unturned(*unturned, ""))
    check_contacts(definition, equations, source)
    outputs = tuple(
        Output(item.name, partial(_output, equations, item.name), item.unit, item.doc, item.label)
        for item in definition.outputs
    )
    outputs += contact_outputs(equations)
    limits = (*definition.limits, *contact_limits(equations))
    text, repeats = write_definition(definition), always_repeats(definition, equations)
    return BuiltSystem(definition, text, equations, repeats, outputs, limits)


@lru_cache(maxsize=256)
def build_system_of_text(text: str) -> BuiltSystem:
    """Read a definition from a TOML text, once."""
    return build_system(source_of_text(text))


def _output(
    equations: SystemEquations, name: str, q: Symbols, c: Symbols, phase: Expression
) -> Expression:
    return as_symbol(equations.output(name, q, c, phase))


def _unrepeated(definition: Definition, entry: tuple[str, str], period: float, at: str) -> str:
    table, name = entry
    what = f"the rate of {name}" if table == "states" else f"the output {name}"
    return (
        f"{what} does not repeat after the forcing period {definition.period}, {period:.6g} s{at}; "
        "give a period after which every term with t begins anew"
    )


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
