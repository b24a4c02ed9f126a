"""Models as texts that are edited on the page, and requests that need no computation."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from slipfold.errors import InputError
from slipfold.interface.explorer.catalogue import Catalogue
from slipfold.interface.explorer.curves import measurements_view
from slipfold.interface.explorer.equations import equations_of, sliding_text
from slipfold.interface.explorer.friction import with_law
from slipfold.interface.explorer.messages import (
    LawRequest,
    MeasurementsRequest,
    ModelRequest,
    PostedRequest,
    TextRequest,
    ValuesRequest,
)
from slipfold.models.definitions.source import source_of_file
from slipfold.models.definitions.system_file import toml_value, write_tables
from slipfold.models.friction.record import law_record
from slipfold.models.model import Model
from slipfold.models.registry import CASE_FILE, built_in_models, built_in_text
from slipfold.models.sliding_oscillator import SlidingOscillator
from slipfold.models.structures.structure import Structure
from slipfold.models.system import System
from slipfold.models.unforced import Unforced
from slipfold.parameter_space.measurement import parse_measurement


def answered(catalogue: Catalogue, request: PostedRequest) -> Any:
    """Return the answer to a request that needs no computation, as plain data."""
    if isinstance(request, ValuesRequest):
        return catalogue.refusals(request.model, request.parameters, request.text)
    if isinstance(request, MeasurementsRequest):
        model = catalogue.model(request.model, {}, request.text)
        return measurements_view(parse_measurement(request.measurements, request.name, model))
    if isinstance(request, TextRequest):
        model = catalogue.model(request.model, {}, request.text)
        file = None if request.text else catalogue.file(model)
        text = request.text or text_of(model, file)
        given = text if file is None else catalogue.text
        return {"text": text, "given": given, **equations_of(model, text)}
    if isinstance(request, LawRequest):
        model = catalogue.model(request.model, {}, request.text)
        if isinstance(model, SlidingOscillator) and request.text is None:
            text = case_text(model, changed_values(model))  # equations have other laws than it
        else:
            text = request.text or text_of(model, catalogue.file(model))
        return {"text": with_law(model, text, request.contact, request.law, catalogue.folder)}
    assert isinstance(request, ModelRequest)  # exports are computed
    return catalogue.described(request.text, request.name or "")


def is_built_in(model: Model) -> bool:
    """Whether a model of this kind comes with the package under its name.

    >>> from slipfold.models.system import System
    >>> is_built_in(System(name="duffing", parameters={"k": 1}, states={"q": "-k*q"}))
    False
    """
    make = built_in_models().get(model.name)
    return make is not None and make().kind == model.kind


def text_of(model: Model, file: Path | None = None) -> str:
    """Return the text to edit of a model: that of its file, of the package, or one that is written.

    >>> print(text_of(SlidingOscillator(f=12.2)))
    model = "sliding"
    <BLANKLINE>
    [parameters]
    f = 12.2
    <BLANKLINE>
    """
    if file is not None:
        return source_of_file(file, CASE_FILE).text or ""
    if model == SlidingOscillator():
        return sliding_text()
    if is_built_in(model) and isinstance(model, System | Structure):
        return built_in_text(model.name)
    if isinstance(model, System | Structure):
        return model.to_toml()
    return case_text(model, changed_values(model))


def case_text(model: Model, values: Mapping[str, float]) -> str:
    """Return the case of a model that is written in Python, with values."""
    text = write_tables({"model": model.name})
    sliding = model.forced_model if isinstance(model, Unforced) else model
    if isinstance(sliding, SlidingOscillator) and sliding.structure:
        text += f"friction = {toml_value(law_record(sliding.friction))}\n"
    elif not is_built_in(model):
        raise InputError(f"{model.name} was made in Python, and no text here can make it")
    return text + (f"\n{write_tables({'parameters': values})}" if values else "")


def changed_values(model: Model, usual: Model | None = None) -> dict[str, float]:
    """Return the parameter values that differ from the defaults, or from those of another model."""
    before = (
        {item.name: item.default for item in model.parameters} if usual is None else usual.values
    )
    return {name: value for name, value in model.values.items() if value != before[name]}


def whole_text(model: System | Structure, text: str | None) -> tuple[str, Model]:
    """Return a text that alone makes a model of this kind, and the model that it makes.

    That is the given text unless it names files or is a case.
    """
    own = type(model)
    if text is not None and "\n" in text:
        try:
            made = own.from_toml(text)
        except InputError:
            pass
        else:
            if made.kind == model.kind:
                return text, made
    text = model.to_toml()
    return text, own.from_toml(text)
