"""Work that follows a response until it loses its stability, or farther."""

from __future__ import annotations

from collections.abc import Collection
from typing import Self

from slipfold.models.model import Model
from slipfold.studies.work.work import Quantity, Span, Work, parsed_span


class LossWork(Work):
    """What tells of the first loss of stability of a response over a parameter."""

    vary: str
    span: Span

    def varied(self) -> Collection[str]:
        """Return the parameter followed."""
        return (self.vary,)

    def checked(self, model: Model) -> Self:
        """Return it with the span in SI units."""
        return self.model_copy(update={"span": parsed_span(model, self.vary, self.span)})

    def quantities(self, model: Model) -> tuple[Quantity, ...]:
        """Return what is said of the loss, as `Loss.values` has it."""
        return (
            Quantity("threshold", "real", f"{self.vary} where the response first loses its "
                     "stability", model.parameter(self.vary).unit),
            Quantity("outcome", "text", "bifurcation by which it is lost; else stable, unstable "
                     "from the start, or how a stable response ends"),
            Quantity("reason", "text", "why there is no threshold"),
        )  # fmt: skip
