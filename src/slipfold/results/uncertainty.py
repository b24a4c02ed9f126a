"""A threshold with uncertain parameters as a result: bands, probabilities, indices."""

from __future__ import annotations

from dataclasses import dataclass
from types import MappingProxyType
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.errors import InputError
from slipfold.models.model import Model
from slipfold.parameter_space.distributions import Distribution, distribution_text, other_means
from slipfold.parameter_space.sampling import INTERRUPTED, SobolIndices
from slipfold.results.fields import REAL, TEXT, Column, Entry, Items, Nested
from slipfold.results.records import Provenance
from slipfold.results.result import Result
from slipfold.text import PrintedTable, headed, parameter_text, with_unit

LEVEL = 0.95
"""Probability of the bands in summaries and records."""

WAYS = ("samples", "gradients")


INDICES = {
    "first": "fraction of the variance that the parameter accounts for individually",
    "total": "fraction of the variance that the parameter takes part in",
    "first_error": "half the interval of 95 % confidence of the first index",
    "total_error": "half the interval of 95 % confidence of the total index",
}

ENDS = ("low", "high")

DISTRIBUTIONS = Items("uncertain", (
    Column("name", TEXT, "uncertain parameter", name="uncertain", label=True),
    Column("kind", TEXT, "normal, uniform or lognormal"),
    Column("mean", REAL, "mean of the normal or uniform distribution, median of the lognormal one"),
    Column("size", REAL, "standard deviation if normal, half the width if uniform, deviation of "
           "the logarithm if lognormal"),
    Column("low", REAL, "smallest value of it, where it is cut off"),
    Column("high", REAL, "largest value of it, likewise"),
), "uncertain_", Distribution, doc="Distribution of each uncertain parameter.")  # fmt: skip


SOBOL = Nested(
    SobolIndices,
    {
        name: Entry("uncertain", meaning, "", name=f"uncertain_{name}", head=name)
        for name, meaning in INDICES.items()
    },
    "Sobol's indices; None if they were not requested or cannot be computed.",
    {"names": lambda _, result: tuple(item.name for item in result.distributions)},
)

By = Annotated[
    str,
    '``"samples"``: thresholds located again; ``"gradients"``: those that are linear in the '
    "parameters, at the same samples.",
]
LoadValue = Annotated[float, "The value, in SI units."]


@dataclass(frozen=True, eq=False, repr=False)
class ThresholdUncertainty(Result):
    """A threshold of uncertain parameters; frozen.

    Made by `slipfold.uncertainty` and `slipfold.load`. What samples say is of those that
    have the threshold.

    Notes
    -----
    `plot` draws the probability that the threshold is above a load, over the load.

    Examples
    --------
    >>> import slipfold as sf
    >>> diagram = sf.response(sf.SlidingOscillator(), vary="Nd", span=(0, 0.05), f=12.5)
    >>> found = sf.uncertainty(diagram.special[0], {"Vd": "normal 1%"}, samples=64)
    >>> [round(found.probability_above(0.0434, by=way), 2) for way in ("samples", "gradients")]
    [0.77, 0.77]
    """

    schema = "slipfold.uncertainty/1"
    row = "a sample"

    rows = "sample"
    gap = "\n\n"
    recorded = ("type", "vary", "value", "period", "lost", "interrupted", "correlation")
    arrays = MappingProxyType({
        "_units": Entry("uncertain", "unit of the parameter", kind=TEXT, name="uncertain_units",
                        label=True),
        "linear": Entry("sample", "threshold from the gradients", "{vary}",
                        name="linear_threshold", head="{vary} by gradients"),
    })  # fmt: skip

    model: Model
    type: Annotated[str, "Type of the special point, e.g. ``PD``."]
    vary: str
    value: Annotated[float, "The threshold at the values of the model."]
    period: Annotated[int, "Period of its orbit in forcing periods."]
    distributions: Annotated[tuple[Distribution, ...], DISTRIBUTIONS]
    gradient: Annotated[
        Array,
        Entry("uncertain", "derivative of the threshold by it, in units of the threshold over its",
              "see uncertain_units", name="uncertain_gradient"),
    ]  # fmt: skip
    correlation: Annotated[
        Array,
        Entry("uncertain other", "correlation with each of the other parameters", "",
              name="uncertain_correlation"),
    ]  # fmt: skip
    samples: Annotated[
        Array, Entry("sample uncertain", "values of the parameters", name="sample_values", head="")
    ]
    thresholds: Annotated[
        Array,
        Entry("sample", "the same special point, even if another bifurcation comes before it; NaN: "
              "vanished or not found, left out of probabilities", "{vary}", name="threshold",
              head="{vary}"),
    ]  # fmt: skip
    reasons: Annotated[
        NDArray[np.str_],
        Entry("sample", "why there is no threshold", name="reason", head="no threshold"),
    ]
    seed: int
    loads: Annotated[
        tuple[float, ...],
        "Loads, values of `vary`, of which the summary states `probability_above`.",
    ]
    indices: Annotated[SobolIndices | None, SOBOL]
    no_indices: Annotated[str, "Why there are no indices that were requested; empty otherwise."]
    interrupted: bool
    provenance: Provenance

    @property
    def _units(self) -> list[str]:
        return [self.model.parameter(item.name).unit for item in self.distributions]

    @property
    def linear(self) -> Array:
        """The threshold at each sample as its gradients have it, shape (n,)."""
        means = np.array([self.model.values[item.name] for item in self.distributions])
        return np.asarray(self.value + (self.samples - means) @ self.gradient)

    @property
    def lost(self) -> int:
        """How many samples have no threshold: it has vanished there, or was not found."""
        return len(self._why_lost())

    @property
    def fractions(self) -> Array:
        """Fraction of the variance that each parameter accounts for by the gradients, shape (d,).

        A covariance of two parameters counts half to each, so that a fraction may be negative.
        """
        parts = self.gradient * [item.deviation for item in self.distributions]
        return np.asarray(parts * (self.correlation @ parts) / (parts @ self.correlation @ parts))

    def deviation(self, by: By = "samples") -> float:
        """Return the standard deviation of the threshold, in its unit."""
        if _checked(by) == "gradients":
            parts = self.gradient * [item.deviation for item in self.distributions]
            return float(np.sqrt(parts @ self.correlation @ parts))
        known = self.thresholds[np.isfinite(self.thresholds)]
        return float(np.std(known, ddof=1)) if len(known) > 1 else np.nan

    def band(self, level: float = LEVEL, by: By = "samples") -> tuple[float, float]:
        """Return the interval that holds the threshold with some probability, as much on each side.

        Parameters
        ----------
        level
            The probability.
        """
        if not 0 < level < 1:
            raise InputError(f"level = {level!r} is no probability; give one between 0 and 1")
        values = self._known(by)
        if not len(values):
            return np.nan, np.nan
        low, high = np.quantile(values, [(1 - level) / 2, (1 + level) / 2])
        return float(low), float(high)

    def probability_above(self, load: LoadValue, by: By = "samples") -> float:
        """Return the probability that the threshold is above a value of the parameter.

        Returns
        -------
        float
            The fraction of samples with a larger threshold, of those that have one: samples without
            it (see `lost`) are left out, since they may be stable at any load or at none. Another
            bifurcation below the threshold is not searched for.
        """
        self._check_load(load)
        values = self._known(by)
        return float((values > load).mean()) if len(values) else np.nan

    def probability_bounds(self, load: LoadValue, by: By = "samples") -> tuple[float, float]:
        """Return the interval of 95 % confidence of `probability_above`.

        It is Wilson's, as for samples drawn at random; Sobol's are spread more evenly. Samples
        without the threshold count as unstable for its lower end and as stable for its upper one,
        and so do those of the gradients that `thresholds` contradict.
        """
        from scipy.stats import binomtest

        self._check_load(load)
        done = self.reasons != INTERRUPTED
        exact = self.thresholds[done]
        ways = [exact > load, np.isnan(exact)]
        if _checked(by) == "gradients":
            linear = self.linear[done] > load
            ways = [linear & ways[0], (linear != ways[0]) | ways[1]]
        if not len(exact):
            return 0.0, 1.0
        sure, unsure = (int(way.sum()) for way in ways)
        low, high = (
            binomtest(count, len(exact)).proportion_ci(LEVEL, "wilson")
            for count in (sure, sure + unsure)
        )
        return float(low.low), float(high.high)

    def _check_load(self, load: float) -> None:
        if not np.isfinite(load):
            raise InputError(f"the load {self.vary} = {load!r} is not finite; give a number")

    def _known(self, by: str) -> Array:
        values = self.linear if _checked(by) == "gradients" else self.thresholds
        return values[np.isfinite(values)]

    def _head(self) -> str:
        lost = f", {self.lost} of them without it" if self.lost else ""
        return f"{self._title()}, {len(self.samples)} samples{lost}"

    def _sections(self) -> list[PrintedTable | list[str]]:
        return [self._ways(), self._rows(), self._notes()]

    def _line(self) -> str:
        low, high = self.band()
        ends = parameter_text(self.model.parameter(self.vary), low, high)
        return f"{self._title()}: {LEVEL:.0%} within {ends}"

    def _ways(self) -> PrintedTable:
        unit = self.model.parameter(self.vary).unit
        heads = ["", "deviation", f"{LEVEL:.0%} from", "to"]
        heads += [f"P(threshold > {with_unit(f'{load:g}', unit)})" for load in self.loads]
        rows = [
            [
                f"by {way}",
                *(f"{value:.6g}" for value in (self.deviation(way), *self.band(by=way))),
                *(self._probability_text(load, way) for load in self.loads),
            ]
            for way in WAYS
        ]
        return PrintedTable(heads, rows, words=("",))

    def _probability_text(self, load: float, way: str) -> str:
        low, high = self.probability_bounds(load, way)
        return f"{self.probability_above(load, way):.1%} ({low:.1%} to {high:.1%})"

    def _rows(self) -> PrintedTable:
        heads = ["parameter", "distribution", "gradient", "fraction"]
        found = self.indices
        if found is not None:
            heads += ["first index", "total index"]
        rows = []
        for place, item in enumerate(self.distributions):
            name = headed(self.model.parameter(item.name))
            words = distribution_text(item, self.model.values[item.name])
            row = [name, words, f"{self.gradient[place]:.6g}"]
            row.append(f"{self.fractions[place]:.2%}")
            if found is not None:
                row += [
                    f"{found.first[place]:.3f} +- {found.first_error[place]:.3f}",
                    f"{found.total[place]:.3f} +- {found.total_error[place]:.3f}",
                ]
            rows.append(row)
        return PrintedTable(heads, rows, words=("parameter", "distribution"))

    def _notes(self) -> list[str]:
        said, lost = [], self._why_lost()
        if missing := int((self.reasons == INTERRUPTED).sum()):
            said.append(f"Interrupted: {missing} samples are missing.")
        if lost:
            said.append(
                f"No threshold at {len(lost)} of {len(self.samples)} samples, which bands and "
                "probabilities leave out and intervals of probabilities count either way; first: "
                f"{lost[0]}"
            )
        if away := other_means(self.distributions, self.model.values):
            said.append(
                f"Gradients are those of the case itself, at {', '.join(away)}: bands by them "
                "are drawn out from there to where the samples are."
            )
        if self.no_indices:
            said.append(f"No indices: {self.no_indices}")
        return [*said, *super()._notes()]

    def _why_lost(self) -> list[str]:
        return [reason for reason in self.reasons.tolist() if reason not in ("", INTERRUPTED)]

    @property
    def _cut(self) -> bool:
        """Whether any distribution is cut off."""
        return any(np.isfinite((item.low, item.high)).any() for item in self.distributions)

    def _title(self) -> str:
        at = parameter_text(self.model.parameter(self.vary), self.value)
        return f"distribution of {self.type} of {self.model.name} at {at}"

    def _indices(self, place: int) -> dict[str, Any]:
        """Indices of a parameter by name."""
        result = self.indices
        return (
            {} if result is None else {key: float(getattr(result, key)[place]) for key in INDICES}
        )

    def _record(self) -> dict[str, Any]:
        return {
            **super()._record(),
            "samples": len(self.samples),
            "no_indices": self.no_indices or None,
            "level": LEVEL,
            **{
                f"by_{way}": {
                    "deviation": self.deviation(way),
                    "band": self.band(by=way),
                    "probability": [
                        [load, self.probability_above(load, way)] for load in self.loads
                    ],
                    "probability_bounds": [
                        [load, *self.probability_bounds(load, way)] for load in self.loads
                    ],
                }
                for way in WAYS
            },
            "distributions": {
                item.name: {
                    "kind": item.kind,
                    "mean": item.mean,
                    "size": item.size,
                    **({key: getattr(item, key) for key in ENDS} if self._cut else {}),
                    "gradient": self.gradient[index],
                    "fraction": self.fractions[index],
                    **self._indices(index),
                }
                for index, item in enumerate(self.distributions)
            },
        }


def _checked(by: str) -> str:
    if by not in WAYS:
        raise InputError(f"by = {by!r} is unknown; give {' or '.join(map(repr, WAYS))}")
    return by
