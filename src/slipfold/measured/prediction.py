"""What a model predicts for readings, and how that changes with its parameters."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from slipfold.arrays import Array
from slipfold.errors import BREAKDOWNS, InputError
from slipfold.measured.quantity import Quantity
from slipfold.measured.stable_orbits import StableOrbit, orbits_at
from slipfold.models.model import Model

STEP = 1e-4
"""Difference by which a parameter is moved, over its size: orbits are known to 1e-12, so that
central differences are good to about 1e-8."""


ROUNDING = 1e-12
"""Difference of readings, over their size, that is none."""


@dataclass(frozen=True, eq=False)
class Prediction:
    """Orbits that explain readings, one each, of a model at some values of its parameters."""

    model: Model
    vary: str
    quantities: tuple[Quantity, ...]
    orbits: tuple[StableOrbit, ...]

    @property
    def read(self) -> Array:
        """What is read off each, shape (k, q)."""
        return np.array([orbit.read for orbit in self.orbits]).reshape(-1, len(self.quantities))

    def moved(self, model: Model) -> Prediction | None:
        """Return the same orbits at other parameters; None if one is lost or not stable."""
        found = self._corrected(model)
        if not all(np.isfinite(orbit.read).all() for orbit in found):
            return None
        return replace(self, model=model, orbits=tuple(found))

    def read_at(self, model: Model) -> Array:
        """Return what is read off the same orbits at other parameters; NaN off those lost."""
        return replace(self, orbits=tuple(self._corrected(model))).read

    def _corrected(self, model: Model) -> list[StableOrbit]:
        """Return the same orbits at other parameters, NaN where they are lost or not stable."""
        found = list(self.orbits)
        for rows in _alike(self.orbits):
            some = [self.orbits[row] for row in rows]
            guesses = np.array([orbit.nodes for orbit in some])
            values = np.array([orbit.value for orbit in some])
            try:
                nodes, read, stable = orbits_at(
                    model, self.vary, some[0].period, guesses, values, self.quantities
                )
                read[~stable] = np.nan
            except BREAKDOWNS:
                nodes, read = guesses, np.full((len(rows), len(self.quantities)), np.nan)
            for row, orbit, *new in zip(rows, some, nodes, read, strict=True):
                found[row] = replace(orbit, nodes=new[0], read=new[1])
        return found


def _alike(orbits: Sequence[StableOrbit]) -> list[list[int]]:
    """Return numbers of orbits that are corrected side by side: of one period and form."""
    groups: dict[tuple[int, int], list[int]] = {}
    for row, orbit in enumerate(orbits):
        groups.setdefault((orbit.period, len(orbit.nodes)), []).append(row)
    return list(groups.values())


def sensitivities(prediction: Prediction, names: Sequence[str], sizes: Array) -> Array:
    """Return the derivatives of what is predicted with respect to parameters.

    NaN where an orbit is lost on both sides; one-sided where it is on one, as beside a fold.
    Shapes: sizes (p,); returns (k, q, p).
    """
    model, here = prediction.model, prediction.read
    found = np.full((*here.shape, len(names)), np.nan)
    for column, (name, size) in enumerate(zip(names, sizes, strict=True)):
        step = STEP * size
        ends = []
        for way in (-1, 1):
            try:
                changed = model.replace(**{name: model.values[name] + way * step})
            except InputError:  # beyond the bounds of the parameter
                ends.append(np.full_like(here, np.nan))
            else:
                ends.append(prediction.read_at(changed))
        sides = [(here - ends[0]) / step, (ends[1] - here) / step]
        known = np.isfinite(sides)
        total = np.where(known, sides, 0.0).sum(axis=0)
        total[np.abs(total) * step <= ROUNDING * np.abs(here)] = 0.0
        with np.errstate(invalid="ignore"):
            found[..., column] = total / np.where(known.any(axis=0), known.sum(axis=0), np.nan)
    return found
