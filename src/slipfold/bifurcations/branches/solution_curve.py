"""Base classes of branches, loci and tori, and of their special points."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Any

import numpy as np

from slipfold.arrays import Array, Complex
from slipfold.continuation.end import End
from slipfold.models.model import Model, evaluation_of
from slipfold.models.quantities import DURATION
from slipfold.orbits.eigenvalues import eigenvalues_of
from slipfold.orbits.extrema import Extrema, find_extrema
from slipfold.orbits.periodic_orbit import Measured, PeriodicOrbit, StickSlipOrbit
from slipfold.read_only import ReadOnly
from slipfold.text import OneLine, PrintedTable, certain, headed, kind_text, number_text, place_text

MULTIPLIERS = "Floquet multipliers, complex, shape ({}n_states,), largest modulus first; for an "
MULTIPLIERS += "equilibrium, those of the flow over the model's ``duration``."
STUCK = "Fraction of the period in which a contact sticks; NaN for an orbit along which every "
STUCK += "contact slips in one direction{}."

Row = Annotated[int, "Row of the curve."]


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class LocatedPoint(OneLine, ReadOnly):
    """A located point of a curve of orbits."""

    type: str
    name: str
    model: Annotated[
        Model, "The model with the parameter values of the point and the duration of its cycle."
    ]
    vary: str | tuple[str, str]
    uncertainty: float | tuple[float, float]
    period: Annotated[int, "Period in forcing periods."]
    nodes: Annotated[Array, "States of the orbit, shape (m, n_states)."]
    multipliers: Annotated[Complex, MULTIPLIERS.format("")]
    residual: Annotated[float, "How far the orbit fails to close, in scaled states."]
    arclength: Annotated[float, "Position on the curve."]
    criticality: Annotated[
        str | None, '``"supercritical"``, ``"subcritical"``, or None where neither applies.'
    ] = None
    stuck_fraction: Annotated[float, STUCK.format("")] = np.nan

    def _line(self) -> str:
        at = place_text(self.model, names_of(self.vary), self.certain_values)
        return ", ".join(part for part in (f"{self.type} at {at}", self.outcome) if part)

    def _rows(self) -> PrintedTable:
        numbers = [[name, number_text(value)] for name, value in self._numbers().items()]
        return PrintedTable(["", ""], [*numbers, *self.orbit._rows().lines])

    def _numbers(self) -> Mapping[str, float | None]:
        """Return the numbers of the point, by name."""
        raise NotImplementedError

    @property
    def _values(self) -> tuple[float, ...]:
        """Values of the varied parameters."""
        raise NotImplementedError

    @property
    def certain_values(self) -> tuple[float, ...]:
        """Values of the varied parameters; zero where zero is within the uncertainty."""
        uncertain = np.atleast_1d(self.uncertainty).tolist()
        return tuple(map(certain, self._values, uncertain))

    @property
    def outcome(self) -> str:
        """The type of the point in words, and the curves that start here."""
        raise NotImplementedError

    @property
    def interrupted(self) -> bool:
        """Whether an interruption left the point without normal form and uncertainty."""
        return bool(np.isnan(self.uncertainty).any())

    @property
    def state(self) -> Array:
        """State at phase zero, shape (n_states,)."""
        return self.nodes[0]

    @cached_property
    def orbit(self) -> PeriodicOrbit:
        """The periodic orbit at this point."""
        kind = PeriodicOrbit if np.isnan(self.stuck_fraction) else StickSlipOrbit
        return kind(self.model, self.period, self.nodes, self.multipliers, self.residual)


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class SolutionCurve(OneLine, ReadOnly):
    """Solutions followed in one parameter or two, one row a point."""

    id: Annotated[int, "Number within the result, from 1."]
    period: Annotated[int, "Period in forcing periods; of an autonomous model, in revolutions."]
    parent: int | None
    model: Annotated[Model, "The model; each point has its own values of `vary`."]
    vary: str | tuple[str, str]
    stopped: Annotated[End, "Why the curve ends where it does."]
    durations: Annotated[
        Array | None,
        "Durations of the cycles of an autonomous model in seconds, shape (n_points,); for "
        "equilibria the time over which their multipliers are taken. None for a forced model, "
        "whose parameters give the period.",
    ] = None

    @property
    def _values(self) -> Array:
        """Values of the varied parameters, shape (n_points, 1 or 2)."""
        raise NotImplementedError

    def __len__(self) -> int:
        """Number of points."""
        return len(self._values)

    def model_at(self, index: Row) -> Model:
        """Return the model with the parameter values of one point."""
        changes = dict(zip(names_of(self.vary), map(float, self._values[index]), strict=True))
        if self.durations is not None:
            changes[DURATION.name] = float(self.durations[index])
        return self.model.replace(**changes)


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class OrbitSeries(Measured, SolutionCurve):
    """Periodic orbits or equilibria followed in parameters."""

    kind: Annotated[str, '``"periodic"`` or ``"equilibrium"``.'] = "periodic"
    nodes: Annotated[Array, "Orbits, shape (n_points, m, n_states): states at `period` * j / m."]
    multipliers: Annotated[Complex, MULTIPLIERS.format("n_points, ")]
    residual: Annotated[
        Array, "How far each orbit fails to close, in scaled states, shape (n_points,)."
    ]
    arclength: Annotated[
        Array, "Arclength along the curve in scaled variables, shape (n_points,), from its start."
    ]
    special: Annotated[tuple[Any, ...], "Special points, in the order of the curve."]
    started: Annotated[End, "Why the curve begins where it does."]
    stuck_fraction: Annotated[
        Array | None, STUCK.format(", shape (n_points,). None if all orbits do that")
    ] = None

    @property
    def _content(self) -> str:
        return kind_text(self.kind, self.period, self.model.forced)

    @cached_property
    def eigenvalues(self) -> Complex | None:
        """Of equilibria in 1/s, largest real part first, (n_points, n_states); None for orbits."""
        if self.kind != "equilibrium":
            return None
        jacobian = evaluation_of(self.model).jacobian
        models = map(self.model_at, range(len(self)))
        pairs = zip(models, self.nodes[:, 0], strict=True)
        return np.array([eigenvalues_of(jacobian(*pair)) for pair in pairs])

    def _rows(self) -> PrintedTable:
        started, stopped = (
            [end.kind, *map(number_text, end.values), end.reason] for end in self.ends
        )
        points = [
            [point.type, *(number_text(value, 10) for value in point._values), point.outcome]
            for point in self.special
        ]
        heads = ["", *(headed(self.model.parameter(name)) for name in names_of(self.vary)), "what"]
        return PrintedTable(heads, [started, *points, stopped], ("", "what"))

    @property
    def ends(self) -> tuple[End, End]:
        """Why the curve begins and ends where it does. It may have been followed both ways."""
        return self.started, self.stopped

    @property
    def interrupted(self) -> bool:
        """Whether the curve, or the computation of its normal forms, was interrupted."""
        stopped = any(end.kind == "interrupted" for end in self.ends)
        return stopped or any(point.interrupted for point in self.special)

    @property
    def failed(self) -> bool:
        """Whether continuation failed before the end of the span or another regular end."""
        return any(end.early for end in self.ends)

    @property
    def states(self) -> Array:
        """States at phase zero, shape (n_points, n_states)."""
        return self.nodes[:, 0]

    @property
    def parameters(self) -> Array:
        """Parameter vectors of all points, shape (n_points, n_parameters)."""
        vectors = np.repeat(self.model.vector[None], len(self), axis=0)
        vectors[:, [self.model.parameter_index(name) for name in names_of(self.vary)]] = (
            self._values
        )
        if self.durations is not None:
            vectors[:, self.model.parameter_index(DURATION.name)] = self.durations
        return vectors

    @cached_property
    def extrema(self) -> Extrema:
        """Extrema of every output over each continuous orbit; computed when first requested."""
        return self._extrema_of(slice(None))

    def extrema_of(self, output: str) -> Extrema:
        """Return the extrema of one output over each orbit."""
        if "extrema" in vars(self) or self.stuck_fraction is not None:
            return self.extrema
        return self._extrema_of(slice(None), (output,))

    def _each(self, measure: Callable[[PeriodicOrbit], float]) -> Array:
        return np.array([measure(self.orbit(index)) for index in range(len(self))])

    def _extrema_of(self, rows: slice, outputs: Sequence[str] | None = None) -> Extrema:
        """Compute the extrema of outputs over some of the orbits."""
        if self.stuck_fraction is None:
            given = self.model, self.parameters[rows], self.nodes[rows], self.period
            return find_extrema(*given, outputs)
        result = [self.orbit(index).extrema for index in range(len(self))[rows]]
        low = np.concatenate([item.minimum for item in result])
        return Extrema(result[0].names, low, np.concatenate([item.maximum for item in result]))

    def orbit(self, index: Row) -> PeriodicOrbit:
        """Return one point as a periodic orbit."""
        fractions = self.stuck_fraction
        slips = fractions is None or bool(np.isnan(fractions[index]))
        return (PeriodicOrbit if slips else StickSlipOrbit)(
            self.model_at(index),
            self.period,
            self.nodes[index],
            self.multipliers[index],
            float(self.residual[index]),
        )


def names_of(vary: str | tuple[str, str]) -> tuple[str, ...]:
    """Return the names of one parameter or two."""
    return (vary,) if isinstance(vary, str) else vary
