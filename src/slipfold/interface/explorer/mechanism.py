"""A mechanism from a model: masses, what connects them, what they slide on, what pulls at them."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache
from typing import Any

import heyoka as hy
import numpy as np

from slipfold.arrays import Array
from slipfold.flow.modes import contacts_of
from slipfold.interface.explorer.settings import PAGE
from slipfold.models.formulas.values import as_symbol
from slipfold.models.model import Model, evaluation_of
from slipfold.models.nonlinear_mode import velocities_of
from slipfold.models.sliding_oscillator import SlidingOscillator
from slipfold.models.structures.contacts import FrictionContact
from slipfold.models.structures.forcing import PeriodicForce
from slipfold.models.structures.matrices import Matrix
from slipfold.models.structures.structure import Structure
from slipfold.models.unforced import Unforced

NONE = 1e-9
"""Stiffness or damping, over that of its mass, that is a rounding error and no spring."""


@lru_cache(maxsize=64)
def mechanism_of(model: Model) -> dict[str, Any] | None:
    """Return what a mechanism consists of, as plain data; None for a model that has no masses.

    Each body is the displacement of a mass in one direction, by the name of its state. A link joins
    two bodies, or a body and the ground, which is -1.

    >>> from slipfold.models.registry import model_named
    >>> mechanism_of(model_named("duffing"))["springs"]
    [[0, -1]]
    >>> mechanism_of(model_named("lorenz")) is None
    True
    """
    if isinstance(model, SlidingOscillator):
        return {"kind": "sliding"}
    if isinstance(model, Structure):
        return _of_structure(model)
    return _of_equations(model)


def loops_of(model: Model) -> list[dict[str, Any]]:
    """Return friction forces that are outputs, with displacements along them as sums of states.

    Contacts that stick are left out: their trajectories show when they do.

    >>> from slipfold.models.friction.with_memory import LuGre
    >>> loops_of(SlidingOscillator(friction=LuGre()))[1]
    {'force': 'Fy', 'along': {'y': 1.0}}
    """
    sliding = model.forced_model if isinstance(model, Unforced) else model
    if isinstance(sliding, SlidingOscillator):
        axes = () if sliding.friction.sticks else ("x", "y")
        return [{"force": f"F{axis}", "along": {axis: 1.0}} for axis in axes]
    if not isinstance(sliding, Structure):
        return []
    names = sliding._assembly.names
    return [
        {
            "force": contact._full_name(f"F{axis}"),
            "along": {names[int(i)]: float(row[i]) for i in np.flatnonzero(row)},
        }
        for placed, contact in sliding._assembly.friction_contacts
        if not contact.law.sticks
        for axis, row, _ in zip("xy", placed.rows, contact.along, strict=False)
    ]


def _of_equations(model: Model) -> dict[str, Any] | None:
    """Return the mechanism of equations of second order, by their derivatives."""
    evaluation, state = evaluation_of(model), _beside(model)
    rates, slopes = evaluation.linear(model, state, np.zeros(()))
    slopes = np.nan_to_num(slopes)
    row = {state.name: i for i, state in enumerate(model.states)}
    moved = velocities_of(model.kind)
    pairs = [(row[name], row[v]) for name, v in moved.items() if name not in moved.values()]
    memory = sum(len(item.law.memory(len(item.slip))) for item in contacts_of(model))
    if not pairs or 2 * len(pairs) + memory != len(model.states):
        return None
    place, speed = map(list, zip(*pairs, strict=True))
    later = evaluation.rates(model, state, 0.25)
    names = [model.states[i].name for i in speed]
    return _limited(
        {
            "bodies": [model.states[i].name for i in place],
            "springs": list(_links(-slopes[np.ix_(speed, place)])),
            "dashpots": list(_links(-slopes[np.ix_(speed, speed)])),
            "contacts": [
                {
                    "name": contact.name,
                    "bodies": sorted(
                        names.index(name)
                        for name in hy.get_variables([as_symbol(part) for part in contact.slip])
                        if name in names
                    ),
                    "moves": contact.plate_speed != hy.expression(0.0),
                }
                for contact in contacts_of(model)
            ],
            "forces": [i for i, row in enumerate(speed) if later[row] != rates[row]],
        }
    )


def _of_structure(model: Structure) -> dict[str, Any] | None:
    assembly = model._assembly
    if assembly.reduced:
        return None  # its states are no displacements of masses
    springs = list(_links(model.stiffness_matrix))
    contacts, forces = [], []
    for placed in assembly.placed:
        bodies = np.flatnonzero(np.any(placed.rows != 0, axis=0)).tolist()
        component = placed.component
        if isinstance(component, FrictionContact):
            moves = assembly.own_values(placed, model.values)["Vd"] > 0
            contacts.append(
                {"name": component.label or "contact", "bodies": bodies, "moves": moves}
            )
        elif isinstance(component, PeriodicForce):
            forces += bodies
        elif 0 < len(bodies) <= 2:
            springs.append([*bodies, -1][:2])
    # Damping by a rule is in every spring and on every mass, so it is not drawn.
    own = isinstance(assembly.definition.C, Matrix)
    dashpots = list(_links(model.damping_matrix)) if own else []
    return _limited(
        {
            "bodies": list(assembly.names),
            "springs": springs,
            "dashpots": dashpots,
            "contacts": contacts,
            "forces": sorted(set(forces)),
        }
    )


def _limited(mechanism: dict[str, Any]) -> dict[str, Any] | None:
    """Return a mechanism that can be drawn; None for one with too many parts."""
    bodies = len(mechanism["bodies"])
    if bodies > PAGE.bodies or len(mechanism["springs"]) > 3 * bodies:
        return None
    grounded = [link for link in mechanism["dashpots"] if link[1] < 0]
    if bodies > 3 and len(grounded) == bodies:
        mechanism["dashpots"] = [link for link in mechanism["dashpots"] if link[1] >= 0]
    return {"kind": "row", **mechanism}


def _links(matrix: Array) -> Iterator[list[int]]:
    """Yield the pairs that a matrix joins, and the rows that it ties to the ground."""
    sizes = np.abs(matrix).max(axis=1, initial=0.0)
    for row, size in enumerate(sizes):
        if abs(matrix[row].sum()) > NONE * size:
            yield [row, -1]
        for column in range(row):
            ways = abs(matrix[row, column]), abs(matrix[column, row])
            if ways[0] > NONE * size or ways[1] > NONE * sizes[column]:
                yield [column, row]


def _beside(model: Model) -> Array:
    """Return a state where springs that are soft in the middle have a stiffness."""
    scales = np.nan_to_num(model.declared_scales(), nan=1.0)
    return np.asarray(model.start + scales * np.linspace(0.31, 0.43, len(scales)))
