"""What motions from a box of starts come to, and how many of them to what."""

from __future__ import annotations

from typing import ClassVar, Literal, Self

import numpy as np
from pydantic import Field

from slipfold.flow.sizes.typical_sizes import measured
from slipfold.long_term.box import Box, box_around, checked_box
from slipfold.long_term.search import ENDED, UNDECIDED, search
from slipfold.models.model import Model
from slipfold.studies.work.work import Findings, Quantity, Span, Value, Work

PERIODS = (1, 2)
"""Periods whose shares have names of their own."""

KINDS = ("torus", "chaos", "cycle", "equilibrium")


class Attractors(Work):
    """All attractors that motions from a box of starts come to; the shares of their basins."""

    listed: ClassVar[str] = "attractor"

    what: Literal["attractors"]
    box: dict[str, Span] = Field(default_factory=dict)
    starts: int = Field(256, ge=1)
    seed: int = Field(0, ge=0)
    periods: int | None = Field(None, ge=1)

    def checked(self, model: Model) -> Self:
        """Return it unchanged if the model has such a box."""
        if self.box:
            checked_box(model, self.box)
        return self

    def quantities(self, model: Model) -> tuple[Quantity, ...]:
        """Return what is found of every case."""
        shares = {f"period_{period}": f"responses of period {period}" for period in PERIODS}
        shares |= {"longer": "responses of other periods"}
        shares |= {kind: f"attractors that are: {kind}" for kind in KINDS}
        shares |= {"ended": "nothing, as they ended at a limit", "undecided": "nothing known"}
        return (
            Quantity("attractors", "whole", "number of attractors"),
            *(
                Quantity(f"share_{name}", "real", f"share of the starts that come to {meaning}")
                for name, meaning in shares.items()
            ),
        )

    def lists(self, model: Model) -> tuple[Quantity, ...]:
        """Return what is said of each attractor."""
        return (
            Quantity("kind", "text", "periodic, torus, chaos, cycle or equilibrium"),
            Quantity("period", "whole", "in forcing periods; 0 where nothing repeats with them"),
            Quantity("share", "real", "share of the starts that come to it"),
            *(
                Quantity(f"state_{state.name}", "real", f"a state on it: {state.doc}", state.unit)
                for state in model.states
            ),
        )

    def of(self, model: Model) -> Findings:
        """Follow the motions."""
        model = measured(model)
        box: Box = checked_box(model, self.box) if self.box else box_around(model)
        found = search(model, box.starts(self.starts, self.seed), self.periods)
        if found.interrupted:
            raise KeyboardInterrupt
        shares = {item.name: 0.0 for item in self.quantities(model)}
        shares["share_ended"] = float(np.mean(found.labels == ENDED))
        shares["share_undecided"] = float(np.mean(found.labels == UNDECIDED))
        listed: list[dict[str, Value]] = []
        for item in found.attractors:
            share = float(np.mean(found.labels == item.id))
            name = item.kind
            if name == "periodic":
                name = f"period_{item.period}" if item.period in PERIODS else "longer"
            shares[f"share_{name}"] += share
            states = zip(model.states, item.state.tolist(), strict=True)
            listed.append(
                {"kind": item.kind, "period": item.period, "share": share}
                | {f"state_{state.name}": value for state, value in states}
            )
        values: dict[str, Value] = {**shares, "attractors": len(listed)}
        return Findings(values, tuple(listed))
