"""Draw the pictures of the README and the tutorial anew: python docs/figures/draw.py."""

from pathlib import Path

import matplotlib.pyplot as plt

import slipfold as sf
from slipfold.plots import draw_response, figure_style

FOLDER = Path(__file__).parent


def main() -> None:
    """Draw the force response at 12.5 Hz, vertical and horizontal."""
    diagram = sf.response(sf.SlidingOscillator(), vary="Nd", span=(0, 0.98), f=12.5)
    with figure_style():
        figure, (left, right) = plt.subplots(1, 2, figsize=(7.2, 2.9), layout="constrained")
        draw_response(diagram, "y", ax=left)
        draw_response(diagram, "x", ax=right)
        figure.savefig(FOLDER / "response.png", dpi=150)


if __name__ == "__main__":
    main()
