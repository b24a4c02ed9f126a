"""A special point that goes where parameters take it."""

from __future__ import annotations

from typing import Self

import numpy as np

from slipfold.arrays import Array
from slipfold.branches.settings import Settings
from slipfold.branches.special_point import SpecialPoint
from slipfold.continuation.newton import Correction
from slipfold.design_space.placed import Lost, Placed
from slipfold.errors import BREAKDOWNS, InputError, breakdown
from slipfold.loci.gradients import plane_of_scales, solved
from slipfold.models.model import Model
from slipfold.orbits.critical import Critical
from slipfold.orbits.orbit_curve import Orbits
from slipfold.orbits.test_functions import PAIRED, critical_pair


class PlacedPoint(Placed):
    """A special point as a solution of its equations, at some values of the parameters."""

    def __init__(
        self, kind: str, names: tuple[str, ...], orbits: Orbits, found: Correction, model: Model
    ) -> None:
        super().__init__(names, orbits, found, model)
        self.kind = kind

    @classmethod
    def at(cls, point: SpecialPoint, names: tuple[str, ...]) -> Self:
        """Return the point where it was found."""
        if point.type == "BP":
            raise InputError(
                "a branch point goes nowhere where a parameter parts its branches; give a special "
                "point of another type"
            )
        try:
            orbits, found = solved(point, plane_of_scales(point, names[0]), Settings())
        except InputError:
            raise
        except BREAKDOWNS as error:
            raise InputError(
                f"the {point.type} at {point.vary} = {point.value:.6g} is not found again "
                f"({breakdown(error)}); compute it anew"
            ) from None
        return cls(point.type, names, orbits, found, point.model)

    @property
    def value(self) -> float:
        """Value of the parameter that was followed."""
        return self.orbits.value(self.z)

    @property
    def gradient(self) -> Array:
        """Derivatives of the value by each parameter, shape (d,)."""
        return np.asarray(self.rates[:, -1] * self.orbits.width)

    def _curve(self, orbits: Orbits) -> Critical:
        return Critical(orbits, self.kind)

    def _placed(self, orbits: Orbits, found: Correction, model: Model) -> Self:
        if self.kind in PAIRED and not _turns(found):
            raise Lost("the pair that was critical no longer turns: it is no bifurcation there")
        placed = model.replace(**{orbits.vary: float(orbits.value(found.z))})
        return type(self)(self.kind, self.names, orbits.at_values_of(placed), found, placed)


def _turns(found: Correction) -> bool:
    """Whether the critical pair is complex."""
    multipliers = np.linalg.eigvals(found.linearisation.monodromy).astype(complex)
    pair = critical_pair(multipliers)
    return pair is not None and bool(multipliers[pair[0]].imag != 0)
