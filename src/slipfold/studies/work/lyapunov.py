"""Lyapunov exponents of a motion, and what motion they tell of."""

from __future__ import annotations

from typing import Literal, Self

from pydantic import Field

from slipfold.flow.simulate import initial_state
from slipfold.long_term.exponents import find_exponents
from slipfold.models.model import Model
from slipfold.models.parameter import DURATION
from slipfold.studies.work.work import Findings, Quantity, Start, Value, Work, parsed_start


class Lyapunov(Work):
    """How fast perturbations of a motion grow; whether it is periodic, a torus or chaos."""

    what: Literal["lyapunov"]
    periods: int | None = Field(None, ge=1)
    start: Start = Field(default_factory=dict)
    tolerance: float = Field(1e-8, gt=0)

    def checked(self, model: Model) -> Self:
        """Return it with the starting states in SI units."""
        return self.model_copy(update={"start": parsed_start(model, self.start)})

    def quantities(self, model: Model) -> tuple[Quantity, ...]:
        """Return what is found of every case."""
        unit = "1/forcing period" if model.forced else "1/s"
        numbers = range(1, len(model.states) + 1)
        return (
            Quantity("verdict", "text", "periodic, torus, chaos, equilibrium or undecided"),
            Quantity("period", "whole", "of a periodic motion, in forcing periods; else 0", none=0),
            *(Quantity(f"exponent_{k}", "real", "Lyapunov exponent", unit) for k in numbers),
            *(Quantity(f"error_{k}", "real", f"error of exponent {k}", unit) for k in numbers),
        )

    def of(self, model: Model) -> Findings:
        """Follow the motion and its perturbations."""
        start = initial_state(model, parsed_start(model, self.start))
        found = find_exponents(model, start, self.periods, self.tolerance)
        if found.interrupted:
            raise KeyboardInterrupt
        unit = 1.0 if model.forced else float(found.model.values[DURATION.name])
        last = found.estimates[-1]
        values: dict[str, Value] = {
            "verdict": found.verdict.kind,
            "period": found.verdict.period,
        }
        for number, (exponent, error) in enumerate(
            zip(last.exponents / unit, last.errors / unit, strict=True), 1
        ):
            values[f"exponent_{number}"] = float(exponent)
            values[f"error_{number}"] = float(error)
        return Findings(values)
