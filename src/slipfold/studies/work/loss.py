"""What studies tell of the first loss of stability."""

from __future__ import annotations

from slipfold.models.model import Model
from slipfold.studies.work.work import Quantity

__all__ = ["loss_quantities"]


def loss_quantities(model: Model, vary: str) -> tuple[Quantity, ...]:
    """Return what is said of it, as `Loss.values` has it."""
    return (
        Quantity("threshold", "real", f"{vary} where the response first loses its stability",
                 model.parameter(vary).unit),
        Quantity("outcome", "text", "bifurcation by which it is lost; else stable, unstable from "
                 "the start, or how a stable response ends"),
        Quantity("reason", "text", "why there is no threshold"),
    )  # fmt: skip
