"""How uncertain a threshold is where parameters scatter, in one call."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from slipfold.branches.special_point import SpecialPoint, sensitive_to
from slipfold.computations.given import checked_count, checked_point
from slipfold.design_space.correlation import parse_correlation
from slipfold.design_space.drawn import drawn
from slipfold.design_space.placed_point import PlacedPoint
from slipfold.design_space.sampling import (
    INTERRUPTED,
    thresholds_at,
)
from slipfold.design_space.scatter import Scatter
from slipfold.design_space.scatter_given import parse_scatter
from slipfold.design_space.sobol_indices import index_design, indices_of, names_of
from slipfold.errors import InputError
from slipfold.models.model import Model
from slipfold.models.parameter import Parameter
from slipfold.models.quantity import parse_quantity
from slipfold.progress import Observer, Progress
from slipfold.results.diagram import Labelled
from slipfold.results.records import provenance
from slipfold.results.uncertainty import ThresholdUncertainty


def uncertainty(
    point: SpecialPoint | Labelled,
    scatter: Mapping[str, str | Mapping[str, Any]],
    *,
    correlation: Mapping[Any, float | str] | ArrayLike | None = None,
    samples: int = 1024,
    seed: int = 0,
    loads: Sequence[float | str] = (),
    indices: bool = False,
    observer: Observer | None = None,
) -> ThresholdUncertainty:
    """Tell how a threshold scatters with parameters: from its gradients, and from samples.

    Each sample is the same special point, located at its own parameter values: whether another
    bifurcation comes before it there is not asked. Samples where it has vanished or is not found
    are left out of bands, and counted; probabilities have an interval that holds them either way.

    Parameters
    ----------
    point
        The threshold: a special point of a branch, LP, PD, NS, HB, GRAZE or LIFT.
    scatter
        How parameters scatter about their values at the point, by name:
        ``"normal 5%"`` (standard deviation), ``"uniform 2deg"`` (half the width), ``"uniform
        0.4:0.6"``, ``"lognormal 5%"`` or ``"normal 5%:0.4:0.6"`` (cut off); sizes in percent of the
        value, with a unit, or in the SI unit. Or a table as studies have it.
    correlation
        Correlations of pairs of parameters, e.g. ``{"mu,Vd": 0.5}``, or their matrix in the order
        of `scatter`; of normal scores (a Gaussian copula), so that they are those of the parameters
        where these are normal. Without it they scatter independently.
    samples
        How many samples (Sobol's, scrambled); a power of 2.
    seed
        Seed of the samples.
    loads
        Values of the parameter that was followed, at which the probability that the response is
        still quiet is told in summaries and records.
    indices
        Whether Sobol's indices are computed: from ``samples * (d + 2)`` more thresholds of d
        parameters. That needs the extra ``slipfold[sensitivity]``.
    observer
        Called before every sample with a `slipfold.Progress`. If it raises
        `KeyboardInterrupt`, or the user does, what is known by then is returned.

    Returns
    -------
    ThresholdUncertainty
        Samples with their thresholds, gradients, bands and probabilities by both ways.

    Raises
    ------
    InputError
        If a scatter or correlation cannot be used, the point has no gradients or is not found
        again, or SALib is missing.

    Examples
    --------
    >>> import slipfold as sf
    >>> diagram = sf.response(sf.SlidingOscillator(), vary="Nd", span=(0, 0.05), f=12.5)
    >>> scatter = {"mu": "normal 5%", "Vd": "uniform 1%"}
    >>> found = sf.uncertainty(diagram.special[0], scatter, samples=64)
    >>> [round(end, 4) for end in found.band(0.95, by="gradients")]
    [0.043, 0.0441]
    >>> [round(end, 4) for end in found.band(0.95)]
    [0.0431, 0.0442]
    """
    point = checked_point(point)
    model, count = point.model, checked_count(samples, "samples")
    start = checked_count(seed, "seed", least=0)
    scatters = _scatters(point, scatter)
    parameter = model.parameter(point.vary)
    known = tuple(_load(value, parameter) for value in loads)
    matrix = parse_correlation(correlation, names_of(scatters))
    if indices and not np.array_equal(matrix, np.eye(len(scatters))):
        raise InputError(
            "Sobol indices are of parameters that scatter independently; leave out correlation or "
            "indices"
        )
    started = perf_counter()
    placed = PlacedPoint.at(point, tuple(item.name for item in scatters))
    places = drawn("sobol", count, start, scatters, correlation=matrix)
    more = index_design(scatters, count, start) if indices else np.empty((0, len(scatters)))
    total = len(places) + len(more)

    def tell(done: int, lost: int) -> None:
        if observer is not None:
            observer(Progress("samples", done, total, values={"failures": lost}))

    found, reasons = thresholds_at(placed, np.concatenate([places, more]), tell)
    missing, told = _missing(reasons[count:]), None
    if indices and not missing:
        told = indices_of(found[count:], names_of(scatters), start)
    return ThresholdUncertainty(
        model=model,
        type=point.type,
        vary=point.vary,
        value=placed.value,
        period=point.period,
        scatters=scatters,
        gradient=placed.gradient,
        samples=places,
        thresholds=found[:count],
        reasons=reasons[:count],
        seed=start,
        loads=known,
        correlation=matrix,
        indices=told,
        no_indices=missing,
        interrupted=bool((reasons == INTERRUPTED).any()),
        provenance=provenance(perf_counter() - started),
    )


def _load(value: float | str, parameter: Parameter) -> float:
    load = parse_quantity(value, parameter.unit, parameter.name)
    if not np.isfinite(load):
        raise InputError(f"the load {parameter.name} = {value!r} is not finite; give a number")
    return load


def _scatters(
    point: SpecialPoint, scatter: Mapping[str, str | Mapping[str, Any]]
) -> tuple[Scatter, ...]:
    if not scatter:
        raise InputError('no parameter scatters; give some, e.g. scatter={"mu": "normal 5%"}')
    for name in scatter:
        _checked_name(point.model, point.vary, name)
    return tuple(
        parse_scatter(text, point.model.parameter(name), point.model.values[name])
        for name, text in scatter.items()
    )


def _checked_name(model: Model, vary: str, name: str) -> None:
    parameter = model.parameter(name)
    if parameter.name not in sensitive_to(model, vary):
        raise InputError(
            f"{name} cannot scatter, since the threshold is a value of {vary}; give others"
            if name == vary
            else f"{name} belongs to an orbit and cannot scatter; give parameters of the model"
        )


def _missing(reasons: NDArray[np.str_]) -> str:
    """Say which of the thresholds that indices take are missing: these are shares of a variance."""
    if (reasons == INTERRUPTED).any():
        return "interrupted before all of their samples were reached"
    lost = reasons[reasons != ""]
    if not len(lost):
        return ""
    return f"{len(lost)} of {len(reasons)} samples have no threshold; first: {lost[0]}"
