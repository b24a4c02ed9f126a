"""Commands made from the signatures of functions: options, their help, and how they are read."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from importlib import import_module
from typing import Annotated, Any

import typer

from slipfold.cli.reading import (
    equidistant,
    find_model,
    parse_assignments,
    parse_bounds,
    parse_box,
    parse_event,
    parse_number,
    parse_pair,
    parse_points,
    parse_span,
    parse_states,
    parse_whole,
    parse_window,
    refuse_varied,
)
from slipfold.cli.running import Outputs
from slipfold.errors import InputError
from slipfold.options import Box, Option, Search, declared, resolved

REQUIRED = inspect.Parameter.empty

SINGLE = ("whole", "number", "text", "grid", "pair")
"""Kinds of options that are given once; the others may be repeated."""

Values = Mapping[str, Any]


@dataclass(frozen=True)
class Reader:
    """Arguments of a function: their options on the command line, and how they are read."""

    options: tuple[inspect.Parameter, ...]
    read: Callable[[Values, Values], Values]  # from the texts given, and the values read before


@dataclass(frozen=True)
class Command:
    """A command: the function that does it, what it does, and what it reads in its own way.

    A computation is called with what it reports progress to, and its result is written.
    """

    home: str  # module and name of the function, imported when the command runs
    help: str
    readers: Mapping[str, Reader] = field(default_factory=dict)  # by argument
    defaults: Mapping[str, Any] = field(default_factory=dict)  # where not those of the function

    def program(self) -> Callable[..., Any]:
        """Return the function that typer calls with texts; it returns the exit status."""
        module, name = self.home.split(":")
        function: Callable[..., Any] = getattr(import_module(module), name)
        parameters = resolved(function).parameters
        computes = "outputs" in self.readers or "on_progress" in parameters
        readers = self._readers(parameters.values(), computes)

        def run(**texts: Any) -> Any:
            values: dict[str, Any] = {}
            for reader in readers:
                values |= reader.read(texts, values)
            if not computes:
                return function(**values)
            outputs: Outputs = values.pop("outputs")
            return outputs.status_of(partial(function, **values))

        ordered = [*readers[1:], readers[0]] if computes else readers  # files are listed last
        options = [option for reader in ordered for option in reader.options]
        options.sort(key=lambda option: option.default is not REQUIRED)
        run.__doc__ = self.help
        run.__annotations__ = {option.name: option.annotation for option in options}
        run.__signature__ = inspect.Signature(options)  # type: ignore[attr-defined]
        return run

    def _readers(self, parameters: Iterable[inspect.Parameter], computes: bool) -> list[Reader]:
        """Return the readers of a function's arguments; files are checked first."""
        known = {**READERS, **self.readers}
        result = [known["outputs"]] if computes else []
        for item in parameters:
            option = declared(item.annotation)
            if item.name in known:
                result.append(known[item.name])
            elif option is not None and item.name not in WITH_VARY:
                default = self.defaults.get(item.name, item.default)
                result.append(reader_of(item.name, option, default))
        return result


def option(name: str, declared: Option, default: Any = REQUIRED) -> inspect.Parameter:
    """Return an option of the command line."""
    several, flag = declared.kind not in (*SINGLE, "flag"), declared.kind == "flag"
    help_ = re.sub(r"(?<!`)`(\w+)`(?!`)", r"--\1", declared.command_help or declared.help)
    help_ = help_.replace("`", "") + " Repeatable." * (several and declared.kind != "spans")
    how = typer.Option(*flags_of(name, declared), metavar=declared.metavar, help=help_)
    kind: Any = bool if flag else list[str] if several else str
    if not flag and default is not REQUIRED:
        default = None if several else _as_text(default, declared)
        kind = kind if default is not None else kind | None
    annotation = Annotated[kind, how]
    return inspect.Parameter(
        name, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=annotation
    )


def optional(**options: Option) -> tuple[inspect.Parameter, ...]:
    """Return options that need not be given, by name."""
    return tuple(option(name, declared, None) for name, declared in options.items())


def flags_of(name: str, declared: Option) -> tuple[str, ...]:
    """Return the names of a parameter on the command line."""
    return declared.flags or (f"--{name.replace('_', '-')}",)


def _as_text(default: Any, declared: Option) -> str | None:
    if default is None:
        return None
    for word, value in (declared.choices or {}).items():
        if value == default:
            return word
    return "x".join(map(str, default)) if isinstance(default, tuple) else str(default)


def reader_of(name: str, declared: Option, default: Any = REQUIRED) -> Reader:
    """Return the reader of one option, by its kind."""
    flag = flags_of(name, declared)[0]

    def read(texts: Values, values: Values) -> Values:
        text = texts[name]
        if text is None or (text == [] and default is not REQUIRED):
            return {name: default}
        return {name: PARSERS[declared.kind](text, flag, declared, values)}

    return Reader((option(name, declared, default),), read)


def _chosen(text: str, flag: str, declared: Option, values: Values) -> Any:
    if declared.choices is None:
        return text
    if text not in declared.choices:
        raise InputError(f"{flag} {text} is unknown; give {', '.join(declared.choices)}")
    return declared.choices[text]


def _numbers(texts: Sequence[str], flag: str, declared: Option, values: Values) -> Any:
    result = [parse_number(text, flag) for text in texts]
    return result[0] if len(result) == 1 else result


PARSERS: Mapping[str, Callable[[Any, str, Option, Values], Any]] = {
    "text": _chosen,
    "texts": lambda texts, flag, declared, values: texts,
    "spans": lambda texts, flag, declared, values: texts,
    "flag": lambda given, flag, declared, values: given,
    "whole": lambda text, flag, declared, values: parse_whole(
        text, flag, declared.minimum, declared.maximum
    ),
    "wholes": lambda texts, flag, declared, values: [parse_whole(text, flag) for text in texts],
    "number": lambda text, flag, declared, values: parse_number(text, flag),
    "numbers": _numbers,
    "pair": lambda text, flag, declared, values: parse_pair(text, flag),
    "grid": lambda text, flag, declared, values: parse_points(text, flag, declared.minimum),
    "intervals": lambda texts, flag, declared, values: parse_box(texts, flag),
    "bounds": lambda texts, flag, declared, values: parse_bounds(texts, values["model"], flag),
    "states": lambda texts, flag, declared, values: parse_states(texts, values["model"]),
    "values": lambda texts, flag, declared, values: parse_assignments(texts, flag),
}
"""What reads each kind of option."""


# -- arguments that many functions have --------------------------------------------------------


def argument(
    metavar: str, help_: str, name: str = "model", default: Any = REQUIRED
) -> inspect.Parameter:
    """Return an argument of the command line, by default the model."""
    kind: Any = str if default is REQUIRED else str | None
    annotation = Annotated[kind, typer.Argument(metavar=metavar, help=help_)]
    return inspect.Parameter(
        name, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=annotation
    )


def given_text(item: inspect.Parameter) -> Reader:
    """Return a parameter that is read as it is given."""
    return Reader((item,), lambda texts, _: {item.name: texts[item.name]})


SET, FRICTION = optional(
    set_=Option(
        "Value of a parameter: in SI units, or with a unit, e.g. alpha=60deg.",
        "texts",
        "NAME=VALUE",
        flags=("--set",),
    ),
    friction=Option(
        "Friction law of the sliding oscillator, e.g. stribeck; its parameters are then set and "
        "varied like others, see slipfold models sliding --friction LAW.",
        metavar="LAW",
    ),
)

MODEL = argument(
    "MODEL", "Name of a built-in model (see slipfold models), or a case file, e.g. case.toml."
)


def _read_model(texts: Values, values: Values) -> Values:
    changes = parse_assignments(texts["set_"])
    return {"model": find_model(texts["model"], changes, texts["friction"])}


def vary_option(help_: str) -> inspect.Parameter:
    """Return ``--vary``."""
    return option("vary", Option(help_, "spans", "NAME=FIRST:LAST", flags=("--vary",)))


VARY = vary_option("Parameter to vary and its ends, e.g. Nd=0:0.98 or f=14:11Hz.")

WITH_VARY = ("span", "values")
"""Arguments that are read together with the name of the parameter that varies."""


def _read_span(texts: Values, values: Values) -> Values:
    name, span = parse_span(texts["vary"], values["model"])
    refuse_varied(parse_assignments(texts["set_"]), (name,))
    return {"vary": name, "span": span}


def _read_plane(texts: Values, values: Values) -> Values:
    names, spans = parse_window(texts["vary"], values["model"], "a map of regimes")
    refuse_varied(parse_assignments(texts["set_"]), names)
    return {"vary": dict(zip(names, spans, strict=True))}


PLANE = Reader(
    (vary_option("A parameter and its ends; give two. Sweeps go along the second."),), _read_plane
)


def _read_values(texts: Values, values: Values) -> Values:
    read = _read_span(texts, values)
    count = parse_whole(texts["points"], "--points")
    return {"vary": read["vary"], "values": equidistant(read["span"], count)}


VALUES = Reader(
    (
        VARY,
        option("points", Option("Equidistant values of it, from first to last.", "whole", "N"), 21),
    ),
    _read_values,
)


FILES = optional(
    json=Option(
        "Write the result as JSON; - is standard output, where nothing else is printed then.",
        metavar="FILE",
    ),
    out=Option("Write everything as netCDF.", metavar="FILE.nc"),
    csv=Option("Write all points as comma-separated values.", metavar="FILE"),
)

OUTPUTS = Reader(
    FILES,
    lambda texts, _: {"outputs": Outputs(texts["json"], texts["out"], texts["csv"]).checked()},
)
"""The files that a result is written to."""


STEPS = {
    ("steps", "largest"): (
        "max_step",
        Option("Largest step from point to point, in scaled arclength.", "number", "S"),
    ),
    ("newton", "tolerance"): (
        "tolerance",
        Option("Largest residual of an orbit, in scaled states.", "number", "R"),
    ),
    ("steps", "points"): (
        "max_points",
        Option("Points after which a branch or locus stops.", "whole", "N"),
    ),
}
"""Settings by their places, and the options that set them."""

BRANCHES = {
    ("", "largest_period"): (
        "largest_period",
        Option("Follow doubled branches up to this many forcing periods.", "whole", "K", minimum=0),
    ),
    ("", "discretization"): (
        "discretization",
        Option(
            "Compute orbits by shooting, by collocation, or (automatic) by collocation where "
            "shooting fails.",
            metavar="NAME",
        ),
    ),
}
"""Settings of branches alone."""


def settings_reader(table: Mapping[tuple[str, str], tuple[str, Option]]) -> Reader:
    """Return the reader of settings, which are the defaults where no option is given."""
    readers = {place: reader_of(name, option, None) for place, (name, option) in table.items()}

    def read(texts: Values, values: Values) -> Values:
        from slipfold.branches.settings import Settings

        settings = Settings()
        for (part, name), reader in readers.items():
            (value,) = reader.read(texts, values).values()
            if value is None:
                continue
            change = {name: value}
            if part:
                change = {part: replace(getattr(settings, part), **change)}
            elif name == "largest_period":
                change["snaking_period"] = value
            settings = replace(settings, **change)
        return {"settings": settings}

    return Reader(tuple(item for reader in readers.values() for item in reader.options), read)


LOCUS_SETTINGS = settings_reader(STEPS)

EVENTS = optional(
    event=Option(
        "Locate where the maximum (or min, peak_to_peak) of an output takes a value: "
        'x=0.3, "min(Vrel)=0.2"; or where the parameter does.',
        "texts",
        "[MEASURE](NAME)=VALUE",
    ),
    stop_at=Option("As --event, and end the branch there.", "texts", "EVENT"),
)


def _read_events(texts: Values, values: Values) -> Values:
    return {
        "events": [
            parse_event(text, values["model"], values["vary"], stop=name == "stop_at")
            for name in ("event", "stop_at")
            for text in texts[name] or ()
        ]
    }


def _read_search(texts: Values, values: Values) -> Values:
    return {"search": parse_box(texts["box"], "--box") or texts["search"]}


def _declared(alias: Any) -> Option:
    found = declared(alias)
    assert isinstance(found, Option)
    return found


READERS: Mapping[str, Reader] = {
    "model": Reader((MODEL, SET, FRICTION), _read_model),
    "vary": Reader((VARY,), _read_span),
    "settings": settings_reader(STEPS | BRANCHES),
    "events": Reader(EVENTS, _read_events),
    "search": Reader(
        (option("search", _declared(Search), False), option("box", _declared(Box), None)),
        _read_search,
    ),
    "outputs": OUTPUTS,
}
"""Readers of arguments by their names, where an option alone does not tell how to read them."""
