"""Distributions of parameters, their correlations, and how users write them."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, TypeAdapter

from slipfold.arrays import Array
from slipfold.errors import InputError, unknown
from slipfold.models.definitions.tables import validated
from slipfold.models.quantities import Parameter
from slipfold.models.units import parse_quantity

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
            raise unknown("no uncertain parameter is named", name, names)
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


def correlated(fractions: Array, matrix: Array) -> Array:
    """Return fractions with correlated normal scores. Shapes: fractions (n, d), matrix (d, d)."""
    if np.array_equal(matrix, np.eye(len(matrix))):
        return fractions
    from scipy.special import ndtr, ndtri

    scores = ndtri(np.clip(fractions, SMALLEST, 1 - SMALLEST))
    return np.asarray(ndtr(scores @ np.linalg.cholesky(matrix).T))


SAME = 1e-9
"""Relative difference of a mean from a value that counts as rounding."""

SMALLEST = 2.0**-53
"""Smallest fraction: quasi-random points may hold 0, where quantiles are infinite."""


@dataclass(frozen=True)
class Distribution:
    """The distribution of a parameter about its value; frozen.

    Parameters
    ----------
    name
        The parameter.
    kind
        ``"normal"``, ``"uniform"`` or ``"lognormal"``.
    mean
        Its mean; the median if lognormal.
    size
        Standard deviation if normal, half the width if uniform, in the unit of the parameter;
        standard deviation of the natural logarithm if lognormal.
    low, high
        Ends at which a normal distribution is truncated, in the unit of the parameter.
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
        if not self._is_truncated:
            return self.size
        from scipy.stats import truncnorm

        return float(truncnorm.std(*self._ends, self.mean, self.size))

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
        from scipy.stats import norm, truncnorm, uniform

        fraction = np.clip(fraction, SMALLEST, 1 - SMALLEST)
        if self.kind == "uniform":
            return np.asarray(uniform.ppf(fraction, self.mean - self.size, 2 * self.size))
        if self.kind == "lognormal":
            return np.asarray(self.mean * np.exp(self.size * norm.ppf(fraction)))
        if not self._is_truncated:
            return np.asarray(norm.ppf(fraction, self.mean, self.size))
        return np.asarray(truncnorm.ppf(fraction, *self._ends, self.mean, self.size))

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
    def _is_truncated(self) -> bool:
        return math.isfinite(self.low) or math.isfinite(self.high)

    @property
    def _ends(self) -> tuple[float, float]:
        """Ends at which it is truncated, in deviations from the mean."""
        return (self.low - self.mean) / self.size, (self.high - self.mean) / self.size


def distribution_text(distribution: Distribution, base: float) -> str:
    """Return kind and size, the mean if it is not `base`, and the ends if it is truncated.

    >>> distribution_text(Distribution("mu", "normal", 0.5, 0.02, 0.4), 0.5)
    'normal 0.02 from 0.4'
    """
    said = f"{distribution.kind} {distribution.size:.4g}"
    ends = {"from": distribution.low, "to": distribution.high}
    if not math.isclose(distribution.mean, base, rel_tol=1e-9, abs_tol=1e-9 * distribution.size):
        if distribution.kind == "uniform":
            said = distribution.kind
            ends = {
                "from": distribution.mean - distribution.size,
                "to": distribution.mean + distribution.size,
            }
        else:
            said += f" about {distribution.mean:.4g}"
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
        if abs(item.mean - values[item.name]) > SAME * max(abs(item.mean), item.size)
    ]


Number = float | str
"""A number in the SI unit of the parameter, or text with a unit or in percent of a value."""

Fraction = Annotated[float, Field(allow_inf_nan=False)]

WIDEST = 5.0
"""Largest deviation of a logarithm; larger ones are percents without their sign."""

WIDE = 1.0
"""Deviation of a logarithm from which a text probably lacks a percent sign."""

MOST_PERCENT = 100.0
"""Maximum number of percents that may have been meant."""

WRITTEN = re.compile(r"\s*(normal|uniform|lognormal)(?:\s+|\s*:)(.*?)\s*")


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

    def of(self, parameter: Parameter, base: float) -> Distribution:
        """Return the distribution; the default mean is the value of the base case."""
        mean = base if self.mean is None else _number(self.mean, parameter, base)
        size = _size(parameter, mean, self.deviation, self.relative, "its deviation")
        low, high = _ends(self.low, self.high, parameter, base)
        if not low < high:
            raise InputError(
                f"{parameter.name} is cut off at {low:g} and {high:g}; give from below to"
            )
        if not low <= mean <= high:
            side, end = ("below", low) if mean < low else ("above", high)
            raise InputError(
                f"the distribution of {parameter.name} is cut off {side} {end:g}, which leaves out "
                f"its mean {mean:g}; give ends with the mean between them, or another mean"
            )
        return Distribution(parameter.name, "normal", mean, size, low, high)


class _Uniform(_Symmetric):
    """The uniform distribution."""

    distribution: Literal["uniform"]
    half_width: Number | None = None

    def of(self, parameter: Parameter, base: float) -> Distribution:
        """Return the distribution between its ends or about a mean."""
        if self.low is None and self.high is None:
            mean = base if self.mean is None else _number(self.mean, parameter, base)
            size = _size(parameter, mean, self.half_width, self.relative, "from and to, half_width")
            return Distribution(parameter.name, "uniform", mean, size)
        if self.low is None or self.high is None:
            raise InputError(
                f"the distribution of {parameter.name} has one end, the other is missing; give "
                "from and to"
            )
        if (self.mean, self.half_width, self.relative) != (None, None, None):
            raise InputError(
                f"the distribution of {parameter.name} has ends, from and to; leave out mean, "
                "half_width and relative"
            )
        low, high = _ends(self.low, self.high, parameter, base)
        if not low < high:
            raise InputError(
                f"{parameter.name} is uncertain from {low:g} to {high:g}; give from below to"
            )
        if _is_percent(self.low) and not low <= base <= high:
            raise InputError(
                f"{parameter.name} is uncertain from {low:g} to {high:g}, since percent are of "
                f"{parameter.name} = {base:g}; give ends on both sides of 100%, or without percent"
            )
        return Distribution(parameter.name, "uniform", (low + high) / 2, (high - low) / 2)


class _Lognormal(_Table):
    """The logarithm is normal, so that all values are positive."""

    distribution: Literal["lognormal"]
    median: Number | None = None
    deviation: Fraction
    """Of the natural logarithm: 0.05 are five percent or so."""

    def of(self, parameter: Parameter, base: float) -> Distribution:
        """Return the distribution."""
        median = base if self.median is None else _number(self.median, parameter, base)
        if not median > 0:
            raise InputError(
                f"{parameter.name} has the median {median:g}, but a lognormal distribution has a "
                "positive one; give another median or distribution"
            )
        if self.deviation > WIDEST:
            raise InputError(
                f"the distribution of {parameter.name} has the deviation {self.deviation:g} of its "
                f"logarithm, but {WIDEST:g} is the most; give e.g. 5%"
            )
        size = _positive(parameter, median, self.deviation)
        return Distribution(parameter.name, "lognormal", median, size)


_TABLE: TypeAdapter[_Uniform | _Normal | _Lognormal] = TypeAdapter(
    Annotated[_Uniform | _Normal | _Lognormal, Field(discriminator="distribution")]
)


def parse_distribution(
    given: str | Mapping[str, Any], parameter: Parameter, base: float, place: str = ""
) -> Distribution:
    """Read the distribution of a parameter about its value in the base case.

    A text abbreviates a table: ``"normal 5%"`` of the value, ``"normal 0.02:0.4:0.6"`` truncated at
    ends, ``"uniform 2deg"`` to either side, ``"uniform 0.4:0.6"``, ``"lognormal 2%"``. Ends in
    percent are of the value, too: ``"uniform 95%:105%"``. `place` is its name in errors, if
    not the distribution of the parameter.
    """
    place = place or f"the distribution of {parameter.name}"
    table = _table_of(given, parameter) if isinstance(given, str) else given
    read: Any = validated(_TABLE.validate_python, table, place, "distribution")
    found: Distribution = read.of(parameter, base)
    return found


def _table_of(text: str, parameter: Parameter) -> dict[str, Any]:
    match = WRITTEN.fullmatch(text)
    kind, rest = match.groups() if match else ("", "")
    size, *ends = (part.strip() for part in rest.split(":"))
    if kind == "uniform" and len(ends) == 1 and (size or ends[0]):
        return {"distribution": kind, "from": size or None, "to": ends[0] or None}
    if not size or len(ends) != (2 if kind == "normal" and ends else 0):
        raise InputError(
            f"the distribution of {parameter.name}, {text!r}, is not known; give normal or uniform "
            'and a size, in percent of the value or with a unit, e.g. "normal 5%", "uniform 2deg", '
            '"uniform FROM:TO", "normal 5%:FROM:TO" or "lognormal 5%"'
        )
    name = f"the distribution of {parameter.name}"
    if kind == "lognormal":
        deviation = parse_quantity(size, "", name)
        if not size.endswith("%") and WIDE <= deviation <= MOST_PERCENT:
            raise InputError(
                f"{name}, {text!r}, is a factor of {math.exp(deviation):.3g} to either side; was "
                f"{size}% meant? Give that, or a table with deviation = {size}"
            )
        return {"distribution": kind, "deviation": deviation}
    cut = {key: end for key, end in zip(("from", "to"), ends, strict=False) if end}
    if size.endswith("%"):
        return {"distribution": kind, "relative": parse_quantity(size, "", name), **cut}
    key = "deviation" if kind == "normal" else "half_width"
    return {"distribution": kind, key: parse_quantity(size, parameter.unit, name), **cut}


def _is_percent(given: Number | None) -> bool:
    return isinstance(given, str) and given.rstrip().endswith("%")


def _number(given: Number, parameter: Parameter, whole: float) -> float:
    """Return a number in the SI unit of the parameter; percent are of `whole`."""
    if _is_percent(given):
        found = parse_quantity(given, "", parameter.name) * whole
    else:
        found = parse_quantity(given, parameter.unit, parameter.name)
    if not math.isfinite(found):
        raise InputError(f"{parameter.name} = {given!r} is not a finite number; give one")
    return found


def _ends(
    low: Number | None, high: Number | None, parameter: Parameter, base: float
) -> tuple[float, float]:
    """Return two ends, infinite where none is given; percent are of the value `base`."""
    if None not in (low, high) and _is_percent(low) != _is_percent(high):
        raise InputError(
            f"the distribution of {parameter.name} has the ends {low} and {high}, of which one is "
            "in percent of its value; give both in percent, or neither"
        )
    return (
        -math.inf if low is None else _number(low, parameter, base),
        math.inf if high is None else _number(high, parameter, base),
    )


def _size(
    parameter: Parameter, mean: float, size: Number | None, relative: float | None, key: str
) -> float:
    """Return its width, which is given in one of two ways."""
    if (size is None) == (relative is None):
        raise InputError(
            f"the distribution of {parameter.name} needs either {key}, in "
            f"{parameter.unit or 'its own unit'}, or relative, a fraction of its mean"
        )
    wide = (
        abs(mean) * relative if relative is not None else _number(size or 0, parameter, abs(mean))
    )
    return _positive(parameter, mean, wide)


def _positive(parameter: Parameter, mean: float, size: float) -> float:
    if size > 0 and math.isfinite(size):
        return size
    raise InputError(
        f"the distribution of {parameter.name} has the size {size:g} about {parameter.name} = "
        f"{mean:g}; give more"
        if not size > 0
        else f"the distribution of {parameter.name} has no finite size; give less"
    )
