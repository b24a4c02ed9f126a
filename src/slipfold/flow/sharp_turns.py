"""Sharp functions and invariant groups of states, which an integrator must watch.

Events watch functions that turn sharply. A group of states whose zero is invariant grows from its
present size: populations, infections, modes of a symmetry. Between two outbreaks it may fall far
below the error of a step of states of order one.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import heyoka as hy
import numpy as np

from slipfold.arrays import Array, Mask
from slipfold.errors import InputError
from slipfold.flow.compiled_code import numbers_of
from slipfold.flow.equations import Equations, Scaled
from slipfold.models.formulas.functions import compiled_function
from slipfold.models.quantities import Expression


@dataclass(frozen=True)
class Operand:
    """An operand of an operation."""

    # Index of the operation that gives it; None if it is constant along a trajectory
    index: int | None
    exponent: float = 1.0  # power to which it is raised; NaN if that is a parameter


@dataclass(frozen=True)
class Operation:
    """One elementary operation."""

    # ``"+"``, ``"*"``, ``"-"``, ``"/"``, ``"<"``, ``"power"``, a function's name, empty for a state
    name: str
    operands: tuple[Operand, ...]  # in order
    needed: tuple[int, ...]  # further operations that its series needs
    expression: Expression  # its value in the symbols of the equations
    moves: bool  # whether it changes along a trajectory


def take_apart(equations: Equations, outputs: Sequence[Expression] = ()) -> tuple[Operation, ...]:
    """Return the elementary operations of the rates, each after those it acts on."""
    states = [*equations.states, *(hy.expression(f"output {i}") for i in range(len(outputs)))]
    there: dict[Any, Any] = {c: hy.par[i] for i, c in enumerate(equations.coefficients)}
    there[equations.phase] = hy.time
    back = {inner: symbol for symbol, inner in there.items()}
    rates = hy.subs([*equations.rates, *outputs], there)
    count = len(states)
    result = [Operation("", (), (), state, True) for state in states]
    for item, needed in _decomposed(states, rates)[count:-count]:
        inner = {name: result[int(name.removeprefix("u_"))] for name in hy.get_variables(item)}
        name, operands = _read(str(item))
        operands = tuple(
            operand if operand.index is None or result[operand.index].moves else Operand(None)
            for operand in operands
        )
        moves = name == "time" or any(operation.moves for operation in inner.values())
        values = {hy.expression(key): operation.expression for key, operation in inner.items()}
        expression = hy.subs(item, {**values, **back})
        result.append(Operation(name, operands, tuple(needed), expression, moves))
    return tuple(result)


def _decomposed(states: Sequence[Any], rates: Sequence[Any]) -> list[tuple[Any, list[int]]]:
    # Only the decomposition is needed: low order, no optimization, and compact if it is long.
    return hy.taylor_adaptive(
        list(zip(states, rates, strict=True)),
        state=[0.0] * len(states),
        tol=0.5,
        compact_mode=len(states) > 60,
        opt_level=0,
    ).decomposition


def _read(text: str) -> tuple[str, tuple[Operand, ...]]:
    """Read an elementary operation as heyoka prints it; its arguments are names and numbers."""
    if text == "t":
        return "time", ()
    if match := re.fullmatch(r"\((.*)\)", text):
        sign = next((sign for sign in "-+*/<" if f" {sign} " in text), "?")
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


Group = tuple[int, ...]


class TURNS:
    """Events at sharp turns."""

    faster: float = (
        1.5  # change of the watched function of an invariant group over that of the state
    )
    flat: float = 36.0  # exp(-36) is rounding relative to 1
    steep_power: int = 15  # highest power whose coefficient is in the series at zero
    # Of events in the length of a step: edges are exact to 1e-4 for arguments up to 1e9
    weight: float = 1e-9
    cooldown: float = 1e-10  # phase after an edge: longer than rounding, shorter than a crossing


def relative_sizes(equations: Equations) -> list[Expression]:
    """Return functions between 0 and 1 that change with the relative size of invariant groups.

    The series of the sine of a logarithm is that of a power of the state. An integrator that
    watches it makes errors that are small relative to a small state.
    """
    arguments = [*equations.states, equations.phase, *equations.coefficients]
    compiled = compiled_function(equations.rates, arguments)
    more = len(arguments) - equations.dimension
    rest = np.random.default_rng(1).uniform(0.5, 1.5, more)

    def rates(states: Array) -> Array:
        inputs = np.column_stack([states, np.tile(rest, (len(states), 1))])
        return np.asarray(compiled(np.ascontiguousarray(inputs.T)).T)

    groups = invariant_groups(rates, equations.dimension)
    squares = [hy.sum([equations.states[i] * equations.states[i] for i in g]) for g in groups]
    return [0.5 + 0.4 * hy.sin(TURNS.faster / 2 * hy.log(each + 1e-300)) for each in squares]


def invariant_groups(rates: Callable[[Array], Array], count: int) -> list[Group]:
    """Return the smallest groups of states whose common zero is invariant.

    Shapes: states (m, n) of `rates`, which returns (m, n).

    >>> def epidemic(q):
    ...     s, e, i = q.T
    ...     return np.column_stack([1 - s - s * i, s * i - e, e - i])
    >>> invariant_groups(epidemic, 3)
    [(1, 2)]
    """
    groups = set[Group]()
    level: set[tuple[Group, int]] = {((first,), first) for first in range(count)}
    for size in range(1, 5):  # a susceptible is exposed, infected, in hospital, dead
        tried, level = sorted(level), set()
        if not tried:
            break
        zero = _vanishes(rates, count, [group for group, _ in tried])
        for (group, member), vanishing in zip(tried, zero, strict=True):
            fed = [i for i in group if not vanishing[i]]
            if not fed:
                # All states together are an equilibrium, not a group.
                groups.update({group} if size == 1 or size < count else ())
            elif size == 1 or vanishing[member]:
                others = set(range(count)).difference(group)
                level |= {(tuple(sorted((*group, i))), fed[0]) for i in others}
    return sorted(group for group in groups if not any(set(g) < set(group) for g in groups))


def _vanishes(rates: Callable[[Array], Array], count: int, groups: list[Group]) -> Mask:
    """Whether each rate vanishes where a group does, shape (number of groups, n)."""
    states = np.random.default_rng(2).uniform(0.5, 1.5, (len(groups), 2, count))  # random places
    for index, group in enumerate(groups):
        states[index, :, list(group)] = 0.0
    result = rates(states.reshape(-1, count)).reshape(states.shape)
    return np.asarray((result == 0).all(axis=1))


EDGES = {
    **dict.fromkeys(("exp", "sinh", "cosh", "sigmoid"), TURNS.flat),
    "tanh": TURNS.flat / 2,
    "erf": math.sqrt(TURNS.flat),
}
"""Arguments beyond which functions or their reciprocals are flat."""


VERSION = f"turns of powers, decoupled apart, no corners={numbers_of(TURNS)}"
"""Version of the events, part of the keys of stored code."""

# heyoka warns on the terminal if a trajectory with events ends in NaN, which is data here.
hy.set_logger_level_error()


@dataclass(frozen=True)
class SharpTurns:
    """Events for the integrators of a system, in its symbols."""

    # A step ends where one of these becomes positive, or negative
    rising: tuple[Expression, ...] = ()
    falling: tuple[Expression, ...] = ()
    # These are positive, without events; their poles close to the turns shorten the steps
    watched: tuple[Expression, ...] = ()
    # These are positive as well: relative sizes of invariant groups
    invariant: tuple[Expression, ...] = ()

    def scaled(self, scaled: Scaled) -> SharpTurns:
        """Return the same for an integrator in scaled states."""
        express = scaled.express
        parts = (self.rising, self.falling, self.watched, self.invariant)
        return SharpTurns(*(tuple(express(part)) for part in parts))

    def events(self, known: Mapping[str, Expression], *, batch: bool) -> list[Any]:
        """Return the terminal events of an integrator."""
        event = hy.t_event_batch if batch else hy.t_event
        up, down = hy.event_direction.positive, hy.event_direction.negative
        directed = [*((item, up) for item in self.rising), *((item, down) for item in self.falling)]
        edges = [
            event(
                hy.subs(item, known),
                callback=_continues,
                cooldown=TURNS.cooldown,
                direction=direction,
            )
            for item, direction in directed
        ]
        return edges + [event(hy.subs(item, known)) for item in self.watched]

    def passed(self, known: Mapping[str, Expression], *, batch: bool) -> list[Any]:
        """Return the other events of an integrator; terminal ones determine its step budget."""
        event = hy.nt_event_batch if batch else hy.nt_event
        return [event(hy.subs(item, known), callback=_continues) for item in self.invariant]


@lru_cache(maxsize=64)  # the integrators of a system have the same: one trajectory, many, phases
def sharp_turns(equations: Equations, outputs: tuple[Expression, ...] = ()) -> SharpTurns:
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
        rising.append(TURNS.weight * (argument + edge))
        falling.append(TURNS.weight * (argument - edge))
    for index, exponent in sorted(set(_steep_powers(operations))):
        base = operations[index].expression
        small, large = math.exp(-TURNS.flat / exponent), math.exp(TURNS.flat / exponent)
        rising += [TURNS.weight * (base - small), TURNS.weight * (base + large)]
        falling += [TURNS.weight * (base + small), TURNS.weight * (base - large)]
    sums = [operations[index].expression for index in sorted(set(_smoothed(operations)))]
    angles = {_index(item) for item in operations if item.name == "atan" and item.moves}
    sums += [1.0 + operations[index].expression ** 2.0 for index in sorted(angles)]
    # Squared, because a sum may be negative.
    watched = [1.0 + TURNS.weight * hy.log(item**2.0) for item in sums]
    invariant = relative_sizes(equations)
    return SharpTurns(tuple(rising), tuple(falling), tuple(watched), tuple(invariant))


def _has_corner(operations: Sequence[Operation], operation: Operation) -> bool:
    """Whether it switches; ``select(x*x < c, ...)`` is that of `exprel`, which is smooth there."""
    if not operation.moves:
        return False
    if operation.name == "<" and operation.operands[1].index is None:
        return _power(operations, _index(operation))[1] != 2
    return operation.name in ("<", "?") or "relu" in operation.name


def _saturations(operations: Sequence[Operation]) -> Iterator[tuple[int, float]]:
    """Arguments of functions that are flat far from zero, and how far that is.

    A power such as 1/cosh(v)^2 is flat nearer to zero.
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
                result = _index(operations[inner]), EDGES[operations[inner].name]
                times[result] = times.get(result, 0.0) + abs(exponent)
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
        if abs(exponent) > TURNS.steep_power:
            yield base, abs(exponent)


def _smoothed(operations: Sequence[Operation]) -> Iterator[int]:
    """Sums such as v^2 + e^2 that must not vanish, although e may be small."""
    for index in _singular(operations):
        addends = list(_addends(operations, index))
        constant = any(addend is None for addend, _ in addends)
        if constant and any(_bends(operations, *addend) for addend in addends):
            yield index


def _singular(operations: Sequence[Operation]) -> Iterator[int]:
    """Denominators, and arguments of logarithms, roots and angles."""
    for operation in operations:
        if operation.name == "atan2":
            yield from operation.needed
        elif operation.name in ("/", "log", "power"):
            last = operation.operands[-1]
            natural = last.exponent >= 0 and last.exponent == round(last.exponent)
            regular = operation.name == "power" and natural
            if last.index is not None and not regular:
                yield last.index


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
    """Whether an operation is nonlinear without edges of its own."""
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
        result = [
            (base, exponent * operand.exponent)
            for operand in operation.operands
            if operand.index is not None
            for base, exponent in [_power(operations, operand.index)]
        ]
        if len(result) == len(operation.operands) and len({base for base, _ in result}) == 1:
            return result[0][0], sum(exponent for _, exponent in result)
    return index, 1.0


def _index(operation: Operation) -> int:
    index = operation.operands[0].index
    assert index is not None
    return index


def _continues(*_: object) -> bool:
    """Continue after an event; a callback that also gets the time for other events."""
    return True
