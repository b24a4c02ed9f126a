"""Variables that are made when they are written, so that not all are in memory at once."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any

from numpy.typing import NDArray

from slipfold.results.fields import Column
from slipfold.results.labelled_table import Variable


class Deferred(Mapping[str, Variable]):
    """Variables by name, each made anew whenever it is looked at."""

    def __init__(self) -> None:
        self._made: dict[str, Callable[[], Variable]] = {}

    def add(
        self,
        name: str,
        column: Column,
        dimensions: tuple[str, ...],
        values: Callable[[], NDArray[Any]],
    ) -> None:
        """Take note of a variable, and of how to come by its values."""
        self._made[name] = lambda: column.variables(name, dimensions, values())[name]

    def __getitem__(self, name: str) -> Variable:
        return self._made[name]()

    def __iter__(self) -> Iterator[str]:
        return iter(self._made)

    def __len__(self) -> int:
        return len(self._made)
