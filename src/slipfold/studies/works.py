"""The computations of a study: each gives a few numbers of a model."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, TypeAdapter

from slipfold import options
from slipfold.bifurcations.branches.batched import BatchedCase, follow_batch
from slipfold.bifurcations.branches.batched_walk import BATCH
from slipfold.bifurcations.branches.response import trace_response
from slipfold.bifurcations.branches.settings import Settings
from slipfold.bifurcations.branches.special_point import SpecialPoint
from slipfold.bifurcations.loci.bifurcation_set import check_requested, find_bifurcation_set
from slipfold.bifurcations.loci.window import measured_across
from slipfold.errors import InputError
from slipfold.flow.scales import measured
from slipfold.flow.simulate import initial_state, simulate
from slipfold.long_term.exponents import find_exponents
from slipfold.long_term.search import ENDED, UNDECIDED, box_around, checked_box, search
from slipfold.models.equilibria import check_followed
from slipfold.models.model import Model
from slipfold.models.quantities import DURATION, Output, State
from slipfold.models.units import interval
from slipfold.orbits.extrema import steady_extrema
from slipfold.parameter_space.loss import STABLE, Loss, first_loss, followed_to_loss, unstable_from

Value = float | int | str | None
"""A number or a word; None where there is none."""


@dataclass(frozen=True)
class CaseField:
    """A quantity that is computed of every case."""

    name: str
    kind: Literal["real", "whole", "text"]
    meaning: str
    unit: str = ""
    none: int | None = None  # the whole number that means none


@dataclass(frozen=True)
class CaseValues:
    """The values of one case."""

    values: dict[str, Value]  # by the names of the quantities
    listed: tuple[dict[str, Value], ...] = ()  # special points or the like: any number of them


class Work(BaseModel):
    """Something to compute of every case; a subclass has its options as fields.

    They have the types of `slipfold.options`, which say what values they may have.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    listed: ClassVar[str] = "special"
    """Name of the items of which a case may have any number."""

    together_from: ClassVar[int] = 1
    """Minimum number of cases of a study for which they are batched as far as possible."""

    side_by_side: ClassVar[tuple[int, int]] = 1, 1
    """Minimum number of cases of a batch, and that of a study which keeps all processes busy."""

    what: str

    def varied(self) -> Collection[str]:
        """Return the parameters that this varies itself, so that cases cannot set them."""
        return ()

    @abstractmethod
    def checked(self, model: Model) -> Self:
        """Return it with all values in SI units; raise where the model cannot do it."""

    @abstractmethod
    def quantities(self, model: Model) -> tuple[CaseField, ...]:
        """Return the quantities of every case."""

    def lists(self, model: Model) -> tuple[CaseField, ...]:
        """Return the quantities of each listed item."""
        return ()

    @abstractmethod
    def compute(self, model: Model) -> CaseValues:
        """Compute it for one case."""

    def together(self, models: Sequence[Model]) -> list[CaseValues | None]:
        """Compute several cases as a batch; None for those that cannot be batched.

        The values of a case must not depend on the other cases of the batch.
        """
        return [None] * len(models)

    def record(self) -> dict[str, Any]:
        """Return it as plain data, from which it can be made again."""
        return self.model_dump(mode="json")

    def case(
        self, model: Model, values: Iterable[Any], listed: Iterable[Iterable[Any]] = ()
    ) -> CaseValues:
        """Return the values of a case, given in the order of the quantities and lists."""
        items = self.lists(model)
        return CaseValues(
            _named(self.quantities(model), values), tuple(_named(items, row) for row in listed)
        )


def _named(fields: Sequence[CaseField], values: Iterable[Any]) -> dict[str, Value]:
    """Return values as plain data by name; a number that is not finite is None."""
    result: dict[str, Value] = {}
    for item, value in zip(fields, values, strict=True):
        plain = value.item() if isinstance(value, np.generic) else value
        missing = isinstance(plain, float) and not math.isfinite(plain)
        result[item.name] = None if missing else plain
    return result


def parsed_span(model: Model, name: str, span: options.Span) -> tuple[float, float]:
    """Return the ends of a span in which orbits are followed, in SI units."""
    check_followed(model)
    return interval(model.variable_parameter(name), span)


class LossWork(Work):
    """The first loss of stability of a response over a parameter."""

    vary: options.Vary
    span: options.Span

    def varied(self) -> Collection[str]:
        """Return the parameter followed."""
        return (self.vary,)

    def checked(self, model: Model) -> Self:
        """Return it with the span in SI units."""
        return self.model_copy(update={"span": parsed_span(model, self.vary, self.span)})

    @property
    def ends(self) -> tuple[float, float]:
        """The ends of the checked span."""
        return float(self.span[0]), float(self.span[1])

    def quantities(self, model: Model) -> tuple[CaseField, ...]:
        """Return the quantities of a loss."""
        return (
            CaseField("threshold", "real", f"{self.vary} where the response first loses its "
                     "stability", model.parameter(self.vary).unit),
            CaseField("outcome", "text", "bifurcation by which it is lost; else stable, unstable "
                     "from the start, or how a stable response ends"),
            CaseField("reason", "text", "why there is no threshold"),
        )  # fmt: skip

    def batched_loss(self, case: BatchedCase) -> Loss | None:
        """Return how a response loses its stability; None if it has to be followed individually."""
        if case.failure:
            return None
        found = (branch := case.branches[0]).loss
        first, last = self.ends
        if not branch.stable:
            return unstable_from(self.vary, first)
        if found is not None:
            return Loss(float(branch.orbits.value(found.point.z)), found.type, "")
        if branch.end != "span":  # where a limit lies is not known
            return None
        reason = f"reached the end of the span at {self.vary} = {last:g}"
        return Loss(math.nan, STABLE, f"{reason} (stable up to {self.vary} = {last:.9g})")


def _loss_values(loss: Loss) -> tuple[Any, ...]:
    return loss.threshold, loss.outcome, loss.reason


class ResponseWork(LossWork):
    """All branches of the response: their first loss of stability and all special points."""

    together_from: ClassVar[int] = BATCH.minimum_size
    side_by_side: ClassVar[tuple[int, int]] = BATCH.sizes

    what: Literal["response"]
    largest_period: int = Field(Settings().largest_period, ge=1)

    def quantities(self, model: Model) -> tuple[CaseField, ...]:
        """Return the quantities of every case."""
        return (
            *super().quantities(model),
            CaseField("branches", "whole", "number of branches"),
            CaseField("given_up", "whole", "number of branches that could not be followed"),
        )

    def lists(self, model: Model) -> tuple[CaseField, ...]:
        """Return the quantities of each special point."""
        unit = model.parameter(self.vary).unit
        return (
            CaseField("type", "text", "type of special point"),
            CaseField("branch", "whole", "number of its branch, from 1"),
            CaseField("period", "whole", "in forcing periods"),
            CaseField("value", "real", f"{self.vary} there", unit),
            CaseField("uncertainty", "real", "computed uncertainty of the value", unit),
            CaseField("criticality", "text", "supercritical, subcritical, or empty"),
            CaseField("coefficient", "real", "of the normal form"),
        )

    def compute(self, model: Model) -> CaseValues:
        """Follow the response."""
        check_followed(model)
        settings = Settings(largest_period=self.largest_period)
        branches = trace_response(
            model, self.vary, self.ends, settings=settings, through_stick=True
        )
        if any(branch.interrupted for branch in branches):
            raise KeyboardInterrupt
        loss = first_loss(branches[0], self.ends[0])
        given_up = sum(branch.failed for branch in branches)
        return self._case(model, loss, [branch.special for branch in branches], given_up)

    def together(self, models: Sequence[Model]) -> list[CaseValues | None]:
        """Follow ordinary responses as a batch."""
        settings = Settings(largest_period=self.largest_period)
        cases = follow_batch(models, self.vary, self.ends, settings, wanted="special")
        losses = [self.batched_loss(case) for case in cases]
        return [
            None if loss is None else self._case(model, loss, case.special, 0)
            for model, case, loss in zip(models, cases, losses, strict=True)
        ]

    def _case(
        self, model: Model, loss: Loss, special: Sequence[Sequence[SpecialPoint]], given_up: int
    ) -> CaseValues:
        """Return the values of a response; special points are given by branch."""
        listed = [
            (
                *(point.type, number, point.period, point.value, point.uncertainty),
                *(point.criticality, point.coefficient),
            )
            for number, points in enumerate(special, 1)
            for point in points
        ]
        return self.case(model, (*_loss_values(loss), len(special), given_up), listed)


class ThresholdWork(LossWork):
    """Where the response of period 1 first loses its stability, and by what."""

    what: Literal["threshold"]

    def together(self, models: Sequence[Model]) -> list[CaseValues | None]:
        """Follow ordinary responses as a batch, each until it loses its stability."""
        settings = Settings(largest_period=1)
        cases = follow_batch(models, self.vary, self.ends, settings, wanted="loss")
        losses = [self.batched_loss(case) for case in cases]
        return [
            None if loss is None else self.case(model, _loss_values(loss))
            for model, loss in zip(models, losses, strict=True)
        ]

    def compute(self, model: Model) -> CaseValues:
        """Follow the response until it meets a bifurcation."""
        check_followed(model)
        branch = followed_to_loss(model, self.vary, self.ends, through_stick=True)
        return self.case(model, _loss_values(first_loss(branch, self.ends[0])))


class LocusWork(Work):
    """Loci of some types in a window: how far they reach, and their points of codimension two."""

    what: Literal["locus"]
    types: tuple[str, ...] = ("PD",)
    periods: tuple[int, ...] = (1,)
    window: dict[str, options.Span]

    def varied(self) -> Collection[str]:
        """Return the two parameters of the window."""
        return tuple(self.window)

    def checked(self, model: Model) -> Self:
        """Return it with the window in SI units."""
        if len(self.window) != 2:
            raise InputError(
                f"compute.window names {', '.join(self.window) or 'nothing'}; give the spans of "
                "two parameters, e.g. {f = [11.5, 13.5], Nd = [0, 0.98]}"
            )
        check_requested(model, self.types, self.periods)
        spans = {name: parsed_span(model, name, span) for name, span in self.window.items()}
        return self.model_copy(update={"window": spans})

    def quantities(self, model: Model) -> tuple[CaseField, ...]:
        """Return the quantities of every case."""
        ends = [
            CaseField(f"{which}_{name}", "real", f"{which} of {name} along all loci",
                     model.parameter(name).unit)
            for name in self.window
            for which in ("min", "max")
        ]  # fmt: skip
        return (CaseField("loci", "whole", "number of loci"), *ends)

    def lists(self, model: Model) -> tuple[CaseField, ...]:
        """Return the quantities of each point of codimension two."""
        return (
            CaseField("type", "text", "type of special point"),
            CaseField("locus", "whole", "number of its locus, from 1"),
            CaseField("locus_type", "text", "type of its locus"),
            CaseField("period", "whole", "in forcing periods"),
            *(
                CaseField(name, "real", f"{name} there", model.parameter(name).unit)
                for name in self.window
            ),
        )

    def compute(self, model: Model) -> CaseValues:
        """Follow the loci."""
        first, second = self.window
        spans = tuple((float(low), float(high)) for low, high in self.window.values())
        plane, window = (first, second), (spans[0], spans[1])
        corner = model.replace(**{first: window[0][0], second: window[1][0]})
        result = find_bifurcation_set(
            measured_across(corner, plane, window),
            plane,
            window,
            types=self.types,
            periods=self.periods,
            regions=False,
        )
        if result.interrupted:
            raise KeyboardInterrupt
        ends: list[float | None] = []
        for place in (0, 1):
            along = [item.values[:, place] for item in result.loci if len(item.values)]
            ends += [min(map(min, along)), max(map(max, along))] if along else [None, None]
        listed = [
            (point.type, item.id, item.type, item.period, *point.values)
            for item in result.loci
            for point in item.special
        ]
        return self.case(model, (len(result.loci), *ends), listed)


class TrajectoryWork(Work):
    """Something of the solution from one state."""

    start: options.Start = None

    def checked(self, model: Model) -> Self:
        """Return it unchanged if the model has such a start."""
        initial_state(model, self.start)
        return self


class SimulationWork(TrajectoryWork):
    """A solution from one state: whether it becomes steady, its period, last state and extrema."""

    what: Literal["simulation"]
    periods: options.Periods = None
    tolerance: options.SteadyTolerance = 1e-9

    def quantities(self, model: Model) -> tuple[CaseField, ...]:
        """Return the quantities of every case."""
        return (
            CaseField("settled", "whole", "1 if the solution became steady, else 0"),
            CaseField("period", "whole", "period of the steady solution; 0 if none", none=0),
            CaseField("duration", "real", "seconds of one period of a cycle", "s"),
            CaseField("time", "real", "seconds of the solution", "s"),
            CaseField("reason", "text", "why the solution ended early"),
            *(
                CaseField(f"last_{state.name}", "real", f"last stroboscopic state: {state.doc}",
                         state.unit)
                for state in model.states
            ),
            *(
                CaseField(f"{measure}_{item.name}", "real",
                         f"{measure} {item.name} of the steady solution, else of the last periods",
                         item.unit)
                for item in _outputs(model)
                for measure in ("min", "max")
            ),
        )  # fmt: skip

    def compute(self, model: Model) -> CaseValues:
        """Integrate the solution."""
        result = simulate(model, self.periods, self.start, tolerance=self.tolerance)
        settlement, stopped = result.settlement, result.stopped
        names = [item.name for item in _outputs(model)]
        ends = np.full((len(names), 2), np.nan)  # what ended early lasts no more
        if stopped is None:
            extrema = steady_extrema(result, names)
            ends = np.column_stack([extrema.minimum[0], extrema.maximum[0]])
        values = (int(settlement.settled), settlement.period, settlement.duration, result.duration)
        reason = "" if stopped is None else stopped.reason
        return self.case(model, (*values, reason, *result.states[-1], *ends.ravel()))


def _outputs(model: Model) -> tuple[State | Output, ...]:
    return (*model.states, *model.outputs())


class LyapunovWork(TrajectoryWork):
    """Growth rates of perturbations of a solution: periodic, a torus or chaos."""

    what: Literal["lyapunov"]
    periods: options.ExponentPeriods = None
    tolerance: options.ExponentTolerance = 1e-8

    def quantities(self, model: Model) -> tuple[CaseField, ...]:
        """Return the quantities of every case."""
        unit = "1/forcing period" if model.forced else "1/s"
        numbers = range(1, len(model.states) + 1)
        return (
            CaseField("classification", "text", "periodic, torus, chaos, equilibrium or undecided"),
            CaseField(
                "period", "whole", "of a periodic solution, in forcing periods; else 0", none=0
            ),
            *(CaseField(f"exponent_{k}", "real", "Lyapunov exponent", unit) for k in numbers),
            *(CaseField(f"error_{k}", "real", f"error of exponent {k}", unit) for k in numbers),
        )

    def compute(self, model: Model) -> CaseValues:
        """Propagate the solution and its perturbations."""
        start = initial_state(model, self.start)
        result = find_exponents(model, start, self.periods, self.tolerance)
        if result.interrupted:
            raise KeyboardInterrupt
        unit = 1.0 if model.forced else float(result.model.values[DURATION.name])
        last = result.estimates[-1]
        classification = result.classification.kind, result.classification.period
        return self.case(model, (*classification, *(last.exponents / unit), *(last.errors / unit)))


OUTCOMES = {
    **{f"period_{period}": f"responses of period {period}" for period in (1, 2)},
    "longer": "responses of other periods",
    **{kind: f"attractors that are: {kind}" for kind in ("torus", "chaos", "cycle", "equilibrium")},
    "ended": "nothing, as they end at a limit or are held by friction",
    "undecided": "an unknown solution",
}
"""What starts converge to, by the end of the name of its fraction."""


class AttractorsWork(Work):
    """All attractors reached from a box of starts, and the fractions of their basins."""

    listed: ClassVar[str] = "attractor"

    what: Literal["attractors"]
    box: options.Box = None
    starts: options.Starts = 256
    seed: options.Seed = 0
    periods: options.SearchPeriods = None

    def checked(self, model: Model) -> Self:
        """Return it unchanged if the model has such a box."""
        if self.box is not None:
            checked_box(model, self.box)
        return self

    def quantities(self, model: Model) -> tuple[CaseField, ...]:
        """Return the quantities of every case."""
        return (
            CaseField("attractors", "whole", "number of attractors"),
            *(
                CaseField(
                    f"fraction_{name}", "real", f"fraction of the starts that converge to {meaning}"
                )
                for name, meaning in OUTCOMES.items()
            ),
        )

    def lists(self, model: Model) -> tuple[CaseField, ...]:
        """Return the quantities of each attractor."""
        return (
            CaseField("kind", "text", "periodic, torus, chaos, cycle or equilibrium"),
            CaseField("period", "whole", "in forcing periods; 0 where nothing repeats with them"),
            CaseField("fraction", "real", "fraction of the starts that converge to it"),
            *(
                CaseField(f"state_{state.name}", "real", f"a state on it: {state.doc}", state.unit)
                for state in model.states
            ),
        )

    def compute(self, model: Model) -> CaseValues:
        """Search the attractors."""
        model = measured(model)
        box = box_around(model) if self.box is None else checked_box(model, self.box)
        result = search(model, box.starts(self.starts, self.seed), self.periods)
        if result.interrupted:
            raise KeyboardInterrupt
        sums = dict.fromkeys(OUTCOMES, 0.0)
        sums["ended"] = float(np.mean(result.labels == ENDED))
        sums["undecided"] = float(np.mean(result.labels == UNDECIDED))
        listed = []
        for item in result.attractors:
            fraction = float(np.mean(result.labels == item.id))
            name = item.kind
            if name == "periodic":
                name = f"period_{item.period}"
            sums[name if name in sums else "longer"] += fraction
            listed.append((item.kind, item.period, fraction, *item.state))
        return self.case(model, (len(listed), *sums.values()), listed)


Known = ResponseWork | ThresholdWork | LocusWork | SimulationWork | LyapunovWork | AttractorsWork

WORK: TypeAdapter[Known] = TypeAdapter(Annotated[Known, Field(discriminator="what")])
"""Reads the table of a computation; the entry ``what`` selects it."""
