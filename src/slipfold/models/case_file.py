"""The model that a case file is about: its name, its parameters, its friction law."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from functools import partial
from pathlib import Path
from typing import Any

from slipfold.errors import InputError
from slipfold.models.definitions.source import Source, source_of_text
from slipfold.models.friction import FrictionLaw
from slipfold.models.friction.law_reader import read_law
from slipfold.models.model import Model
from slipfold.models.registry import WITH_FRICTION, model_named
from slipfold.models.structures import Structure
from slipfold.models.suggestion import not_supported
from slipfold.models.system import System

FORM = (
    'model = "sliding", or the name of a file with a system or structure, and a table '
    '[parameters] with lines such as f = 12.5 or alpha = "60deg", '
    'and it may have a table [friction] with e.g. law = "Stribeck"; '
    "a system of equations has a table [states], see slipfold models --show duffing, and a "
    "structure a table [structure], see slipfold models --show chain"
)


def read_case_file(given: str, wanted: str = "another case file or the name of a model") -> Source:
    """Read a TOML file; say what is wanted where there is none."""
    try:
        text = Path(given).read_text(encoding="utf-8")
    except OSError as error:
        why = (error.strerror or str(error)).lower()
        raise InputError(f"{given} cannot be read ({why}); give {wanted}") from error
    except UnicodeDecodeError as error:
        raise InputError(f"{given} is not TOML ({error}); a case file has {FORM}") from error
    return source_of_text(text, given)


def model_of_file(given: str, changes: Mapping[str, str], law: FrictionLaw | None = None) -> Model:
    """Make the model of a file: a case, a system of equations or a structure."""
    source = read_case_file(given)
    own = _model_in(Path(given), source)
    if own is not None:
        return own.replace(**with_law(given, law), **changes)
    return model_of_case(source, Path(given).parent, changes, law)


def model_of_case(
    source: Source,
    folder: Path,
    changes: Mapping[str, Any],
    law: FrictionLaw | None = None,
    others: Collection[str] = (),
) -> Model:
    """Make the model that a case is about; it may have some other tables, too."""
    given = source.label
    unknown = sorted(set(source.tables) - {"model", "parameters", "friction", *others})
    if unknown:
        refused = not_supported(unknown[0])
        raise InputError(
            f"{given} has the unknown entry {unknown[0]!r}; {refused}a case file has {FORM}"
        )
    name, values = source.tables.get("model"), source.tables.get("parameters", {})
    if not isinstance(name, str) or not isinstance(values, dict):
        raise InputError(f"{given} does not say which model it is about; a case file has {FORM}")
    if law is None and "friction" in source.tables:
        law = read_law(source, ("friction",), source.tables["friction"])
    try:
        make: Callable[..., Model] = partial(model_named, name)
        if name.endswith(".toml"):
            make = _named_model(folder / name).replace
        return make(**{**with_law(name, law), **values, **changes})
    except InputError as error:
        raise InputError(f"{given}: {error}") from error


def with_law(name: str, law: FrictionLaw | None) -> dict[str, Any]:
    """Return the argument of a model for a friction law; empty without one."""
    if law is None:
        return {}
    if name not in WITH_FRICTION:
        raise InputError(
            f"{name} takes no friction law, which is for {' and '.join(WITH_FRICTION)}; give that "
            "of a structure's contact in its file, and leave it out for other models"
        )
    return {"friction": law}


def _model_in(path: Path, source: Source) -> Model | None:
    """Return the system or structure that a file holds; None if it is a case file."""
    for table, kind in (("states", System), ("structure", Structure)):
        if "model" not in source.tables and table in source.tables:
            return kind.from_toml(path)
    return None


def _named_model(path: Path) -> Model:
    """Return the system or structure of a file that a case file names."""
    found = _model_in(path, read_case_file(str(path)))
    if found is None:
        raise InputError(f"{path} holds no system or structure; give the name of a file that does")
    return found
