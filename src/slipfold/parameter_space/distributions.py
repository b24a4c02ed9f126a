"""Distributions of parameters, their correlations, and how users write them."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, TypeAdapter

from slipfold.arrays import Array, as_numbers
from slipfold.errors import InputError, unknown
from slipfold.models.definitions.tables import validated
from slipfold.models.quantities import Parameter
from slipfold.models.units import parse_quantity
from slipfold.read_only import Documented

SINGULAR = 1e-10
"""Eigenvalue of a correlation matrix that counts as zero: then parameters determine each other."""


def parse_correlation(given: Any, names: Sequence[str]) -> Array:
    """Return a correlation matrix from pairs of parameters, or check a given one.

    Shapes: returns (d, d).

    >>> parse_correlation({"mu,Vd": 0.5}, ["mu", "Vd"]).tolist()
    [[1.0, 0.5], [0.5, 1.0]]
    """
    matrix = np.eye(len(names))
    if isinstance(given, Mapping):
        seen = set()
        for key, value in given.items():
            one, other = _pair(key, names)
            said = f"the correlation of {names[one]} and {names[other]}"
            if frozenset((one, other)) in seen:
                raise InputError(f"{said} is given twice")
            seen.add(frozenset((one, other)))
            matrix[one, other] = matrix[other, one] = parse_quantity(value, "", said)
    elif given is not None:
        matrix = as_numbers(given)
    return _checked(matrix, names)


def _pair(key: Any, names: Sequence[str]) -> tuple[int, int]:
    pair = [part.strip() for part in key.split(",")] if isinstance(key, str) else list(key)
    if len(pair) != 2 or pair[0] == pair[1]:
        raise InputError(
            f"correlation {key!r} does not name two different parameters; give e.g. mu,Vd=0.5"
        )
    for name in pair:
        if name not in names:
            raise unknown("no uncertain parameter is named", name, names)
    return list(names).index(pair[0]), list(names).index(pair[1])


def _checked(matrix: Array, names: Sequence[str]) -> Array:
    count = len(names)
    regular = matrix.shape == (count, count) and np.isfinite(matrix).all()
    if not (regular and np.array_equal(matrix, matrix.T) and (np.diag(matrix) == 1).all()):
        raise InputError(
            f"the correlation matrix of {', '.join(names)} is not {count} by {count}, finite and "
            "symmetric with ones on its diagonal; give one that is, or pairs, e.g. "
            '{"mu,Vd": 0.5}'
        )
    smallest = float(np.linalg.eigvalsh(matrix)[0])
    if smallest < SINGULAR:
        # Between the unit matrix and this one eigenvalues go linearly.
        factor = np.floor(100 * (1 - SINGULAR) / (1 - smallest) - 1e-9) / 100
        raise InputError(
            f"the correlations of {', '.join(names)} contradict each other: the smallest "
            f"eigenvalue of their matrix is {smallest:.3g}, but it must be positive; make them "
            f"smaller, e.g. {factor:.2g} times what they are"
        )
    return matrix


def correlated(fractions: Array, matrix: Array) -> Array:
    """Return fractions with correlated normal scores. Shapes: fractions (n, d), matrix (d, d)."""
    if np.array_equal(matrix, np.eye(len(matrix))):
        return fractions
    from scipy.special import ndtr, ndtri

    scores = ndtri(_inside(fractions))
    return np.asarray(ndtr(scores @ np.linalg.cholesky(matrix).T))


def _inside(fractions: Array) -> Array:
    """Return fractions above 0 and below 1, where quantiles are infinite."""
    smallest = np.finfo(float).eps / 2
    return np.clip(fractions, smallest, 1 - smallest)


@dataclass(frozen=True)
class Distribution(Documented):
    """The distribution of a parameter about its value; frozen."""

    name: Annotated[str, "The parameter."]
    kind: Annotated[str, '``"normal"``, ``"uniform"`` or ``"lognormal"``.']
    mean: Annotated[float, "Its mean; the median if lognormal."]
    size: Annotated[
        float,
        "Standard deviation if normal, half the width if uniform, in the unit of the parameter; "
        "standard deviation of the natural logarithm if lognormal.",
    ]
    low: Annotated[
        float, "Ends at which a normal distribution is truncated, in the unit of the parameter."
    ] = -math.inf
    high: Annotated[float, ""] = math.inf

    @cached_property
    def _law(self) -> Any:
        """The distribution as SciPy has it."""
        from scipy import stats

        if self.kind == "uniform":
            return stats.uniform(self.mean - self.size, 2 * self.size)
        if self.kind == "lognormal":
            return stats.lognorm(self.size, scale=self.mean)
        if not (math.isfinite(self.low) or math.isfinite(self.high)):
            return stats.norm(self.mean, self.size)
        ends = (self.low - self.mean) / self.size, (self.high - self.mean) / self.size
        return stats.truncnorm(*ends, self.mean, self.size)

    @property
    def deviation(self) -> float:
        """Standard deviation."""
        return float(self._law.std())

    def quantile(self, fraction: Array) -> Array:
        """Return the quantiles of fractions.

        Parameters
        ----------
        fraction
            Fractions between 0 and 1, shape (n,).

        Returns
        -------
        ndarray
            Values in the unit of the parameter, shape (n,).

        Examples
        --------
        >>> float(Distribution("mu", "uniform", 0.5, 0.1).quantile(np.array([0.25]))[0])
        0.45
        """
        return np.asarray(self._law.ppf(_inside(fraction)))

    def record(self) -> dict[str, Any]:
        """Return it as the table from which it can be read again."""
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


def distribution_text(distribution: Distribution, base: float) -> str:
    """Return kind and size, the mean if it is not `base`, and the ends if it is truncated.

    >>> distribution_text(Distribution("mu", "normal", 0.5, 0.02, 0.4), 0.5)
    'normal 0.02 from 0.4'
    """
    kind, mean, size = distribution.kind, distribution.mean, distribution.size
    said = f"{kind} {size:.4g}"
    ends = {"from": distribution.low, "to": distribution.high}
    if _has_other_mean(distribution, base):
        said = kind if kind == "uniform" else f"{said} about {mean:.4g}"
        ends = {"from": mean - size, "to": mean + size} if kind == "uniform" else ends
    cut = [f" {key} {end:.4g}" for key, end in ends.items() if math.isfinite(end)]
    return "".join([said, *cut])


def other_means(distributions: Iterable[Distribution], values: Mapping[str, float]) -> list[str]:
    """Say which parameters have other means than their own values.

    >>> other_means([Distribution("mu", "uniform", 0.55, 0.05)], {"mu": 0.5})
    ['mu = 0.5 and not about 0.55']
    """
    return [
        f"{item.name} = {values[item.name]:.6g} and not about {item.mean:.6g}"
        for item in distributions
        if _has_other_mean(item, values[item.name])
    ]


def _has_other_mean(distribution: Distribution, base: float) -> bool:
    """Whether the mean differs from a value by more than rounding."""
    largest = max(abs(distribution.mean), distribution.size)
    return abs(distribution.mean - base) > 1e-9 * largest


# -- how users write them --------------------------------------------------------------------------

Number = float | str
"""A number in the SI unit of the parameter, or text with a unit or in percent of a value."""

Fraction = Annotated[float, Field(allow_inf_nan=False)]

WIDEST = 1.0
"""Largest deviation of a logarithm, a factor of e: larger ones are percents without their sign."""


class _Table(BaseModel):
    """A distribution as users write it."""

    model_config = ConfigDict(extra="forbid")


class _Symmetric(_Table):
    """A distribution about a mean, or between ends."""

    mean: Number | None = None
    relative: Fraction | None = None
    low: Number | None = Field(None, alias="from")
    high: Number | None = Field(None, alias="to")


class _Normal(_Symmetric):
    """The normal distribution, truncated at ends if any are given."""

    distribution: Literal["normal"]
    deviation: Number | None = None


class _Uniform(_Symmetric):
    """The uniform distribution."""

    distribution: Literal["uniform"]
    half_width: Number | None = None


class _Lognormal(_Table):
    """The logarithm is normal, so that all values are positive."""

    distribution: Literal["lognormal"]
    median: Number | None = None
    deviation: Fraction
    """Of the natural logarithm: 0.05 are five percent or so."""


_TABLE: TypeAdapter[_Uniform | _Normal | _Lognormal] = TypeAdapter(
    Annotated[_Uniform | _Normal | _Lognormal, Field(discriminator="distribution")]
)

WRITTEN = re.compile(r"\s*(normal|uniform|lognormal)(?:\s+|\s*:)(.*?)\s*")


def parse_distribution(
    given: str | Mapping[str, Any], parameter: Parameter, base: float, place: str = ""
) -> Distribution:
    """Read the distribution of a parameter about its value in the base case.

    A text abbreviates a table: ``"normal 5%"`` of the value, ``"normal 0.02:0.4:0.6"`` truncated at
    ends, ``"uniform 2deg"`` to either side, ``"uniform 0.4:0.6"``, ``"lognormal 2%"``. Ends in
    percent are of the value, too: ``"uniform 95%:105%"``. `place` is its name in errors, if
    not the distribution of the parameter.
    """
    reader = _Reader(parameter, base)
    table = reader.table(given) if isinstance(given, str) else given
    read = validated(_TABLE.validate_python, table, place or reader.label, "distribution")
    if isinstance(read, _Lognormal):
        return reader.lognormal(read)
    return reader.normal(read) if isinstance(read, _Normal) else reader.uniform(read)


class _Reader:
    """Reads the distribution of a parameter about its value in the base case."""

    def __init__(self, parameter: Parameter, base: float) -> None:
        self.parameter, self.name, self.base = parameter, parameter.name, base
        self.label = f"the distribution of {parameter.name}"

    def table(self, text: str) -> dict[str, Any]:
        """Return the table that a text abbreviates."""
        match = WRITTEN.fullmatch(text)
        kind, rest = match.groups() if match else ("", "")
        size, *ends = (part.strip() for part in rest.split(":"))
        if kind == "uniform" and len(ends) == 1 and (size or ends[0]):
            return {"distribution": kind, "from": size or None, "to": ends[0] or None}
        if not size or len(ends) != (2 if kind == "normal" and ends else 0):
            raise InputError(
                f"{self.label}, {text!r}, is not known; give normal or uniform and a size, in "
                'percent of the value or with a unit, e.g. "normal 5%", "uniform 2deg", '
                '"uniform FROM:TO", "normal 5%:FROM:TO" or "lognormal 5%"'
            )
        cut = {key: end for key, end in zip(("from", "to"), ends, strict=False) if end}
        if kind == "lognormal":
            return {"distribution": kind, "deviation": parse_quantity(size, "", self.label)}
        if size.endswith("%"):
            relative = parse_quantity(size, "", self.label)
            return {"distribution": kind, "relative": relative, **cut}
        key = "deviation" if kind == "normal" else "half_width"
        number = parse_quantity(size, self.parameter.unit, self.label)
        return {"distribution": kind, key: number, **cut}

    def normal(self, given: _Normal) -> Distribution:
        """Return a normal distribution; its mean is the base case's if none is given."""
        mean = self._number(given.mean, self.base, self.base)
        size = self._size(mean, given.deviation, given.relative, "its deviation")
        low, high = self._ends(given)
        if not low <= mean <= high:
            side, end = ("below", low) if mean < low else ("above", high)
            raise InputError(
                f"{self.label} is cut off {side} {end:g}, which leaves out its mean {mean:g}; give "
                "ends with the mean between them, or another mean"
            )
        return Distribution(self.name, "normal", mean, size, low, high)

    def uniform(self, given: _Uniform) -> Distribution:
        """Return a uniform distribution between its ends or about a mean."""
        if given.low is None and given.high is None:
            mean = self._number(given.mean, self.base, self.base)
            size = self._size(mean, given.half_width, given.relative, "from and to, half_width")
            return Distribution(self.name, "uniform", mean, size)
        if given.low is None or given.high is None:
            raise InputError(f"{self.label} has one end, the other is missing; give from and to")
        if (given.mean, given.half_width, given.relative) != (None, None, None):
            raise InputError(
                f"{self.label} has ends, from and to; leave out mean, half_width and relative"
            )
        low, high = self._ends(given)
        if _is_percent(given.low) and not low <= self.base <= high:
            raise InputError(
                f"{self.label} goes from {low:g} to {high:g}, since percent are of {self.name} = "
                f"{self.base:g}; give ends on both sides of 100%, or without percent"
            )
        return Distribution(self.name, "uniform", (low + high) / 2, (high - low) / 2)

    def lognormal(self, given: _Lognormal) -> Distribution:
        """Return a lognormal distribution about a median."""
        median = self._number(given.median, self.base, self.base)
        if not median > 0:
            raise InputError(
                f"{self.name} has the median {median:g}, but a lognormal distribution has a "
                "positive one; give another median or distribution"
            )
        if given.deviation > WIDEST:
            raise InputError(
                f"{self.label} has the deviation {given.deviation:g} of its logarithm, more than "
                f"{WIDEST:g}, a factor of e to either side; give less, e.g. 5%"
            )
        size = self._positive(median, given.deviation)
        return Distribution(self.name, "lognormal", median, size)

    def _number(self, given: Number | None, whole: float, default: float) -> float:
        """Return a number in the SI unit of the parameter; percent are of `whole`."""
        if given is None:
            return default
        if _is_percent(given):
            number = parse_quantity(given, "", self.name) * whole
        else:
            number = parse_quantity(given, self.parameter.unit, self.name)
        if not math.isfinite(number):
            raise InputError(f"{self.name} = {given!r} is not a finite number; give one")
        return number

    def _ends(self, given: _Symmetric) -> tuple[float, float]:
        """Return two ends, infinite where none is given; percent are of the base case's value."""
        low, high = given.low, given.high
        if None not in (low, high) and _is_percent(low) != _is_percent(high):
            raise InputError(
                f"{self.label} has the ends {low} and {high}, of which one is in percent of its "
                "value; give both in percent, or neither"
            )
        ends = (self._number(low, self.base, -math.inf), self._number(high, self.base, math.inf))
        if not ends[0] < ends[1]:
            raise InputError(
                f"{self.label} goes from {ends[0]:g} to {ends[1]:g}; give from below to"
            )
        return ends

    def _size(self, mean: float, size: Number | None, relative: float | None, key: str) -> float:
        """Return its width, which is given in one of two ways."""
        if (size is None) == (relative is None):
            raise InputError(
                f"{self.label} needs either {key}, in {self.parameter.unit or 'its own unit'}, or "
                "relative, a fraction of its mean"
            )
        wide = abs(mean) * relative if relative is not None else self._number(size, abs(mean), 0.0)
        return self._positive(mean, wide)

    def _positive(self, mean: float, size: float) -> float:
        if size > 0 and math.isfinite(size):
            return size
        if not size > 0:
            raise InputError(
                f"{self.label} has the size {size:g} about {self.name} = {mean:g}; give more"
            )
        raise InputError(f"{self.label} has no finite size; give less")


def _is_percent(given: Number | None) -> bool:
    return isinstance(given, str) and given.rstrip().endswith("%")
