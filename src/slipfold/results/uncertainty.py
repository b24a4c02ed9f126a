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
from slipfold.parameter_space.sampling import INTERRUPTED, SobolIndices
from slipfold.parameter_space.scatter import Scatter, scatter_text, scattered_away
from slipfold.results.fields import REAL, TEXT, Column, Entry, Items, ItemTable, ResultPart
from slipfold.results.records import Provenance, SavedTable
from slipfold.results.result import Result
from slipfold.results.tables import Variable
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

SCATTERS = Items("scattered", Scatter, (
    Column("name", TEXT, "scattered parameter", name="scattered", label=True),
    Column("kind", TEXT, "normal, uniform or lognormal"),
    Column("mean", REAL, "value about which it scatters; the median if lognormal"),
    Column("size", REAL, "standard deviation if normal, half the width if uniform, deviation of "
           "the logarithm if lognormal"),
    Column("low", REAL, "smallest value of it, where it is cut off"),
    Column("high", REAL, "largest value of it, likewise"),
), "scatter_", doc="How each parameter scatters.")  # fmt: skip


@dataclass(frozen=True)
class Indices(ResultPart):
    """Sobol's indices as an attribute, which may be None."""

    doc = "Sobol's indices; None if they were not requested or cannot be computed."

    def names(self, key: str) -> set[str]:
        """Return the names of the arrays."""
        return {f"scatter_{name}" for name in INDICES}

    def variables(self, result: Any, key: str) -> dict[str, Variable]:
        """Return an array for each index."""
        found: SobolIndices | None = getattr(result, key)
        columns = (
            [] if found is None else [Column(name, REAL, INDICES[name], "") for name in INDICES]
        )
        return ItemTable(("scattered",), tuple(columns), "scatter_", joined=True).variables(
            [found], {}
        )

    def read(self, saved: SavedTable, result: Any, key: str) -> SobolIndices | None:
        """Return the indices."""
        names = [f"scatter_{name}" for name in INDICES]
        if not set(names) & set(saved.columns):
            return None
        values = [saved.columns[name] for name in names]
        return SobolIndices(tuple(item.name for item in result.scatters), *values)


@dataclass(frozen=True, eq=False, repr=False)
class ThresholdUncertainty(Result):
    """A threshold where parameters scatter; frozen.

    Made by `slipfold.uncertainty` and `slipfold.load`. What samples say is of those that
    have the threshold.

    Notes
    -----
    In the dataset of `to_xarray`, along ``scattered``: the parameters with their scatter and
    gradients; along ``sample``: values and thresholds. In the spreadsheet of `to_csv` a sample is
    a row. In `to_json`, schema slipfold.uncertainty/1, bands of 95 %. `plot` draws the probability
    that the response is quiet over the parameter.

    Examples
    --------
    >>> import slipfold as sf
    >>> diagram = sf.response(sf.SlidingOscillator(), vary="Nd", span=(0, 0.05), f=12.5)
    >>> found = sf.uncertainty(diagram.special[0], {"Vd": "normal 1%"}, samples=64)
    >>> round(found.quiet(0.0434), 2), round(found.quiet(0.0434, by="gradients"), 2)
    (0.77, 0.77)
    """

    schema = "slipfold.uncertainty/1"

    rows = "sample"
    gap = "\n\n"
    recorded = ("type", "vary", "value", "period", "lost", "interrupted", "correlation")
    arrays = MappingProxyType({
        "_units": Entry("scattered", "unit of the parameter", kind=TEXT, name="scattered_units",
                        label=True),
        "linear": Entry("sample", "threshold from the gradients", "{vary}",
                        name="linear_threshold", head="{vary} by gradients"),
    })  # fmt: skip

    model: Model
    type: Annotated[str, "Type of the special point, e.g. ``PD``."]
    vary: str
    value: Annotated[float, "The threshold at the values of the model."]
    period: Annotated[int, "Period of its orbit in forcing periods."]
    scatters: Annotated[tuple[Scatter, ...], SCATTERS]
    gradient: Annotated[
        Array,
        Entry("scattered", "derivative of the threshold by it, in units of the threshold over its",
              "see scattered_units", name="scatter_gradient"),
    ]  # fmt: skip
    correlation: Annotated[
        Array,
        Entry("scattered other", "correlation with each of the other parameters", "",
              name="scatter_correlation"),
    ]  # fmt: skip
    samples: Annotated[
        Array,
        Entry("sample scattered", "values of the parameters", name="sample_values", head=""),
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
        tuple[float, ...], "Values of `vary` of which summaries say the probability of being quiet."
    ]
    indices: Annotated[SobolIndices | None, Indices()]
    no_indices: Annotated[str, "Why there are no indices that were requested; empty otherwise."]
    interrupted: bool
    provenance: Provenance

    @property
    def _units(self) -> list[str]:
        return [self.model.parameter(item.name).unit for item in self.scatters]

    @property
    def linear(self) -> Array:
        """The threshold at each sample as its gradients have it, shape (n,)."""
        means = np.array([self.model.values[item.name] for item in self.scatters])
        return np.asarray(self.value + (self.samples - means) @ self.gradient)

    @property
    def lost(self) -> int:
        """How many samples have no threshold: it has vanished there, or was not found."""
        return len(self._why_lost())

    @property
    def shares(self) -> Array:
        """Fraction of the variance that each parameter accounts for by the gradients, shape (d,).

        Of correlated parameters a covariance counts half to each, so that a share may be negative.
        """
        parts = self.gradient * [item.deviation for item in self.scatters]
        return np.asarray(parts * (self.correlation @ parts) / (parts @ self.correlation @ parts))

    def deviation(self, by: str = "samples") -> float:
        """Return the standard deviation of the threshold, in its unit.

        Parameters
        ----------
        by
            ``"samples"`` or ``"gradients"``.
        """
        if _checked(by) == "gradients":
            parts = self.gradient * [item.deviation for item in self.scatters]
            return float(np.sqrt(parts @ self.correlation @ parts))
        return float(np.nanstd(self.thresholds, ddof=1))

    def band(self, level: float = LEVEL, by: str = "samples") -> tuple[float, float]:
        """Return the interval that holds the threshold with some probability, as much on each side.

        Parameters
        ----------
        level
            The probability.
        by
            ``"samples"``: thresholds located again; ``"gradients"``: those that are linear in the
            parameters, at the same samples.

        Returns
        -------
        tuple of float
            Its ends, in the unit of the threshold.

        Raises
        ------
        InputError
            If `level` is not between 0 and 1, or `by` is unknown.
        """
        if not 0 < level < 1:
            raise InputError(f"level = {level!r} is no probability; give one between 0 and 1")
        values = self._known(by)
        if not len(values):
            return np.nan, np.nan
        low, high = np.quantile(values, [(1 - level) / 2, (1 + level) / 2])
        return float(low), float(high)

    def quiet(self, load: float, by: str = "samples") -> float:
        """Return the probability that a value of the parameter is below the threshold.

        Parameters
        ----------
        load
            The value, in SI units.
        by
            ``"samples"`` or ``"gradients"``.

        Returns
        -------
        float
            The share of samples whose threshold is larger, of those that have it: samples without
            it (see `lost`) are left out, since they may be quiet at any load or at none. Whether
            another bifurcation comes before the threshold is not asked.
        """
        self._check_load(load)
        values = self._known(by)
        return float((values > load).mean()) if len(values) else np.nan

    def quiet_between(self, load: float, by: str = "samples") -> tuple[float, float]:
        """Return the interval of 95 % confidence of the probability of being quiet.

        It is Wilson's, as for samples drawn at random; Sobol's are spread more evenly. Samples
        without the threshold count as loud for its lower end and as quiet for its upper one, and
        of the gradients those too that `thresholds` contradict.

        Parameters
        ----------
        load
            The value, in SI units.
        by
            ``"samples"`` or ``"gradients"``.

        Returns
        -------
        tuple of float
            Its ends.
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
        heads += [with_unit(f"quiet at {load:g}", unit) for load in self.loads]
        rows = [
            [
                f"by {way}",
                *(f"{value:.6g}" for value in (self.deviation(way), *self.band(by=way))),
                *(self._quiet_text(load, way) for load in self.loads),
            ]
            for way in WAYS
        ]
        return PrintedTable(heads, rows, words=("",))

    def _quiet_text(self, load: float, way: str) -> str:
        low, high = self.quiet_between(load, way)
        return f"{self.quiet(load, way):.1%} ({low:.1%} to {high:.1%})"

    def _rows(self) -> PrintedTable:
        heads = ["parameter", "scatter", "gradient", "share"]
        found = self.indices
        if found is not None:
            heads += ["first index", "total index"]
        rows = []
        for place, item in enumerate(self.scatters):
            name = headed(self.model.parameter(item.name))
            words = scatter_text(item, self.model.values[item.name])
            row = [name, words, f"{self.gradient[place]:.6g}"]
            row.append(f"{self.shares[place]:.2%}")
            if found is not None:
                row += [
                    f"{found.first[place]:.3f} +- {found.first_error[place]:.3f}",
                    f"{found.total[place]:.3f} +- {found.total_error[place]:.3f}",
                ]
            rows.append(row)
        return PrintedTable(heads, rows, words=("parameter", "scatter"))

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
        if away := scattered_away(self.scatters, self.model.values):
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
        return any(np.isfinite((item.low, item.high)).any() for item in self.scatters)

    def _title(self) -> str:
        at = parameter_text(self.model.parameter(self.vary), self.value)
        return f"scatter of {self.type} of {self.model.name} at {at}"

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
                    "quiet": [[load, self.quiet(load, way)] for load in self.loads],
                    "quiet_between": [
                        [load, *self.quiet_between(load, way)] for load in self.loads
                    ],
                }
                for way in WAYS
            },
            "scatter": {
                item.name: {
                    "kind": item.kind,
                    "mean": item.mean,
                    "size": item.size,
                    **({key: getattr(item, key) for key in ENDS} if self._cut else {}),
                    "gradient": self.gradient[index],
                    "share": self.shares[index],
                    **self._indices(index),
                }
                for index, item in enumerate(self.scatters)
            },
        }


def _checked(by: str) -> str:
    if by not in WAYS:
        raise InputError(f"by = {by!r} is unknown; give {' or '.join(map(repr, WAYS))}")
    return by
