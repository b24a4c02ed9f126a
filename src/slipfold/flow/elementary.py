"""Equations taken apart into elementary operations, as heyoka does it for its Taylor series."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import heyoka as hy

from slipfold.flow.equations import Equations
from slipfold.models.output import Expression

COMPARED = "?"
"""Name of all comparisons but ``"<"``."""


@dataclass(frozen=True)
class Operand:
    """What an operation acts on."""

    # Which operation it is the result of; None for what is constant along a motion
    index: int | None
    exponent: float = 1.0  # power to which it is raised; NaN if that is a parameter


@dataclass(frozen=True)
class Operation:
    """One elementary operation."""

    # ``"+"``, ``"*"``, ``"-"``, ``"/"``, ``"<"``, ``"power"``, a function's name, empty for a state
    name: str
    operands: tuple[Operand, ...]  # what it acts on, in order
    needed: tuple[int, ...]  # operations that its series needs beside those it acts on
    expression: Expression  # its value in the symbols of the equations
    moves: bool  # whether it changes along a motion


def take_apart(equations: Equations, outputs: Sequence[Expression] = ()) -> tuple[Operation, ...]:
    """Return the elementary operations of the rates, each after those it acts on."""
    states = [*equations.states, *(hy.expression(f"output {i}") for i in range(len(outputs)))]
    there: dict[Any, Any] = {c: hy.par[i] for i, c in enumerate(equations.coefficients)}
    there[equations.phase] = hy.time
    back = {inner: symbol for symbol, inner in there.items()}
    rates = hy.subs([*equations.rates, *outputs], there)
    count = len(states)
    found = [Operation("", (), (), state, True) for state in states]
    for item, needed in _decomposed(states, rates)[count:-count]:
        inner = {name: found[int(name.removeprefix("u_"))] for name in hy.get_variables(item)}
        name, operands = _read(str(item))
        operands = tuple(
            operand if operand.index is None or found[operand.index].moves else Operand(None)
            for operand in operands
        )
        moves = name == "time" or any(operation.moves for operation in inner.values())
        values = {hy.expression(key): operation.expression for key, operation in inner.items()}
        expression = hy.subs(item, {**values, **back})
        found.append(Operation(name, operands, tuple(needed), expression, moves))
    return tuple(found)


def _decomposed(states: Sequence[Any], rates: Sequence[Any]) -> list[tuple[Any, list[int]]]:
    # Compiled for its decomposition alone: of low order, and nothing is optimised.
    return hy.taylor_adaptive(
        list(zip(states, rates, strict=True)),
        state=[0.0] * len(states),
        tol=0.5,
        compact_mode=True,
        opt_level=0,
    ).decomposition


def _read(text: str) -> tuple[str, tuple[Operand, ...]]:
    """Read an elementary operation as heyoka prints it; its arguments are names and numbers."""
    if text == "t":
        return "time", ()
    if match := re.fullmatch(r"\((.*)\)", text):
        sign = next((sign for sign in "-+*/<" if f" {sign} " in text), COMPARED)
        return sign, _operands(match[1].split(f" {sign} "))
    if match := re.fullmatch(r"(\w+)\((.*)\)", text):
        name = {"div": "/", "sub": "-"}.get(match[1], match[1])
        return name, _operands(match[2].split(", "))
    if "**" in text:
        return "power", _operands([text])
    return "-", _operands([text.removeprefix("-")])


def _operands(texts: Sequence[str]) -> tuple[Operand, ...]:
    return tuple(_operand(text) for text in texts)


def _operand(text: str) -> Operand:
    base, _, exponent = text.partition("**")
    match = re.fullmatch(r"u_(\d+)", base)
    if match is None:
        return Operand(None)
    try:
        return Operand(int(match[1]), float(exponent or 1.0))
    except ValueError:
        return Operand(int(match[1]), math.nan)
