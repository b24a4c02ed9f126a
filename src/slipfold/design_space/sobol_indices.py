"""Which scatter matters: indices of Sobol, by SALib."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from slipfold.arrays import Array
from slipfold.design_space.drawn import quantiles
from slipfold.design_space.scatter import Scatter
from slipfold.errors import InputError

CONFIDENCE = 0.95

FEWEST = 4
"""Points at least: errors are spreads over points drawn again from them, in 35 ways from 4, but in
10 from 3, and 95 % of less than 20 cannot be told."""

SALTELLI = "saltelli"
"""What samples are called from which indices are told."""


@dataclass(frozen=True, eq=False)
class SobolIndices:
    """Shares of a variance that scattered parameters account for; frozen.

    Parameters
    ----------
    names
        The parameters.
    first
        Share that each accounts for by itself, shape (d,).
    total
        Share that it takes part in, together with others as well, shape (d,).
    first_error, total_error
        Half the widths of their intervals of 95 % confidence, shape (d,).
    """

    names: tuple[str, ...]
    first: Array
    total: Array
    first_error: Array
    total_error: Array


def index_design(
    scatters: Sequence[Scatter], count: int, seed: int, asked: str = "samples"
) -> Array:
    """Return where to evaluate a function for its indices, shape (count (d + 2), d).

    `asked` is what the count is called where it was given.
    """
    if count < FEWEST:
        raise InputError(
            f"{asked} = {count} is too few to tell errors of indices; give at least {FEWEST}"
        )
    sample, _ = _salib()
    shares = sample.sample(_problem(names_of(scatters)), count, calc_second_order=False, seed=seed)
    return quantiles(scatters, shares)


def indices_of(values: Array, names: Sequence[str], seed: int) -> SobolIndices:
    """Return the indices from the values of a function there. Shapes: values (count (d + 2),)."""
    _, analyze = _salib()
    found = analyze.analyze(
        _problem(names),
        values,
        calc_second_order=False,
        conf_level=CONFIDENCE,
        seed=seed + 1,  # SALib takes 0 for none
    )
    keys = ("S1", "ST", "S1_conf", "ST_conf")
    return SobolIndices(tuple(names), *(np.asarray(found[key], dtype=float) for key in keys))


def names_of(scatters: Sequence[Scatter]) -> tuple[str, ...]:
    """Return which parameters scatter."""
    return tuple(item.name for item in scatters)


def _problem(names: Sequence[str]) -> dict[str, Any]:
    """Say to SALib that shares are uniform: their quantiles are taken here."""
    return {"num_vars": len(names), "names": [*names], "bounds": [[0.0, 1.0]] * len(names)}


def _salib() -> tuple[Any, Any]:
    try:
        from SALib.analyze import sobol as analyze
        from SALib.sample import sobol as sample
    except ImportError:
        raise InputError(
            "Sobol indices need SALib, which is not installed; pip install slipfold[sensitivity]"
        ) from None
    return sample, analyze
