"""The model that a command is about: a built-in one by name, or one from a case file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from slipfold.cli.parsing import parse_assignments, parse_span, refuse_varied

if TYPE_CHECKING:
    from slipfold.models.friction import FrictionLaw
    from slipfold.models.model import Model


def find_model(given: str, changes: Mapping[str, str], friction: str | None = None) -> Model:
    """Make the model that a command names.

    >>> find_model("sliding", {"alpha": "30deg"}).alpha
    0.5235987755982988
    """
    from slipfold.models.case_file import model_of_file, with_law
    from slipfold.models.registry import model_named

    law = None if friction is None else _law_named(friction)
    if given.endswith(".toml"):
        return model_of_file(given, changes, law)
    return model_named(given, **with_law(given, law), **changes)


def find_varied(
    given: str, vary: Sequence[str], set_: Sequence[str] | None, friction: str | None = None
) -> tuple[Model, str, tuple[float, float]]:
    """Make the model that a command names, and read the parameter it varies with its ends.

    >>> find_varied("sliding", ["Nd=0:0.98"], ["f=12.5"])[1:]
    ('Nd', (0.0, 0.98))
    """
    changes = parse_assignments(set_)
    model = find_model(given, changes, friction)
    name, span = parse_span(vary, model)
    refuse_varied(changes, (name,))
    return model, name, span


def equations_file(given: str) -> Path | None:
    """Return the file that holds the equations of a model that a command names."""
    from slipfold.models.case_file import read_case_file

    if not given.endswith(".toml"):
        return None
    tables = read_case_file(given).tables
    if "model" not in tables:
        return Path(given).absolute()
    name = tables["model"]
    return (Path(given).parent / name).absolute() if name.endswith(".toml") else None


def _law_named(name: str) -> FrictionLaw:
    """Return the law of a name, with its default values."""
    from slipfold.models.definitions.source import source_of_tables
    from slipfold.models.friction import friction_laws
    from slipfold.models.friction.law_reader import read_law

    exact = {law.lower(): law for law in friction_laws()}
    value = exact.get(name.lower(), name)
    return read_law(source_of_tables({}, "--friction"), ("--friction",), value)
