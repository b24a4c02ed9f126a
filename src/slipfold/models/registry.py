"""Models by name and by file."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from functools import lru_cache, partial
from importlib.resources import files
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from slipfold.errors import InputError, not_supported, suggest
from slipfold.models.definitions.source import Source, source_of_file, source_of_text
from slipfold.models.definitions.tables import WrongEntry, check_keys, type_name
from slipfold.models.friction.law import FrictionLaw
from slipfold.models.friction.record import read_law
from slipfold.models.model import Model
from slipfold.models.sliding_oscillator import SlidingOscillator
from slipfold.models.system import System

if TYPE_CHECKING:
    from slipfold.models.structures.structure import Structure

WITH_FRICTION = ("sliding", "steady-sliding")
"""Models that take a friction law as ``friction``."""


def built_in_models() -> dict[str, Callable[..., Model]]:
    """Return what makes the models that come with the package, by name.

    Examples
    --------
    >>> built_in_models()["sliding"](Nd=0.1)
    SlidingOscillator(Nd=0.1)
    >>> built_in_models()["duffing"](W=1.2)
    System('duffing', W=1.2)
    """
    return {
        SlidingOscillator.name: SlidingOscillator,
        "steady-sliding": _steady_sliding,
        **{name: partial(_from_file, name) for name in _files()},
    }


def built_in_text(name: str) -> str:
    """Return the TOML text of a built-in system of equations or structure."""
    _check(name)
    if name not in _files():
        raise InputError(
            f"{name} is written in Python and has no TOML text; the models that have one are "
            f"{', '.join(_files())}"
        )
    return _files()[name].read_text(encoding="utf-8")


def model_named(name: str, **values: Any) -> Model:
    """Make a built-in model."""
    _check(name)
    return built_in_models()[name](**values)


def _check(name: str) -> None:
    names = built_in_models()
    if name not in names:
        raise InputError(
            f"there is no model {name!r}; {suggest(name, names)}"
            f"the built-in models are: {', '.join(names)}"
        )


@lru_cache(maxsize=1)
def _files() -> dict[str, Traversable]:
    """Return the file of each model that comes as one: systems, then structures."""
    models = files("slipfold.models")
    named = {}
    for folder in (models / "systems", models / "structures" / "examples"):
        names = (item.name for item in folder.iterdir())
        for name in sorted(name for name in names if name.endswith(".toml")):
            named[name.removesuffix(".toml")] = folder / name
    return named


def _structure() -> type[Structure]:
    """Return the class of structures, imported where a model is one."""
    from slipfold.models.structures.structure import Structure

    return Structure


@lru_cache(maxsize=64)
def _default(name: str) -> Model:
    source = source_of_text(built_in_text(name))
    made = _structure().from_tables if "structure" in source.tables else System
    return made(source.tables)


def _from_file(name: str, **values: Any) -> Model:
    return _default(name).replace(**values)


def _steady_sliding(friction: FrictionLaw | None = None, **values: Any) -> Model:
    return SlidingOscillator(friction).steady().replace(**values)


EXAMPLE = (
    'model = "sliding", or the name of a file with a system of equations, which has a table '
    "[states], see slipfold models --show duffing, or a structure, which has a table [structure], "
    "see slipfold models --show chain"
)
CASE_FILE = "the path of another case file, or the name of a model"


def model_of_file(given: str, changes: Mapping[str, str], law: FrictionLaw | None = None) -> Model:
    """Make the model of a file: a case, a system of equations or a structure."""
    path = Path(given)
    source = source_of_file(path, CASE_FILE)
    own = _model_in(source, path.parent, path.stem)
    if own is not None:
        return own.replace(**with_law(given, law), **changes)
    return model_of_case(source, path.parent, changes, law)


def model_of_text(text: str, label: str = "", folder: Path | None = None) -> Model:
    r"""Make the model of a text: a case of a built-in model, a system or a structure.

    `label` is what messages call the text, `folder` where its files with matrices are; it may name
    none if that is None.

    >>> model_of_text('model = "duffing"\n[parameters]\nW = 1.2')
    System('duffing', W=1.2)
    """
    source = source_of_text(text, label)
    own = _model_in(source, folder, Path(label).stem)
    return model_of_case(source, None, {}) if own is None else own


def model_of_case(
    source: Source,
    folder: Path | None,
    changes: Mapping[str, Any],
    law: FrictionLaw | None = None,
    others: Collection[str] = (),
) -> Model:
    """Make the model that a case is about; it may have some other tables, too.

    Without a folder it names a built-in model and no file.
    """

    def make(tables: Mapping[str, Any]) -> Model:
        if "model" not in tables:
            refused = next(filter(None, map(not_supported, tables)), "")
            raise WrongEntry(f"has no model; {refused}give e.g. {EXAMPLE}")
        check_keys(tables, ["model", "parameters", "friction", *others], {})
        name, values = tables["model"], tables.get("parameters", {})
        if not isinstance(name, str):
            raise WrongEntry(f"is {type_name(name)}; give e.g. {EXAMPLE}", path=["model"])
        if not isinstance(values, Mapping):
            message = f"is {type_name(values)}, not a table; give values by name, e.g. f = 12.5"
            raise WrongEntry(message, path=["parameters"])
        made: Callable[..., Model] = partial(model_named, name)
        if name.endswith(".toml") and folder is None:
            message = f"= {name[:80]!r} is the name of a file, but this text is in none; "
            raise WrongEntry(f"{message}give e.g. {EXAMPLE}", path=["model"])
        if name.endswith(".toml") and folder is not None:
            made = _named_model(folder / name).replace
        return made(**{**with_law(name, own_law), **values, **changes})

    own_law = law
    if law is None and "friction" in source.tables:
        own_law = source.read(read_law, source.tables["friction"], ("friction",))
    return source.read(make, source.tables, root="a case file")


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


def _model_in(source: Source, folder: Path | None, name: str) -> Model | None:
    """Return the system or structure that a text holds, `name` if it has none; None for a case."""
    if "model" in source.tables:
        return None
    if "states" in source.tables:
        return System._read(source, name or "system")
    if "structure" not in source.tables:
        return None
    return _structure()._read(source, folder, name or "structure")


def _named_model(path: Path) -> Model:
    """Return the system or structure of a file that a case file names."""
    model = _model_in(source_of_file(path, CASE_FILE), path.parent, path.stem)
    if model is None:
        raise InputError(f"{path} holds no system or structure; give the name of a file that does")
    return model
