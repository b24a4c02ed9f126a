"""A branch of periodic orbits as data."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from slipfold.branches.special_point import SpecialPoint
from slipfold.continuation.end import End
from slipfold.models.model import Model
from slipfold.orbits.extrema import Extrema, find_extrema
from slipfold.orbits.periodic_orbit import PeriodicOrbit, StickSlipOrbit
from slipfold.orbits.uncertainty import multiplier_uncertainty
from slipfold.read_only import ReadOnly
from slipfold.text.one_line import OneLine, headed, listed, number_text, parameter_text
from slipfold.text.printed_table import PrintedTable
from slipfold.text.stability import outside, turns_text


@dataclass(frozen=True, eq=False, repr=False)
class Branch(OneLine, ReadOnly):
    """Periodic orbits followed in one parameter; frozen, one row a point.

    Parameters
    ----------
    id
        Number within the diagram, from 1.
    kind
        ``"periodic"`` or ``"equilibrium"``.
    period
        Period in forcing periods.
    parent
        Id of the branch it left, or None. At a branch point it continues in both directions, so the
        parent is crossed between its ends.
    model
        The model; the value of `vary` is replaced by `parameter`.
    vary
        Name of the parameter followed.
    parameter
        Its values, shape (n_points,).
    nodes
        Orbits, shape (n_points, m, n_states): states at `period` * j / m.
    multipliers
        Floquet multipliers, complex, shape (n_points, n_states), largest modulus first.
    residual
        How far each orbit fails to close, in scaled states, shape (n_points,).
    arclength
        Arclength along the branch in scaled variables, shape (n_points,), from where it was begun.
    special
        Special points, in the order in which the branch meets them.
    stopped
        Why the branch ends where it ends.
    begun
        Why it begins where it begins.
    durations
        Durations of one round of each cycle of an autonomous model, in seconds, shape (n_points,);
        of equilibria the unit of time that their multipliers are over, which keeps pace with the
        fastest turning. None where the model's parameters give the period.
    stuck_fraction
        Share of the period in which a contact sticks, shape (n_points,); NaN of orbits along which
        contacts slip in one direction all the time. None where that is all of them.
    """

    id: int
    kind: str
    period: int
    parent: int | None
    model: Model
    vary: str
    parameter: NDArray[np.float64]
    nodes: NDArray[np.float64]
    multipliers: NDArray[np.complex128]
    residual: NDArray[np.float64]
    arclength: NDArray[np.float64]
    special: tuple[SpecialPoint, ...]
    stopped: End
    begun: End
    durations: NDArray[np.float64] | None = None
    stuck_fraction: NDArray[np.float64] | None = None

    def __len__(self) -> int:
        """Number of points."""
        return len(self.parameter)

    def _line(self) -> str:
        parts = ["equilibria" if self.kind == "equilibrium" else f"period {self.period}"]
        parts.append(turns_text(self.turns))
        parts.append(f"{len(self)} points")
        if len(self):
            ends = (float(self.parameter[0]), float(self.parameter[-1]))
            parts.append(parameter_text(self.model.parameter(self.vary), *ends))
        parts.append(listed(f"{p.type} at {number_text(p.value)}" for p in self.special))
        found = ", ".join(part for part in [*parts, self.stopped.kind] if part)
        return f"Branch {self.id} of {self.model.name}: {found}"

    def _rows(self) -> PrintedTable:
        begun, stopped = ([end.kind, number_text(end.value), end.reason] for end in self.ends)
        found = [[p.type, number_text(p.value, 10), p.outcome] for p in self.special]
        heads = ["", headed(self.model.parameter(self.vary)), "what"]
        return PrintedTable(heads, [begun, *found, stopped], ("", "what"))

    @property
    def ends(self) -> tuple[End, End]:
        """Why it begins and ends where it does: it may have been followed both ways."""
        return self.begun, self.stopped

    @property
    def interrupted(self) -> bool:
        """Whether it was interrupted, or before its special points had normal forms."""
        stopped = any(end.kind == "interrupted" for end in self.ends)
        return stopped or any(point.interrupted for point in self.special)

    @property
    def failed(self) -> bool:
        """Whether it was given up before it came to an end of its own."""
        return any(end.early for end in self.ends)

    @property
    def states(self) -> NDArray[np.float64]:
        """States at phase zero, shape (n_points, n_states)."""
        return self.nodes[:, 0]

    @property
    def unstable(self) -> NDArray[np.int64]:
        """Number of multipliers outside the unit circle, shape (n_points,)."""
        return outside(self.multipliers).sum(axis=1)

    @property
    def stable(self) -> NDArray[np.bool_]:
        """Whether each orbit is stable, or neutral as without damping, shape (n_points,)."""
        return self.unstable == 0

    @property
    def parameters(self) -> NDArray[np.float64]:
        """Parameter vectors of all points, shape (n_points, n_parameters)."""
        vectors = np.repeat(self.model.vector[None], len(self), axis=0)
        vectors[:, self.model.parameter_index(self.vary)] = self.parameter
        if self.durations is not None:
            vectors[:, self.model.parameter_index("duration")] = self.durations
        return vectors

    @cached_property
    def extrema(self) -> Extrema:
        """Extrema of every output over each continuous orbit; computed when first asked for."""
        if self.stuck_fraction is not None:
            return self._extrema_one_by_one()
        return find_extrema(self.model, self.parameters, self.nodes, self.period)

    def extrema_of(self, output: str) -> Extrema:
        """Return the extrema of one output over each orbit, which is quicker than of all.

        Parameters
        ----------
        output
            A state or output of the model.

        Raises
        ------
        InputError
            If there is none of that name.
        """
        if "extrema" in vars(self) or self.stuck_fraction is not None:
            return self.extrema
        return find_extrema(self.model, self.parameters, self.nodes, self.period, (output,))

    def _extrema_one_by_one(self) -> Extrema:
        """Extrema of orbits some of which stick."""
        found = [self.orbit(index).extrema for index in range(len(self))]
        low, high = (
            np.concatenate([getattr(item, which) for item in found])
            for which in ("minimum", "maximum")
        )
        return Extrema(found[0].names, low, high)

    @cached_property
    def multiplier_uncertainty(self) -> NDArray[np.float64]:
        """Computed uncertainty of every multiplier, shape (n_points, n_states).

        How much each moves when the monodromy matrix is integrated anew with other steps;
        computed when first asked for.
        """
        if self.stuck_fraction is not None:
            orbits = [self.orbit(index) for index in range(len(self))]
            return np.array([orbit.multiplier_uncertainty for orbit in orbits])
        return multiplier_uncertainty(
            self.model, self.parameters, self.nodes, self.period, self.multipliers
        )

    @cached_property
    def turns(self) -> dict[str, int]:
        """Whole turns that each angle makes in a period, by name: the same all along a branch."""
        return self.orbit(0).turns if len(self) else {}

    def orbit(self, index: int) -> PeriodicOrbit:
        """Return one point as a periodic orbit.

        Parameters
        ----------
        index
            Row of the branch.
        """
        changes = {self.vary: float(self.parameter[index])}
        if self.durations is not None:
            changes["duration"] = float(self.durations[index])
        model = self.model.replace(**changes)
        fractions = self.stuck_fraction
        slips = fractions is None or bool(np.isnan(fractions[index]))
        return (PeriodicOrbit if slips else StickSlipOrbit)(
            model,
            self.period,
            self.nodes[index],
            self.multipliers[index],
            float(self.residual[index]),
        )
