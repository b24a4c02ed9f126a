"""Basins of attraction on a plane as a result: saved, printed, drawn."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.drawing import draw
from slipfold.long_term.basin_boundaries import WITHIN_CELL, WITHIN_ERROR
from slipfold.models.parameter import State
from slipfold.results.fields import Field, axis
from slipfold.results.motions.found_attractors import REACHED, FoundAttractors, in_words
from slipfold.text.one_line import listed, number_text

PHASE = State("phase", "forcing period", "phase of the forcing at which the start is released")
"""The axis of a plane that is none of the states."""


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Basins(FoundAttractors):
    """Which attractor the motion from each state of a plane comes to; frozen.

    Made by `slipfold.basins` and `slipfold.load`. It is a sequence of `slipfold.Attractor`.

    Parameters
    ----------
    model
        The model with its parameter values.
    plane
        Names of the two states that span the plane; one may be ``"phase"``, at which starts are
        released.
    first, second
        Their values, shapes (n_first,) and (n_second,).
    state
        Starting state whose other components all starts have, shape (n_states,).
    labels
        Number of the attractor that each start came to, shape (n_second, n_first); 0 where that is
        undecided, -1 where the motion ended before, -2 where it was not finished.
    uncertain
        Whether a label stands for its cell, shape (n_second, n_first): 0 where motions from its
        corners have the same label, 1 where one of them has another, so that a boundary passes; 2
        where the label changes if the start is moved by the error of the integration.
    attractors
        What was found, each verified.
    ends
        How many motions ended before they came to anything, by the limit of the model they met.
    asked
        Periods that were asked for; None if none were.
    interrupted
        Whether the computation was interrupted.
    provenance
        Versions and time.

    Notes
    -----
    In the dataset of `to_xarray`, along ``attractor``: as of `slipfold.Attractors`; ``reached`` and
    ``uncertain`` along the two states by their names, ``found.to_xarray().sel(x=0, vy=1,
    method="nearest")``; ``starting_state``. In the spreadsheet of `to_csv` a start is a row. In
    `to_json`, schema slipfold.basins/1.

    Examples
    --------
    >>> import slipfold as sf
    >>> duffing = sf.built_in_models()["duffing"](W=1.2)
    >>> found = sf.basins(duffing, {"q": (-4, 4), "v": (-4, 4)}, points=16)
    >>> len(found), bool(sum(found.share(item).value for item in found) == 1)
    (2, True)
    """

    schema = "slipfold.basins/1"

    title = "basins of attraction of {0.model.name} in {0.plane[0]} and {0.plane[1]}"
    rows = "{axes[0]} {axes[1]}"
    recorded = ("plane", "first", "second", "state", "labels", "uncertain")

    plane: tuple[str, str]
    first: Annotated[Array, axis("{axes[0]}")]
    second: Annotated[Array, axis("{axes[1]}")]
    state: Annotated[
        Array,
        Field("state", "starting state whose other components all starts have",
              name="starting_state"),
    ]  # fmt: skip
    labels: Annotated[NDArray[np.int64], Field("{axes[1]} {axes[0]}", REACHED, name="reached")]
    uncertain: Annotated[
        NDArray[np.int64],
        Field("{axes[1]} {axes[0]}", "whether the label changes: 0 no, 1 within the cell, 2 within "
              "the error of the integration"),
    ]  # fmt: skip

    def uncertain_share(self, least: int = WITHIN_CELL) -> float:
        """Return the share of the cells whose label does not stand for the cell.

        Parameters
        ----------
        least
            1 for all cells in which the label changes, 2 for those where it changes within the
            error of the integration.

        Returns
        -------
        float
            The share, from 0 to 1.
        """
        return float((self.uncertain >= least).mean())

    def summary(self) -> str:
        """Return what was found, with shares of the plane, and what came to nothing."""
        ends = [
            f"{name} {number_text(values[0])} to {number_text(values[-1])}"
            for name, values in zip(self.plane, (self.first, self.second), strict=True)
        ]
        others = [
            f"{state.name} = {number_text(value)}"
            for state, value in zip(self.model.states, self.state, strict=True)
            if state.name not in self.plane
        ]
        grid = f"{len(self.first)} x {len(self.second)} starts"
        at = f" at {listed(others)}" if others else ""
        head = f"{self.model!r} from {grid}: {listed(ends)}{at}"
        lines = [*self._rows().text(), *self._rest(), *self._boundaries(), *self._remarks()]
        return "\n".join([head, *lines])

    def _boundaries(self) -> list[str]:
        """Return in how many cells the label changes."""
        within, error = map(self.uncertain_share, (WITHIN_CELL, WITHIN_ERROR))
        found = [f"Uncertain: the label changes within {100 * within:.3g} % of the cells"]
        if error:
            found.append(
                f"Of {100 * error:.3g} % it changes within the error of the integration: there the "
                "boundary is too fine to know it"
            )
        return found if within else ["The label changes within no cell"]

    def plot(self, **options: Any) -> Any:
        """Draw the plane, a colour for each attractor.

        Parameters
        ----------
        **options
            Options of the drawing, e.g. ``legend=False`` and ``ax=`` the axes to draw in.

        Returns
        -------
        matplotlib.axes.Axes
            The axes.
        """
        return draw(self, **options)

    def _line(self) -> str:
        found = listed(f"{in_words(item)} {self.share(item).value:.3f}" for item in self)
        return f"Basins of {self.model.name} in {' and '.join(self.plane)}: {found or 'none'}"

    @property
    def axes(self) -> tuple[State, State]:
        """What spans the plane, with its units."""
        known = {state.name: state for state in (PHASE, *self.model.states)}
        first, second = (known[name] for name in self.plane)
        return first, second
