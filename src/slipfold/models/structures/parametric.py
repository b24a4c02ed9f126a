"""What has parameters of its own: the parts of a structure."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Self

from slipfold.models.friction.quantities import declared
from slipfold.models.parameter import Parameter
from slipfold.models.quantity import parse_quantity


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
        """Check and convert the fields that are no parameters; raise `InputError` if they fail."""

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
