"""What all spreadsheets share: lines of text, heads with units, complex numbers in two columns."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from slipfold.models.model import Model

__all__ = ["complex_parts", "csv_text", "multiplier_heads", "with_unit"]


def csv_text(heads: Sequence[str], rows: Iterable[Sequence[Any]]) -> str:
    r"""Return a line of column names and one line a row; numbers are exact when read back.

    Examples
    --------
    >>> csv_text(["a", "b"], [[1, 0.5]])
    'a,b\n1,0.5\n'
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(heads)
    writer.writerows(rows)
    return text.getvalue()


def with_unit(item: Any) -> str:
    """Return the name of a parameter, state or output with its unit, e.g. ``"Nd (N)"``."""
    return f"{item.name} ({item.unit})" if item.unit else str(item.name)


def multiplier_heads(model: Model) -> list[str]:
    """Return the names of the columns of Floquet multipliers."""
    numbers = range(1, len(model.states) + 1)
    return [f"multiplier {number} {part}" for number in numbers for part in ("real", "imaginary")]


def complex_parts(values: NDArray[np.complex128]) -> list[float]:
    """Return real and imaginary parts in turn.

    Shapes: values (n,).
    """
    return list(np.column_stack([values.real, values.imag]).ravel().tolist())
