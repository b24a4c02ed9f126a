"""Linear modes about a point: natural frequencies, damping ratios, shapes."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from slipfold.arrays import Array, Complex
from slipfold.text import OneLine, PrintedTable, listed, number_text


@dataclass(frozen=True, eq=False, repr=False)
class Modes(OneLine):
    """Modes of a linear system; one row a mode, the lowest natural frequency first.

    A pair of complex eigenvalues is one mode; a real eigenvalue (overdamped or divergent) is a mode
    of its own with damping ratio 1 or -1.

    Parameters
    ----------
    eigenvalues
        In 1/s, the one of a pair with positive imaginary part, shape (n_modes,).
    shapes
        Complex displacements, the largest being 1, shape (n_modes, n_displacements).
    names
        Names of the displacements.

    Examples
    --------
    >>> from slipfold.models.sliding_oscillator import SlidingOscillator
    >>> modes = SlidingOscillator(mu=0).modes()
    >>> [round(float(value), 6) for value in modes.frequency]
    [6.59, 12.459652]
    """

    eigenvalues: Complex
    shapes: Complex
    names: tuple[str, ...]

    def _line(self) -> str:
        state = "stable" if self.stable else "unstable"
        return f"Modes of {listed(map(number_text, self.frequency))} Hz, {state}"

    def _rows(self) -> PrintedTable:
        numbers = zip(self.frequency, self.damping_ratio, self.shapes, strict=True)
        lines = [
            [number_text(f), number_text(ratio), *(f"{part:.3f}" for part in shape)]
            for f, ratio, shape in numbers
        ]
        return PrintedTable(["f (Hz)", "damping", *self.names], lines)

    @property
    def frequency(self) -> Array:
        """Undamped natural frequencies |lambda|/(2 pi), Hz."""
        return np.abs(self.eigenvalues) / (2 * math.pi)

    @property
    def damped_frequency(self) -> Array:
        """Frequencies of the free decay, Im lambda/(2 pi), Hz."""
        return self.eigenvalues.imag / (2 * math.pi)

    @property
    def damping_ratio(self) -> Array:
        """Ratios of damping to critical damping, -Re lambda/|lambda|; negative if unstable."""
        size = np.abs(self.eigenvalues)
        return np.divide(-self.eigenvalues.real, size, out=np.zeros_like(size), where=size > 0)

    @property
    def stable(self) -> bool:
        """Whether every mode decays."""
        return bool(np.all(self.eigenvalues.real < 0))

    def __str__(self) -> str:
        """Table of the modes."""
        return "\n".join(self._rows().text())


def find_modes(jacobian: Array, names: tuple[str, ...]) -> Modes:
    """Find the modes of a first-order system of displacements and their rates.

    Shapes: jacobian (2 n, 2 n).
    """
    values, vectors = np.linalg.eig(jacobian)
    upper = np.flatnonzero(values.imag >= 0)
    upper = upper[np.argsort(np.abs(values[upper]), kind="stable")]
    shapes = vectors[: len(names), upper].T.astype(complex)
    for shape in shapes:
        shape /= shape[np.abs(shape).argmax()]
    return Modes(values[upper].astype(complex), shapes, names)
