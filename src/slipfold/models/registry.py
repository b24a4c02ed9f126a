"""Models by name and by file."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from functools import lru_cache, partial
from importlib.resources import files
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any

from slipfold.errors import InputError
from slipfold.models.definitions.source import Source, source_of_text
from slipfold.models.friction.law import FrictionLaw
from slipfold.models.friction.record import read_law
from slipfold.models.model import Model
from slipfold.models.sliding_oscillator import SlidingOscillator
from slipfold.models.structures.structure import Structure
from slipfold.models.suggestion import not_supported, suggest
from slipfold.models.system import System

WITH_FRICTION = ("sliding", "steady-sliding")
"""Models that take a friction law as ``friction``."""

_KINDS: tuple[type[Model], ...] = (SlidingOscillator,)


def built_in_models() -> dict[str, Callable[..., Model]]:
    """Return what makes the models that come with the package, by name.

    Examples
    --------
    >>> built_in_models()["sliding"](Nd=0.1)
    SlidingOscillator(Nd=0.1)
    >>> built_in_models()["duffing"](W=1.2)
    System('duffing', W=1.2)
    """
    classes: dict[str, Callable[..., Model]] = {kind.name: kind for kind in _KINDS}
    classes["steady-sliding"] = _steady_sliding
    return {**classes, **{name: partial(_from_file, name) for name in _files()}}


def built_in_text(name: str) -> str:
    """Return the TOML text of a built-in system of equations or structure.

    >>> print(built_in_text("duffing").splitlines()[0])
    # Duffing's oscillator: q'' + d q' + k q + g q^3 = F cos(W t).
    """
    _check(name)
    if name not in _files():
        raise InputError(
            f"{name} is written in Python and has no TOML text; the models that have one are "
            f"{', '.join(_files())}"
        )
    return _files()[name].read_text(encoding="utf-8")


def model_named(name: str, **values: Any) -> Model:
    """Make a built-in model.

    >>> model_named("sliding", f=12.2)
    SlidingOscillator(f=12.2)
    """
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
    found = {}
    for folder in (models / "systems", models / "structures" / "examples"):
        names = (item.name for item in folder.iterdir())
        for name in sorted(name for name in names if name.endswith(".toml")):
            found[name.removesuffix(".toml")] = folder / name
    return found


@lru_cache(maxsize=64)
def _default(name: str) -> Model:
    source = source_of_text(built_in_text(name))
    if "structure" in source.tables:
        return Structure.from_tables(source.tables)
    return System(source.tables)


def _from_file(name: str, **values: Any) -> Model:
    return _default(name).replace(**values)


def _steady_sliding(friction: FrictionLaw | None = None, **values: Any) -> Model:
    return SlidingOscillator(friction).steady().replace(**values)


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
        law = source.read(read_law, source.tables["friction"], ("friction",))
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
