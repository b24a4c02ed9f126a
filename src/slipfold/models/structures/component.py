"""Components of a structure: they exert forces along directions of it."""

from __future__ import annotations

import math
import re
from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import heyoka as hy
import numpy as np

from slipfold.arrays import Array
from slipfold.errors import InputError, suggest
from slipfold.models.parametric import Parametric, structural
from slipfold.models.quantities import Expression, Limit, Output, Parameter, State, Symbols
from slipfold.models.structures.matrix_files import node_name
from slipfold.text import listed

NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,59}")
"""Names of degrees of freedom and components, so that they can be written anywhere."""

Forces = tuple[Expression, ...]
"""Forces along the directions of a component in N."""


def brief(value: Any) -> str:
    """Return a value as it would be typed, on one line and not too long."""
    try:
        text = " ".join(repr(value).split())
    except ValueError:  # a whole number of more digits than Python prints
        text = f"a {type(value).__name__}"
    return text if len(text) <= 60 else f"{text[:57]}..."


def is_whole(value: Any, least: int, most: float = math.inf) -> bool:
    """Whether something is a whole number, of Python or NumPy, between two bounds."""
    whole = isinstance(value, int | np.integer) and not isinstance(value, bool)
    return whole and bool(least <= value <= most)


def weighted_sum(weights: Iterable[float], symbols: Iterable[Expression]) -> list[Expression]:
    """Return the terms of a sum, without those of weight zero and without factors of one."""
    pairs = zip(map(float, weights), symbols, strict=True)
    return [symbol if weight == 1 else weight * symbol for weight, symbol in pairs if weight != 0]


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

    def vector(self, names: Sequence[str]) -> Array:
        """Return the weights in the order of the degrees of freedom, shape (n,)."""
        places = {name: place for place, name in enumerate(names)}
        vector = np.zeros(len(names))
        for name, weight in self.weights:
            if name.startswith(EVERY) and (all_of := degrees_along(name, names)):
                vector[all_of] = weight
                continue
            if name not in places:
                raise InputError(
                    f"the structure has no degree of freedom {brief(name)}; {suggest(name, names)}"
                    f"it has {listed(names)}"
                )
            vector[places[name]] = weight
        return vector


EVERY = "*:"
"""What the name of a direction at all nodes begins with."""


def degrees_along(name: str, names: Sequence[str]) -> list[int]:
    """Return the places of the degrees of freedom along a direction at all nodes."""
    form = re.compile(rf"{re.escape(name.removeprefix(EVERY))}(\d+|_\w+)")
    return [place for place, one in enumerate(names) if form.fullmatch(one)]


def _name_of(text: str) -> str:
    """Return the name of a degree of freedom that is given by node and direction, ``17:uz``."""
    node, colon, direction = text.partition(":")
    return node_name(node, direction) if colon and node != "*" else text


def as_direction(value: Any, title: str) -> Direction:
    """Make a direction of a name or of weights by name."""
    if isinstance(value, Direction):
        return value
    if isinstance(value, str):
        return Direction(((_name_of(value), 1.0),))
    if not isinstance(value, Mapping) or not all(isinstance(name, str) for name in value):
        raise InputError(
            f"a {title} acts at {brief(value)}, which is not a direction; give the name of a "
            'degree of freedom, or weights by name such as {"x": 0.6, "y": 0.8}'
        )
    weights = {_name_of(name): _weight(name, weight, title) for name, weight in value.items()}
    kept = tuple((name, weight) for name, weight in weights.items() if weight)
    if not kept:
        raise InputError(
            f"the direction of a {title} is zero; give at least one degree of freedom a weight "
            "that is not zero"
        )
    return Direction(kept)


def _weight(name: str, weight: Any, title: str) -> float:
    try:
        number = float(weight)
    except (TypeError, ValueError):
        number = math.nan
    if not math.isfinite(number):
        raise InputError(
            f"the direction of a {title} has the weight {brief(weight)} for {name}; give a "
            "finite number"
        )
    return number


def as_directions(value: Any, title: str, most: int = 2) -> tuple[Direction, ...]:
    """Make one to `most` directions of one, or of a sequence of them."""
    several = value if isinstance(value, list | tuple) else (value,)
    if not 1 <= len(several) <= most:
        raise InputError(
            f"a {title} acts along {len(several)} directions; give 1 to {most} of them"
        )
    directions = tuple(as_direction(item, title) for item in several)
    names = sorted({name for item in directions for name, _ in item.weights})
    vectors = np.array([item.vector(names) for item in directions])
    lengths = np.linalg.norm(vectors, axis=1, keepdims=True)
    if np.linalg.matrix_rank(vectors / lengths) < len(directions):
        raise InputError(
            f"the directions {', '.join(map(str, directions))} of a {title} lie in one another; "
            "give directions at right angles"
        )
    return directions


@dataclass(frozen=True)
class Sector:
    """Where a component stands that repeats one of a given sector."""

    number: int  # counted from the given sector
    lag: float  # by which it is later, in forcing periods


@dataclass(frozen=True)
class LocalState:
    """State of a structure where a component acts, and the coefficients there; symbols."""

    q: Symbols  # states of the structure by name
    c: Symbols  # coefficients of the component by their own names
    phase: Expression  # time divided by the forcing period
    # Displacement in m and velocity in m/s along each direction of the component
    u: tuple[Expression, ...]
    v: tuple[Expression, ...]
    memory: tuple[Expression, ...] = ()  # states of the component's own
    a: tuple[Expression, ...] = ()  # acceleration in m/s^2; for the rates of the memory alone


def _checked_name(name: Any, title: str) -> str:
    if not isinstance(name, str) or (name and not NAME.fullmatch(name)):
        raise InputError(
            f"{brief(name)} cannot name a {title}; give letters, digits and _, a letter first"
        )
    return name


def _checked_group(group: Any, title: str) -> str | tuple[tuple[str, str], ...]:
    if isinstance(group, Mapping | tuple):
        pairs = dict(group)
        return tuple(
            (str(one), _checked_name(name, f"group of a {title}")) for one, name in pairs.items()
        )
    return _checked_name(group, f"group of a {title}")


@dataclass(frozen=True)
class Component(Parametric, ABC):
    """A part of a structure that exerts forces on it.

    A subclass gives `_directions` and `_forces`. The parameters of a component with a name end in
    ``_name``; without a name they have the names in its formula, which works for one of its kind.
    Of several components without a name each is named by where it acts. Those of a group end in
    the name of the group, and are the same parameters for all components of it.
    """

    title: ClassVar[str] = "component"

    sector: ClassVar[Sector | None] = None
    """Set for one that repeats another by cyclic symmetry: it shares its parameters."""

    inertial: ClassVar[bool] = False
    """Whether forces act with the masses along the direction, as those of a moving base do."""

    name: Any = structural(
        "name that distinguishes components of one kind; empty if there is only one",
        "",
        _checked_name,
        kw_only=True,
    )
    group: Any = structural(
        "name of a group of components, whose parameters are varied together: ``Ns_ring`` with "
        '``group="ring"``; or a group for some parameters, such as ``{"mu_k": "ring"}``. One '
        "of them may give the value",
        "",
        _checked_group,
        kw_only=True,
    )

    # -- what a subclass gives -----------------------------------------------------------------

    @property
    @abstractmethod
    def _directions(self) -> tuple[Direction | None, ...]:
        """Where the component acts; None stands for all degrees of freedom with the weight 1."""

    @abstractmethod
    def _forces(self, local: LocalState) -> Forces:
        """Forces on the structure along the directions, in N."""

    def _coefficients(self, p: Symbols) -> dict[str, Expression]:
        """Combinations of parameters that the forces use."""
        return {parameter.name: p[parameter.name] for parameter in self.parameters}

    @property
    def _amplitudes(self) -> tuple[str, ...]:
        """Names of the parameters that switch off what is periodic in time."""
        return ()

    def memory(self) -> tuple[State, ...]:
        """Return the component's own states."""
        return ()

    def _potential(self, local: LocalState) -> Expression:
        """Return the energy the component stores, in J."""
        return hy.expression(0.0)

    def _dissipation(self, local: LocalState) -> Expression:
        """Return the power that an element dissipates, in W."""
        return hy.expression(0.0)

    def _measures(self) -> tuple[Output, ...]:
        """Return quantities of interest; their expressions take a `LocalState` for the states."""
        return ()

    def limits(self) -> tuple[Limit, ...]:
        """Return limits of validity; they watch measures."""
        return ()

    def _later(self, phase: Expression) -> Expression:
        """Return the phase of the component where that of the given sector is known."""
        return phase - self.sector.lag if self.sector and self.sector.lag else phase

    # -- names in the structure ------------------------------------------------------------------

    @property
    def label(self) -> str:
        """Its name, and the sector where it repeats another; empty if it has neither."""
        number = f"s{self.sector.number}" if self.sector else ""
        return "_".join(filter(None, (self.name, number)))

    def _full_name(self, symbol: str) -> str:
        """Return the name of a state or measure of the component in the structure."""
        return f"{symbol}_{self.label}" if self.label else symbol

    def _group_of(self, symbol: str) -> str:
        """Return the name of the group that shares a parameter; empty if none does."""
        return self.group if isinstance(self.group, str) else dict(self.group).get(symbol, "")

    def _parameter_name(self, symbol: str) -> str:
        """Return the name of a parameter of the component in the structure."""
        group = self._group_of(symbol)
        return "_".join(filter(None, (symbol, group or self.name)))

    def _limit_name(self, limit: Limit) -> str:
        """Return the name of a limit of the component in the structure."""
        return f"{limit.name} of {self.label}" if self.label else limit.name

    @property
    def named_values(self) -> dict[str, float]:
        """The values of the parameters by the names that the structure gives them."""
        return {self._parameter_name(name): value for name, value in self.values.items()}

    @property
    def public_names(self) -> list[str]:
        """Names in the structure of the parameters, states and measures of the component alone."""
        alone = (item for item in self.parameters if not self._group_of(item.name))
        own: tuple[Any, ...] = (*alone, *self.memory(), *self._measures())
        return [self._full_name(item.name) for item in own]

    @property
    def location(self) -> str:
        """The degrees of freedom on which the component acts, as a name; empty for all of them."""
        weights = [item.weights for item in self._directions if item is not None]
        joined = "_".join(name for pairs in weights for name, _ in pairs)
        return joined if NAME.fullmatch(joined) else ""

    @property
    def named_parameters(self) -> tuple[Parameter, ...]:
        """The parameters by the names that the structure gives them."""
        return tuple(
            replace(
                item,
                name=self._parameter_name(item.name),
                symbol=item.symbol
                and f"{item.symbol} {self._group_of(item.name) or self.name}".rstrip(),
            )
            for item in self.parameters
        )

    def _own(self, p: Mapping[str, Any]) -> dict[str, Any]:
        """Return the component's parameters by their own names."""
        return {item.name: p[self._parameter_name(item.name)] for item in self.parameters}


@dataclass(frozen=True)
class OneDirection(Component):
    """A component along one direction: a degree of freedom, or weights by name."""

    at: Any = structural(
        'degree of freedom, or weights by name such as ``{"a": 1, "b": -1}``', read=as_direction
    )

    @property
    def _directions(self) -> tuple[Direction | None, ...]:
        """The one direction."""
        return (self.at,)


MAX_HARMONIC = 64
"""Highest harmonic; each one takes a cosine and a sine at every step of the integration."""


def checked_harmonic(value: Any, title: str, lowest: int = 1) -> int:
    """Return the number of a harmonic, or raise if it is none."""
    if not is_whole(value, lowest, MAX_HARMONIC):
        raise InputError(
            f"a {title} has the harmonic {brief(value)}; give a whole number from {lowest} to "
            f"{MAX_HARMONIC}"
        )
    return int(value)
