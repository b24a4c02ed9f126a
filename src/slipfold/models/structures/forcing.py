"""Periodic forces on a structure: harmonic, of several harmonics, of samples, by a moving base."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Self

import numpy as np

from slipfold.arrays import as_numbers
from slipfold.errors import InputError
from slipfold.models.friction.law import cos, sin
from slipfold.models.parametric import described, structural
from slipfold.models.quantities import Expression, Parameter, Symbols
from slipfold.models.structures.component import (
    MAX_HARMONIC,
    Component,
    Direction,
    Forces,
    LocalState,
    OneDirection,
    as_direction,
    brief,
    checked_harmonic,
    total,
)
from slipfold.models.units import parse_quantity

_PHASE = Parameter("phi", 0.0, "rad", "phase by which a forcing leads", symbol=r"$\varphi$")


_PERIODS = "number of periods in a forcing period, a whole number"


class PeriodicForce(Component):
    """A Fourier series of the phase.

    A subclass gives the terms as `coefficients`: ``cos0 cos1 sin1 ...`` in N.
    """

    amplitude: ClassVar[str] = "F"
    """Name of the parameter that switches it off."""

    @property
    def _amplitudes(self) -> tuple[str, ...]:
        return (self.amplitude,)

    def _forces(self, local: LocalState) -> Forces:
        """Return the sum of the series."""
        terms = []
        for key, value in local.c.items():
            function = cos if key.startswith("cos") else sin
            angle = 2 * math.pi * int(key[3:]) * local.phase
            terms.append(value if key == "cos0" else value * function(angle))
        return (total(terms),)


def _leading(h: int, size: Expression, phi: Expression) -> dict[str, Expression]:
    """Return the terms of ``size cos(2 pi h f t + phi)``."""
    return {f"cos{h}": size * cos(phi), f"sin{h}": -(size * sin(phi))}


@dataclass(frozen=True)
class HarmonicForce(PeriodicForce, OneDirection):
    r"""A harmonic force :math:`F \cos(2\pi h f t + \varphi)`; the number h is `harmonic`.

    Examples
    --------
    >>> HarmonicForce("tip", F="20 mN").F
    0.02
    """

    title: ClassVar[str] = "harmonic force"

    F: float = described(Parameter("F", 0.0, "N", "amplitude of a force", symbol="$F$"))
    phi: float = described(_PHASE)
    harmonic: int = structural(_PERIODS, 1, checked_harmonic)

    def _coefficients(self, p: Symbols) -> dict[str, Expression]:
        """Parts in phase and out of phase."""
        return _leading(self.harmonic, p["F"], p["phi"])


def _amplitude(h: int) -> Parameter:
    what = f"amplitude of harmonic {h} of a force" if h else "mean of a force"
    return Parameter(f"F{h}", 0.0, "N", what, symbol=f"$F_{{{h}}}$")


def _angle(h: int) -> Parameter:
    return Parameter(f"phi{h}", 0.0, "rad", f"phase by which harmonic {h} of a force leads")


def _checked_harmonics(given: Any, title: str) -> tuple[tuple[int, float, float], ...]:
    """Return harmonic, amplitude and phase of each term."""
    # A force that is made again from its own fields has triples already.
    triples = isinstance(given, tuple) and all(
        isinstance(item, tuple) and len(item) == 3 for item in given
    )
    pairs = {h: (size, phi) for h, size, phi in given} if triples else given
    if not isinstance(pairs, Mapping) or not any(h != 0 for h in pairs):
        raise InputError(
            f"harmonics = {brief(given)} is not a periodic force; give amplitudes by "
            "harmonic, such as {1: 1.0, 3: (0.2, 0.5)}"
        )
    checked = []
    for h, pair in pairs.items():
        number = checked_harmonic(h, title, 0)
        values = pair if isinstance(pair, tuple | list) and len(pair) == 2 else (pair, 0.0)
        size, phi = (
            item.check(parse_quantity(value, item.unit, item.name))
            for item, value in zip((_amplitude(number), _angle(number)), values, strict=True)
        )
        checked.append((number, size, phi))
    return tuple(sorted(checked))


@dataclass(frozen=True)
class MultiHarmonicForce(PeriodicForce, OneDirection):
    r"""A force of several harmonics: :math:`\sum_h F_h \cos(2\pi h f t + \varphi_h)`.

    Examples
    --------
    >>> force = MultiHarmonicForce("tip", {0: 2.0, 1: 1.0, 3: (0.2, 0.5)})
    >>> force.values
    {'F0': 2.0, 'F1': 1.0, 'phi1': 0.0, 'F3': 0.2, 'phi3': 0.5}
    """

    title: ClassVar[str] = "force of several harmonics"

    harmonics: Any = structural(
        "amplitude in N, or amplitude and phase in rad, by harmonic: ``{0: 2.0, 1: 1.0, 3: (0.2, "
        "0.5)}``. They become the parameters ``F0 F1 phi1 F3 phi3``; the mean ``F0`` has no phase",
        read=_checked_harmonics,
    )

    def _pairs(self) -> Iterator[tuple[Parameter, float]]:
        for h, size, phi in self.harmonics:
            yield _amplitude(h), size
            if h:
                yield _angle(h), phi

    @property
    def kind(self) -> Self:
        """The force with all amplitudes zero."""
        return replace(self, harmonics=tuple((h, 0.0, 0.0) for h, _, _ in self.harmonics))

    @property
    def _amplitudes(self) -> tuple[str, ...]:
        return tuple(f"F{h}" for h, _, _ in self.harmonics if h)

    def _coefficients(self, p: Symbols) -> dict[str, Expression]:
        """Parts of each harmonic in phase and out of phase."""
        result: dict[str, Expression] = {}
        for h, _, _ in self.harmonics:
            result |= _leading(h, p[f"F{h}"], p[f"phi{h}"]) if h else {"cos0": p["F0"]}
        return result


@dataclass(frozen=True)
class _MovingBase(PeriodicForce):
    """A base that shakes the structure: displacements are relative to it."""

    inertial: ClassVar[bool] = True

    along: Any = structural(
        "the influence vector r: how each degree of freedom would move with the base if the "
        "structure were rigid, as weights by name; None if all move by the same",
        None,
        as_direction,
    )

    @property
    def _directions(self) -> tuple[Direction | None, ...]:
        return (self.along,)


@dataclass(frozen=True)
class BaseMotion(_MovingBase):
    r"""A base that shakes the structure: :math:`u_b = A \cos(2\pi h f t + \varphi)`.

    Displacements are then relative to the base, and the force is :math:`-M r \ddot u_b`. The
    number h is `harmonic`.

    Examples
    --------
    >>> BaseMotion(A="1mm").A
    0.001
    """

    title: ClassVar[str] = "base motion"
    amplitude: ClassVar[str] = "A"

    A: float = described(Parameter("A", 0.0, "m", "amplitude of the base's motion", symbol="$A$"))
    phi: float = described(_PHASE)
    harmonic: int = structural(_PERIODS, 1, checked_harmonic)

    def _coefficients(self, p: Symbols) -> dict[str, Expression]:
        """Parts of ``A (2 pi h f)^2`` in phase and out of phase; forces are these times masses."""
        rate = 2 * math.pi * self.harmonic * p["f"]
        return _leading(self.harmonic, p["A"] * rate * rate, p["phi"])


@dataclass(frozen=True)
class BaseAcceleration(_MovingBase):
    r"""A base with a given acceleration: :math:`\ddot u_b = a \cos(2\pi h f t + \varphi)`.

    It is that of a shaker that holds the acceleration while the frequency changes. Displacements
    are relative to the base, and the force is :math:`-M r \ddot u_b`. The number h is `harmonic`.

    Examples
    --------
    >>> BaseAcceleration("*:uz", a=9.81).a
    9.81
    """

    title: ClassVar[str] = "base acceleration"
    amplitude: ClassVar[str] = "a"

    a: float = described(
        Parameter("a", 0.0, "m/s^2", "amplitude of the base's acceleration", symbol="$a$")
    )
    phi: float = described(_PHASE)
    harmonic: int = structural(_PERIODS, 1, checked_harmonic)

    def _coefficients(self, p: Symbols) -> dict[str, Expression]:
        """Parts of ``-a`` in phase and out of phase; forces are these times masses."""
        return _leading(self.harmonic, -p["a"], p["phi"])


def _checked_samples(given: Any, title: str) -> tuple[float, ...]:
    samples = as_numbers(given)
    if samples.ndim != 1 or len(samples) < 3 or not np.isfinite(samples).all():
        raise InputError(
            f"the samples of a {title} are not a row of numbers; give at least 3 finite "
            "numbers, equidistant over one period"
        )
    if np.ptp(samples) == 0:
        raise InputError(
            f"the samples of a {title} are all the same, so it does not vary; give one "
            "period of a force that does"
        )
    return tuple(samples.tolist())


@dataclass(frozen=True)
class TabulatedForce(PeriodicForce, OneDirection):
    """A force given by samples over one forcing period, times a factor.

    Between the samples it is their trigonometric interpolant. The factor multiplies the mean, too.

    Examples
    --------
    >>> import numpy as np
    >>> force = TabulatedForce("tip", np.cos(2 * np.pi * np.arange(8) / 8))
    >>> force.residual < 1e-15
    True
    """

    title: ClassVar[str] = "tabulated force"
    amplitude: ClassVar[str] = "factor"

    samples: Any = structural(
        "force in N at equidistant times of one period, without its end, shape (m,)",
        read=_checked_samples,
    )
    factor: float = described(Parameter("factor", 1.0, "", "factor of a tabulated force"))
    harmonics: int | None = structural(
        "highest harmonic that is kept; `residual` says what that leaves out. None keeps all that "
        "the samples have",
        None,
        checked_harmonic,
    )

    def prepare(self) -> None:
        """Refuse harmonics that are too high."""
        highest = max((h for h, _, _ in self.series), default=0)
        if highest > MAX_HARMONIC:
            raise InputError(
                f"the table of {len(self.samples)} samples has harmonics up to {highest}; give "
                f"harmonics, at most {MAX_HARMONIC}, and see in residual what that leaves out"
            )

    @property
    def series(self) -> tuple[tuple[int, float, float], ...]:
        """Harmonic, cosine and sine coefficient in N of all terms that are not zero."""
        count = len(self.samples)
        spectrum = np.fft.rfft(self.samples) / count
        size = np.abs(spectrum).max(initial=0.0)
        terms = []
        for h, value in enumerate(
            spectrum[: None if self.harmonics is None else 1 + self.harmonics]
        ):
            # The mean and, with an even number of samples, the last term stand for themselves.
            factor = 1.0 if h == 0 or 2 * h == count else 2.0
            if abs(value) > 1e-14 * size:  # else it is rounding
                terms.append((h, float(factor * value.real), float(-factor * value.imag)))
        return tuple(terms)

    @property
    def residual(self) -> float:
        """Largest difference between samples and series, over the largest sample."""
        samples = np.array(self.samples)
        angle = 2 * np.pi * np.arange(len(samples)) / len(samples)
        summed = np.zeros(len(samples))
        for h, a, b in self.series:
            summed += a * np.cos(h * angle) + b * np.sin(h * angle)
        return float(np.abs(summed - samples).max() / np.abs(samples).max())

    def _coefficients(self, p: Symbols) -> dict[str, Expression]:
        """Return the Fourier series times the factor."""
        series = [(f"cos{h}", a) for h, a, _ in self.series]
        series += [(f"sin{h}", b) for h, _, b in self.series if h]
        return {key: value * p["factor"] for key, value in series if value}
