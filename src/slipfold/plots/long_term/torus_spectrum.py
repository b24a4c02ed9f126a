"""Lines of motions on tori, named by the multiples of the two frequencies that they are."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes

from slipfold.errors import InputError
from slipfold.plots.axes import axes_or_new, label_of, settle
from slipfold.plots.labels import Label, place_labels
from slipfold.text.printed_table import with_unit
from slipfold.tori.torus_branch import TorusBranch
from slipfold.tori.torus_spectrum import TorusSpectrum

DEEP = 1e-4
"""Least amplitude that is drawn, of the largest."""

NAMED = 8
"""Lines that are named, the tallest."""

FIRST, BETWEEN = "black", "#2166ac"
"""Colours of the multiples of the first frequency, and of the other lines."""


def draw_spectrum_at(
    tori: Sequence[TorusBranch],
    output: str,
    at: float | None = None,
    ax: Axes | None = None,
    **options: float,
) -> Axes:
    """Draw the lines of the torus nearest to a value of the parameter, and say which one it is."""
    known = [each for each in tori if len(each) > 1]
    if not known:
        raise InputError("the diagram has no tori; compute it with tori=True, or --tori")
    vary, unit = known[0].vary, known[0].model.parameter(known[0].vary).unit
    low = min(each.parameter.min() for each in known)
    high = max(each.parameter.max() for each in known)
    if at is None or not low <= at <= high:
        where = with_unit(f"{vary} = {low:.6g} to {high:.6g}", unit)
        told = "no value is given" if at is None else f"no torus at {vary} = {at:g}"
        raise InputError(f"{told}; there are tori at {where}, give one of these as at")
    # The first one of each is the orbit that they are born from.
    rows = [1 + int(np.abs(each.parameter[1:] - at).argmin()) for each in known]
    chosen, row = min(
        zip(known, rows, strict=True), key=lambda pair: abs(pair[0].parameter[pair[1]] - at)
    )
    ax = draw_torus_spectrum(chosen.spectrum(row), output, ax, **options)
    place = with_unit(f"{vary} = {chosen.parameter[row]:.6g}", unit)
    ax.set_title(f"tori {chosen.id}, {place}")
    return ax


def draw_torus_spectrum(
    spectrum: TorusSpectrum,
    output: str,
    ax: Axes | None = None,
    *,
    largest_order: float = 3.0,
) -> Axes:
    """Draw the amplitudes of one output over frequency, up to a multiple of the first one."""
    label, (first, second) = label_of(spectrum.model, output), spectrum.frequencies
    frequency, amplitude = spectrum.frequency, spectrum.of(output)
    floor = max(DEEP * float(amplitude.max()), float(np.finfo(float).tiny))
    shown = (frequency <= (largest_order + 0.5) * first) & (amplitude > floor)
    ax = axes_or_new(ax)
    ax.set_yscale("log")
    for colour, name, own in (
        (FIRST, f"multiples of $f_1$ = {first:.6g} Hz", spectrum.orders[:, 1] == 0),
        (BETWEEN, f"with $f_2$ = {second:.6g} Hz", spectrum.orders[:, 1] != 0),
    ):
        lines = shown & own
        stems = np.full(lines.sum(), floor), amplitude[lines]
        # Names keep clear of lines that are plotted.
        ax.plot(np.array([frequency[lines]] * 2), np.array(stems), color=colour, linewidth=1.0)
        ax.plot(
            frequency[lines], amplitude[lines], linestyle="none", marker="o", markersize=3,
            color=colour, label=name,
        )  # fmt: skip
    ax.set_xlim(-0.05 * first, (largest_order + 0.5) * first)
    ax.set_ylim(floor, 10.0 ** np.ceil(np.log10(max(amplitude.max(), 10 * floor)) + 0.25))
    ax.set_xlabel("frequency (Hz)")
    ax.set_ylabel(f"amplitude of {label}")
    ax.legend()
    settle(ax)
    tallest = np.flatnonzero(shown)[np.argsort(amplitude[shown])[::-1][:NAMED]]
    place_labels(
        ax,
        [
            Label(
                _name(*spectrum.orders[line]),
                np.array([[frequency[line], amplitude[line]]]),
                BETWEEN if spectrum.orders[line, 1] else FIRST,
            )
            for line in tallest
        ],
    )
    return ax


def _name(k: int, l: int) -> str:  # noqa: E741
    """Return e.g. ``"3f_1 - f_2"`` as mathematics."""
    terms = [
        f"{'-' if order < 0 else '+'}{'' if abs(order) == 1 else abs(order)}f_{place}"
        for place, order in ((1, k), (2, l))
        if order
    ]
    return f"${''.join(terms).removeprefix('+')}$" if terms else "mean"
