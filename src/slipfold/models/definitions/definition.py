"""What defines a system of equations: names, formulas as text and meanings, read from tables."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from numbers import Real
from typing import Any, TypeVar

from slipfold.errors import InputError
from slipfold.models.definitions.contacts import ContactFormulas, read_contact
from slipfold.models.definitions.source import MOST_ENTRIES, Source
from slipfold.models.definitions.tables import Entries, type_name
from slipfold.models.formulas.functions import CONSTANTS, FUNCTIONS, TIME
from slipfold.models.friction.record import law_record
from slipfold.models.model import Model
from slipfold.models.output import Limit
from slipfold.models.parameter import Parameter, State
from slipfold.models.suggestion import suggest


@dataclass(frozen=True)
class StateFormula:
    """A state with the formula of its rate."""

    state: State  # name, unit and meaning
    rate: str  # formula of its time derivative, per second
    scale: float | None = None  # typical size, in the unit of the state; None if it is to be found
    start: float = 0.0  # value from which motions and searches start, in the unit of the state


@dataclass(frozen=True)
class OutputFormula:
    """A quantity of interest with its formula."""

    name: str  # name in results
    formula: str  # in states, parameters, named formulas and the time
    unit: str = ""  # unit as text
    doc: str = ""  # one line that says what it is
    label: str = ""  # axis label in mathtext; the name itself if empty


@dataclass(frozen=True)
class WatchedValue:
    """An event: a value of an output, or of a parameter, to be located on every branch."""

    name: str  # name of the event
    output: str  # a state, an output or, with the measure ``"parameter"``, a parameter
    value: float  # the value, in its unit
    measure: str = "max"  # ``"max"``, ``"min"``, ``"peak_to_peak"`` or ``"parameter"``
    stop: bool = False  # whether the branch ends there


@dataclass(frozen=True)
class Definition:
    """A system of first-order equations."""

    # Short name, and a line that says what it is
    name: str
    title: str = ""
    parameters: tuple[Parameter, ...] = ()  # parameters with defaults and bounds
    # Named intermediate formulas: pairs of a name and a text
    formulas: tuple[tuple[str, str], ...] = ()
    states: tuple[StateFormula, ...] = ()  # states with the formulas of their rates
    contacts: tuple[ContactFormulas, ...] = ()  # where friction acts that may stick
    # Formula of the forcing period in seconds; None for an autonomous system
    period: str | None = None
    # Name of the parameter that switches the forcing off; None if there is none
    quiet: str | None = None
    outputs: tuple[OutputFormula, ...] = ()  # quantities of interest
    limits: tuple[Limit, ...] = ()  # where the system is valid
    events: tuple[WatchedValue, ...] = ()  # values to be located on branches


_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]{0,59}")

_TAKEN = frozenset(
    (
        # Attributes of models, which would hide a parameter of that name ...
        *(name for name in (*dir(Model), *Model.__annotations__) if not name.startswith("_")),
        *("events", "resting", "from_toml", "to_toml"),
        # ... and arguments of what takes parameters by name.
        *(
            "self",
            "definition",
            "sizes",
            "formulas",
            "forcing",
            "model",
            "vary",
            "span",
            "settings",
        ),
        *("on_progress", "plane", "window", "types", "regions", "regimes", "periods", "state"),
        *("tolerance", "settled", "search", "tori", "gradients", "duration"),
    )
)

_SYMBOLS = ("c_", "p_", "carried_")
"""How the compiled equations begin the names of coefficients, parameters and variations."""


def check_names(definition: Definition, source: Source) -> None:
    """Refuse names that cannot be written in formulas, are taken, or are given twice."""
    parameters = [item.name for item in definition.parameters]
    states = [item.state.name for item in definition.states]
    formulas = [name for name, _ in definition.formulas]
    outputs = [item.name for item in definition.outputs]
    given: dict[str, str] = {}
    for table, what, names in (
        ("parameters", "a parameter", parameters),
        ("formulas", "a formula", formulas),
        ("states", "a state", states),
    ):
        _check_form(names, table, source)
        _check_double(names, table, what, given, source)
        given |= dict.fromkeys(names, what)
    for item in definition.contacts:
        _check_form([item.name], "contacts", source)
        for name in item.output_names:
            what = f"a quantity of the contact {item.name}"
            _check_double([name], "contacts", what, given, source)
            given[name] = what
    _check_form(outputs, "outputs", source)
    # An output may show a formula under its own name; states are outputs already.
    shown = {name: what for name, what in given.items() if what != "a formula"}
    _check_double(outputs, "outputs", "an output", shown, source)
    for name in parameters:
        if name in _TAKEN:
            raise source.error(
                ("parameters", name),
                f"a parameter cannot be called {name}, which is an attribute or argument in Python "
                f"already; call it e.g. {name}_0",
                key=True,
            )
    for name in states:
        if name == "phase" or name.startswith(_SYMBOLS):
            raise source.error(
                ("states", name),
                f"a state cannot be called {name}: phase and names that begin with "
                f"{', '.join(_SYMBOLS)} are used inside; call it e.g. q_{name}",
                key=True,
            )


def _check_form(names: Iterable[str], table: str, source: Source) -> None:
    for name in names:
        if _NAME.fullmatch(name) is None:
            raise source.error(
                (table, name),
                f"{name[:80]!r} cannot be a name in formulas; give at most 60 ASCII letters, "
                "digits and _, a letter first",
                key=True,
            )
        if name in FUNCTIONS or name in CONSTANTS or name == TIME:
            what = "a function" if name in FUNCTIONS else "a constant"
            meaning = "the time" if name == TIME else what
            raise source.error(
                (table, name), f"{name} is {meaning} in formulas; choose another name", key=True
            )


def _check_double(
    names: Iterable[str], table: str, what: str, given: dict[str, str], source: Source
) -> None:
    for name in names:
        if name in given:
            raise source.error(
                (table, name),
                f"{name} is {given[name]} and {what}; a name can be one of them only, rename one",
                key=True,
            )


T = TypeVar("T")

TABLES = (
    *("parameters", "formulas", "states", "contacts", "forcing"),
    *("outputs", "limits", "events"),
)

MEASURES = ("max", "min", "peak_to_peak", "parameter")


_BRACES = re.compile(r"\{value(?::\.\d[efg])?\}")
"""What a reason may hold: other braces would be looked up in Python objects."""


def read_definition(source: Source, default_name: str = "system") -> Definition:
    """Read a definition; formulas stay texts."""
    top = Entries(source, (), source.tables, ("name", "title", "sizes", *TABLES))
    if "states" not in top:
        raise source.error((), 'there is no table [states]; give each state its rate, e.g. q = "v"')
    forcing = _forcing(source)
    definition = Definition(
        name=top.text("name", None) or default_name,
        title=top.text("title"),
        parameters=_each(source, "parameters", _parameter),
        formulas=_each(source, "formulas", _formula),
        states=_each(source, "states", _state),
        contacts=_each(source, "contacts", read_contact),
        period=forcing[0],
        quiet=forcing[1],
        outputs=_each(source, "outputs", _output),
        limits=_each(source, "limits", _limit),
        events=_each(source, "events", _event),
    )
    if not definition.states:
        raise source.error(
            ("states",), 'the table [states] is empty; give each state its rate, e.g. q = "v"'
        )
    check_names(definition, source)
    _check_references(definition, source)
    return definition


def _each(source: Source, name: str, read: Callable[[Source, str, Any], T]) -> tuple[T, ...]:
    table = source.tables.get(name, {})
    if not isinstance(table, Mapping):
        raise source.error((name,), f"{name} is {type_name(table)}, not a table; write [{name}]")
    if len(table) > MOST_ENTRIES:
        raise source.error((name,), f"[{name}] has {len(table)} entries, more than {MOST_ENTRIES}")
    for key in table:
        if not isinstance(key, str):
            raise source.error((name,), f"the key {key!r} of {name} is no text; give names")
    return tuple(read(source, key, value) for key, value in table.items())


def _parameter(source: Source, name: str, value: Any) -> Parameter:
    path = ("parameters", name)
    table = value if isinstance(value, Mapping) else {"value": value}
    known = ("value", "unit", "min", "max", "above", "below", "doc", "symbol")
    entries = Entries(source, path, table, known)
    entries.need("value", f"the parameter {name} has no value; give e.g. value = 1.0")
    for closed, opened in (("min", "above"), ("max", "below")):
        if closed in entries and opened in entries:
            raise entries.error(
                opened, f"{name} has both {closed} and {opened}; give the one that is meant"
            )
    unit = entries.text("unit")
    lower_open, upper_open = "above" in entries, "below" in entries
    lower = entries.number("above" if lower_open else "min", -math.inf, unit)
    upper = entries.number("below" if upper_open else "max", math.inf, unit)
    if lower > upper or (lower == upper and (lower_open or upper_open)):
        raise source.error(
            path, f"no value of {name} is allowed from {lower:g} to {upper:g}; exchange the bounds"
        )
    bounds = (lower, upper, lower_open, upper_open)
    number, doc = entries.number("value", 0.0, unit), entries.text("doc")
    parameter = Parameter(name, number, unit, doc, *bounds, entries.text("symbol"))
    try:
        parameter.check(parameter.default)
    except InputError as error:
        raise source.error(path, str(error)) from None
    return parameter


def _state(source: Source, name: str, value: Any) -> StateFormula:
    entries = _formula_entries(source, ("states", name), value, "rate", ("scale", "start", "angle"))
    scale = entries.number("scale", math.nan)
    if scale <= 0:
        raise entries.error("scale", f"the scale {scale:g} of {name} is not positive; give e.g. 1")
    unit, doc, label = (entries.text(key) for key in ("unit", "doc", "label"))
    state = State(name, unit, doc, label, entries.flag("angle"))
    rate, size = entries.text("rate", lines=True), None if math.isnan(scale) else scale
    return StateFormula(state, rate, size, entries.number("start", 0.0, unit))


def _output(source: Source, name: str, value: Any) -> OutputFormula:
    entries = _formula_entries(source, ("outputs", name), value, "formula", ())
    unit, doc, label = (entries.text(key) for key in ("unit", "doc", "label"))
    return OutputFormula(name, entries.text("formula", lines=True), unit, doc, label)


def _formula_entries(
    source: Source, path: tuple[str, str], value: Any, key: str, more: tuple[str, ...]
) -> Entries:
    """Entries of what is a formula alone, or a table with one; a number is a formula as well."""
    value = _number_as_text(source, path, value)
    if not isinstance(value, (str, Mapping)):
        raise source.error(
            path, f"{path[1]} is {type_name(value)}; give its {key} as a text in quotes"
        )
    table = value if isinstance(value, Mapping) else {key: value}
    entries = Entries(source, path, table, (key, "unit", "doc", "label", *more))
    entries.need(key, f'{path[1]} has no {key}; give e.g. {key} = "2*q"')
    return entries


def _number_as_text(source: Source, path: tuple[str, str], value: Any) -> Any:
    """Return a number as a formula, anything else as it is."""
    if isinstance(value, bool) or not isinstance(value, Real):
        return value
    try:
        number = float(value)
    except OverflowError:
        number = math.inf
    if not math.isfinite(number):
        raise source.error(path, f"{path[1]} = {number} is not a finite number; give a formula")
    return repr(number)


def _formula(source: Source, name: str, value: Any) -> tuple[str, str]:
    if not isinstance(value, str):
        message = f"{name} is {type_name(value)}; give the formula in quotes"
        raise source.error(("formulas", name), message)
    return name, value


def _forcing(source: Source) -> tuple[str | None, str | None]:
    if "forcing" not in source.tables:
        return None, None
    table = source.tables["forcing"]
    entries = Entries(source, ("forcing",), table, ("period", "quiet"))
    entries.need(
        "period",
        'the table [forcing] has no period; give it in seconds, e.g. period = "2*pi/W", or leave '
        "the table out for an autonomous system",
    )
    period = _number_as_text(source, ("forcing", "period"), table["period"])
    if not isinstance(period, str):
        raise entries.error(
            "period", f"the period is {type_name(period)}; give a formula in quotes"
        )
    return period, entries.text("quiet", None)


def _limit(source: Source, name: str, value: Any) -> Limit:
    path = ("limits", name)
    entries = Entries(source, path, value, ("output", "bound", "reason"))
    for key in ("output", "bound"):
        entries.need(key, f"the limit {name[:60]!r} has no {key}; give output and bound")
    _check_title(source, path)
    output, bound = entries.text("output"), entries.number("bound", 0.0)
    default = f"{name}: {output} fell to {{value:.3g}}; the model ends at {bound:g}"
    reason = entries.text("reason", default)
    if "{" in _BRACES.sub("", reason) or "}" in _BRACES.sub("", reason):
        raise entries.error(
            "reason", "the only braces in a reason are {value} and {value:.3g} for the value"
        )
    return Limit(name, output, bound, reason)


def _event(source: Source, name: str, value: Any) -> WatchedValue:
    path = ("events", name)
    entries = Entries(source, path, value, ("output", "value", "measure", "stop"))
    entries.need("value", f"the event {name[:60]!r} has no value; give e.g. value = 1.0")
    _check_title(source, path)
    measure = entries.text("measure", "max")
    if measure not in MEASURES:
        raise entries.error(
            "measure", f"measure {measure[:80]!r} is unknown; give one of {', '.join(MEASURES)}"
        )
    output, number = entries.text("output", name), entries.number("value", 0.0)
    return WatchedValue(name, output, number, measure, entries.flag("stop"))


def _check_title(source: Source, path: tuple[str, str]) -> None:
    name = path[1]
    if not name.strip() or len(name) > 60 or not name.isprintable() or set(name) & set("{}"):
        raise source.error(
            path,
            f"{name[:80]!r} is not a name for one of the {path[0]}; give a few words",
            key=True,
        )


def _check_references(definition: Definition, source: Source) -> None:
    """Refuse limits, events and a quiet parameter that name nothing there is."""
    parameters = [item.name for item in definition.parameters]
    outputs = [item.state.name for item in definition.states]
    outputs += [item.name for item in definition.outputs]
    outputs += [name for item in definition.contacts for name in item.output_names]
    if definition.quiet is not None and definition.quiet not in parameters:
        raise source.error(
            ("forcing", "quiet"),
            f"there is no parameter {definition.quiet[:80]!r} to switch the forcing off; "
            f"{suggest(definition.quiet[:80], parameters)}"
            f"there are {', '.join(parameters) or 'none'}",
        )
    for limit in definition.limits:
        _check_output(source, ("limits", limit.name), limit.output, outputs, "output")
    for event in definition.events:
        watched, what = (
            (parameters, "parameter") if event.measure == "parameter" else (outputs, "output")
        )
        _check_output(source, ("events", event.name), event.output, watched, what)


def _check_output(
    source: Source, path: tuple[str, str], name: str, known: list[str], what: str
) -> None:
    if name not in known:
        raise source.error(
            (*path, "output"),
            f"there is no {what} {name[:80]!r}; {suggest(name[:80], known)}"
            f"there are {', '.join(known) or 'none'}",
        )


def write_definition(definition: Definition) -> str:
    """Write a definition as TOML, always the same for the same definition.

    >>> print(write_definition(Definition("decay", states=(StateFormula(State("q"), "-q"),))))
    name = "decay"
    <BLANKLINE>
    [states]
    q = "-q"
    <BLANKLINE>
    """
    tables: dict[str, dict[str, Any]] = {
        "": _given(name=definition.name, title=definition.title),
        "parameters": {item.name: _parameter_entry(item) for item in definition.parameters},
        "formulas": {name: {"formula": text} for name, text in definition.formulas},
        "states": {item.state.name: _state_entry(item) for item in definition.states},
        "contacts": {item.name: _contact_entry(item) for item in definition.contacts},
        "forcing": {} if definition.period is None else {"period": definition.period},
        "outputs": {item.name: _output_entry(item) for item in definition.outputs},
        "limits": {
            item.name: {"output": item.output, "bound": item.bound, "reason": item.reason}
            for item in definition.limits
        },
        "events": {
            item.name: {key: getattr(item, key) for key in ("output", "value", "measure", "stop")}
            for item in definition.events
        },
    }
    if definition.quiet is not None:
        tables["forcing"]["quiet"] = definition.quiet
    return "\n\n".join(_table(name, table) for name, table in tables.items() if table) + "\n"


def _table(name: str, entries: Mapping[str, Any]) -> str:
    """Write a table; an entry with nothing but its first value is written as that value."""
    lines = [f"[{name}]"] if name else []
    for key, value in entries.items():
        single = isinstance(value, dict) and len(value) == 1
        lines.append(
            f"{_key(key)} = {toml_value(*value.values()) if single else toml_value(value)}"
        )
    return "\n".join(lines)


def _given(**values: Any) -> dict[str, Any]:
    """Return the values that say something."""
    return {key: value for key, value in values.items() if value}


def _parameter_entry(item: Parameter) -> dict[str, Any]:
    bounds = {}
    if math.isfinite(item.lower):
        bounds["above" if item.lower_open else "min"] = item.lower
    if math.isfinite(item.upper):
        bounds["below" if item.upper_open else "max"] = item.upper
    words = _given(unit=item.unit, doc=item.doc)
    return {"value": item.default, **words, **bounds, **_given(symbol=item.symbol)}


def _state_entry(item: StateFormula) -> dict[str, Any]:
    state = item.state
    words = _given(unit=state.unit, doc=state.doc, label=state.label)
    return (
        {"rate": item.rate} | words | _given(scale=item.scale, angle=state.angle, start=item.start)
    )


def _contact_entry(item: ContactFormulas) -> dict[str, Any]:
    slip = item.slip[0] if len(item.slip) == 1 else list(item.slip)
    law = {**law_record(item.law), **dict(item.values)}
    return {"slip": slip, "normal": item.normal, "friction": law}


def _output_entry(item: OutputFormula) -> dict[str, Any]:
    return {"formula": item.formula, **_given(unit=item.unit, doc=item.doc, label=item.label)}


def _key(name: str) -> str:
    plain = name.isascii() and name.replace("_", "a").isalnum()
    return name if plain else toml_value(name)


def toml_value(value: Any) -> str:
    """Write a value as TOML, tables and arrays in one line.

    >>> toml_value({"law": "Stribeck", "vs": 0.25})
    '{ law = "Stribeck", vs = 0.25 }'
    """
    if isinstance(value, Mapping):
        entries = ", ".join(f"{_key(key)} = {toml_value(item)}" for key, item in value.items())
        return f"{{ {entries} }}"
    if isinstance(value, list | tuple):
        return f"[{', '.join(toml_value(item) for item in value)}]"
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        # JSON escapes a string as TOML does, but for one character.
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    number = float(value)
    return str(int(number)) if number.is_integer() and abs(number) < 1e15 else repr(number)
