"""A periodic orbit as collocation finds it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from slipfold.models.model import Model
from slipfold.read_only import ReadOnly
from slipfold.text.one_line import OneLine, number_text
from slipfold.text.printed_table import PrintedTable
from slipfold.text.stability import multipliers_text


@dataclass(frozen=True, eq=False, repr=False)
class CollocatedOrbit(OneLine, ReadOnly):
    """A periodic orbit by piecewise polynomials; frozen.

    Parameters
    ----------
    model
        The model; of a cycle, its ``duration`` is that of the guess.
    period
        Period in forcing periods, or rounds of a cycle.
    edges
        Phases at which the N intervals begin and end, shape (N + 1,).
    states
        States at the beginning of each interval, shape (N, n_states).
    anchors
        States at `period` * j / M, shape (M, n_states).
    duration
        Duration of the whole orbit in seconds.
    multipliers
        Floquet multipliers, largest modulus first, shape (n_states,); the one of a cycle's own
        direction stands where the modulus falls below one.
    mismatch
        Largest violation of a collocation equation, in scaled states.
    error
        How much states at the edges (in scaled states), duration and multipliers (relative to the
        larger of one and the largest) differ from those on a mesh of half as many intervals. Their
        own error is smaller. Infinite where Newton's method did not converge.
    converged
        Whether that is within the tolerance.
    """

    model: Model
    period: int
    edges: NDArray[np.float64]
    states: NDArray[np.float64]
    anchors: NDArray[np.float64]
    duration: float
    multipliers: NDArray[np.complex128]
    mismatch: float
    error: float
    converged: bool

    def _line(self) -> str:
        verdict = "" if self.converged else "not "
        return (
            f"CollocatedOrbit of {self.model.name}: period {self.period}, "
            f"{len(self.edges) - 1} intervals, {verdict}converged, "
            f"{multipliers_text(self.multipliers, cycle=not self.model.forced)}"
        )

    def _rows(self) -> PrintedTable:
        facts = {"duration (s)": self.duration, "mismatch": self.mismatch, "error": self.error}
        return PrintedTable(["", ""], [[name, number_text(v)] for name, v in facts.items()])
