"""Correlations of scattered parameters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from slipfold.arrays import Array
from slipfold.errors import InputError
from slipfold.models.quantity import parse_quantity
from slipfold.models.suggestion import unknown

SINGULAR = 1e-10
"""Eigenvalue of a correlation matrix that is zero: some parameters then determine another."""


def parse_correlation(given: Any, names: Sequence[str]) -> Array:
    """Return a correlation matrix from pairs of parameters, or checked if it is one.

    Shapes: returns (d, d).

    >>> parse_correlation({"mu,Vd": 0.5}, ["mu", "Vd"]).tolist()
    [[1.0, 0.5], [0.5, 1.0]]
    """
    matrix = np.eye(len(names))
    if isinstance(given, Mapping):
        seen = set()
        for key, value in given.items():
            one, other = _pair(key, names)
            if frozenset((one, other)) in seen:
                raise InputError(
                    f"the correlation of {names[one]} and {names[other]} is given twice"
                )
            seen.add(frozenset((one, other)))
            number = parse_quantity(
                value, "", f"the correlation of {names[one]} and {names[other]}"
            )
            matrix[one, other] = matrix[other, one] = number
    elif given is not None:
        try:
            matrix = np.array(given, dtype=float)
        except (TypeError, ValueError):
            raise InputError(
                f'correlation = {given!r} cannot be used; give pairs, e.g. {{"mu,Vd": 0.5}}'
            ) from None
    return _checked(matrix, names)


def _pair(key: Any, names: Sequence[str]) -> tuple[int, int]:
    pair = [part.strip() for part in key.split(",")] if isinstance(key, str) else list(key)
    if len(pair) != 2 or pair[0] == pair[1]:
        raise InputError(
            f"correlation {key!r} does not name two different parameters; give e.g. mu,Vd=0.5"
        )
    for name in pair:
        if name not in names:
            raise unknown("no parameter that scatters is named", name, names)
    return list(names).index(pair[0]), list(names).index(pair[1])


def _checked(matrix: Array, names: Sequence[str]) -> Array:
    count = len(names)
    regular = matrix.shape == (count, count) and np.isfinite(matrix).all()
    if not (regular and np.array_equal(matrix, matrix.T) and (np.diag(matrix) == 1).all()):
        raise InputError(
            f"the correlation matrix of {', '.join(names)} is not {count} by {count}, finite and "
            "symmetric with ones on its diagonal; give one that is, or pairs of names"
        )
    least = float(np.linalg.eigvalsh(matrix)[0])
    if least < SINGULAR:
        # Between the unit matrix and this one eigenvalues go linearly.
        factor = np.floor(100 * (1 - SINGULAR) / (1 - least) - 1e-9) / 100
        raise InputError(
            f"the correlations of {', '.join(names)} contradict each other: the smallest "
            f"eigenvalue of their matrix is {least:.3g}, but it must be positive; make them "
            f"smaller, e.g. {factor:.2g} times what they are"
        )
    return matrix


def correlated(shares: Array, matrix: Array) -> Array:
    """Return shares whose normal scores have correlations. Shapes: shares (n, d), matrix (d, d)."""
    if np.array_equal(matrix, np.eye(len(matrix))):
        return shares
    from scipy.special import ndtr, ndtri

    scores = ndtri(np.clip(shares, 2.0**-53, 1 - 2.0**-53))
    return np.asarray(ndtr(scores @ np.linalg.cholesky(matrix).T))
