"""A map of thresholds as a result: labelled, printed, saved, exported and drawn."""

from __future__ import annotations

from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from slipfold.checks.checked import Checked
from slipfold.drawing import draw
from slipfold.results.fields import Field, Labels
from slipfold.results.provenance import Provenance
from slipfold.results.result import Result
from slipfold.results.threshold_summary import threshold_html, threshold_summary
from slipfold.thresholds.threshold_map import GridThresholds

GRID = "{axes[0]} {axes[1]}"


@dataclass(frozen=True, eq=False, repr=False)
class ThresholdMap(GridThresholds, Result):
    """Where the response of period 1 first loses its stability, over two parameters; frozen.

    Made by `slipfold.threshold_map` and `slipfold.load`. Every array has the grid's two axes first.
    Where there is no threshold, `kinds` and `reasons` say why, and the numbers are NaN.

    Parameters
    ----------
    model
        The model; its values of `threshold` and of the grid's parameters play no part.
    threshold
        Name of the parameter that is raised until stability is lost.
    type
        ``"PD"``: the bifurcation by which it is lost.
    over
        Values of the grid's two parameters by name, shapes (n1,) and (n2,).
    span
        First and last value of the threshold.
    values
        Thresholds, shape (n1, n2), in the unit of the parameter; NaN where there is none.
    states
        States of the orbits there at phase zero, shape (n1, n2, n_states).
    multipliers
        Their Floquet multipliers, complex, shape (n1, n2, n_states), largest modulus first.
    residuals
        How far each orbit fails to close, in scaled states, shape (n1, n2).
    kinds
        Why there is no threshold, in a few words, shape (n1, n2); empty where there is one.
    reasons
        The same as sentences.
    followed
        Whether the whole response was followed at this point, shape (n1, n2). Elsewhere the
        threshold was corrected from a guess, and the response below it checked at four places.
    provenance
        Versions and time.
    checked
        Thresholds that were computed again by other means; None if nothing was.

    Notes
    -----
    The dataset of `to_xarray` lies along the two parameters of the grid, which label it, so that
    ``dataset.Nd.sel(Vd=0.6, alpha=1.0)`` is a threshold; further along ``state`` and
    ``multiplier``. In the spreadsheet of `to_csv`, one row a point of the grid. In `to_json`,
    schema slipfold.threshold_map/1, thresholds and failures, a list for each value of the first
    parameter.

    Examples
    --------
    >>> import slipfold as sf
    >>> over = {"Vd": [0.4, 0.6, 1.0], "alpha": ["60deg"]}
    >>> found = sf.threshold_map(sf.SlidingOscillator(), "Nd", over=over, span=(0, "50mN"))
    >>> found.values[:, 0].round(8).tolist(), found.failures
    ([nan, 0.04357891, 0.03429776], {'no PD in the span': 1})
    """

    schema = "slipfold.threshold_map/1"
    title = "first {0.type} of {0.model.name} in {0.threshold} over {0.axes[0]} and {0.axes[1]}"
    rows = GRID
    recorded = (
        "threshold", "type", "over", "span", "interrupted", "failures", "values", "kinds",
        "reasons",
    )  # fmt: skip
    arrays = MappingProxyType({
        "over": Labels(),
        "values": Field(GRID, "{threshold}", "{threshold}", name="{threshold}"),
        "states": Field(f"{GRID} state", "state at phase zero", head=""),
        "multipliers": Field(f"{GRID} multiplier", "Floquet multipliers", head="multiplier"),
        "residuals": Field(GRID, "how far the orbit fails to close, in scaled states",
                           name="residual"),
        "kinds": Field(GRID, "why there is no threshold, in a few words", name="kind",
                       head="no threshold"),
        "reasons": Field(GRID, "why there is no threshold", name="reason"),
        "followed": Field(GRID, "whether the whole response was followed here"),
    })  # fmt: skip

    provenance: Provenance
    checked: Checked | None = None

    def summary(self) -> str:
        """Return how many thresholds were found, their range, and why points have none."""
        return threshold_summary(self, self._remarks())

    def plot(self, **options: Any) -> Any:
        """Draw the thresholds as colours over the plane of the grid's parameters.

        Parameters
        ----------
        **options
            Options of the drawing, e.g. ``contours=False`` and ``ax=`` the axes to draw in.

        Returns
        -------
        matplotlib.axes.Axes
            The axes.
        """
        return draw(self, **options)

    def _repr_html_(self) -> str:
        return threshold_html(self, self._remarks())
