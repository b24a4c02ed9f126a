"""Points of motions over a parameter as a result: saved, printed, drawn."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.drawing import draw
from slipfold.errors import InputError
from slipfold.long_term.repeats import repeats_of
from slipfold.models.model import Model
from slipfold.results.fields import Field, axis
from slipfold.results.provenance import Provenance
from slipfold.results.result import Result
from slipfold.text.one_line import number_text
from slipfold.text.printed_table import PrintedTable


@dataclass(frozen=True, eq=False, repr=False)
class Sweep(Result):
    """Motions at many values of a parameter, once a forcing period; frozen.

    Made by `slipfold.sweep` and `slipfold.load`.

    Parameters
    ----------
    model
        The model; its value of the parameter plays no part.
    vary
        Name of the parameter.
    values
        Its values, shape (n_values,), increasing.
    runs
        ``"up"`` and ``"down"``, then ``"start 1"`` and so on, length n_runs.
    states
        States at phase zero of successive forcing periods, shape (n_runs, n_values, n_periods,
        n_states); NaN where there are none.
    stuck
        Whether a contact stuck or was open in the last period, shape (n_runs, n_values).
    reasons
        Why there are no points, shape (n_runs, n_values); empty where there are.
    transient
        Forcing periods left out at each value.
    interrupted
        Whether the computation was interrupted.
    provenance
        Versions and time.

    Notes
    -----
    The dataset of `to_xarray` lies along ``run``, a dimension named for the parameter, ``period``
    and ``state``: ``states``, ``stuck`` and ``reason``. In the spreadsheet of `to_csv` a state is a
    row. In `to_json`, schema slipfold.sweep/1.

    Examples
    --------
    >>> import slipfold as sf
    >>> found = sf.sweep(sf.SlidingOscillator(), "Nd", (0.02, 0.04), points=3, starts=0, f=12.5)
    >>> found.states.shape, found.repeats("up").tolist()
    ((2, 3, 64, 4), [1, 1, 1])
    """

    schema = "slipfold.sweep/1"
    title = "sweep of {0.model.name} over {0.vary}"
    rows = "run {vary} period"
    recorded = (
        "vary", "values", "runs", "stuck", "reasons", "states", "transient", "interrupted",
    )  # fmt: skip

    model: Model
    vary: str
    values: Annotated[Array, axis("{vary}")]
    runs: Annotated[tuple[str, ...], Field("run", "sweep or start", name="run", label=True)]
    states: Annotated[
        Array,
        Field("run {vary} period state", "states at phase zero of successive periods", head=""),
    ]
    stuck: Annotated[
        NDArray[np.bool_], Field("run {vary}", "whether a contact stuck in the last period")
    ]
    reasons: Annotated[
        NDArray[np.str_], Field("run {vary}", "why there are no points", name="reason")
    ]
    transient: int
    interrupted: bool
    provenance: Provenance

    def run(self, name: str) -> int:
        """Return the place of a run.

        Parameters
        ----------
        name
            Its name.

        Raises
        ------
        InputError
            If there is none of that name.
        """
        if name in self.runs:
            return self.runs.index(name)
        raise InputError(f"there is no run {name!r}; there are {', '.join(self.runs)}")

    def repeats(self, run: str) -> NDArray[np.int64]:
        """Return after how many forcing periods motions repeat, or will in the long run.

        Parameters
        ----------
        run
            Name of the run.

        Returns
        -------
        ndarray, shape (n_values,)
            The period, 16 at most; 0 where nothing repeats, that is not clear yet, or there are no
            points.
        """
        states, model = self.states[self.run(run)], self.model
        return repeats_of(states, model.state_scales(), model.whole_turns)

    def plot(self, **options: Any) -> Any:
        """Draw the points over the parameter, a section of one value, or spectra over it.

        Parameters
        ----------
        **options
            ``output=`` what to draw; ``kind="points"``, ``"section"`` (states at phase zero at one
            value, ``at=``) or ``"waterfall"`` (amplitudes over frequency and parameter);
            ``runs=`` the runs to draw; ``ax=`` the axes to draw in. Of points ``measure="strobe"``
            at phase zero, or ``"max"``, ``"min"``, ``"peak_to_peak"``, ``"modulus"`` as in response
            diagrams: of the whole response where it repeats, else of each forcing period.

        Returns
        -------
        matplotlib.axes.Axes
            The axes.
        """
        return draw(self, **options)

    def summary(self) -> str:
        """Return how many motions repeat after how many periods, run by run."""
        first, last = self.values[0], self.values[-1]
        unit = self.model.parameter(self.vary).unit
        span = f"{self.vary} {number_text(first)} to {number_text(last)} {unit}".rstrip()
        kept = self.states.shape[2]
        lines = [
            f"{self.model!r}: {span}, {len(self.values)} values, {kept} periods after "
            f"{self.transient}",
            *self._rows().text(),
        ]
        if self.interrupted:
            lines.append("Interrupted before all motions were done")
        return "\n".join([*lines, *self._remarks()])

    def _line(self) -> str:
        return f"Sweep of {self.model.name} over {self.vary}: {len(self.runs)} runs"

    def _rows(self) -> PrintedTable:
        rows = []
        for place, name in enumerate(self.runs):
            ended = self.reasons[place] != ""
            counts = Counter(self.repeats(name)[~ended].tolist())
            told = [f"{counts[each]} x {each}" for each in sorted(counts) if each]
            missing = Counter(self.reasons[place][ended].tolist()).most_common(1)
            why = f"{int(ended.sum())}: {missing[0][0]}" if missing else ""
            rows.append(
                [name, ", ".join(told), str(counts[0]), str(int(self.stuck[place].sum())), why]
            )
        heads = ["", "repeat (values x period)", "do not repeat", "stick", "without points"]
        return PrintedTable(heads, rows, words=(heads[1], heads[4]))

    def _record(self) -> dict[str, Any]:
        repeats = [self.repeats(run) for run in self.runs]
        return {**super()._record(), "repeats": repeats}
