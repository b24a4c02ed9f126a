"""Contacts at an instant: slips, forces, and the next mode."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise, product
from typing import NamedTuple

import heyoka as hy
import numpy as np

from slipfold.arrays import Array
from slipfold.errors import InputError
from slipfold.flow.compiled_code import StateFunction
from slipfold.flow.equations import Constants, Equations
from slipfold.flow.modes import CONTACT, Mode, Status, rate_along, rate_of_phase
from slipfold.models.friction.contact import Contact, normal_name
from slipfold.models.quantities import Expression

Numbers = list[float]


HARDLY = 2.0**-8
"""Slip, over what a phase without any friction would add to it, below which it is no scale."""


class ContactsNow(NamedTuple):
    """All contacts at a state; m components of slip, k contacts, in SI units.

    For so few numbers a list is faster than an array.
    """

    slip: Numbers  # velocity of the moving surfaces relative to the bodies, m of them
    free: Numbers  # its rate without any force in a contact, m
    by_friction: list[Numbers]  # change of that rate with each component of friction, m rows of m
    by_normal: list[Numbers]  # and with each normal force, m rows of k
    normal: Numbers  # normal forces, k
    kinetic: Numbers  # friction in slip at the present speed, k
    starting: Numbers  # friction at the onset of slip, k
    holding: Numbers  # friction up to which contacts stick, k
    plate: Numbers  # velocity of the moving surfaces, m


class ContactQuantities:
    """Evaluates slips and forces, which decide on the next mode."""

    def __init__(self, contacts: Sequence[Contact], equations: Equations) -> None:
        ends = np.cumsum([0, *(len(contact.slip) for contact in contacts)])
        # Components of each contact
        self.places = tuple(slice(*pair) for pair in pairwise(ends))
        k, m = len(contacts), int(ends[-1])
        sizes = [m, m, *[m] * m, *[k] * m, k, k, k, k, m]
        borders = np.cumsum([0, *sizes])
        self._parts = [slice(*pair) for pair in pairwise(borders.tolist())]
        self._components = m
        expressions = _expressions(contacts, equations)
        self._function = StateFunction("contacts", expressions, equations)

    def at(self, state: Array, phase: float, constants: Constants) -> ContactsNow:
        """Evaluate at a state. Shapes: state (n,)."""
        return self._sorted(self._function.at(state, phase, constants).tolist())

    def along(self, states: Array, phases: Array, constants: Constants) -> list[ContactsNow]:
        """Evaluate at many states. Shapes: states (p, n); phases (p,)."""
        values = self._function.along(states, phases, constants)
        return [self._sorted(row) for row in values.tolist()]

    def sizes(self, states: Array, constants: Constants) -> tuple[Array, Array]:
        """Return slip of contacts and the friction that holds them, (p, k), at states (p, n)."""
        values = np.abs(self._function.along(states, np.zeros(len(states)), constants))
        begins = [part.start for part in self.places]
        slips, gained = (
            np.hypot.reduceat(values[:, self._parts[part]], begins, axis=1) for part in (0, 1)
        )
        # Of a contact that has hardly slipped so far, slip is known to rounding of other motions
        hardly = HARDLY * constants.period * gained
        return np.maximum(slips, hardly), values[:, self._parts[-2]]

    def _sorted(self, values: Numbers) -> ContactsNow:
        result, m = [values[part] for part in self._parts], self._components
        matrices = result[2 : 2 + m], result[2 + m : 2 + 2 * m]
        return ContactsNow(result[0], result[1], *matrices, *result[2 + 2 * m :])


def _expressions(contacts: Sequence[Contact], equations: Equations) -> list[Expression]:
    normals = [normal_name(contact.name) for contact in contacts]
    forces = [name for contact in contacts for name in contact.friction_names]
    nothing = dict.fromkeys((*normals, *forces), hy.expression(0.0))
    rates = dict(zip(equations.names, equations.field, strict=True)) | rate_of_phase(equations)
    slips = [part for contact in contacts for part in contact.slip]
    changes = [rate_along(slip, rates) for slip in slips]
    result = [*slips, *hy.subs(changes, nothing)]
    for names in (forces, normals):
        result += [hy.diff(change, hy.expression(name)) for change in changes for name in names]
    result += [contact.normal for contact in contacts]
    for contact in contacts:
        speed = contact.slip[0] if len(contact.slip) == 1 else None
        square = hy.sum([part * part for part in contact.slip])
        size = hy.sqrt(square) if speed is None else hy.select(hy.gt(speed, 0.0), speed, -speed)
        result.append(contact.normal * contact.friction(size))
    result += [contact.normal * contact.friction(hy.expression(0.0)) for contact in contacts]
    result += [contact.normal * contact.holding for contact in contacts]
    return result + [hy.expression(0.0) + part for contact in contacts for part in contact.plate]


class Undecided(ArithmeticError):
    """No mode is consistent with the forces."""


@dataclass(eq=False)
class Instant:
    """Contacts at an instant, some of them at rest."""

    now: ContactsNow
    places: Sequence[slice]  # components of each contact
    rest: tuple[int, ...]  # contacts without slip, whose next status is open
    moving: Mode  # status of each contact, ignored of those at rest

    def forces(
        self, mode: Mode, given: Mapping[int, Numbers] | None = None
    ) -> tuple[Numbers, Numbers]:
        """Return friction and rates of slip if the contacts continue in a mode.

        Friction in contacts that slip may be given.
        """
        now, rows = self.now, range(len(self.now.slip))
        friction, rates = [0.0] * len(rows), list(now.free)
        stuck = list[int]()
        for contact, (status, components) in enumerate(zip(mode, self.places, strict=True)):
            if status is Status.OPEN:
                continue
            for row in rows:
                rates[row] += now.by_normal[row][contact] * now.normal[contact]
            if status is Status.STICK:
                stuck += range(components.start, components.stop)
                continue
            known = (given or {}).get(contact)
            forces = self._sliding(contact, status, components) if known is None else known
            friction[components] = forces
            for column, force in enumerate(forces, components.start):
                for row in rows:
                    rates[row] += now.by_friction[row][column] * force
        if stuck:
            matrix = [[now.by_friction[row][column] for column in stuck] for row in stuck]
            try:
                held = _solved(matrix, [-rates[row] for row in stuck])
            except (ZeroDivisionError, np.linalg.LinAlgError):
                count = sum(status is Status.STICK for status in mode)
                raise InputError(
                    f"too many contacts would stick at once: fewer than these {count} hold all "
                    "that moves, so that their forces are not determined; give one contact in "
                    "place of those along one direction, or Regularized laws"
                ) from None
            for column, force in zip(stuck, held, strict=True):
                friction[column] = force
                for row in rows:
                    rates[row] += now.by_friction[row][column] * force
            for row in stuck:
                rates[row] = 0.0
        return friction, rates

    def _sliding(self, contact: int, status: Status, components: slice) -> Numbers:
        """Return the friction of a contact that slips."""
        now, starts = self.now, contact in self.rest
        size = (now.starting if starts else now.kinetic)[contact]
        if components.stop - components.start == 1:
            forth = status is Status.FORTH if starts else now.slip[components.start] > 0
            return [size if forth else -size]
        along = (self._borne if starts else now.slip)[components]
        length = math.hypot(*along)
        return [size * part / length if length else math.nan for part in along]

    @cached_property
    def _borne(self) -> Numbers:
        """Friction if all contacts at rest stick."""
        changes = dict.fromkeys(self.rest, Status.STICK)
        return self.forces(changed(self.moving, changes))[0]

    def response(self, mode: Mode, contact: int) -> tuple[Numbers, list[Numbers]]:
        """Return a contact's rate of slip without its friction, and its change with that.

        Other contacts keep their mode; those that stick have the friction they need.
        """
        components = self.places[contact]
        size = range(components.stop - components.start)
        alone = self.forces(mode, {contact: [0.0 for _ in size]})[1][components]
        columns = [
            self.forces(mode, {contact: [float(i == axis) for i in size]})[1][components]
            for axis in size
        ]
        return alone, [[column[row] - alone[row] for column in columns] for row in size]

    def next_mode(self, wanted: Mapping[int, Status]) -> Mode:
        """Return the mode in which contacts continue; `wanted` is the next status of some.

        Stick has priority over slip in reverse: a contact stops where friction can hold it.
        """
        seen = set[Mode]()
        trial = changed(self.moving, wanted)
        while trial not in seen:
            seen.add(trial)
            wrong = self.violations(trial)
            if not wrong:
                return trial
            # One at a time, the last first: the release of one changes the forces of others.
            worst = max(wrong)
            trial = changed(trial, {worst: wrong[worst]})
        for candidate in self._all():
            if candidate not in seen and not self.violations(candidate):
                return candidate
        raise Undecided("no state of its contacts agrees with the forces in them")

    def _all(self) -> Iterator[Mode]:
        """Yield all modes, those with most sticking contacts first."""
        if len(self.rest) > 7:  # too many combinations to try
            return
        planar = (Status.STICK, Status.SLOW)
        straight = (Status.STICK, Status.FORTH, Status.BACK)
        sizes = [self.places[item].stop - self.places[item].start for item in self.rest]
        choices = product(*(planar if size == 2 else straight for size in sizes))
        for chosen in sorted(choices, key=lambda mode: -mode.count(Status.STICK)):
            yield changed(self.moving, dict(zip(self.rest, chosen, strict=True)))

    def violations(self, mode: Mode) -> dict[int, Status]:
        """Return the contacts at rest that cannot keep their status, and the next one."""
        friction, rates = self.forces(mode)
        result = {}
        for contact in self.rest:
            components, limit = self.places[contact], self.now.holding[contact]
            if mode[contact] is Status.STICK:
                if math.hypot(*friction[components]) > limit * (1 + CONTACT.slack):
                    planar = components.stop - components.start == 2
                    straight = Status.FORTH if friction[components.start] > 0 else Status.BACK
                    result[contact] = Status.SLOW if planar else straight
            elif mode[contact] is Status.SLOW:
                alone, change = self.response(mode, contact)
                start = self.now.starting[contact]
                away = outward(alone, change, start)[1]
                if away < -CONTACT.slack * largest(change) * limit:
                    result[contact] = Status.STICK
            else:
                size = abs(self.now.by_friction[components.start][components.start]) * limit
                if float(mode[contact]) * rates[components.start] < -CONTACT.slack * size:
                    result[contact] = Status.STICK
        return result


def outward(alone: Numbers, change: list[Numbers], size: float) -> tuple[Numbers, float]:
    """Return the direction in which slip in the plane begins, and its rate of growth.

    Slip grows along itself, ``s' = k e`` with friction ``size e``.
    """
    (a, b), (c, d) = change
    x, y = _solved(change, [-part for part in alone])
    angle = math.atan2(y, x)
    for _ in range(50):  # three steps are enough
        cos, sin = math.cos(angle), math.sin(angle)
        u, v = alone[0] + size * (a * cos + b * sin), alone[1] + size * (c * cos + d * sin)
        across = size * (sin * (a * sin - b * cos) - cos * (c * sin - d * cos))
        step = (cos * v - sin * u) / (across - (cos * u + sin * v))
        angle -= step
        if abs(step) < 1e-15:
            break
    cos, sin = math.cos(angle), math.sin(angle)
    u, v = alone[0] + size * (a * cos + b * sin), alone[1] + size * (c * cos + d * sin)
    return [cos, sin], cos * u + sin * v


def largest(matrix: list[Numbers]) -> float:
    """Return the largest absolute entry."""
    return max(abs(entry) for row in matrix for entry in row)


def _solved(matrix: list[Numbers], right: Numbers) -> Numbers:
    """Solve linear equations; for one or two a library call would dominate the time."""
    if len(right) == 1:
        return [right[0] / matrix[0][0]]
    if len(right) == 2:
        (a, b), (c, d) = matrix
        e, f = right
        size = a * d - b * c
        return [(d * e - b * f) / size, (a * f - c * e) / size]
    return [float(part) for part in np.linalg.solve(matrix, right)]


def changed(mode: Mode, changes: Mapping[int, Status]) -> Mode:
    """Return a mode in which some contacts have another status."""
    if not changes:
        return mode
    return tuple(changes.get(components, status) for components, status in enumerate(mode))
