"""Modes of contacts that slip, stick and open: their equations, and the events that end them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from enum import Enum, IntEnum
from functools import cache

import heyoka as hy

from slipfold.flow.batches import TOLERANCE
from slipfold.flow.compiled_code import numbers_of, shared_by_kind
from slipfold.flow.equations import Equations, build_equations, model_symbols
from slipfold.models.friction.contact import Contact, normal_name
from slipfold.models.model import Model
from slipfold.models.quantities import Expression, Limit


class Status(IntEnum):
    """Status of a contact."""

    BACK = -1  # along a line: slips backwards
    STICK = 0
    FORTH = 1  # slips: forwards along a line, or in any direction in the plane
    OPEN = 2  # without contact force
    SLOW = 3  # slips slowly in the plane, which is integrated in other variables

    __hash__ = int.__hash__  # faster than that of an enum: modes are dictionary keys


class CONTACT:
    """Tolerances of stick and slip; slip is over its scale."""

    rest: float = 1e-13  # slip in the plane below which slip ends
    slow: float = 0.05  # slip in the plane below which its logarithm and angle are integrated
    grazing: float = 1e-7  # slip that counts as zero if its direction turns too fast to continue
    # Unit of logarithms that are states, so that they do not dominate the error of a step
    unit: float = 64.0
    slack: float = 1e-11  # rounding error of a limit of friction, as a fraction of it
    # An event triggers this far beyond zero, since slip is exactly zero where a mode begins
    event_distance: float = TOLERANCE / 10
    max_steps: int = 20_000  # of the integrator between two changes
    max_changes: int = 10_000  # in a forcing period
    forever: float = 1e30  # end of the rescaled time in slow slip
    # Onset of slip in the plane: a phase after which a force has grown measurably, and the slip up
    # to which the onset may last
    short: float = 1e-6
    # Minimum rate of slip, over that from friction alone, at which slip begins at once
    immediate_rate: float = 1e-3
    immediate_phase: float = 1e-13  # duration of such an onset, in phases
    longest_phase: float = 0.01  # maximum duration of any other onset
    shrink_factor: float = 0.3  # factor of a duration that was too long
    # Number of decreasing terms of the series of slip at its end: slip is then fast enough not to
    # be stiff
    terms: float = 25.0
    # Last step of Newton's method: slip at the first point is 1e-4 of that at the last
    last_step: float = 1e-15
    iterations: int = 12
    renewal_ratio: float = 0.1  # ratio of two steps above which derivatives are computed again
    # Fraction of slow slip that a linearization leaves out before rest, where it is singular, and
    # the first slip after rest: the effect is of second order
    linearized: float = 1e-9


CONTACT_NUMBERS = numbers_of(CONTACT)

Mode = tuple[Status, ...]
"""Status of each contact."""

STUCK: Mode = (Status.STICK,)
"""The mode of stick of a single contact."""


@cache
def reported_mode(mode: Mode) -> Mode:
    """Return a mode without the distinction of slow slip."""
    return tuple(Status.FORTH if status is Status.SLOW else status for status in mode)


def status_name(status: int) -> str:
    """Return the name of a status."""
    return _NAMES.get(status, "slip")


_NAMES: dict[int, str] = {Status.STICK: "stick", Status.OPEN: "free"}


def is_zero(expression: Expression) -> bool:
    """Whether it is the number zero."""
    return bool(expression == hy.expression(0.0))


def rate_along(value: Expression, rates: Mapping[str, Expression]) -> Expression:
    """Return the rate of a function of states and phase from their rates."""
    terms = []
    for name, rate in rates.items():
        slope = hy.diff(value, hy.expression(name))
        if not is_zero(slope):
            terms.append(slope * rate)
    return hy.sum(terms) if terms else hy.expression(0.0)


def solve(matrix: Sequence[Sequence[Expression]], right: Sequence[Expression]) -> list[Expression]:
    """Solve equations with a definite matrix, which needs no pivots."""
    rows = [[*row, value] for row, value in zip(matrix, right, strict=True)]
    size = len(rows)
    for index in range(size):
        for below in range(index + 1, size):
            if not is_zero(rows[below][index]):
                factor = rows[below][index] / rows[index][index]
                rows[below] = [
                    low - factor * high for low, high in zip(rows[below], rows[index], strict=True)
                ]
    result: list[Expression] = [None] * size
    for index in reversed(range(size)):
        known = rows[index][size]
        for after in range(index + 1, size):
            if not is_zero(rows[index][after]):
                known = known - rows[index][after] * result[after]
        result[index] = known / rows[index][index]
    return result


def solve_for_states(
    zeros: Sequence[Expression], names: Sequence[str]
) -> dict[str, Expression] | None:
    """Solve for the states at which linear functions vanish, one state per function.

    None if the functions are linearly dependent.
    """
    result: dict[str, Expression] = {}
    for zero in zeros:
        value = hy.subs(zero, result)
        for name in names:
            slope = hy.diff(value, hy.expression(name))
            if not is_zero(slope):
                break
        else:
            return None
        rest = hy.subs(value, {name: hy.expression(0.0)})
        solved = {name: -rest / slope}
        result = {key: hy.subs(item, solved) for key, item in result.items()} | solved
    return result


ZERO = hy.expression(0.0)

LOGARITHM, ANGLE = hy.expression("logarithm of slow slip"), hy.expression("angle of slow slip")
"""Slip in the plane reaches zero in finite time. Its direction turns ever faster and tends to a
limit, so the equations are singular there. The equations of the logarithm of its speed in m/s and
of its angle are regular in a time s with ``dt = |v| ds``."""

COS, SIN = hy.cos(ANGLE), hy.sin(ANGLE)


class UndeterminedMode(ArithmeticError):
    """Sticking contacts constrain one degree of freedom twice: their forces are undetermined."""


@dataclass(frozen=True)
class ModeEquations:
    """A model in one mode."""

    # Rates and outputs, with the forces and the held states inserted
    equations: Equations
    contacts: tuple[Contact, ...]
    mode: Mode
    held: dict[str, Expression]  # states that contacts hold, as functions of the others
    normal: tuple[Expression, ...]  # normal force of each contact, zero if it is open
    friction: tuple[tuple[Expression, ...], ...]  # components of the friction of each contact
    # Rates of logarithm and angle of slow slip a phase, times the speed
    slow: tuple[Expression, Expression] | None = None


@shared_by_kind
def contacts_of(model: Model) -> tuple[Contact, ...]:
    """Return the contacts of a model in the symbols of its equations."""
    symbols = model_symbols(model)
    return model.contacts(symbols.states, symbols.coefficients, symbols.phase)


def limits_of_contacts(model: Model) -> set[str]:
    """Return the names of limits at which contacts stick or open, so that trajectories go on."""
    return {name for contact in contacts_of(model) for name in contact.limits}


def with_given_forces(model: Model, contacts: Sequence[Contact]) -> Equations:
    """Return the equations of a model with the forces in contacts as symbols."""
    names = [normal_name(contact.name) for contact in contacts]
    names += [name for contact in contacts for name in contact.friction_names]
    return build_equations(model, {name: hy.expression(name) for name in names})


def rate_of_phase(equations: Equations) -> dict[str, Expression]:
    """Return the rate of the phase by its name, since slip may depend on it."""
    return {str(equations.phase): 1.0 / equations.coefficients[-1]}


def friction_given(contact: Contact, status: Status) -> dict[str, Expression]:
    """Return the forces in a contact that follow from the state, without those that hold it."""
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
    # Velocities first, since friction holds them.
    held = solve_for_states([*slips, *polar], [*reversed(free.names)])
    if held is None:
        raise UndeterminedMode(" and ".join(contact.name for contact in stuck))
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
    """Return the friction by name that keeps slips constant."""
    if not slips:
        return {}
    changes = [rate_along(slip, rates) for slip in slips]
    matrix = [[hy.diff(change, hy.expression(name)) for name in names] for change in changes]
    alone = hy.subs(changes, dict.fromkeys(names, ZERO))
    return dict(zip(names, solve(matrix, [-item for item in alone]), strict=True))


PHASE, END = hy.expression("phase in slow slip"), hy.expression("requested phase")
"""In slow slip the phase is a state, and an event ends the integration."""


class Ending(Enum):
    """Why a smooth phase ends."""

    STOPS = "slip comes to an end"
    SLOWS = "slip in the plane becomes slow"
    QUICKENS = "it becomes fast again"
    ARRIVES = "the requested phase"
    YIELDS = "friction cannot hold any more"
    PARTS = "the normal force vanishes"
    MEETS = "the contact closes"
    LIMIT = "a limit of the model is met"
    STIFF = "too many steps"
    SINGULAR = "no number"


@dataclass(frozen=True)
class SwitchingEvent:
    """An event that may end a mode."""

    ending: Ending
    which: int  # number of the contact, or of the limit
    expression: Expression  # zero there
    rising: bool = False  # whether the expression rises through zero
    towards: Status = Status.FORTH  # next status of a contact that yields
    scaled: bool = False  # whether the expression is scaled already


def events_of(
    mode: ModeEquations, limits: Sequence[Limit], slips: Sequence[Expression]
) -> tuple[SwitchingEvent, ...]:
    """Return the events of a mode; `slips` are one over the scales of slips."""
    result = []
    for which, (contact, status) in enumerate(zip(mode.contacts, mode.mode, strict=True)):
        if status is Status.OPEN:
            normal = hy.subs(contact.normal, mode.held)
            result.append(SwitchingEvent(Ending.MEETS, which, normal, rising=True))
            continue
        if contact.opens:
            result.append(SwitchingEvent(Ending.PARTS, which, mode.normal[which]))
        if status is Status.STICK:
            most = mode.normal[which] * hy.subs(contact.holding, mode.held)
            friction = mode.friction[which]
            if len(friction) == 2:
                left = most - hy.sum([part * part for part in friction]) / most
                result.append(SwitchingEvent(Ending.YIELDS, which, left, towards=Status.SLOW))
                continue
            result.append(SwitchingEvent(Ending.YIELDS, which, most - friction[0]))
            result.append(
                SwitchingEvent(Ending.YIELDS, which, most + friction[0], towards=Status.BACK)
            )
        elif status is Status.SLOW:
            result += _slow_events(which, slips[which])
        elif len(contact.slip) == 2:
            square = hy.subs(hy.sum([part * part for part in contact.slip]), mode.held)
            level = slips[which] ** 2.0 * square - CONTACT.slow**2
            result.append(SwitchingEvent(Ending.SLOWS, which, level, scaled=True))
        else:
            slip = hy.subs(contact.slip[0], mode.held)
            result.append(SwitchingEvent(Ending.STOPS, which, slip, rising=status is Status.BACK))
    outputs = dict(mode.equations.outputs)
    return (
        *result,
        *(
            SwitchingEvent(Ending.LIMIT, index, outputs[limit.output] - limit.bound)
            for index, limit in enumerate(limits)
        ),
    )


def _slow_events(which: int, slip: Expression) -> list[SwitchingEvent]:
    """Return the events of slow slip: its end, its return to fast slip, and the requested phase."""
    logarithm = LOGARITHM + hy.log(slip)
    return [
        SwitchingEvent(
            Ending.STOPS, which, (logarithm - math.log(CONTACT.rest)) / CONTACT.unit, scaled=True
        ),
        SwitchingEvent(
            Ending.QUICKENS,
            which,
            (logarithm - math.log(2 * CONTACT.slow)) / CONTACT.unit,
            rising=True,
            scaled=True,
        ),
        SwitchingEvent(Ending.ARRIVES, which, PHASE - END, rising=True, scaled=True),
    ]


GRAZED = {
    "GRAZE": (Ending.STOPS, Ending.SLOWS, Ending.YIELDS),
    "LIFT": (Ending.PARTS, Ending.MEETS),
}
"""Events that are grazed at a place where contacts begin or cease to do something."""

MET = (*GRAZED, "STICK")
"""Types of loci on which a change of contacts is only just met."""
