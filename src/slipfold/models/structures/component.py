"""What elements, contacts and forcing have in common: forces along directions of a structure."""

from __future__ import annotations

import dataclasses
import math
import re
from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, Self

import heyoka as hy
import numpy as np
from numpy.typing import NDArray

from slipfold.errors import InputError
from slipfold.models.friction.quantities import declared, is_symbolic
from slipfold.models.output import Expression, Limit, Output, Symbols
from slipfold.models.parameter import Parameter, State
from slipfold.models.quantity import parse_quantity
from slipfold.models.suggestion import suggest
from slipfold.text.one_line import listed

LONGEST_LINE = 60


def shown(value: Any) -> str:
    """Return a value as it would be typed, on one line and not too long.

    >>> shown("tip")
    "'tip'"
    """
    try:
        text = " ".join(repr(value).split())
    except ValueError:  # a whole number of more digits than Python prints
        text = f"a {type(value).__name__}"
    return text if len(text) <= LONGEST_LINE else f"{text[: LONGEST_LINE - 3]}..."


@dataclass(frozen=True)
class Parametric:
    """A part of a structure with parameters of its own; immutable, comparable, picklable.

    A subclass is a frozen dataclass whose parameters are fields made by `described`. The other
    fields tell equations apart.

    Raises
    ------
    InputError
        For a wrong unit, a value outside its bounds or values that contradict each other.
    """

    def __post_init__(self) -> None:
        """Check the fields and convert what has a unit."""
        self.prepare()
        for parameter in self.own_parameters:
            if any(item.name == parameter.name for item in declared(type(self))):
                value = getattr(self, parameter.name)
                number = parse_quantity(value, parameter.unit, parameter.name)
                object.__setattr__(self, parameter.name, parameter.check(number))
        self.check(self.own_values)

    def prepare(self) -> None:
        """Check and convert the fields that are not parameters; raise `InputError` if they fail."""

    def check(self, values: Mapping[str, float]) -> None:
        """Raise `InputError` if parameter values contradict each other.

        Parameters
        ----------
        values
            Values of the part's own parameters by their own names.
        """

    @property
    def own_parameters(self) -> tuple[Parameter, ...]:
        """Names, units, bounds and meanings of the parameters."""
        return declared(type(self))

    @property
    def own_values(self) -> dict[str, float]:
        """Values of the parameters by name, in SI units."""
        return {parameter.name: getattr(self, parameter.name) for parameter in self.own_parameters}

    @property
    def kind(self) -> Self:
        """The part with default values: equal for all parts with the same equations."""
        defaults = {item.name: item.default for item in declared(type(self))}
        return dataclasses.replace(self, **defaults)


def cos_sin(angle: Expression) -> tuple[Expression, Expression]:
    """Return the cosine and the sine."""
    if is_symbolic(angle):
        return hy.cos(angle), hy.sin(angle)
    return math.cos(angle), math.sin(angle)


def wave(harmonic: int, phase: Expression) -> tuple[Expression, Expression]:
    """Return the cosine and the sine of a harmonic of the forcing."""
    return cos_sin(2 * math.pi * harmonic * phase)


def product(weight: float, symbol: Expression) -> Expression:
    """Return ``weight * symbol``, without a factor of 1."""
    return symbol if weight == 1 else weight * symbol


def weighted_sum(weights: Iterable[float], symbols: Iterable[Expression]) -> list[Expression]:
    """Return the terms of a sum, those with a weight of zero left out."""
    pairs = zip(weights, symbols, strict=True)
    return [product(float(weight), symbol) for weight, symbol in pairs if weight != 0]


def total(terms: list[Expression]) -> Expression:
    """Return the sum of expressions; zero if there are none."""
    # One sum of many terms compiles faster than a chain of sums of two.
    return hy.sum(terms) if terms else hy.expression(0.0)


@dataclass(frozen=True)
class Direction:
    """A weighted sum of degrees of freedom: the displacement ``u = sum w_i q_i``.

    A force F along it acts on each degree of freedom with ``w_i F``, so that its power is ``F u'``.
    The weights are taken as they are given, so that ``{"a": 1, "b": -1}`` is the displacement of a
    relative to b.

    >>> print(Direction((("x", 0.6), ("y", 0.8))))
    0.6 x + 0.8 y
    """

    weights: tuple[tuple[str, float], ...]  # name and weight of each degree of freedom; no unit

    def __str__(self) -> str:
        """Write the sum."""
        parts = [name if weight == 1 else f"{weight:g} {name}" for name, weight in self.weights]
        return " + ".join(parts).replace("+ -", "- ")

    def vector(self, names: Sequence[str]) -> NDArray[np.float64]:
        """Return the weights in the order of the degrees of freedom, shape (n,)."""
        result = np.zeros(len(names))
        places = {name: place for place, name in enumerate(names)}
        for name, weight in self.weights:
            if name not in places:
                raise InputError(
                    f"the structure has no degree of freedom {shown(name)}; {suggest(name, names)}"
                    f"it has {listed(names)}"
                )
            result[places[name]] = weight
        return result


def as_direction(value: Any, what: str) -> Direction:
    """Make a direction of a name or of weights by name.

    >>> as_direction("tip", "a spring")
    Direction(weights=(('tip', 1.0),))
    """
    if isinstance(value, Direction):
        return value
    if isinstance(value, str):
        return Direction(((value, 1.0),))
    if not isinstance(value, Mapping) or not all(isinstance(name, str) for name in value):
        raise InputError(
            f"{what} acts at {shown(value)}, which is not a direction; give the name of a degree "
            'of freedom, or weights by name such as {"x": 0.6, "y": 0.8}'
        )
    weights = {name: _weight(name, weight, what) for name, weight in value.items()}
    kept = tuple((name, weight) for name, weight in weights.items() if weight)
    if not kept:
        raise InputError(
            f"the direction of {what} is zero; give at least one degree of freedom a weight that "
            "is not zero"
        )
    return Direction(kept)


def as_directions(value: Any, what: str, most: int) -> tuple[Direction, ...]:
    """Make one to `most` directions of one, or of a sequence of them."""
    several = value if isinstance(value, list | tuple) else (value,)
    if not 1 <= len(several) <= most:
        raise InputError(f"{what} acts along {len(several)} directions; give 1 to {most} of them")
    directions = tuple(as_direction(item, what) for item in several)
    names = sorted({name for item in directions for name, _ in item.weights})
    vectors = np.array([item.vector(names) for item in directions])
    sizes = np.linalg.norm(vectors, axis=1, keepdims=True)
    if np.linalg.matrix_rank(vectors / sizes) < len(directions):
        listed_directions = ", ".join(str(item) for item in directions)
        raise InputError(
            f"the directions {listed_directions} of {what} lie in one another; give directions at "
            "right angles"
        )
    return directions


def _weight(name: str, weight: Any, what: str) -> float:
    try:
        number = float(weight)
    except (TypeError, ValueError):
        number = math.nan
    if not math.isfinite(number):
        raise InputError(
            f"the direction of {what} has the weight {shown(weight)} for {name}; give a "
            "finite number"
        )
    return number


NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,59}")
"""Names of degrees of freedom and components, so that they can be written anywhere."""


Forces = tuple[Expression | None, ...]
"""Forces along the directions of a component in N; None where there is none."""


@dataclass(frozen=True)
class Motion:
    """How the structure moves where a component acts; symbols."""

    displacement: tuple[Expression, ...]  # along each direction of the component, in m
    velocity: tuple[Expression, ...]  # along each direction, in m/s
    memory: tuple[Expression, ...] = ()  # states of the component's own
    # Along each direction, in m/s^2; there for the rates of the memory alone
    acceleration: tuple[Expression, ...] = ()
    # Forces of a contact where they are given instead of following from its law
    normal: Expression | None = None
    friction: tuple[Expression, ...] | None = None


@dataclass(frozen=True)
class Component(Parametric, ABC):
    """A part of a structure that exerts forces on it.

    A subclass gives `directions` and `forces`. The parameters of a component with a name end in
    ``_name``; without a name they are called as its formula says, which goes for one of its kind.

    Parameters
    ----------
    name
        Tells components of one kind apart; empty if there is one only. Of several without a name
        each is named by where it acts.
    """

    title: ClassVar[str] = "component"

    inertial: ClassVar[bool] = False
    """Whether forces act with the masses along the direction, as those of a moving base do."""

    name: Any = field(default="", kw_only=True)

    def __post_init__(self) -> None:
        """Check the name, then the other fields."""
        if not isinstance(self.name, str) or (self.name and not NAME.fullmatch(self.name)):
            raise InputError(
                f"{shown(self.name)} cannot name a {self.title}; give letters, digits and _, "
                "a letter first"
            )
        super().__post_init__()

    # -- what a subclass gives -----------------------------------------------------------------

    @property
    @abstractmethod
    def directions(self) -> tuple[Direction | None, ...]:
        """Where the component acts; None stands for all degrees of freedom with the weight 1."""

    @abstractmethod
    def forces(self, motion: Motion, c: Symbols, phase: Expression) -> Forces:
        """Forces on the structure along the directions, in N; None where there is none.

        Parameters
        ----------
        motion
            How the structure moves there.
        c
            The coefficients by their own names.
        phase
            Time divided by the forcing period.
        """

    def coefficients(self, p: Symbols) -> dict[str, Expression]:
        """Combinations of parameters that the forces use.

        Parameters
        ----------
        p
            The component's parameters by their own names, and ``f`` in Hz if there is a forcing.
        """
        return {parameter.name: p[parameter.name] for parameter in self.own_parameters}

    amplitude: ClassVar[str | None] = None
    """Name of the parameter that switches off what is periodic in time, if it is one."""

    @property
    def amplitudes(self) -> tuple[str, ...]:
        """Names of the parameters that switch off what is periodic in time."""
        return () if self.amplitude is None else (self.amplitude,)

    def memory(self) -> tuple[State, ...]:
        """Return the component's own states."""
        return ()

    def memory_rates(self, motion: Motion, c: Symbols, phase: Expression) -> tuple[Expression, ...]:
        """Return the rates of the component's own states, per second.

        Parameters
        ----------
        motion
            How the structure moves there, with its acceleration.
        c
            The coefficients by their own names.
        phase
            Time divided by the forcing period.
        """
        return ()

    def steady_memory(self, values: Mapping[str, float]) -> tuple[float, ...]:
        """Return the component's own states where the structure rests for long.

        Parameters
        ----------
        values
            Parameter values by their own names.
        """
        return ()

    def memory_scale(self, values: Mapping[str, float]) -> float:
        """Return the typical size of the component's own states.

        Parameters
        ----------
        values
            Parameter values by their own names.
        """
        return 1.0

    def potential(self, motion: Motion, c: Symbols) -> Expression | None:
        """Return the energy the component stores, in J; None if it stores none.

        Parameters
        ----------
        motion
            How the structure moves there.
        c
            The coefficients by their own names.
        """
        return None

    def dissipation(self, motion: Motion, c: Symbols) -> Expression | None:
        """Return the power an element takes out, in W; None if it takes none.

        Parameters
        ----------
        motion
            How the structure moves there.
        c
            The coefficients by their own names.
        """
        return None

    def measures(self) -> tuple[Output, ...]:
        """Return quantities of interest, as functions of how the structure moves there."""
        return ()

    def limits(self) -> tuple[Limit, ...]:
        """Return limits of validity; they watch measures."""
        return ()

    # -- what follows --------------------------------------------------------------------------

    def called(self, symbol: str) -> str:
        """Return what the structure calls a parameter, state or measure of the component.

        Parameters
        ----------
        symbol
            The component's own name for it.
        """
        return f"{symbol}_{self.name}" if self.name else symbol

    @property
    def public_names(self) -> list[str]:
        """What the structure calls the parameters, states and measures of the component."""
        own = [item.name for item in self.own_parameters]
        own += [item.name for item in self.memory()]
        own += [item.name for item in self.measures()]
        return [self.called(name) for name in own]

    @property
    def place(self) -> str:
        """The degrees of freedom on which the component acts, as a name; empty for all of them."""
        weights = [item.weights for item in self.directions if item is not None]
        joined = "_".join(name for pairs in weights for name, _ in pairs)
        return joined if NAME.fullmatch(joined) else ""

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The parameters by the names that the structure gives them."""
        return tuple(
            replace(item, name=self.called(item.name), symbol=self._symbol(item))
            for item in self.own_parameters
        )

    @property
    def values(self) -> dict[str, float]:
        """Parameter values by the names that the structure gives them, in SI units."""
        return {self.called(name): value for name, value in self.own_values.items()}

    def own(self, p: Mapping[str, Any]) -> dict[str, Any]:
        """Return the component's parameters by their own names.

        Parameters
        ----------
        p
            The structure's parameters by name, numbers or symbols.
        """
        return {item.name: p[self.called(item.name)] for item in self.own_parameters}

    def _symbol(self, parameter: Parameter) -> str:
        if not self.name or not parameter.symbol:
            return parameter.symbol
        return f"{parameter.symbol} {self.name}"


@dataclass(frozen=True)
class OneDirection(Component):
    """A component along one direction: a degree of freedom, or weights by name."""

    at: Any

    def prepare(self) -> None:
        """Read the direction."""
        object.__setattr__(self, "at", as_direction(self.at, f"a {self.title}"))

    @property
    def directions(self) -> tuple[Direction | None, ...]:
        """The one direction."""
        return (self.at,)


HIGHEST = 64
"""Highest harmonic; each one takes a cosine and a sine at every step of the integration."""


def checked_harmonic(value: Any, what: str, lowest: int = 1) -> int:
    """Return the number of a harmonic, or raise if it is none."""
    whole = isinstance(value, int | np.integer) and not isinstance(value, bool)
    if not whole or not lowest <= value <= HIGHEST:
        raise InputError(
            f"a {what} has the harmonic {shown(value)}; give a whole number from {lowest} to "
            f"{HIGHEST}"
        )
    return int(value)
