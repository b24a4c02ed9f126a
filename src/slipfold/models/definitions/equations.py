"""The equations of a system, evaluated with symbols or floats."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from graphlib import CycleError, TopologicalSorter

import heyoka as hy

from slipfold.errors import InputError, suggest
from slipfold.models.definitions.source import Keys, Source
from slipfold.models.definitions.system_file import ContactTable, SystemFile, write_system
from slipfold.models.formulas.functions import CONSTANTS, TIME
from slipfold.models.formulas.grammar import (
    Call,
    FormulaError,
    Name,
    Tree,
    fold,
    names_in,
    parse_formula,
)
from slipfold.models.formulas.values import PHASE, CoefficientFinder, as_symbol, value_of
from slipfold.models.friction.contact import Contact, friction_name, normal_name
from slipfold.models.friction.law import ContactState, FrictionLaw
from slipfold.models.quantities import (
    DURATION,
    STICK,
    Expression,
    Limit,
    Output,
    Parameter,
    State,
    Symbols,
)
from slipfold.text import listed

PERIOD = ("forcing", "period")
"""The path of the formula of the forcing period."""


@dataclass(frozen=True)
class ContactEquations:
    """A contact with its formulas split into coefficients and the remainder."""

    name: str
    table: ContactTable
    slip_trees: tuple[Tree, ...]  # in states, coefficients, named formulas and the phase
    normal_tree: Tree  # likewise
    values: Mapping[str, Tree]  # of the law's parameters, in coefficients
    equations: SystemEquations  # those around it

    @property
    def law(self) -> FrictionLaw:
        """The friction law with default values."""
        return self.table.friction.law

    @property
    def force_names(self) -> tuple[str, ...]:
        """Names of its forces in formulas."""
        return self.table.force_names(self.name)

    @property
    def given(self) -> tuple[str, ...]:
        """Names under which the components of its friction may be given."""
        return tuple(friction_name(self.name, axis) for axis in range(len(self.slip_trees)))

    def law_values(self, c: Symbols) -> dict[str, Expression]:
        """Return the law's parameters by name."""
        coefficients = {f"@{key}": value for key, value in c.items()}
        return {name: value_of(tree, coefficients) for name, tree in self.values.items()}

    def check(self, c: Mapping[str, float]) -> None:
        """Refuse values that the law cannot have, and a constant normal force that pulls."""
        if all(name.startswith("@") and name != PHASE for name in names_in(self.normal_tree)):
            normal = value_of(self.normal_tree, {f"@{key}": value for key, value in c.items()})
            if not normal > 0:
                raise InputError(f"the normal force of {self.name} is {normal:g}; it must be > 0")
        values = self.law_values(c)
        try:
            for item in self.law.parameters:
                item.check(values[item.name])
            self.law.check(values)
        except InputError as error:
            raise InputError(f"friction of {self.name}: {error}") from None

    def forces(
        self, value: Callable[[Tree], Expression], q: Symbols, c: Symbols
    ) -> dict[str, Expression]:
        """Return the forces by name: those given among the states, else those in slip."""
        if normal_name(self.name) in q:
            friction = tuple(q[name] for name in self.given)
            normal = q[normal_name(self.name)]
        else:
            slip, normal = [value(tree) for tree in self.slip_trees], value(self.normal_tree)
            at_rest = not any(isinstance(part, hy.expression) or part for part in slip)
            # At rest friction may be anything up to its limit.
            state = ContactState(tuple(slip), normal=normal)
            friction = state.slip if at_rest else self.law.forces(state, self.law_values(c))
        return dict(zip(self.force_names, (*friction, normal), strict=True))

    def slip(self, q: Symbols, c: Symbols, phase: Expression) -> tuple[Expression, ...]:
        """Return the velocity of the moving surface relative to the body."""
        return tuple(self.equations.value(tree, q, c, phase) for tree in self.slip_trees)

    def at_rest(self, c: Symbols, phase: Expression) -> tuple[Expression, ...]:
        """Return the velocity of the moving surface: slip where nothing else moves."""
        return self.slip(dict.fromkeys(self.equations.rates, 0.0), c, phase)

    def contact(self, q: Symbols, c: Symbols, phase: Expression) -> Contact:
        """Return the contact in symbols."""
        plate = tuple(map(as_symbol, self.at_rest(c, phase)))
        return Contact(
            slip=tuple(map(as_symbol, self.slip(q, c, phase))),
            normal=as_symbol(self.equations.value(self.normal_tree, q, c, phase)),
            name=self.name,
            plate=plate,
            plate_speed=ContactState(plate).speed,
            law=self.law,
            values=self.law_values(c),
            opens=self.opens,
            limits=tuple(limit.name for limit in self.limits),
        )

    @cached_property
    def moves(self) -> bool:
        """Whether the moving surface moves steadily, at some parameter values."""
        _, c, phase = self.equations.symbols
        plate = [as_symbol(part) for part in self.at_rest(c, phase)]
        steady = str(phase) not in hy.get_variables(plate)
        return steady and any(part != hy.expression(0.0) for part in plate)

    @cached_property
    def opens(self) -> bool:
        """Whether the normal force varies, and so may vanish."""
        q, c, phase = self.equations.symbols
        normal = as_symbol(self.equations.value(self.normal_tree, q, c, phase))
        return not set(hy.get_variables(normal)).isdisjoint((*q, str(phase)))

    @property
    def outputs(self) -> tuple[Output, ...]:
        """Forces and speed of slip."""

        def speed(q: Symbols, c: Symbols, phase: Expression) -> Expression:
            return self.contact(q, c, phase).speed

        def ratio(q: Symbols, c: Symbols, phase: Expression) -> Expression:
            contact = self.contact(q, c, phase)
            return contact.speed / contact.plate_speed

        *_, speed_name, ratio_name = self.table.output_names(self.name)
        *frictions, normal = self.force_names
        docs = dict.fromkeys(frictions, f"friction in {self.name}")
        docs[normal] = f"normal force of {self.name}"
        result = [self.equations.output(name, Name(name), doc=doc) for name, doc in docs.items()]
        doc = f"speed of slip in {self.name}"
        result.append(Output(speed_name, speed, doc=doc))
        if self.moves:
            result.append(Output(ratio_name, ratio, doc=f"{doc} over that of its moving surface"))
        return tuple(result)

    @property
    def limits(self) -> tuple[Limit, ...]:
        """Limits at which branches in slip end."""
        result = []
        if self.moves:
            reason = (
                f"stick: the speed of slip in {self.name} fell to {{value:.3g}} of that of its "
                "moving surface; orbits are followed in slip, stay below this value, or simulate"
            )
            ratio = self.table.output_names(self.name)[-1]
            result.append(Limit(f"stick of {self.name}", ratio, STICK, reason))
        if self.opens:
            reason = (
                f"lost contact: the normal force of {self.name} fell to {{value:.3g}}; orbits are "
                "followed in contact, press harder, or simulate"
            )
            normal = self.force_names[-1]
            result.append(Limit(f"lost contact of {self.name}", normal, 0.0, reason))
        return tuple(result)


class SystemEquations:
    """Formulas of a system, parsed and split into coefficients and the remainder.

    Formulas of parameters alone are in `fixed` and `terms`; those of rates, outputs and contacts
    are in states, coefficients, `named` formulas and the phase.
    """

    def __init__(self, definition: SystemFile, source: Source) -> None:
        self.definition = definition
        formulas = _Formulas(definition, source)
        trees, constant = formulas.trees, formulas.constant
        self.cycle = trees.get(PERIOD)  # the forcing period; None for an autonomous system
        finder = CoefficientFinder(formulas.parameters | constant, self.cycle)

        def remainder(path: Keys) -> Tree:
            try:
                return finder.rest_of(trees[path])
            except FormulaError as error:
                raise formulas.error(path, error) from None

        def contact(name: str, table: ContactTable) -> ContactEquations:
            parts = {path: remainder(path) for path in table.texts(name)}
            *slip, normal = (tree for path, tree in parts.items() if path[2] != "friction")
            values = {path[3]: tree for path, tree in parts.items() if path[2] == "friction"}
            return ContactEquations(name, table, tuple(slip), normal, values, self)

        # Named formulas each follow those that they use. Coefficients are numbered in this order.
        self.fixed = {name: tree for name, tree in formulas.named.items() if name in constant}
        self.rates = {name: remainder(("states", name)) for name in definition.states}
        varying = [name for name in formulas.named if name not in constant]
        self.named = {name: remainder(("formulas", name)) for name in varying}
        self.output_trees = {name: remainder(("outputs", name)) for name in definition.outputs}
        self.contacts = tuple(contact(name, table) for name, table in definition.contacts.items())
        self.terms = finder.coefficients  # by key
        # Whether forcing and angles repeat whatever the parameters; else each set is to be checked
        self.repeats = False

    @cached_property
    def text(self) -> str:
        """The definition as TOML, always the same for the same definition."""
        return write_system(self.definition)

    @cached_property
    def states(self) -> tuple[State, ...]:
        """The states."""
        return tuple(
            State(name, item.unit, item.doc, item.label, item.angle)
            for name, item in self.definition.states.items()
        )

    @cached_property
    def parameters(self) -> tuple[Parameter, ...]:
        """Parameters of the definition, and the duration that autonomous models have."""
        return (*self.definition.own_parameters(), *(() if self.cycle else (DURATION,)))

    @property
    def defaults(self) -> dict[str, float]:
        """Default values of the parameters, and of the duration."""
        return {item.name: item.default for item in (*self.parameters, DURATION)}

    @cached_property
    def symbols(self) -> tuple[Symbols, Symbols, Expression]:
        """Symbols of states, coefficients and phase."""
        q = {name: hy.expression(name) for name in self.rates}
        return q, {key: hy.expression(f"c_{key}") for key in self.terms}, hy.expression("phase")

    @cached_property
    def outputs(self) -> tuple[Output, ...]:
        """Quantities of interest."""
        own = [
            self.output(name, self.output_trees[name], item.unit, item.doc, item.label)
            for name, item in self.definition.outputs.items()
        ]
        return (*own, *(output for contact in self.contacts for output in contact.outputs))

    def output(
        self, name: str, tree: Tree, unit: str = "", doc: str = "", label: str = ""
    ) -> Output:
        """Return an output that is a formula."""

        def expression(q: Symbols, c: Symbols, phase: Expression) -> Expression:
            return as_symbol(self.value(tree, q, c, phase))

        return Output(name, expression, unit, doc, label)

    @cached_property
    def limits(self) -> tuple[Limit, ...]:
        """Limits of validity."""
        own = (item.limit(name) for name, item in self.definition.limits.items())
        return (*own, *(limit for contact in self.contacts for limit in contact.limits))

    def period(self, p: Symbols) -> Expression:
        """Return the period in seconds."""
        return p[DURATION.name] if self.cycle is None else value_of(self.cycle, self._fixed(p))

    def coefficients(self, p: Symbols) -> dict[str, Expression]:
        """Return the coefficients by key."""
        fixed = self._fixed(p)
        return {key: value_of(tree, fixed) for key, tree in self.terms.items()}

    @cached_property
    def timed(self) -> tuple[Keys, ...]:
        """Paths of rates and outputs in which the time occurs."""
        timed = {PHASE}
        for contact in self.contacts:
            if any(
                PHASE in self._used(tree) for tree in (*contact.slip_trees, contact.normal_tree)
            ):
                timed |= {*contact.force_names}
        tables = {"states": self.rates, "outputs": self.output_trees}
        return tuple(
            (table, name)
            for table, trees in tables.items()
            for name, tree in trees.items()
            if self._used(tree) & timed
        )

    def _fixed(self, p: Symbols) -> dict[str, Expression]:
        values = {**p, **CONSTANTS}
        for name, tree in self.fixed.items():
            values[name] = value_of(tree, values)
        return values

    def value(self, tree: Tree, q: Symbols, c: Symbols, phase: Expression) -> Expression:
        """Return the value of a formula."""
        values = {**q, **{f"@{key}": value for key, value in c.items()}, PHASE: phase}
        used = self._used(tree)
        for contact in self.contacts:
            if used & {*contact.force_names}:
                values |= contact.forces(lambda part: self.value(part, q, c, phase), q, c)
        for name, formula in self.named.items():
            if name in used:
                values[name] = value_of(formula, values)
        return value_of(tree, values)

    def _used(self, tree: Tree) -> set[str]:
        """Return the names in a tree and in the named formulas behind it."""
        names = set(names_in(tree))
        return names.union(*(self._behind[name] for name in names if name in self._behind))

    @cached_property
    def _behind(self) -> dict[str, set[str]]:
        """The names in each named formula, and in those behind it."""
        behind: dict[str, set[str]] = {}
        for name, tree in self.named.items():  # each follows those that it uses
            names = set(names_in(tree))
            behind[name] = names.union(*(behind[other] for other in names if other in behind))
        return behind


class _Formulas:
    """All formulas of a system as trees, by the path of the entry."""

    def __init__(self, definition: SystemFile, source: Source) -> None:
        self._source, self._forced = source, definition.period is not None
        texts: dict[Keys, str] = {
            ("formulas", name): text for name, text in definition.formulas.items()
        }
        texts |= {("states", name): item.rate for name, item in definition.states.items()}
        texts |= {("outputs", name): item.formula for name, item in definition.outputs.items()}
        for name, contact in definition.contacts.items():
            texts |= contact.texts(name)
        if definition.period is not None:
            texts[PERIOD] = definition.period
        self._texts = texts
        self.parameters = frozenset(definition.parameters)
        contacts = definition.contacts.items()
        forces = [force for name, item in contacts for force in item.force_names(name)]
        self._known = {
            "the states": list(definition.states),
            "the parameters": list(definition.parameters),
            "the formulas": list(definition.formulas),
            "the forces in contacts": forces,
        }
        self.trees: dict[Keys, Tree] = {}
        for path, text in texts.items():
            try:
                self.trees[path] = parse_formula(text)
                self._look_up(path)
            except FormulaError as error:
                raise self.error(path, error) from None
        named = {name: self.trees[("formulas", name)] for name in definition.formulas}
        self.named = _ordered(named, source)  # each after those that it uses
        units = {name: item.unit for name, item in definition.parameters.items()}
        units |= {name: item.unit for name, item in definition.states.items()}
        self._check_angles([name for name in units if units[name] in ("deg", "°")])
        self.constant = self._of_parameters_alone()
        if PERIOD in self.trees:
            self._check_constant("the forcing period", PERIOD)
        self._check_contacts(set(forces))

    def error(self, path: Keys, error: FormulaError) -> InputError:
        """Return the error about a position in a formula, whose text may be inside a table."""
        inner = (*path, "rate" if path[0] == "states" else "formula")
        inside = self._source.locations and inner in self._source.locations
        return self._source.formula_error(inner if inside else path, self._texts[path], error)

    def _look_up(self, path: Keys) -> None:
        # Whether the period depends on states is checked later, through the named formulas as well.
        known = {*CONSTANTS, *(name for names in self._known.values() for name in names)}
        for name, position in names_in(self.trees[path]).items():
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
            raise FormulaError(message, position, len(name))

    def _unknown(self, name: str) -> str:
        hint = {"e": "write exp(1) for Euler's number; ", "i": "there are no complex numbers; "}
        groups = {**self._known, "and": [*([TIME] if self._forced else []), *CONSTANTS]}
        known = ", ".join(f"{what} {listed(names)}" for what, names in groups.items() if names)
        near = suggest(name, [each for names in self._known.values() for each in names])
        return f"there is no name {name[:80]!r}; {hint.get(name, '') or near}known are {known}"

    def _check_angles(self, angles: list[str]) -> None:
        """Refuse the sine of an angle in degrees, unless it has a factor such as pi/180."""
        if not angles:
            return
        used = {name for tree in self.trees.values() for name in names_in(tree)}
        values: dict[str, Expression] = {name: hy.expression(name) for name in used.union(angles)}
        values |= CONSTANTS
        for name, tree in self.named.items():
            values[name] = value_of(tree, values)

        def check(node: Tree, _: tuple[None, ...]) -> None:
            if not isinstance(node, Call) or node.function not in ("sin", "cos", "tan"):
                return
            argument = as_symbol(value_of(node.arguments[0], values))
            for name in angles:
                factor = hy.diff(argument, values[name])
                if not hy.get_variables(factor) and not _converts(float(str(factor))):
                    what = f"{node.function} takes radians, but {name} is in deg; give it the unit "
                    advice = 'rad, and its value as in "30 deg"'
                    word, place = node.function, node.position  # the angle is behind a formula
                    if name in (known := names_in(node)):
                        word, place = name, known[name]
                    raise FormulaError(what + advice, place, len(word))

        for path, tree in self.trees.items():
            try:
                fold(tree, check)
            except FormulaError as error:
                raise self.error(path, error) from None

    def _of_parameters_alone(self) -> frozenset[str]:
        constant: set[str] = set()
        for name, tree in self.named.items():
            if names_in(tree).keys() <= self.parameters | constant | CONSTANTS.keys():
                constant.add(name)
        return frozenset(constant)

    def _check_constant(self, what: str, path: Keys) -> None:
        """Refuse a formula that depends on more than parameters."""
        fixed = self.parameters | self.constant | CONSTANTS.keys()
        for name, position in names_in(self.trees[path]).items():
            if name not in fixed:
                other = "the time" if name == TIME else "the formula"
                kind = "the state" if name in self._known["the states"] else other
                factor = ", and a factor of friction that varies in normal" * (path != PERIOD)
                message = (
                    f"{what} depends on {kind} {name}, but must be known before the trajectory; "
                    f"give it in parameters{factor}"
                )
                raise self.error(path, FormulaError(message, position, len(name)))

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
            for name, position in names_in(tree).items():
                if name in forces:
                    message = (
                        f"the {path[2]} of {path[1]} depends on {name}, a force in a contact; "
                        "write it in states and parameters"
                    )
                    raise self.error(path, FormulaError(message, position, len(name)))


def _converts(factor: float) -> bool:
    """Whether a factor is pi/180 times a fraction below 60, or 1 to 9 or 1/9 within a hundredth."""
    times = abs(factor) * 180 / math.pi or 1.0  # nothing depends on the angle if it is zero
    near = Fraction(times).limit_denominator(59)
    if near.numerator < 60 and abs(times - near) < 1e-12 * times:
        return True
    return any(abs(max(times, 1 / times) / whole - 1) < 0.01 for whole in range(1, 10))


def _ordered(trees: Mapping[str, Tree], source: Source) -> dict[str, Tree]:
    """Sort named formulas so that each follows those that it uses."""
    uses = {name: [n for n in names_in(tree) if n in trees] for name, tree in trees.items()}
    try:
        return {name: trees[name] for name in TopologicalSorter(uses).static_order()}
    except CycleError as error:
        first, *others = names = list(reversed(error.args[1]))
    message = f"the formula {first} uses itself; write it in states and parameters"
    if len(others) > 1:
        message = (
            f"the formulas {' -> '.join(names)} use each other in a circle; write one of them in "
            "states and parameters"
        )
    raise source.error(("formulas", first), message, key=True)
