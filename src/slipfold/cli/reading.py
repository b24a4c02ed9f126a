"""What commands read: models, values and options, as they are declared in `slipfold.options`."""

from __future__ import annotations

import inspect
import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, get_args

import typer

from slipfold.cli.running import Outputs
from slipfold.errors import InputError
from slipfold.options import Option

if TYPE_CHECKING:
    from slipfold.branches.settings import Event, Settings
    from slipfold.models.friction.law import FrictionLaw
    from slipfold.models.model import Model

_EVENT = re.compile(r"\s*(?:(\w+)\s*\(\s*(\w+)\s*\)|(\w+))\s*=(.*)", re.DOTALL)

_NUMBER = re.compile(r"\s*[-+]?[\d.]+(?:[eE][-+]?\d+)?\s*")

REPEATABLE = ("texts", "intervals", "states", "values", "spans")
"""Kinds of options that may be given several times."""

Values = Mapping[str, Any]


# -- commands ----------------------------------------------------------------------------------


@dataclass(frozen=True)
class Reader:
    """A parameter of a command: its options on the command line, and how its value is read."""

    options: tuple[inspect.Parameter, ...]
    read: Callable[[Values, Values], Any]  # from the texts given, and the values read before
    rank: int = 2  # the lowest is read first


def command(function: Callable[..., Any]) -> Callable[..., Any]:
    """Make a command of a function of values: its options follow from the parameters' types."""
    readers: dict[str, Reader] = {}
    for item in inspect.signature(function).parameters.values():
        declared = get_args(function.__globals__.get(item.annotation))[1:]
        (result,) = (each for each in declared if isinstance(each, Option | Reader))
        readers[item.name] = (
            result if isinstance(result, Reader) else _reader(item.name, result, item.default)
        )

    def run(**given: Any) -> Any:
        values: dict[str, Any] = {}
        for name, reader in sorted(readers.items(), key=lambda pair: pair[1].rank):
            values[name] = reader.read(given, values)
        return function(**values)

    options = [option for reader in readers.values() for option in reader.options]
    options.sort(key=lambda option: option.default is not inspect.Parameter.empty)
    run.__name__, run.__doc__ = function.__name__, function.__doc__
    run.__annotations__ = {option.name: option.annotation for option in options}
    run.__wrapped__ = function  # type: ignore[attr-defined]
    run.__signature__ = inspect.Signature(options)  # type: ignore[attr-defined]
    return run


def option(
    name: str, declared: Option, default: Any = inspect.Parameter.empty
) -> inspect.Parameter:
    """Return an option of the command line."""
    several, flag = declared.kind in REPEATABLE, declared.kind == "flag"
    help_ = re.sub(r"(?<!`)`(\w+)`(?!`)", r"--\1", declared.command_help or declared.help)
    help_ = help_.replace("`", "") + " Repeatable." * (several and declared.kind != "spans")
    flags = declared.flags or (f"--{name.replace('_', '-')}",)
    how = typer.Option(*flags, metavar=declared.metavar, help=help_)
    kind: Any = bool if flag else list[str] if several else str
    if not flag and default is not inspect.Parameter.empty:
        several_or_none = several or default is None
        default = None if several_or_none else _as_text(default)
        kind = kind | None if several_or_none else kind
    annotation = Annotated[kind, how]
    return inspect.Parameter(
        name, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=annotation
    )


def _as_text(default: Any) -> str:
    return "x".join(map(str, default)) if isinstance(default, tuple) else str(default)


def _reader(name: str, declared: Option, default: Any) -> Reader:
    flag = (declared.flags or (f"--{name.replace('_', '-')}",))[0]

    def read(given: Values, values: Values) -> Any:
        text = given[name]
        if text is None or declared.kind in ("text", "texts", "flag", "spans"):
            return text
        if declared.kind == "whole":
            return parse_whole(text, flag, declared.minimum)
        if declared.kind == "number":
            return parse_number(text, flag)
        if declared.kind == "grid":
            return parse_points(text, flag, declared.minimum)
        if declared.kind == "intervals":
            return parse_box(text, flag)
        if declared.kind == "states":
            return parse_states(text, values["model"])
        return parse_assignments(text, flag)

    return Reader((option(name, declared, default),), read)


def argument(
    metavar: str, help_: str, name: str = "model", default: Any = inspect.Parameter.empty
) -> inspect.Parameter:
    """Return an argument of the command line, by default the model."""
    kind: Any = str if default is inspect.Parameter.empty else str | None
    annotation = Annotated[kind, typer.Argument(metavar=metavar, help=help_)]
    return inspect.Parameter(
        name, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=annotation
    )


def given_text(item: inspect.Parameter) -> Reader:
    """Return a parameter that is read as it is given."""
    return Reader((item,), lambda given, _: given[item.name])


SET = option(
    "set_",
    Option(
        "Value of a parameter: in SI units, or with a unit, e.g. alpha=60deg.",
        "texts",
        "NAME=VALUE",
        flags=("--set",),
    ),
    None,
)

FRICTION = option(
    "friction",
    Option(
        "Friction law of the sliding oscillator, e.g. stribeck; its parameters are then set and "
        "varied like others, see slipfold models sliding --friction LAW.",
        metavar="LAW",
    ),
    None,
)

MODEL_ARGUMENT = argument(
    "MODEL", "Name of a built-in model (see slipfold models), or a case file, e.g. case.toml."
)

MODEL = (MODEL_ARGUMENT, SET, FRICTION)


def _read_model(given: Values, values: Values) -> Model:
    return find_model(given["model"], parse_assignments(given["set_"]), given["friction"])


def _read_span(given: Values, values: Values) -> tuple[str, tuple[float, float]]:
    """Read ``--vary`` for the model that was read before."""
    name, span = parse_span(given["vary"], values["model"])
    refuse_varied(parse_assignments(given["set_"]), (name,))
    return name, span


def vary_option(help_: str) -> Option:
    """Return the declaration of ``--vary``."""
    return Option(help_, "spans", "NAME=FIRST:LAST", flags=("--vary",))


def varied(help_: str) -> Reader:
    """Return a parameter that is read as the name of a model's parameter and its ends."""
    return Reader((option("vary", vary_option(help_)),), _read_span)


GivenModel = Annotated["Model", Reader(MODEL, _read_model, 1)]
"""A model by its name or file, with ``--set`` and ``--friction``."""

Varied = Annotated[tuple[str, tuple[float, float]], varied("Parameter and its ends.")]

FILES = (
    option(
        "json",
        Option(
            "Write the result as JSON; - is standard output, where nothing else is printed then.",
            metavar="FILE",
        ),
        None,
    ),
    option("out", Option("Write everything as netCDF.", metavar="FILE.nc"), None),
    option("csv", Option("Write all points as comma-separated values.", metavar="FILE"), None),
)

OutputFiles = Annotated[
    Outputs,
    Reader(FILES, lambda given, _: Outputs(given["json"], given["out"], given["csv"]).checked(), 0),
]
"""The files that a result is written to; they are checked first."""

STEPS = (
    option(
        "max_step",
        Option("Largest step from point to point, in scaled arclength.", metavar="S"),
        None,
    ),
    option(
        "tolerance", Option("Largest residual of an orbit, in scaled states.", metavar="R"), None
    ),
    option("max_points", Option("Points after which a branch or locus stops.", metavar="N"), None),
)


def _read_settings(given: Values, values: Values) -> Settings:
    from slipfold.branches.settings import Settings
    from slipfold.continuation.settings import Newton, Steps

    newton, steps, settings = Newton(), Steps(), Settings()
    if given["tolerance"] is not None:
        newton = replace(newton, tolerance=parse_number(given["tolerance"], "--tolerance"))
    if given["max_step"] is not None:
        steps = replace(steps, largest=parse_number(given["max_step"], "--max-step"))
    if given["max_points"] is not None:
        steps = replace(steps, points=parse_whole(given["max_points"], "--max-points"))
    if given.get("largest_period") is not None:
        period = parse_whole(given["largest_period"], "--largest-period", least=0)
        settings = replace(settings, largest_period=period, snaking_period=period)
    if given.get("discretization") is not None:
        settings = replace(settings, discretization=given["discretization"])
    return replace(settings, newton=newton, steps=steps)


LocusSettings = Annotated["Settings", Reader(STEPS, _read_settings)]

ResponseSettings = Annotated[
    "Settings",
    Reader(
        (
            *STEPS,
            option(
                "largest_period",
                Option("Follow doubled branches up to this many forcing periods.", metavar="K"),
                None,
            ),
            option(
                "discretization",
                Option(
                    "Compute orbits by shooting, by collocation, or (automatic) by collocation "
                    "where shooting fails.",
                    metavar="NAME",
                ),
                None,
            ),
        ),
        _read_settings,
    ),
]


# -- models ------------------------------------------------------------------------------------


def find_model(given: str, changes: Mapping[str, str], friction: str | None = None) -> Model:
    """Make the model that a command names.

    >>> find_model("sliding", {"alpha": "30deg"}).alpha
    0.5235987755982988
    """
    from slipfold.models.registry import model_named, model_of_file, with_law

    law = None if friction is None else _law_named(friction)
    if given.endswith(".toml"):
        return model_of_file(given, changes, law)
    return model_named(given, **with_law(given, law), **changes)


def _law_named(name: str) -> FrictionLaw:
    """Return the law of a name, with its default values."""
    from slipfold.models.definitions.source import Source
    from slipfold.models.friction.record import friction_laws, read_law

    exact = {law.lower(): law for law in friction_laws()}
    value = exact.get(name.lower(), name)
    return Source({}, "--friction").read(read_law, value, ("--friction",))


def equations_file(given: str) -> Path | None:
    """Return the file that holds the equations of a model that a command names."""
    from slipfold.models.registry import read_case_file

    if not given.endswith(".toml"):
        return None
    tables = read_case_file(given).tables
    if "model" not in tables:
        return Path(given).absolute()
    name = tables["model"]
    return (Path(given).parent / name).absolute() if name.endswith(".toml") else None


# -- values ------------------------------------------------------------------------------------


def parse_assignments(texts: Sequence[str] | None, option: str = "--set") -> dict[str, str]:
    """Split every ``NAME=VALUE``.

    >>> parse_assignments(["f=12.5", "alpha=60deg"])
    {'f': '12.5', 'alpha': '60deg'}
    """
    result: dict[str, str] = {}
    for text in texts or ():
        name, equals, value = (part.strip() for part in text.partition("="))
        if not (name and equals and value):
            raise InputError(
                f"{option} {text!r} is not of the form NAME=VALUE; write e.g. {option} f=12.5"
            )
        if name in result:
            raise InputError(
                f"{name} is set twice, to {result[name]} and to {value}; give {option} {name}= once"
            )
        result[name] = value
    return result


def parse_states(texts: Sequence[str] | None, model: Model) -> dict[str, float] | None:
    """Read the starting states that are given; None if none is."""
    from slipfold.models.quantity import parse_quantity

    units = {item.name: item.unit for item in model.states}
    given = parse_assignments(texts, "--start")
    result = {name: parse_quantity(given[name], units.get(name, ""), name) for name in given}
    return result or None


def parse_box(
    texts: Sequence[str] | None, option: str = "--box"
) -> dict[str, tuple[str, str]] | None:
    """Read intervals of states, ``NAME=LEAST:LARGEST``; None if none is given.

    >>> parse_box(["y=-0.5:0.5"])
    {'y': ('-0.5', '0.5')}
    """
    result = {}
    for name, text in parse_assignments(texts, option).items():
        least, colon, largest = (part.strip() for part in text.partition(":"))
        if not (least and colon and largest) or ":" in largest:
            raise InputError(
                f"{option} {name}={text} is not of the form NAME=LEAST:LARGEST; write e.g. "
                f"{option} {name}=-1:1"
            )
        result[name] = (least, largest)
    return result or None


def parse_points(text: str, option: str = "--points", least: int = 2) -> tuple[int, int]:
    """Read the number of points along both axes, or along each.

    >>> parse_points("200"), parse_points("300x200")
    ((200, 200), (300, 200))
    """
    first, times, second = text.partition("x")
    count = parse_whole(first, option, least)
    return count, parse_whole(second, option, least) if times else count


def parse_number(text: str, option: str) -> float:
    """Read a finite number."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise InputError(f"{option} {text} is not a finite number; give e.g. {option} 0.01")
    return value


def parse_whole(text: str, option: str, least: int = 1) -> int:
    """Read a whole number of at least 1, or of another minimum.

    >>> parse_whole("2000", "--periods")
    2000
    """
    try:
        value = int(text)
    except ValueError:
        value = least - 1
    if value < least:
        raise InputError(
            f"{option} {text} is not a whole number of at least {least}; give e.g. {option} 4"
        )
    return value


def parse_span(texts: Sequence[str], model: Model) -> tuple[str, tuple[float, float]]:
    """Read ``NAME=FIRST:LAST``. A unit behind the last value alone goes for both.

    >>> from slipfold.models import SlidingOscillator
    >>> parse_span(["f=11:14Hz"], SlidingOscillator())
    ('f', (11.0, 14.0))
    """
    if len(texts) != 1:
        raise InputError(
            f"--vary is given {len(texts)} times, but a response is followed in one parameter; "
            "give it once"
        )
    return _parse_interval(texts[0], model)


def parse_window(
    texts: Sequence[str], model: Model, what: str = "a locus"
) -> tuple[tuple[str, str], tuple[tuple[float, float], tuple[float, float]]]:
    """Read ``NAME=FIRST:LAST`` twice, for two parameters.

    >>> from slipfold.models import SlidingOscillator
    >>> parse_window(["f=11:14Hz", "Nd=0:0.5"], SlidingOscillator())
    (('f', 'Nd'), ((11.0, 14.0), (0.0, 0.5)))
    """
    if len(texts) != 2:
        times = "once" if len(texts) == 1 else f"{len(texts)} times"
        raise InputError(
            f"--vary is given {times}, but {what} has two parameters; give it twice, e.g. "
            "--vary f=11.5:13.5 --vary Nd=0:0.98"
        )
    (first, one), (second, other) = (_parse_interval(text, model) for text in texts)
    return (first, second), (one, other)


def refuse_varied(given: Mapping[str, str], varied: Sequence[str]) -> None:
    """Raise if a parameter is set although it is varied."""
    for name in varied:
        if name in given:
            raise InputError(
                f"{name} is varied, so it cannot be set to {given[name]} as well; "
                f"leave out --set {name}={given[name]}"
            )


def parse_bounds(texts: Sequence[str] | None, model: Model) -> dict[str, tuple[float, float]]:
    """Read every ``NAME=LEAST:GREATEST``.

    >>> from slipfold.models import SlidingOscillator
    >>> parse_bounds(["mu=0.3:0.7", "L=40:60mm"], SlidingOscillator())
    {'mu': (0.3, 0.7), 'L': (0.04, 0.06)}
    """
    result: dict[str, tuple[float, float]] = {}
    for text in texts or ():
        name, ends = _parse_interval(text, model, "--fit mu=0.3:0.7")
        if name in result:
            raise InputError(f"{name} has bounds twice; give --fit {name}= once")
        result[name] = ends
    return result


def _parse_interval(
    text: str, model: Model, example: str = "--vary Nd=0:0.98"
) -> tuple[str, tuple[float, float]]:
    from slipfold.models.quantity import parse_quantity, units_of

    name, _, values = (part.strip() for part in text.partition("="))
    first, colon, last = (part.strip() for part in values.partition(":"))
    if not (name and first and colon and last) or ":" in last:
        raise InputError(
            f"{example.split()[0]} {text!r} is not of the form NAME=FIRST:LAST; write e.g. "
            f"{example}"
        )
    unit = model.parameter(name).unit
    suffix = _NUMBER.sub("", last, count=1)
    if suffix in units_of(unit) and _NUMBER.fullmatch(first):
        first += suffix
    return name, (parse_quantity(first, unit, name), parse_quantity(last, unit, name))


def parse_event(text: str, model: Model, vary: str, stop: bool = False) -> Event:
    """Read ``NAME=VALUE`` or ``MEASURE(NAME)=VALUE``.

    >>> from slipfold.models import SlidingOscillator
    >>> parse_event("min(Vrel)=200mm/s", SlidingOscillator(), "Nd")
    Event(name='Vrel', value=0.2, measure='min', stop=False)
    """
    from slipfold.branches.settings import Event
    from slipfold.models.quantity import parse_quantity
    from slipfold.models.suggestion import suggest

    match = _EVENT.fullmatch(text)
    if match is None:
        raise InputError(
            f"event {text!r} is not of the form NAME=VALUE or MEASURE(NAME)=VALUE; "
            'write e.g. "min(Vrel)=0.2"'
        )
    measure, name, value = match[1], match[2] or match[3], match[4]
    if name == vary and measure is None:
        unit = model.parameter(vary).unit
        return Event(name, parse_quantity(value, unit, name), "parameter", stop)
    units = {state.name: state.unit for state in model.states}
    units |= {output.name: output.unit for output in model.outputs()}
    if name not in units:
        raise InputError(
            f"{model.name} has no output {name!r}; {suggest(name, [*units, vary])}"
            f"it has {', '.join(units)}"
        )
    return Event(name, parse_quantity(value, units[name], name), measure or "max", stop)
