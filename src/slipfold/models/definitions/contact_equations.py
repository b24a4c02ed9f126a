"""Friction in the contacts of a system of equations, taken apart as all its formulas are."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import heyoka as hy

from slipfold.errors import InputError
from slipfold.models.contact import friction_name, normal_name
from slipfold.models.definitions.contact_formulas import ContactFormulas
from slipfold.models.formulas.coefficients import PHASE
from slipfold.models.formulas.tree import Tree, names_in
from slipfold.models.formulas.values import value_of
from slipfold.models.output import Expression, Symbols


@dataclass(frozen=True)
class ContactEquations:
    """A contact with its formulas taken apart."""

    formulas: ContactFormulas
    slip: tuple[Tree, ...]  # in states, coefficients, named formulas and the phase
    normal: Tree  # likewise
    values: Mapping[str, Tree]  # of the law's parameters, in coefficients

    def law_values(self, c: Symbols) -> dict[str, Expression]:
        """Return the law's parameters by name."""
        known = {f"@{key}": value for key, value in c.items()}
        return {name: value_of(tree, known) for name, tree in self.values.items()}

    def check(self, c: Mapping[str, float]) -> None:
        """Refuse values that the law cannot have, and a constant normal force that pulls."""
        if all(name.startswith("@") and name != PHASE for name in names_in(self.normal)):
            normal = value_of(self.normal, {f"@{key}": value for key, value in c.items()})
            if not normal > 0:
                raise InputError(
                    f"the normal force of {self.formulas.name} is {normal:g}; it must be > 0"
                )
        law, values = self.formulas.law, self.law_values(c)
        try:
            for item in law.parameters:
                item.check(values[item.name])
            law.check(values)
        except InputError as error:
            raise InputError(f"friction of {self.formulas.name}: {error}") from None

    def forces(
        self, value: Callable[[Tree], Expression], q: Symbols, c: Symbols
    ) -> dict[str, Expression]:
        """Return the forces by name: those given among the states, else those in slip."""
        own = self.formulas
        if normal_name(own.name) in q:
            friction = tuple(q[friction_name(own.name, axis)] for axis in range(len(own.slip)))
            normal = q[normal_name(own.name)]
        else:
            slip, normal = [value(tree) for tree in self.slip], value(self.normal)
            rests = not any(isinstance(part, hy.expression) or part for part in slip)
            # At rest it may be anything up to its limit.
            friction = tuple(slip) if rests else own.law.force(slip, normal, p=self.law_values(c))
        return dict(zip(own.forces, friction, strict=True)) | {own.normal_name: normal}
