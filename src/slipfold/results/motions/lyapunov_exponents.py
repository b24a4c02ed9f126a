"""Lyapunov exponents as a result: saved, printed, with where they come from."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np

from slipfold.arrays import Array
from slipfold.long_term.exponents import Estimate
from slipfold.long_term.verdict import Verdict
from slipfold.models.model import Model
from slipfold.models.parameter import DURATION
from slipfold.results.fields import REAL, WHOLE, Column, Field, Items
from slipfold.results.provenance import Provenance
from slipfold.results.result import Result
from slipfold.text.one_line import capitalised
from slipfold.text.printed_table import PrintedTable


@dataclass(frozen=True, eq=False, repr=False)
class LyapunovExponents(Result):
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
        sentence, and the period or duration of what repeats, or the rotation number of a torus and
        the resonance p/q that it is near.
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
    the latter along ``exponent`` as well; along ``state``: the first and last state, ``start`` and
    ``last``. In the spreadsheet of `to_csv` an estimate is a row. In `to_json`, schema
    slipfold.lyapunov/1.

    Examples
    --------
    >>> import slipfold as sf
    >>> found = sf.lyapunov(sf.SlidingOscillator(), f=12.5, Nd=0.02)
    >>> found.verdict.kind, found.verdict.period, found.exponents.round(6).tolist()
    ('periodic', 1, [-0.0427, -0.0427, -0.151903, -0.151903])
    """

    schema = "slipfold.lyapunov/1"

    title = "Lyapunov exponents of {0.model.name}"
    rows = "estimate"
    recorded = ("exponents", "errors", "per", "dimension", "periods", "state", "interrupted")

    model: Model
    estimates: Annotated[
        tuple[Estimate, ...],
        Items("estimate", Estimate, (
            Column("periods", WHOLE, "forcing periods, or intervals of the duration, since the "
                   "start", "", label=True),
            Column("exponents", REAL, "Lyapunov exponents, the largest first", "1/{per}",
                   ("exponent",), head="exponent"),
            Column("errors", REAL, "estimated errors of the exponents", "1/{per}", ("exponent",),
                   head="error"),
        )),
    ]  # fmt: skip
    verdict: Verdict
    start: Annotated[Array, Field("state", "first state of the motion")]
    state: Annotated[Array, Field("state", "last state of the motion", name="last")]
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
            capitalised(message, (*model.parameters, *model.states)),
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

    def _record(self) -> dict[str, Any]:
        verdict = self.verdict
        told = {"verdict": verdict.kind, "message": verdict.message, "initial_state": self.start}
        repeats: dict[str, Any] = {"period": verdict.period, "duration": verdict.duration}
        repeats |= {"rotation": verdict.rotation, "resonance": verdict.resonance}
        return {**super()._record(), **told, **repeats}


def _digits(error: float) -> int:
    """Return how many digits are shown of an exponent of that error."""
    return 4 if error > 1e-5 else 9
