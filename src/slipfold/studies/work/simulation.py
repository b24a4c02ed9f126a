"""A motion in time: what it settles on, where it stays, and how far it moves."""

from __future__ import annotations

from typing import Literal, Self

import numpy as np
from pydantic import Field

from slipfold.flow.switched.simulate import simulate_smooth_or_switched
from slipfold.models.model import Model
from slipfold.models.output import Output
from slipfold.models.parameter import State
from slipfold.orbits.extrema import steady_extrema
from slipfold.studies.work.work import Findings, Quantity, Start, Value, Work, parsed_start


class Simulation(Work):
    """A motion from one state: whether it settles, on what period, its last state, its extrema."""

    what: Literal["simulation"]
    periods: int | None = Field(None, ge=1)
    start: Start = Field(default_factory=dict)
    tolerance: float = Field(1e-9, gt=0)

    def checked(self, model: Model) -> Self:
        """Return it with the starting states in SI units."""
        return self.model_copy(update={"start": parsed_start(model, self.start)})

    def quantities(self, model: Model) -> tuple[Quantity, ...]:
        """Return what is found of every case."""
        return (
            Quantity("settled", "whole", "1 if the motion has settled, else 0"),
            Quantity("period", "whole", "period of what it settled on; 0 if it has not", none=0),
            Quantity("duration", "real", "seconds that one round of a cycle takes", "s"),
            Quantity("time", "real", "seconds of the motion", "s"),
            Quantity("reason", "text", "why the motion ended early"),
            *(
                Quantity(f"last_{state.name}", "real", f"last strobe state: {state.doc}",
                         state.unit)
                for state in model.states
            ),
            *(
                Quantity(f"{measure}_{item.name}", "real",
                         f"{measure} {item.name} over what it settled on, else its last periods",
                         item.unit)
                for item in _outputs(model)
                for measure in ("min", "max")
            ),
        )  # fmt: skip

    def of(self, model: Model) -> Findings:
        """Integrate the motion."""
        found = simulate_smooth_or_switched(
            model, self.periods, parsed_start(model, self.start) or None, tolerance=self.tolerance
        )
        settlement, stopped = found.settlement, found.stopped
        values: dict[str, Value] = {
            "settled": int(settlement.settled),
            "period": settlement.period,
            "duration": settlement.duration,
            "time": float(found.duration),
            "reason": "" if stopped is None else stopped.reason,
        }
        for state, value in zip(model.states, found.strobe[-1], strict=True):
            values[f"last_{state.name}"] = float(value) if np.isfinite(value) else None
        names = [item.name for item in _outputs(model)]
        low = high = np.full(len(names), np.nan)  # what ended early lasts no more
        if stopped is None:
            extrema = steady_extrema(found, names)
            (low,), (high,) = extrema.minimum, extrema.maximum
        for name, least, most in zip(names, low.tolist(), high.tolist(), strict=True):
            values[f"min_{name}"] = least if np.isfinite(least) else None
            values[f"max_{name}"] = most if np.isfinite(most) else None
        return Findings(values)


def _outputs(model: Model) -> tuple[State | Output, ...]:
    return (*model.states, *model.outputs())
