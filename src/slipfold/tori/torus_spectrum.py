"""Lines of a motion on a torus, each at a sum of multiples of two frequencies."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.drawing import draw
from slipfold.errors import InputError
from slipfold.flow.flow import flow_of
from slipfold.long_term.spectrum import SpectralLines
from slipfold.models.evaluation import evaluation_of
from slipfold.models.model import Model
from slipfold.read_only import ReadOnly
from slipfold.text.one_line import number_text
from slipfold.text.printed_table import PrintedTable
from slipfold.tori.surface import Surface

SHOWN = 12
"""Lines that a notebook shows."""


@dataclass(frozen=True, eq=False, repr=False)
class TorusSpectrum(SpectralLines, ReadOnly):
    """Single-sided spectra of all outputs on one torus; frozen.

    Made by `TorusBranch.spectrum`. Lines lie at ``k f1 + l f2``. They come from the series of the
    torus and not from a motion of some length, so that none leaks into another however near they
    are.

    Parameters
    ----------
    model
        The model with its parameter values.
    names
        The outputs; states come first.
    frequencies
        f1 and f2 in Hz: that of the orbit which the tori are born from, i.e. of the forcing over
        its period, and the modulation frequency, which is negative if the circle turns the other
        way.
    orders
        Whole numbers k and l of each line, shape (m, 2). Of a line and its mirror image it is the
        one at a positive frequency.
    coefficients
        Complex amplitudes ``a``, in the units of the outputs, shape (m, n_outputs): to the motion
        from the first state of the circle a line contributes ``Re(a exp(2 pi i f t))``. That of
        ``k = l = 0`` is the mean.

    Examples
    --------
    >>> import slipfold as sf
    >>> model = sf.built_in_models()["vanderpol"](a=0.3, e=0.2)
    >>> (tori,) = sf.response(model, vary="w", span=(1, 1.1), tori=True).tori
    >>> spectrum = tori.spectrum(-1)
    >>> spectrum.orders[spectrum.of("x").argsort()[:-4:-1]].tolist()
    [[1, -1], [1, 0], [1, -2]]
    """

    model: Model
    names: tuple[str, ...]
    frequencies: tuple[float, float]
    orders: NDArray[np.int64]
    coefficients: NDArray[np.complex128]

    def _line(self) -> str:
        first, second = map(number_text, self.frequencies)
        return (
            f"Spectrum of a torus of {self.model.name}: {len(self.names)} outputs, "
            f"{len(self.orders)} lines at k {first} Hz + l {second} Hz"
        )

    def _rows(self) -> PrintedTable:
        size = self.amplitude / np.maximum(self.amplitude.max(axis=0), np.finfo(float).tiny)
        tallest = np.sort(np.argsort(size.max(axis=1))[::-1][:SHOWN])
        lines = [
            [*map(str, self.orders[i]), *map(number_text, (self.frequency[i], *self.amplitude[i]))]
            for i in tallest
        ]
        return PrintedTable(["k", "l", "f (Hz)", *self.names], lines)

    @property
    def frequency(self) -> Array:
        """Frequencies of the lines in Hz, in rising order, shape (m,)."""
        return np.asarray(self.orders @ np.array(self.frequencies))

    def line(self, name: str, k: int, l: int) -> float:  # noqa: E741
        """Return the amplitude of one output at ``k f1 + l f2``.

        Parameters
        ----------
        name
            A state or output of the model.
        k, l
            Multiples of the two frequencies.

        Raises
        ------
        InputError
            If there is no such output or line.
        """
        column = self._column(name)
        same = (self.orders == (k, l)).all(axis=1) | (self.orders == (-k, -l)).all(axis=1)
        if not same.any():
            most = np.abs(self.orders).max(axis=0)
            raise InputError(
                f"k = {k}, l = {l} is not a line of the spectrum; k goes to {most[0]} and l to "
                f"{most[1]} on both sides"
            )
        return float(self.amplitude[same.argmax(), column])

    def plot(self, output: str | None = None, **options: Any) -> Any:
        """Draw the amplitudes of an output over frequency, the tallest lines with their orders.

        Parameters
        ----------
        output
            A state or output of the model; the first state if None.
        **options
            Options of the drawing, e.g. ``ax=`` the axes to draw in.

        Returns
        -------
        matplotlib.axes.Axes
            The axes.

        Raises
        ------
        InputError
            For an unknown output.
        """
        return draw(self, output=output, **options)


def spectrum_of(model: Model, surface: Surface) -> TorusSpectrum:
    """Return the lines of a whole torus."""
    first = 1 / (surface.period * evaluation_of(model).period(model))
    frequencies = first, surface.rotation * first
    series = surface.lines
    around, along = (np.fft.fftfreq(count, 1 / count).astype(int) for count in series.shape[:2])
    orders = np.stack(np.meshgrid(along, around), axis=-1)
    frequency = orders @ np.array(frequencies)
    # Of an even number of phases the last line is all that lies above it as well.
    known = 2 * np.abs(orders[..., 0]) < len(along)
    kept = known & ((frequency > 0) | ((frequency == 0) & (orders[..., 0] > 0)))
    kept[0, 0] = True
    rising = np.argsort(frequency[kept], kind="stable")
    orders, coefficients = orders[kept][rising], 2 * series[kept][rising]
    coefficients[~orders.any(axis=1)] /= 2
    names = flow_of(model).output_names
    return TorusSpectrum(model, names, frequencies, orders, coefficients)
