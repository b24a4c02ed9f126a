"""A branch of periodic orbits as data."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Annotated

import numpy as np

from slipfold.arrays import Array, Indices, Mask
from slipfold.bifurcations.branches.solution_curve import OrbitSeries
from slipfold.text import listed, number_text, outside, parameter_text, revolutions_text


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Branch(OrbitSeries):
    """Periodic orbits followed in one parameter; frozen, one row a point."""

    parent: Annotated[
        int | None,
        "Id of the branch it left, or None. At a branch point it continues in both directions, so "
        "the parent is crossed between its ends.",
    ]
    vary: Annotated[str, "Name of the parameter followed."]
    parameter: Annotated[Array, "Its values, shape (n_points,)."]

    @property
    def _values(self) -> Array:
        return self.parameter[:, None]

    def _line(self) -> str:
        parts = [self._content, revolutions_text(self.revolutions)]
        parts.append(f"{len(self)} points")
        if len(self):
            ends = (float(self.parameter[0]), float(self.parameter[-1]))
            parts.append(parameter_text(self.model.parameter(self.vary), *ends))
        parts.append(listed(f"{p.type} at {number_text(p.value)}" for p in self.special))
        found = ", ".join(part for part in [*parts, self.stopped.kind] if part)
        return f"Branch {self.id} of {self.model.name}: {found}"

    @property
    def unstable(self) -> Indices:
        """Number of multipliers outside the unit circle, shape (n_points,)."""
        return outside(self.multipliers).sum(axis=1)

    @property
    def stable(self) -> Mask:
        """Whether each orbit is stable, or neutral as without damping, shape (n_points,)."""
        return self.unstable == 0

    @cached_property
    def multiplier_uncertainty(self) -> Array:
        """Computed uncertainty of every multiplier, shape (n_points, n_states).

        How much each moves when the monodromy matrix is integrated again with other steps;
        computed when first requested.
        """
        return self._multiplier_uncertainty_of(slice(None))

    def _multiplier_uncertainty_of(self, rows: slice) -> Array:
        """Compute the uncertainties of the multipliers of some of the orbits."""
        from slipfold.orbits.uncertainty import multiplier_uncertainty

        if self.stuck_fraction is None:
            given = self.model, self.parameters[rows], self.nodes[rows], self.period
            return multiplier_uncertainty(*given, self.multipliers[rows])
        orbits = (self.orbit(index) for index in range(len(self))[rows])
        return np.array([orbit.multiplier_uncertainty for orbit in orbits])

    @cached_property
    def revolutions(self) -> dict[str, int]:
        """Revolutions that each angle makes in a period, by name: the same all along a branch."""
        return self.orbit(0).revolutions if len(self) else {}
