"""The figures of docs/how-to/tori-and-chaos.md that show what solutions do.

    python docs/figures/regimes.py

The last three are those of ``slipfold paper --long-term``. About ten minutes.
"""

from pathlib import Path

from matplotlib.figure import Figure

import slipfold as sf
from slipfold.interface.paper.cases import read_cases
from slipfold.interface.paper.drawing import draw
from slipfold.plots.style import COLUMN, figure_style

FOLDER = Path(__file__).parent
MODEL = sf.SlidingOscillator()
BOX = {"x": (-0.3, 0.3), "y": (-0.3, 0.3), "vx": (-10, 10), "vy": (-10, 10)}
WINDOW = (11.5, 13.5), (0.0, 0.5)


def sweeps() -> Figure:
    """The response at 12.5 Hz with what solutions do besides, and its spectra."""
    diagram = sf.response(MODEL, vary="Nd", span=(0, 0.2), f=12.5)
    swept = sf.sweep(
        MODEL, "Nd", (0, 0.2), points=240, starts=4, box=BOX, transient=1500, periods=48, f=12.5
    )
    figure = Figure(figsize=(2 * COLUMN, 1.9 * COLUMN), layout="constrained")
    first, second = figure.subplots(2, 1, sharex=True)
    diagram.plot(under=swept, ax=first)
    swept.plot(kind="waterfall", ax=second)
    return figure


def plane() -> Figure:
    """What solutions do over frequency and amplitude, over the bifurcations."""
    loci = sf.bifurcation_set(MODEL, ("f", "Nd"), WINDOW)
    found = sf.regimes(MODEL, {"f": WINDOW[0], "Nd": WINDOW[1]}, points=(81, 61))
    figure = Figure(figsize=(2 * COLUMN, 1.25 * COLUMN), layout="constrained")
    found.plot(over=loci, ax=figure.add_subplot())
    return figure


def main() -> None:
    """Compute and write all."""
    with figure_style():
        for name, picture in (("sweep", sweeps), ("regimes", plane)):
            picture().savefig(FOLDER / f"{name}.png", dpi=200)
        for figure in read_cases(long_term=True).figures:
            if figure.kind in ("completed", "hysteresis"):
                found = {case: case.compute(tori=True) for case in figure.needs}
                draw(figure, found).savefig(FOLDER / f"{figure.key}.png", dpi=200)


if __name__ == "__main__":
    main()
