"""A walk over the public interface: the names in ``slipfold.__all__`` and their methods."""

import dataclasses
import enum
import functools
import importlib
import inspect
import pkgutil
import sys
from collections.abc import Iterator
from typing import Any, NamedTuple

from numpydoc.docscrape import NumpyDocString
from numpydoc.docscrape import Parameter as DocumentedParameter

import slipfold


class PublicObject(NamedTuple):
    """A public class, function, method or property, and the name that users call it by."""

    name: str
    value: Any


def module_names() -> list[str]:
    """Return the names of the package's modules, itself first."""
    found = pkgutil.walk_packages(slipfold.__path__, prefix="slipfold.", onerror=_raise)
    return ["slipfold", *(m.name for m in found if not m.name.endswith(".__main__"))]


def public_objects(name: str) -> list[PublicObject]:
    """Return a public class with its own methods and properties, or a public function."""
    value = getattr(slipfold, name, None)
    if inspect.isclass(value):
        return [PublicObject(name, value), *_members(name, value)]
    if inspect.isroutine(value) or isinstance(value, functools._lru_cache_wrapper):
        return [PublicObject(name, value)]
    return []


def parameters(value: Any) -> dict[str, inspect.Parameter]:
    """Return the parameters that a caller passes, by the names that a docstring gives them."""
    if isinstance(value, property | functools.cached_property) or not _is_called(value):
        return {}
    stars = {inspect.Parameter.VAR_POSITIONAL: "*", inspect.Parameter.VAR_KEYWORD: "**"}
    signature = inspect.signature(value)
    return {
        stars.get(p.kind, "") + p.name: p
        for p in signature.parameters.values()
        if p.name not in ("self", "cls") and not p.name.startswith("_")
    }


def default(owner: Any, parameter: inspect.Parameter) -> Any:
    """Return the default of a parameter, made by its factory where it has one."""
    if dataclasses.is_dataclass(owner):
        for field in dataclasses.fields(owner):
            if field.name == parameter.name and field.default_factory is not dataclasses.MISSING:
                return field.default_factory()
    pydantic_field = getattr(owner, "model_fields", {}).get(parameter.name)
    if pydantic_field is not None and not pydantic_field.is_required():
        return pydantic_field.get_default(call_default_factory=True)
    return parameter.default


def documented(value: Any) -> dict[str, DocumentedParameter]:
    """Return what the docstring says of each parameter, by name.

    A class documents each field once, as a parameter or as an attribute. A method that overrides
    another may leave its parameters to that one's docstring.
    """
    own = _sections(value)
    overridden = [entry for base in _overridden(value) for entry in _sections(base).items()]
    left_out = {name: entry for name, entry in reversed(overridden) if name in parameters(value)}
    return left_out | own


def _sections(value: Any) -> dict[str, DocumentedParameter]:
    doc = NumpyDocString(inspect.getdoc(value) or "")
    sections = ["Parameters", "Other Parameters"]
    if inspect.isclass(value):
        sections.append("Attributes")
    return {
        name.strip().replace("\\", ""): entry
        for section in sections
        for entry in doc[section]
        for name in entry.name.split(",")
    }


def _overridden(value: Any) -> list[Any]:
    """Return the methods of base classes that this one takes the place of, the nearest first."""
    if not inspect.isfunction(value):
        return []
    owner = getattr(sys.modules[value.__module__], value.__qualname__.rpartition(".")[0], None)
    bases = owner.__mro__[1:] if inspect.isclass(owner) else ()
    return [vars(base)[value.__name__] for base in bases if value.__name__ in vars(base)]


def _members(class_name: str, cls: type) -> Iterator[PublicObject]:
    seen: set[str] = set()
    for base in cls.__mro__:
        if not base.__module__.startswith("slipfold"):
            continue
        for name, raw in vars(base).items():
            if name.startswith("_") or name in seen:
                continue
            seen.add(name)
            if isinstance(raw, property | functools.cached_property):
                yield PublicObject(f"{class_name}.{name}", raw)
            elif inspect.isfunction(raw) or isinstance(raw, classmethod | staticmethod):
                yield PublicObject(f"{class_name}.{name}", getattr(cls, name))


def _is_called(value: Any) -> bool:
    """Tell whether users call this object with parameters of the package's own."""
    if not inspect.isclass(value):
        return True
    if issubclass(value, enum.Enum) or getattr(value, "_is_protocol", False):
        return False
    if issubclass(value, BaseException):
        return inspect.isfunction(value.__init__)  # else it takes what any exception takes
    return not inspect.isabstract(value)


def _raise(name: str) -> None:
    importlib.import_module(name)
