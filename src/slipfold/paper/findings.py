"""What was computed for the paper, as the claims ask for it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from slipfold.branches.branch import Branch
from slipfold.branches.special_point import SpecialPoint
from slipfold.lines import stretches_of
from slipfold.long_term.spectrum import Spectrum
from slipfold.models.sliding_oscillator import SlidingOscillator
from slipfold.paper.cases import Cases, Curve, Row, Steady
from slipfold.plots.response import HasBranches


class NotComputed(LookupError):
    """A result that a claim needs is not there, e.g. because the run was interrupted."""


@dataclass(frozen=True)
class Findings:
    """Results by case."""

    cases: Cases  # what was to be computed
    # Finished response diagrams
    diagrams: Mapping[Curve, HasBranches] = field(default_factory=dict)
    spectra: Mapping[Steady, Spectrum] = field(default_factory=dict)  # finished spectra

    def diagram(self, vary: str = "Nd", **parameters: Any) -> HasBranches:
        """Return the response diagram of a case."""
        model = SlidingOscillator(**parameters)
        for curve, diagram in self.diagrams.items():
            if curve.vary == vary and curve.model == model:
                return diagram
        raise NotComputed(f"the response in {vary} of {model!r}")

    def spectrum(self, **parameters: Any) -> Spectrum:
        """Return the spectrum of a case."""
        model = SlidingOscillator(**parameters)
        try:
            return self.spectra[Steady(model)]
        except KeyError:
            raise NotComputed(f"the spectrum of {model!r}") from None

    def rows(self, figure: int) -> tuple[Row, ...]:
        """Return the families of a figure."""
        for item in self.cases.figures:
            if item.number == figure:
                return item.rows
        raise NotComputed(f"figure {figure}")

    def family(self, row: Row) -> list[tuple[float, HasBranches]]:
        """Return the diagrams of a family with the value that tells them apart, ascending."""
        missing = [curve.key for curve in row.curves if curve not in self.diagrams]
        if missing:
            raise NotComputed(", ".join(missing))
        members = [(curve.model.values[row.member], self.diagrams[curve]) for curve in row.curves]
        return sorted(members, key=lambda member: member[0])


def on_branches(diagram: HasBranches, type_: str, doubled: bool) -> list[SpecialPoint]:
    """Return special points of one type by value."""
    found = [
        point
        for branch in diagram.branches
        if (branch.period > 1) == doubled
        for point in branch.special
        if point.type == type_
    ]
    return sorted(found, key=lambda point: point.value)


def first(diagram: HasBranches, type_: str, doubled: bool) -> SpecialPoint | None:
    """Return the special point of one type with the smallest value, or None."""
    return next(iter(on_branches(diagram, type_, doubled)), None)


def band(branches: Sequence[Branch]) -> tuple[float, float]:
    """Return the smallest and the largest parameter that branches reach."""
    values = [branch.parameter for branch in branches]
    values += [np.array([point.value for point in branch.special]) for branch in branches]
    together = np.concatenate(values)
    return float(together.min()), float(together.max())


def reached(branch: Branch, output: str, value: float, measure: str = "max") -> list[float]:
    """Return what an output reaches where a branch passes a value of the parameter."""
    found = []
    for stretch in stretches_of(branch, output, measure):
        ahead = stretch.parameter - value
        for i in np.flatnonzero(ahead[:-1] * ahead[1:] <= 0):
            width = ahead[i] - ahead[i + 1]
            share = ahead[i] / width if width else 0.0
            step = stretch.value[i + 1] - stretch.value[i]
            found.append(float(stretch.value[i] + share * step))
    return found
