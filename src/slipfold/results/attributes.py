"""The attributes of a saved result: what it is, the full input, and where it comes from."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from slipfold.results.model_record import structure_record

if TYPE_CHECKING:
    from slipfold.models.model import Model
    from slipfold.results.provenance import Provenance

__all__ = ["result_attributes"]


def result_attributes(
    schema: str, title: str, model: Model, given: Mapping[str, Any], origin: Provenance
) -> dict[str, Any]:
    """Return the attributes that all saved results have."""
    described = {"model": model.name, "parameters": dict(model.values)}
    structure = structure_record(model)
    if structure:
        described["structure"] = structure
    return {
        "schema": schema,
        "title": title,
        "model": model.name,
        "input": json.dumps({**described, **given}),
        "slipfold_version": origin.slipfold,
        "heyoka_version": origin.heyoka,
        "numpy_version": origin.numpy,
        "python_version": origin.python,
        "computed": origin.computed,
        "seconds": origin.seconds,
    }
