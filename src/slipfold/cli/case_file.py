"""The model that a command is about: a built-in one by name, or one from a case file."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from slipfold.errors import InputError

if TYPE_CHECKING:
    from slipfold.models.model import Model

__all__ = ["find_model"]

FORM = (
    'model = "sliding" and a table [parameters] with lines such as f = 12.5 or alpha = "60deg"; '
    "a system of equations has a table [states], see slipfold models --show duffing, and a "
    "structure a table [structure], see slipfold models --show chain"
)


def find_model(given: str, changes: Mapping[str, str]) -> Model:
    """Make the model that a command names.

    Parameters
    ----------
    given
        Name of a built-in model, or a file ``....toml``: a case with ``model = "sliding"`` and a
        table ``[parameters]``, a system of equations with a table ``[states]``, or a structure
        from matrices with a table ``[structure]``.
    changes
        Values of parameters that replace those of the file.

    Raises
    ------
    InputError
        If there is no such model or file, or a value cannot be used.

    Examples
    --------
    >>> find_model("sliding", {"alpha": "30deg"}).alpha
    0.5235987755982988
    """
    from slipfold.models.registry import model_named
    from slipfold.models.structures import Structure
    from slipfold.models.system import System

    if not given.endswith(".toml"):
        return model_named(given, **changes)
    text = _read(given)
    case = _parsed(given, text)
    if "model" not in case and "states" in case:
        return System.from_toml(Path(given)).replace(**changes)
    if "model" not in case and "structure" in case:
        return Structure.from_toml(Path(given)).replace(**changes)
    unknown = sorted(set(case) - {"model", "parameters"})
    if unknown:
        raise InputError(f"{given} has the unknown entry {unknown[0]!r}; a case file has {FORM}")
    name, values = case.get("model"), case.get("parameters", {})
    if not isinstance(name, str) or not isinstance(values, dict):
        raise InputError(f"{given} does not say which model it is about; a case file has {FORM}")
    try:
        return model_named(name, **{**values, **changes})
    except InputError as error:
        raise InputError(f"{given}: {error}") from error


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


def _parsed(given: str, text: str) -> dict[str, Any]:
    from slipfold.models.system_source import source_of_text

    return dict(source_of_text(text, given).tables)
