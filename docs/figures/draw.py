"""Draw the pictures of the README and the tutorial anew: python docs/figures/draw.py."""

from pathlib import Path

import matplotlib.pyplot as plt

import slipfold as sf
from slipfold.plots import draw_response, figure_style

FOLDER = Path(__file__).parent


def main() -> None:
    """Draw all of them."""
    draw_response_at_base_case()
    draw_stick_and_slip()


def draw_response_at_base_case() -> None:
    """Draw the force response at 12.5 Hz, vertical and horizontal."""
    diagram = sf.response(sf.SlidingOscillator(), vary="Nd", span=(0, 0.98), f=12.5)
    with figure_style():
        figure, (left, right) = plt.subplots(1, 2, figsize=(7.2, 2.9), layout="constrained")
        draw_response(diagram, "y", ax=left)
        draw_response(diagram, "x", ax=right)
        figure.savefig(FOLDER / "response.png", dpi=150)


def draw_stick_and_slip() -> None:
    """Draw what the tip does on a slow plate: friction loops, where it goes, when it sticks."""
    motion = sf.simulate(sf.SlidingOscillator(), f=12.5, Nd=0.9, Vd=0.02)
    with figure_style():
        figure = plt.figure(figsize=(7.2, 6.4), layout="constrained")
        axes = figure.subplot_mosaic("AB;CD;EE", height_ratios=(1, 1, 0.32))
        kinds = ("hysteresis", "friction", "path", "track", "timeline")
        for ax, kind in zip(axes.values(), kinds, strict=True):
            motion.plot(kind=kind, ax=ax)
        figure.savefig(FOLDER / "stick_and_slip.png", dpi=150)


if __name__ == "__main__":
    main()
