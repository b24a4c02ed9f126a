"""The tables of a file, or of Python, read as a definition; types and entries are checked."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from numbers import Real
from typing import Any, TypeVar

from slipfold.errors import InputError
from slipfold.models.definitions.contact_formulas import read_contact
from slipfold.models.definitions.definition import (
    Definition,
    OutputFormula,
    StateFormula,
    WatchedValue,
)
from slipfold.models.definitions.names import check_names
from slipfold.models.definitions.source import Source
from slipfold.models.definitions.toml_entries import Entries, type_name
from slipfold.models.output import Limit
from slipfold.models.parameter import Parameter, State
from slipfold.models.suggestion import suggest

T = TypeVar("T")

TABLES = (
    *("parameters", "formulas", "states", "contacts", "forcing"),
    *("outputs", "limits", "events"),
)

MEASURES = ("max", "min", "peak_to_peak", "parameter")

MOST = 1000
"""Entries of a table: a hundred degrees of freedom have two hundred states."""

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
    if len(table) > MOST:
        raise source.error((name,), f"[{name}] has {len(table)} entries, more than {MOST}")
    for key in table:
        if not isinstance(key, str):
            raise source.error((name,), f"the key {key!r} of {name} is no text; give names")
    return tuple(read(source, key, value) for key, value in table.items())


def _parameter(source: Source, name: str, value: Any) -> Parameter:
    path = ("parameters", name)
    table = value if isinstance(value, Mapping) else {"value": value}
    known = ("value", "unit", "min", "max", "above", "below", "doc", "symbol")
    entries = Entries(source, path, table, known)
    if "value" not in entries:
        raise source.error(path, f"the parameter {name} has no value; give e.g. value = 1.0")
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
    parameter = Parameter(
        name,
        entries.number("value", 0.0, unit),
        unit,
        entries.text("doc"),
        lower,
        upper,
        lower_open,
        upper_open,
        entries.text("symbol"),
    )
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
    rate = entries.text("rate", lines=True)
    size = None if math.isnan(scale) else scale
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
    if key not in entries:
        raise source.error(path, f'{path[1]} has no {key}; give e.g. {key} = "2*q"')
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
        raise source.error(
            ("formulas", name), f"{name} is {type_name(value)}; give the formula in quotes"
        )
    return name, value


def _forcing(source: Source) -> tuple[str | None, str | None]:
    if "forcing" not in source.tables:
        return None, None
    table = source.tables["forcing"]
    entries = Entries(source, ("forcing",), table, ("period", "quiet"))
    if "period" not in entries:
        raise source.error(
            ("forcing",),
            'the table [forcing] has no period; give it in seconds, e.g. period = "2*pi/W", or '
            "leave the table out for an autonomous system",
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
        if key not in entries:
            raise source.error(path, f"the limit {name[:60]!r} has no {key}; give output and bound")
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
    if "value" not in entries:
        raise source.error(path, f"the event {name[:60]!r} has no value; give e.g. value = 1.0")
    _check_title(source, path)
    measure = entries.text("measure", "max")
    if measure not in MEASURES:
        raise entries.error(
            "measure", f"measure {measure[:80]!r} is unknown; give one of {', '.join(MEASURES)}"
        )
    return WatchedValue(
        name,
        entries.text("output", name),
        entries.number("value", 0.0),
        measure,
        entries.flag("stop"),
    )


def _check_title(source: Source, path: tuple[str, str]) -> None:
    name = path[1]
    if not name.strip() or len(name) > 60 or not name.isprintable() or set(name) & set("{}"):
        raise source.error(
            path, f"{name[:80]!r} is no name for one of the {path[0]}; give a few words", key=True
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
