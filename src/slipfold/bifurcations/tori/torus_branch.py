"""A branch of tori as data."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING, Annotated

import numpy as np

from slipfold.arrays import Array, Indices, Mask
from slipfold.bifurcations.branches.solution_curve import Row, SolutionCurve
from slipfold.continuation.end import End
from slipfold.models.model import evaluation_of
from slipfold.orbits.extrema import Extrema
from slipfold.read_only import ReadOnly
from slipfold.text import (
    OneLine,
    PrintedTable,
    headed,
    kind_text,
    listed,
    number_text,
    parameter_text,
)

if TYPE_CHECKING:
    from slipfold.bifurcations.tori.surface import TorusSpectrum


@dataclass(frozen=True, repr=False)
class Locked(OneLine, ReadOnly):
    """A resonance that tori pass, where trajectories may be locked to an orbit; frozen."""

    ratio: Annotated[
        Fraction, "The rotation number p/q: a locked orbit closes after q returns of the map."
    ]
    first: Annotated[float, "Value of the parameter at the last torus before it."]
    last: Annotated[float, "Value of the parameter at the first torus after it."]
    low: Annotated[
        float,
        "Beginning of the interval in which locked orbits exist: their fold. Between both folds "
        "lies the resonance tongue. NaN if they were not found, and of autonomous models.",
    ] = np.nan
    high: Annotated[float, "End of that interval."] = np.nan

    def _line(self) -> str:
        return (
            f"resonance {self.ratio} between {number_text(self.first)} and {number_text(self.last)}"
        )

    def _rows(self) -> PrintedTable:
        ends = (self.first, self.last, self.low, self.high)
        row = [str(self.ratio), *(number_text(value, 10) for value in ends)]
        return PrintedTable(["rotation", "from", "to", "locked from", "to"], [row])


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class TorusBranch(SolutionCurve):
    """Quasi-periodic tori followed in one parameter; frozen, one row a torus.

    The first row is the Neimark-Sacker point from which they emanate: a torus without thickness.
    Or it is the torus that a trajectory converges to.
    """

    id: Annotated[int, "Number within the diagram; those of tori come after those of branches."]
    period: Annotated[
        int,
        "Forcing periods after which the circle is mapped onto itself: the period of the orbit "
        "from which the tori emanate. Of an autonomous model revolutions, which last `durations`.",
    ]
    parent: Annotated[
        int,
        "Id of the branch with the Neimark-Sacker point; 0 if they begin where a trajectory "
        "converges.",
    ]
    vary: Annotated[str, "Name of the parameter followed."]
    parameter: Annotated[Array, "Its values, shape (n_points,)."]
    rotation: Annotated[
        Array,
        "Rotation numbers, shape (n_points,): the fraction of a revolution by which the circle "
        "turns over `period` forcing periods. It begins between 0 and 1/2, and is negative once "
        "the circle turns the other way.",
    ]
    circles: Annotated[
        Array,
        "States at phase zero at equidistant angles of the circle, shape (n_points, m, n_states); "
        "of a circle with fewer angles NaN follows. See `circle`.",
    ]
    extrema: Annotated[
        Extrema, "Minimum and maximum of every output over the whole torus: the envelope."
    ]
    growth: Annotated[
        Array,
        "Largest exponent of perturbations across the torus over `period` forcing periods, shape "
        "(n_points,). The torus attracts if it is negative.",
    ]
    growth_error: Annotated[Array, "Estimated errors of `growth`, shape (n_points,)."]
    truncation: Annotated[
        Array,
        "How far circles fail to be invariant between the angles at which they are made so, in "
        "scaled states, shape (n_points,).",
    ]
    omitted: Annotated[
        Indices,
        "Numbers of circles that were followed after each torus but left out since they fail to be "
        "invariant by more than 1e-8, shape (n_points,). Lines are not drawn across them.",
    ]
    folds: Annotated[tuple[float, ...], "Values of the parameter at which the tori have a fold."]
    locked: Annotated[tuple[Locked, ...], "Resonances that they pass, in order."]
    durations: Annotated[
        Array | None,
        "Of tori of an autonomous model the seconds after which each circle lies on itself again, "
        "over `period`, shape (n_points,); None where the model is forced.",
    ] = None

    @property
    def _values(self) -> Array:
        return self.parameter[:, None]

    def _line(self) -> str:
        ends = (float(self.parameter[0]), float(self.parameter[-1]))
        turns = f"rotation {self.rotation[0]:.6g} to {self.rotation[-1]:.6g}"
        of = kind_text("periodic", self.period, self.model.forced)
        parts = [f"of {of}", f"{len(self)} points"]
        parts += [parameter_text(self.model.parameter(self.vary), *ends), turns]
        parts.append(listed(f"fold at {number_text(value)}" for value in self.folds))
        found = ", ".join(part for part in [*parts, self.stopped.kind] if part)
        return f"Tori {self.id} of {self.model.name}: {found}"

    def _rows(self) -> PrintedTable:
        rows = [
            [number_text(value, 10), f"{turns:.8g}", f"{hertz:.6g}", f"{growth:.3g}"]
            for value, turns, hertz, growth in zip(
                self.parameter, self.rotation, self.frequency, self.growth, strict=True
            )
        ]
        vary = headed(self.model.parameter(self.vary))
        return PrintedTable([vary, "rotation", "modulation (Hz)", "growth across"], rows)

    @property
    def started(self) -> End:
        """Where it begins: at a Neimark-Sacker point or at the limit of a trajectory."""
        if not self.parent:
            reason = "begins at the torus that a trajectory converges to"
            return End("settled", reason, float(self.parameter[0]))
        reason = f"emanates from a Neimark-Sacker point of branch {self.parent}"
        return End("bifurcation", reason, float(self.parameter[0]))

    @property
    def frequency(self) -> Array:
        """Modulation frequencies in Hz with the sign of `rotation`, shape (n_points,)."""
        models = map(self.model_at, range(len(self)))
        periods = [evaluation_of(model).period(model) for model in models]
        return np.asarray(self.rotation / (self.period * np.array(periods)))

    @property
    def stable(self) -> Mask:
        """Whether each torus attracts for certain, shape (n_points,). An orbit does not."""
        return np.asarray(self.growth < -self.growth_error)

    @property
    def interrupted(self) -> bool:
        """Whether the observer stopped it."""
        return self.stopped.kind == "interrupted"

    @property
    def angles(self) -> Indices:
        """Number of angles at which each circle is described, shape (n_points,)."""
        return np.asarray(np.isfinite(self.circles[:, :, 0]).sum(axis=1))

    def circle(self, index: Row) -> Array:
        """Return the circle of one torus: states at equidistant angles, shape (m, n_states)."""
        return self.circles[index, : self.angles[index]]

    def spectrum(self, index: Row) -> TorusSpectrum:
        """Return the lines of all outputs on one torus."""
        from slipfold.bifurcations.tori.surface import spectrum_of, surface_of

        model, turns = self.model_at(index), float(self.rotation[index])
        return spectrum_of(model, surface_of(model, self.circle(index), turns, self.period))
