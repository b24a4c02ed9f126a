"""The built-in models by name."""

from __future__ import annotations

from slipfold.errors import InputError
from slipfold.models.model import Model
from slipfold.models.sliding_oscillator import SlidingOscillator
from slipfold.models.suggestion import suggest

__all__ = ["built_in_models", "model_named"]

_KINDS: tuple[type[Model], ...] = (SlidingOscillator,)


def built_in_models() -> dict[str, type[Model]]:
    """Return the kinds of model that come with the package, by name.

    Examples
    --------
    >>> built_in_models()["sliding"](Nd=0.1)
    SlidingOscillator(Nd=0.1)
    """
    return {kind.name: kind for kind in _KINDS}


def model_named(name: str, **values: float | str) -> Model:
    """Make a built-in model.

    Parameters
    ----------
    name
        Its name, e.g. ``"sliding"``.
    **values
        Parameter values that differ from the defaults.

    Raises
    ------
    InputError
        If there is no such model, or a value cannot be used.

    Examples
    --------
    >>> model_named("sliding", f=12.2)
    SlidingOscillator(f=12.2)
    """
    kinds = built_in_models()
    if name not in kinds:
        raise InputError(
            f"there is no model {name!r}; {suggest(name, kinds)}"
            f"the built-in models are: {', '.join(kinds)}"
        )
    return kinds[name](**values)
