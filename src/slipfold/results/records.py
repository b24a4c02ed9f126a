"""Contents of files besides arrays: model, input, versions, plain data."""

from __future__ import annotations

import json
import math
from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass, fields, is_dataclass
from datetime import UTC, datetime
from functools import cache, cached_property
from types import NoneType, UnionType
from typing import Annotated, Any, Union, cast, get_args, get_origin, get_type_hints

import numpy as np
from numpy.typing import NDArray

from slipfold.errors import InputError
from slipfold.models.friction.record import law_from_record, law_record
from slipfold.models.model import Model
from slipfold.models.nonlinear_mode import NonlinearMode
from slipfold.models.registry import built_in_models, model_named
from slipfold.models.sliding_oscillator import SlidingOscillator
from slipfold.models.system import System
from slipfold.models.unforced import Unforced
from slipfold.read_only import Documented
from slipfold.results.checks.checked import Checked
from slipfold.results.tables import LabeledTable
from slipfold.version import versions


def encoded(value: Any) -> Any:
    """Return what `json` can write; `decoded` makes the value of it again.

    >>> from slipfold.continuation.end import End
    >>> encoded((End("span", "it ends here", 0.5), None))
    [{'kind': 'span', 'reason': 'it ends here', 'values': [0.5]}, None]
    """
    if hasattr(value, "to_json"):
        return value.to_json()
    if is_dataclass(value):
        return {item.name: encoded(getattr(value, item.name)) for item in fields(value)}
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    if isinstance(value, Mapping):
        return {key: encoded(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [encoded(item) for item in value]
    return value


def decoded(kind: Any, value: Any) -> Any:
    """Return a value of a type, such as ``tuple[float, ...] | None``, from plain data.

    >>> decoded(tuple[float, ...] | None, [1, 2.5])
    (1.0, 2.5)
    """
    origin, inner = get_origin(kind), get_args(kind)
    if origin in (Union, UnionType):
        if value is None and NoneType in inner:
            return None
        (kind,) = (each for each in inner if each is not NoneType)
        return decoded(kind, value)
    if origin is np.ndarray:
        return np.array(value, get_args(inner[1])[0])
    if origin is tuple:
        kinds = inner[:1] * len(value) if inner[1:] == (...,) else inner
        return tuple(decoded(each, item) for each, item in zip(kinds, value, strict=True))
    if origin is not None and issubclass(origin, Mapping):
        return {key: decoded(inner[1], item) for key, item in value.items()}
    if hasattr(kind, "from_json"):
        return kind.from_json(value)
    if is_dataclass(kind) or hasattr(kind, "_fields"):
        types = types_of(cast(type, kind))
        if not is_dataclass(kind):
            value = dict(zip(types, value, strict=True))
        return cast(Any, kind)(**{key: decoded(types[key], item) for key, item in value.items()})
    return _checked(kind, value)


def _checked(kind: Any, value: Any) -> Any:
    """Convert a number or text, and refuse anything else."""
    if kind in (int, float, str, bool):
        numbers = (int, float, np.number, np.bool_)
        if not isinstance(value, str if kind is str else numbers):
            raise ValueError(f"{value!r} is not of type {kind.__name__}")
        return kind(value)
    return value


@cache
def types_of(kind: type) -> dict[str, Any]:
    """Return the types of the fields of a class."""
    return get_type_hints(kind)


def finite(value: Any) -> Any:
    """Return what JSON can hold: pairs for complex numbers, None for what is not finite.

    >>> finite({"a": (1, float("inf")), "b": 2 - 1j})
    {'a': [1, None], 'b': [2.0, -1.0]}
    """
    if isinstance(value, np.ndarray | np.generic):
        return finite(value.tolist())
    if isinstance(value, Mapping):
        return {key: finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [finite(item) for item in value]
    if isinstance(value, complex):
        return finite((value.real, value.imag))
    return None if isinstance(value, float) and not math.isfinite(value) else value


@dataclass(frozen=True)
class Provenance(Documented):
    """Versions that computed a result, and when."""

    slipfold: Annotated[str, "Versions."]
    heyoka: Annotated[str, ""]
    numpy: Annotated[str, ""]
    python: Annotated[str, ""]
    computed: Annotated[
        str | None,
        "When the computation ended: UTC, ISO 8601; None of a study, which ends more than once.",
    ] = None
    seconds: Annotated[float | None, "How long it took; likewise."] = None

    def attributes(self) -> dict[str, Any]:
        """Return it as attributes of a file."""
        known = {f"{name}_version": getattr(self, name) for name in VERSIONS}
        if self.computed is not None:
            known |= {"computed": self.computed, "seconds": self.seconds}
        return known

    @classmethod
    def from_attributes(cls, attributes: Mapping[str, Any]) -> Provenance:
        """Make it again from the attributes of a file."""
        known: dict[str, Any] = {name: str(attributes[f"{name}_version"]) for name in VERSIONS}
        if "computed" in attributes:
            known["computed"] = str(attributes["computed"])
            known["seconds"] = float(attributes["seconds"])
        return cls(**known)


VERSIONS = ("slipfold", "heyoka", "numpy", "python")
"""What has a version."""


def provenance(seconds: float | None = None) -> Provenance:
    """Describe a computation that has just ended after some seconds, or one without a time."""
    known = {name: version for name, version in versions().items() if name in VERSIONS}
    computed = None if seconds is None else datetime.now(UTC).isoformat(timespec="seconds")
    return Provenance(**known, computed=computed, seconds=seconds)


def structure_record(model: Model) -> dict[str, Any]:
    """Return the structure of a model, on which its equations depend, as plain data for JSON."""
    if not model.structure:
        return {}
    if isinstance(model, System):
        return {"definition": model.to_toml()}
    if isinstance(model, SlidingOscillator):
        return {"friction": law_record(model.friction)}
    if isinstance(model, NonlinearMode):
        return {"mode": _whole_record(model.forced_model)}
    if isinstance(model, Unforced):
        return {"forced": _whole_record(model.forced_model)}
    from slipfold.models.structures.structure import Structure  # most models are none

    return {"tables": model.to_tables()} if isinstance(model, Structure) else {}


def scales_record(model: Model) -> dict[str, Any]:
    """Return the state scales that a computation determined, by state; nothing if it did not."""
    if model.estimated_scales is None:
        return {}
    names, columns = [state.name for state in model.states], model.estimated_scales.T.tolist()
    return {"scales": dict(zip(names, columns, strict=True))}


def measured_as(model: Model, described: Mapping[str, Any]) -> Model:
    """Return a saved model with the scales of `scales_record`, if there are any."""
    if "scales" not in described:
        return model
    scales = np.array([described["scales"][item.name] for item in model.states])
    return model.with_scales(scales.T)


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
    kind: object = None,
) -> Model:
    """Make a saved model again."""
    for part, made in (("forced", Unforced), ("mode", NonlinearMode)):
        if part in structure:
            own = structure[part]
            base = model_from_record(own["model"], own["structure"], own["parameters"], kind)
            return made(base, **values)
    if kind is not None and not (isinstance(kind, type) and issubclass(kind, Model)):
        raise InputError(
            f"kind = {kind!r} is not the class of a model; give a class, e.g. SlidingOscillator"
        )
    from slipfold.models.structures.structure import Structure

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


@dataclass(frozen=True, eq=False)
class SavedTable:
    """Contents of a file, before a result is made from it."""

    table: LabeledTable
    given: Mapping[str, Any]
    """The input of the computation."""
    model: Model

    @cached_property
    def columns(self) -> dict[str, NDArray[Any]]:
        """The arrays by name."""
        return {name: item.values for name, item in self.table.real()}

    @property
    def attributes(self) -> Mapping[str, Any]:
        """Attributes of the file."""
        return self.table.attributes

    @property
    def provenance(self) -> Provenance:
        """Where the result comes from."""
        return Provenance.from_attributes(self.attributes)

    @property
    def checked(self) -> Checked | None:
        """The checks; files of earlier versions lack them."""
        text = self.attributes.get("checked")
        return None if text is None else Checked.from_json(json.loads(str(text)))

    def rows(self, dimension: str, owner: str) -> Mapping[int, NDArray[np.int64]]:
        """Return the rows along a dimension that belong to each owner; some have none."""
        owners = self.columns[owner]
        for name, item in self.table.variables.items():
            if item.dimensions[0] == dimension and len(item.values) != len(owners):
                raise ValueError(f"{name} has {len(item.values)} rows, not {len(owners)}")
        result = {int(key): np.flatnonzero(owners == key) for key in np.unique(owners)}
        return defaultdict(lambda: np.empty(0, np.int64), result)

    def complex(self, name: str) -> NDArray[np.complex128]:
        """Return a column of complex numbers."""
        real, imag = self.columns[f"{name}_real"], self.columns[f"{name}_imag"]
        values = np.empty(real.shape, complex)
        values.real, values.imag = real, imag  # exact, also where a part is not finite
        return values


def open_table(table: LabeledTable, kind: type[Model] | None = None) -> SavedTable:
    """Find out what a table was computed with."""
    given = json.loads(table.attributes["input"])
    parameters = given["parameters"]
    model = model_from_record(str(given["model"]), given.get("structure", {}), parameters, kind)
    return SavedTable(table, given, measured_as(model, given))
