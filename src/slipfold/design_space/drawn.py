"""Values of scattered parameters, drawn at random."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from slipfold.arrays import Array
from slipfold.design_space.correlation import correlated
from slipfold.design_space.scatter import Scatter
from slipfold.errors import InputError


def drawn(
    method: str,
    count: int,
    seed: int,
    scatters: Sequence[Scatter],
    asked: str = "samples",
    correlation: Array | None = None,
) -> Array:
    """Return values of each parameter, shape (count, d): the same ones for the same seed.

    `method` is "latin hypercube", "sobol" or "random"; `asked` is what the count is called where
    it was given; `correlation` is that of normal scores, shape (d, d).

    >>> half = Scatter("mu", "uniform", 0.25, 0.25)
    >>> bool(drawn("latin hypercube", 4, 1, [half]).max() < 0.5)
    True
    """
    from scipy.stats import qmc

    size = len(scatters)
    if method == "sobol":
        check_power(count, asked)
        shares = qmc.Sobol(size, seed=seed).random(count)
    elif method == "latin hypercube":
        shares = qmc.LatinHypercube(size, seed=seed).random(count)
    else:
        shares = np.random.default_rng(seed).random((count, size))
    return quantiles(scatters, shares if correlation is None else correlated(shares, correlation))


def check_power(count: int, asked: str) -> None:
    """Refuse a number of points that Sobol's sequence does not spread evenly."""
    if count & (count - 1):
        raise InputError(
            f"{asked} = {count} is not a power of 2, as the numbers of Sobol's samples are; "
            f"give e.g. {1 << count.bit_length()}"
        )


def quantiles(scatters: Sequence[Scatter], shares: Array) -> Array:
    """Return the values that shares of all lie below. Shapes: shares (n, d); returns (n, d)."""
    columns = [item.quantile(shares[:, place]) for place, item in enumerate(scatters)]
    return np.stack(columns, axis=1)
