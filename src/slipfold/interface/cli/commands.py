"""Commands made from the signatures of functions: options, their help, and how they are read."""

from __future__ import annotations

import ast
import gc
import inspect
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Annotated, Any

import typer

from slipfold import options as declarations
from slipfold.declarations import METAVARS, Option, declared, flags_of, resolved
from slipfold.errors import InputError, suggest
from slipfold.interface.cli.reading import (
    make_model,
    parse_assignments,
    parse_event,
    parse_intervals,
    parse_number,
    parse_pair,
    parse_points,
    parse_whole,
)
from slipfold.interface.cli.running import Outputs, exit_statuses
from slipfold.options import Box, Search
from slipfold.progress import Observer
from slipfold.writing import inputs_kept

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

    def program(self) -> Program:
        """Return the function that typer calls with texts; it returns the exit status."""
        parameters = signature_of(self.home)
        computes = "outputs" in self.readers or "on_progress" in parameters
        known = {**READERS, **self.readers}
        readers = [known["outputs"]] if computes else []  # files are checked first
        for name, item in parameters.items():
            declaration = declared(item.annotation)
            if name in known:
                readers.append(known[name])
            elif declaration is not None and name not in WITH_VARY:
                default = self.defaults.get(name, item.default)
                readers.append(reader_of(name, declaration, default))
        return Program(self, readers, computes)


class Program:
    """A function of texts with the signature that typer needs."""

    def __init__(self, command: Command, readers: Sequence[Reader], computes: bool) -> None:
        self._command, self._readers, self._computes = command, readers, computes
        ordered = [*readers[1:], readers[0]] if computes else readers  # files are listed last
        options = [item for reader in ordered for item in reader.options]
        options.sort(key=lambda item: item.default is not REQUIRED)
        self.__doc__ = f"{command.help}\n\n{exit_statuses(command.home)}"
        self.__annotations__ = {item.name: item.annotation for item in options}
        self.__signature__ = inspect.Signature(options)

    @inputs_kept()
    def __call__(self, **texts: Any) -> Any:
        """Read the texts, call the function, and return the exit status."""
        values: dict[str, Any] = {}
        for reader in self._readers:
            values |= reader.read(texts, values)
        module, name = self._command.home.split(":")
        function = getattr(import_module(module), name)
        if not gc.isenabled():  # as `main` left it: what is imported stays
            gc.freeze()
            gc.enable()
        if not self._computes:
            return function(**values)
        outputs: Outputs = values.pop("outputs")
        if "before" not in values:
            return outputs.status_of(partial(function, **values))
        before = values.pop("before")

        def compute(on_progress: Observer) -> Any:
            more = before(on_progress)
            return function(**values, **more, on_progress=on_progress)

        return outputs.status_of(compute)


def signature_of(home: str) -> Mapping[str, inspect.Parameter]:
    """Return the parameters of a function.

    Those of a computation are read from its source: importing it takes longer than its help.
    """
    module, name = home.split(":")
    if not module.startswith("slipfold.computations."):
        return resolved(getattr(import_module(module), name)).parameters
    spec = find_spec(module)
    assert spec is not None
    assert spec.origin is not None
    tree = ast.parse(Path(spec.origin).read_text(encoding="utf-8"))
    (function,) = (
        node for node in tree.body if isinstance(node, ast.FunctionDef) and node.name == name
    )
    given = function.args
    count = len(given.args) - len(given.defaults)
    defaults = [*[None] * count, *given.defaults, *given.kw_defaults]
    names = {f"options.{name}": value for name, value in vars(declarations).items()}
    return {
        item.arg: inspect.Parameter(
            item.arg,
            inspect.Parameter.KEYWORD_ONLY,
            default=REQUIRED if default is None else ast.literal_eval(default),
            annotation=names.get(ast.unparse(item.annotation or item)),
        )
        for item, default in zip([*given.args, *given.kwonlyargs], defaults, strict=True)
    }


def option(name: str, declared: Option, default: Any = REQUIRED) -> inspect.Parameter:
    """Return an option of the command line."""
    several, flag = declared.kind not in (*SINGLE, "flag"), declared.kind == "flag"
    help_ = re.sub(r"(?<!`)`(\w+)`(?!`)", r"--\1", declared.command_help or declared.help)
    help_ = help_.replace("`", "") + " Repeatable." * (several and declared.kind != "spans")
    how = typer.Option(
        *flags_of(name, declared),
        metavar=declared.metavar or METAVARS[declared.kind] or None,
        help=help_,
    )
    kind: Any = bool if flag else list[str] if several else str
    if not flag and default is not REQUIRED:
        default = None if several else _as_text(default, declared)
        kind = kind if default is not None else kind | None
    return inspect.Parameter(
        name, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=Annotated[kind, how]
    )


def optional(**options: Option) -> tuple[inspect.Parameter, ...]:
    """Return options that need not be given, by name."""
    return tuple(option(name, declared, None) for name, declared in options.items())


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
        return {name: PARSERS[declared.kind](text, flag, declared)}

    return Reader((option(name, declared, default),), read)


def _chosen(text: str, flag: str, declared: Option) -> Any:
    if declared.choices is None:
        return text
    if text not in declared.choices:
        meant = suggest(text, declared.choices)
        raise InputError(f"{flag} {text} is unknown; {meant}give {', '.join(declared.choices)}")
    return declared.choices[text]


def _numbers(texts: Sequence[str], flag: str, declared: Option) -> Any:
    result = [parse_number(text, flag) for text in texts]
    return result[0] if len(result) == 1 else result


PARSERS: Mapping[str, Callable[[Any, str, Option], Any]] = {
    "text": _chosen,
    "texts": lambda texts, flag, declared: texts,
    "spans": lambda texts, flag, declared: texts,
    "flag": lambda given, flag, declared: given,
    "whole": lambda text, flag, declared: parse_whole(
        text, flag, declared.minimum, declared.maximum
    ),
    "wholes": lambda texts, flag, declared: [parse_whole(text, flag) for text in texts],
    "number": lambda text, flag, declared: parse_number(text, flag),
    "numbers": _numbers,
    "pair": lambda text, flag, declared: parse_pair(text, flag),
    "grid": lambda text, flag, declared: parse_points(text, flag, declared.minimum),
    "intervals": lambda texts, flag, declared: parse_intervals(texts, flag),
    "starts": lambda texts, flag, declared: tuple(
        parse_assignments(text.split(","), flag, example="Vd=0.5,x=1") for text in texts or ()
    ),
    **dict.fromkeys(
        ("values", "entries"),
        lambda texts, flag, declared: parse_assignments(texts, flag, example="x=0.1"),
    ),
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


def read_model(texts: Values, values: Values) -> Values:
    """Read the model with its values and its friction law."""
    changes = parse_assignments(texts["set_"])
    return {"model": make_model(texts["model"], changes, texts["friction"])}


def vary_option(help_: str) -> inspect.Parameter:
    """Return ``--vary``."""
    return option("vary", Option(help_, "spans", flags=("--vary",)))


VARY = vary_option("Parameter to vary and its ends, e.g. Nd=0:0.98 or f=14:11Hz.")

WITH_VARY = ("span", "values")
"""Arguments that are read together with the name of the parameter that varies."""


def read_varied(texts: Values, count: int) -> dict[str, tuple[str, str]]:
    """Read the parameters that vary, with their first and last values."""
    from slipfold.computations.arguments import refuse_varied

    given = texts["vary"]
    if len(given) != count:
        times = {1: "once", 2: "twice"}
        raise InputError(
            f"--vary is given {times.get(len(given), f'{len(given)} times')}; give it "
            f"{times[count]}, e.g. {' '.join(('--vary Nd=0:0.98', '--vary f=11:14')[:count])}"
        )
    result = parse_intervals(given, "--vary")
    refuse_varied(result, parse_assignments(texts["set_"]), "--vary")
    return result


def read_span(texts: Values, values: Values) -> Values:
    """Read the parameter that varies, and its span."""
    ((name, span),) = read_varied(texts, 1).items()
    return {"vary": name, "span": span}


PLANE = Reader(
    (vary_option("A parameter and its ends; give two. Sweeps go along the second."),),
    lambda texts, values: {"vary": read_varied(texts, 2)},
)


def _read_values(texts: Values, values: Values) -> Values:
    import numpy as np

    from slipfold.models.units import interval

    ((name, span),) = read_varied(texts, 1).items()
    ends = interval(values["model"].variable_parameter(name), span)
    count = parse_whole(texts["points"], "--points", 2)
    return {"vary": name, "values": np.linspace(*ends, count).tolist()}


VALUES = Reader(
    (VARY, option("points", Option("Equidistant values of it, from first to last.", "whole"), 21)),
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

STEPS = {
    ("steps", "largest"): (
        "max_step",
        Option("Largest step from point to point, in scaled arclength.", "number", "S"),
    ),
    ("newton", "tolerance"): (
        "tolerance",
        Option("Largest residual of an orbit, in scaled states.", "number"),
    ),
    ("steps", "points"): (
        "max_points",
        Option("Points after which a branch or locus stops.", "whole"),
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
        from slipfold.bifurcations.branches.settings import Settings

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
        'x=0.3, "min(Vrel)=0.2"; or where the parameter does. Without a value, where it has an '
        'extremum along a branch: "max(x)".',
        "texts",
        "[MEASURE](NAME)[=VALUE]",
    ),
    stop_at=Option("As --event, and end the branch there.", "texts", "EVENT"),
)


def _read_events(texts: Values, values: Values) -> Values:
    return {
        "events": [
            parse_event(text, values["model"], [values["vary"]], stop=name == "stop_at")
            for name in ("event", "stop_at")
            for text in texts[name] or ()
        ]
    }


def declaration(alias: Any) -> Option:
    """Return the declaration of an option by its type."""
    result = declared(alias)
    assert result is not None
    return result


READERS: Mapping[str, Reader] = {
    "model": Reader((MODEL, SET, FRICTION), read_model),
    "vary": Reader((VARY,), read_span),
    "settings": settings_reader(STEPS | BRANCHES),
    "events": Reader(EVENTS, _read_events),
    "search": Reader(
        (option("search", declaration(Search), False), option("box", declaration(Box), None)),
        lambda texts, _: {"search": parse_intervals(texts["box"], "--box") or texts["search"]},
    ),
    "outputs": Reader(
        FILES,
        lambda texts, _: {"outputs": Outputs(texts["json"], texts["out"], texts["csv"]).checked()},
    ),
}
"""Readers of arguments by their names, where an option alone does not say how to read them."""
