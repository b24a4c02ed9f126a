"""``slipfold models``: what there is to compute with."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, Any

from slipfold.declarations import Option
from slipfold.errors import InputError
from slipfold.interface.cli.commands import FILES, FRICTION, argument, given_text
from slipfold.interface.cli.reading import find_model
from slipfold.interface.cli.running import say, write_json
from slipfold.text import PrintedTable

if TYPE_CHECKING:
    from slipfold.models.model import Model

READERS = {
    "model": given_text(
        argument("[MODEL]", "Show one model in detail, built-in or from a file.", default=None)
    ),
    "friction": given_text(FRICTION),
    "json": given_text(FILES[0]),
}
Show = Annotated[
    str | None,
    Option("Print the equations of a built-in model as a file to start from.", metavar="NAME"),
]


def models(model: str | None, friction: str | None, json: str | None, show: Show = None) -> None:
    """List the built-in models, or print one of them."""
    from slipfold.models.registry import built_in_models, built_in_text

    if friction is not None and model is None:
        raise InputError(
            f"--friction {friction} is for one model; give it, e.g. slipfold models sliding "
            f"--friction {friction}"
        )
    if show is not None:
        say(built_in_text(show).rstrip())
        return
    chosen = (
        [kind() for kind in built_in_models().values()]
        if model is None
        else [find_model(model, {}, friction)]
    )
    if json is not None:
        record = {"schema": "slipfold.models/1", "models": [_record(item) for item in chosen]}
        write_json(record, json)
        if json == "-":
            return
    if model is None:
        say("\n".join(_table([(item.name, item.title) for item in chosen])))
    else:
        say(_details(chosen[0]))


def _record(model: Model) -> dict[str, Any]:
    varied = {item.name for item in model.variable_parameters}

    def described(items: Sequence[Any]) -> list[dict[str, str]]:
        return [{"name": item.name, "unit": item.unit, "doc": item.doc} for item in items]

    return {
        "name": model.name,
        "title": model.title,
        "parameters": [
            {
                "name": item.name,
                "default": item.default,
                "value": model.values[item.name],
                "unit": item.unit,
                "lower": item.lower if math.isfinite(item.lower) else None,
                "upper": item.upper if math.isfinite(item.upper) else None,
                "bounds": item.bounds,
                "doc": item.doc,
                "varied": item.name in varied,
            }
            for item in model.parameters
        ],
        "states": described(model.states),
        "outputs": described(model.outputs()),
        "limits": [
            {"name": item.name, "output": item.output, "bound": item.bound} for item in model.limits
        ],
    }


def _details(model: Model) -> str:
    from slipfold.flow.modes import limits_of_contacts

    varied = {item.name for item in model.variable_parameters}
    parameters = [
        (
            item.name,
            f"{model.values[item.name]:.10g}",
            item.unit,
            item.bounds,
            item.doc if item.name in varied else f"{item.doc}; cannot be varied",
        )
        for item in model.parameters
    ]
    quantities = [
        [(item.name, item.unit, item.doc) for item in items]
        for items in (model.states, model.outputs())
    ]
    passed = limits_of_contacts(model)
    limits = [
        (
            item.name,
            f"where {item.output} <= {item.bound:g}",
            "unless it continues through stick and slip" if item.name in passed else "",
        )
        for item in model.limits
    ]
    sections = [
        [f"{model.name}: {model.title}" if model.title else model.name],
        ["Parameters", *_table([("name", "value", "unit", "bounds", "meaning"), *parameters])],
        ["States", *_table(quantities[0])],
        ["Outputs", *_table(quantities[1])],
        ["Limits, where a branch ends", *_table(limits)],
    ]
    # What has no outputs or limits needs no headings for them.
    filled = [section for index, section in enumerate(sections) if not index or len(section) > 1]
    return "\n\n".join("\n".join(section) for section in filled)


def _table(rows: Sequence[Sequence[str]]) -> list[str]:
    table = PrintedTable(rows[0], rows[1:], rows[0]).text() if rows else []
    return [f"  {line}" for line in table]
