"""What the page shows of a model at first: what is declared, else where something happens."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Iterator, Mapping
from functools import cache
from importlib.resources import files
from itertools import pairwise
from time import process_time
from typing import Any

import numpy as np

from slipfold.arrays import Array
from slipfold.computations.response import response
from slipfold.errors import BREAKDOWNS, refusal
from slipfold.interface.explorer.messages import ScreenRequest
from slipfold.interface.explorer.plain import Check, Emit, number
from slipfold.interface.explorer.settings import PAGE
from slipfold.models.equilibria import check_followed, search_equilibrium
from slipfold.models.model import Model, evaluation_of
from slipfold.models.quantities import Parameter
from slipfold.models.registry import built_in_models
from slipfold.orbits.bifurcation_types import BIFURCATION_TYPES
from slipfold.progress import Progress
from slipfold.text import certain


class SCREEN:
    """How bifurcations of equilibria are looked for before a response is computed."""

    # Values of each parameter: one between two bifurcations is enough to see that there are some
    values: int = 17
    # Spans that are tried, over the distance of a slider's ends from the value
    widths: tuple[float, ...] = (1.0, 3.0)
    seconds: float = 1.0  # of a processor: the page waits for it
    # Processor seconds for responses of a forced model, of all and of one: nobody waits for them
    forced: float = 2.0
    one: float = 0.7
    # Real part of an eigenvalue, over the largest modulus, that counts as positive
    positive: float = 1e-9
    halvings: int = 20  # of the way to a value that the model does not allow
    longest: float = 20.0  # forcing period at a slider's end, over the model's own, at most
    # Fraction of a declared forcing at which a span begins: less may leave a dry contact stuck, and
    # then no orbit is isolated
    moving: float = 0.5


def first_view(model: Model) -> dict[str, Any]:
    """Return the first view of a model.

    It is declared for built-in models. A user's model may have the same name and other parameters:
    entries of a parameter that is not the same are left out.

    >>> from slipfold.models.system import System
    >>> own = System(name="duffing", parameters={"a": 1}, states={"q": "a - q"})
    >>> first_view(own)
    {'sliders': {}, 'show': 'q'}
    """
    known = _known().get(model.name)
    if known is None:
        return {"sliders": {}}
    named = {item.name: item for item in built_in_models()[model.name]().variable_parameters}
    same = {item.name for item in model.variable_parameters if named.get(item.name) == item}
    sliders = known.get("sliders", {})
    result = {"sliders": {name: ends for name, ends in sliders.items() if name in same}}
    if known["vary"] in same:
        result |= {key: known[key] for key in ("vary", "span", "parameters") if key in known}
    if known["show"] in {item.name for item in model.states}:
        result["show"] = known["show"]
    if "plane" in known and {axis["name"] for axis in known["plane"].values()} <= same:
        result["plane"] = known["plane"]
    return result


@cache
def _known() -> Mapping[str, Any]:
    text = (files("slipfold.interface.explorer") / "first_view.toml").read_text(encoding="utf-8")
    return tomllib.loads(text)


def chosen_span(model: Model) -> tuple[str, list[float]]:
    """Return a parameter and a span in which something happens, else what the model names.

    Of an autonomous model that is the first parameter along which an equilibrium loses stability,
    at a Hopf point if there is one.

    >>> from slipfold.models.system import System
    >>> states = {"x": "v", "v": "a*v - v^3 - k*x"}
    >>> chosen_span(System(name="own", parameters={"k": 1, "a": 0.5}, states=states))
    ('a', [-0.5, 1.0])
    """
    usual = model.varied_first or model.variable_parameters[0].name
    until = process_time() + SCREEN.seconds
    for width in SCREEN.widths if not model.forced else ():
        found = list(_screened(model, usual, width, until))
        if found:
            *_, vary, span = min(found, key=lambda item: item[:2])
            return vary, span
    return usual, span_about(model, usual)


def send_screen(model: Model, request: ScreenRequest, send: Emit, check: Check) -> None:
    """Look for a parameter over which a response has a bifurcation; send the first that is found.

    If none is found, that is one over which there is a response at all, with a value where there is
    one. Responses are followed over the ranges of the sliders, for a short time.
    """
    until, offer = process_time() + SCREEN.forced, dict[str, Any](vary=None)
    names = [item.name for item in model.variable_parameters if item.name != request.vary]
    for name in names if model.forced else ():
        end = min(until, process_time() + SCREEN.one)

        def watch(progress: Progress, end: float = end) -> None:
            check()
            if process_time() > end:
                raise KeyboardInterrupt

        try:
            span = span_about(model, name)
            branches = response(model, name, (span[0], span[1]), on_progress=watch).branches
        except (*BREAKDOWNS, KeyboardInterrupt):
            continue  # interrupted before there was a branch
        points = [p for each in branches[:1] for p in each.special if p.type in BIFURCATION_TYPES]
        if points:
            value = number(certain(points[0].value, points[0].uncertainty))
            offer = {"vary": name, "span": span, "type": points[0].type, "value": value}
            break
        if branches and not offer["vary"]:
            middle = float(branches[0].parameter[len(branches[0]) // 2])
            offer = {"vary": name, "span": span, "type": None, "value": middle}
    send({**offer, "done": True})


def _screened(
    model: Model, usual: str, width: float, until: float
) -> Iterator[tuple[bool, bool, str, list[float]]]:
    """Yield parameters with spans in which an equilibrium gains or loses stability.

    Before them: whether it does so otherwise than at a Hopf point, and whether the parameter has no
    effect at the model's own value, zero.
    """
    start = search_equilibrium(model, model.start)
    names = [item.name for item in model.variable_parameters]
    for name in sorted(names, key=lambda other: other != usual):
        if start is None or process_time() > until:
            return
        span = span_about(model, name, width)
        own, values = model.values[name], np.linspace(span[0], span[1], SCREEN.values)
        counts = [_unstable(model, name, float(value), start) for value in values]
        changes = [
            ((after - before) % 2 != 0, abs(middle - own) / (span[1] - span[0]), float(middle))
            for (before, after), middle in zip(
                pairwise(counts), (values[1:] + values[:-1]) / 2, strict=True
            )
            if before is not None and after is not None and before != after
        ]
        if changes:
            kind, _, place = min(changes)
            if place - span[0] < (span[1] - span[0]) / SCREEN.values:  # what lies before it, too
                bound = model.variable_parameter(name).lower
                lower = max(span[0] - (span[1] - span[0]) / 2, bound)
                span = [_allowed(model, name, lower), span[1]]
            yield kind, own == 0.0, name, span


def _unstable(model: Model, name: str, value: float, near: Array) -> int | None:
    """Return how many eigenvalues of an equilibrium are unstable; None if there is none.

    Shapes: near (n,).
    """
    try:
        there = model.replace(**{name: value})
        state = search_equilibrium(there, near)
        if state is None:
            return None
        found = np.linalg.eigvals(evaluation_of(there).jacobian(there, state))
    except BREAKDOWNS:
        return None
    return int((found.real > SCREEN.positive * np.abs(found).max(initial=0.0)).sum())


def span_about(model: Model, vary: str, width: float = 1.0) -> list[float]:
    """Return a span about the value of a parameter, from above zero if nothing slides there."""
    (low, high), refused = slider_range(model, vary, width), refusal(check_followed, model)
    if refused and model.forced and vary == model.varied_first and low == 0:
        low = SCREEN.moving * model.values[vary]
    elif not refused and refusal(check_followed, model.replace(**{vary: low})):
        low += PAGE.margin * (abs(model.values[vary]) or 1.0)
    return [low, high]


def slider_range(model: Model, name: str, width: float = 1.0) -> tuple[float, float]:
    """Return the ends of a slider: around the value, as far as the model allows."""
    low, high = _around(model.variable_parameter(name), model.values[name], width)
    low, high = _allowed(model, name, low), _allowed(model, name, high)
    period = evaluation_of(model).period
    if model.forced and period(model.replace(**{name: low})) > SCREEN.longest * period(model):
        low = model.values[name] / SCREEN.longest
    return low, high


def _allowed(model: Model, name: str, end: float) -> float:
    """Return an end, or about the last value before it that the model allows."""
    if not refusal(model.replace, **{name: end}):
        return end
    own, allowed, refused = model.values[name], 0.0, 1.0
    for _ in range(SCREEN.halvings):
        share = (allowed + refused) / 2
        if refusal(model.replace, **{name: own + share * (end - own)}):
            refused = share
        else:
            allowed = share
    return float(f"{own + math.floor(allowed / PAGE.margin) * PAGE.margin * (end - own):.12g}")


def _around(item: Parameter, value: float, width: float) -> tuple[float, float]:
    """Ends of a slider: around the value, within the bounds of what is allowed."""
    size = width * (abs(value) or 1.0)
    low, high = (-math.pi, math.pi) if item.unit == "rad" else (value - size, value + size)
    margin = PAGE.margin * min(size, item.upper - item.lower)
    low = max(low, item.lower + margin if item.lower_open else item.lower)
    high = min(high, item.upper - margin if item.upper_open else item.upper)
    return low, high
