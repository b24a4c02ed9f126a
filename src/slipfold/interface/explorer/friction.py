"""Friction of a model's contacts: the laws, their coefficients, and other laws in their place."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from slipfold.errors import InputError
from slipfold.interface.explorer.messages import FrictionRequest
from slipfold.interface.explorer.plain import Check, Emit, number, short
from slipfold.models.definitions.source import Keys, Source, source_of_text, value_end
from slipfold.models.definitions.system_file import toml_value
from slipfold.models.friction.law import FrictionLaw
from slipfold.models.friction.record import friction_laws
from slipfold.models.model import Model
from slipfold.models.registry import model_of_text
from slipfold.models.sliding_oscillator import SlidingOscillator
from slipfold.models.structures.structure import Structure
from slipfold.models.system import System
from slipfold.models.unforced import Unforced

POINTS = 161
"""Slip speeds at which a coefficient is drawn, denser near rest, where it changes most."""


class LawInPlace(NamedTuple):
    """The friction law of a contact, with its present values."""

    name: str  # name of the contact
    law: FrictionLaw
    path: Keys  # the entry of the model's text that gives it
    plate: float | None  # speed of the moving surface in m/s; None where formulas give it
    names: Mapping[str, str]  # names that the model gives the law's parameters


def laws_of(model: Model) -> list[LawInPlace]:
    """Return the friction laws of all contacts that a text of the model can change.

    >>> from slipfold.models.registry import model_named
    >>> [(item.name, item.law) for item in laws_of(model_named("sliding"))]
    [('tip', Coulomb(mu_s=0.5, mu_k=0.5))]
    """
    sliding = model.forced_model if isinstance(model, Unforced) else model
    if isinstance(sliding, SlidingOscillator):
        law = sliding.friction
        names = {name: name for name in (*law.values, "mu")}  # that of Coulomb's law without one
        return [LawInPlace("tip", law, ("friction",), sliding.values["Vd"], names)]
    if isinstance(model, Structure):
        return _of_structure(model)
    if isinstance(model, System):
        c = model.coefficients(model.values)
        return [
            LawInPlace(
                item.name,
                item.law.replace(**item.law_values(c)),
                ("contacts", item.name, "friction"),
                None,
                {},
            )
            for item in model._equations.contacts
        ]
    return []


def _of_structure(model: Structure) -> list[LawInPlace]:
    assembly = model._assembly
    placed = assembly.friction_contacts
    if len(placed) != len(assembly.given.contacts):
        return []  # the contacts of a sector stand for those of all
    result = []
    for place, (item, contact) in enumerate(placed):
        own = assembly.own_values(item, model.values)
        names = {name: contact._parameter_name(name) for name in contact.law.values}
        path = ("contacts", str(place), "friction")
        name = contact.name or "contact"
        result.append(LawInPlace(name, contact._law_with(own), path, own["Vd"], names))
    return result


def _choices(model: Model) -> dict[str, str]:
    """Return titles of the laws that contacts of a model may have: those that need no other law."""
    return {
        name: law.title
        for name, law in friction_laws().items()
        if name not in ("Regularized", "Iwan") and (law.sticks or not isinstance(model, System))
    }


def send_friction(model: Model, request: FrictionRequest, send: Emit, check: Check) -> None:
    """Send the friction coefficient of each contact over the slip speed."""
    contacts = []
    for item in laws_of(model):
        check()
        top = max(5 * item.law.typical_speed, 1.2 * (item.plate or 0.0))
        speed = top * np.linspace(0.0, 1.0, POINTS) ** 2
        with np.errstate(all="ignore"):
            coefficient = np.broadcast_to(item.law.coefficient(speed), speed.shape)
        contacts.append(
            {
                "name": item.name,
                "law": type(item.law).__name__,
                "title": item.law.label,
                "speed": short(speed),
                "coefficient": short(np.nan_to_num(coefficient)),
                "holding": number(item.law.stiction) if item.law.sticks else None,
                "plate": number(item.plate),
            }
        )
    send({"contacts": contacts, "laws": _choices(model)})


def with_law(model: Model, text: str, contact: int, law: str, folder: Path | None) -> str:
    """Return the text of a model with another friction law in a contact.

    Parameters that both laws have keep their entries.
    """
    present = laws_of(model)
    if not contact < len(present):
        raise InputError(
            f"{model.name} has {len(present)} contacts whose law can be chosen here, not "
            f"{contact + 1}; write it in the text of the model"
        )
    item, new = present[contact], friction_laws().get(law)
    if new is None:
        raise InputError(f"there is no law {law!r}; there are {', '.join(friction_laws())}")
    source = source_of_text(text)
    before = _entry(source.tables, item.path)
    own = {field.name for field in fields(new)}
    kept = before if isinstance(before, Mapping) else {}
    inner = kept.get("of")  # a regularized law's
    kept = {**(inner if isinstance(inner, Mapping) else {}), **kept}
    table = {"law": law} | {key: value for key, value in kept.items() if key in own}
    changed = _replaced(source, item.path, toml_value(table))
    gone = [name for key, name in item.names.items() if key not in own]
    changed = _without(changed, gone)
    model_of_text(changed, "", folder)  # refuses a law that the model cannot have
    return changed


def _entry(tables: Any, path: Keys) -> Any:
    for key in path:
        tables = tables[int(key)] if isinstance(tables, list) else tables.get(key)
        if tables is None:
            return None
    return tables


def _replaced(source: Source, path: Keys, value: str) -> str:
    """Return a text with another value of an entry, which may be missing."""
    text, locations = source.text or "", source.locations or {}
    if path in locations:
        start = locations[path].value
        if text.startswith("[", start):
            message = "this law is a table of its own; change it in the text"
            raise source.error(path, message)
        return text[:start] + value + text[value_end(text, start) :]
    above = path[:-1]
    start = locations[above].value if above else 0
    if text.startswith("{", start):
        return f"{text[: start + 1]} {path[-1]} = {value},{text[start + 1 :]}"
    # In a table with a header it is the first entry; in a case it stands before all tables.
    start = text.index("\n", start) + 1 if above else 0
    return f"{text[:start]}{path[-1]} = {value}\n{text[start:]}"


def _without(text: str, names: list[str]) -> str:
    """Return a text without the values of parameters that are gone."""
    locations = source_of_text(text).locations or {}
    spans = [locations[("parameters", name)] for name in names if ("parameters", name) in locations]
    for span in sorted(spans, key=lambda item: -item.key):
        end = value_end(text, span.value)
        if text[: span.key].rpartition("\n")[2].strip() == "":
            text = text[: span.key] + text[end:].lstrip(" \t").removeprefix("\n")
    return text
