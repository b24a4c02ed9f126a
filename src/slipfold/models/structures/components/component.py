"""What elements, contacts and forcing have in common: forces along directions of a structure."""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar

from slipfold.errors import InputError
from slipfold.models.output import Expression, Limit, Symbols
from slipfold.models.parameter import Parameter, State
from slipfold.models.structures.components.direction import Direction
from slipfold.models.structures.parametric import Parametric
from slipfold.models.structures.shown import shown

NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,59}")
"""Names of degrees of freedom and components, so that they can be written anywhere."""


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
class Measure:
    """A quantity of a component that is of interest."""

    name: str  # name among the outputs, e.g. ``"Vrel"``
    # ``expression(motion, c, phase)`` with the component's coefficients by their own names
    expression: Callable[[Motion, Symbols, Expression], Expression]
    unit: str  # SI unit as text
    doc: str  # one line that says what it is
    label: str  # axis label in mathtext


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
    def forces(
        self, motion: Motion, c: Symbols, phase: Expression
    ) -> tuple[Expression | None, ...]:
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

    @property
    def amplitudes(self) -> tuple[str, ...]:
        """Names of the parameters that switch off what is periodic in time."""
        return ()

    @property
    def speeds(self) -> tuple[str, ...]:
        """Names of the parameters that are speeds of a counter-body."""
        return ()

    @property
    def sliding_speeds(self) -> tuple[str, ...]:
        """Names of those on which nothing can slide steadily while they are zero."""
        return ()

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

    def measures(self) -> tuple[Measure, ...]:
        """Return quantities of interest."""
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
