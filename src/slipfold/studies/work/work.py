"""What all computations of a study have in common: they make a model into a few numbers."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Literal, Self

from pydantic import BaseModel, ConfigDict

from slipfold.errors import InputError
from slipfold.flow.simulate import initial_state
from slipfold.models.followed import check_followed
from slipfold.models.model import Model
from slipfold.models.quantity import parse_quantity

Value = float | int | str | None
"""A number or a word; None where there is none."""

Span = tuple[float | str, float | str]

Start = dict[str, float | str]
"""Some states by name."""


@dataclass(frozen=True)
class Quantity:
    """What is found of every case under a name."""

    name: str
    kind: Literal["real", "whole", "text"]
    meaning: str
    unit: str = ""
    none: int | None = None  # the whole number that stands for none


@dataclass(frozen=True)
class Findings:
    """What was found of one case."""

    values: dict[str, Value]  # by the names of the quantities
    listed: tuple[dict[str, Value], ...] = ()  # special points or the like: any number of them


class Work(BaseModel):
    """Something to compute of every case; a subclass has its options as fields."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    listed: ClassVar[str] = "special"
    """What the things are called of which a case may have any number."""

    together_from: ClassVar[int] = 1
    """Cases of a study from which on they are computed side by side, as far as they can be."""

    side_by_side: ClassVar[int] = 1
    """Cases of a group then, at least: of fewer each takes longer."""

    what: str

    def varied(self) -> Collection[str]:
        """Return the parameters that this varies itself, so that cases cannot set them."""
        return ()

    @abstractmethod
    def checked(self, model: Model) -> Self:
        """Return it with all values in SI units; raise where the model cannot do it."""

    @abstractmethod
    def quantities(self, model: Model) -> tuple[Quantity, ...]:
        """Return what is found of every case."""

    def lists(self, model: Model) -> tuple[Quantity, ...]:
        """Return what is said of each thing of which a case may have any number."""
        return ()

    @abstractmethod
    def of(self, model: Model) -> Findings:
        """Compute it for one case."""

    def together(self, models: Sequence[Model]) -> list[Findings | None]:
        """Compute what can be computed of several cases side by side; None of all others.

        What is found of a case must not depend on which others are beside it.
        """
        return [None] * len(models)

    def record(self) -> dict[str, Any]:
        """Return it as plain data, from which it can be made again."""
        return self.model_dump(mode="json")


def parsed_span(model: Model, name: str, span: Span) -> tuple[float, float]:
    """Return the ends of a span in which orbits are followed, in SI units."""
    check_followed(model)
    parameter = model.variable_parameter(name)
    first, last = (parameter.check(parse_quantity(end, parameter.unit, name)) for end in span)
    if first == last:
        raise InputError(f"the span of {name} is empty; give two different values")
    return first, last


def parsed_start(model: Model, start: Start) -> dict[str, float]:
    """Return starting states in their units."""
    units = {state.name: state.unit for state in model.states}
    parsed = {
        name: parse_quantity(value, units.get(name, ""), name) for name, value in start.items()
    }
    initial_state(model, parsed)  # complains of a state that there is not
    return parsed
