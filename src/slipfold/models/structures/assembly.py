"""A structure put together: reduced matrices, components at their places, equations, outputs."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property, lru_cache, partial
from typing import Any

import numpy as np

from slipfold.arrays import Array
from slipfold.errors import InputError
from slipfold.models.output import (
    Contact,
    Expression,
    Limit,
    Output,
    Symbols,
    friction_name,
    normal_name,
)
from slipfold.models.parameter import DURATION, Parameter, State, positive
from slipfold.models.structures.component import (
    Component,
    Direction,
    Motion,
    total,
    weighted_sum,
)
from slipfold.models.structures.contacts import FrictionContact
from slipfold.models.structures.damping import Damping
from slipfold.models.structures.definition import Definition
from slipfold.models.structures.matrices import lowest_modes
from slipfold.models.structures.reduction import Reduced, static_errors

LARGEST = 200
"""Most degrees of freedom of a model: beyond it a flow takes minutes to compile and to run."""

FREQUENCY = positive("f", 1.0, "Hz", "forcing frequency", "$f$")
LEVEL = Parameter("level", 1.0, "", "factor of everything that is periodic in time")

GENERAL = ("energy", "power_damping", "power_forcing", "power_contacts")
"""Outputs of the structure as a whole; the energy needs a symmetric stiffness matrix."""

WIDE = 1e5
"""Largest squared frequency over the smallest beyond which rounding of displacements is felt."""

MOST_MODES = 80
"""Degrees of freedom up to which the equations are written with modes: compiling takes longer."""

ROUNDING = 1e-15
"""Entry of the inverse mass times a matrix, over the largest of its row, that is rounding."""


@dataclass(frozen=True, eq=False)
class Placed:
    """A component at its place in the structure."""

    component: Component
    prefix: str  # what its coefficients begin with
    # Weights of the kept coordinates in each of its directions, shape (n_directions, n_kept)
    rows: Array


class Assembly:
    """All that follows from a definition; shared by all models of it.

    Raises `InputError` if its parts do not fit each other.
    """

    def __init__(self, definition: Definition) -> None:
        self.definition = definition
        self.reduced = self._reduce()
        self.names = definition.names if self.reduced is None else self.reduced.names
        self.size = len(self.names)
        if self.size > LARGEST:
            raise InputError(
                f"the structure keeps {self.size} degrees of freedom; orbits of more than "
                f"{LARGEST} take minutes each, so give reduction=CraigBampton(boundary, modes=10) "
                "or ModalReduction(modes=20)"
            )
        self.mass = definition.M.dense() if self.reduced is None else self.reduced.mass
        self.stiffness = definition.K.dense() if self.reduced is None else self.reduced.stiffness
        self.damping = self._damping_terms()
        self.placed = tuple(
            Placed(component, f"{place}_", self._rows(component))
            for place, component in enumerate(definition.components)
        )
        self.watched = tuple((name, self._row(item)) for name, item in definition.watch)
        self.symmetric = definition.K.asymmetry[0] < 1e-9

    # -- matrices ------------------------------------------------------------------------------

    def _reduce(self) -> Reduced | None:
        item = self.definition
        if item.reduction is None:
            return None
        reduced = item.reduction.apply(item.M, item.K, item.names)
        directions = [
            direction
            for component in item.components
            for direction in component.directions
            if direction is not None and not component.inertial
        ]
        lost = static_errors(item.K, reduced, item.names, directions)
        return replace(reduced, report=replace(reduced.report, static_errors=lost))

    def _damping_terms(self) -> tuple[tuple[str | None, Array], ...]:
        damping = self.definition.C
        if damping is None:
            return ()
        if isinstance(damping, Damping):
            return damping.terms(self.mass, self.stiffness)
        if self.reduced is None:
            return ((None, damping.dense()),)
        basis = self.reduced.basis
        return ((None, basis.T @ np.asarray(damping.array() @ basis)),)

    def _rows(self, component: Component) -> Array:
        rows = [self._row(item, component.inertial) for item in component.directions]
        return np.array(rows).reshape(len(rows), self.size)

    def _row(self, direction: Direction | None, inertial: bool = False) -> Array:
        names, mass = self.definition.names, self.definition.M
        row = np.ones(len(names)) if direction is None else direction.vector(names)
        if inertial:
            row = np.asarray(mass.array() @ row)
        return row if self.reduced is None else np.asarray(row @ self.reduced.basis)

    def over_mass(self, matrix: Array) -> Array:
        """Return the inverse mass matrix times a matrix; what is zero but for rounding is zero.

        Shapes: matrix (n_kept, m).
        """
        if matrix is self.mass:
            return np.eye(self.size)
        diagonal = np.diag(self.mass)
        if not np.any(self.mass - np.diag(diagonal)):
            return matrix / diagonal[:, None]
        result = np.asarray(np.linalg.solve(self.mass, matrix), dtype=float)
        largest = np.abs(result).max(axis=1, keepdims=True, initial=0.0)
        result[np.abs(result) < ROUNDING * largest] = 0.0
        return result

    @cached_property
    def frequencies(self) -> Array:
        """Natural frequencies of the linear structure without elements in Hz, shape (n_kept,)."""
        squares = lowest_modes(self.stiffness, self.mass)[0]
        return np.sqrt(np.maximum(squares, 0.0)) / (2 * np.pi)

    # -- names ---------------------------------------------------------------------------------

    @cached_property
    def forced(self) -> bool:
        """Whether anything is periodic in time."""
        return bool(self._amplitudes)

    @cached_property
    def _amplitudes(self) -> tuple[str, ...]:
        return tuple(
            item.component.called(name)
            for item in self.placed
            for name in item.component.amplitudes
        )

    @property
    def quiet(self) -> str | None:
        """Name of the parameter that switches the forcing off."""
        if len(self._amplitudes) > 1:
            return LEVEL.name
        return self._amplitudes[0] if self._amplitudes else None

    @property
    def speeds(self) -> dict[str, bool]:
        """Names of the speeds of moving surfaces, and whether something sticks to a resting one."""
        return {item.called("Vd"): item.law.sticks for item in self.definition.contacts}

    @cached_property
    def parameters(self) -> tuple[Parameter, ...]:
        """The structure's own, then those of the components."""
        own = [FREQUENCY] if self.forced else [DURATION]
        own += [LEVEL] if self.quiet == LEVEL.name else []
        damping = self.definition.C
        if isinstance(damping, Damping):
            own += damping.own_parameters
        for item in self.placed:
            own += item.component.parameters
        return tuple(own)

    @cached_property
    def states(self) -> tuple[State, ...]:
        """Displacements, their rates, then the memories of contacts."""
        scaled = self.definition.length_scale != 1
        units = ("", "1/s") if scaled else ("m", "m/s")
        over = " over the length scale" if scaled else ""
        labels = ["" if scaled else f"{name} (m)" for name in self.names]
        labels += [f"v{name} ({units[1]})" for name in self.names]
        states = [State(name, units[0], f"displacement {name}{over}") for name in self.names]
        states += [State(f"v{name}", units[1], f"rate of {name}") for name in self.names]
        states = [replace(item, label=text) for item, text in zip(states, labels, strict=True)]
        for item in self.placed:
            states += [
                replace(state, name=item.component.called(state.name))
                for state in item.component.memory()
            ]
        return tuple(states)

    @cached_property
    def limits(self) -> tuple[Limit, ...]:
        """Limits of all components."""
        found = []
        for item in self.placed:
            called, name = item.component.called, item.component.name
            for limit in item.component.limits():
                reason = f"{name}: {limit.reason}" if name else limit.reason
                found.append(
                    Limit(_titled(item.component, limit), called(limit.output), limit.bound, reason)
                )
        return tuple(found)

    # -- equations -----------------------------------------------------------------------------

    def own_values(self, item: Placed, p: Symbols) -> dict[str, Expression]:
        """Return a component's parameters by their own names, amplitudes times the level."""
        own = item.component.own(p)
        if LEVEL.name in p and self.quiet == LEVEL.name:
            for name in item.component.amplitudes:
                own[name] = p[LEVEL.name] * own[name]
        return own

    def coefficients(self, p: Symbols) -> dict[str, Expression]:
        """Return the coefficients of all components, and those of damping."""
        result: dict[str, Expression] = {key: p[key] for key, _ in self.damping if key is not None}
        for item in self.placed:
            own = self.own_values(item, p)
            if self.forced:
                own["f"] = p["f"]
            found = item.component.coefficients(own)
            result |= {f"{item.prefix}{key}": value for key, value in found.items()}
        return result

    def own_coefficients(self, item: Placed, c: Symbols) -> dict[str, Expression]:
        """Return a component's coefficients by their own names."""
        start = item.prefix
        return {key[len(start) :]: value for key, value in c.items() if key.startswith(start)}

    def motion(self, item: Placed, q: Symbols) -> Motion:
        """Return how the structure moves where a component acts."""
        component = item.component
        memory = tuple(q[component.called(state.name)] for state in component.memory())
        return Motion(
            tuple(self.displacement(row, q) for row in item.rows),
            tuple(self.displacement(row, q, "v") for row in item.rows),
            memory,
            **_given_forces(component, q),
        )

    def contacts(self, q: Symbols, c: Symbols, phase: Expression) -> tuple[Contact, ...]:
        """Return the contacts whose laws stick."""
        found = []
        for item in self.placed:
            if isinstance(item.component, FrictionContact):
                motion, own = self.motion(item, q), self.own_coefficients(item, c)
                contact = item.component.contact(motion, own, phase)
                titles = tuple(_titled(item.component, limit) for limit in item.component.passed())
                found += [] if contact is None else [replace(contact, limits=titles)]
        return tuple(found)

    def displacement(self, row: Array, q: Symbols, rate: str = "") -> Expression:
        """Return a weighted sum of displacements in m, or of velocities in m/s.

        Shapes: row (n_kept,).
        """
        symbols = [q[f"{rate}{name}"] for name in self.names]
        return total(weighted_sum(row * self.definition.length_scale, symbols))

    def rates(self, q: Symbols, c: Symbols, phase: Expression) -> dict[str, Expression]:
        """Return the time derivatives of the states."""
        places = [q[name] for name in self.names]
        speeds = [q[f"v{name}"] for name in self.names]
        rates: dict[str, Expression] = dict(zip(self.names, speeds, strict=True))
        terms = self._linear_terms(places, speeds, c)
        for item in self.placed:
            motion, own = self.motion(item, q), self.own_coefficients(item, c)
            inputs = self.over_mass(item.rows.T) / self.definition.length_scale
            for force, column in zip(
                item.component.forces(motion, own, phase), inputs.T, strict=True
            ):
                if force is not None:
                    for place in np.flatnonzero(column):
                        terms[place] += weighted_sum([column[place]], [force])
        rates |= {f"v{name}": total(terms[place]) for place, name in enumerate(self.names)}
        return {**rates, **self._memory_rates(q, rates, c, phase)}

    def _memory_rates(
        self, q: Symbols, rates: Symbols, c: Symbols, phase: Expression
    ) -> dict[str, Expression]:
        """Return the rates of the memories of contacts, which may see accelerations."""
        found: dict[str, Expression] = {}
        for item in self.placed:
            names = [item.component.called(state.name) for state in item.component.memory()]
            if names:
                gained = tuple(self.displacement(row, rates, "v") for row in item.rows)
                motion = replace(self.motion(item, q), acceleration=gained)
                own = self.own_coefficients(item, c)
                memory = item.component.memory_rates(motion, own, phase)
                found |= dict(zip(names, memory, strict=True))
        return found

    @cached_property
    def modal(self) -> tuple[Array, Array, Array] | None:
        """Squared circular frequencies, shapes and what makes modal coordinates of displacements.

        None where the stiffness is as well applied without them. The inverse mass times the
        stiffness of a beam of many elements makes an acceleration of what rounding leaves of the
        displacements that is no longer small compared with that of the slow modes.

        Shapes: (n,), (n, n), (n, n).
        """
        diagonal = not np.any(self.mass - np.diag(np.diag(self.mass)))
        if diagonal or not self.symmetric or self.size > MOST_MODES:
            return None
        squares, shapes = lowest_modes(self.stiffness, self.mass)
        if squares[-1] <= WIDE * abs(squares[0]):
            return None
        moved = shapes.T @ self.mass
        return squares, shapes, moved / np.sum(shapes.T * moved, axis=1, keepdims=True)

    def _linear_terms(
        self, places: list[Expression], speeds: list[Expression], c: Symbols
    ) -> list[list[Expression]]:
        """Return the linear terms of each acceleration; numbers stand in for the matrices."""
        if self.modal is not None:
            return self._terms_by_modes(places, speeds, c)
        constant = sum((matrix for key, matrix in self.damping if key is None), np.zeros(1))
        stiffness = self.over_mass(self.stiffness)
        damping = self.over_mass(np.broadcast_to(constant, self.mass.shape))
        scaled = [(key, self.over_mass(m)) for key, m in self.damping if key is not None]
        terms = []
        for row in range(self.size):
            found = weighted_sum(-stiffness[row], places) + weighted_sum(-damping[row], speeds)
            for key, matrix in scaled:
                parts = weighted_sum(-matrix[row], speeds)
                found += [c[key] * total(parts)] if parts else []
            terms.append(found)
        return terms

    def _terms_by_modes(
        self, places: list[Expression], speeds: list[Expression], c: Symbols
    ) -> list[list[Expression]]:
        """Return the same, the stiffness applied to the modal coordinates."""
        assert self.modal is not None
        squares, shapes, into = self.modal
        acting = [total(weighted_sum(row, places)) for row in into]
        others = []
        for key, matrix in self.damping:
            factor = 1.0 if key is None else c[key]
            if matrix is self.stiffness:
                rates = [total(weighted_sum(row, speeds)) for row in into]
                acting = [one + factor * other for one, other in zip(acting, rates, strict=True)]
            else:
                others.append((factor, self.over_mass(matrix)))
        terms = []
        for row in range(self.size):
            found = weighted_sum(-shapes[row] * squares, acting)
            for factor, matrix in others:
                parts = weighted_sum(-matrix[row], speeds)
                found += [factor * total(parts)] if parts else []
            terms.append(found)
        return terms

    @cached_property
    def nonzeros(self) -> int:
        """Number of products in the linear part of the equations."""
        if self.modal is not None:
            return 3 * self.size**2
        matrices = [self.stiffness, *(matrix for _, matrix in self.damping)]
        return sum(int(np.count_nonzero(self.over_mass(matrix))) for matrix in matrices)


def _titled(component: Component, limit: Limit) -> str:
    """Return what the structure calls a limit of a component."""
    return f"{limit.name} of {component.name}" if component.name else limit.name


def _given_forces(component: Component, q: Symbols) -> dict[str, Any]:
    """Return the forces of a contact where they are given among the states."""
    if not isinstance(component, FrictionContact) or normal_name(component.key) not in q:
        return {}
    friction = (q[friction_name(component.key, axis)] for axis in range(len(component.along)))
    return {"normal": q[normal_name(component.key)], "friction": tuple(friction)}


@lru_cache(maxsize=64)
def assemble(definition: Definition) -> Assembly:
    """Put a structure together; equal definitions share the result."""
    assembly = Assembly(definition)
    _refuse_doubles(assembly)
    return assembly


def _refuse_doubles(assembly: Assembly) -> None:
    """Refuse names that stand for two things."""
    measured = [
        item.component.called(measure.name)
        for item in assembly.placed
        for measure in item.component.measures()
    ]
    groups = {
        "a state": [item.name for item in assembly.states],
        "a parameter": [item.name for item in assembly.parameters],
        "an output": [*measured, *(name for name, _ in assembly.watched), *GENERAL],
    }
    known: dict[str, str] = {}
    for what, names in groups.items():
        for name in names:
            if name in known:
                both = f"{name} is {known[name]} and {what}"
                if known[name] == what:
                    both = f"two {what.split()[1]}s are called {name}"
                raise InputError(
                    f'{both}; give each component a name of its own, such as name = "left", or '
                    "rename the degree of freedom"
                )
            known[name] = what


def structure_outputs(assembly: Assembly) -> tuple[Output, ...]:
    """Return the outputs of a structure.

    The energy is that of structure and elements. Its rate is ``power_forcing + power_contacts -
    power_damping``, where damping is that of structure and elements.
    """
    outputs = [
        Output(name, partial(_displacement, assembly, row), "m", f"displacement {name}")
        for name, row in assembly.watched
    ]
    for item in assembly.placed:
        outputs += [_measure(assembly, item, measure) for measure in item.component.measures()]
    if assembly.symmetric:
        doc = "kinetic and elastic energy of structure and elements"
        outputs.append(Output(GENERAL[0], partial(_energy, assembly), "J", doc, "$E$ (J)"))
    places = len(assembly.definition.elements)
    ends = places + len(assembly.definition.contacts)
    powers = (
        (partial(_lost, assembly), "power lost to damping"),
        (partial(_given, assembly, ends, None), "power put in by the forcing"),
        (partial(_given, assembly, places, ends), "power put in by the contacts"),
    )
    outputs += [
        Output(name, function, "W", doc, "$P$ (W)")
        for name, (function, doc) in zip(GENERAL[1:], powers, strict=True)
    ]
    return tuple(outputs)


def _displacement(
    assembly: Assembly, row: np.ndarray, q: Symbols, c: Symbols, phase: Expression
) -> Expression:
    return assembly.displacement(row, q)


def _measure(assembly: Assembly, item: Placed, measure: Output) -> Output:
    component = item.component
    doc = f"{measure.doc} ({component.name})" if component.name else measure.doc
    function = partial(_measured, assembly, item, measure)
    return Output(component.called(measure.name), function, measure.unit, doc, measure.label)


def _measured(
    assembly: Assembly, item: Placed, measure: Output, q: Symbols, c: Symbols, phase: Expression
) -> Expression:
    own = assembly.own_coefficients(item, c)
    return measure.expression(assembly.motion(item, q), own, phase)


def _form(assembly: Assembly, matrix: np.ndarray, q: Symbols, rate: str) -> list[Expression]:
    """Return the terms of a quadratic form of displacements or velocities, in SI units."""
    symbols = [q[f"{rate}{name}"] for name in assembly.names]
    even = (matrix + matrix.T) * (assembly.definition.length_scale**2 / 2)
    terms = []
    for row, symbol in enumerate(symbols):
        weights = even[row, row:] * np.where(np.arange(row, assembly.size) == row, 1.0, 2.0)
        parts = weighted_sum(weights, symbols[row:])
        terms += [symbol * total(parts)] if parts else []
    return terms


def _energy(assembly: Assembly, q: Symbols, c: Symbols, phase: Expression) -> Expression:
    terms = _form(assembly, assembly.mass / 2, q, "v")
    terms += _form(assembly, assembly.stiffness / 2, q, "")
    for item in assembly.placed:
        own = assembly.own_coefficients(item, c)
        stored = item.component.potential(assembly.motion(item, q), own)
        terms += [] if stored is None else [stored]
    return total(terms)


def _lost(assembly: Assembly, q: Symbols, c: Symbols, phase: Expression) -> Expression:
    terms: list[Expression] = []
    for key, matrix in assembly.damping:
        form = _form(assembly, matrix, q, "v")
        terms += form if key is None else [c[key] * total(form)]
    for item in assembly.placed:
        own = assembly.own_coefficients(item, c)
        lost = item.component.dissipation(assembly.motion(item, q), own)
        terms += [] if lost is None else [lost]
    return total(terms)


def _given(
    assembly: Assembly, first: int, last: int | None, q: Symbols, c: Symbols, phase: Expression
) -> Expression:
    """Return the power of the components from one place to another."""
    terms = []
    for item in assembly.placed[first:last]:
        motion, own = assembly.motion(item, q), assembly.own_coefficients(item, c)
        forces = item.component.forces(motion, own, phase)
        terms += [
            force * speed
            for force, speed in zip(forces, motion.velocity, strict=True)
            if force is not None
        ]
    return total(terms)
