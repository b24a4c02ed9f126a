"""Lyapunov exponents as a result: saved, printed, with where they come from."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slipfold.long_term.exponents import Estimate
from slipfold.long_term.verdict import Verdict
from slipfold.models.model import Model
from slipfold.models.parameter import DURATION
from slipfold.results.column import WHOLE, Column
from slipfold.results.labelled_table import Variable
from slipfold.results.provenance import Provenance
from slipfold.results.result import Result
from slipfold.results.saved_table import SavedTable
from slipfold.results.sheet import Sheet
from slipfold.results.table import Table, axes_of, names
from slipfold.text.one_line import OneLine
from slipfold.text.printed_table import PrintedTable

__all__ = ["LyapunovExponents"]

Array = NDArray[np.float64]


def _estimates(model: Model) -> Table:
    """Exponents as they became known."""
    counted = "forcing periods" if model.forced else "intervals of the duration"
    unit = "1/forcing period" if model.forced else "1/s"
    exponent = ("exponent",)
    return Table(
        ("estimate",),
        (
            Column("periods", WHOLE, f"{counted} since the start", "", label=True),
            Column("exponents", meaning="Lyapunov exponents, the largest first", unit=unit,
                   dimensions=exponent),
            Column("errors", meaning="estimated errors of the exponents", unit=unit,
                   dimensions=exponent),
        ),
    )  # fmt: skip


def _ends(model: Model) -> Table:
    """Where the motion began, and what it came to."""
    meaning = f"first and last state{' at phase zero' if model.forced else ''}"
    columns = (Column("state", meaning=meaning, dimensions=("state",), name="states", get=_same),)
    return Table(("end",), columns)


def _same(state: Array) -> Array:
    return state


def _axes(model: Model) -> dict[str, list[str]]:
    axes = axes_of(model)
    return {**axes, "exponent": axes["multiplier"]}


@dataclass(frozen=True, eq=False, repr=False)
class LyapunovExponents(OneLine, Result):
    """How fast perturbations of a motion grow on average, and what that makes of it; frozen.

    Made by `slipfold.lyapunov` and `slipfold.load`.

    Parameters
    ----------
    model
        The model with its parameter values.
    estimates
        Exponents with their errors after more and more forcing periods; the last ones count.
    verdict
        ``"periodic"``, ``"torus"``, ``"chaos"``, ``"equilibrium"`` or ``"undecided"``, with its
        sentence, and the period or duration of what repeats.
    start, state
        First and last state of the motion, at phase zero, shape (n_states,).
    tolerance
        Error of the exponents at which the computation ends.
    asked
        Forcing periods that were asked for; None for as many as it takes.
    interrupted
        Whether the computation was interrupted before that.
    provenance
        Versions and time.

    Notes
    -----
    In the dataset of `to_xarray`, along ``estimate``: ``periods``, ``exponents`` and ``errors``,
    the latter along ``exponent`` as well; along ``end``: the first and last of the ``states``. In
    the spreadsheet of `to_csv` an estimate is a row. In `to_json`, schema slipfold.lyapunov/1.

    Examples
    --------
    >>> import slipfold as sf
    >>> found = sf.lyapunov(sf.SlidingOscillator(), f=12.5, Nd=0.02)
    >>> found.verdict.kind, found.verdict.period, found.exponents.round(6).tolist()
    ('periodic', 1, [-0.0427, -0.0427, -0.151903, -0.151903])
    """

    schema = "slipfold.lyapunov/1"

    model: Model
    estimates: tuple[Estimate, ...]
    verdict: Verdict
    start: Array
    state: Array
    tolerance: float
    asked: int | None
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
        """Estimated errors of the exponents, in their unit, shape (n_states,)."""
        return self.estimates[-1].errors

    @property
    def periods(self) -> int:
        """Forcing periods of the motion; of an autonomous model intervals of its ``duration``."""
        return self.estimates[-1].periods

    @property
    def per(self) -> str:
        """What the exponents are per: ``"forcing period"``, or ``"s"`` of an autonomous model."""
        return "forcing period" if self.model.forced else "s"

    @property
    def dimension(self) -> float:
        """Dimension of what the motion settles on, by the conjecture of Kaplan and Yorke (1979).

        That of a periodic response at its discrete phases is 0.
        """
        sums = np.cumsum(np.where(np.abs(self.exponents) <= self.errors, 0.0, self.exponents))
        whole = int((sums >= 0).sum()) if sums[0] >= 0 else 0
        if whole in (0, len(sums)):
            return float(whole)
        return float(whole + sums[whole - 1] / abs(self.exponents[whole]))

    def summary(self) -> str:
        """Return the exponents with their errors, and what motion they tell of."""
        message, model = self.verdict.message, self.model
        length = f"{self.periods} forcing periods"
        if not model.forced:
            length = f"{self.periods * model.values[DURATION.name]:.6g} s"
            model = model.replace(**{DURATION.name: DURATION.default})
        wanted = "its exponents were known" if self.asked is None else "all periods were done"
        stopped = [f"Interrupted before {wanted}"] if self.interrupted else []
        lines = [
            f"{model!r} over {length}",
            message[:1].upper() + message[1:],
            *self._rows().text(),
            *stopped,
        ]
        return "\n".join([*lines, *self._remarks()])

    def _line(self) -> str:
        return f"Lyapunov exponents of {self.model.name}: {self.verdict.message}"

    def _rows(self) -> PrintedTable:
        rows = [
            [f"{exponent:.{_digits(error)}g}" if exponent else "0", f"{error:.0e}"]
            for exponent, error in zip(self.exponents, self.errors, strict=True)
        ]
        return PrintedTable([f"exponent (1/{self.per})", "error"], rows)

    def _title(self) -> str:
        return f"Lyapunov exponents of {self.model.name}"

    def _given(self) -> dict[str, Any]:
        return {
            "periods": self.asked,
            "state": self.start.tolist(),
            "tolerance": self.tolerance,
        }

    def _attributes(self) -> dict[str, Any]:
        return {
            "verdict": json.dumps(asdict(self.verdict)),
            "per": self.per,
            "interrupted": int(self.interrupted),
        }

    def _variables(self) -> dict[str, Variable]:
        labels = names("state", self.model.states)
        estimates = _estimates(self.model).variables(self.estimates, _axes(self.model))
        ends = _ends(self.model).variables([self.start, self.state], _axes(self.model))
        return labels | estimates | ends

    def _record(self) -> dict[str, Any]:
        verdict = self.verdict
        return {
            "exponents": self.exponents,
            "errors": self.errors,
            "per": self.per,
            "verdict": verdict.kind,
            "period": verdict.period,
            "duration": verdict.duration,
            "message": verdict.message,
            "dimension": self.dimension,
            "periods": self.periods,
            "initial_state": self.start,
            "state": self.state,
            "interrupted": self.interrupted,
        }

    def _csv(self) -> str:
        table = _estimates(self.model)
        heads = {"periods": "periods", "exponents": "exponent", "errors": "error"}
        sheet = Sheet(heads, (table,), _axes(self.model))
        return sheet.text(sheet.rows(table, self.estimates, {}))

    @classmethod
    def _read(cls, saved: SavedTable) -> LyapunovExponents:
        table, axes = _estimates(saved.model), _axes(saved.model)
        count = len(saved.columns["periods"])
        estimates = [Estimate(**table.read(saved, axes, row)) for row in range(count)]
        if not estimates:
            raise ValueError("there are no exponents")
        start, state = (_ends(saved.model).read(saved, axes, row)["state"] for row in (0, 1))
        asked = saved.given["periods"]
        return cls(
            model=saved.model,
            estimates=tuple(estimates),
            verdict=Verdict(**json.loads(saved.attributes["verdict"])),
            start=start,
            state=state,
            tolerance=float(saved.given["tolerance"]),
            asked=None if asked is None else int(asked),
            interrupted=bool(saved.attributes["interrupted"]),
            provenance=saved.provenance,
        )


def _digits(error: float) -> int:
    """Return how many digits are shown of an exponent of that error."""
    return 4 if error > 1e-5 else 9
