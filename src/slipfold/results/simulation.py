"""A simulated trajectory as a result."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from functools import cached_property
from html import escape
from types import MappingProxyType
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.flow.guarded_flow import GuardStop
from slipfold.flow.hybrid_trajectory import Interval
from slipfold.flow.modes import Status, contacts_of
from slipfold.flow.settlement import Settlement
from slipfold.flow.trajectory import LastRound, PerPeriod, Sticking, Trajectory, last_round
from slipfold.models.quantities import DURATION
from slipfold.results.checks.checked import Checked
from slipfold.results.fields import REAL, TEXT, WHOLE, Column, Entry, Items, Nested
from slipfold.results.records import Provenance
from slipfold.results.result import Result
from slipfold.results.tables import Frame
from slipfold.text import PrintedTable, capitalized

if TYPE_CHECKING:
    from slipfold.long_term.spectrum import Spectrum

WORDS = {
    Status.STICK: "stick", Status.FORTH: "slip", Status.BACK: "slip backwards", Status.OPEN: "open",
}  # fmt: skip

LISTED = 4
"""Intervals of stick that a summary lists of each contact."""

INTERVALS = Items("interval", (
    Column("contact", TEXT, "contact that does one thing in an interval"),
    Column("state", TEXT, "what it does: slip, stick or free"),
    Column("begin", REAL, "begin of the interval, {_clock}", "{_clock_unit}"),
    Column("end", REAL, "end of the interval, {_clock}", "{_clock_unit}"),
    Column("work", REAL, "work of friction on the structure", "J"),
    Column("heat", REAL, "heat from friction", "J"),
), "interval_", Interval)  # fmt: skip

STICKING = Nested(Sticking, {
    "contacts": Entry("contact", "name of the contact", name="contact", label=True),
    "modes": Entry("sample contact", "what contacts do: 0 stick, 1 slip, -1 slip backwards, 2 open",
                   "", head=None),
    "intervals": INTERVALS,
}, "Status of the contacts; None if the trajectory never sticks.")  # fmt: skip


def stick_record(last: LastRound) -> dict[str, Any]:
    """Return a record of the intervals in which contacts stick."""
    return {
        "fraction": last.fraction,
        "count": len(last.sticking),
        "intervals": [
            {"contact": item.contact, "from": item.begin, "to": item.end} for item in last.sticking
        ],
    }


def stick_columns(sticking: Sticking | None) -> dict[str, list[str]]:
    """Return the status of each contact at the start of every forcing period, in words."""
    if sticking is None:
        return {}
    return {
        name: [WORDS[Status(int(value))] for value in sticking.modes[:, index]]
        for index, name in enumerate(sticking.contacts)
    }


def stick_text(last: LastRound, unit: str) -> str:
    """Return when contacts stick, counted from the start of the round."""
    names = dict.fromkeys(item.contact for item in last.sticking)
    parts = []
    for name in names:
        own = [item for item in last.sticking if item.contact == name]
        spans = [f"{item.begin:.6g} to {item.end:.6g}" for item in own[:LISTED]]
        more = f" and {len(own) - LISTED} more intervals" if len(own) > LISTED else ""
        parts.append(f"{name} from {', '.join(spans)}{more}")
    return f"{'; '.join(parts)} ({unit} from its start)"


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Simulation(Trajectory, Result):
    """A trajectory over many forcing periods, with its input; frozen.

    Made by `slipfold.simulate` and `slipfold.load`.

    Notes
    -----
    `plot` draws ``kind="timeseries"`` of an output, from period ``start=`` to ``stop=``, where more
    than 200 vibrations become the band between their extrema, its ``"spectrum"`` or ``"phase"``. Of
    contacts with exact friction, in the last ``rounds=``, of all or one ``contact=``:
    ``"hysteresis"``, friction over displacement; ``"friction"``, over the velocity of the moving
    surface relative to the body; ``"path"``, where a contact in a plane goes, and ``"track"``,
    where on the moving surface; ``"timeline"``, when contacts stick, slip and are open.
    """

    schema = "slipfold.simulation/1"
    row = "the start of a forcing period"
    title = "simulation of {0.model.name}"
    rows = "sample"
    arrays = MappingProxyType({
        "_count": Entry("sample", "forcing periods, or intervals of the duration, since the start",
                        "", WHOLE, "sample", label=True, head=None),
        "time": Entry("sample", "time since the start", "s", label=True),
        "states": Entry("sample state", "state, at phase zero of the forcing",
                        head=""),
        "sticking": STICKING,
    })  # fmt: skip

    settlement: Annotated[Settlement, "The steady state that was reached, if any."]
    stopped: Annotated[
        GuardStop | None, "Why and when it ended early; None if it ran to its end."
    ] = None
    requested: Annotated[int, "Forcing periods that were requested."]
    tolerance: Annotated[
        float,
        "Distance from a periodic response at which the trajectory counts as settled, in scaled "
        "states.",
    ]
    provenance: Provenance
    checked: Checked | None = None

    @property
    def interrupted(self) -> bool:
        """Whether the computation was interrupted: of the trajectory, or of its checks."""
        unchecked = self.checked is not None and self.checked.interrupted
        return unchecked or (self.stopped is not None and self.stopped.kind == "interrupted")

    @cached_property
    def last_round(self) -> LastRound | None:
        """The last whole round: extrema of the states, when contacts stick; None if there is none.

        That is the last response or cycle; of a trajectory that has not settled the last forcing
        period, or the last 16 intervals if nothing forces it.
        """
        return last_round(self)

    @property
    def regime(self) -> str | None:
        """``"slip"``, ``"stick-slip"`` or ``"stuck"`` in the last whole round.

        None if there is none, or the model has no contacts that could stick.
        """
        last = self.last_round
        if last is None or not contacts_of(self.model):
            return None
        if last.stuck and self.sticking is not None:
            return "stuck"
        return "stick-slip" if last.sticking else "slip"

    @property
    def stuck_fraction(self) -> float | None:
        """Fraction of the last whole round in which a contact sticks; None if there is no round."""
        return None if self.last_round is None else self.last_round.fraction

    def spectrum(self, periods: int = 64, per_period: PerPeriod = 64) -> Spectrum:
        """Return the spectra of all outputs at the end of the run.

        Parameters
        ----------
        periods
            Forcing periods to transform; rounded up to whole response periods.

        Raises
        ------
        InputError
            If the run is shorter than one response, or a number is less than 1.
        """
        from slipfold.long_term.spectrum import find_spectrum

        return find_spectrum(self, periods, per_period)

    def _head(self) -> str:
        length = f"{self.duration:.6g} s"
        if self.model.forced:
            return f"{self.model!r} over {self.periods} forcing periods ({length})"
        # The intervals at which an autonomous trajectory is stored are no property of the model.
        return f"{self.model.replace(**{DURATION.name: DURATION.default})!r} over {length}"

    def _sections(self) -> list[PrintedTable | list[str]]:
        model, last, spectrum = self.model, self.last_round, self._response_spectrum
        pairs = zip(model.states, self.states[-1], strict=True)
        state = ", ".join(f"{item.name} = {value:.12g}" for item, value in pairs)
        sentences = [
            capitalized(self.settlement.message, (*model.parameters, *model.states)),
            f"Last state{' at phase zero' if model.forced else ''}: {state}",
        ]
        if last is not None and last.sticking:
            sentences.append(
                f"In its last round contacts stick {100 * last.fraction:.6g}% of the time: "
                f"{stick_text(last, 'forcing periods' if model.forced else 's')}"
            )
        if spectrum is None:
            return [sentences, self._notes()]
        frequencies, amplitudes = spectrum
        lines = [
            # Lines at the level of rounding are set to zero.
            [f"{np.round(f, 9):.8g}", *(f"{v if abs(v) > 1e-12 else 0:.8g}" for v in values)]
            for f, *values in zip(frequencies, *amplitudes.values(), strict=True)
        ]
        return [[*sentences, ""], PrintedTable(["Hz", *amplitudes], lines), self._notes()]

    @cached_property
    def _response_spectrum(self) -> tuple[Array, dict[str, Array]] | None:
        """Frequencies and amplitudes of the response; None if there is none, or nothing moves."""
        period = self.settlement.period
        if period is None or self.settlement.kind == "equilibrium":
            return None
        spectrum = self.spectrum(period)
        # Up to three times the forcing frequency.
        count = 3 * spectrum.periods + 1
        amplitudes = {name: spectrum.of(name)[:count] for name in self.model.shown}
        return spectrum.frequency[:count], amplitudes

    def _record(self) -> dict[str, Any]:
        settlement, spectrum, last = self.settlement, self._response_spectrum, self.last_round
        pairs = (
            () if last is None else zip(self.model.states, last.minimum, last.maximum, strict=True)
        )
        extrema = {state.name: [float(low), float(high)] for state, low, high in pairs}
        return {
            "periods": self.periods,
            "initial_state": self.states[0],
            "state": self.states[-1],
            "settled": settlement.settled,
            "kind": settlement.kind,
            "period": settlement.period,
            "duration": settlement.duration,
            "drift": settlement.drift,
            **({"revolutions": settlement.revolutions} if settlement.revolutions else {}),
            "message": settlement.message,
            "regime": self.regime,
            "stick": None if self.regime is None or last is None else stick_record(last),
            "extrema": None if last is None else extrema,
            "spectrum": None
            if spectrum is None
            else {"frequency": spectrum[0], "amplitude": spectrum[1]},
            "stopped": None if self.stopped is None else asdict(self.stopped),
        }

    @property
    def _clock(self) -> str:
        """How intervals are timed."""
        return f"{'forcing periods' if self.model.forced else 'time'} since the start"

    @property
    def _clock_unit(self) -> str:
        return "" if self.model.forced else "s"

    @property
    def _count(self) -> NDArray[np.int64]:
        return np.arange(len(self.states))

    def _frame(self) -> Frame:
        result = super()._frame()
        return Frame({**result.columns, **stick_columns(self.sticking)}, result.units)

    def _repr_html_(self) -> str:
        return f"<pre>{escape(self.summary())}</pre>"
