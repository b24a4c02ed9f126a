"""Declarations of parameters: what is said of them, how they are checked and documented."""

from __future__ import annotations

import difflib
import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import wraps
from numbers import Integral, Real
from typing import Annotated, Any, ForwardRef, TypeVar, cast, get_args

from slipfold.errors import InputError
from slipfold.read_only import with_parameters

SIMILAR = 0.8
"""Minimum similarity of a word that counts as a misspelled argument."""

Function = TypeVar("Function", bound=Callable[..., Any])

METAVARS = {
    "text": "TEXT", "texts": "TEXT", "flag": "", "whole": "N", "wholes": "N", "number": "R",
    "numbers": "R", "pair": "FROM:TO", "grid": "N1xN2", "intervals": "NAME=FIRST:LAST",
    "values": "NAME=VALUE", "entries": "NAME=VALUE", "spans": "NAME=FIRST:LAST",
    "starts": "NAME=VALUE,...",
}  # fmt: skip
"""Kinds of parameters, and what a command calls their values: ``entries`` are always by name."""

TYPES = {bool: "flag", int: "whole", int | None: "whole", float: "number"}
"""Kinds by type; where the type does not determine it, a declaration names its kind."""


@dataclass(frozen=True)
class Option:
    """What is said of a parameter wherever it can be given, and how a command reads it."""

    help: str
    kind: str = "text"
    metavar: str = ""
    minimum: int = 1  # of a whole number
    maximum: int | None = None
    flags: tuple[str, ...] = ()  # names on the command line, if not that of the parameter
    command_help: str = ""  # what a command says instead
    choices: Mapping[str, Any] | None = None  # values by the words of a command

    def checked(self, name: str, value: Any) -> Any:
        """Return the value of an argument, or raise."""
        if self.kind == "whole":
            return self._whole(name, value)
        if self.kind == "grid":
            pair = value if isinstance(value, tuple | list) else (value, value)
            if len(pair) != 2:
                raise InputError(f"{name} = {value!r} are not two numbers; give e.g. (60, 50)")
            return self._whole(name, pair[0]), self._whole(name, pair[1])
        if self.kind in ("intervals", "entries") and not isinstance(value, Mapping):
            raise InputError(
                f"{name} = {value!r} is not by name; give e.g. {name}={{'x': {self.example}}}"
            )
        if self.kind == "texts" and (isinstance(value, str | Real) or not iterable(value)):
            return (value,)
        if self.kind == "pair" and (isinstance(value, str) or not iterable(value, 2)):
            raise InputError(f"{name} = {value!r} are not two values; give e.g. (0, 1)")
        if self.kind == "flag" and type(value).__name__ not in ("bool", "bool_", "dict"):
            raise InputError(f"{name} = {value!r} is not True or False; give one of them")
        if self.kind == "number":
            number = isinstance(value, Real) and not isinstance(value, bool)
            if not (number and 0 < value < float("inf")):
                raise InputError(f"{name} = {value!r} is not a positive number; give e.g. 1e-9")
            return float(value)
        return value

    @property
    def example(self) -> str:
        """A value of an entry."""
        return "(0, 1)" if self.kind == "intervals" else "0.1"

    def _whole(self, name: str, value: Any) -> int:
        whole = isinstance(value, Integral) and not isinstance(value, bool)
        if not whole or value < self.minimum or (self.maximum or value) < value:
            ends = f"of at least {self.minimum}"
            raise InputError(f"{name} = {value!r} is not a whole number {ends}; give one")
        return int(value)

    def __get_pydantic_core_schema__(self, source: Any, handler: Callable[[Any], Any]) -> Any:
        """Give numbers in a file their bounds: tolerances are positive."""
        from pydantic import Field

        kind = next((kind for type_, kind in TYPES.items() if type_ == source), self.kind)
        if kind not in ("whole", "number"):
            return handler(source)
        whole = kind == "whole"
        bounds = Field(ge=self.minimum, le=self.maximum) if whole else Field(gt=0)
        return handler(Annotated[source, bounds])


def iterable(value: Any, count: int | None = None) -> bool:
    """Whether something has items, and as many.

    >>> iterable((1, 2), 2), iterable(0.5)
    (True, False)
    """
    try:
        return count in (None, len(tuple(value)))
    except TypeError:
        return False


def flags_of(name: str, option: Option) -> tuple[str, ...]:
    """Return the names of a parameter on the command line."""
    return option.flags or (f"--{name.replace('_', '-')}",)


USUAL = {
    "model": "The model, e.g. ``SlidingOscillator()``.",
    "settings": "Options of continuation; the defaults of `slipfold.Settings` if None.",
    "events": "Values of outputs or of the parameter, or extrema along a branch, to locate.",
    "on_progress": "Receives a `slipfold.Progress` now and then. If it raises "
    "`KeyboardInterrupt`, or the user does, finished results are returned.",
    "**parameters": "Parameters of the model to change first: numbers in SI units, or text with a "
    "unit.",
}
"""What is said of parameters that mean the same in every computation."""


def documented(function: Function) -> Function:
    """Write the parameters' section of a docstring, and check arguments, by their types.

    >>> Seed = Annotated[int, Option("Seed of noise.", "whole", minimum=0)]
    >>> @documented
    ... def demo(seed: Seed = 0):
    ...     '''Show it.
    ...
    ...     Returns
    ...     -------
    ...     int
    ...     '''
    >>> "Seed of noise." in demo.__doc__
    True
    >>> demo(seed=-1)
    Traceback (most recent call last):
    ...
    slipfold.errors.InputError: seed = -1 is not a whole number of at least 0; give one
    """
    meanings, options = dict[str, str](), dict[str, Option]()
    signature = resolved(function)
    for item in signature.parameters.values():
        name = "**" * (item.kind is item.VAR_KEYWORD) + item.name
        option = declared(item.annotation)
        if option is not None:
            options[name] = option
        meanings[name] = USUAL[name] if option is None else option.help
    function.__doc__ = with_parameters(function.__doc__, meanings)

    @wraps(function)
    def checked(*given: Any, **named: Any) -> Any:
        bound = signature.bind(*given, **named)
        for name, value in bound.arguments.items():
            optional = value is None and signature.parameters[name].default is None
            if name == "on_progress" and not optional and not callable(value):
                raise InputError(f"on_progress = {value!r} is not a function; give one")
            if name in options and not optional:
                bound.arguments[name] = options[name].checked(name, value)
        for name in bound.arguments.get("parameters", ()):
            meant = difflib.get_close_matches(name, signature.parameters, 1, SIMILAR)
            known = getattr(given[0], "values", {}) if given else {}
            if meant and name not in known and meant[0] not in known:
                raise InputError(
                    f"{function.__name__} takes no {name}; did you mean {meant[0]}? "
                    f"its arguments are {', '.join(signature.parameters)}"
                )
        return function(*bound.args, **bound.kwargs)

    return cast(Function, checked)


def resolved(function: Callable[..., Any]) -> inspect.Signature:
    """Return a signature with the types that its annotations name, where they are imported."""
    names, signature = inspect.unwrap(function).__globals__, inspect.signature(function)

    def typed(item: inspect.Parameter) -> inspect.Parameter:
        module, _, name = str(item.annotation).rpartition(".")
        known = vars(names[module]) if module in names else names
        return item.replace(annotation=known.get(name, item.annotation))

    return signature.replace(parameters=list(map(typed, signature.parameters.values())))


def default_of(function: Callable[..., Any], name: str) -> Any:
    """Return the default of a parameter.

    >>> def demo(seed: int = 7): ...
    >>> default_of(demo, "seed")
    7
    """
    return inspect.signature(function).parameters[name].default


def declared(annotation: Any) -> Option | None:
    """Return the declaration of a parameter by its type, None if there is none."""
    given = get_args(annotation)
    option = next((item for item in given if isinstance(item, Option)), None)
    if option is None or option.kind != "text" or isinstance(given[0], str | ForwardRef):
        return option
    kind = next((kind for type_, kind in TYPES.items() if type_ == given[0]), "text")
    return replace(option, kind=kind)
