"""The Python that makes a view."""

from __future__ import annotations

import re
from pathlib import Path

from slipfold.explorer.export.described_model import changed_values, filed_model, is_built_in
from slipfold.explorer.messages import (
    DiagramRequest,
    DrawnRequest,
    PlaneRequest,
    SimulationRequest,
)
from slipfold.explorer.start import start_of, timed
from slipfold.models.model import Model
from slipfold.models.parameter import DURATION
from slipfold.models.sliding_oscillator import SlidingOscillator
from slipfold.models.system import System
from slipfold.models.unforced import Unforced
from slipfold.orbits.periodic_orbit import PeriodicOrbit

_CLASS, _PUBLIC = re.compile(r"\b([A-Z]\w*)\("), r"sf.\1("
"""Names of classes in what a friction law prints, and the same as public names."""


def python_text(
    model: Model,
    view: DrawnRequest,
    orbit: PeriodicOrbit | None,
    file: Path | None = None,
    readings: str | None = None,
) -> str:
    """Return a script that computes and draws what a view shows; a diagram with readings of a file.

    >>> from slipfold.explorer.messages import parse_request
    >>> view = parse_request(
    ...     '{"kind": "diagram", "id": 1, "model": "sliding", "vary": "Nd", "span": [0, 0.98],'
    ...     ' "show": "x"}'
    ... )
    >>> print(python_text(SlidingOscillator(), view, None))
    import slipfold as sf
    <BLANKLINE>
    model = sf.SlidingOscillator()
    diagram = sf.response(model, vary="Nd", span=(0.0, 0.98))
    print(diagram.summary())
    diagram.plot("x", measure="max").figure.savefig("diagram.svg")
    <BLANKLINE>
    """
    shown = model if orbit is None else orbit.model
    lines = [
        "import slipfold as sf",
        "",
        f"model = {_model(shown, file)}",
        *_steps(shown, view, orbit, readings),
    ]
    return "\n".join(lines) + "\n"


def _steps(
    model: Model, view: DrawnRequest, orbit: PeriodicOrbit | None, readings: str | None
) -> list[str]:
    if isinstance(view, DiagramRequest):
        span = f"({view.span[0]!r}, {view.span[1]!r})"
        read = f"measured = sf.read_measurement({readings!r}, model)"
        return [
            f'diagram = sf.response(model, vary="{view.vary}", span={span})',
            "print(diagram.summary())",
            *([read] if readings else []),
            f'diagram.plot("{view.show}", measure="{view.statistic}"'
            f'{", measured=measured" if readings else ""}).figure.savefig("diagram.svg")',
        ]
    if isinstance(view, PlaneRequest):
        window = (
            f"(({view.x.span[0]!r}, {view.x.span[1]!r}), ({view.y.span[0]!r}, {view.y.span[1]!r}))"
        )
        # There are regions of forced models only.
        regions = "" if model.forced else ", regions=False"
        plane = f'("{view.x.name}", "{view.y.name}")'
        return [
            f"found = sf.bifurcation_set(model, {plane}, {window}{regions})",
            "print(found.summary())",
            'found.plot().figure.savefig("plane.svg")',
        ]
    if isinstance(view, SimulationRequest):
        start = start_of(model, view)
        unit = "" if model.forced else f", duration={timed(model, view).values['duration']!r}"
        return [
            f"motion = sf.simulate(model, periods={view.periods}, state={start!r}{unit})",
            "print(motion.summary())",
            f'motion.plot("{model.states[0].name}").figure.savefig("motion.svg")',
        ]
    assert orbit is not None  # what is left is an orbit
    names = [item.name for item in model.states]
    state = dict(zip(names, orbit.state.tolist(), strict=True))
    return [
        f"orbit = sf.periodic_orbit(model, period={orbit.period}, state={state!r})",
        "print(orbit.multipliers, orbit.stable)",
        "time, states = orbit.sample()",
    ]


def _model(model: Model, file: Path | None) -> str:
    """Return an expression that makes a model; numbers are exact when read back."""
    values = _values(model)
    if isinstance(model, SlidingOscillator):
        law = model.structure.get("friction")
        friction = [] if law is None else [f"friction={_CLASS.sub(_PUBLIC, repr(law))}"]
        return f"sf.SlidingOscillator({', '.join([*friction, *([values] if values else [])])})"
    if is_built_in(model):
        return f'sf.built_in_models()["{model.name}"]({values})'
    if isinstance(model, System):
        made = f"sf.System.from_toml({_quoted(model.to_toml())})"
        return f"{made}.replace({values})" if values else made
    if isinstance(model, Unforced):
        forced = f"sf.Unforced({_model(model.forced_model, file)})"
        own = DURATION.name
        changed = model.values[own] != DURATION.default
        return f"{forced}.replace({own}={model.values[own]!r})" if changed else forced
    found = filed_model(model, file)
    made, values = f"sf.Structure.from_toml({str(file)!r})", _values(model, found)
    return f"{made}.replace({values})" if values else made


def _values(model: Model, usual: Model | None = None) -> str:
    return ", ".join(f"{name}={value!r}" for name, value in changed_values(model, usual).items())


def _quoted(text: str) -> str:
    """Return a literal of a text of several lines; quotes and backslashes stay what they are."""
    if "'''" in text or text.endswith("'"):
        return repr(text)
    return f"r'''\n{text}'''"
