"""The model that a command is about: a built-in one by name, or one from a case file."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from slipfold.errors import InputError

if TYPE_CHECKING:
    from slipfold.models.definitions.source import Source
    from slipfold.models.friction import FrictionLaw
    from slipfold.models.model import Model

__all__ = ["equations_file", "find_model"]

FORM = (
    'model = "sliding", or the name of a file with a system or structure, and a table '
    '[parameters] with lines such as f = 12.5 or alpha = "60deg", '
    'and it may have a table [friction] with e.g. law = "Stribeck"; '
    "a system of equations has a table [states], see slipfold models --show duffing, and a "
    "structure a table [structure], see slipfold models --show chain"
)


def find_model(given: str, changes: Mapping[str, str], friction: str | None = None) -> Model:
    """Make the model that a command names.

    >>> find_model("sliding", {"alpha": "30deg"}).alpha
    0.5235987755982988
    """
    from slipfold.models.registry import model_named

    law = None if friction is None else _law_named(friction)
    if not given.endswith(".toml"):
        return model_named(given, **_with_law(given, law), **changes)
    source = _source(given)
    own = _model_in(Path(given), source)
    if own is not None:
        return own.replace(**_with_law(given, law), **changes)
    unknown = sorted(set(source.tables) - {"model", "parameters", "friction"})
    if unknown:
        raise InputError(f"{given} has the unknown entry {unknown[0]!r}; a case file has {FORM}")
    name, values = source.tables.get("model"), source.tables.get("parameters", {})
    if not isinstance(name, str) or not isinstance(values, dict):
        raise InputError(f"{given} does not say which model it is about; a case file has {FORM}")
    if law is None and "friction" in source.tables:
        from slipfold.models.friction.law_reader import read_law

        law = read_law(source, ("friction",), source.tables["friction"])
    try:
        make: Callable[..., Model] = partial(model_named, name)
        if name.endswith(".toml"):
            make = _named_model(Path(given).parent / name).replace
        return make(**{**_with_law(name, law), **values, **changes})
    except InputError as error:
        raise InputError(f"{given}: {error}") from error


def equations_file(given: str) -> Path | None:
    """Return the file that holds the equations of a model that a command names."""
    if not given.endswith(".toml"):
        return None
    tables = _source(given).tables
    if "model" not in tables:
        return Path(given).absolute()
    name = tables["model"]
    return (Path(given).parent / name).absolute() if name.endswith(".toml") else None


def _model_in(path: Path, source: Source) -> Model | None:
    """Return the system or structure that a file holds; None if it is a case file."""
    from slipfold.models.structures import Structure
    from slipfold.models.system import System

    for table, kind in (("states", System), ("structure", Structure)):
        if "model" not in source.tables and table in source.tables:
            return kind.from_toml(path)
    return None


def _named_model(path: Path) -> Model:
    """Return the system or structure of a file that a case file names."""
    found = _model_in(path, _source(str(path)))
    if found is None:
        raise InputError(f"{path} holds no system or structure; give the name of a file that does")
    return found


def _law_named(name: str) -> FrictionLaw:
    """Return the law of a name, with its default values."""
    from slipfold.models.definitions.source import source_of_tables
    from slipfold.models.friction import friction_laws
    from slipfold.models.friction.law_reader import read_law

    exact = {law.lower(): law for law in friction_laws()}
    value = exact.get(name.lower(), name)
    return read_law(source_of_tables({}, "--friction"), ("--friction",), value)


def _with_law(name: str, law: FrictionLaw | None) -> dict[str, Any]:
    """Return the argument of a model for a friction law; empty without one."""
    from slipfold.models.registry import WITH_FRICTION

    if law is None:
        return {}
    if name not in WITH_FRICTION:
        raise InputError(
            f"{name} takes no friction law, which is for {' and '.join(WITH_FRICTION)}; give that "
            "of a structure's contact in its file, and leave it out for other models"
        )
    return {"friction": law}


def _source(given: str) -> Source:
    from slipfold.models.definitions.source import source_of_text

    return source_of_text(_read(given), given)


def _read(given: str) -> str:
    try:
        return Path(given).read_text(encoding="utf-8")
    except OSError as error:
        why = (error.strerror or str(error)).lower()
        raise InputError(
            f"{given} cannot be read ({why}); give another case file or the name of a model"
        ) from error
    except UnicodeDecodeError as error:
        raise InputError(f"{given} is not TOML ({error}); a case file has {FORM}") from error
