"""Spectra with physical amplitudes, free of leakage."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.errors import InputError, index_of
from slipfold.flow.flow import Flow, flow_of
from slipfold.flow.trajectory import Trajectory
from slipfold.models.angles import REVOLUTION
from slipfold.models.model import Model
from slipfold.models.quantities import OutputName
from slipfold.orbits.periodic_orbit import PeriodicOrbit, StickSlipOrbit
from slipfold.read_only import Documented
from slipfold.text import OneLine, PrintedTable, number_text

FINER = 32
"""Times as many samples where contacts stick: lines of a corner fall only with their order squared,
and those above half the samples come back among the lower ones, a thousandth as large then."""


class SpectralLines(OneLine, Documented):
    """Complex amplitudes of all outputs, a line a row."""

    names: tuple[str, ...]
    coefficients: NDArray[np.complex128]

    @property
    def amplitude(self) -> Array:
        """Moduli of the coefficients, in the units of the outputs, shape (m, n_outputs)."""
        return np.abs(self.coefficients)

    def of(self, name: OutputName) -> Array:
        """Return the amplitudes of one output, shape (m,)."""
        return self.amplitude[:, index_of(name, self.names, "output")]


@dataclass(frozen=True, eq=False, repr=False)
class Spectrum(SpectralLines):
    """Single-sided spectra of all outputs over a whole number of forcing periods; frozen.

    The spectrum of a revolving angle is that of its difference from uniform rotation.

    Parameters
    ----------
    model
        The model with its parameter values.
    names
        The outputs; states come first.
    frequency
        Hz, from 0, shape (m,).
    coefficients
        Complex amplitudes ``a``, in the units of the outputs, shape (m, n_outputs): a line
        contributes ``Re(a exp(2 pi i f t))``. That of frequency zero is the mean.
    periods
        Forcing periods transformed: the lines are 1/`periods` of the forcing frequency apart.
    settled
        Whether the trajectory was periodic with these periods. If not, lines leak into each other.

    Examples
    --------
    >>> from slipfold.flow.simulate import simulate
    >>> from slipfold.models.sliding_oscillator import SlidingOscillator
    >>> spectrum = find_spectrum(simulate(SlidingOscillator(f=12.2, Nd=0.15), 1000))
    >>> [round(spectrum.line("x", order), 6) for order in (0, 0.5, 1, 1.5)]
    [0.115373, 0.276327, 0.038987, 0.01296]
    """

    model: Model
    names: tuple[str, ...]
    frequency: Array
    coefficients: NDArray[np.complex128]
    periods: int
    settled: bool

    def _line(self) -> str:
        leaks = "" if self.settled else ", not settled"
        return (
            f"Spectrum of {self.model.name}: {len(self.names)} outputs, {len(self.frequency)} "
            f"lines to {number_text(self.frequency[-1])} Hz{leaks}"
        )

    def _rows(self) -> PrintedTable:
        size = self.amplitude / np.maximum(self.amplitude.max(axis=0), np.finfo(float).tiny)
        tallest = np.sort(np.argsort(size.max(axis=1))[::-1][:10])  # lines that a notebook shows
        lines = [
            [number_text(self.frequency[i]), *map(number_text, self.amplitude[i])] for i in tallest
        ]
        return PrintedTable(["f (Hz)", *self.names], lines)

    @property
    def order(self) -> Array:
        """Frequencies over the forcing frequency, shape (m,)."""
        return np.arange(len(self.frequency)) / self.periods

    def line(self, name: OutputName, order: float) -> float:
        """Return the amplitude of one output at a multiple of the forcing frequency.

        Parameters
        ----------
        order
            Frequency over the forcing frequency, e.g. 0.5 for the subharmonic.
        """
        position = order * self.periods
        index = round(position)
        if abs(position - index) > 1e-9 * max(1, self.periods) or not (
            0 <= index < len(self.frequency)
        ):
            raise InputError(
                f"order = {order:g} is not a line of the spectrum; its lines are the multiples of "
                f"1/{self.periods} up to {self.order[-1]:g}"
            )
        return float(self.amplitude[index, index_of(name, self.names, "output")])


def find_spectrum(
    trajectory: Trajectory | PeriodicOrbit,
    periods: int = 64,
    per_period: int = 64,
    *,
    tapered: bool = False,
) -> Spectrum:
    """Transform the steady end of a trajectory, or a periodic orbit.

    Parameters
    ----------
    trajectory
        A trajectory, of which the end is taken, or a periodic orbit.
    periods
        Forcing periods to transform: rounded up to whole response periods, as far as the trajectory
        allows; rounds of a cycle. An orbit is transformed over its own period, whatever this says.
    per_period
        Samples per forcing period; what lies above half of them is taken to be nothing.
    tapered
        Whether a trajectory that has not settled is multiplied by Hann's window, so that a line
        leaks into its neighbors only; its amplitude may be 15 % too small.

    Raises
    ------
    InputError
        If the trajectory is shorter than one response, or a number is less than 1.
    """
    if per_period < 2:
        raise InputError(f"per_period = {per_period} is too few; give 2 or more")
    flow = flow_of(trajectory.model)
    if isinstance(trajectory, Trajectory):
        count = trajectory.steady_periods(periods)
        finer = 1 if trajectory.sticking is None else FINER
        values = trajectory.steady_outputs(periods, finer * per_period)
        if tapered and not trajectory.settlement.settled:
            taper = 1 - np.cos(2 * np.pi * np.arange(len(values)) / len(values))[:, None]
            mean = (values * taper).mean(axis=0)
            values = mean + (values - mean) * taper
        known = flow, trajectory.steady_model, values, count
        return _transform(*known, trajectory.settlement.settled, finer)
    # The orbit rounds its samples up to a multiple of its nodes.
    finer = FINER if isinstance(trajectory, StickSlipOrbit) else 1
    values = trajectory.outputs(trajectory.period * per_period * finer)[1]
    return _transform(flow, trajectory.model, values, trajectory.period, True, finer)


def _without_even_turning(angles: Array) -> Array:
    """Return angles of a periodic trajectory less their mean speed. Shapes: angles (m, k)."""
    steps = np.diff(angles, axis=0, append=angles[:1])
    steps -= REVOLUTION * np.round(steps / REVOLUTION)
    steps -= steps.mean(axis=0)
    return angles[:1] + np.cumsum(steps, axis=0) - steps


def _transform(
    flow: Flow, model: Model, values: Array, periods: int, settled: bool, finer: int = 1
) -> Spectrum:
    constants = flow.constants_of(model)
    count = len(values)
    angles = np.flatnonzero(model.angle_periods)
    values = values.copy()
    values[:, angles] = _without_even_turning(values[:, angles])
    with np.errstate(invalid="ignore"):  # what has no value somewhere has no spectrum
        coefficients = np.fft.rfft(values, axis=0) / count
    # Every line but the mean stands for two of the two-sided spectrum, except the last one of an
    # even number of samples, which is its own mirror image.
    coefficients[1 : (count + 1) // 2] *= 2
    coefficients = coefficients[: count // finer // 2 + 1]
    frequency = np.arange(len(coefficients)) / (periods * constants.period)
    return Spectrum(model, flow.output_names, frequency, coefficients, periods, settled)
