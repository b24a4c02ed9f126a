"""What follows from the contacts of a system of equations: outputs, limits, where motions stick."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property, partial

import heyoka as hy
import numpy as np

from slipfold.errors import InputError
from slipfold.models.definitions.contacts import ContactEquations, ContactFormulas
from slipfold.models.definitions.definition import Definition
from slipfold.models.definitions.equations import SystemEquations
from slipfold.models.definitions.source import Source
from slipfold.models.formulas.grammar import Name
from slipfold.models.formulas.values import as_symbol
from slipfold.models.friction.contact import Contact, friction_name, normal_name
from slipfold.models.output import STICK, Expression, Limit, Output, Symbols
from slipfold.models.parameter import DURATION


@dataclass(frozen=True)
class DeclaredContact:
    """A contact in the terms of the equations around it."""

    equations: SystemEquations
    taken_apart: ContactEquations

    @property
    def own(self) -> ContactFormulas:
        """Names, formulas and law."""
        return self.taken_apart.formulas

    @property
    def given(self) -> tuple[str, ...]:
        """Names under which the components of its friction may be given."""
        return tuple(friction_name(self.own.name, axis) for axis in range(len(self.own.slip)))

    def slip(self, q: Symbols, c: Symbols, phase: Expression) -> tuple[Expression, ...]:
        """Return the velocity of the moving surface relative to the body."""
        trees = self.taken_apart.slip
        return tuple(as_symbol(self.equations.value(tree, q, c, phase)) for tree in trees)

    def plate(self, c: Symbols, phase: Expression) -> tuple[Expression, ...]:
        """Return the velocity of the moving surface: slip where nothing else moves."""
        return self.slip(dict.fromkeys(self.equations.rates, 0.0), c, phase)

    def normal(self, q: Symbols, c: Symbols, phase: Expression) -> Expression:
        """Return the normal force of the formula."""
        return as_symbol(self.equations.value(self.taken_apart.normal, q, c, phase))

    def speed(self, q: Symbols, c: Symbols, phase: Expression) -> Expression:
        """Return the speed of slip."""
        return hy.sqrt(hy.sum([part * part for part in self.slip(q, c, phase)]))

    def ratio(self, q: Symbols, c: Symbols, phase: Expression) -> Expression:
        """Return the speed of slip over that of the moving surface."""
        driven = hy.sqrt(hy.sum([part * part for part in self.plate(c, phase)]))
        return self.speed(q, c, phase) / driven

    @cached_property
    def moves(self) -> bool:
        """Whether the moving surface moves steadily, at some parameter values."""
        _, c, phase = _symbols(self.equations)
        plate = self.plate(c, phase)
        steady = str(phase) not in hy.get_variables(list(plate))
        return steady and any(part != hy.expression(0.0) for part in plate)

    @cached_property
    def opens(self) -> bool:
        """Whether the normal force varies, and so may vanish."""
        q, c, phase = _symbols(self.equations)
        variables = set(hy.get_variables(self.normal(q, c, phase)))
        return not variables.isdisjoint((*q, str(phase)))

    def rests(self, values: Mapping[str, float]) -> bool:
        """Whether the moving surface stands still, or swings, at parameter values."""
        c, still = self.equations.coefficients(values), dict.fromkeys(self.equations.rates, 0.0)
        slips = (self.equations.value(tree, still, c, 0.0) for tree in self.taken_apart.slip)
        return not self.moves or not any(slips)

    def contact(self, q: Symbols, c: Symbols, phase: Expression) -> Contact:
        """Return the contact as trajectories that stick need it."""
        plate = self.plate(c, phase)
        return Contact(
            slip=self.slip(q, c, phase),
            normal=self.normal(q, c, phase),
            name=self.own.name,
            plate=plate,
            plate_speed=hy.sqrt(hy.sum([part * part for part in plate])),
            law=self.own.law,
            values=self.taken_apart.law_values(c),
            opens=self.opens,
            limits=tuple(limit.name for limit in self.limits),
        )

    @property
    def outputs(self) -> tuple[Output, ...]:
        """Forces and speed of slip."""
        own = self.own
        found = [
            Output(name, partial(_force, self.equations, name), doc=f"{what} {own.name}")
            for what, names in (("friction in", own.forces), ("normal force of", [own.normal_name]))
            for name in names
        ]
        doc = f"speed of slip in {own.name}"
        found.append(Output(own.speed_name, self.speed, doc=doc))
        if self.moves:
            doc += " over that of its moving surface"
            found.append(Output(own.ratio_name, self.ratio, doc=doc))
        return tuple(found)

    @property
    def limits(self) -> tuple[Limit, ...]:
        """Where branches, which are followed in slip, end."""
        own, found = self.own, []
        if self.moves:
            reason = (
                f"stick: the speed of slip in {own.name} fell to {{value:.3g}} of that of its "
                "moving surface; orbits are followed in slip, stay below this value, or simulate"
            )
            found.append(Limit(f"stick of {own.name}", own.ratio_name, STICK, reason))
        if self.opens:
            reason = (
                f"lost contact: the normal force of {own.name} fell to {{value:.3g}}; orbits are "
                "followed in contact, press harder, or simulate"
            )
            found.append(Limit(f"lost contact of {own.name}", own.normal_name, 0.0, reason))
        return tuple(found)


def declared_contacts(equations: SystemEquations) -> tuple[DeclaredContact, ...]:
    """Return the contacts of a system."""
    return tuple(DeclaredContact(equations, item) for item in equations.contacts)


def _force(
    equations: SystemEquations, name: str, q: Symbols, c: Symbols, phase: Expression
) -> Expression:
    return as_symbol(equations.value(Name(name), q, c, phase))


def _symbols(equations: SystemEquations) -> tuple[Symbols, Symbols, Expression]:
    q = {name: hy.expression(name) for name in equations.rates}
    c = {key: hy.expression(f"c_{key}") for key in equations.terms}
    return q, c, hy.expression("phase")


def check_contacts(definition: Definition, equations: SystemEquations, source: Source) -> None:
    """Refuse slips and forces of which a trajectory that sticks could make nothing."""
    q, c, phase = _symbols(equations)
    contacts = declared_contacts(equations)
    names = [name for item in contacts for name in (normal_name(item.own.name), *item.given)]
    given = {name: hy.expression(name) for name in names}
    varying = {*q, str(phase), *given}
    defaults = {item.name: item.default for item in (*definition.parameters, DURATION)}
    rates = {name: as_symbol(equations.rate(name, {**q, **given}, c, phase)) for name in q}
    for item in contacts:
        name = item.own.name
        path = ("contacts", name)
        try:
            item.taken_apart.check(equations.coefficients(defaults))
        except InputError as error:
            raise source.error((*path, "friction"), str(error)) from None
        for part in item.slip(q, c, phase):
            slopes = [hy.diff(part, hy.expression(state)) for state in q]
            if not all(varying.isdisjoint(hy.get_variables(slope)) for slope in slopes):
                raise source.error(
                    (*path, "slip"),
                    f"the slip of {name} is not linear in the states; give a difference of "
                    "velocities, with parameters as factors",
                )
            if all(slope == hy.expression(0.0) for slope in slopes):
                message = f"the slip of {name} has no state in it; give e.g. Vd - v"
                raise source.error((*path, "slip"), message)
        for state, rate in rates.items():
            for force in (normal_name(name), *item.given):
                slope = hy.diff(rate, hy.expression(force))
                if not set(given).isdisjoint(hy.get_variables(slope)):
                    raise source.error(
                        ("states", state),
                        f"the rate of {state} is not linear in the forces of {name}; add them "
                        "with factors of states and parameters",
                    )
    c = equations.coefficients(defaults)
    start = {item.state.name: item.start for item in definition.states}
    for item in contacts:
        if not _slows(item, start, c, dict.fromkeys(names, 0.0)):
            name = item.own.name
            message = (
                f"the friction {name} acts along its slip and so has to slow it, but does not; "
                f"write it into the rates, with the sign that {name} has on what moves"
            )
            raise source.error(("contacts", name, "slip"), message)


def _slows(
    item: DeclaredContact,
    start: Mapping[str, float],
    c: Mapping[str, float],
    none: Mapping[str, float],
) -> bool:
    """Return whether friction acts against its own slip; `none` has every force at zero."""
    equations, trees = item.equations, item.taken_apart.slip

    def slip_rates(forces: Mapping[str, float]) -> np.ndarray:
        moved = {**start, **forces}
        rates = {name: equations.rate(name, moved, c, 0.0) for name in start}
        zero = [equations.value(tree, dict.fromkeys(start, 0.0), c, 0.0) for tree in trees]
        gone = [equations.value(tree, rates, c, 0.0) for tree in trees]
        return np.subtract(gone, zero)

    still = slip_rates(none)
    columns = [slip_rates({**none, name: 1.0}) - still for name in item.given]
    slows = np.linalg.eigvalsh(-(np.array(columns) + np.transpose(columns)) / 2)
    return bool(slows[0] > 0) or not np.isfinite(slows).all()
