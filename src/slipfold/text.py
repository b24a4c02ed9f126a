"""Results in words: one line, tables for terminals and notebooks, stability, revolutions."""

from __future__ import annotations

import html
import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import MISSING, Field, dataclass, fields
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class PrintedTable:
    """Cells of text under heads."""

    heads: Sequence[str]  # heads of the columns
    lines: Sequence[Sequence[str]]  # the lines, as many cells each as there are heads
    # Heads of the columns that hold words, which stand to the left; numbers stand to the right
    words: Collection[str] = ()

    def text(self) -> list[str]:
        """Return it as lines of text, the heads first."""
        columns = zip(self.heads, *self.lines, strict=True)
        widths = [max(len(cell) for cell in column) for column in columns]
        return [
            "  ".join(
                cell.ljust(width) if head in self.words else cell.rjust(width)
                for head, cell, width in zip(self.heads, line, widths, strict=True)
            ).rstrip()
            for line in [self.heads, *self.lines]
        ]

    def html(self, caption: str) -> str:
        """Return it as an HTML table."""
        body = "".join(_html_line(line, "td") for line in self.lines)
        return (
            f"<table><caption>{html.escape(caption)}</caption>"
            f"<thead>{_html_line(self.heads, 'th')}</thead><tbody>{body}</tbody></table>"
        )


def _html_line(cells: Sequence[str], tag: str) -> str:
    inside = "".join(f"<{tag}>{html.escape(cell)}</{tag}>" for cell in cells)
    return f"<tr>{inside}</tr>"


def html_list(sentences: Iterable[str]) -> str:
    """Return sentences as an HTML list."""
    return f"<ul>{''.join(f'<li>{html.escape(text)}</li>' for text in sentences)}</ul>"


def with_unit(text: str, unit: str) -> str:
    """Return text with a unit behind it, if there is one."""
    return f"{text} {unit}".rstrip()


LISTED = 6
"""Names that a line lists before it counts the rest."""


class NamedQuantity(Protocol):
    """A parameter, state or output."""

    @property
    def name(self) -> str:
        """The name in the model."""

    @property
    def unit(self) -> str:
        """The SI unit."""


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


def place_text(model: Any, names: Iterable[str], values: Iterable[float]) -> str:
    """Return parameters of a model with values, e.g. ``"f = 12.5 Hz, Nd = 0.1 N"``."""
    pairs = zip(names, values, strict=True)
    return ", ".join(parameter_text(model.parameter(name), value) for name, value in pairs)


def capitalized(text: str, named: Iterable[NamedQuantity]) -> str:
    """Return a sentence with a capital letter, unless it begins with the name of a quantity."""
    names = [item.name for item in named]
    return text if text.split(" ")[0] in names else text[:1].upper() + text[1:]


Multipliers = NDArray[np.complex128]

NEUTRAL = 1e-9
"""A multiplier this near to the unit circle is neither inside nor outside: rounding may move it."""


def outside(multipliers: Multipliers) -> NDArray[np.bool_]:
    """Whether each multiplier lies outside the unit circle, beyond rounding.

    Shapes: multipliers (...).
    """
    return np.asarray(np.abs(multipliers) > 1 + NEUTRAL)


def stability_word(multipliers: Multipliers, *, cycle: bool) -> str:
    """Return ``"stable"``, ``"unstable"`` or, of an undamped orbit, ``"neutral"``.

    One multiplier of a cycle is always one. Shapes: multipliers (n,).

    >>> stability_word(np.array([0.5, 1.0]), cycle=True)
    'stable'
    >>> stability_word(np.array([1j, -1j]), cycle=False)
    'neutral'
    """
    if outside(multipliers).any():
        return "unstable"
    others: Any = np.delete(multipliers, np.abs(multipliers - 1).argmin()) if cycle else multipliers
    return "neutral" if np.abs(others).max(initial=0.0) > 1 - NEUTRAL else "stable"


def multipliers_text(multipliers: Multipliers, *, cycle: bool) -> str:
    """Return the stability of an orbit, and the modulus of its largest multiplier.

    >>> multipliers_text(np.array([-1.2, 0.5j, -0.5j]), cycle=False)
    'unstable by 1 of 3 multipliers, the largest 1.2'
    """
    word = stability_word(multipliers, cycle=cycle)
    if word == "unstable":
        word += f" by {outside(multipliers).sum()} of {len(multipliers)} multipliers"
    largest = float(np.abs(multipliers).max(initial=0.0))
    return f"{word}, the largest {number_text(largest)}" if len(multipliers) else word


def kind_text(kind: str, period: int, forced: bool) -> str:
    """Say what a curve consists of, e.g. ``"period 2"``, ``"cycles"`` or ``"equilibria"``."""
    if kind == "equilibrium":
        return "equilibria"
    if forced:
        return f"period {period}"
    return "cycles" if period == 1 else f"cycles of period {period}"


def revolutions_text(revolutions: Mapping[str, int]) -> str:
    """Say how many revolutions angles make in a period; empty where none does.

    >>> revolutions_text({"phi": -1, "psi": 0, "theta": 2})
    'phi makes 1 revolution, backwards; theta makes 2 revolutions'
    """
    return "; ".join(
        f"{name} makes {abs(count)} revolution{'s' * (abs(count) != 1)}"
        f"{', backwards' if count < 0 else ''}"
        for name, count in revolutions.items()
        if count
    )
