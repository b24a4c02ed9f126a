"""The response over a parameter: its threshold, and the special points of all branches."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import ClassVar, Literal

from pydantic import Field

from slipfold.branches.abreast.responses import (
    FEWEST,
    TOGETHER,
    FollowedResponse,
    responses_abreast,
)
from slipfold.branches.response import trace_response
from slipfold.branches.settings import Settings
from slipfold.branches.special_point import SpecialPoint
from slipfold.models.followed import check_followed
from slipfold.models.model import Model
from slipfold.studies.work.loss import LossWork
from slipfold.studies.work.work import Findings, Quantity
from slipfold.thresholds.loss import STABLE, Loss, first_loss, unstable_from


class Response(LossWork):
    """Every branch of the response; where it loses its stability, and all special points."""

    together_from: ClassVar[int] = FEWEST
    side_by_side: ClassVar[int] = TOGETHER

    what: Literal["response"]
    largest_period: int = Field(Settings().largest_period, ge=1)

    def quantities(self, model: Model) -> tuple[Quantity, ...]:
        """Return what is found of every case."""
        return (
            *super().quantities(model),
            Quantity("branches", "whole", "number of branches"),
            Quantity("given_up", "whole", "number of branches that could not be followed"),
        )

    def lists(self, model: Model) -> tuple[Quantity, ...]:
        """Return what is said of each special point."""
        unit = model.parameter(self.vary).unit
        return (
            Quantity("type", "text", "type of special point"),
            Quantity("branch", "whole", "number of its branch, from 1"),
            Quantity("period", "whole", "in forcing periods"),
            Quantity("value", "real", f"{self.vary} there", unit),
            Quantity("uncertainty", "real", "computed uncertainty of the value", unit),
            Quantity("criticality", "text", "supercritical, subcritical, or empty"),
            Quantity("coefficient", "real", "of the normal form"),
        )

    def of(self, model: Model) -> Findings:
        """Follow the response."""
        check_followed(model)
        first, last = self.span
        settings = Settings(largest_period=self.largest_period)
        span = (float(first), float(last))
        branches = trace_response(model, self.vary, span, settings=settings, through_stick=True)
        if any(branch.interrupted for branch in branches):
            raise KeyboardInterrupt
        found = first_loss(branches[0], float(first))
        given_up = sum(branch.failed for branch in branches)
        return _findings(found, [branch.special for branch in branches], given_up)

    def together(self, models: Sequence[Model]) -> list[Findings | None]:
        """Follow responses side by side, as far as nothing on them is out of the ordinary."""
        span = (float(self.span[0]), float(self.span[1]))
        settings = Settings(largest_period=self.largest_period)
        followed = responses_abreast(models, self.vary, span, settings)
        return [None if item is None else self._found(item) for item in followed]

    def _found(self, response: FollowedResponse) -> Findings | None:
        loss = response.loss
        if not response.branches[0].stable:
            told = unstable_from(self.vary, float(self.span[0]))
        elif loss is None:
            if response.branches[0].ends != "span":  # where a limit lies is not known
                return None
            last = float(self.span[1])
            reason = f"reached the end of the span at {self.vary} = {last:g}"
            told = Loss(math.nan, STABLE, f"{reason} (stable up to {self.vary} = {last:.9g})")
        else:
            told = Loss(float(loss.value), loss.type, "")
        return _findings(told, [branch.special for branch in response.branches], 0)


def _findings(loss: Loss, special: Sequence[Sequence[SpecialPoint]], given_up: int) -> Findings:
    """Return what is kept of a response: special points are given by branch."""
    values = {**loss.values(), "branches": len(special), "given_up": given_up}
    listed = tuple(
        {
            "type": point.type,
            "branch": number,
            "period": point.period,
            "value": float(point.value),
            "uncertainty": float(point.uncertainty),
            "criticality": point.criticality,
            "coefficient": None if point.coefficient is None else float(point.coefficient),
        }
        for number, points in enumerate(special, 1)
        for point in points
    )
    return Findings(values, listed)
