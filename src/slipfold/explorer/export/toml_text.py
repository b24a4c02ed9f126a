"""The case file that makes a view, with the command that reads it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from slipfold.errors import InputError
from slipfold.explorer.export.described_model import changed_values, filed_model, is_built_in
from slipfold.explorer.messages import (
    DiagramRequest,
    DrawnRequest,
    OrbitRequest,
    PlaneRequest,
    SimulationRequest,
)
from slipfold.explorer.start import start_of
from slipfold.models.definitions.toml_writer import toml_value
from slipfold.models.friction import law_record
from slipfold.models.model import Model
from slipfold.models.sliding_oscillator import SlidingOscillator
from slipfold.models.system import System
from slipfold.models.unforced import Unforced


def toml_text(model: Model, view: DrawnRequest, file: Path | None = None) -> str:
    """Return a case file; its first line is the command that computes what the view shows.

    >>> from slipfold.explorer.messages import parse_request
    >>> from slipfold.models import SlidingOscillator
    >>> view = parse_request(
    ...     '{"kind": "diagram", "id": 1, "model": "sliding", "vary": "Nd", "span": [0, 0.98],'
    ...     ' "show": "x"}'
    ... )
    >>> print(toml_text(SlidingOscillator(f=12.2), view))
    # slipfold response case.toml --vary Nd=0.0:0.98
    model = "sliding"
    <BLANKLINE>
    [parameters]
    f = 12.2
    <BLANKLINE>
    """
    if isinstance(view, OrbitRequest):
        raise InputError(
            "no command computes a single orbit from a case file; copy it as Python instead"
        )
    command = _command(model, view)
    if isinstance(model, System) and not is_built_in(model):
        # The values of a definition are its own, so the command changes them.
        changed = changed_values(model)
        sets = "".join(f" --set {name}={value!r}" for name, value in changed.items())
        return f"# {command}{sets}\n{model.to_toml()}"
    head: dict[str, Any]
    usual: Model | None
    sliding = model.forced_model if isinstance(model, Unforced) else model
    if is_built_in(model):
        head, usual = {"model": model.name}, None
    elif isinstance(sliding, SlidingOscillator):
        head, usual = {"model": model.name, "friction": law_record(sliding.friction)}, None
    else:
        head, usual = {"model": str(file)}, filed_model(model, file)
    lines = "".join(f"{key} = {toml_value(value)}\n" for key, value in head.items())
    changed = changed_values(model, usual)
    values = "".join(f"{name} = {value!r}\n" for name, value in changed.items())
    return f"# {command}\n{lines}" + (f"\n[parameters]\n{values}" if values else "")


def _command(model: Model, view: DrawnRequest) -> str:
    if isinstance(view, DiagramRequest):
        return f"slipfold response case.toml --vary {_span(view.vary, view.span)}"
    if isinstance(view, PlaneRequest):
        axes = " ".join(f"--vary {_span(axis.name, axis.span)}" for axis in (view.x, view.y))
        return f"slipfold locus case.toml {axes}{' --regions' if model.forced else ''}"
    assert isinstance(view, SimulationRequest)  # orbits were refused
    start = start_of(model, view)
    states = "".join(f" --state {name}={value!r}" for name, value in start.items())
    return f"slipfold simulate case.toml --periods {view.periods}{states}"


def _span(name: str, span: tuple[float, float]) -> str:
    return f"{name}={span[0]!r}:{span[1]!r}"
