"""Lyapunov exponents, sweeps and maps of regimes as results."""

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
from slipfold.errors import InputError, index_of
from slipfold.long_term.classification import (
    CHAOS,
    CLASSIFICATION,
    NOT_DONE,
    PERIODIC,
    STICKS,
    TORUS,
    UNDECIDED,
    repeats_of,
)
from slipfold.long_term.exponents import Classification, ExponentEstimate
from slipfold.long_term.regimes import NONE
from slipfold.models.angles import distances
from slipfold.models.model import Model
from slipfold.models.quantities import DURATION
from slipfold.results.fields import REAL, TRUTH, WHOLE, Column, Entry, Items, Labels, axis
from slipfold.results.records import Provenance
from slipfold.results.result import PerPeriod, Result
from slipfold.text import PrintedTable, capitalized, parameter_text


@dataclass(frozen=True, eq=False, repr=False)
class LyapunovExponents(PerPeriod, Result):
    """Lyapunov exponents of a trajectory, and its classification by them; frozen.

    Made by `slipfold.lyapunov` and `slipfold.load`.
    """

    schema = "slipfold.lyapunov/1"
    row = "an estimate"

    title = "Lyapunov exponents of {0.model.name}"
    rows = "estimate"
    recorded = ("exponents", "errors", "per", "dimension", "periods", "state", "interrupted")

    model: Model
    estimates: Annotated[
        tuple[ExponentEstimate, ...],
        Items("estimate", (
            Column("periods", WHOLE, "forcing periods, or intervals of the duration, since the "
                   "start", "", label=True),
            Column("exponents", REAL, "Lyapunov exponents, the largest first", "1/{per}",
                   ("exponent",), head="exponent"),
            Column("errors", REAL, "estimated errors of the exponents", "1/{per}", ("exponent",),
                   head="error"),
        ), kind=ExponentEstimate,
           doc="Exponents with their errors after more and more periods; the last ones count."),
    ]  # fmt: skip
    classification: Annotated[
        Classification,
        "Its classification: ``kind`` is periodic, torus, chaos, equilibrium or undecided; with "
        "its sentence, and the period, duration, rotation number or resonance.",
    ]
    start: Annotated[Array, Entry("state", "first state of the trajectory")]
    state: Annotated[Array, Entry("state", "last state of the trajectory", name="last")]
    tolerance: Annotated[float, "Error of the exponents at which the computation ends."]
    requested: int | None
    interrupted: bool
    provenance: Provenance

    @property
    def exponents(self) -> Array:
        """The exponents, the largest first, in 1/forcing period or 1/s, shape (n_states,).

        Minus infinity where stick takes perturbations away.
        """
        return self.estimates[-1].exponents

    @property
    def errors(self) -> Array:
        """Estimated errors of the exponents, in their unit, shape (n_states,).

        Infinite where perturbations decay to rounding: the exponent is an upper bound.
        """
        return self.estimates[-1].errors

    @property
    def periods(self) -> int:
        """Length in forcing periods; of an autonomous model in intervals of its ``duration``."""
        return self.estimates[-1].periods

    @property
    def dimension(self) -> float:
        """Dimension of the attractor, by the conjecture of Kaplan and Yorke (1979).

        That of a periodic response at its discrete phases is 0.
        """
        zero = np.isfinite(self.errors) & (np.abs(self.exponents) <= self.errors)
        sums = np.cumsum(np.where(zero, 0.0, self.exponents))
        whole = int((sums >= 0).sum()) if sums[0] >= 0 else 0
        if whole in (0, len(sums)):
            return float(whole)
        return float(whole + sums[whole - 1] / abs(self.exponents[whole]))

    def _head(self) -> str:
        message, model = self.classification.message, self.model
        length = f"{self.periods} forcing periods"
        if not model.forced:
            length = f"{self.periods * model.values[DURATION.name]:.6g} s"
            model = model.replace(**{DURATION.name: DURATION.default})
        classification = capitalized(message, (*model.parameters, *model.states))
        return f"{model!r} over {length}\n{classification}"

    def _notes(self) -> list[str]:
        requested = (
            "its exponents were known" if self.requested is None else "all periods were done"
        )
        return [f"Interrupted before {requested}"] if self.interrupted else []

    def _line(self) -> str:
        return f"Lyapunov exponents of {self.model.name}: {self.classification.message}"

    def _rows(self) -> PrintedTable:
        # Those of a small error have more digits.
        rows = [
            [f"{exponent:.{4 if error > 1e-5 else 9}g}" if exponent else "0", f"{error:.0e}"]
            for exponent, error in zip(self.exponents, self.errors, strict=True)
        ]
        return PrintedTable([f"exponent (1/{self.per})", "error"], rows)

    def _record(self) -> dict[str, Any]:
        classification = self.classification
        outcome = {
            "classification": classification.kind,
            "message": classification.message,
            "initial_state": self.start,
        }
        repeats: dict[str, Any] = {
            "period": classification.period,
            "duration": classification.duration,
        }
        repeats |= {"rotation": classification.rotation, "resonance": classification.resonance}
        return {**super()._record(), **outcome, **repeats}


KNOWN = (PERIODIC, TORUS, CHAOS, STICKS)

UNFINISHED = "Interrupted before all trajectories were done"

RUNS = (
    "``rest``, from the model's start; ``up`` and ``down``, swept along the second parameter; "
    "``continued 1`` and so on, trajectories that none of the runs before has in a cell, continued "
    "from a neighboring cell"
)
KINDS_OF_MOTION = (
    "``periodic``, ``torus``, ``chaos``, ``sticks`` where a contact sticks or is open at the end, "
    "be it periodic or not, ``stopped`` at a limit of the model, ``undecided``, ``not done``, or "
    "``none`` where a cell has no further trajectory"
)

CELLS = "run {axes[0]} {axes[1]}"


@dataclass(frozen=True, eq=False, repr=False)
class RegimeMap(Result):
    """Regimes of trajectories over a plane of two parameters; frozen.

    Made by `slipfold.regimes` and `slipfold.load`. The first axis of its arrays is that of `runs`,
    the others are those of the plane.

    Notes
    -----
    Selecting is ``found.to_xarray().sel(f=12.2, method="nearest")``. `plot` draws a color for each
    regime of the trajectories of ``run="rest"``, hatched where others coexist, and over it the
    lines of ``over=`` a `slipfold.LocusDiagram` of the same plane.
    """

    schema = "slipfold.regimes/1"
    row = "a cell, for each run"

    title = "regimes of {0.model.name} over {0.axes[0]} and {0.axes[1]}"
    rows = CELLS
    recorded = (
        "over", "runs", "kinds", "periods", "exponents", "coexist", "transient", "interrupted",
    )  # fmt: skip
    arrays = MappingProxyType({
        "coexist": Entry("{axes[0]} {axes[1]}", "whether different attractors coexist", kind=TRUTH),
    })  # fmt: skip

    model: Model
    over: Annotated[Mapping[str, Array], Labels()]
    runs: Annotated[
        tuple[str, ...], Entry("run", "where trajectories begin", name="run", label=True, more=RUNS)
    ]
    kinds: Annotated[
        NDArray[np.str_],
        Entry(CELLS, "what the trajectory does", name="kind", head="regime", more=KINDS_OF_MOTION),
    ]
    periods: Annotated[
        NDArray[np.int64], Entry(CELLS, "period in forcing periods, 0 for none", head="period")
    ]
    exponents: Annotated[
        Array,
        Entry(CELLS, "largest Lyapunov exponent, where it was needed", "1/forcing period",
              head="exponent"),
    ]  # fmt: skip
    states: Annotated[Array, Entry(f"{CELLS} state", "last state at phase zero", head="")]
    means: Annotated[
        Array,
        Entry(f"{CELLS} state", "mean of the states at phase zero of a response that repeats",
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
        """Return the regimes of all cells in words, such as ``"period 2"``, shape (n1, n2).

        Parameters
        ----------
        run
            One of `runs`.
        """
        place = index_of(run, self.runs, "run")
        names = np.char.add("period ", self.periods[place].astype(str))
        return np.where(self.kinds[place] == PERIODIC, names, self.kinds[place])

    @property
    def coexist(self) -> NDArray[np.bool_]:
        """Where trajectories of different runs converge to different attractors, shape (n1, n2).

        Responses of one period are different where their means are, angles up to revolutions. Two
        tori, or two chaotic trajectories, or two that stick, are not distinguished.
        """
        result = np.zeros(self.kinds.shape[1:], bool)
        named = [self.names(run) for run in self.runs]
        known = np.isin(self.kinds, KNOWN)
        for one, other in combinations(range(len(self.runs)), 2):
            both = known[one] & known[other]
            apart = distances(self.model, self.means[one], self.means[other])
            differ = (named[one] != named[other]) | (apart > CLASSIFICATION.same_mean)
            result |= both & differ
        return result

    def at(self, **values: float) -> dict[str, str]:
        """Return the regimes in the cell nearest to a point.

        Parameters
        ----------
        **values
            Values of the two parameters.

        Returns
        -------
        dict
            What the trajectory of each run does, as far as there is one.
        """
        if set(values) != set(self.axes):
            raise InputError(f"{', '.join(values)} is not {' and '.join(self.axes)}; give these")
        first, second = (
            int(np.abs(places - values[name]).argmin()) for name, places in self.over.items()
        )
        result = {run: str(self.names(run)[first, second]) for run in self.runs}
        return {run: name for run, name in result.items() if name != NONE}

    def _head(self) -> str:
        spans = [
            parameter_text(self.model.parameter(name), values[0], values[-1])
            for name, values in self.over.items()
        ]
        size = " x ".join(str(len(values)) for values in self.over.values())
        return f"{self.model!r}: {', '.join(spans)}, {size} cells"

    def _notes(self) -> list[str]:
        result = [f"Different regimes or responses in {int(self.coexist.sum())} cells"]
        return result + [UNFINISHED] * self.interrupted

    def _rows(self) -> PrintedTable:
        counts = [Counter(self.names(run).ravel().tolist()) for run in self.runs]
        result = sorted({name for each in counts for name in each} - {NONE}, key=_order)
        rows = [
            [run, *(str(each[name]) for name in result)]
            for run, each in zip(self.runs, counts, strict=True)
        ]
        return PrintedTable(["cells", *result], rows)


def _order(name: str) -> tuple[int, int]:
    """Return the rank of a regime: short periods first."""
    word, _, period = name.partition(" ")
    if word == "period":
        return 0, int(period)
    known = (TORUS, CHAOS, STICKS, "stopped", UNDECIDED, NOT_DONE)
    return 1, known.index(name)


@dataclass(frozen=True, eq=False, repr=False)
class Sweep(Result):
    """Trajectories at many values of a parameter, once a forcing period; frozen.

    Made by `slipfold.sweep` and `slipfold.load`.

    Notes
    -----
    `plot` draws ``kind="points"`` or ``"section"``, the states at phase zero at one value ``at=``,
    of ``runs=``, or ``"waterfall"``, amplitudes over frequency and parameter, of one ``run=``, the
    first if none is given. Of points ``measure="stroboscopic"`` at phase zero, or ``"max"``,
    ``"min"``, ``"peak_to_peak"`` and ``"modulus"`` as in response diagrams: of the whole response
    where it repeats, else of each forcing period.
    """

    schema = "slipfold.sweep/1"
    row = "a state"
    title = "sweep of {0.model.name} over {0.vary}"
    rows = "run {vary} period"
    recorded = (
        "vary", "values", "runs", "stuck", "reasons", "states", "transient", "interrupted",
    )  # fmt: skip

    model: Model
    vary: str
    values: Annotated[Array, axis("{vary}")]
    runs: Annotated[
        tuple[str, ...],
        Entry(
            "run",
            "sweep or start",
            name="run",
            label=True,
            more="``up``, ``down``, ``start 1`` and so on",
        ),
    ]
    states: Annotated[
        Array,
        Entry(
            "run {vary} period state",
            "states at phase zero of successive periods",
            head="",
            more="NaN where there are none",
        ),
    ]
    stuck: Annotated[
        NDArray[np.bool_],
        Entry("run {vary}", "whether a contact stuck or was open in the last period"),
    ]
    reasons: Annotated[
        NDArray[np.str_], Entry("run {vary}", "why there are no points", name="reason")
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
        """
        return index_of(name, self.runs, "run")

    def repeats(self, run: str) -> NDArray[np.int64]:
        """Return the periods of trajectories in forcing periods, if necessary extrapolated.

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
        return repeats_of(self.model, self.states[self.run(run)])

    def _head(self) -> str:
        ends = self.values[0], self.values[-1]
        span = parameter_text(self.model.parameter(self.vary), *ends)
        kept = self.states.shape[2]
        return (
            f"{self.model!r}: {span}, {len(self.values)} values, {kept} periods after "
            f"{self.transient}"
        )

    def _notes(self) -> list[str]:
        return [UNFINISHED] * self.interrupted

    def _rows(self) -> PrintedTable:
        rows = []
        for index, name in enumerate(self.runs):
            ended = self.reasons[index] != ""
            counts = Counter(self.repeats(name)[~ended].tolist())
            parts = [f"{counts[each]} x {each}" for each in sorted(counts) if each]
            missing = Counter(self.reasons[index][ended].tolist()).most_common(1)
            why = f"{int(ended.sum())}: {missing[0][0]}" if missing else ""
            rows.append(
                [name, ", ".join(parts), str(counts[0]), str(int(self.stuck[index].sum())), why]
            )
        heads = ["", "repeat (values x period)", "do not repeat", "stick or open", "without points"]
        return PrintedTable(heads, rows, words=(heads[1], heads[4]))

    def _record(self) -> dict[str, Any]:
        repeats = [self.repeats(run) for run in self.runs]
        return {**super()._record(), "repeats": repeats}
