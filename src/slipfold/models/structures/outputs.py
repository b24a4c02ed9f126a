"""Outputs of a structure: watched displacements, measures of components, energy and powers."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from slipfold.arrays import Array
from slipfold.models.quantities import Expression, Output, Symbols
from slipfold.models.structures.assembly import GENERAL, Assembly, Placed
from slipfold.models.structures.component import total, weighted_sum


def outputs_of(assembly: Assembly) -> tuple[Output, ...]:
    """Return the outputs of the structure.

    The energy is that of structure and elements. Its rate is ``power_forcing + power_contacts +
    power_circulatory - power_damping``, where damping is that of structure and elements.
    """
    outputs = [
        Output(name, partial(_watched, assembly, row), "m", f"displacement {name}")
        for name, row in assembly.watched
    ]
    for item in assembly.placed:
        outputs += [_measured(assembly, item, measure) for measure in item.component._measures()]
    first = len(assembly.definition.elements)
    end = first + len(assembly.definition.contacts)
    energy, *powers = GENERAL
    if assembly.symmetric:
        doc = "kinetic and elastic energy of structure and elements"
        outputs.append(Output(energy, partial(_energy, assembly), "J", doc, "$E$ (J)"))
    functions: tuple[tuple[Any, str], ...] = (
        (partial(_damping_power, assembly), "power lost to damping"),
        (partial(_power, assembly, assembly.placed[end:]), "power put in by the forcing"),
        (partial(_power, assembly, assembly.placed[first:end]), "power put in by the contacts"),
    )
    if assembly.circulatory:
        powers.append("power_circulatory")
        functions += (
            (partial(_circulatory_power, assembly), "power put in by the circulatory matrix"),
        )
    for name, (function, doc) in zip(powers, functions, strict=True):
        outputs.append(Output(name, function, "W", doc, "$P$ (W)"))
    return tuple(outputs)


def _watched(
    assembly: Assembly, row: Array, q: Symbols, c: Symbols, phase: Expression
) -> Expression:
    return assembly.displacement(row, q)


def _measured(assembly: Assembly, item: Placed, measure: Output) -> Output:
    """Return a measure of a component as an output of the structure."""
    component = item.component
    doc = f"{measure.doc} ({component.label})" if component.label else measure.doc

    def expression(q: Symbols, c: Symbols, phase: Expression) -> Expression:
        local = assembly.local(item, q, c, phase)
        return measure.expression(local, local.c, local.phase)

    name = component._full_name(measure.name)
    return replace(measure, name=name, expression=expression, doc=doc)


def _form(assembly: Assembly, matrix: Array, q: Symbols, rate: str) -> list[Expression]:
    """Return the terms of a quadratic form of displacements or velocities, in SI units."""
    symbols = [q[f"{rate}{name}"] for name in assembly.names]
    even = (matrix + matrix.T) * (assembly.length**2 / 2)
    terms = []
    for row, symbol in enumerate(symbols):
        weights = even[row, row:] * np.where(np.arange(row, assembly.size) == row, 1.0, 2.0)
        parts = weighted_sum(weights, symbols[row:])
        terms += [symbol * total(parts)] if parts else []
    return terms


def _energy(assembly: Assembly, q: Symbols, c: Symbols, phase: Expression) -> Expression:
    terms = [
        *_form(assembly, assembly.mass / 2, q, "v"),
        *_form(assembly, assembly.stiffness / 2, q, ""),
    ]
    for name, matrix in assembly.inertia.parts:
        terms.append(0.5 * c[name] * total(_form(assembly, matrix, q, "v")))
    for key, matrix in assembly.stiffening:
        terms.append(0.5 * c[str(key)] * total(_form(assembly, matrix, q, "")))
    stored = (
        item.component._potential(assembly.local(item, q, c, phase)) for item in assembly.placed
    )
    return total([*terms, *stored])


def _damping_power(assembly: Assembly, q: Symbols, c: Symbols, phase: Expression) -> Expression:
    terms: list[Expression] = []
    for key, matrix in assembly.damping:
        form = _form(assembly, matrix, q, "v")
        terms += form if key is None else [c[key] * total(form)]
    lost = (
        item.component._dissipation(assembly.local(item, q, c, phase)) for item in assembly.placed
    )
    return total([*terms, *lost])


def _circulatory_power(assembly: Assembly, q: Symbols, c: Symbols, phase: Expression) -> Expression:
    terms = []
    for key, matrix in assembly.circulatory:
        for name, row in zip(assembly.names, matrix, strict=True):
            force = -assembly.displacement(row, q) * (1.0 if key is None else c[key])
            terms.append(force * q[f"v{name}"] * assembly.length)
    return total(terms)


def _power(
    assembly: Assembly, placed: tuple[Placed, ...], q: Symbols, c: Symbols, phase: Expression
) -> Expression:
    """Return the power of components."""
    terms = []
    for item in placed:
        local = assembly.local(item, q, c, phase)
        pairs = zip(item.component._forces(local), local.v, strict=True)
        terms += [force * speed for force, speed in pairs]
    return total(terms)
