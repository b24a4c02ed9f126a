"""Linear modes about a point: natural frequencies, damping ratios, shapes."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from slipfold.arrays import Array, Complex
from slipfold.models.equilibria import find_static_point
from slipfold.models.model import Model, evaluation_of
from slipfold.models.quantities import Parameter
from slipfold.models.unforced import Unforced
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

    >>> import numpy as np
    >>> modes = find_modes(np.array([[0.0, 1.0], [-1.0, -0.02]]), ("x",))
    >>> [round(float(value), 12) for value in modes.damping_ratio]
    [0.01]
    """
    values, vectors = np.linalg.eig(jacobian)
    upper = np.flatnonzero(values.imag >= 0)
    upper = upper[np.argsort(np.abs(values[upper]), kind="stable")]
    shapes = vectors[: len(names), upper].T.astype(complex)
    for shape in shapes:
        shape /= shape[np.abs(shape).argmax()]
    return Modes(values[upper].astype(complex), shapes, names)


class MechanicalModel(Model):
    """A model of displacements ``x`` and their rates ``vx``, with its static point and modes."""

    @property
    def surface_speeds(self) -> Mapping[str, bool]:
        """Names of the speeds of moving surfaces, and whether contacts stick to them at rest."""
        return {}

    @property
    def varied_first(self) -> str | None:
        """The parameter that switches the forcing off, or the speed of a moving surface."""
        return self.forcing_amplitude or next(iter(self.surface_speeds), None)

    @property
    def variable_parameters(self) -> tuple[Parameter, ...]:
        """Those that may be varied; what may stick stays in slip, so above a speed of zero."""
        speeds = self.surface_speeds
        return tuple(
            replace(item, lower_open=True) if speeds.get(item.name) else item
            for item in super().variable_parameters
        )

    def static_point(self) -> Array:
        """Return the state at rest under steady friction without forcing, shape (n_states,).

        Raises
        ------
        InputError
            If there is none, as where the drag is more than the structure can hold.
        """
        return find_static_point(self)

    def steady(self, **values: float | str) -> Unforced:
        """Return the model without what is periodic in time, as an autonomous model.

        Its equilibrium is steady sliding, to be followed with its Hopf points and their cycles.

        Parameters
        ----------
        **values
            Parameter values that differ from those of this model. Those of the forcing are gone,
            and there is a ``duration``.

        Raises
        ------
        InputError
            If the model is autonomous.
        """
        return Unforced(self, **values)

    def modes(self) -> Modes:
        """Return the linear modes about the static point, all forces included.

        Returns
        -------
        Modes
            One a pair of eigenvalues, the lowest natural frequency first; friction laws with memory
            add modes in which the contact recovers without vibration.

        Examples
        --------
        >>> from slipfold import SlidingOscillator
        >>> [f"{value:.4f}" for value in SlidingOscillator().modes().frequency]
        ['7.1383', '12.4607']
        """
        unforced = (
            self
            if self.forcing_amplitude is None
            else self.replace(**{self.forcing_amplitude: 0.0})
        )
        names = [item.name for item in self.states]
        displacements = tuple(name for name in names if f"v{name}" in names)
        jacobian = evaluation_of(unforced).jacobian(unforced, self.static_point())
        return find_modes(jacobian, displacements)
