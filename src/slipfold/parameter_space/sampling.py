"""Samples of distributed parameters, and Sobol's indices."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.errors import InputError
from slipfold.parameter_space.distributions import Distribution, correlated
from slipfold.parameter_space.optimum import NoSolutionError, ParameterizedPoint
from slipfold.read_only import Documented


def drawn(
    method: str,
    count: int,
    seed: int,
    distributions: Sequence[Distribution],
    option: str = "samples",
    correlation: Array | None = None,
) -> Array:
    """Return values of each parameter, shape (count, d): the same ones for the same seed.

    `method` is "latin hypercube", "sobol" or "random"; `option` is the name under which the count
    was given; `correlation` is that of normal scores, shape (d, d).

    >>> half = Distribution("mu", "uniform", 0.25, 0.25)
    >>> bool(drawn("latin hypercube", 4, 1, [half]).max() < 0.5)
    True
    """
    from scipy.stats import qmc

    size = len(distributions)
    if method == "sobol":
        check_power(count, option)
        fractions = qmc.Sobol(size, seed=seed).random(count)
    elif method == "latin hypercube":
        fractions = qmc.LatinHypercube(size, seed=seed).random(count)
    else:
        fractions = np.random.default_rng(seed).random((count, size))
    if correlation is not None:
        fractions = correlated(fractions, correlation)
    return quantiles(distributions, fractions)


def check_power(count: int, option: str) -> None:
    """Refuse a number of points that Sobol's sequence does not spread evenly."""
    if count & (count - 1):
        raise InputError(
            f"{option} = {count} is not a power of 2, as the numbers of Sobol's samples are; "
            f"give e.g. {1 << count.bit_length()}"
        )


def quantiles(distributions: Sequence[Distribution], fractions: Array) -> Array:
    """Return the quantiles of fractions. Shapes: fractions (n, d); returns (n, d)."""
    columns = [item.quantile(fractions[:, place]) for place, item in enumerate(distributions)]
    return np.stack(columns, axis=1)


RESAMPLES = 100
"""Bootstrap samples from which the errors of indices come."""

MINIMUM = 4
"""Minimum number of points: errors come from resampling them, in 35 ways from 4, but in 10 from 3,
too few for an interval of 95 %."""

SALTELLI = "saltelli"
"""Name of the sampling method that indices need."""


@dataclass(frozen=True, eq=False)
class SobolIndices(Documented):
    """Fractions of a variance that distributed parameters account for; frozen."""

    names: Annotated[tuple[str, ...], "The parameters."]
    first: Annotated[Array, "Fraction that each accounts for individually, shape (d,)."]
    total: Annotated[
        Array, "Fraction that it accounts for, including interactions with others, shape (d,)."
    ]
    first_error: Annotated[
        Array, "Half the widths of their intervals of 95 % confidence, shape (d,)."
    ]
    total_error: Annotated[Array, ""]


def index_design(
    distributions: Sequence[Distribution], count: int, seed: int, option: str = "samples"
) -> Array:
    """Return where to evaluate a function for its indices, shape (count (d + 2), d).

    `option` is the name under which the count was given.
    """
    if count < MINIMUM:
        raise InputError(
            f"{option} = {count} is too few for the errors of indices; give at least {MINIMUM}"
        )
    from scipy.stats import qmc

    d = len(distributions)
    points = qmc.Sobol(2 * d, seed=seed).random(count)  # two independent points in each row
    rows = np.repeat(points[:, None, :d], d + 2, axis=1)
    for place in range(d):
        rows[:, place + 1, place] = points[:, d + place]
    rows[:, -1] = points[:, d:]
    return quantiles(distributions, rows.reshape(-1, d))


def indices_of(values: Array, names: Sequence[str], seed: int) -> SobolIndices:
    """Return the indices from the values of a function there, with bootstrap errors.

    Shapes: values (count (d + 2),).
    """
    from scipy.special import ndtri

    rows = ((values - values.mean()) / (values.std() or 1.0)).reshape(-1, len(names) + 2)
    count = len(rows)
    chosen = np.random.default_rng(seed + 1).integers(count, size=(count, RESAMPLES))
    resampled = [_estimates(rows[subset]) for subset in chosen.T]
    errors = ndtri(0.975) * np.std(resampled, axis=0, ddof=1)
    return SobolIndices(tuple(names), *_estimates(rows), *errors)


def _estimates(rows: Array) -> Array:
    """Return the first and total indices.

    The estimators of Saltelli et al. (2010), Computer Physics Communications 181, table 2, (b) and
    (f). Shapes: rows (n, d + 2); returns (2, d).
    """
    first, crossed, second = rows[:, :1], rows[:, 1:-1], rows[:, -1:]
    variance = np.var([first, second])
    if variance == 0:
        return np.zeros((2, crossed.shape[1]))
    alone = np.mean(second * (crossed - first), axis=0)
    return np.array([alone, 0.5 * np.mean((first - crossed) ** 2, axis=0)]) / variance


INTERRUPTED = "interrupted before this sample was reached"


def thresholds_at(
    point: ParameterizedPoint,
    samples: Array,
    report: Callable[[int, int], None] = lambda done, missing: None,
) -> tuple[Array, NDArray[np.str_]]:
    """Return the threshold at each sample, and why there is none, both of shape (n,).

    `report` is called with how many are done and how many of them have none; if it raises
    `KeyboardInterrupt`, the others say so. Shapes: samples (n, d).
    """
    values, reasons = np.full(len(samples), np.nan), [INTERRUPTED] * len(samples)
    missing = 0
    try:
        for row, sample in enumerate(samples.tolist()):
            report(row, missing)
            try:
                values[row] = point.moved_to(dict(zip(point.names, sample, strict=True))).value
                reasons[row] = ""
            except NoSolutionError as error:
                reasons[row], missing = str(error), missing + 1
    except KeyboardInterrupt:
        pass
    return values, np.array(reasons, dtype=np.str_)
