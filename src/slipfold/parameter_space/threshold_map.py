"""Thresholds of stability over a grid of two parameters."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import product
from types import MappingProxyType

import numpy as np
from numpy.typing import ArrayLike, NDArray

from slipfold.arrays import Array
from slipfold.errors import InputError
from slipfold.flow.scales import measured_within
from slipfold.models.model import Model
from slipfold.parameter_space.search import INTERRUPTED, ThresholdSearch
from slipfold.progress import Observer, Progress
from slipfold.read_only import ReadOnly

TYPES = ("PD",)


@dataclass(frozen=True, eq=False)
class GridThresholds(ReadOnly):
    """Where the response of period 1 first loses its stability, over two parameters; frozen.

    Every array has the grid's two axes first. Where there is no threshold, `kinds` and `reasons`
    say why, and the numbers are NaN.

    `slipfold.ThresholdMap`, which adds what a result has, describes the fields.
    """

    model: Model
    threshold: str
    type: str
    over: Mapping[str, Array]
    span: tuple[float, float]
    values: Array
    states: Array
    multipliers: NDArray[np.complex128]
    residuals: Array
    kinds: NDArray[np.str_]
    reasons: NDArray[np.object_]
    followed: NDArray[np.bool_]

    @property
    def axes(self) -> tuple[str, str]:
        """Names of the grid's two parameters."""
        first, second = self.over
        return first, second

    @property
    def failures(self) -> dict[str, int]:
        """How many points have no threshold, by the reason in a few words, most frequent first."""
        counts = Counter(kind for kind in self.kinds.ravel().tolist() if kind)
        return dict(counts.most_common())

    @property
    def interrupted(self) -> bool:
        """Whether the computation was interrupted, so that points were not reached."""
        return INTERRUPTED in self.failures

    def model_at(self, first: int, second: int) -> Model:
        """Return the model of one point of the grid, at its threshold if it has one.

        Parameters
        ----------
        first, second
            Indices along the two axes.

        Raises
        ------
        InputError
            If the parameters of this point contradict each other.
        """
        own = {
            name: float(values[index])
            for (name, values), index in zip(self.over.items(), (first, second), strict=True)
        }
        value = float(self.values[first, second])
        return self.model.replace(
            **own, **{self.threshold: self.span[0] if np.isnan(value) else value}
        )

    def __repr__(self) -> str:
        """Return the threshold, its grid and the number of results."""
        first, second = self.axes
        size = f"{self.values.shape[0]} x {self.values.shape[1]}"
        found = int(np.isfinite(self.values).sum())
        missing = "".join(f", {count} {kind}" for kind, count in self.failures.items())
        return (
            f"<{type(self).__name__} of {self.model.name}: {self.type} in {self.threshold} over "
            f"{first} and {second}, {size} points, {found} thresholds{missing}>"
        )


def find_threshold_map(
    model: Model,
    threshold: str,
    type: str = "PD",
    *,
    over: Mapping[str, ArrayLike],
    span: tuple[float, float],
    observer: Observer | None = None,
) -> GridThresholds:
    """Find where the response of period 1 first loses its stability, over a grid of parameters.

    The responses of a few points are followed from the first value of the span. Between them the
    threshold, the orbit there and the stable response on the way are guessed by interpolation and
    corrected in batches; a point is accepted if the orbits on the way are stable, keep the limits
    of the model and lie near their guess. Where that cannot be shown, the response of the point
    itself is followed.

    Shapes: over (n,).

    >>> from slipfold.models import SlidingOscillator
    >>> speeds, angles = [0.5, 0.6, 0.7], [1.0, 1.1]
    >>> over = {"Vd": speeds, "alpha": angles}
    >>> found = find_threshold_map(SlidingOscillator(), "Nd", over=over, span=(0, 0.9))
    >>> found.values.shape, found.failures
    ((3, 2), {})
    """
    axes, values = _checked_grid(model, threshold, over)
    first, last = _checked_span(model, threshold, span)
    if type not in TYPES:
        raise InputError(
            f"type = {type!r} cannot be mapped; give 'PD', or follow the bifurcation as a locus"
        )
    orders = [np.argsort(own) for own in values]
    ordered = (values[0][orders[0]], values[1][orders[1]])

    def report(search: ThresholdSearch) -> None:
        if observer is not None:
            waiting = int(np.count_nonzero(search.kinds == INTERRUPTED))
            found = int(np.count_nonzero(search.kinds == ""))
            total = search.kinds.size
            failures = total - waiting - found
            observer(Progress("points", total - waiting, total, values={"failures": failures}))

    corners = product(*((own[0], own[-1]) for own in ordered), (last,))
    names = (*axes, threshold)
    at = [dict(zip(names, map(float, corner), strict=True)) for corner in corners]
    model = measured_within(model, at)
    search = ThresholdSearch(model, threshold, axes, ordered, (first, last), report)
    search.run()
    found = search.kinds == ""
    # As they were given: the search needs increasing values.
    given = np.ix_(*(np.argsort(order) for order in orders))
    return GridThresholds(
        model,
        threshold,
        type,
        MappingProxyType(dict(zip(axes, values, strict=True))),
        (first, last),
        np.where(found, search.ends, np.nan)[given],
        np.where(found[..., None], search.states[:, :, -1], np.nan)[given],
        search.multipliers[given],
        search.residuals[given],
        search.kinds[given].astype(str),
        search.reasons[given],
        search.followed[given],
    )


def _checked_grid(
    model: Model, threshold: str, over: Mapping[str, ArrayLike]
) -> tuple[tuple[str, str], tuple[Array, Array]]:
    model.parameter(threshold)
    if len(over) != 2:
        raise InputError(
            f"over = {dict(over)!r} does not name two parameters; give their values by name, e.g. "
            f"{{'{model.parameters[0].name}': [...], '{model.parameters[1].name}': [...]}}"
        )
    if threshold in over:
        raise InputError(
            f"{threshold} is the threshold that is sought, so it cannot span the grid as well; "
            "give another parameter in over"
        )
    first, second = over
    checked = [_checked_values(model, name, values) for name, values in over.items()]
    return (first, second), (checked[0], checked[1])


def _checked_values(model: Model, name: str, values: ArrayLike) -> Array:
    parameter, checked = model.variable_parameter(name), np.array(values, dtype=float)
    if checked.ndim != 1 or not checked.size:
        raise InputError(
            f"the values of {name} have the shape {checked.shape}; give a list of one or more"
        )
    for value in checked:
        parameter.check(value)
    ordered = np.sort(checked)
    repeated = ordered[1:][np.diff(ordered) == 0]
    if len(repeated):
        raise InputError(f"{name} = {repeated[0]:g} occurs twice in over; give each value once")
    return checked


def _checked_span(model: Model, name: str, span: tuple[float, float]) -> tuple[float, float]:
    first, last = (model.parameter(name).check(float(value)) for value in span)
    if first == last:
        raise InputError(
            f"the span of {name} from {first:g} to {last:g} is empty; give two different values"
        )
    return first, last
