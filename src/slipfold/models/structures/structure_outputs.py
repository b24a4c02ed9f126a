"""What a user asks of a structure besides its states: energy, powers, measures of components."""

from __future__ import annotations

from functools import partial

import numpy as np

from slipfold.models.output import Expression, Output, Symbols
from slipfold.models.structures.assembly import GENERAL, Assembly, Placed
from slipfold.models.structures.components.component import Measure
from slipfold.models.structures.components.sums import total, weighted_sum


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


def _measure(assembly: Assembly, item: Placed, measure: Measure) -> Output:
    component = item.component
    doc = f"{measure.doc} ({component.name})" if component.name else measure.doc
    function = partial(_measured, assembly, item, measure)
    return Output(component.called(measure.name), function, measure.unit, doc, measure.label)


def _measured(
    assembly: Assembly, item: Placed, measure: Measure, q: Symbols, c: Symbols, phase: Expression
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
