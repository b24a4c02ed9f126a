"""What follows from the contacts of a system of equations: outputs, limits, where motions stick."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

import heyoka as hy
import numpy as np

from slipfold.errors import InputError
from slipfold.models.definitions.contacts import ContactEquations, ContactFormulas
from slipfold.models.definitions.definition import Definition
from slipfold.models.definitions.equations import SystemEquations
from slipfold.models.definitions.source import Source
from slipfold.models.formulas.grammar import Name
from slipfold.models.formulas.values import as_symbol
from slipfold.models.friction.law import FrictionLaw
from slipfold.models.output import (
    Contact,
    Expression,
    Limit,
    Output,
    Symbols,
    friction_name,
    normal_name,
)
from slipfold.models.parameter import DURATION

STICK = 0.01
"""Slip speed over the counter-body's speed at which a branch ends."""


def contacts_of_system(
    equations: SystemEquations, q: Symbols, c: Symbols, phase: Expression
) -> tuple[Contact, ...]:
    """Return the contacts of a system as motions that stick need them."""
    found = []
    for item in equations.contacts:
        law, values = item.formulas.law, item.law_values(c)
        found.append(
            Contact(
                item.formulas.name,
                _slip(equations, item, q, c, phase),
                _plate(equations, item, c, phase),
                as_symbol(equations.value(item.normal, q, c, phase)),
                friction=partial(_coefficient, law, values),
                holding=as_symbol(law.holding(values)),
                opens=_opens(equations, item),
                limits=tuple(limit.name for limit in _limits(equations, item)),
            )
        )
    return tuple(found)


def _coefficient(law: FrictionLaw, values: Symbols, speed: Expression) -> Expression:
    return as_symbol(law.formula(speed, values))


def contact_outputs(equations: SystemEquations) -> tuple[Output, ...]:
    """Return forces and speed of slip of each contact."""
    found = []
    for item in equations.contacts:
        own = item.formulas
        for force in own.forces:
            doc = f"friction in {own.name}"
            found.append(Output(force, partial(_force, equations, force), doc=doc))
        doc = f"normal force of {own.name}"
        normal = partial(_force, equations, own.normal_name)
        found.append(Output(own.normal_name, normal, doc=doc))
        doc = f"speed of slip in {own.name}"
        found.append(Output(own.speed_name, partial(_speed, equations, item), doc=doc))
        if _moves(equations, item):
            doc = f"speed of slip in {own.name} over that of its counter-body"
            found.append(Output(own.ratio_name, partial(_ratio, equations, item), doc=doc))
    return tuple(found)


def contact_limits(equations: SystemEquations) -> tuple[Limit, ...]:
    """Return where branches, which are followed in slip, end."""
    return tuple(limit for item in equations.contacts for limit in _limits(equations, item))


def contacts_at_rest(equations: SystemEquations, values: Mapping[str, float]) -> tuple[str, ...]:
    """Return the names of contacts whose counter-bodies do not move steadily."""
    c, still = equations.coefficients(values), dict.fromkeys(equations.rates, 0.0)
    return tuple(
        item.formulas.name
        for item in equations.contacts
        if not _moves(equations, item)
        or not any(equations.value(tree, still, c, 0.0) for tree in item.slip)
    )


def _limits(equations: SystemEquations, item: ContactEquations) -> list[Limit]:
    own, found = item.formulas, []
    if _moves(equations, item):
        reason = (
            f"stick: the speed of slip in {own.name} fell to {{value:.3g}} of that of its "
            "counter-body; orbits are followed in slip, stay below this value, or simulate"
        )
        found.append(Limit(f"stick of {own.name}", own.ratio_name, STICK, reason))
    if _opens(equations, item):
        reason = (
            f"lost contact: the normal force of {own.name} fell to {{value:.3g}}; orbits are "
            "followed in contact, press harder, or simulate"
        )
        found.append(Limit(f"lost contact of {own.name}", own.normal_name, 0.0, reason))
    return found


def _slip(
    equations: SystemEquations, item: ContactEquations, q: Symbols, c: Symbols, phase: Expression
) -> tuple[Expression, ...]:
    return tuple(as_symbol(equations.value(tree, q, c, phase)) for tree in item.slip)


def _plate(
    equations: SystemEquations, item: ContactEquations, c: Symbols, phase: Expression
) -> tuple[Expression, ...]:
    """Return the velocity of the counter-body: slip where nothing else moves."""
    return _slip(equations, item, dict.fromkeys(equations.rates, 0.0), c, phase)


def _force(
    equations: SystemEquations, name: str, q: Symbols, c: Symbols, phase: Expression
) -> Expression:
    return as_symbol(equations.value(Name(name), q, c, phase))


def _speed(
    equations: SystemEquations, item: ContactEquations, q: Symbols, c: Symbols, phase: Expression
) -> Expression:
    parts = _slip(equations, item, q, c, phase)
    return hy.sqrt(hy.sum([part * part for part in parts]))


def _ratio(
    equations: SystemEquations, item: ContactEquations, q: Symbols, c: Symbols, phase: Expression
) -> Expression:
    plate = _plate(equations, item, c, phase)
    driven = hy.sqrt(hy.sum([part * part for part in plate]))
    return _speed(equations, item, q, c, phase) / driven


def _moves(equations: SystemEquations, item: ContactEquations) -> bool:
    """Whether the counter-body moves steadily, at some parameter values."""
    _, c, phase = _symbols(equations)
    plate = _plate(equations, item, c, phase)
    steady = str(phase) not in hy.get_variables(list(plate))
    return steady and any(part != hy.expression(0.0) for part in plate)


def _opens(equations: SystemEquations, item: ContactEquations) -> bool:
    """Whether the normal force varies, and so may vanish."""
    q, c, phase = _symbols(equations)
    normal = as_symbol(equations.value(item.normal, q, c, phase))
    return not set(hy.get_variables(normal)).isdisjoint((*q, str(phase)))


def _symbols(equations: SystemEquations) -> tuple[Symbols, Symbols, Expression]:
    q = {name: hy.expression(name) for name in equations.rates}
    c = {key: hy.expression(f"c_{key}") for key in equations.terms}
    return q, c, hy.expression("phase")


def check_contacts(definition: Definition, equations: SystemEquations, source: Source) -> None:
    """Refuse slips and forces of which a motion that sticks could make nothing."""
    q, c, phase = _symbols(equations)
    given = {
        name: hy.expression(name)
        for item in definition.contacts
        for name in (normal_name(item.name), *_given(item))
    }
    varying = {*q, str(phase), *given}
    defaults = {item.name: item.default for item in (*definition.parameters, DURATION)}
    rates = {name: as_symbol(equations.rate(name, {**q, **given}, c, phase)) for name in q}
    for item in equations.contacts:
        own = item.formulas
        path = ("contacts", own.name)
        try:
            item.check(equations.coefficients(defaults))
        except InputError as error:
            raise source.error((*path, "friction"), str(error)) from None
        for part in _slip(equations, item, q, c, phase):
            slopes = [hy.diff(part, hy.expression(name)) for name in q]
            if not all(varying.isdisjoint(hy.get_variables(slope)) for slope in slopes):
                raise source.error(
                    (*path, "slip"),
                    f"the slip of {own.name} is not linear in the states; give a difference of "
                    "velocities, with parameters as factors",
                )
            if all(slope == hy.expression(0.0) for slope in slopes):
                raise source.error(
                    (*path, "slip"),
                    f"the slip of {own.name} has no state in it; give e.g. Vd - v",
                )
        for name, rate in rates.items():
            for force in (normal_name(own.name), *_given(own)):
                slope = hy.diff(rate, hy.expression(force))
                if not set(given).isdisjoint(hy.get_variables(slope)):
                    raise source.error(
                        ("states", name),
                        f"the rate of {name} is not linear in the forces of {own.name}; add them "
                        "with factors of states and parameters",
                    )
    _check_sense(definition, equations, source)


def _check_sense(definition: Definition, equations: SystemEquations, source: Source) -> None:
    """Refuse friction that drives its own slip, or does not act on it."""
    values = {item.name: item.default for item in (*definition.parameters, DURATION)}
    c = equations.coefficients(values)
    start = {item.state.name: item.start for item in definition.states}
    none = {
        name: 0.0
        for item in definition.contacts
        for name in (normal_name(item.name), *_given(item))
    }

    def slip_rates(item: ContactEquations, forces: dict[str, float]) -> np.ndarray:
        moved = {**start, **forces}
        rates = {name: equations.rate(name, moved, c, 0.0) for name in start}
        zero = [equations.value(tree, dict.fromkeys(start, 0.0), c, 0.0) for tree in item.slip]
        gone = [equations.value(tree, rates, c, 0.0) for tree in item.slip]
        return np.subtract(gone, zero)

    for item in equations.contacts:
        own = item.formulas
        still = slip_rates(item, none)
        columns = [slip_rates(item, {**none, name: 1.0}) - still for name in _given(own)]
        slows = np.linalg.eigvalsh(-(np.array(columns) + np.transpose(columns)) / 2)
        if np.isfinite(slows).all() and not slows[0] > 0:
            message = (
                f"the friction {own.name} acts along its slip and so has to slow it, but does not; "
                f"write it into the rates, with the sign that {own.name} has on what moves"
            )
            raise source.error(("contacts", own.name, "slip"), message)


def _given(own: ContactFormulas) -> list[str]:
    return [friction_name(own.name, axis) for axis in range(len(own.slip))]
