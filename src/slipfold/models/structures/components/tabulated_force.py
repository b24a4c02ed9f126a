"""A periodic force from samples, by its Fourier series."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from slipfold.errors import InputError
from slipfold.models.friction.quantities import described
from slipfold.models.output import Expression, Symbols
from slipfold.models.parameter import Parameter
from slipfold.models.structures.components.component import Motion
from slipfold.models.structures.components.harmonics import HIGHEST, checked_harmonic
from slipfold.models.structures.components.one_direction import OneDirection
from slipfold.models.structures.components.sums import total
from slipfold.models.structures.components.trigonometry import wave

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

    @property
    def amplitudes(self) -> tuple[str, ...]:
        """``factor``."""
        return ("factor",)

    def forces(
        self, motion: Motion, c: Symbols, phase: Expression
    ) -> tuple[Expression | None, ...]:
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
