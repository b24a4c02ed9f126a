"""The built-in models by name: classes, and systems of equations and structures in files."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache, partial
from importlib.resources import files
from importlib.resources.abc import Traversable
from typing import Any

from slipfold.errors import InputError
from slipfold.models.definitions.source import source_of_text
from slipfold.models.friction import FrictionLaw
from slipfold.models.model import Model
from slipfold.models.sliding_oscillator import SlidingOscillator
from slipfold.models.structures import Structure
from slipfold.models.suggestion import suggest
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
