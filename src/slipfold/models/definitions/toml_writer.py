"""A definition as a TOML text, always the same for the same definition."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import Any

from slipfold.models.definitions.contact_formulas import ContactFormulas
from slipfold.models.definitions.definition import (
    Definition,
    OutputFormula,
    StateFormula,
    WatchedValue,
)
from slipfold.models.friction.record import law_record
from slipfold.models.output import Limit
from slipfold.models.parameter import Parameter

Value = str | float | bool


def write_definition(definition: Definition) -> str:
    """Write a definition as TOML.

    >>> from slipfold.models import State
    >>> from slipfold.models.definitions.definition import StateFormula
    >>> print(write_definition(Definition("decay", states=(StateFormula(State("q"), "-q"),))))
    name = "decay"
    <BLANKLINE>
    [states]
    q = "-q"
    <BLANKLINE>
    """
    head = {key: text for key in ("name", "title") if (text := getattr(definition, key))}
    tables = [
        _table("parameters", {item.name: _parameter(item) for item in definition.parameters}),
        _table("formulas", {name: {"formula": text} for name, text in definition.formulas}),
        _table("states", {item.state.name: _state(item) for item in definition.states}),
        _contacts(definition),
        _forcing(definition),
        _table("outputs", {item.name: _output(item) for item in definition.outputs}),
        _table("limits", {item.name: _limit(item) for item in definition.limits}),
        _table("events", {item.name: _event(item) for item in definition.events}),
    ]
    return "\n\n".join([_lines(head), *(table for table in tables if table)]) + "\n"


def _lines(values: Mapping[str, Value]) -> str:
    return "\n".join(f"{_key(key)} = {_value(value)}" for key, value in values.items())


def _contacts(definition: Definition) -> str:
    lines = [f"{_key(item.name)} = {toml_value(_contact(item))}" for item in definition.contacts]
    return "\n".join(["[contacts]", *lines]) if lines else ""


def _contact(item: ContactFormulas) -> dict[str, Any]:
    slip = item.slip[0] if len(item.slip) == 1 else list(item.slip)
    law = {**law_record(item.law), **dict(item.values)}
    return {"slip": slip, "normal": item.normal, "friction": law}


def _forcing(definition: Definition) -> str:
    given = {"period": definition.period, "quiet": definition.quiet}
    texts: dict[str, Value] = {key: text for key, text in given.items() if text is not None}
    return f"[forcing]\n{_lines(texts)}" if texts else ""


def _table(name: str, entries: Mapping[str, Mapping[str, Value]]) -> str:
    lines = [f"{_key(key)} = {_entry(values)}" for key, values in entries.items()]
    return "\n".join([f"[{name}]", *lines]) if lines else ""


def _entry(values: Mapping[str, Value]) -> str:
    """An entry with nothing but its first value is written as that value."""
    if len(values) == 1:
        return _value(*values.values())
    return "{ " + ", ".join(f"{key} = {_value(value)}" for key, value in values.items()) + " }"


def _parameter(item: Parameter) -> dict[str, Value]:
    values: dict[str, Value] = {"value": item.default, **_words(item.unit, item.doc)}
    if math.isfinite(item.lower):
        values["above" if item.lower_open else "min"] = item.lower
    if math.isfinite(item.upper):
        values["below" if item.upper_open else "max"] = item.upper
    return {**values, "symbol": item.symbol} if item.symbol else values


def _state(item: StateFormula) -> dict[str, Value]:
    values: dict[str, Value] = {"rate": item.rate}
    values |= _words(item.state.unit, item.state.doc, item.state.label)
    values |= {"scale": item.scale} if item.scale is not None else {}
    values |= {"angle": True} if item.state.angle else {}
    return values | ({"start": item.start} if item.start else {})


def _output(item: OutputFormula) -> dict[str, Value]:
    return {"formula": item.formula, **_words(item.unit, item.doc, item.label)}


def _limit(item: Limit) -> dict[str, Value]:
    return {"output": item.output, "bound": item.bound, "reason": item.reason}


def _event(item: WatchedValue) -> dict[str, Value]:
    return {
        "output": item.output,
        "value": item.value,
        "measure": item.measure,
        "stop": item.stop,
    }


def _words(unit: str, doc: str, label: str = "") -> dict[str, Value]:
    words = {"unit": unit, "doc": doc, "label": label}
    return {key: text for key, text in words.items() if text}


def _key(name: str) -> str:
    plain = name.isascii() and name.replace("_", "a").isalnum()
    return name if plain else _value(name)


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
    return _value(float(value) if isinstance(value, int) and not isinstance(value, bool) else value)


def _value(value: Value) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        # JSON escapes a string as TOML does, but for one character.
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    return str(int(value)) if value.is_integer() and abs(value) < 1e15 else repr(value)
