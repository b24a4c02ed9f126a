"""Texts of the command line, read as models, numbers, intervals and events."""

from __future__ import annotations

import math
import re
import sys
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from slipfold.errors import InputError

if TYPE_CHECKING:
    from slipfold.bifurcations.branches.settings import Event
    from slipfold.models.model import Model

R = TypeVar("R")

_EVENT = re.compile(r"\s*(?:(\w+)\s*\(\s*(\w+)\s*\)|(\w+))\s*(?:=(.*))?", re.DOTALL)

_NUMBER = re.compile(r"\s*[-+]?[\d.]+(?:[eE][-+]?\d+)?\s*(.*)")

Texts = Sequence[str] | None
"""Values of an option that may be repeated; None if it is not given."""


def find_model(given: str, changes: Mapping[str, str], friction: str | None = None) -> Model:
    """Make the model that a command names.

    >>> find_model("sliding", {"alpha": "30deg"}).alpha
    0.5235987755982988
    """
    from slipfold.models.definitions.source import Source
    from slipfold.models.friction.record import friction_laws, read_law
    from slipfold.models.registry import model_named, model_of_file, with_law

    law = None
    if friction is not None:
        exact = {law.lower(): law for law in friction_laws()}
        value = exact.get(friction.lower(), friction)
        law = Source({}, "--friction").read(read_law, value, ("--friction",))
    if given.endswith(".toml"):
        model = model_of_file(given, changes, law)
        for note in model.notes:
            print(f"slipfold: {given}: {note}", file=sys.stderr)
        return model
    return model_named(given, **with_law(given, law), **changes)


def make_model(given: str, changes: Mapping[str, str], friction: str | None) -> Model:
    """Make the model that a command computes with, and print how wrong its reduction is."""
    model = find_model(given, changes, friction)
    if report := getattr(model, "reduction_report", None):
        print(f"slipfold: {given}: {', '.join(str(report).splitlines()[:2])}", file=sys.stderr)
    return model


def load_result(path: str, kind: type[R], advice: str) -> R:
    """Read a saved result of a kind, or say what else to give."""
    from slipfold.results.result import load

    result = load(path)
    if not isinstance(result, kind):
        raise InputError(f"{path} holds a {type(result).__name__}, {advice}")
    return result


def equations_file(given: str) -> Path | None:
    """Return the file that holds the equations of a model that a command names."""
    from slipfold.models.definitions.source import source_of_file
    from slipfold.models.registry import CASE_FILE

    if not given.endswith(".toml"):
        return None
    tables = source_of_file(Path(given), CASE_FILE).tables
    if "model" not in tables:
        return Path(given).absolute()
    name = tables["model"]
    return (Path(given).parent / name).absolute() if name.endswith(".toml") else None


def parse_assignments(
    texts: Texts, option: str = "--set", form: str = "NAME=VALUE", example: str = "f=12.5"
) -> dict[str, str]:
    """Split every ``NAME=VALUE``.

    >>> parse_assignments(["f=12.5", "alpha=60deg"])
    {'f': '12.5', 'alpha': '60deg'}
    """
    result: dict[str, str] = {}
    for text in texts or ():
        name, equals, value = (part.strip() for part in text.partition("="))
        if not (name and equals and value):
            raise InputError(
                f"{option} {text!r} is not of the form {form}; write e.g. {option} {example}"
            )
        if name in result:
            raise InputError(
                f"{option} gives {name} twice, {result[name]} and {value}; give it once"
            )
        result[name] = value
    return result


def parse_intervals(texts: Texts, option: str) -> dict[str, tuple[str, str]]:
    """Split every ``NAME=FIRST:LAST``.

    >>> parse_intervals(["f=11:14Hz", "Nd=0:0.5"], "--vary")
    {'f': ('11Hz', '14Hz'), 'Nd': ('0', '0.5')}
    """
    form, example = "NAME=FIRST:LAST", "Nd=0:0.98"
    return {
        name: parse_pair(text, option, f"'{name}={text}'", form, example)
        for name, text in parse_assignments(texts, option, form, example).items()
    }


def parse_points(text: str, option: str = "--points", minimum: int = 2) -> tuple[int, int]:
    """Read the number of points along both axes, or along each.

    >>> parse_points("200"), parse_points("300x200")
    ((200, 200), (300, 200))
    """
    first, times, second = text.partition("x")
    count = parse_whole(first, option, minimum)
    return count, parse_whole(second, option, minimum) if times else count


def parse_pair(
    text: str, option: str, given: str = "", form: str = "FROM:TO", example: str = "1:2"
) -> tuple[str, str]:
    """Split ``FROM:TO``. A unit behind one of the values is that of both.

    >>> parse_pair("40:60mN", "--outside"), parse_pair("900rpm:2000", "--outside")
    (('40mN', '60mN'), ('900rpm', '2000rpm'))
    >>> parse_pair("0.9:pi/3", "--outside"), parse_pair("sqrt(2):3", "--outside")
    (('0.9', 'pi/3'), ('sqrt(2)', '3'))
    """
    ends = [part.strip() for part in text.split(":")]
    if len(ends) != 2 or not all(ends):
        raise InputError(
            f"{option} {given or text} is not of the form {form}; write e.g. {option} {example}"
        )
    units = [match and match[1] for match in map(_NUMBER.fullmatch, ends)]
    for unit, other in zip(units, (1, 0), strict=True):
        if unit and (unit[0].isalpha() or unit in "°%") and units[other] == "":
            ends[other] += unit
    return ends[0], ends[1]


def parse_number(text: str, option: str) -> float:
    """Read a finite number."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise InputError(f"{option} {text} is not a finite number; give e.g. {option} 0.01")
    return value


def parse_whole(text: str, option: str, minimum: int = 1, maximum: int | None = None) -> int:
    """Read a whole number of at least 1, or within other bounds.

    >>> parse_whole("2000", "--periods")
    2000
    """
    try:
        value = int(text)
    except ValueError:
        value = minimum - 1
    if value < minimum or (maximum is not None and value > maximum):
        bounds = f"of at least {minimum}" if maximum is None else f"from {minimum} to {maximum}"
        raise InputError(f"{option} {text} is not a whole number {bounds}; give one")
    return value


def parse_event(text: str, model: Model, varied: Collection[str], stop: bool = False) -> Event:
    """Read ``NAME=VALUE`` or ``MEASURE(NAME)=VALUE``, or the same without a value.

    >>> from slipfold.models.sliding_oscillator import SlidingOscillator
    >>> parse_event("min(Vrel)=200mm/s", SlidingOscillator(), ["Nd"])
    Event(name='Vrel', value=0.2, measure='min', stop=False)
    """
    from slipfold.bifurcations.branches.settings import Event
    from slipfold.models.levels import quantity_of
    from slipfold.models.units import parse_quantity

    match = _EVENT.fullmatch(text)
    if match is None:
        raise InputError(
            f"event {text!r} is not of the form NAME=VALUE or MEASURE(NAME)=VALUE; "
            'write e.g. "min(Vrel)=0.2", or "max(x)" for where that has an extremum'
        )
    measure, name, value = match[1], match[2] or match[3], match[4]
    of_parameter = name in varied
    if of_parameter and measure:
        raise InputError(
            f"event {text!r} is a {measure} of {name}, which is varied and has one value; write "
            f"{name}={value or 'VALUE'}"
        )
    unit = (model.parameter(name) if of_parameter else quantity_of(model, name, varied)).unit
    wanted = None if value is None else parse_quantity(value, unit, name)
    return Event(name, wanted, measure or ("parameter" if of_parameter else "max"), stop)
