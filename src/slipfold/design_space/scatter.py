"""How a parameter scatters about its value."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from slipfold.arrays import Array

SAME = 1e-9
"""Difference of a mean from a value, over its size, that is rounding."""

LEAST = 2.0**-53
"""Share nearest to none: quasi-random points may hold 0, where quantiles are infinite."""


@dataclass(frozen=True)
class Scatter:
    """How a parameter scatters about its value; frozen.

    Parameters
    ----------
    name
        The parameter.
    kind
        ``"normal"``, ``"uniform"`` or ``"lognormal"``.
    mean
        Its value in the middle; the median if lognormal.
    size
        Standard deviation if normal, half the width if uniform, in the unit of the parameter;
        standard deviation of the natural logarithm if lognormal.
    low, high
        Ends at which a normal distribution is cut off, in the unit of the parameter.
    """

    name: str
    kind: str
    mean: float
    size: float
    low: float = -math.inf
    high: float = math.inf

    @property
    def deviation(self) -> float:
        """Standard deviation."""
        if self.kind == "uniform":
            return self.size / math.sqrt(3)
        if self.kind == "lognormal":
            spread = math.expm1(self.size**2)
            return self.mean * math.sqrt(spread * (1 + spread))
        if not self._is_cut:
            return self.size
        from scipy.stats import truncnorm

        return float(truncnorm.std(*self._ends, self.mean, self.size))

    def quantile(self, share: Array) -> Array:
        """Return the values that a share of all lies below.

        Parameters
        ----------
        share
            Shares between 0 and 1, shape (n,).

        Returns
        -------
        ndarray
            Values in the unit of the parameter, shape (n,).

        Examples
        --------
        >>> float(Scatter("mu", "uniform", 0.5, 0.1).quantile(np.array([0.25]))[0])
        0.45
        """
        from scipy.stats import norm, truncnorm, uniform

        share = np.clip(share, LEAST, 1 - LEAST)
        if self.kind == "uniform":
            return np.asarray(uniform.ppf(share, self.mean - self.size, 2 * self.size))
        if self.kind == "lognormal":
            return np.asarray(self.mean * np.exp(self.size * norm.ppf(share)))
        if not self._is_cut:
            return np.asarray(norm.ppf(share, self.mean, self.size))
        return np.asarray(truncnorm.ppf(share, *self._ends, self.mean, self.size))

    def record(self) -> dict[str, Any]:
        """Return it as the table from which it can be read again.

        Returns
        -------
        dict
            Plain data, numbers in SI units.
        """
        if self.kind == "uniform":
            ends = {"from": self.mean - self.size, "to": self.mean + self.size}
            return {"distribution": self.kind, **ends}
        middle = "median" if self.kind == "lognormal" else "mean"
        cut = {"from": self.low, "to": self.high}
        return {
            "distribution": self.kind,
            middle: self.mean,
            "deviation": self.size,
            **{key: end for key, end in cut.items() if math.isfinite(end)},
        }

    @property
    def _is_cut(self) -> bool:
        return math.isfinite(self.low) or math.isfinite(self.high)

    @property
    def _ends(self) -> tuple[float, float]:
        """Where it is cut off, in deviations from the mean."""
        return (self.low - self.mean) / self.size, (self.high - self.mean) / self.size


def scatter_text(scatter: Scatter, base: float) -> str:
    """Return kind and size, and where it is if it is not about `base` or is cut off.

    >>> scatter_text(Scatter("mu", "normal", 0.5, 0.02, 0.4), 0.5)
    'normal 0.02 from 0.4'
    """
    said = f"{scatter.kind} {scatter.size:.4g}"
    ends = {"from": scatter.low, "to": scatter.high}
    if not math.isclose(scatter.mean, base, rel_tol=1e-9, abs_tol=1e-9 * scatter.size):
        if scatter.kind == "uniform":
            said = scatter.kind
            ends = {"from": scatter.mean - scatter.size, "to": scatter.mean + scatter.size}
        else:
            said += f" about {scatter.mean:.4g}"
    cut = [f" {key} {end:.4g}" for key, end in ends.items() if math.isfinite(end)]
    return "".join([said, *cut])


def scattered_away(scatters: Iterable[Scatter], values: Mapping[str, float]) -> list[str]:
    """Say which parameters do not scatter about their own values.

    >>> scattered_away([Scatter("mu", "uniform", 0.55, 0.05)], {"mu": 0.5})
    ['mu = 0.5 and not about 0.55']
    """
    return [
        f"{item.name} = {values[item.name]:.6g} and not about {item.mean:.6g}"
        for item in scatters
        if abs(item.mean - values[item.name]) > SAME * max(abs(item.mean), item.size)
    ]
