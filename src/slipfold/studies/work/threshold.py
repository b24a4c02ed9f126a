"""The first loss of stability alone: the branch ends where it is found."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from typing import Literal, Self

from slipfold.models.followed import check_followed
from slipfold.models.model import Model
from slipfold.studies.work.loss import loss_quantities
from slipfold.studies.work.work import Findings, Quantity, Span, Work, parsed_span
from slipfold.thresholds.first_loss import Loss, first_loss, followed_to_loss
from slipfold.thresholds.side_by_side import first_doublings

__all__ = ["Threshold"]


class Threshold(Work):
    """Where the response of period 1 first loses its stability, and by what."""

    what: Literal["threshold"]
    vary: str
    span: Span

    def varied(self) -> Collection[str]:
        """Return the parameter followed."""
        return (self.vary,)

    def checked(self, model: Model) -> Self:
        """Return it with the span in SI units."""
        return self.model_copy(update={"span": parsed_span(model, self.vary, self.span)})

    def quantities(self, model: Model) -> tuple[Quantity, ...]:
        """Return what is found of every case."""
        return loss_quantities(model, self.vary)

    def together(self, models: Sequence[Model]) -> list[Findings | None]:
        """Find first period doublings side by side."""
        first, last = float(self.span[0]), float(self.span[1])
        found = first_doublings(models, self.vary, (first, last)).tolist()
        return [
            None if math.isnan(value) else Findings(Loss(value, "PD", "").values())
            for value in found
        ]

    def of(self, model: Model) -> Findings:
        """Follow the response until it meets a bifurcation."""
        check_followed(model)
        first, last = float(self.span[0]), float(self.span[1])
        branch = followed_to_loss(model, self.vary, (first, last), through_stick=True)
        return Findings(first_loss(branch, first).values())
