"""What a model's equations depend on besides parameter values, as plain data in saved files."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from slipfold.errors import InputError
from slipfold.models.friction import law_from_record, law_record
from slipfold.models.model import Model
from slipfold.models.registry import built_in_models, model_named
from slipfold.models.sliding_oscillator import SlidingOscillator
from slipfold.models.structures import Structure
from slipfold.models.system import System
from slipfold.models.unforced import Unforced


def structure_record(model: Model) -> dict[str, Any]:
    """Return what a model's equations depend on besides its class, as plain data for JSON."""
    if not model.structure:
        return {}
    if isinstance(model, System):
        return {"definition": model.to_toml()}
    if isinstance(model, Structure):
        return {"tables": model.to_tables()}
    if isinstance(model, SlidingOscillator):
        return {"friction": law_record(model.friction)}
    if isinstance(model, Unforced):
        return {"forced": _whole_record(model.forced_model)}
    return {}


def scales_record(model: Model) -> dict[str, Any]:
    """Return the typical sizes that a computation found, by state; nothing if it found none."""
    sizes = model.found_sizes
    if sizes is None:
        return {}
    names = [state.name for state in model.states]
    return {"scales": dict(zip(names, sizes.tolist(), strict=True))}


def measured_as(model: Model, described: Mapping[str, Any]) -> Model:
    """Return a saved model with the sizes that `scales_record` told, if it did."""
    if "scales" not in described:
        return model
    return model.measured_in(np.array([described["scales"][item.name] for item in model.states]))


def _whole_record(model: Model) -> dict[str, Any]:
    return {
        "model": model.name,
        "structure": structure_record(model),
        "parameters": dict(model.values),
    }


def model_from_record(
    name: str,
    structure: Mapping[str, Any],
    values: Mapping[str, Any],
    kind: type[Model] | None = None,
) -> Model:
    """Make a saved model again."""
    if "forced" in structure:
        whole = structure["forced"]
        forced = model_from_record(whole["model"], whole["structure"], whole["parameters"], kind)
        return Unforced(forced, **values)
    if kind is not None:
        _check_kind(kind)
    given = dict(values)
    if "friction" in structure:
        given["friction"] = law_from_record(structure["friction"])
    if kind not in (None, System, Structure):
        return kind(**given)
    if "tables" in structure:
        return Structure.from_tables({**structure["tables"], "parameters": given})
    if "definition" in structure:
        return System(str(structure["definition"]), **given)
    if name not in built_in_models():
        raise InputError(
            f"its model {name!r} is not a built-in one; read it in Python with the class of that "
            "model, slipfold.load(..., kind=TheClass)"
        )
    if "friction" in structure:
        return SlidingOscillator(**given)
    return model_named(name, **given)


def _check_kind(kind: Any) -> None:
    if not (isinstance(kind, type) and issubclass(kind, Model)):
        raise InputError(
            f"kind = {kind!r} is not the class of a model; give a class, e.g. SlidingOscillator"
        )
