"""Periodic forces on a structure: harmonic, of several harmonics, of samples, by a moving base."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import NDArray

from slipfold.errors import InputError
from slipfold.models.friction.quantities import described
from slipfold.models.output import Expression, Symbols
from slipfold.models.parameter import Parameter
from slipfold.models.quantity import parse_quantity
from slipfold.models.structures.component import (
    HIGHEST,
    Component,
    Direction,
    Forces,
    Motion,
    OneDirection,
    as_direction,
    checked_harmonic,
    cos_sin,
    shown,
    total,
    wave,
)

_PHASE = Parameter("phi", 0.0, "rad", "phase by which a forcing leads", symbol=r"$\varphi$")


@dataclass(frozen=True)
class HarmonicForce(OneDirection):
    r"""A harmonic force :math:`F \cos(2\pi h f t + \varphi)`.

    Parameters
    ----------
    at
        Degree of freedom, or weights by name.
    F
        Amplitude in N.
    phi
        Phase in rad.
    harmonic
        The whole number h: how often the force repeats in a forcing period.
    name
        Tells forces apart; empty if there is one only.

    Examples
    --------
    >>> HarmonicForce("tip", F="20 mN").F
    0.02
    """

    title: ClassVar[str] = "harmonic force"
    amplitude: ClassVar[str | None] = "F"

    F: float = described(Parameter("F", 0.0, "N", "amplitude of a force", symbol="$F$"))
    phi: float = described(_PHASE)
    harmonic: int = 1

    def prepare(self) -> None:
        """Read the direction and the harmonic."""
        super().prepare()
        object.__setattr__(self, "harmonic", checked_harmonic(self.harmonic, self.title))

    def coefficients(self, p: Symbols) -> dict[str, Expression]:
        """Parts in phase and out of phase."""
        cos, sin = cos_sin(p["phi"])
        return {"cos": p["F"] * cos, "sin": p["F"] * sin}

    def forces(self, motion: Motion, c: Symbols, phase: Expression) -> Forces:
        """``F cos(2 pi h f t + phi)``."""
        return (_harmonic(self.harmonic, c, phase),)


@dataclass(frozen=True)
class MultiHarmonicForce(OneDirection):
    r"""A force of several harmonics: :math:`\sum_h F_h \cos(2\pi h f t + \varphi_h)`.

    Parameters
    ----------
    at
        Degree of freedom, or weights by name.
    harmonics
        Amplitude in N, or amplitude and phase in rad, by harmonic: ``{0: 2.0, 1: 1.0, 3: (0.2,
        0.5)}``. They become the parameters ``F0 F1 phi1 F3 phi3``; the mean ``F0`` has no phase.
    name
        Tells forces apart; empty if there is one only.

    Examples
    --------
    >>> force = MultiHarmonicForce("tip", {0: 2.0, 1: 1.0, 3: (0.2, 0.5)})
    >>> force.own_values
    {'F0': 2.0, 'F1': 1.0, 'phi1': 0.0, 'F3': 0.2, 'phi3': 0.5}
    """

    title: ClassVar[str] = "force of several harmonics"

    harmonics: Any = field()

    def prepare(self) -> None:
        """Read the direction and the harmonics."""
        super().prepare()
        given = self.harmonics
        # A force that is made again from its own fields has triples already.
        if isinstance(given, tuple) and all(
            isinstance(item, tuple) and len(item) == 3 for item in given
        ):
            given = {h: (size, phi) for h, size, phi in given}
        if not isinstance(given, Mapping) or not any(h != 0 for h in given):
            raise InputError(
                f"harmonics = {shown(self.harmonics)} is not a periodic force; give amplitudes by "
                "harmonic, such as {1: 1.0, 3: (0.2, 0.5)}"
            )
        checked = []
        for h, pair in given.items():
            number = checked_harmonic(h, self.title, 0)
            size, phi = pair if isinstance(pair, tuple | list) and len(pair) == 2 else (pair, 0.0)
            amplitude = self._size(number).check(parse_quantity(size, "N", f"F{number}"))
            angle = self._angle(number).check(parse_quantity(phi, "rad", f"phi{number}"))
            checked.append((number, amplitude, angle))
        object.__setattr__(self, "harmonics", tuple(sorted(checked)))

    @staticmethod
    def _size(h: int) -> Parameter:
        what = f"amplitude of harmonic {h} of a force" if h else "mean of a force"
        return Parameter(f"F{h}", 0.0, "N", what, symbol=f"$F_{{{h}}}$")

    @staticmethod
    def _angle(h: int) -> Parameter:
        return Parameter(f"phi{h}", 0.0, "rad", f"phase by which harmonic {h} of a force leads")

    @property
    def own_parameters(self) -> tuple[Parameter, ...]:
        """Amplitude and phase of each harmonic."""
        pairs = [
            (self._size(h), self._angle(h)) if h else (self._size(h),) for h, _, _ in self.harmonics
        ]
        return tuple(item for pair in pairs for item in pair)

    @property
    def own_values(self) -> dict[str, float]:
        """Values of the parameters by name, in SI units."""
        values: dict[str, float] = {}
        for h, size, phi in self.harmonics:
            values |= {f"F{h}": size, f"phi{h}": phi} if h else {"F0": size}
        return values

    @property
    def kind(self) -> Self:
        """The force with all amplitudes zero."""
        return replace(self, harmonics=tuple((h, 0.0, 0.0) for h, _, _ in self.harmonics))

    @property
    def amplitudes(self) -> tuple[str, ...]:
        """All but the mean."""
        return tuple(f"F{h}" for h, _, _ in self.harmonics if h)

    def coefficients(self, p: Symbols) -> dict[str, Expression]:
        """Parts of each harmonic in phase and out of phase."""
        result: dict[str, Expression] = {}
        for h, _, _ in self.harmonics:
            cos, sin = cos_sin(p[f"phi{h}"]) if h else (1.0, 0.0)
            result[f"cos{h}"] = p[f"F{h}"] * cos
            if h:
                result[f"sin{h}"] = p[f"F{h}"] * sin
        return result

    def forces(self, motion: Motion, c: Symbols, phase: Expression) -> Forces:
        """``sum F_h cos(2 pi h f t + phi_h)``."""
        terms = []
        for h, _, _ in self.harmonics:
            if not h:
                terms.append(c["cos0"])
                continue
            cos, sin = wave(h, phase)
            terms += [c[f"cos{h}"] * cos, -c[f"sin{h}"] * sin]
        return (total(terms),)


@dataclass(frozen=True)
class BaseMotion(Component):
    r"""A base that shakes the structure: :math:`u_b = A \cos(2\pi h f t + \varphi)`.

    Displacements are then relative to the base, and the force is :math:`-M r \ddot u_b`.

    Parameters
    ----------
    along
        The influence vector r: how each degree of freedom would move with the base if the
        structure were rigid, as weights by name; None if all move by the same.
    A
        Amplitude of the displacement in m.
    phi
        Phase in rad.
    harmonic
        The whole number h: how often the base moves to and fro in a forcing period.
    name
        Tells base motions apart; empty if there is one only.

    Examples
    --------
    >>> BaseMotion(A="1mm").A
    0.001
    """

    title: ClassVar[str] = "base motion"
    amplitude: ClassVar[str | None] = "A"
    inertial: ClassVar[bool] = True

    along: Any = None
    A: float = described(Parameter("A", 0.0, "m", "amplitude of the base's motion", symbol="$A$"))
    phi: float = described(_PHASE)
    harmonic: int = 1

    def prepare(self) -> None:
        """Read the direction and the harmonic."""
        if self.along is not None:
            object.__setattr__(self, "along", as_direction(self.along, f"a {self.title}"))
        object.__setattr__(self, "harmonic", checked_harmonic(self.harmonic, self.title))

    @property
    def directions(self) -> tuple[Direction | None, ...]:
        """The one direction."""
        return (self.along,)

    def coefficients(self, p: Symbols) -> dict[str, Expression]:
        """Parts of minus the acceleration in phase and out of phase, in m/s^2."""
        cos, sin = cos_sin(p["phi"])
        rate = 2 * math.pi * self.harmonic * p["f"]
        size = p["A"] * rate * rate
        return {"cos": size * cos, "sin": size * sin}

    def forces(self, motion: Motion, c: Symbols, phase: Expression) -> Forces:
        """``A (2 pi h f)^2 cos(2 pi h f t + phi)``, to be multiplied with the masses."""
        return (_harmonic(self.harmonic, c, phase),)


def _harmonic(harmonic: int, c: Symbols, phase: Expression) -> Expression:
    cos, sin = wave(harmonic, phase)
    return c["cos"] * cos - c["sin"] * sin


ROUNDING = 1e-14
"""Share of the largest amplitude below which one is zero but for rounding."""


@dataclass(frozen=True)
class TabulatedForce(OneDirection):
    """A force given by samples over one forcing period, times a factor.

    Between the samples it is their trigonometric interpolant. The factor multiplies the mean, too.

    Parameters
    ----------
    at
        Degree of freedom, or weights by name.
    samples
        Force in N at equidistant times of one period, without its end, shape (m,).
    factor
        What the whole table is multiplied with; no unit.
    harmonics
        Keep only harmonics up to this one; `residual` says what that leaves out. None keeps all
        that the samples have.
    name
        Tells forces apart; empty if there is one only.

    Examples
    --------
    >>> import numpy as np
    >>> force = TabulatedForce("tip", np.cos(2 * np.pi * np.arange(8) / 8))
    >>> force.residual < 1e-15
    True
    """

    title: ClassVar[str] = "tabulated force"
    amplitude: ClassVar[str | None] = "factor"

    samples: Any
    factor: float = described(Parameter("factor", 1.0, "", "factor of a tabulated force"))
    harmonics: int | None = None

    def prepare(self) -> None:
        """Read the direction and the samples."""
        super().prepare()
        object.__setattr__(self, "samples", _checked_samples(self.samples))
        if self.harmonics is not None:
            checked = checked_harmonic(self.harmonics, self.title)
            object.__setattr__(self, "harmonics", checked)
        highest = max((h for h, _, _ in self.series), default=0)
        if highest > HIGHEST:
            raise InputError(
                f"the table of {len(self.samples)} samples has harmonics up to {highest}; give "
                f"harmonics, at most {HIGHEST}, and see in residual what that leaves out"
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
            if abs(value) > ROUNDING * size:
                terms.append((h, float(factor * value.real), float(-factor * value.imag)))
        return tuple(terms)

    @property
    def residual(self) -> float:
        """Largest difference between samples and series, over the largest sample."""
        samples = np.array(self.samples)
        angle = 2 * np.pi * np.arange(len(samples)) / len(samples)
        found = np.zeros(len(samples))
        for h, a, b in self.series:
            found += a * np.cos(h * angle) + b * np.sin(h * angle)
        return float(np.abs(found - samples).max() / np.abs(samples).max())

    def forces(self, motion: Motion, c: Symbols, phase: Expression) -> Forces:
        """Return the Fourier series times the factor."""
        terms = []
        for h, a, b in self.series:
            cos, sin = wave(h, phase) if h else (1.0, 0.0)
            terms += [a * c["factor"] * cos] if a else []
            terms += [b * c["factor"] * sin] if b and h else []
        return (total(terms),)


def _checked_samples(given: Any) -> tuple[float, ...]:
    try:
        samples: NDArray[np.float64] = np.asarray(given, dtype=float)
    except (TypeError, ValueError):
        samples = np.empty(0)
    if samples.ndim != 1 or len(samples) < 3 or not np.isfinite(samples).all():
        raise InputError(
            "the samples of a tabulated force are not a row of numbers; give at least 3 finite "
            "numbers, equidistant over one period"
        )
    if np.ptp(samples) == 0:
        raise InputError(
            "the samples of a tabulated force are all the same, so it does not vary; give one "
            "period of a force that does"
        )
    return tuple(samples.tolist())
