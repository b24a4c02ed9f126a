"""Line spectra of steady responses."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes

from slipfold.long_term.spectrum import Spectrum
from slipfold.plots.axes import axes_or_new, label_of, settle
from slipfold.plots.labels import Label, place_labels


def draw_spectrum(
    spectrum: Spectrum,
    output: str = "x",
    ax: Axes | None = None,
    colour: str = "black",
    *,
    floor: float = 1e-6,
    largest_order: float = 3.0,
    annotate: bool = True,
) -> Axes:
    """Draw the amplitudes of one output over frequency, one line each, on a logarithmic scale."""
    label = label_of(spectrum.model, output)
    amplitude = spectrum.of(output)
    ax = axes_or_new(ax)
    shown = (spectrum.order <= largest_order * (1 + 1e-9)) & (amplitude > floor)
    frequency, height = spectrum.frequency[shown], amplitude[shown]
    ax.set_yscale("log")
    ax.vlines(frequency, floor, height, color=colour, linewidth=1.0)
    ax.plot(frequency, height, linestyle="none", marker="o", markersize=3, color=colour)
    unit = spectrum.frequency[spectrum.periods] if spectrum.periods < len(spectrum.frequency) else 1
    ax.set_xlim(-0.05 * unit, (largest_order + 0.1) * unit)
    ax.set_ylim(floor, 10.0 ** np.ceil(np.log10(height.max(initial=10 * floor)) + 0.25))
    ax.set_xlabel("frequency (Hz)")
    ax.set_ylabel(f"amplitude of {label}")
    if annotate:
        name_lines(ax, spectrum, output, colour)
    return ax


def name_lines(ax: Axes, spectrum: Spectrum, output: str = "x", colour: str = "black") -> None:
    """Name the multiples of half the forcing frequency."""
    settle(ax)
    floor, rightmost = ax.get_ylim()[0], ax.get_xlim()[1]
    labels = []
    for frequency, amplitude, order in zip(
        spectrum.frequency, spectrum.of(output), spectrum.order, strict=True
    ):
        if amplitude > floor and frequency < rightmost and 2 * order == round(2 * order):
            place = np.array([[frequency, amplitude]])
            labels.append(Label(_order_name(round(2 * order)), place, colour, leader=False))
    place_labels(ax, labels)


def _order_name(halves: int) -> str:
    """Return e.g. ``"3f/2"`` for three halves of the forcing frequency."""
    if halves == 0:
        return "mean"
    count, rest = (halves // 2, "") if halves % 2 == 0 else (halves, "/2")
    return f"${'' if count == 1 else count}f{rest}$"
