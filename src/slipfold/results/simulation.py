"""A simulated motion as a result: saved, printed, drawn, with where it comes from."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from functools import cached_property
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from slipfold.checks.checked import Checked
from slipfold.drawing import draw
from slipfold.flow.last_round import LastRound, last_round
from slipfold.flow.switched.mode_equations import contacts_of
from slipfold.flow.trajectory import Trajectory
from slipfold.models.model import Model
from slipfold.models.parameter import DURATION
from slipfold.results.fields import WHOLE, Field
from slipfold.results.frame import Frame
from slipfold.results.provenance import Provenance
from slipfold.results.result import Result
from slipfold.results.stick_table import Contacts, stick_columns, stick_record, stick_text
from slipfold.text.one_line import capitalised

if TYPE_CHECKING:
    from slipfold.long_term.spectrum import Spectrum

HIGHEST = 3
"""Multiples of the forcing frequency shown."""


@dataclass(frozen=True, eq=False, repr=False, kw_only=True)
class Simulation(Trajectory, Result):
    """A motion over many forcing periods, with its input; frozen.

    Made by `slipfold.simulate` and `slipfold.load`.

    Parameters
    ----------
    model
        The model with its parameter values.
    strobe
        States at phase zero of every forcing period, from the initial state on, shape
        (periods + 1, n_states).
    settlement
        Whether and on what it settled.
    stopped
        Why and when it ended early; None if it ran to its end.
    asked
        Forcing periods that were asked for.
    tolerance
        Distance from a periodic response at which the motion counts as settled, in scaled states.
    provenance
        Versions and time.
    sticking
        What contacts did in a motion that sticks; None of one that always slips.
    checked
        Parts of the motion that were held against the equations; None if none was.

    Notes
    -----
    In the dataset of `to_xarray`, along ``strobe``: ``time`` in seconds and ``states``; the outcome
    is in the attributes. In the spreadsheet of `to_csv`, time and states once every forcing period,
    at phase zero, and what each contact does then if one sticks. In `to_json`, schema
    slipfold.simulation/1, the outcome.

    Examples
    --------
    >>> import slipfold as sf
    >>> motion = sf.simulate(sf.SlidingOscillator(), periods=1000, f=12.2, Nd=0.15)
    >>> motion.settlement.period, round(motion.spectrum().line("x", 0.5), 6)
    (2, 0.276327)
    """

    schema = "slipfold.simulation/1"
    title = "simulation of {0.model.name}"
    rows = "strobe"
    arrays = MappingProxyType({
        "_count": Field("strobe", "forcing periods, or intervals of the duration, since the start",
                        "", WHOLE, "strobe", label=True, head=None),
        "time": Field("strobe", "time since the start", "s", label=True),
        "strobe": Field("strobe state", "state, at phase zero of the forcing", name="states",
                        head=""),
        "sticking": Contacts(),
    })  # fmt: skip

    asked: int
    tolerance: float
    provenance: Provenance
    checked: Checked | None = None

    @property
    def interrupted(self) -> bool:
        """Whether the computation was interrupted: of the motion, or of its checks."""
        unchecked = self.checked is not None and self.checked.interrupted
        return unchecked or (self.stopped is not None and self.stopped.kind == "interrupted")

    @cached_property
    def last_round(self) -> LastRound | None:
        """The last whole round: extrema of the states, when contacts stick; None if there is none.

        That is the last response or cycle; of a motion that has not settled the last forcing
        period.
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
        """Share of the last whole round in which a contact sticks; None if there is no round."""
        return None if self.last_round is None else self.last_round.fraction

    def spectrum(self, periods: int = 64, per_period: int = 64) -> Spectrum:
        """Return the spectra of all outputs at the end of the run.

        Parameters
        ----------
        periods
            Forcing periods to transform; rounded up to whole response periods.
        per_period
            Samples per forcing period.

        Raises
        ------
        InputError
            If the run is shorter than one response, or a number is less than 1.
        """
        from slipfold.long_term.spectrum import find_spectrum

        return find_spectrum(self, periods, per_period)

    def summary(self) -> str:
        """Return whether it settled, its last state, and the amplitudes of what it settled on."""
        names = [state.name for state in self.model.states]
        state = ", ".join(
            f"{name} = {value:.12g}" for name, value in zip(names, self.strobe[-1], strict=True)
        )
        message, last = self.settlement.message, self.last_round
        forced = self.model.forced
        length = f"{self.duration:.6g} s"
        # At how long intervals a motion that nothing forces was kept is no property of the model.
        model = self.model if forced else self.model.replace(**{DURATION.name: DURATION.default})
        lines = [
            f"{model!r} over "
            + (f"{self.periods} forcing periods ({length})" if forced else length),
            capitalised(message, (*model.parameters, *model.states)),
            f"Last state{' at phase zero' if forced else ''}: {state}",
        ]
        if last is not None and last.sticking:
            lines.append(
                f"In its last round contacts stick {100 * last.fraction:.6g}% of the time: "
                f"{stick_text(last, 'forcing periods' if forced else 's')}"
            )
        spectrum = self._response_spectrum()
        if spectrum is not None:
            lines += ["", f"{'Hz':>12}" + "".join(f"{name:>14}" for name in names)]
            for index in range(_lines(spectrum)):
                values = [spectrum.of(name)[index] for name in names]
                # Lines of rounding errors are no lines.
                cells = "".join(f"{value if abs(value) > 1e-12 else 0:14.8g}" for value in values)
                lines.append(f"{np.round(spectrum.frequency[index], 9):12.8g}" + cells)
        return "\n".join([*lines, *self._remarks()])

    def plot(self, output: str | None = None, kind: str = "timeseries", **options: Any) -> Any:
        """Draw the motion.

        Parameters
        ----------
        output
            A state or output of the model; the first state if None. Of a contact there is none.
        kind
            ``"timeseries"``, ``"spectrum"`` or ``"phase"`` of an output. Of contacts with exact
            friction, in the last round: ``"hysteresis"``, friction over displacement;
            ``"friction"``, over the velocity of the counter-body relative to the body;
            ``"path"``, where a contact in a plane goes, and ``"track"``, where on the counter-body;
            ``"timeline"``, when contacts stick, slip and are open.
        **options
            Options of the drawing, e.g. ``ax=`` the axes to draw in, ``contact=`` the name of one
            contact, ``rounds=`` how many rounds are shown of it.

        Returns
        -------
        matplotlib.axes.Axes
            The axes.

        Raises
        ------
        InputError
            For an unknown output, contact or kind, or one that the model has no picture of.
        """
        return draw(self, output=output, kind=kind, **options)

    def _response_spectrum(self) -> Spectrum | None:
        """Return the spectrum over one response; None if there is none, or nothing moves."""
        period = self.settlement.period
        still = self.settlement.kind == "equilibrium"
        return None if period is None or still else self.spectrum(period)

    def _record(self) -> dict[str, Any]:
        settlement, spectrum = self.settlement, self._response_spectrum()
        last = self.last_round
        return {
            "periods": self.periods,
            "initial_state": self.strobe[0],
            "state": self.strobe[-1],
            "settled": settlement.settled,
            "kind": settlement.kind,
            "period": settlement.period,
            "duration": settlement.duration,
            "drift": settlement.drift,
            **({"turns": settlement.turns} if settlement.turns else {}),
            "message": settlement.message,
            "regime": self.regime,
            "stick": None if self.regime is None or last is None else stick_record(last),
            "extrema": None if last is None else _extrema_record(self.model, last),
            "spectrum": None if spectrum is None else _spectrum_record(self.model, spectrum),
            "stopped": None if self.stopped is None else asdict(self.stopped),
        }

    @property
    def _count(self) -> NDArray[np.int64]:
        return np.arange(len(self.strobe))

    def _frame(self) -> Frame:
        found = super()._frame()
        return Frame({**found.columns, **stick_columns(self.sticking)}, found.units)

    def _repr_html_(self) -> str:
        from html import escape

        return f"<pre>{escape(self.summary())}</pre>"


def _lines(spectrum: Spectrum) -> int:
    return HIGHEST * spectrum.periods + 1


def _extrema_record(model: Model, last: LastRound) -> dict[str, list[float]]:
    pairs = zip(model.states, last.least, last.most, strict=True)
    return {state.name: [float(least), float(most)] for state, least, most in pairs}


def _spectrum_record(model: Model, spectrum: Spectrum) -> dict[str, Any]:
    count = _lines(spectrum)
    amplitudes = {state.name: spectrum.of(state.name)[:count] for state in model.states}
    return {"frequency": spectrum.frequency[:count], "amplitude": amplitudes}
