"""Where formulas turn sharply after being flat: events that end Taylor steps in time for it.

The length of a Taylor step follows from the last coefficients of the series. A saturated tanh is
exactly 1 in double precision and its coefficients are exactly 0; those of 1/(1 + (v/e)^2) far from
v = 0 are below any tolerance. The step is then chosen as if nothing were to come and leads past
the turn. But the arguments are smooth, so that events know when they come near.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import heyoka as hy

from slipfold.errors import InputError
from slipfold.flow.elementary import COMPARED, Operation, take_apart
from slipfold.flow.equations import Equations
from slipfold.flow.scaled import Scaled
from slipfold.flow.sizes.unfed import FASTER, relative_sizes
from slipfold.models.output import Expression

FLAT = 36.0
"""exp(-36) is rounding: an exponential is not seen beside 1."""

EDGES = {
    **dict.fromkeys(("exp", "sinh", "cosh", "sigmoid"), FLAT),
    "tanh": FLAT / 2,
    "erf": math.sqrt(FLAT),
}
"""Arguments beyond which functions, or what is divided by them, are flat."""

STEEP_POWER = 15
"""Highest power whose own coefficient, 1, is among those of a series at zero."""

WEIGHT = 1e-9
"""Events count in the length of a step as states do. With this weight an edge is known to 1e-4 or
better, arguments up to 1e9 do not loosen the tolerance, and a pole, of however small a residue,
ends a step at half of its distance."""

COOLDOWN = 1e-10
"""Phase in which an edge just met is not met again: more than rounding, less than a crossing."""

VERSION = f"turns of powers, unfed apart, no corners={FLAT, STEEP_POWER, WEIGHT, COOLDOWN, FASTER}"
"""What is compiled with other events differs."""

# Where a motion with events ends in NaN, heyoka warns on the terminal; here that is data.
hy.set_logger_level_error()


@dataclass(frozen=True)
class SharpTurns:
    """Events for the integrators of a system, in its symbols."""

    # A step ends where one of these becomes positive, or negative
    rising: tuple[Expression, ...] = ()
    falling: tuple[Expression, ...] = ()
    # These are positive and no event; but their poles, close to the turns, shorten the steps
    watched: tuple[Expression, ...] = ()
    # These are positive and no event either, and have nothing to do with turns: how large states
    # are that nothing feeds
    unfed: tuple[Expression, ...] = ()

    def scaled(self, scaled: Scaled) -> SharpTurns:
        """Return the same for an integrator in scaled states."""
        express = scaled.express
        parts = (self.rising, self.falling, self.watched, self.unfed)
        return SharpTurns(*(tuple(express(part)) for part in parts))

    def events(self, known: Mapping[str, Expression], *, batch: bool) -> list[Any]:
        """Return the terminal events of an integrator."""
        event = hy.t_event_batch if batch else hy.t_event
        up, down = hy.event_direction.positive, hy.event_direction.negative
        directed = [*((item, up) for item in self.rising), *((item, down) for item in self.falling)]
        edges = [
            event(hy.subs(item, known), callback=_go_on, cooldown=COOLDOWN, direction=direction)
            for item, direction in directed
        ]
        return edges + [event(hy.subs(item, known)) for item in self.watched]

    def passed(self, known: Mapping[str, Expression], *, batch: bool) -> list[Any]:
        """Return the other events of an integrator, which tells how patient it is by the former."""
        event = hy.nt_event_batch if batch else hy.nt_event
        return [event(hy.subs(item, known), callback=_go_on) for item in self.unfed]


def sharp_turns(equations: Equations, outputs: Sequence[Expression] = ()) -> SharpTurns:
    """Find the sharp turns of a system."""
    operations = take_apart(equations, outputs)
    if any(_has_corner(operations, item) for item in operations):
        raise InputError(
            "the equations of the model have a corner or a jump: they compare what moves, as in "
            "select(x < 0, -x, x), and a step of the integrator would lead past it; write a smooth "
            "function that is as steep, e.g. sqrt(x^2 + e^2) or tanh(x/e)"
        )
    rising, falling = [], []
    for index, edge in sorted(set(_saturations(operations))):
        argument = operations[index].expression
        rising.append(WEIGHT * (argument + edge))
        falling.append(WEIGHT * (argument - edge))
    for index, exponent in sorted(set(_steep_powers(operations))):
        base = operations[index].expression
        small, large = math.exp(-FLAT / exponent), math.exp(FLAT / exponent)
        rising += [WEIGHT * (base - small), WEIGHT * (base + large)]
        falling += [WEIGHT * (base + small), WEIGHT * (base - large)]
    sums = [operations[index].expression for index in sorted(set(_smoothed(operations)))]
    sums += [1.0 + operations[index].expression ** 2.0 for index in _arctangents(operations)]
    # Squared, because a sum may be negative too.
    watched = [1.0 + WEIGHT * hy.log(item**2.0) for item in sums]
    unfed = relative_sizes(equations)
    return SharpTurns(tuple(rising), tuple(falling), tuple(watched), tuple(unfed))


def _has_corner(operations: Sequence[Operation], operation: Operation) -> bool:
    """Whether it switches; ``select(x*x < c, ...)`` is that of `exprel`, which is smooth there."""
    if not operation.moves:
        return False
    if operation.name == "<" and operation.operands[1].index is None:
        return _power(operations, _index(operation))[1] != 2
    return operation.name in ("<", COMPARED) or "relu" in operation.name


def _saturations(operations: Sequence[Operation]) -> Iterator[tuple[int, float]]:
    """Arguments of functions that are flat far from zero, and how far that is.

    What is multiplied by itself, as 1/cosh(v)^2, is flat so much nearer to zero.
    """
    slopes = {index for item in operations if item.name == "erf" for index in item.needed}
    flat = {
        index
        for index, operation in enumerate(operations)
        if operation.moves and operation.name in EDGES and index not in slopes
        if not _is_switched(operations, _index(operation))
    }
    for index in flat:
        yield _index(operations[index]), EDGES[operations[index].name]
    for index in range(len(operations)):
        times: dict[tuple[int, float], float] = {}
        for base, exponent in _factors(operations, index):
            addends = {addend for addend, _ in _addends(operations, base) if addend is not None}
            for inner in {base, *addends} & flat:
                found = _index(operations[inner]), EDGES[operations[inner].name]
                times[found] = times.get(found, 0.0) + abs(exponent)
        for (argument, edge), power in times.items():
            if power > 1:
                yield argument, edge / power


def _factors(
    operations: Sequence[Operation], index: int, power: float = 1.0
) -> Iterator[tuple[int, float]]:
    """Moving factors of a product of products, and their exponents."""
    operation = operations[index]
    if operation.name not in ("*", "/", "power"):
        yield index, power
        return
    for operand in operation.operands:
        if operand.index is not None:
            yield from _factors(operations, operand.index, power * operand.exponent)


def _is_switched(operations: Sequence[Operation], index: int) -> bool:
    """Whether it is a multiple of ``select(x*x < c, x, 0)``, which stays far from any edge."""
    operation = operations[index]
    moving = [operand.index for operand in operation.operands if operand.index is not None]
    if operation.name == "*":
        return len(moving) == 1 and _is_switched(operations, moving[0])
    return operation.name == "select" and len(moving) == 2 and operations[moving[0]].name == "<"


def _steep_powers(operations: Sequence[Operation]) -> Iterator[tuple[int, float]]:
    """Bases of powers that are flat about zero, and their exponents."""
    for index in range(len(operations)):
        base, exponent = _power(operations, index)
        if abs(exponent) > STEEP_POWER:
            yield base, abs(exponent)


def _arctangents(operations: Sequence[Operation]) -> list[int]:
    """Arguments of arctangents."""
    return sorted({_index(item) for item in operations if item.name == "atan" and item.moves})


def _smoothed(operations: Sequence[Operation]) -> Iterator[int]:
    """Sums such as v^2 + e^2 that must not vanish: what keeps them from it may be small."""
    for index in _singular(operations):
        addends = list(_addends(operations, index))
        constant = any(addend is None for addend, _ in addends)
        if constant and any(_bends(operations, *addend) for addend in addends):
            yield index


def _singular(operations: Sequence[Operation]) -> Iterator[int]:
    """What something divides by, or takes the logarithm, a root or the angle of."""
    for operation in operations:
        if operation.name == "atan2":
            yield from operation.needed
        elif operation.name in ("/", "log", "power"):
            last = operation.operands[-1]
            regular = operation.name == "power" and _is_natural(last.exponent)
            if last.index is not None and not regular:
                yield last.index


def _is_natural(exponent: float) -> bool:
    return exponent >= 0 and exponent == round(exponent)


def _addends(operations: Sequence[Operation], index: int) -> Iterator[tuple[int | None, float]]:
    """Addends of a sum of sums: which operation, None if constant, and to which power."""
    if operations[index].name != "+":
        return
    for operand in operations[index].operands:
        inner = operand.index
        if inner is not None and operations[inner].name == "+" and operand.exponent == 1:
            yield from _addends(operations, inner)
        else:
            yield inner, operand.exponent


def _bends(operations: Sequence[Operation], index: int | None, exponent: float = 1.0) -> bool:
    """Whether something is not linear, and its edges are not known by themselves."""
    if index is None:
        return False
    operation = operations[index]
    if operation.name in ("*", "/"):
        moving = [item.index for item in operation.operands if item.index is not None]
        return len(moving) > 1 or exponent != 1 or _bends(operations, moving[0])
    return exponent != 1 or operation.name not in ("", "time", "+", "-", *EDGES)


def _power(operations: Sequence[Operation], index: int) -> tuple[int, float]:
    """Base and exponent of an operation; the exponent is 1 if it is no power."""
    operation = operations[index]
    if operation.moves and operation.name in ("*", "power"):
        found = [
            (base, exponent * operand.exponent)
            for operand in operation.operands
            if operand.index is not None
            for base, exponent in [_power(operations, operand.index)]
        ]
        if len(found) == len(operation.operands) and len({base for base, _ in found}) == 1:
            return found[0][0], sum(exponent for _, exponent in found)
    return index, 1.0


def _index(operation: Operation) -> int:
    index = operation.operands[0].index
    assert index is not None
    return index


def _go_on(*_: object) -> bool:
    """Whether to integrate on after an event; what passes no edge is given the time as well."""
    return True
