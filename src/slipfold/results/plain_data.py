"""Data classes as plain data for JSON, and back by the types of their fields."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from functools import cache
from types import NoneType, UnionType
from typing import Any, Union, cast, get_args, get_origin, get_type_hints

import numpy as np


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
    """Return a number or text, which must be one."""
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
