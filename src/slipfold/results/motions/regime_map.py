"""What motions do over a plane of two parameters as a result: saved, printed, drawn."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from itertools import combinations
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slipfold.drawing import draw
from slipfold.errors import InputError
from slipfold.long_term.neighbours import NONE, SAME
from slipfold.long_term.open_motions import CHAOS, PERIODIC, STICKS, TORUS, UNDECIDED
from slipfold.long_term.places import NOT_DONE
from slipfold.models.model import Model
from slipfold.models.turns import without_turns
from slipfold.read_only import ReadOnly
from slipfold.results.column import TEXT, TRUTH, WHOLE, Column
from slipfold.results.labelled_table import Variable
from slipfold.results.provenance import Provenance
from slipfold.results.result import Result
from slipfold.results.saved_table import SavedTable
from slipfold.results.sheet import Sheet
from slipfold.results.table import Table, axes_of, names
from slipfold.results.threshold_map import column_name
from slipfold.text.one_line import OneLine, headed, number_text
from slipfold.text.printed_table import PrintedTable

__all__ = ["RegimeMap"]

Array = NDArray[np.float64]

KNOWN = (PERIODIC, TORUS, CHAOS, STICKS)

ROWS = Table(("run",), (Column("runs", TEXT, "where motions begin", name="run", label=True),),
             joined=True)  # fmt: skip

CELLS = (
    Column("kinds", TEXT, "what the motion does", name="kind"),
    Column("periods", WHOLE, "period in forcing periods, 0 for none", ""),
    Column("exponents", meaning="largest Lyapunov exponent, where it was needed",
           unit="1/forcing period", optional=True),
    Column("states", meaning="last state at phase zero", dimensions=("state",), optional=True),
    Column("means", meaning="mean of the states at phase zero of a response that repeats",
           dimensions=("state",), optional=True),
)  # fmt: skip

COEXIST = Column("coexist", TRUTH, "whether different motions coexist", derived=True)


def _axis(model: Model, name: str) -> Table:
    item, dimension = model.parameter(name), column_name(name)
    column = Column(
        "values", meaning=item.doc or name, unit=item.unit, name=dimension, label=True,
        get=lambda values: values,
    )  # fmt: skip
    return Table((dimension,), (column,), joined=True)


def _cells(over: Iterable[str]) -> tuple[Table, Table]:
    """Return what is known of each motion, and of each cell."""
    first, second = (column_name(name) for name in over)
    motions = Table(("run", first, second), CELLS, joined=True)
    return motions, Table((first, second), (COEXIST,), joined=True)


@dataclass(frozen=True, eq=False, repr=False)
class RegimeMap(OneLine, ReadOnly, Result):
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

    model: Model
    over: Mapping[str, Array]
    runs: tuple[str, ...]
    kinds: NDArray[np.str_]
    periods: NDArray[np.int64]
    exponents: Array
    states: Array
    means: Array
    transient: int
    interrupted: bool
    provenance: Provenance

    def __post_init__(self) -> None:
        """Lock the arrays, and the mapping of parameters."""
        object.__setattr__(self, "over", MappingProxyType(dict(self.over)))
        super().__post_init__()

    def __getstate__(self) -> dict[str, Any]:
        """Give what can be copied and sent to other processes: read-only mappings cannot."""
        return {**vars(self), "over": dict(self.over)}

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Lock it again."""
        vars(self).update(state)
        self.__post_init__()

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

    def _title(self) -> str:
        return f"regimes of {self.model.name} over {' and '.join(self.axes)}"

    def _given(self) -> dict[str, Any]:
        return {"over": list(self.axes), "transient": self.transient}

    def _attributes(self) -> dict[str, Any]:
        return {"over": " ".join(self.axes), "interrupted": int(self.interrupted)}

    def _variables(self) -> dict[str, Variable]:
        axes = axes_of(self.model)
        found = names("state", self.model.states) | ROWS.variables([self], axes)
        for name, values in self.over.items():
            found |= _axis(self.model, name).variables([values], {})
        motions, cells = _cells(self.over)
        return found | motions.variables([self], axes) | cells.variables([self], axes)

    def _record(self) -> dict[str, Any]:
        return {
            "over": self.over,
            "runs": self.runs,
            "kinds": self.kinds,
            "periods": self.periods,
            "exponents": self.exponents,
            "coexist": self.coexist,
            "transient": self.transient,
            "interrupted": self.interrupted,
        }

    def _csv(self) -> str:
        heads = {"run": "run"}
        heads |= {
            dimension: headed(self.model.parameter(name))
            for dimension, name in zip(("first", "second"), self.axes, strict=True)
        }
        heads |= {"kinds": "regime", "periods": "period", "exponents": "exponent", "states": ""}
        places = np.indices(self.kinds.shape).reshape(3, -1)
        first, second = self.over.values()
        known = {
            "run": [self.runs[place] for place in places[0]],
            "first": first[places[1]].tolist(),
            "second": second[places[2]].tolist(),
        }
        motions, _ = _cells(self.over)
        sheet = Sheet(heads, (motions,), axes_of(self.model))
        return sheet.text(sheet.rows(motions, [self], known))

    @classmethod
    def _read(cls, saved: SavedTable) -> RegimeMap:
        model, given = saved.model, saved.given
        runs = ROWS.read(saved, {}, ...)["runs"].tolist()
        axes: dict[str, Any] = dict(axes_of(model)) | {"run": runs}
        over = {}
        for name in given["over"]:
            values = _axis(model, name).read(saved, {}, ...)["values"]
            over[model.parameter(name).name] = axes[column_name(name)] = values
        return cls(
            model=model,
            over=over,
            runs=tuple(runs),
            transient=int(given["transient"]),
            interrupted=bool(saved.attributes["interrupted"]),
            provenance=saved.provenance,
            **_cells(over)[0].read(saved, axes, ...),
        )


def _order(name: str) -> tuple[int, int]:
    """Return where a regime stands among others: the quiet ones first."""
    word, _, period = name.partition(" ")
    if word == "period":
        return 0, int(period)
    known = (TORUS, CHAOS, STICKS, "stopped", UNDECIDED, NOT_DONE)
    return 1, known.index(name)
