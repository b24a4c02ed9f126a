"""What decides how contacts go on, in numbers: slips, what changes them, and what friction can."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import heyoka as hy
import numpy as np

from slipfold.arrays import Array
from slipfold.flow.cache import cached
from slipfold.flow.equations import Constants, Equations
from slipfold.flow.switched.arguments import Arguments, many
from slipfold.flow.switched.linear_symbols import rate_along
from slipfold.flow.switched.mode_equations import rate_of_phase
from slipfold.models.evaluation import compiled_function
from slipfold.models.output import Contact, Expression, normal_name

Numbers = list[float]


class ContactsNow(NamedTuple):
    """All contacts at a state; m components of slip, k contacts, in SI units.

    They are few numbers, of which a list is quicker than an array.
    """

    slip: Numbers  # velocity of the counter-bodies relative to the bodies, m of them
    free: Numbers  # its rate without any force in a contact, m
    by_friction: list[Numbers]  # change of that rate with each component of friction, m rows of m
    by_normal: list[Numbers]  # and with each normal force, m rows of k
    normal: Numbers  # normal forces, k
    kinetic: Numbers  # friction in slip at the present speed, k
    starting: Numbers  # friction in slip at no speed yet, k
    holding: Numbers  # friction up to which contacts stick, k
    plate: Numbers  # velocity of the counter-bodies, m


class ContactQuantities:
    """Evaluates what decides how contacts go on."""

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
        inputs = [*equations.states, equations.phase, *equations.coefficients]
        key = f"contacts {[str(item) for item in expressions]}\n{equations.fingerprint()}"
        self._function: Any = cached(key, lambda: compiled_function(expressions, inputs))
        self._arguments = Arguments()

    def at(self, state: Array, phase: float, constants: Constants) -> ContactsNow:
        """Evaluate at a state. Shapes: state (n,)."""
        return self._sorted(self._function(self._arguments.of(state, phase, constants)).tolist())

    def along(self, states: Array, phases: Array, constants: Constants) -> list[ContactsNow]:
        """Evaluate at many states. Shapes: states (p, n); phases (p,)."""
        values = self._function(many(states, phases, constants))
        return [self._sorted(row) for row in values.T.tolist()]

    def _sorted(self, values: Numbers) -> ContactsNow:
        found, m = [values[part] for part in self._parts], self._components
        matrices = found[2 : 2 + m], found[2 + m : 2 + 2 * m]
        return ContactsNow(found[0], found[1], *matrices, *found[2 + 2 * m :])


def _expressions(contacts: Sequence[Contact], equations: Equations) -> list[Expression]:
    normals = [normal_name(contact.name) for contact in contacts]
    forces = [name for contact in contacts for name in contact.friction_names]
    nothing = dict.fromkeys((*normals, *forces), hy.expression(0.0))
    rates = dict(zip(equations.names, equations.field, strict=True)) | rate_of_phase(equations)
    slips = [part for contact in contacts for part in contact.slip]
    changes = [rate_along(slip, rates) for slip in slips]
    found = [*slips, *hy.subs(changes, nothing)]
    for names in (forces, normals):
        found += [hy.diff(change, hy.expression(name)) for change in changes for name in names]
    found += [contact.normal for contact in contacts]
    for contact in contacts:
        speed = contact.slip[0] if len(contact.slip) == 1 else None
        square = hy.sum([part * part for part in contact.slip])
        size = hy.sqrt(square) if speed is None else hy.select(hy.gt(speed, 0.0), speed, -speed)
        found.append(contact.normal * contact.friction(size))
    found += [contact.normal * contact.friction(hy.expression(0.0)) for contact in contacts]
    found += [contact.normal * contact.holding for contact in contacts]
    return found + [hy.expression(0.0) + part for contact in contacts for part in contact.plate]
