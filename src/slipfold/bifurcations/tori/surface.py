"""A whole torus: its surface, the lines of its spectrum, and whether it attracts."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import numpy as np

from slipfold.arrays import Array, Complex, Indices
from slipfold.bifurcations.tori.circles import TORUS, slopes, turned
from slipfold.drawing import Drawn
from slipfold.errors import InputError, index_of
from slipfold.flow.flow import flow_of
from slipfold.long_term.exponents import Average, average
from slipfold.long_term.spectrum import SpectralLines
from slipfold.models.model import Model, evaluation_of
from slipfold.models.quantities import OutputName
from slipfold.read_only import ReadOnly
from slipfold.text import PrintedTable, number_text


def growth_across(
    matrices: Array, circle: Array, rotation: float, scales: Array, rates: Array | None = None
) -> Average:
    """Return exponents a return of what is across the torus, the largest first.

    Along the circle perturbations neither grow nor decay, nor do they along the flow of an
    autonomous model; what they have along these does not count. The derivatives of the map between
    the angles are those of their Fourier series.

    Shapes: matrices (m, n, n), circle, rates (m, n).
    """
    (m, n), scaled = circle.shape, matrices * (scales / scales[:, None])
    within = [part / scales for part in (slopes(circle), rates) if part is not None]
    series = np.fft.rfft(np.concatenate([scaled.reshape(m, -1), *within], axis=1), axis=0) / m
    series[1:] *= 2
    returns = np.arange(2 * TORUS.returns + 1)[:, None]
    angles = (np.arange(TORUS.starts) / TORUS.starts + rotation * returns) % 1.0
    waves = np.exp(2j * np.pi * angles[..., None] * np.arange(len(series)))
    passed = (waves @ series).real
    tangents = passed[..., n * n :].reshape(*angles.shape, -1, n).swapaxes(-1, -2)
    planes = np.concatenate([tangents, np.broadcast_to(np.eye(n), (*angles.shape, n, n))], axis=-1)
    across = np.linalg.qr(planes)[0][..., len(within) :]  # bases of what is across, by columns
    maps = passed[:-1, :, : n * n].reshape(-1, TORUS.starts, n, n)
    steps = across[1:].swapaxes(-1, -2) @ maps @ across[:-1]
    left = n - len(within)
    frame, growth = np.eye(left), np.empty((2 * TORUS.returns, left))
    for step, row in zip(steps, growth, strict=True):
        frame, factors = np.linalg.qr(step @ frame)
        sizes = np.abs(np.diagonal(factors, axis1=-2, axis2=-1))
        row[:] = np.log(np.maximum(sizes, np.finfo(float).tiny)).mean(axis=0)
    result = average(growth[TORUS.returns :])
    order = np.argsort(-result.values, kind="stable")
    return Average(result.values[order], result.errors[order])


@dataclass(frozen=True, eq=False)
class Surface:
    r"""Outputs over two angles, in both of which they are periodic with one turn.

    A trajectory has :math:`\psi = \psi_0 + \rho t/(k T)` and :math:`\tau = t/(k T)`: its values are
    sums of lines at the frequencies :math:`(l \rho + j) f/k`.
    """

    rotation: float
    period: int
    values: Array  # at equidistant angles psi, tau, shape (m, q, n_outputs)

    @property
    def lines(self) -> Complex:
        """Coefficients of exp(2 pi i (l psi + j tau)), shape (m, q, n_outputs)."""
        m, q, _ = self.values.shape
        return np.fft.fft2(self.values, axes=(0, 1)) / (m * q)

    def extremes(self) -> tuple[Array, Array]:
        """Return the smallest and the largest value of outputs anywhere on the torus, (k,) each."""
        outputs = [np.moveaxis(item, -1, 0) for item in (self.lines, self.values)]
        result = [
            [sign * _largest(sign * lines, sign * values) for sign in (-1, 1)]
            for lines, values in zip(*outputs, strict=True)
        ]
        low, high = np.array(result).reshape(-1, 2).T
        return low, high


def _largest(lines: Complex, values: Array) -> float:
    """Return the largest value of a doubly periodic function, by Newton's method on its series."""
    highest = float(values.max())
    place = np.array(np.unravel_index(values.argmax(), values.shape)) / values.shape
    best, spacing = place, 1 / np.array(values.shape)
    turns = [2j * np.pi * np.fft.fftfreq(count, 1 / count) for count in values.shape]
    for _ in range(TORUS.corrections):
        # All derivatives by both angles up to the second.
        left, right = (
            np.exp(orders * at) * orders ** np.arange(3)[:, None]
            for orders, at in zip(turns, best, strict=True)
        )
        by = (left @ lines @ right.T).real
        bends = np.array([[by[2, 0], by[1, 1]], [by[1, 1], by[0, 2]]])
        if not np.linalg.det(bends) > 0:  # a corner, a ridge or a plain: samples have to do
            break
        best = best - np.linalg.solve(bends, [by[1, 0], by[0, 1]])
        if (np.abs(best - place) > spacing).any():
            break
        highest = max(highest, float(by[0, 0]))
    return highest


def surface_of(model: Model, circle: Array, rotation: float, period: int) -> Surface:
    """Return all of a torus from its circle at phase zero. Shapes: circle (m, n)."""
    flow, count = flow_of(model), TORUS.samples * period
    constants, zero = flow.constants_of(model), np.zeros(len(circle))
    states = flow.sample(circle, zero, zero + period, count, constants)
    phases = np.arange(count) / TORUS.samples % 1.0
    result = np.stack(
        [
            turned(
                flow.outputs(states[:, j], np.full(len(circle), phases[j]), constants),
                -rotation * j / count,
            )
            for j in range(count)
        ],
        axis=1,
    )
    return Surface(rotation, period, result)


@dataclass(frozen=True, eq=False, repr=False)
class TorusSpectrum(SpectralLines, Drawn, ReadOnly):
    """Single-sided spectra of all outputs on one torus; frozen.

    Made by `TorusBranch.spectrum`. Lines lie at ``k f1 + l f2``. They come from the series of the
    torus and not from a trajectory of some length, so that none leaks into another, however near.
    `plot` draws the amplitudes of an output over frequency, the tallest lines with their orders.

    Examples
    --------
    >>> import slipfold as sf
    >>> model = sf.built_in_models()["vanderpol"](a=0.3, e=0.2)
    >>> (tori,) = sf.response(model, vary="w", span=(1, 1.1), tori=True).tori
    >>> spectrum = tori.spectrum(-1)
    >>> spectrum.orders[spectrum.of("x").argsort()[:-4:-1]].tolist()
    [[1, -1], [1, 0], [1, -2]]
    """

    model: Annotated[Model, "The model with its parameter values."]
    names: Annotated[tuple[str, ...], "The outputs; states come first."]
    frequencies: Annotated[
        tuple[float, float],
        "f1 and f2 in Hz: that of the orbit from which the tori emanate, i.e. of the forcing "
        "over its period, and the modulation frequency, which is negative if the circle turns "
        "the other way.",
    ]
    orders: Annotated[
        Indices,
        "Whole numbers k and l of each line, shape (m, 2). Of a line and its mirror image it is "
        "the one at a positive frequency.",
    ]
    coefficients: Annotated[
        Complex,
        "Complex amplitudes ``a``, in the units of the outputs, shape (m, n_outputs). A line "
        "contributes ``Re(a exp(2 pi i f t))`` to the trajectory from the first state of the "
        "circle. That of ``k = l = 0`` is the mean.",
    ]

    def _line(self) -> str:
        first, second = map(number_text, self.frequencies)
        return (
            f"Spectrum of a torus of {self.model.name}: {len(self.names)} outputs, "
            f"{len(self.orders)} lines at k {first} Hz + l {second} Hz"
        )

    def _rows(self) -> PrintedTable:
        size = self.amplitude / np.maximum(self.amplitude.max(axis=0), np.finfo(float).tiny)
        tallest = np.sort(np.argsort(size.max(axis=1))[::-1][: TORUS.lines])
        lines = [
            [*map(str, self.orders[i]), *map(number_text, (self.frequency[i], *self.amplitude[i]))]
            for i in tallest
        ]
        return PrintedTable(["k", "l", "f (Hz)", *self.names], lines)

    @property
    def frequency(self) -> Array:
        """Frequencies of the lines in Hz, in rising order, shape (m,)."""
        return np.asarray(self.orders @ np.array(self.frequencies))

    def line(self, name: OutputName, k: int, l: int) -> float:  # noqa: E741
        """Return the amplitude of one output at ``k f1 + l f2``.

        Parameters
        ----------
        k, l
            Multiples of the two frequencies.
        """
        column = index_of(name, self.names, "output")
        same = (self.orders == (k, l)).all(axis=1) | (self.orders == (-k, -l)).all(axis=1)
        if not same.any():
            most = np.abs(self.orders).max(axis=0)
            raise InputError(
                f"k = {k}, l = {l} is not a line of the spectrum; k goes to {most[0]} and l to "
                f"{most[1]} on both sides"
            )
        return float(self.amplitude[same.argmax(), column])


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
