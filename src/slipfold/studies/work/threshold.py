"""The first loss of stability alone: the branch ends where it is found."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal

from slipfold.models.followed import check_followed
from slipfold.models.model import Model
from slipfold.studies.work.loss import LossWork
from slipfold.studies.work.work import Findings
from slipfold.thresholds.batch import first_doublings
from slipfold.thresholds.loss import Loss, first_loss, followed_to_loss


class Threshold(LossWork):
    """Where the response of period 1 first loses its stability, and by what."""

    what: Literal["threshold"]

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
