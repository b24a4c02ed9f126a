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


@dataclass(frozen=True)
class Formulas:
    """All formulas of a system, parsed."""

    rates: Mapping[str, Tree]  # by state
    named: Mapping[str, Tree]  # the table of formulas, each after those that it uses
    outputs: Mapping[str, Tree]  # by name
    contacts: Mapping[Keys, Tree]  # of slips, normal forces and laws, by the entry
    period: Tree | None  # of the forcing; None for an autonomous system
    constant: frozenset[str]  # names of those in `named` that depend on parameters alone
    # By table and name: the entry that holds the text, and the text
    texts: Mapping[Keys, tuple[Keys, str]]


def parse_formulas(definition: Definition, source: Source) -> Formulas:
    """Parse the formulas of a system and look up the names in them."""
    texts: dict[Keys, str] = {("formulas", name): text for name, text in definition.formulas}
    for item in definition.states:
        texts[("states", item.state.name)] = item.rate
    for output in definition.outputs:
        texts[("outputs", output.name)] = output.formula
    for contact in definition.contacts:
        texts |= contact.texts
    if definition.period is not None:
        texts[("forcing", "period")] = definition.period
    paths = {path: _path_of_text(path, source) for path in texts}
    trees: dict[Keys, Tree] = {}
    for path, text in texts.items():
        try:
            trees[path] = parse_formula(text)
            _look_up(definition, path, trees[path])
        except FormulaError as error:
            raise source.formula_error(paths[path], text, error) from None
    named = _ordered({name: trees[("formulas", name)] for name, _ in definition.formulas}, source)
    constant = _constant(named, {item.name for item in definition.parameters})
    if definition.period is not None:
        what, path = "the forcing period", ("forcing", "period")
        _check_constant(definition, what, path, trees[path], texts[path], constant, source)
    contacts = {path: tree for path, tree in trees.items() if path[0] == "contacts"}
    _check_contacts(definition, contacts, texts, named, constant, source)
    return Formulas(
        rates={item.state.name: trees[("states", item.state.name)] for item in definition.states},
        named=named,
        outputs={item.name: trees[("outputs", item.name)] for item in definition.outputs},
        contacts=contacts,
        period=trees.get(("forcing", "period")),
        constant=constant,
        texts={path: (paths[path], text) for path, text in texts.items()},
    )


def _path_of_text(path: Keys, source: Source) -> Keys:
    """The entry that holds the text itself, which may be inside a table."""
    inner = (*path, "rate" if path[0] == "states" else "formula")
    return inner if source.places and inner in source.places else path


def _look_up(definition: Definition, path: Keys, tree: Tree) -> None:
    states = [item.state.name for item in definition.states]
    parameters = [item.name for item in definition.parameters]
    formulas = [name for name, _ in definition.formulas]
    # Whether the period depends on states is checked later, through the named formulas as well.
    contacts = [name for item in definition.contacts for name in item.force_names]
    known = [*states, *parameters, *formulas, *contacts, *CONSTANTS]
    forced = definition.period is not None
    for name, place in names_in(tree).items():
        if name in known:
            continue
        if name == TIME and forced:
            if path != ("forcing", "period"):
                continue
            message = "the forcing period cannot depend on the time t; give it in parameters"
        elif name == TIME:
            message = (
                "t, the time, occurs in a system without forcing; add the table [forcing] with the "
                'period in seconds, e.g. period = "2*pi/W"'
            )
        else:
            message = _unknown(name, states, parameters, formulas, contacts, forced)
        raise FormulaError(message, place, len(name))


def _unknown(
    name: str,
    states: list[str],
    parameters: list[str],
    formulas: list[str],
    contacts: list[str],
    forced: bool,
) -> str:
    hint = {"e": "write exp(1) for Euler's number; ", "i": "there are no complex numbers; "}
    groups = {
        "the states": states,
        "the parameters": parameters,
        "the formulas": formulas,
        "the forces in contacts": contacts,
        "and": [*([TIME] if forced else []), *CONSTANTS],
    }
    known = ", ".join(f"{what} {listed(names)}" for what, names in groups.items() if names)
    near = suggest(name, [*states, *parameters, *formulas, *contacts])
    return f"there is no name {name[:80]!r}; {hint.get(name, '') or near}known are {known}"


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


def _constant(named: Mapping[str, Tree], parameters: set[str]) -> frozenset[str]:
    found: set[str] = set()
    for name, tree in named.items():
        if names_in(tree).keys() <= parameters | found | CONSTANTS.keys():
            found.add(name)
    return frozenset(found)


def _check_constant(
    definition: Definition,
    what: str,
    path: Keys,
    tree: Tree,
    text: str,
    constant: frozenset[str],
    source: Source,
) -> None:
    """Refuse a formula that is not of parameters alone."""
    fixed = {item.name for item in definition.parameters} | constant | CONSTANTS.keys()
    states = {item.state.name for item in definition.states}
    for name, place in names_in(tree).items():
        if name not in fixed:
            kind = "the state" if name in states else "the time" if name == TIME else "the formula"
            message = (
                f"{what} depends on {kind} {name}, but must be known before the motion is; give it "
                "in parameters"
            )
            raise source.formula_error(path, text, FormulaError(message, place, len(name)))


def _check_contacts(
    definition: Definition,
    trees: Mapping[Keys, Tree],
    texts: Mapping[Keys, str],
    named: Mapping[str, Tree],
    constant: frozenset[str],
    source: Source,
) -> None:
    """Refuse laws whose parameters vary, slips and normal forces that depend on friction."""
    forces = {name for item in definition.contacts for name in item.force_names}
    for name, tree in named.items():
        if names_in(tree).keys() & forces:
            forces.add(name)
    for path, tree in trees.items():
        if path[2] == "friction":
            what = f"{path[3]} of the contact {path[1]}"
            _check_constant(definition, what, path, tree, texts[path], constant, source)
            continue
        for name, place in names_in(tree).items():
            if name in forces:
                message = (
                    f"the {path[2]} of {path[1]} depends on {name}, a force in a contact; write it "
                    "in states and parameters"
                )
                raise source.formula_error(
                    path, texts[path], FormulaError(message, place, len(name))
                )


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

    def taken_apart_one(path: Keys, tree: Tree) -> Tree:
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
