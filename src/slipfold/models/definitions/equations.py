"""The equations of a system as models need them: of symbols, or of floats."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

from slipfold.errors import InputError
from slipfold.models.definitions.contacts import ContactEquations, ContactFormulas
from slipfold.models.definitions.definition import Definition
from slipfold.models.definitions.source import Keys, Source
from slipfold.models.formulas.functions import CONSTANTS, TIME
from slipfold.models.formulas.grammar import FormulaError, Name, Tree, names_in, parse_formula
from slipfold.models.formulas.values import PHASE, CoefficientFinder, value_of
from slipfold.models.output import Expression, Symbols
from slipfold.models.parameter import DURATION
from slipfold.models.suggestion import suggest
from slipfold.text.one_line import listed

PERIOD = ("forcing", "period")
"""The path of the formula of the forcing period."""


@dataclass(frozen=True)
class SystemEquations:
    """Formulas taken apart into coefficients and the rest."""

    fixed: Mapping[str, Tree]  # named formulas of parameters alone, each after those that it uses
    terms: Mapping[str, Tree]  # coefficients in parameters and `fixed`, by key
    named: Mapping[str, Tree]  # the other named formulas, each after those that it uses
    # By name, in states, coefficients, `named` and the phase
    rates: Mapping[str, Tree]
    outputs: Mapping[str, Tree]
    contacts: tuple[ContactEquations, ...]  # where friction acts
    cycle: Tree | None  # the forcing period; None for an autonomous system

    def period(self, p: Symbols) -> Expression:
        """Return the period in seconds."""
        return p[DURATION.name] if self.cycle is None else value_of(self.cycle, self._fixed(p))

    def coefficients(self, p: Symbols) -> dict[str, Expression]:
        """Return the coefficients by key."""
        fixed = self._fixed(p)
        return {key: value_of(tree, fixed) for key, tree in self.terms.items()}

    def not_finite(self, values: Mapping[str, float]) -> Tree | None:
        """Return a coefficient that is not a finite number; None if all are."""
        fixed = self._fixed(values)
        for tree in self.terms.values():
            known = isinstance(tree, Name) and tree.name not in self.fixed
            if not known and not math.isfinite(value_of(tree, fixed)):
                return tree
        return None

    def rate(self, name: str, q: Symbols, c: Symbols, phase: Expression) -> Expression:
        """Return the rate of a state, per second."""
        return self.value(self.rates[name], q, c, phase)

    def output(self, name: str, q: Symbols, c: Symbols, phase: Expression) -> Expression:
        """Return an output."""
        return self.value(self.outputs[name], q, c, phase)

    @cached_property
    def timed(self) -> tuple[tuple[str, str], ...]:
        """Rates and outputs in which the time occurs, as pairs of table and name."""
        timed = {PHASE}
        for _ in range(2):  # friction may vary with formulas, and formulas with friction
            for name, tree in self.named.items():
                if names_in(tree).keys() & timed:
                    timed.add(name)
            for contact in self.contacts:
                if any(names_in(tree).keys() & timed for tree in (*contact.slip, contact.normal)):
                    timed |= {*contact.formulas.force_names}
        tables = {"states": self.rates, "outputs": self.outputs}
        return tuple(
            (table, name)
            for table, trees in tables.items()
            for name, tree in trees.items()
            if names_in(tree).keys() & timed
        )

    def _fixed(self, p: Symbols) -> dict[str, Expression]:
        values = {**p, **CONSTANTS}
        for name, tree in self.fixed.items():
            values[name] = value_of(tree, values)
        return values

    def value(self, tree: Tree, q: Symbols, c: Symbols, phase: Expression) -> Expression:
        """Return what a formula amounts to."""
        values = {**q, **{f"@{key}": value for key, value in c.items()}, PHASE: phase}
        needed = self._needed(tree)
        if self.contacts:
            used = set(names_in(tree)).union(*(names_in(self.named[name]) for name in needed))
            for contact in self.contacts:
                if used & {*contact.formulas.force_names}:
                    values |= contact.forces(lambda part: self.value(part, q, c, phase), q, c)
        for name, formula in self.named.items():
            if name in needed:
                values[name] = value_of(formula, values)
        return value_of(tree, values)

    def _needed(self, tree: Tree) -> set[str]:
        """Named formulas behind a tree; those that use others come later in the table."""
        needed = set(names_in(tree)) & self.named.keys()
        for name in reversed(list(self.named)):
            if name in needed:
                needed |= names_in(self.named[name]).keys() & self.named.keys()
        return needed


def build_system_equations(definition: Definition, source: Source) -> SystemEquations:
    """Parse the formulas of a system, look up the names in them, and take them apart."""
    formulas = _Formulas(definition, source)
    trees, constant = formulas.trees, formulas.constant
    finder = CoefficientFinder(formulas.parameters | constant, trees.get(PERIOD))

    def rest(path: Keys) -> Tree:
        try:
            return finder.rest_of(trees[path])
        except FormulaError as error:
            raise formulas.error(path, error) from None

    def contact(item: ContactFormulas) -> ContactEquations:
        rests = {path: rest(path) for path in item.texts}
        *slip, normal = (tree for path, tree in rests.items() if path[2] != "friction")
        values = {path[3]: tree for path, tree in rests.items() if path[2] == "friction"}
        return ContactEquations(item, tuple(slip), normal, values)

    # The keys of coefficients are numbered in this order.
    rates = {item.state.name: rest(("states", item.state.name)) for item in definition.states}
    varying = [name for name in formulas.named if name not in constant]
    named = {name: rest(("formulas", name)) for name in varying}
    outputs = {item.name: rest(("outputs", item.name)) for item in definition.outputs}
    return SystemEquations(
        fixed={name: tree for name, tree in formulas.named.items() if name in constant},
        contacts=tuple(contact(item) for item in definition.contacts),
        terms=finder.coefficients,
        named=named,
        rates=rates,
        outputs=outputs,
        cycle=trees.get(PERIOD),
    )


class _Formulas:
    """All formulas of a system as trees, by the path of the entry."""

    def __init__(self, definition: Definition, source: Source) -> None:
        self._source, self._forced = source, definition.period is not None
        texts: dict[Keys, str] = {("formulas", name): text for name, text in definition.formulas}
        texts |= {("states", item.state.name): item.rate for item in definition.states}
        texts |= {("outputs", item.name): item.formula for item in definition.outputs}
        for contact in definition.contacts:
            texts |= contact.texts
        if definition.period is not None:
            texts[PERIOD] = definition.period
        self._texts = texts
        self.parameters = frozenset(item.name for item in definition.parameters)
        self._states = [item.state.name for item in definition.states]
        forces = [name for item in definition.contacts for name in item.force_names]
        self._known = {
            "the states": self._states,
            "the parameters": [item.name for item in definition.parameters],
            "the formulas": [name for name, _ in definition.formulas],
            "the forces in contacts": forces,
        }
        self.trees: dict[Keys, Tree] = {}
        for path, text in texts.items():
            try:
                self.trees[path] = parse_formula(text)
                self._look_up(path)
            except FormulaError as error:
                raise self.error(path, error) from None
        named = {name: self.trees[("formulas", name)] for name, _ in definition.formulas}
        self.named = _ordered(named, source)  # each after those that it uses
        self.constant = self._of_parameters_alone()
        if PERIOD in self.trees:
            self._check_constant("the forcing period", PERIOD)
        self._check_contacts(set(forces))

    def error(self, path: Keys, error: FormulaError) -> InputError:
        """Return the error about a place in a formula, whose text may be inside a table."""
        inner = (*path, "rate" if path[0] == "states" else "formula")
        inside = self._source.places and inner in self._source.places
        return self._source.formula_error(inner if inside else path, self._texts[path], error)

    def _look_up(self, path: Keys) -> None:
        # Whether the period depends on states is checked later, through the named formulas as well.
        known = {*CONSTANTS, *(name for names in self._known.values() for name in names)}
        for name, place in names_in(self.trees[path]).items():
            if name in known or (name == TIME and self._forced and path != PERIOD):
                continue
            if name == TIME and self._forced:
                message = "the forcing period cannot depend on the time t; give it in parameters"
            elif name == TIME:
                message = (
                    "t, the time, occurs in a system without forcing; add the table [forcing] with "
                    'the period in seconds, e.g. period = "2*pi/W"'
                )
            else:
                message = self._unknown(name)
            raise FormulaError(message, place, len(name))

    def _unknown(self, name: str) -> str:
        hint = {"e": "write exp(1) for Euler's number; ", "i": "there are no complex numbers; "}
        groups = {**self._known, "and": [*([TIME] if self._forced else []), *CONSTANTS]}
        known = ", ".join(f"{what} {listed(names)}" for what, names in groups.items() if names)
        near = suggest(name, [each for names in self._known.values() for each in names])
        return f"there is no name {name[:80]!r}; {hint.get(name, '') or near}known are {known}"

    def _of_parameters_alone(self) -> frozenset[str]:
        found: set[str] = set()
        for name, tree in self.named.items():
            if names_in(tree).keys() <= self.parameters | found | CONSTANTS.keys():
                found.add(name)
        return frozenset(found)

    def _check_constant(self, what: str, path: Keys) -> None:
        """Refuse a formula that is not of parameters alone."""
        fixed = self.parameters | self.constant | CONSTANTS.keys()
        for name, place in names_in(self.trees[path]).items():
            if name not in fixed:
                other = "the time" if name == TIME else "the formula"
                kind = "the state" if name in self._states else other
                message = (
                    f"{what} depends on {kind} {name}, but must be known before the motion is; "
                    "give it in parameters"
                )
                raise self.error(path, FormulaError(message, place, len(name)))

    def _check_contacts(self, forces: set[str]) -> None:
        """Refuse laws whose parameters vary, slips and normal forces that depend on friction."""
        for name, tree in self.named.items():
            if names_in(tree).keys() & forces:
                forces.add(name)
        for path, tree in self.trees.items():
            if path[0] != "contacts":
                continue
            if path[2] == "friction":
                self._check_constant(f"{path[3]} of the contact {path[1]}", path)
                continue
            for name, place in names_in(tree).items():
                if name in forces:
                    message = (
                        f"the {path[2]} of {path[1]} depends on {name}, a force in a contact; "
                        "write it in states and parameters"
                    )
                    raise self.error(path, FormulaError(message, place, len(name)))


def _ordered(trees: Mapping[str, Tree], source: Source) -> dict[str, Tree]:
    """Sort named formulas so that each follows those that it uses."""
    uses = {name: [n for n in names_in(tree) if n in trees] for name, tree in trees.items()}
    done: dict[str, Tree] = {}
    for first in trees:
        # Depth first, with a stack of its own: a chain may be as long as the table.
        chain = [] if first in done else [first]
        while chain:
            missing = next((name for name in uses[chain[-1]] if name not in done), None)
            if missing is None:
                name = chain.pop()
                done[name] = trees[name]
            elif missing in chain:
                raise _circle([*chain[chain.index(missing) :], missing], source)
            else:
                chain.append(missing)
    return done


def _circle(names: list[str], source: Source) -> InputError:
    first = names[0]
    if len(names) == 2:
        message = f"the formula {first} uses itself; write it in states and parameters"
    else:
        message = (
            f"the formulas {' -> '.join(names)} use each other in a circle; write one of them in "
            "states and parameters"
        )
    return source.error(("formulas", first), message, key=True)
