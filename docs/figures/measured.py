"""Draw what a test stand would record and what that determines: python docs/figures/measured.py."""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import slipfold as sf
from slipfold.plots import figure_style

FOLDER = Path(__file__).parent
FITTED = ("mu", "zeta1", "alpha")
ERROR = 1e-3  # of measurements of x/L and y/L
POINTS = 24
SWEEPS = {
    "f 11.8 to 13.2 Hz at Nd = 0.04 N": ({"Nd": 0.04}, "f", (11.8, 13.2)),
    "f 11.8 to 13.2 Hz at Nd = 0.1 N": ({"Nd": 0.1}, "f", (11.8, 13.2)),
    "f 11.8 to 13.2 Hz at Nd = 0.2 N": ({"Nd": 0.2}, "f", (11.8, 13.2)),
    "Nd 0.01 to 0.3 N at f = 12.2 Hz": ({"f": 12.2}, "Nd", (0.01, 0.3)),
    "Nd 0.01 to 0.3 N at f = 12.5 Hz": ({"f": 12.5}, "Nd", (0.01, 0.3)),
}
READ = (("max y",), ("max x",), ("max y", "max x"))


def main() -> None:
    """Write the table and draw the picture."""
    plans = {
        (sweep, read): sf.plan_measurement(
            sf.SlidingOscillator(**given), vary, np.linspace(*span, POINTS), read, FITTED,
            errors=ERROR,
        )
        for sweep, (given, vary, span) in SWEEPS.items()
        for read in READ
    }  # fmt: skip
    (FOLDER / "measured_plans.md").write_text(table(plans) + "\n")
    draw(plans)


def table(plans: dict[tuple[str, tuple[str, ...]], sf.MeasurementPlan]) -> str:
    """Return expected errors of the parameters, in percent, as a table of Markdown."""
    heads = ["sweep", "measured", *FITTED, "largest correlation", "best six values"]
    lines = ["| " + " | ".join(heads) + " |", "|" + "---|" * len(heads)]
    for (sweep, read), plan in plans.items():
        sizes = [plan.model.values[name] for name in FITTED]
        errors = [f"{100 * error / size:.2g} %" for error, size in
                  zip(plan.errors_expected, sizes, strict=True)]  # fmt: skip
        off = np.abs(plan.correlation - np.eye(len(FITTED))).max()
        best = ", ".join(f"{plan.values[row]:.4g}" for row in plan.best(6))
        lines.append(
            "| " + " | ".join([sweep, ", ".join(read), *errors, f"{off:.3f}", best]) + " |"
        )
    return "\n".join(lines)


def draw(plans: dict[tuple[str, tuple[str, ...]], sf.MeasurementPlan]) -> None:
    """Draw measurements over the response, and what each of them determines."""
    oscillator = sf.SlidingOscillator(Nd=0.1)
    seen = sf.measure(
        oscillator, "f", np.linspace(11.8, 13.2, 29), ["max y"], sweep="both", errors=ERROR, seed=1
    )
    with figure_style():
        figure, (left, right) = plt.subplots(1, 2, figsize=(7.2, 3.0), layout="constrained")
        diagram = sf.response(oscillator, vary="f", span=(11.8, 13.2))
        diagram.plot("y", ax=left, measured=seen)
        plans["f 11.8 to 13.2 Hz at Nd = 0.04 N", ("max y",)].plot(ax=right)
        figure.savefig(FOLDER / "measured.png", dpi=200)
        plt.close(figure)


if __name__ == "__main__":
    main()
