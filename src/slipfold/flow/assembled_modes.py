r"""Modes of many contacts, assembled from matrices: no combination of contacts is compiled.

Where contacts lie along lines, and all is affine in states x and forces of contacts, the functions
of a mode are among some :math:`G(u, t, p)` with :math:`u = (x, \lambda)`. Of these, those that give
forces, or vanish, determine :math:`u = U x + V G(0, t, p)`. With :math:`A = G_u`,

.. math:: G = A U x + (1 + A V)\, G(0, t, p), \qquad G_p = (1 + A V)\, \partial_p G(u, t, p).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import accumulate
from typing import Any

import heyoka as hy
import numpy as np

from slipfold.arrays import Array
from slipfold.flow.affine_flow import AffineFlow, Harmonics, harmonics_of, is_affine
from slipfold.flow.compiled_code import Evaluated, Slopes
from slipfold.flow.equations import Constants, Equations
from slipfold.flow.flow import Flow
from slipfold.flow.modes import (
    Ending,
    Mode,
    ModeEquations,
    Status,
    SwitchingEvent,
    UndeterminedMode,
    events_of,
    friction_given,
    rate_along,
    rate_of_phase,
)
from slipfold.models.friction.contact import Contact, normal_name
from slipfold.models.quantities import Expression, Limit

DEPENDENT = 1e-10
"""Part of a slip that is left without other slips, if it is a combination of them."""

WAYS = (Status.FORTH, Status.BACK)


class FreeContacts(Evaluated):
    """All functions of a structure, with the forces of its contacts after the states."""

    def __init__(
        self, plain: Equations, contacts: Sequence[Contact], limits: Sequence[Limit]
    ) -> None:
        self.plain, self.contacts, self._limits = plain, tuple(contacts), limits
        self.states, names = plain.dimension, [normal_name(contact.name) for contact in contacts]
        names += [contact.friction_names[0] for contact in contacts]
        rates = dict(zip(plain.names, plain.field, strict=True)) | rate_of_phase(plain)
        slips = [contact.slip[0] for contact in contacts]
        parts: dict[Any, list[Expression]] = {
            "changes": [rate_along(slip, rates) for slip in slips],
            Ending.STOPS: slips,
            Ending.PARTS: [contact.normal for contact in contacts],
            "plates": [contact.plate[0] for contact in contacts],
        }
        for way in WAYS:
            given = [friction_given(contact, way) for contact in contacts]
            parts[way] = [
                forces[contact.friction_names[0]]
                for forces, contact in zip(given, contacts, strict=True)
            ]
        for event in self.events((Status.STICK,) * len(contacts)):
            if event.ending is not Ending.PARTS:
                parts.setdefault(_key(event), []).append(event.expression)
        ends = [*accumulate(map(len, parts.values()), initial=self.states)]
        self.places = dict(zip(parts, map(np.arange, ends, ends[1:]), strict=False))
        # All but rates are meant as they are, and not by the phase
        others = [item / plain.coefficients[-1] for part in parts.values() for item in part]
        field, symbols = (*plain.field, *others), (*plain.states, *map(hy.expression, names))
        named = tuple(map(str, symbols))
        super().__init__(replace(plain, names=named, states=symbols, field=field))
        slopes = tuple(hy.diff(item, plain.phase) for item in field)
        self._by_phase = Evaluated(replace(self.equations, field=slopes))
        self._known = b"", np.empty(0)
        none: tuple[Constants | None, Harmonics | None] = None, None
        self._forced = none

    @classmethod
    def of(
        cls, plain: Equations, contacts: Sequence[Contact], limits: Sequence[Limit]
    ) -> FreeContacts | None:
        """Return those of an affine structure with several contacts along lines, None elsewhere."""
        if len(contacts) < 2 or any(len(contact.slip) == 2 for contact in contacts):
            return None
        free = cls(plain, contacts, limits)
        return free if is_affine(free.equations.field, free.equations) else None

    def events(self, mode: Mode) -> tuple[SwitchingEvent, ...]:
        """Return the events of a mode."""
        normal = tuple(contact.normal for contact in self.contacts)
        friction = tuple(
            tuple(map(hy.expression, contact.friction_names)) for contact in self.contacts
        )
        free = ModeEquations(self.plain, self.contacts, mode, {}, normal, friction)
        return events_of(free, self._limits, ())

    def row(self, event: SwitchingEvent) -> int:
        """Return the number of the function of an event."""
        return int(self.places[_key(event)][event.which])

    def matrix(self, constants: Constants) -> Array:
        """Return the derivatives of all functions by the unknowns, shape (q, u).

        Rates are those in a second, so that a branch in the frequency needs them once.
        """
        (known, found), values = self._known, constants.values[:-1].tobytes()
        if known != values:
            second = constants.in_a_second
            found = self.jacobians(np.zeros((1, self.dimension)), np.zeros(1), second)[0]
            self._known = values, found
        return found

    def groups(self, constants: Constants) -> list[list[int]]:
        """Return groups of contacts whose changes change no rate of an event of another group.

        Where two events of different groups happen at once, their order makes no difference to
        first derivatives.
        """
        whole, n, k = self.matrix(constants), self.states, len(self.contacts)
        seen = [whole[self.places[key]] for key in ("changes", Ending.PARTS)]
        pushed, own = whole[:n, n:], np.abs(seen[0][:, n:])
        coupled = (own > DEPENDENT * own.max(initial=0.0)).reshape(k, 2, k).any(axis=1)
        for rows in seen:
            sizes = np.abs(rows[:, :n]) @ np.abs(pushed)
            parts = np.abs(rows[:, :n] @ pushed) > DEPENDENT * sizes
            coupled |= parts.reshape(k, 2, k).any(axis=1)
        coupled |= coupled.T | np.eye(k, dtype=bool)
        for _ in range(k.bit_length()):
            coupled = coupled @ coupled
        return [np.flatnonzero(row).tolist() for row in np.unique(coupled, axis=0)]

    def given(self, phases: Array, constants: Constants) -> Array:
        """Return all functions where the unknowns vanish, rates in a second, shape (p, q)."""
        found = self.rates(np.zeros((len(phases), self.dimension)), phases, constants)
        found[:, : self.states] /= constants.period
        return found

    def harmonics(self, constants: Constants) -> Harmonics | None:
        """Return these functions as sums of harmonics, None if there are too many."""
        known, found = self._forced
        if known is not constants:
            scales = constants.scales
            sizes = np.abs(self.matrix(constants)[:, : self.states]) @ scales
            sizes[: self.states] = np.maximum(sizes[: self.states], scales / constants.period)
            each = lambda at: self.given(at, constants)[..., None]  # noqa: E731
            found = harmonics_of(each, np.ones(1), sizes)
            self._forced = constants, found
        return found

    def by_phase(self, phase: float, constants: Constants) -> Array:
        """Return their derivatives by the phase, shape (q,)."""
        none = np.zeros((1, self.dimension))
        return self._by_phase.rates(none, np.array([phase]), constants)[0]


def _key(event: SwitchingEvent) -> object:
    if event.ending is Ending.YIELDS:
        return event.ending, event.towards
    return Ending.PARTS if event.ending is Ending.MEETS else event.ending


class AssembledFlow(AffineFlow):
    """The flow of a mode, whose equations are derived only where they are to be integrated."""

    def __init__(self, free: FreeContacts, mode: Mode, derive: Callable[[], Equations]) -> None:
        self.free, self.mode, self._derive = free, mode, derive
        self.dimension = free.states
        self.output_names = tuple(name for name, _ in free.equations.outputs)
        none: tuple[Array | None, tuple[list[int], Array]] = None, ([], np.empty(0))
        self._assembled = none
        self._forget()

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__") or "equations" in self.__dict__:
            raise AttributeError(name)
        Flow.__init__(self, self._derive())
        return getattr(self, name)

    def at(self, constants: Constants) -> tuple[list[int], Array]:
        """Return which states contacts hold, and what multiplies states and given functions.

        Its rows are functions, rates in a second, then unknowns, shape (q + u, n + q).
        """
        (known, found), whole = self._assembled, self.free.matrix(constants)
        if known is not whole:
            found = self._assemble(whole)
            self._assembled = whole, found
        return found

    def _assemble(self, whole: Array) -> tuple[list[int], Array]:
        places, mode = self.free.places, np.array(self.mode)
        (q, u), n, k = whole.shape, self.dimension, len(mode)
        stuck = np.flatnonzero(mode == Status.STICK)
        slips = whole[places[Ending.STOPS][stuck], :n]
        held = self._held(slips)
        hold, others = np.linalg.inv(slips[:, held]), slips.copy()
        others[:, held] = 0.0
        function, unknown = np.eye(q, n + q, n), np.eye(u, n + q)
        unknown[n:] = 0.0
        unknown[held, :n] = -hold @ others
        unknown[held] -= hold @ function[places[Ending.STOPS][stuck]]
        normal, friction = np.arange(n, n + k), np.arange(n + k, u)
        kinds = [(normal, Ending.PARTS, mode != Status.OPEN)]
        for forces, key, which in kinds + [(friction, way, mode == way) for way in WAYS]:
            rows = places[key][which]
            unknown[forces[which]] = whole[rows, :n] @ unknown[:n] + function[rows]
        changes, forces = places["changes"][stuck], friction[stuck]
        pushed = whole[changes] @ unknown + function[changes]
        unknown[forces] = -np.linalg.solve(whole[np.ix_(changes, forces)], pushed)
        result = np.concatenate([whole @ unknown + function, unknown])
        # Rounding of rates of held states would leave the matrix without eigenvectors.
        result[held, :n] = -hold @ (others @ result[:n, :n])
        return held, result

    def _held(self, slips: Array) -> list[int]:
        """Return the states for which slips are solved. Shapes: slips (s, n)."""
        left, found = slips.copy(), list[int]()
        for row, (slip, own) in enumerate(zip(left, slips, strict=True)):
            found.append(int(np.argmax(np.abs(slip))))
            if not np.abs(slip).max() > DEPENDENT * np.abs(own).max():
                pairs = zip(self.free.contacts, self.mode, strict=True)
                names = [contact.name for contact, status in pairs if status is Status.STICK]
                raise UndeterminedMode(" and ".join(names))
            left[row + 1 :] -= np.outer(left[row + 1 :, found[-1]] / slip[found[-1]], slip)
        return found

    def values(
        self, states: Array, phases: Array, constants: Constants, rows: slice | list[int]
    ) -> Array:
        """Return some functions and unknowns, (p, ...). Shapes: states (p, n); phases (p,)."""
        known = np.concatenate([states, self.free.given(phases, constants)], axis=1)
        return np.asarray(known @ self.at(constants)[1][rows].T)

    def unknowns(self, states: Array, phases: Array, constants: Constants) -> Array:
        """Return the unknowns, shape (p, u). Shapes: states (p, n); phases (p,)."""
        return self.values(states, phases, constants, slice(-self.free.dimension, None))

    def pulled(
        self, states: Array, phases: Array, c: Constants, directions: Array, rows: slice | list[int]
    ) -> Array:
        """Return their derivatives along changes of the coefficients, shape (p, ..., k)."""
        at = self.unknowns(states, phases, c)
        own = self.free.parameter_slopes(at, phases, c, directions)
        own[:, : self.dimension] /= c.period
        return np.asarray(self.at(c)[1][rows, self.dimension :] @ own)

    def work(self, states: Array, phases: Array, constants: Constants) -> Array:
        """Return power of each contact on the structure, and heat, in J per phase, (p, 2 k)."""
        values, places = self.values(states, phases, constants, slice(None)), self.free.places
        friction = values[:, -len(self.mode) :]
        lost = friction * values[:, places[Ending.STOPS]]
        given = friction * values[:, places["plates"]] - lost
        return constants.period * np.concatenate([given, lost], axis=1)

    def rates(self, states: Array, phases: Array, constants: Constants) -> Array:
        """Evaluate dq/dphase."""
        return constants.period * self.values(states, phases, constants, slice(self.dimension))

    def _forcing(self, constants: Constants, units: Array) -> Harmonics | None:
        """Return the rates of states that are zero from all given functions."""
        found, n = self.free.harmonics(constants), self.dimension
        pushed = constants.period * self.at(constants)[1][:n, n:]
        return found and found._replace(values=found.values @ pushed.T)

    def jacobians(self, states: Array, phases: Array, constants: Constants) -> Array:
        """Evaluate the Jacobian of dq/dphase with respect to the states."""
        n = self.dimension
        return np.tile(constants.period * self.at(constants)[1][:n, :n], (len(states), 1, 1))

    def parameter_slopes(
        self, states: Array, phases: Array, constants: Constants, directions: Array
    ) -> Array:
        """Return the derivatives of the rates along changes of the coefficients."""
        own = self.pulled(states, phases, constants, directions, slice(self.dimension))
        return constants.period * own

    def outputs(self, states: Array, phases: Array, constants: Constants) -> Array:
        """Evaluate all outputs, the states first."""
        at = self.unknowns(states, phases, constants)
        return self.free.outputs(at, phases, constants)


class AssembledSlopes(Slopes):
    """Some functions of a mode with their first derivatives."""

    def __init__(self, flow: AssembledFlow, rows: Callable[[Constants], list[int]]) -> None:
        self._flow, self._rows = flow, rows

    def values(self, states: Array, phases: Array, constants: Constants) -> Array:
        """Return the functions themselves."""
        return self._flow.values(states, phases, constants, self._rows(constants))

    def at(
        self, state: Array, phase: float, constants: Constants, directions: Array
    ) -> tuple[Array, Array, Array]:
        """Return derivatives by state and phase, and along changes of the coefficients."""
        rows, n = self._rows(constants), len(state)
        own = self._flow.at(constants)[1][rows]
        by_phase = own[:, n:] @ self._flow.free.by_phase(phase, constants)
        given = state[None], np.array([phase]), constants, directions
        return own[:, :n], by_phase, self._flow.pulled(*given, rows)[0]

    def affine(self, constants: Constants, floor: Array) -> tuple[Array, Harmonics | None]:
        """Return derivatives by states, and what the phase gives."""
        own, n = self._flow.at(constants)[1][self._rows(constants)], self._flow.dimension
        found = self._flow.free.harmonics(constants)
        return own[:, :n], found and found._replace(values=found.values @ own[:, n:].T)
