"""Objects that print as one line, and as a table in a notebook."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import MISSING, Field, fields
from typing import Any, Protocol

from slipfold.text.printed_table import PrintedTable, with_unit

LISTED = 6
"""Names that a line lists before it counts the rest."""


class NamedQuantity(Protocol):
    """A parameter, state or output."""

    @property
    def name(self) -> str:
        """The name in the model."""
        ...

    @property
    def unit(self) -> str:
        """The SI unit."""
        ...


class OneLine:
    """Base of data classes (with ``repr=False``) that print as `_line`, in notebooks as `_rows`."""

    def _line(self) -> str:
        """Return a summary in one short line."""
        raise NotImplementedError

    def _rows(self) -> PrintedTable:
        """Return a table with numbers, for notebooks."""
        raise NotImplementedError

    def __repr__(self) -> str:
        return f"<{self._line()}>"

    def _repr_html_(self) -> str:
        return self._rows().html(self._line())


def call_text(options: Any) -> str:
    """Return the call that makes a data class, with the fields that are not defaults.

    >>> from slipfold.continuation.settings import Steps
    >>> call_text(Steps(largest=0.05))
    'Steps(largest=0.05)'
    """
    values = {item.name: getattr(options, item.name) for item in fields(options)}
    changed = [
        f"{item.name}={values[item.name]!r}"
        for item in fields(options)
        if values[item.name] != _default(item)
    ]
    return f"{type(options).__name__}({', '.join(changed)})"


def _default(item: Field[Any]) -> Any:
    return item.default if item.default_factory is MISSING else item.default_factory()


def listed(names: Iterable[str], none: str = "") -> str:
    """Return the first few names, and how many more there are.

    >>> listed(["PD", "NS", "NS"])
    'PD, NS, NS'
    >>> listed(str(i) for i in range(9))
    '0, 1, 2, 3, 4, 5 and 3 more'
    """
    known = list(names)
    more = f" and {len(known) - LISTED} more" if len(known) > LISTED else ""
    return ", ".join(known[:LISTED]) + more or none


def headed(item: NamedQuantity) -> str:
    """Return the name of a quantity with its unit, e.g. ``"Nd (N)"``."""
    return f"{item.name} ({item.unit})" if item.unit else item.name


def number_text(value: float | None, digits: int = 6) -> str:
    """Return a number as lines and tables show it, nothing for None."""
    return "" if value is None else f"{value:.{digits}g}"


def certain(value: float, uncertainty: float) -> float:
    """Return a value, and zero where it is no further from zero than it is uncertain.

    >>> certain(-3.5e-14, 6.6e-14), certain(0.5, 1e-12)
    (0.0, 0.5)
    """
    return 0.0 if abs(value) <= uncertainty < math.inf else value


def parameter_text(parameter: NamedQuantity, *values: float) -> str:
    """Return e.g. ``"Nd = 0 to 0.98 N"``."""
    span = " to ".join(map(number_text, values))
    return with_unit(f"{parameter.name} = {span}", parameter.unit)


def capitalized(text: str, named: Iterable[NamedQuantity]) -> str:
    """Return a sentence with a capital letter, unless it begins with the name of a quantity."""
    names = [item.name for item in named]
    return text if text.split(" ")[0] in names else text[:1].upper() + text[1:]
