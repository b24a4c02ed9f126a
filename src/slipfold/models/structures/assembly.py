"""An assembled structure: reduced matrices, located components, equations, outputs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from typing import Any

import numpy as np

from slipfold.arrays import Array
from slipfold.errors import InputError
from slipfold.models.friction.contact import Contact
from slipfold.models.quantities import (
    DURATION,
    Expression,
    Limit,
    Parameter,
    State,
    Symbols,
    positive,
)
from slipfold.models.structures.component import (
    Component,
    Direction,
    LocalState,
    total,
    weighted_sum,
)
from slipfold.models.structures.contacts import FrictionContact
from slipfold.models.structures.cyclic import CyclicStructure, Sectors
from slipfold.models.structures.damping import Damping
from slipfold.models.structures.definition import Definition
from slipfold.models.structures.inertia import Inertia
from slipfold.models.structures.matrices import (
    MATRICES,
    Matrix,
    factor_names,
    factor_value,
    finite_factor,
    frequencies_of,
    is_diagonal,
    lowest_modes,
    static_shapes,
)
from slipfold.models.structures.receptance import Coupling, FullStructure
from slipfold.models.structures.reduction import Reduced, ReductionReport
from slipfold.text import listed

MAX_DEGREES = 200
"""Maximum degrees of freedom of a model; larger flows take minutes to compile and to run."""

FEW = 3
"""Most degrees of freedom of a direction that are outputs: of more, such as a pressure's, none."""

FREQUENCY = positive("f", 1.0, "Hz", "forcing frequency", "$f$")
LEVEL = Parameter("level", 1.0, "", "factor of everything that is periodic in time")

GENERAL = ("energy", "power_damping", "power_forcing", "power_contacts")
"""Outputs of the structure as a whole; the energy needs a symmetric stiffness matrix."""


@dataclass(frozen=True, eq=False)
class Placed:
    """A component with the coordinates on which it acts."""

    component: Component
    prefix: str  # what its coefficients begin with
    # Weights of the retained coordinates in each of its directions, shape (n_directions, r)
    rows: Array

    def own(self, c: Symbols) -> dict[str, Expression]:
        """Return the coefficients of the component by their own names."""
        start = len(self.prefix)
        return {key[start:]: value for key, value in c.items() if key.startswith(self.prefix)}


class Assembly:
    """All that follows from a definition; shared by all models of it.

    Raises `InputError` if its parts do not fit each other.
    """

    def __init__(self, given: Definition) -> None:
        self.given, definition = given, given.repeated
        self.definition = definition  # with all sectors that repeat
        self.length = definition.length_scale
        matrices = [(name, getattr(definition, name)) for name in ("M", "C", "G", "K", "H")]
        # Formulas of coefficients that multiply matrices
        self.factors = {
            f"{name} {number}": text
            for name, matrix in matrices
            if isinstance(matrix, Matrix)
            for number, (text, _) in enumerate(matrix.terms, start=1)
        }
        # Names of the parameters that switch off what is periodic in time
        named = (
            one._parameter_name(name) for one in definition.components for name in one._amplitudes
        )
        self.amplitudes = tuple(dict.fromkeys(named))
        self.forced = bool(self.amplitudes)
        self.scaled = len(self.amplitudes) > 1  # whether the level scales all of them
        self.reduced = self._reduce()
        self._retain()
        self.size = len(self.names)
        self._reports: dict[tuple[float, ...], ReductionReport] = {}  # by their values
        # Parts of matrices, each with the coefficient that multiplies it, None for one
        self.inertia = Inertia(
            self.mass, tuple((str(key), part) for key, part in self._terms("M")[1:])
        )
        self.damping = self._damping_terms()
        self.gyroscopic = self._terms("G")
        self.stiffening = self._terms("K")[1:]  # beside the constant stiffness
        self.circulatory = self._terms("H")
        self.placed = tuple(
            Placed(component, f"{position}_", self._rows(component))
            for position, component in enumerate(definition.components)
        )
        visible = (*self._watched_directions(), *self._acted_directions())
        self.watched = tuple((name, self._row(item)) for name, item in visible)
        self.symmetric = definition.K.symmetric
        self._refuse_doubles()
        self._refuse_stiff()

    # -- matrices ------------------------------------------------------------------------------

    def _reduce(self) -> Reduced | None:
        """Return the structure in few modal coordinates; None if it keeps all its own."""
        item = self.definition
        if item.reduction is None:
            return None
        acting = [
            self._vector(direction, one.inertial)
            for one in item.components
            for direction in one._directions
        ]
        watched = [self._vector(direction) for _, direction in self._watched_directions()]
        columns = (np.array(rows).reshape(len(rows), item.M.size).T for rows in (acting, watched))
        whole, given = (item.M.array(), item.K.array()), self.given
        if given.cyclic is None:
            full = FullStructure(*whole, *columns)
        else:
            sectors = Sectors(given.cyclic, given.names)
            full = CyclicStructure(sectors, (given.M, given.K), whole, *columns)
        rates = [part for one in (item.C, item.G) if isinstance(one, Matrix) for part in one.parts]
        held = [part.array() for part in item.H.parts] if item.H else []
        parts = [part.array() for part in (*rates, *item.K.parts[1:], *item.M.parts[1:])]
        full.couples = [*parts, *held, *(part.T for part in held)]
        if item.reduction.accuracy is not None or not self.factors:
            full.coupling = self._coupling({one.name: one.default for one in self.parameters})
        return item.reduction._apply(full, item.names)

    def _coupling(self, values: Mapping[str, float]) -> Coupling | None:
        """Return what couples modes at parameter values."""
        item = self.definition
        rates = [one for one in (item.C, item.G) if isinstance(one, Matrix)]
        held, found = [item.H] if item.H else [], []
        for whole, added in ((rates, ()), (held, (item.K,)), ((), (item.M,))):
            parts = [one.array() for one in whole if len(one.entries)]
            terms = [pair for one in (*whole, *added) for pair in one.terms]
            parts += [finite_factor(text, values) * one.array() for text, one in terms]
            found.append(parts)
        if not any(found):
            return None
        return Coupling(*(sum(parts, 0.0 * item.K.array()) for parts in found))

    def _retain(self) -> None:
        """Take over names, matrices and basis of the retained coordinates."""
        item, reduced = self.definition, self.reduced
        moving = np.setdiff1d(np.arange(item.M.size), item.M.empty)
        self.names = reduced.names if reduced else tuple(item.names[at] for at in moving)
        if len(self.names) > MAX_DEGREES:
            raise InputError(
                f"the structure has {len(self.names)} degrees of freedom; orbits of more than "
                f"{MAX_DEGREES} take minutes each, so give reduction=FreeInterface(up_to=f, "
                "accuracy=1e-3) with the highest frequency f in Hz that matters, or fewer modes"
            )
        if reduced is None:
            self.basis = static_shapes(item.K.dense(), moving)
            self.mass = item.M.part(moving).dense()
            self.stiffness = item.K.dense()
            if item.massless:
                condensed = self.stiffness[moving] @ self.basis
                self.stiffness = (condensed + condensed.T) / 2
            return
        few = reduced.coordinates
        self.basis = few.shapes
        self.mass, self.stiffness = np.diag(few.masses), np.diag(few.masses * few.squares)

    def report(self, values: Mapping[str, float]) -> ReductionReport | None:
        """Return what the reduction changes at parameter values; None without one."""
        if self.reduced is None:
            return None
        factors = tuple(self.factors_at(values).values())
        if factors not in self._reports:  # of large structures each takes seconds
            coupling = self._coupling(values) if factors else None
            self._reports[factors] = self.reduced.report(coupling)
        return self._reports[factors]

    def _watched_directions(self) -> tuple[tuple[str, Direction], ...]:
        """Return watched displacements, and those of a boundary, which are no states."""
        watched, given = self.definition.watch, self.given.reduction
        # Those of other sectors move alike.
        count = len(given.boundary) if given else 0
        names = self.definition.reduction.boundary[:count] if self.definition.reduction else ()
        boundary = ((name, Direction(((name, 1.0),))) for name in names)
        more = (one for one in boundary if one not in watched)
        return (*watched, *more)

    def _acted_directions(self) -> tuple[tuple[str, Direction], ...]:
        """Return degrees of freedom where components act that are neither states nor watched."""
        item, watched = self.definition, self._watched_directions()
        # Those without mass move with the force itself, too.
        hidden = {*item.names}.difference(self.names, item.massless, dict(watched))
        several = (*item.contacts, *item.elements, *item.forcing)
        parts = (part for part in several if not (part.inertial or part.sector))
        directions = (one for part in parts for one in part._directions if one)
        named = (name for one in directions if len(one.weights) <= FEW for name, _ in one.weights)
        acted = ((name, Direction(((name, 1.0),))) for name in dict.fromkeys(named))
        known = dict(watched).values()
        return tuple((name, one) for name, one in acted if name in hidden and one not in known)

    def _damping_terms(self) -> tuple[tuple[str | None, Array], ...]:
        damping = self.definition.C
        if isinstance(damping, Damping):
            return damping._terms(self.mass, self.stiffness)
        return self._terms("C")

    def _terms(self, name: str) -> tuple[tuple[str | None, Array], ...]:
        """Return the parts of a matrix in the retained coordinates, the constant one first."""
        matrix: Matrix | None = getattr(self.definition, name)
        if matrix is None:
            return ()
        keys = [f"{name} {number}" for number in range(1, len(matrix.terms) + 1)]
        projected = (self._projected(part.array()) for part in matrix.parts)
        return tuple(zip((None, *keys), projected, strict=True))

    def _projected(self, matrix: Any) -> Array:
        """Return a matrix in the retained coordinates, without entries that are rounding errors.

        With modal coordinates each of them would be a term of the equations. Shapes: matrix (n, n).
        """
        basis = self.basis
        result = basis.T @ np.asarray(matrix @ basis)
        if self.reduced is not None:
            sizes = abs(basis).T @ np.asarray(abs(matrix) @ abs(basis))
            result[np.abs(result) < MATRICES.projected * sizes] = 0.0
        return result

    def added(self, parts: tuple[tuple[str | None, Array], ...], values: Symbols) -> Array:
        """Return the sum of parts of a matrix at parameter values, shape (r, r)."""
        known = {**values, **self.factors_at(values)}
        return np.zeros((self.size, self.size)) + sum(
            matrix if key is None else known[key] * matrix for key, matrix in parts
        )

    def factors_at(self, values: Symbols) -> dict[str, Any]:
        """Return the values of the formulas that multiply matrices."""
        return {key: factor_value(text, values) for key, text in self.factors.items()}

    def _rows(self, component: Component) -> Array:
        rows = [self._row(item, component.inertial) for item in component._directions]
        return np.array(rows).reshape(len(rows), self.size)

    def _row(self, direction: Direction | None, inertial: bool = False) -> Array:
        return np.asarray(self._vector(direction, inertial) @ self.basis)

    def _vector(self, direction: Direction | None, inertial: bool = False) -> Array:
        """Return the weights of all degrees of freedom, shape (n,)."""
        names, mass = self.definition.names, self.definition.M
        row = np.ones(len(names)) if direction is None else direction.vector(names)
        return np.asarray(mass.array() @ row) if inertial else row

    @cached_property
    def frequencies(self) -> Array:
        """Natural frequencies of the linear structure without elements in Hz, shape (r,)."""
        return frequencies_of(self.squares)

    @cached_property
    def squares(self) -> Array:
        """Squared circular frequencies of the constant matrices in rad^2/s^2, shape (r,)."""
        return lowest_modes(self.stiffness, self.mass)[0]

    @cached_property
    def notes(self) -> tuple[str, ...]:
        """What an unusual stiffness matrix means, one sentence each."""
        if not self.symmetric:
            return ("K is not symmetric, so that there is no energy of the structure",)
        rounding = 10 * MATRICES.rounding * self.size * np.abs(self.squares).max()
        growing = int(np.sum(self.squares < -rounding))
        kinds = {"negative": growing, "no": int(np.sum(np.abs(self.squares) <= rounding))}
        return tuple(
            f"{count} of {self.size} modes have {kind} stiffness: only elements, contacts and "
            "other matrices can hold them"
            for kind, count in kinds.items()
            if count
        )

    def _refuse_stiff(self) -> None:
        """Refuse a fast mode whose rounding errors hide the slow ones."""
        if self.definition.reduction is None and (found := self._stiff(MATRICES.hidden)):
            what, kept = found
            raise InputError(
                f"{what}, which its rounding errors hide; give "
                f"reduction=ModalReduction(modes={kept}), or a stiffness at most "
                f"{MATRICES.hidden:g} times as large"
            )

    def _stiff(self, ratio: float) -> tuple[str, int] | None:
        """Say which mode is so many times as stiff as the first; and how many modes are below."""
        squares = self.squares
        # What is slower still is a motion without stiffness.
        slow = squares > MATRICES.rounding * self.size * squares[-1]
        hidden = np.flatnonzero(slow & (squares < squares[-1] / ratio))
        if not self.symmetric or not len(hidden):
            return None
        first, last = hidden[0], self.size - 1
        kept = first + int(np.argmax(np.diff(np.log(squares[first:])))) + 1
        what = (
            f"mode {last + 1} at {self.frequencies[last]:.2g} Hz is "
            f"{squares[last] / squares[first]:.2g} times as stiff as mode {first + 1} at "
            f"{self.frequencies[first]:.2g} Hz"
        )
        return what, kept

    @cached_property
    def advice(self) -> str:
        """What its matrices have that may hide a motion, and the way out, as a clause."""
        squares, shapes = lowest_modes(self.stiffness, self.mass)
        if self.symmetric and squares[0] <= 10 * MATRICES.rounding * self.size * squares[-1]:
            moved = np.abs(self.basis @ shapes[:, 0])
            names = [self.definition.names[at] for at in np.argsort(-moved, kind="stable")]
            shown = sorted(names[: np.count_nonzero(moved > moved.max() / 2)])
            return (
                "mode 1 has no stiffness, so that nothing may determine the mean of "
                f"{listed(shown)}; add a LinearSpring, or give K a stiffness"
            )
        if found := self._stiff(MATRICES.steep):
            what, kept = found
            return f"{what}; give reduction=ModalReduction(modes={kept})"
        return ""

    # -- names ---------------------------------------------------------------------------------

    @cached_property
    def parameters(self) -> tuple[Parameter, ...]:
        """The structure's own, then those of the components."""
        own = [FREQUENCY if self.forced else DURATION, *([LEVEL] if self.scaled else [])]
        damping = self.definition.C
        if isinstance(damping, Damping):
            own += damping.parameters
        own += self.definition.variables
        shared: dict[str, Parameter] = {}
        for component in (one for one in self.definition.components if one.sector is None):
            named = zip(component.parameters, component.named_parameters, strict=True)
            for parameter, one in named:
                first = shared.setdefault(one.name, one)
                if first is one or not component._group_of(parameter.name):
                    own.append(one)
                elif first != one:
                    raise InputError(
                        f"{one.name} is {first.doc} and {one.doc} in components of one group; "
                        "give each kind a group of its own"
                    )
        known = {item.name for item in own}
        names = (name for text in self.factors.values() for name in factor_names(text))
        own += [
            Parameter(name, 1.0, "", "factor of a matrix")
            for name in dict.fromkeys(names)
            if name not in known
        ]
        return tuple(own)

    @cached_property
    def states(self) -> tuple[State, ...]:
        """Displacements, their rates, then the memories of contacts."""
        scaled = self.length != 1
        units = ("", "1/s") if scaled else ("m", "m/s")
        over = " over the length scale" if scaled else ""
        states = [State(name, units[0], f"displacement {name}{over}") for name in self.names]
        states += [State(f"v{name}", units[1], f"rate of {name}") for name in self.names]
        for item in self.placed:
            states += [
                replace(state, name=item.component._full_name(state.name))
                for state in item.component.memory()
            ]
        return tuple(states)

    @cached_property
    def limits(self) -> tuple[Limit, ...]:
        """Limits of all components."""
        limits = []
        for component in (item.component for item in self.placed):
            before = f"{component.label}: " if component.label else ""
            for limit in component.limits():
                output, reason = component._full_name(limit.output), f"{before}{limit.reason}"
                name = component._limit_name(limit)
                limits.append(replace(limit, name=name, output=output, reason=reason))
        return tuple(limits)

    def _refuse_doubles(self) -> None:
        """Refuse names that stand for two things."""
        measured = [
            item.component._full_name(measure.name)
            for item in self.placed
            for measure in item.component._measures()
        ]
        groups = {
            "a state": [item.name for item in self.states],
            "a parameter": [item.name for item in self.parameters],
            "an output": [*measured, *(name for name, _ in self.watched), *GENERAL],
        }
        owners: dict[str, str] = {}
        for what, names in groups.items():
            for name in names:
                if name in owners:
                    both = f"{name} is {owners[name]} and {what}"
                    if owners[name] == what:
                        both = f"two {what.split()[1]}s are called {name}"
                    raise InputError(
                        f'{both}; give each component a name of its own, such as name = "left", '
                        "or rename the degree of freedom"
                    )
                owners[name] = what

    # -- equations -----------------------------------------------------------------------------

    def own_values(self, item: Placed, p: Symbols) -> dict[str, Expression]:
        """Return a component's parameters by their own names, amplitudes times the level."""
        own = item.component._own(p)
        if self.scaled:
            own |= {name: p[LEVEL.name] * own[name] for name in item.component._amplitudes}
        return own

    def coefficients(self, p: Symbols) -> dict[str, Expression]:
        """Return the coefficients of all components, and those of damping."""
        result = self.factors_at(p)
        result |= self.inertia.coefficients(result)
        result |= {key: p[key] for key, _ in self.damping if key is not None and key in p}
        for item in self.placed:
            own = self.own_values(item, p) | ({"f": p["f"]} if self.forced else {})
            for key, value in item.component._coefficients(own).items():
                result[f"{item.prefix}{key}"] = value
        return result

    def local(
        self, item: Placed, q: Symbols, c: Symbols, phase: Expression, rates: Symbols | None = None
    ) -> LocalState:
        """Return the state where a component acts; with accelerations if rates are given."""
        memory = tuple(q[item.component._full_name(one.name)] for one in item.component.memory())
        return LocalState(
            q,
            item.own(c),
            item.component._later(phase),
            tuple(self.displacement(row, q) for row in item.rows),
            tuple(self.displacement(row, q, "v") for row in item.rows),
            memory,
            tuple(self.displacement(row, rates, "v") for row in item.rows) if rates else (),
        )

    @property
    def friction_contacts(self) -> list[tuple[Placed, FrictionContact]]:
        """The friction contacts and their components."""
        pairs = ((item, item.component) for item in self.placed)
        return [(item, one) for item, one in pairs if isinstance(one, FrictionContact)]

    def contacts(self, q: Symbols, c: Symbols, phase: Expression) -> tuple[Contact, ...]:
        """Return the contacts whose laws stick."""
        return tuple(
            component._contact(self.local(item, q, c, phase))
            for item, component in self.friction_contacts
            if component.law.sticks
        )

    def displacement(self, row: Array, q: Symbols, rate: str = "") -> Expression:
        """Return a weighted sum of displacements in m, or of velocities in m/s.

        Shapes: row (r,).
        """
        symbols = [q[f"{rate}{name}"] for name in self.names]
        return total(weighted_sum(row * self.length, symbols))

    def rates(self, q: Symbols, c: Symbols, phase: Expression) -> dict[str, Expression]:
        """Return the time derivatives of the states."""
        displacements = [q[name] for name in self.names]
        speeds = [q[f"v{name}"] for name in self.names]
        rates: dict[str, Expression] = dict(zip(self.names, speeds, strict=True))
        terms = self._linear_terms(displacements, speeds, c)
        for item in self.placed:
            inputs = self.inertia.over(item.rows.T) / self.length
            forces = item.component._forces(self.local(item, q, c, phase))
            for force, column in zip(forces, inputs.T, strict=True):
                for row in np.flatnonzero(column):
                    terms[row] += weighted_sum([column[row]], [force])
        accelerations = self.inertia.accelerations(terms, c)
        rates |= {f"v{name}": one for name, one in zip(self.names, accelerations, strict=True)}
        known = dict(rates)
        for item, component in self.friction_contacts:
            names = [component._full_name(state.name) for state in component.memory()]
            if names:
                contact = component._contact(self.local(item, q, c, phase, known))
                rates |= dict(zip(names, contact.memory_rates, strict=True))
        return rates

    def modes(self) -> tuple[Array, Array, Array]:
        """Return squared circular frequencies, shapes and their inverse: (r,), (r, r), (r, r)."""
        mass, stiffness = self.mass, self.stiffness
        if is_diagonal(mass) and is_diagonal(stiffness):
            return np.diag(stiffness) / np.diag(mass), np.eye(len(mass)), np.eye(len(mass))
        squares, shapes = lowest_modes(stiffness, mass)
        moved = shapes.T @ mass
        return squares, shapes, moved / np.sum(shapes.T * moved, axis=1, keepdims=True)

    @cached_property
    def modal(self) -> tuple[Array, Array, Array] | None:
        """Squared circular frequencies, shapes, and the map from displacements to modes.

        None where the stiffness needs no modal coordinates. In a beam of many elements the inverse
        mass times the stiffness amplifies rounding errors of displacements to accelerations as
        large as those of the slow modes.

        Shapes: (n,), (n, n), (n, n).
        """
        simple = is_diagonal(self.mass) or self.inertia.parts
        if simple or not self.symmetric or self.size > MATRICES.modal:
            return None
        squares = self.squares
        return None if squares[-1] <= MATRICES.wide * abs(squares[0]) else self.modes()

    def _linear_terms(
        self, displacements: list[Expression], speeds: list[Expression], c: Symbols
    ) -> list[list[Expression]]:
        """Return the linear terms of each acceleration; numbers stand in for the matrices."""
        acting, dampings = displacements, list(self.damping)
        if self.modal is None:
            stiffness = self.inertia.over(self.stiffness)
        else:
            squares, shapes, into = self.modal
            stiffness = shapes * squares
            acting = [total(weighted_sum(row, displacements)) for row in into]
            # Damping proportional to the stiffness acts on the modal coordinates as well.
            for key, matrix in self.damping:
                if matrix is self.stiffness:
                    dampings = [item for item in dampings if item[1] is not matrix]
                    rates = [total(weighted_sum(row, speeds)) for row in into]
                    pairs = zip(acting, rates, strict=True)
                    acting = [one + c[str(key)] * other for one, other in pairs]
        others = [
            (key, self.inertia.over(matrix), states)
            for parts, states in (
                ((*dampings, *self.gyroscopic), speeds),
                ((*self.stiffening, *self.circulatory), displacements),
            )
            for key, matrix in parts
        ]
        terms = []
        for row in range(self.size):
            own = weighted_sum(-stiffness[row], acting)
            for key, matrix, states in others:
                parts = weighted_sum(-matrix[row], states)
                own += parts if key is None else [c[key] * total(parts)] if parts else []
            terms.append(own)
        return terms


assemble = lru_cache(maxsize=64)(Assembly)
"""Put a structure together; equal definitions share the result."""
