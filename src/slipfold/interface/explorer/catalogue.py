"""The models that a client can ask for, and what the page shows of them at first."""

from __future__ import annotations

import re
from collections.abc import Mapping
from contextlib import suppress
from functools import lru_cache
from hashlib import blake2b
from pathlib import Path
from typing import Any

from slipfold.errors import InputError, refusal, suggest
from slipfold.flow.modes import contacts_of
from slipfold.interface.explorer.first_views import chosen_span, first_view, slider_range
from slipfold.interface.explorer.mechanism import loops_of
from slipfold.interface.explorer.messages import UNNAMED, ViewRequest
from slipfold.interface.explorer.plain import axis_of
from slipfold.interface.explorer.settings import PAGE
from slipfold.models.model import Model
from slipfold.models.nonlinear_mode import velocities_of
from slipfold.models.quantities import Parameter
from slipfold.models.registry import built_in_models, model_of_text
from slipfold.models.units import units_of, wanted_text

NAMED = re.compile(r"""["']([^"'\n]{1,255})["']""")
"""Quoted text, which may be the name of a file."""


class Catalogue:
    """Models by name; a client names one of them and nothing else is ever opened.

    `given` is a model to offer first, `file` that with its equations, if it has one. Raises
    `InputError` if it has nothing to vary.

    >>> Catalogue().model("sliding", {"Nd": 0.1})
    SlidingOscillator(Nd=0.1)
    """

    def __init__(self, given: Model | None = None, file: Path | None = None) -> None:
        if given is not None:
            _check_variable(given)
        self._file = (given, file)
        self.text: str | None = None  # of the file, as the model was made of it
        if file is not None and file.is_file():
            self.text = file.read_text("utf-8", "replace").removeprefix("\ufeff")
        built_in = {name: make() for name, make in built_in_models().items()}
        first = {} if given is None else {_key(given.name): given}
        self._models: Mapping[str, Model] = {**first, **built_in, **first}
        # Where texts may name files with matrices; None if they may name none
        self.folder = None if file is None else file.parent
        # A model is made anew when a file that its text names has changed
        self._kept = lru_cache(PAGE.texts)(
            lambda text, files, label: model_of_text(text, label, self.folder)
        )

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the models, a given one first."""
        return tuple(self._models)

    def model(self, name: str, values: Mapping[str, float], text: str | None = None) -> Model:
        """Return a model with some values of its own; that of a text, if one is given."""
        if text is not None:
            return self._written(text).replace(**values)
        if name not in self._models:
            raise InputError(
                f"there is no model {name!r}; {suggest(name, self.names)}"
                f"there are {', '.join(self.names)}"
            )
        return self._models[name].replace(**values)

    def refusals(
        self, name: str, values: Mapping[str, float], text: str | None = None
    ) -> dict[str, str]:
        """Return why a model cannot have these values, by parameter.

        Of values that contradict each other those are named that differ from the model's own and
        without which the others would do; all of them if there is none.

        >>> Catalogue().refusals("sliding", {"Ns": 2.0, "Vd": -1.0})
        {'Vd': 'Vd = -1 is outside its bounds; Vd must be >= 0 m/s'}
        """
        model = self.model(name, {}, text)
        alone = {key: refusal(model.parameter(key).check, values[key]) for key in values}
        result = {key: sentence for key, sentence in alone.items() if sentence}
        if result:
            return result
        sentence = refusal(model.replace, **values)
        if not sentence:
            return {}
        own = model.values
        blamed = [key for key in values if not refusal(model.replace, **{**values, key: own[key]})]
        return dict.fromkeys(blamed or values, sentence)

    def of(self, request: ViewRequest) -> Model:
        """Return the model that a request is about, without values of what it varies.

        A page sends the values of all its sliders; that of a varied parameter is not used, and must
        not contradict the others.
        """
        names = request.varied
        values = {name: value for name, value in request.parameters.items() if name not in names}
        return self.model(request.model, values, request.text)

    def file(self, model: Model) -> Path | None:
        """Return the file that holds the equations of a model."""
        given, file = self._file
        return file if given is not None and given.kind == model.kind else None

    def described(self, text: str, label: str) -> dict[str, Any]:
        """Describe the model of a text; messages call the text `label`."""
        model = self._written(text, label)
        _check_variable(model)
        return {**_described(_key(model.name), model), "files": files_of(text, self.folder)}

    def describe(self) -> list[dict[str, Any]]:
        """Return all models as plain data for the page."""
        result = [_described(name, model) for name, model in self._models.items()]
        if self.text is not None:
            result[0]["files"] = files_of(self.text, self.folder)
        return result

    def _written(self, text: str, label: str = "") -> Model:
        model: Model = self._kept(text, files_of(text, self.folder), label)
        return model


def files_of(text: str, folder: Path | None) -> str:
    """Return a digest of the state of the files in a folder that a text names; empty without any.

    It changes when one of them does.
    """
    states = []
    for name in dict.fromkeys(NAMED.findall(text)) if folder is not None else ():
        if Path(name).is_absolute() or ".." in Path(name).parts:
            continue
        with suppress(OSError, ValueError):
            status = (folder / name).stat()
            states.append((name, status.st_mtime_ns, status.st_size))
    return blake2b(repr(states).encode(), digest_size=8).hexdigest() if states else ""


def _check_variable(model: Model) -> None:
    if not model.variable_parameters:
        raise InputError(
            f"{model.name} has no parameter that may be varied, so there is no diagram to "
            "show; give its file a table [parameters]"
        )


def _key(name: str) -> str:
    """Return a name that requests may have, whatever a file calls its model."""
    return re.sub(f"[{UNNAMED}]", "_", name)[: PAGE.name_length] or "model"


def _described(name: str, model: Model) -> dict[str, Any]:
    first = first_view(model)
    knobs = model.variable_parameters
    return {
        "name": name,
        "title": model.title,
        "forced": model.forced,
        "states": [axis_of(model, item.name) for item in model.states],
        "rates": velocities_of(model.kind),
        "contacts": [
            {"name": item.name, "directions": len(item.slip)} for item in contacts_of(model)
        ],
        "loops": loops_of(model),
        "outputs": [axis_of(model, item.name) for item in model.outputs()],
        "parameters": [_parameter(model, item, first) for item in knobs],
        "vary": [item.name for item in knobs],
        "default": _default(model, first),
        "plane": first.get("plane"),
        "files": "",
    }


def _default(model: Model, first: Mapping[str, Any]) -> dict[str, Any]:
    vary, span = first.get("vary"), first.get("span")
    if vary is None or span is None:
        vary, span = chosen_span(model)
    return {
        "vary": vary,
        "span": span,
        "show": first.get("show") or model.shown[0],
        "statistic": "max",
        "parameters": first.get("parameters", {}),
    }


def _parameter(model: Model, item: Parameter, first: Mapping[str, Any]) -> dict[str, Any]:
    value = model.values[item.name]
    low, high = first["sliders"].get(item.name) or slider_range(model, item.name)
    low, high = min(low, value), max(high, value)
    return {
        **axis_of(model, item.name),
        "value": value,
        "display_unit": "deg" if item.unit == "rad" else item.unit,
        "units": units_of(item.unit),
        "wanted": wanted_text(item.unit),
        "bounds": item.bounds,
        "low": low,
        "high": high,
    }
