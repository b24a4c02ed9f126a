"""The equations of a model in words of its text, and the sources that the text names."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cache
from importlib.resources import files
from typing import Any

import numpy as np

from slipfold.interface.explorer.plain import formula_of, plain_text
from slipfold.models.friction.law import FrictionLaw
from slipfold.models.friction.without_memory import Regularized
from slipfold.models.model import Model
from slipfold.models.registry import model_of_text
from slipfold.models.sliding_oscillator import SlidingOscillator
from slipfold.models.structures.component import Component
from slipfold.models.structures.contacts import FrictionContact, ModulatedLoad, NormalLoad
from slipfold.models.structures.forcing import HarmonicForce, PeriodicForce
from slipfold.models.structures.matrices import Matrix
from slipfold.models.structures.springs import CubicSpring, LinearSpring
from slipfold.models.structures.structure import Structure
from slipfold.models.system import System
from slipfold.models.unforced import Unforced

ROWS = 12
"""Maximum number of displacements whose equations are written out."""

POWERS = str.maketrans("0123456789-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻")

Row = list[str]
"""Left side, right side, and what the left side is."""


@cache
def sliding_text() -> str:
    """Return the source paper's oscillator as a text with its equations."""
    return (files("slipfold.interface.explorer") / "sliding.toml").read_text(encoding="utf-8")


def equations_of(model: Model, text: str) -> dict[str, Any]:
    """Return what the text says of a model, and its equations in groups of rows, as plain data.

    >>> from slipfold.models.registry import model_named
    >>> equations_of(model_named("duffing"), "# Duffing")["groups"][0]["rows"][1][:2]
    ['v′', 'F cos(Ω t) − d v − k q − g q³']
    """
    about = []
    for line in text.splitlines():
        if not line.startswith("#") and line.strip():
            break
        about.append(line.removeprefix("#").strip())
    shown: Model = model.forced_model if isinstance(model, Unforced) else model
    if isinstance(shown, SlidingOscillator):
        shown = model_of_text(sliding_text())
        law = model.structure.get("friction")
        groups = _of_system(shown, law if isinstance(law, FrictionLaw) else None)
    elif isinstance(shown, System):
        groups = _of_system(shown)
    elif isinstance(shown, Structure):
        groups = _of_structure(shown)
    else:
        groups = {}
    return {
        "about": " ".join(line for line in about if not line.startswith("slipfold explore:")),
        "title": model.title,
        "groups": [{"title": title, "rows": rows} for title, rows in groups.items() if rows],
    }


def _of_system(model: Model, law: FrictionLaw | None = None) -> dict[str, list[Row]]:
    assert isinstance(model, System)
    definition = model._equations.definition
    symbols = _symbols(model)
    contacts: list[Row] = []
    for name, table in definition.contacts.items():
        slips = [_pretty(part, symbols) for part in table.slip]
        force = _vector([_pretty(force, symbols) for force in table.forces(name)])
        own = law or table.friction.law
        formulas = table.friction.formulas.items()
        named = _symbols(law) if law else {key: _pretty(text, symbols) for key, text in formulas}
        contacts += _force(own, named, force, slips, f"in {name}")
        contacts.append(["N", _pretty(table.normal, symbols), f"normal force of {name}"])
        contacts += _coefficient(own, named)
    period = definition.period
    return {
        "Equations of motion": [
            [f"{_symbol(name)}′", _pretty(item.rate, symbols), item.doc]
            for name, item in definition.states.items()
        ],
        "where": [
            [_symbol(name), _pretty(text, symbols), ""]
            for name, text in definition.formulas.items()
        ],
        "Contacts": contacts,
        "Forcing": [] if period is None else [["T", _pretty(period, symbols), "period in s"]],
        "Outputs": [
            [_symbol(name), _pretty(item.formula, symbols), item.doc]
            for name, item in definition.outputs.items()
        ],
    }


def _of_structure(model: Structure) -> dict[str, list[Row]]:
    assembly = model._assembly
    definition, names = assembly.definition, assembly.names
    symbols = _symbols(model)
    parts: list[Row] = []
    forces: dict[int, list[str]] = {}
    for place, item in enumerate(assembly.placed):
        component = item.component
        name = f"{_letter(component)}{component.name or place + 1}"
        for axis, row in enumerate(item.rows):
            one = name if len(item.rows) == 1 else f"{name}{'xyz'[axis]}"
            for column in np.flatnonzero(row):
                forces.setdefault(int(column), []).append(
                    _times(row[column], one, bool(forces.get(int(column))))
                )
        parts += _component(component, name, symbols)
    whole = isinstance(definition.C, Matrix) or definition.C is None
    rows: list[Row] = [
        [
            "M q″ + C q′ + K q",
            "forces of the parts below",
            f"{len(names)} coordinate{'s' * (len(names) > 1)}",
        ]
    ]
    if len(names) <= ROWS and whole and not assembly.reduced:
        damping = model.damping_matrix
        rows += [
            [
                _sum(
                    [
                        (model.mass_matrix[i], "″"),
                        (damping[i], "′"),
                        (model.stiffness_matrix[i], ""),
                    ],
                    names,
                ),
                "".join(forces.get(i, ["0"])),
                "",
            ]
            for i in range(len(names))
        ]
    elif not whole:
        rows.append(["C", _call(definition.C, symbols), "damping"])
    return {"Equations of motion": rows, "Parts": parts}


def _sum(parts: list[tuple[Any, str]], names: tuple[str, ...]) -> str:
    text = ""
    for row, mark in parts:
        for value, name in zip(row, names, strict=True):
            if value:
                text += _times(value, f"{_symbol(name)}{mark}", bool(text))
    return text or "0"


def _times(value: float, name: str, is_next: bool) -> str:
    sign = (" − " if value < 0 else " + ") if is_next else ("−" if value < 0 else "")
    factor = "" if abs(value) == 1 else f"{abs(value):.6g} "
    return f"{sign}{factor}{name}"


def _letter(component: Component) -> str:
    if isinstance(component, FrictionContact):
        return "R"
    return "P" if isinstance(component, PeriodicForce) else "S"


def _component(component: Component, name: str, symbols: Mapping[str, str]) -> Iterator[Row]:
    """Yield what the force of a component is."""
    names = [item.name for item in component.parameters]
    own = {key: symbols.get(component._parameter_name(key), key) for key in names}
    if isinstance(component, FrictionContact):
        along = [str(direction) for direction in component.along]
        plate = own.get("Vd", "Vd")
        turns = ("",) if len(along) == 1 else ("cos", "sin")
        of = [f"{plate} {turn}({own.get('alpha', 'α')})" if turn else plate for turn in turns]
        slips = [
            f"{part} − {one}′" if one.isidentifier() else f"{part} − ({one})′"
            for part, one in zip(of, along, strict=True)
        ]
        yield from _force(component.law, own, name, slips, f"along {', '.join(along)}")
        yield ["N", _load(component.load, own), f"normal force of {name}"]
        yield from _coefficient(component.law, own)
    elif isinstance(component, HarmonicForce):
        order = "" if component.harmonic == 1 else f"{component.harmonic}·"
        yield [name, f"{own['F']} cos(2π {order}f t + {own['phi']})", f"force at {component.at}"]
    elif isinstance(component, LinearSpring | CubicSpring):
        k, power = ("k", "") if isinstance(component, LinearSpring) else ("k3", "³")
        yield [name, f"−{own[k]} ({component.at}){power}", f"spring along {component.at}"]
    else:
        at = getattr(component, "at", "")
        yield [name, _call(component, own), f"on {at}" if at else ""]


def _load(load: NormalLoad, own: Mapping[str, str]) -> str:
    if isinstance(load, ModulatedLoad):
        return f"{own['Ns']} + {own['Nd']} cos(2π f t)"
    return own["Ns"] if type(load).__name__ == "ConstantLoad" else _call(load, own)


def _call(part: Any, own: Mapping[str, str]) -> str:
    """Name a part with its parameters, where a formula would be long."""
    return f"{part.title}: {', '.join(own.get(key, key) for key in part.values)}"


def _force(
    law: FrictionLaw, named: Mapping[str, str], force: str, slips: Sequence[str], of: str
) -> Iterator[Row]:
    """Yield a friction force, and how its memory changes if the law has one.

    In the plane force and slip are vectors.
    """
    kind, named = type(law), {**named, "v": "s"}
    slip = _vector(slips)
    if law.memory(1):
        yield [force, f"{_said(kind.forces, named)}, s = {slip}", f"friction {of}"]
        yield ["z′", _said(kind.memory_rates, named), f"memory of {force}"]
    else:
        yield [force, f"μ(|s|) N s/|s|, s = {slip}", f"friction {of}"]
        if law.sticks:
            most = named.get("mu_s", "μ(0)")
            yield [f"|{force}|", f"{most} N at most", "where s = 0: it sticks"]


def _vector(parts: Sequence[str]) -> str:
    return parts[0] if len(parts) == 1 else f"({', '.join(parts)})"


def _coefficient(law: FrictionLaw, named: Mapping[str, str], name: str = "μ") -> Iterator[Row]:
    """Yield the friction coefficient, and that of the law which it regularizes."""
    text = _said(type(law).formula, {**named, "v": "|s|"}) or law.label
    yield [f"{name}(|s|)", text, "" if text == law.label else law.label]
    if hasattr(law, "exponent"):
        yield ["n", str(law.exponent), "exponent"]
    if isinstance(law, Regularized):
        yield from _coefficient(law.law, named, "μ₀")


def _said(method: Callable[..., Any], symbols: Mapping[str, str]) -> str:
    """Return the formulas that describe a method of a law, with the words between them."""
    words = " ".join((method.__doc__ or "").split()).removesuffix(".")
    if "``" not in words:
        return ""
    return re.sub(r"``(.+?)``", lambda found: _pretty(found[1], symbols), words)


def _symbols(owner: Model | FrictionLaw) -> dict[str, str]:
    return {item.name: _symbol(item.name, item.symbol) for item in owner.parameters}


def _symbol(name: str, symbol: str = "") -> str:
    formula = symbol or formula_of(name)
    return plain_text(formula) if formula != name else name


_TOKEN = re.compile(r"[A-Za-z_]\w*|\*\*|\^-?\d+(?![\w.])|\*|-|.", re.DOTALL)


def _pretty(formula: str, symbols: Mapping[str, str]) -> str:
    """Return a formula as one writes it by hand."""
    parts = []
    for token in _TOKEN.findall(formula):
        if token[0].isalpha() or token[0] == "_":
            parts.append(
                symbols.get(token) or {"pi": "π", "sqrt": "√"}.get(token) or _symbol(token)
            )
        elif token.startswith("^") and len(token) > 1:
            parts.append(token[1:].translate(POWERS))
        else:
            parts.append({"*": " ", "-": "−", "'": "′"}.get(token, token))
    return re.sub(r" {2,}", " ", "".join(parts))
