"""The response over a parameter: its threshold, and the special points of all branches."""

from __future__ import annotations

from collections.abc import Collection
from typing import Literal, Self

from pydantic import Field

from slipfold.branches.response import trace_response
from slipfold.branches.settings import Settings
from slipfold.models.followed import check_followed
from slipfold.models.model import Model
from slipfold.studies.work.loss import first_loss, loss_quantities
from slipfold.studies.work.work import Findings, Quantity, Span, Work, parsed_span

__all__ = ["Response"]


class Response(Work):
    """Every branch of the response; where it loses its stability, and all special points."""

    what: Literal["response"]
    vary: str
    span: Span
    largest_period: int = Field(Settings().largest_period, ge=1)

    def varied(self) -> Collection[str]:
        """Return the parameter followed."""
        return (self.vary,)

    def checked(self, model: Model) -> Self:
        """Return it with the span in SI units."""
        return self.model_copy(update={"span": parsed_span(model, self.vary, self.span)})

    def quantities(self, model: Model) -> tuple[Quantity, ...]:
        """Return what is found of every case."""
        return (
            *loss_quantities(model, self.vary),
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
        values = first_loss(branches[0], float(first)).values()
        values["branches"] = len(branches)
        values["given_up"] = sum(branch.failed for branch in branches)
        listed = tuple(
            {
                "type": point.type,
                "branch": branch.id,
                "period": point.period,
                "value": float(point.value),
                "uncertainty": float(point.uncertainty),
                "criticality": point.criticality,
                "coefficient": None if point.coefficient is None else float(point.coefficient),
            }
            for branch in branches
            for point in branch.special
        )
        return Findings(values, listed)
