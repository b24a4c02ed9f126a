r"""The equations of a mode: contacts that slip rub by their law, those that stick do not move.

What sticks needs no penalty and no multiplier in time: as many states as there are components held
follow from the others, and the friction is what keeps them so,
:math:`W M^{-1} W^T \lambda = -b`, solved in symbols for all contacts that stick together.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import heyoka as hy

from slipfold.flow.equations import Equations, build_equations, written
from slipfold.flow.switched.linear_symbols import rate_along, solve, solve_for_states
from slipfold.flow.switched.mode import Mode, Status
from slipfold.models.model import Model
from slipfold.models.output import Contact, Expression, normal_name

ZERO = hy.expression(0.0)

LOGARITHM, ANGLE = hy.expression("logarithm of slow slip"), hy.expression("angle of slow slip")
"""Slip in the plane comes to rest in finite time, while its direction, which turns faster and
faster, tends to a limit: the equations are singular there. Those of the logarithm of its speed in
m/s and of its angle are not, in a time that goes with the speed, ``dt = |v| ds``."""

COS, SIN = hy.cos(ANGLE), hy.sin(ANGLE)


class Undetermined(ValueError):
    """Contacts that stick together hold one motion twice, so what each of them bears is open."""


@dataclass(frozen=True)
class ModeEquations:
    """A model in one mode."""

    # Rates without the states that the contacts hold, and outputs, forces included
    equations: Equations
    contacts: tuple[Contact, ...]
    mode: Mode
    held: dict[str, Expression]  # the states that contacts hold, by the others
    normal: tuple[Expression, ...]  # normal force of each contact, zero if it is open
    friction: tuple[tuple[Expression, ...], ...]  # components of the friction of each contact
    # Rates of logarithm and angle of slow slip a phase, times the speed
    slow: tuple[Expression, Expression] | None = None


def contacts_of(model: Model) -> tuple[Contact, ...]:
    """Return the contacts of a model in the symbols of its equations."""
    symbols = written(model)
    return model.contacts(symbols.states, symbols.coefficients, symbols.phase)


def with_given_forces(model: Model, contacts: Sequence[Contact]) -> Equations:
    """Return the equations of a model with the forces in contacts as symbols."""
    names = [normal_name(contact.name) for contact in contacts]
    names += [name for contact in contacts for name in contact.friction_names]
    return build_equations(model, {name: hy.expression(name) for name in names})


def rate_of_phase(equations: Equations) -> dict[str, Expression]:
    """Return the rate of the phase by its name, beside those of states: slip may depend on it."""
    return {str(equations.phase): 1.0 / equations.coefficients[-1]}


def friction_given(contact: Contact, status: Status) -> dict[str, Expression]:
    """Return the forces in a contact that follow from its state; not what holds it."""
    if status is Status.OPEN:
        return dict.fromkeys((normal_name(contact.name), *contact.friction_names), ZERO)
    forces = {normal_name(contact.name): contact.normal}
    if status is Status.STICK:
        return forces
    if status is Status.SLOW:
        drag = contact.normal * contact.friction(hy.exp(LOGARITHM))
        return forces | dict(zip(contact.friction_names, (drag * COS, drag * SIN), strict=True))
    if len(contact.slip) == 1:
        sign = float(status)
        size = contact.normal * contact.friction(sign * contact.slip[0])
        return forces | {contact.friction_names[0]: sign * size}
    speed = hy.sqrt(hy.sum([part * part for part in contact.slip]))
    drag = contact.normal * contact.friction(speed) / speed
    pairs = zip(contact.friction_names, contact.slip, strict=True)
    return forces | {name: drag * part for name, part in pairs}


def mode_equations(model: Model, mode: Mode) -> ModeEquations:
    """Write the equations of a mode."""
    contacts = contacts_of(model)
    free = with_given_forces(model, contacts)
    forces: dict[str, Expression] = {}
    for contact, status in zip(contacts, mode, strict=True):
        forces |= friction_given(contact, status)
    stuck = [item for item, status in zip(contacts, mode, strict=True) if status is Status.STICK]
    slips = [part for contact in stuck for part in contact.slip]
    slow = [item for item, status in zip(contacts, mode, strict=True) if status is Status.SLOW]
    polar = [
        part - hy.exp(LOGARITHM) * along
        for item in slow
        for part, along in zip(item.slip, (COS, SIN), strict=True)
    ]
    # Velocities first: it is they that friction holds.
    held = solve_for_states([*slips, *polar], [*reversed(free.names)])
    if held is None:
        raise Undetermined(" and ".join(contact.name for contact in stuck))
    names = [name for contact in stuck for name in contact.friction_names]
    clock = rate_of_phase(free)
    rates = dict(zip(free.names, hy.subs(list(free.field), forces), strict=True))
    forces |= _holding(slips, names, rates | clock)
    rates = dict(zip(free.names, hy.subs(list(free.field), forces), strict=True))
    turning = _turning(slow, rates | clock, free, held)
    rates |= {name: rate_along(value, rates | clock) for name, value in held.items()}
    outputs = hy.subs([item for _, item in free.outputs], forces)
    friction = tuple(tuple(forces[name] for name in item.friction_names) for item in contacts)
    normal = tuple(forces[normal_name(item.name)] for item in contacts)
    equations = replace(
        free,
        field=tuple(hy.subs(list(rates.values()), held)),
        outputs=tuple(
            (name, item)
            for (name, _), item in zip(free.outputs, hy.subs(outputs, held), strict=True)
        ),
    )
    return ModeEquations(
        equations,
        contacts,
        mode,
        held,
        tuple(hy.subs(list(normal), held)),
        tuple(tuple(hy.subs(list(item), held)) for item in friction),
        turning,
    )


def _turning(
    slow: Sequence[Contact],
    rates: dict[str, Expression],
    free: Equations,
    held: dict[str, Expression],
) -> tuple[Expression, Expression] | None:
    """Return the rates of logarithm and angle of slow slip, times its speed."""
    if not slow:
        return None
    x, y = (free.coefficients[-1] * rate_along(part, rates) for part in slow[0].slip)
    grows, turns = hy.subs([COS * x + SIN * y, COS * y - SIN * x], held)
    return grows, turns


def _holding(
    slips: Sequence[Expression], names: Sequence[str], rates: dict[str, Expression]
) -> dict[str, Expression]:
    """Return the friction by name that keeps slips from changing."""
    if not slips:
        return {}
    changes = [rate_along(slip, rates) for slip in slips]
    matrix = [[hy.diff(change, hy.expression(name)) for name in names] for change in changes]
    alone = hy.subs(changes, dict.fromkeys(names, ZERO))
    return dict(zip(names, solve(matrix, [-item for item in alone]), strict=True))
