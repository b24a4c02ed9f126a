"""Solutions that go where parameters take them: all of them, not one or two."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from functools import cached_property
from typing import Self

import numpy as np

from slipfold.arrays import Array
from slipfold.branches.settings import Settings
from slipfold.continuation.newton import Correction
from slipfold.errors import BREAKDOWNS, InputError, breakdown
from slipfold.loci.gradients import column_of, corrected
from slipfold.models.model import Model
from slipfold.orbits.orbit_curve import OrbitCurve, Orbits

FAR = 0.1
"""Correction of a guess, in scaled variables, beyond which it may have led to another solution."""

HALVINGS = 6
"""How often the way is halved before a solution is given up."""


class Lost(Exception):
    """There is no such solution at some parameter values; says why."""


class Placed(ABC):
    """An orbit that solves some equations, at some values of the parameters.

    `names` are the parameters that may change. One of them is among the unknowns, held: it comes
    first of what varies.
    """

    def __init__(
        self, names: tuple[str, ...], orbits: Orbits, found: Correction, model: Model
    ) -> None:
        self.names, self.model, self.orbits = names, model, orbits
        self.z: Array = found.z
        self._found = found

    @abstractmethod
    def _curve(self, orbits: Orbits) -> OrbitCurve:
        """Return the equations that are solved."""

    @abstractmethod
    def _placed(self, orbits: Orbits, found: Correction, model: Model) -> Self:
        """Return the same elsewhere; may raise `Lost`."""

    @property
    def _held(self) -> int:
        """Place of the parameter that is held."""
        return -len(self.orbits.varied)

    def beside(self, name: str) -> tuple[Orbits, Array]:
        """Return the same orbit where another parameter is the one that is held."""
        scale = abs(self.model.values[name]) or 1.0
        others = list(self.orbits.varied.items())[1:]
        z = self.z.copy()
        z[self._held] = self.model.values[name] / scale
        return self.orbits.varying({name: scale, **dict(others)}), z

    @cached_property
    def rates(self) -> Array:
        """Derivatives of the unknown by each parameter in its own unit, shape (d, u).

        All from one factorisation; what is held is left out.
        """
        rows = []
        for name in self.names:
            orbits, z = self.beside(name)
            column = column_of(self._curve(orbits).linearise(z), self._held)
            right = -column / orbits.varied[name]
            rows.append(self._found.bordered.solve(np.append(right, 0.0)))
        return np.array(rows)

    def moved_to(self, values: Mapping[str, float]) -> Self:
        """Return the same at other values of the parameters, in steps where one leads too far.

        Raises `Lost`.
        """
        here, done, step = self, 0.0, 1.0
        first = {name: self.model.values[name] for name in self.names}
        while done < 1.0:
            share = min(done + step, 1.0)
            there = {
                name: first[name] + share * (values.get(name, first[name]) - first[name])
                for name in self.names
            }
            try:
                here, done = here._nearby(there), share
            except Lost:
                step /= 2
                if step < 0.5**HALVINGS:
                    raise
        return here

    def _nearby(self, values: Mapping[str, float]) -> Self:
        """Return the same nearby, in one step."""
        try:
            model = self.model.replace(**values)
        except InputError as error:
            raise Lost(str(error)) from None
        orbits = self.orbits.at_values_of(model)
        change = np.array([model.values[name] - self.model.values[name] for name in self.names])
        guess = self.z + change @ self.rates
        held = next(iter(orbits.varied))
        guess[self._held] = model.values[held] / orbits.varied[held]
        try:
            found = corrected(self._curve(orbits), guess, self._held, Settings())
        except BREAKDOWNS as error:
            raise Lost(breakdown(error)) from None
        if not found.converged:
            raise Lost(found.failure)
        if found.distance > FAR:
            raise Lost("the equations lead to another solution")
        return self._placed(orbits, found, model)
