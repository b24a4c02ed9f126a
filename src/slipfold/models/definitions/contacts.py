"""Contacts of a system of equations: slip, normal force and law as formulas."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from numbers import Real
from typing import Any

import heyoka as hy

from slipfold.errors import InputError
from slipfold.models.definitions.source import Keys, Source
from slipfold.models.definitions.tables import Entries, type_name
from slipfold.models.formulas.grammar import Tree, names_in
from slipfold.models.formulas.values import PHASE, value_of
from slipfold.models.friction.contact import friction_name, normal_name
from slipfold.models.friction.law import ContactState, FrictionLaw
from slipfold.models.friction.record import friction_laws, law_record
from slipfold.models.output import Expression, Symbols
from slipfold.models.suggestion import suggest

EXAMPLE = 'F = { slip = "Vd - v", normal = "N", friction = "Coulomb" }'

AXES = ("x", "y")


@dataclass(frozen=True)
class ContactFormulas:
    """A contact with its formulas; its friction force stands under its name in other formulas."""

    name: str
    slip: tuple[str, ...]  # one or two components of the relative velocity along which it rubs
    normal: str
    law: FrictionLaw  # with default values
    values: tuple[tuple[str, str], ...]  # a formula for each of the law's parameters

    @property
    def forces(self) -> tuple[str, ...]:
        """Names of the components of friction."""
        return (self.name,) if len(self.slip) == 1 else tuple(self.name + axis for axis in AXES)

    @property
    def normal_name(self) -> str:
        """Name of the normal force, which vanishes where the contact is open."""
        return f"{self.name}_normal"

    @property
    def speed_name(self) -> str:
        """Name of the output that is the speed of slip."""
        return f"{self.name}_slip"

    @property
    def ratio_name(self) -> str:
        """Name of the output that is the speed of slip over that of the moving surface."""
        return f"{self.name}_ratio"

    @property
    def force_names(self) -> tuple[str, ...]:
        """Names of its forces in other formulas."""
        return (*self.forces, self.normal_name)

    @property
    def output_names(self) -> tuple[str, ...]:
        """Names of all its outputs."""
        return (*self.force_names, self.speed_name, self.ratio_name)

    @property
    def texts(self) -> dict[Keys, str]:
        """All formulas, by the path of the entry that holds them."""
        path: Keys = ("contacts", self.name, "slip")
        slips = {(*path, str(axis)): text for axis, text in enumerate(self.slip)}
        if len(self.slip) == 1:
            slips = {path: self.slip[0]}
        return {**slips, (*path[:2], "normal"): self.normal, **self.law_texts}

    @property
    def law_texts(self) -> dict[Keys, str]:
        """Those of the law's parameters."""
        return {("contacts", self.name, "friction", name): text for name, text in self.values}


def read_contact(source: Source, name: str, value: Any) -> ContactFormulas:
    """Read an entry of the table of contacts."""
    path = ("contacts", name)
    if not isinstance(value, Mapping):
        raise source.error(
            path, f"the contact {name[:60]} is {type_name(value)}; give a table, e.g. {EXAMPLE}"
        )
    Entries(source, path, value, ("slip", "normal", "friction"))
    for key in ("slip", "normal"):
        if key not in value:
            raise source.error(path, f"the contact {name[:60]} has no {key}; give e.g. {EXAMPLE}")
    law, values = _law(source, (*path, "friction"), value.get("friction", "Coulomb"))
    normal = _formula(source, (*path, "normal"), value["normal"])
    return ContactFormulas(name, _slip(source, path, value["slip"]), normal, law, values)


def _slip(source: Source, path: Keys, value: Any) -> tuple[str, ...]:
    where = (*path, "slip")
    if not isinstance(value, list | tuple):
        return (_formula(source, where, value),)
    if len(value) != 2:
        raise source.error(
            where,
            f"slip has {len(value)} components; give one formula on a line, or two in a plane",
        )
    return tuple(_formula(source, (*where, str(i)), item) for i, item in enumerate(value))


def _formula(source: Source, path: Keys, value: Any) -> str:
    if isinstance(value, str):
        return value
    if isinstance(value, bool) or not isinstance(value, Real):
        raise source.error(path, f"{path[2]} is {type_name(value)}; give a formula in quotes")
    return repr(float(value))


def _law(source: Source, path: Keys, value: Any) -> tuple[FrictionLaw, tuple[tuple[str, str], ...]]:
    """Read a friction law whose parameters are formulas."""
    given: Any = law_record(value) if isinstance(value, FrictionLaw) else value
    table = {"law": given} if isinstance(given, str) else given
    if not isinstance(table, Mapping):
        raise source.error(
            path, f'friction is {type_name(given)}; give a law, e.g. friction = "Coulomb"'
        )
    laws = {name: law for name, law in friction_laws().items() if law.sticks}
    name = table.get("law")
    if name not in laws:
        shown = name[:80] if isinstance(name, str) else type_name(name)
        near = suggest(shown, laws)
        raise source.error(
            (*path, "law"),
            f"{shown!r} is no law that sticks; {near}there are {', '.join(laws)}, and laws that do "
            "not stick are written as formulas",
        )
    fields = dataclasses.fields(laws[name])
    Entries(source, path, table, ("law", *(item.name for item in fields)), name)
    fixed = {
        item.name: table[item.name]
        for item in fields if item.name in table and "parameter" not in item.metadata
    }  # fmt: skip
    try:
        law = laws[name](**fixed)
    except InputError as error:
        raise source.error(path, str(error)) from None
    values = {item.name: table.get(item.name, item.default) for item in law.parameters}
    texts = {key: _formula(source, (*path, key), item) for key, item in values.items()}
    return law, tuple(texts.items())


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
            state = ContactState(tuple(slip), normal=normal)
            friction = state.slip if rests else own.law.forces(state, self.law_values(c))
        return dict(zip(own.forces, friction, strict=True)) | {own.normal_name: normal}
