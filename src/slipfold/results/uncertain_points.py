"""Special points that are less certain than they should be: a sentence for each."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING

from slipfold.text.one_line import parameter_text
from slipfold.text.printed_table import with_unit

if TYPE_CHECKING:
    from slipfold.models.parameter import Parameter
    from slipfold.results.diagram import Diagram
    from slipfold.results.locus_diagram import LocusDiagram

__all__ = ["uncertain_on_branches", "uncertain_on_loci"]

UNCERTAIN = 1e-6
"""Share of the span from which on the uncertainty of a point is told: points are located to 1e-12,
and in a figure this cannot be seen."""


def uncertain_on_branches(diagram: Diagram) -> Iterator[str]:
    """Yield a sentence for each special point of a branch that is uncertain."""
    parameter, width = diagram.model.parameter(diagram.vary), abs(diagram.span[1] - diagram.span[0])
    for branch, point in diagram.special:
        if not point.uncertainty <= UNCERTAIN * width:
            name = f"{point.type} of branch {branch.id} at {parameter_text(parameter, point.value)}"
            yield _sentence(name, [(parameter, point.uncertainty)])


def uncertain_on_loci(diagram: LocusDiagram) -> Iterator[str]:
    """Yield a sentence for each special point of a locus that is uncertain."""
    parameters = [diagram.model.parameter(name) for name in diagram.vary]
    widths = [high - low for low, high in diagram.window]
    for locus in diagram.loci:
        for point in locus.special:
            pairs = zip(point.uncertainty, widths, strict=True)
            if not all(uncertainty <= UNCERTAIN * width for uncertainty, width in pairs):
                values = zip(parameters, point.values, strict=True)
                place = ", ".join(parameter_text(item, value) for item, value in values)
                name = f"{point.type} of locus {locus.id} at {place}"
                yield _sentence(name, zip(parameters, point.uncertainty, strict=True))


def _sentence(name: str, known: Iterable[tuple[Parameter, float]]) -> str:
    amounts = list(known)
    if not all(math.isfinite(amount) for _, amount in amounts):
        return f"{name}: how certain it is could not be computed."
    texts = [with_unit(f"{amount:.0e}", parameter.unit) for parameter, amount in amounts]
    return f"{name} is uncertain by {' and '.join(texts)}."
