"""What motions do over a plane of two parameters as a result: saved, printed, drawn."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import combinations
from types import MappingProxyType
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.drawing import draw
from slipfold.errors import InputError
from slipfold.long_term.neighbours import NONE, SAME
from slipfold.long_term.open_motions import CHAOS, PERIODIC, STICKS, TORUS, UNDECIDED
from slipfold.long_term.places import NOT_DONE
from slipfold.models.model import Model
from slipfold.models.turns import without_turns
from slipfold.results.fields import TRUTH, Field, Labels
from slipfold.results.provenance import Provenance
from slipfold.results.result import Result
from slipfold.text.one_line import number_text
from slipfold.text.printed_table import PrintedTable

KNOWN = (PERIODIC, TORUS, CHAOS, STICKS)

CELLS = "run {axes[0]} {axes[1]}"


@dataclass(frozen=True, eq=False, repr=False)
class RegimeMap(Result):
    """What motions do over a plane of two parameters; frozen.

    Made by `slipfold.regimes` and `slipfold.load`. The first axis of its arrays is that of `runs`,
    the others are those of the plane.

    Parameters
    ----------
    model
        The model; its values of the two parameters play no part.
    over
        Values of the two parameters by name, shapes (n1,) and (n2,), increasing.
    runs
        ``"rest"``, motions from the model's start; ``"up"`` and ``"down"``, motions swept along the
        second parameter; then ``"continued 1"`` and so on, motions that none of the runs before has
        in a cell, continued from a cell beside it. Length n_runs.
    kinds
        ``"periodic"``, ``"torus"``, ``"chaos"``, ``"sticks"``, ``"stopped"`` at a limit of the
        model, ``"undecided"`` or ``"not done"``, shape (n_runs, n1, n2); ``"none"`` where a cell
        has no further motion.
    periods
        Periods in forcing periods, shape (n_runs, n1, n2); 0 of what does not repeat, or sticks and
        was followed no further.
    exponents
        Largest Lyapunov exponents, a forcing period each, shape (n_runs, n1, n2), of motions that
        did not repeat soon; else NaN.
    states
        Last states at phase zero, shape (n_runs, n1, n2, n_states).
    means
        Means of the states at phase zero of responses that repeat, shape (n_runs, n1, n2,
        n_states); else NaN.
    transient
        Forcing periods left out in each cell.
    interrupted
        Whether the computation was interrupted.
    provenance
        Versions and time.

    Notes
    -----
    The dataset of `to_xarray` lies along ``run``, the two parameters by their names, and ``state``:
    ``found.to_xarray().sel(f=12.2, method="nearest")``. In the spreadsheet of `to_csv` a cell is a
    row, for each run. In `to_json`, schema slipfold.regimes/1.

    Examples
    --------
    >>> import slipfold as sf
    >>> plane = {"f": (12.2, 12.21), "Nd": (0.06, 0.16)}
    >>> found = sf.regimes(sf.SlidingOscillator(), plane, points=(2, 3))
    >>> found.at(f=12.2, Nd=0.1), found.coexist[0].tolist()
    ({'rest': 'period 2', 'up': 'period 1', 'down': 'period 2'}, [False, True, False])
    """

    schema = "slipfold.regimes/1"

    title = "regimes of {0.model.name} over {0.axes[0]} and {0.axes[1]}"
    rows = CELLS
    recorded = (
        "over", "runs", "kinds", "periods", "exponents", "coexist", "transient", "interrupted",
    )  # fmt: skip
    arrays = MappingProxyType({
        "coexist": Field("{axes[0]} {axes[1]}", "whether different motions coexist", kind=TRUTH),
    })  # fmt: skip

    model: Model
    over: Annotated[Mapping[str, Array], Labels()]
    runs: Annotated[tuple[str, ...], Field("run", "where motions begin", name="run", label=True)]
    kinds: Annotated[
        NDArray[np.str_], Field(CELLS, "what the motion does", name="kind", head="regime")
    ]
    periods: Annotated[
        NDArray[np.int64], Field(CELLS, "period in forcing periods, 0 for none", head="period")
    ]
    exponents: Annotated[
        Array,
        Field(CELLS, "largest Lyapunov exponent, where it was needed", "1/forcing period",
              head="exponent"),
    ]  # fmt: skip
    states: Annotated[Array, Field(f"{CELLS} state", "last state at phase zero", head="")]
    means: Annotated[
        Array,
        Field(f"{CELLS} state", "mean of the states at phase zero of a response that repeats",
              head="mean"),
    ]  # fmt: skip
    transient: int
    interrupted: bool
    provenance: Provenance

    @property
    def axes(self) -> tuple[str, str]:
        """Names of the two parameters."""
        first, second = self.over
        return first, second

    def names(self, run: str) -> NDArray[np.str_]:
        """Return what motions do in words, such as ``"period 2"``.

        Parameters
        ----------
        run
            One of `runs`.

        Returns
        -------
        ndarray, shape (n1, n2)
            What the motion of each cell does.
        """
        place = self._run(run)
        told = np.char.add("period ", self.periods[place].astype(str))
        return np.where(self.kinds[place] == PERIODIC, told, self.kinds[place])

    @property
    def coexist(self) -> NDArray[np.bool_]:
        """Where motions of different runs settle on different things, shape (n1, n2).

        Responses of one period are different where their means are, angles up to whole turns. Two
        tori, or two chaotic motions, or two that stick are not told apart.
        """
        found = np.zeros(self.kinds.shape[1:], bool)
        named = [self.names(run) for run in self.runs]
        known = np.isin(self.kinds, KNOWN)
        scales, turns = self.model.state_scales(), self.model.whole_turns
        for one, other in combinations(range(len(self.runs)), 2):
            both = known[one] & known[other]
            between = without_turns(self.means[one] - self.means[other], turns)
            apart = np.abs(between / scales).max(axis=-1) > SAME
            found |= both & ((named[one] != named[other]) | apart)
        return found

    def at(self, **values: float) -> dict[str, str]:
        """Return what motions do in the cell nearest to a place.

        Parameters
        ----------
        **values
            Values of the two parameters.

        Returns
        -------
        dict
            What the motion of each run does, as far as there is one.

        Raises
        ------
        InputError
            If these are not the parameters of the plane.
        """
        if set(values) != set(self.axes):
            raise InputError(f"{', '.join(values)} is not {' and '.join(self.axes)}; give these")
        first, second = (
            int(np.abs(places - values[name]).argmin()) for name, places in self.over.items()
        )
        found = {run: str(self.names(run)[first, second]) for run in self.runs}
        return {run: name for run, name in found.items() if name != NONE}

    def plot(self, **options: Any) -> Any:
        """Draw the plane: a colour for each regime, hatched where others coexist.

        Parameters
        ----------
        **options
            ``run="rest"`` which motions are colours; ``over=`` a `slipfold.LocusDiagram` of the
            same plane whose lines are drawn over it; ``ax=`` the axes to draw in.

        Returns
        -------
        matplotlib.axes.Axes
            The axes.
        """
        return draw(self, **options)

    def summary(self) -> str:
        """Return how many cells there are of each regime, run by run."""
        spans = [
            f"{name} {number_text(values[0])} to {number_text(values[-1])} "
            f"{self.model.parameter(name).unit}".rstrip()
            for name, values in self.over.items()
        ]
        size = " x ".join(str(len(values)) for values in self.over.values())
        lines = [
            f"{self.model!r}: {', '.join(spans)}, {size} cells",
            *self._rows().text(),
            f"Different regimes or responses in {int(self.coexist.sum())} cells",
        ]
        if self.interrupted:
            lines.append("Interrupted before all motions were done")
        return "\n".join([*lines, *self._remarks()])

    def _run(self, run: str) -> int:
        if run in self.runs:
            return self.runs.index(run)
        raise InputError(f"there is no run {run!r}; there are {', '.join(self.runs)}")

    def _line(self) -> str:
        return f"Regimes of {self.model.name} over {' and '.join(self.axes)}"

    def _rows(self) -> PrintedTable:
        counts = [Counter(self.names(run).ravel().tolist()) for run in self.runs]
        found = sorted({name for each in counts for name in each} - {NONE}, key=_order)
        rows = [
            [run, *(str(each[name]) for name in found)]
            for run, each in zip(self.runs, counts, strict=True)
        ]
        return PrintedTable(["cells", *found], rows)


def _order(name: str) -> tuple[int, int]:
    """Return where a regime stands among others: the quiet ones first."""
    word, _, period = name.partition(" ")
    if word == "period":
        return 0, int(period)
    known = (TORUS, CHAOS, STICKS, "stopped", UNDECIDED, NOT_DONE)
    return 1, known.index(name)
