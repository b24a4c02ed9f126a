"""The equations of a system as models need them: of symbols, or of floats."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

from slipfold.models.definitions.contact_equations import ContactEquations
from slipfold.models.definitions.contact_formulas import ContactFormulas
from slipfold.models.definitions.definition import Definition
from slipfold.models.definitions.named_formulas import Formulas
from slipfold.models.definitions.source import Source
from slipfold.models.definitions.toml_places import Path
from slipfold.models.formulas.coefficients import PHASE, CoefficientFinder
from slipfold.models.formulas.functions import CONSTANTS
from slipfold.models.formulas.tokens import FormulaError
from slipfold.models.formulas.tree import Name, Tree, names_in
from slipfold.models.formulas.values import value_of
from slipfold.models.output import Expression, Symbols
from slipfold.models.parameter import DURATION


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


def build_system_equations(
    definition: Definition, formulas: Formulas, source: Source
) -> SystemEquations:
    """Take all formulas of a system apart."""
    parameters = {item.name for item in definition.parameters}
    finder = CoefficientFinder(parameters | formulas.constant, formulas.period)

    def taken_apart_one(path: Path, tree: Tree) -> Tree:
        try:
            return finder.rest_of(tree)
        except FormulaError as error:
            raise source.formula_error(*formulas.texts[path], error) from None

    def taken_apart(table: str, trees: Mapping[str, Tree]) -> dict[str, Tree]:
        return {name: taken_apart_one((table, name), tree) for name, tree in trees.items()}

    def contact(item: ContactFormulas) -> ContactEquations:
        rests = {path: taken_apart_one(path, formulas.contacts[path]) for path in item.texts}
        *slip, normal = (tree for path, tree in rests.items() if path[2] != "friction")
        values = {path[3]: tree for path, tree in rests.items() if path[2] == "friction"}
        return ContactEquations(item, tuple(slip), normal, values)

    varying = {name: tree for name, tree in formulas.named.items() if name not in formulas.constant}
    rates = taken_apart("states", formulas.rates)
    named = taken_apart("formulas", varying)
    outputs = taken_apart("outputs", formulas.outputs)
    contacts = tuple(contact(item) for item in definition.contacts)
    return SystemEquations(
        fixed={name: formulas.named[name] for name in formulas.named if name in formulas.constant},
        terms=finder.coefficients,
        named=named,
        rates=rates,
        outputs=outputs,
        contacts=contacts,
        cycle=formulas.period,
    )
