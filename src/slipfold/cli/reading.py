"""Texts of the command line, read as models, numbers, intervals and events."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from slipfold.errors import InputError

if TYPE_CHECKING:
    from slipfold.branches.settings import Event
    from slipfold.models.friction.law import FrictionLaw
    from slipfold.models.model import Model

_EVENT = re.compile(r"\s*(?:(\w+)\s*\(\s*(\w+)\s*\)|(\w+))\s*=(.*)", re.DOTALL)

_NUMBER = re.compile(r"\s*[-+]?[\d.]+(?:[eE][-+]?\d+)?\s*")

# -- models ------------------------------------------------------------------------------------


def find_model(given: str, changes: Mapping[str, str], friction: str | None = None) -> Model:
    """Make the model that a command names.

    >>> find_model("sliding", {"alpha": "30deg"}).alpha
    0.5235987755982988
    """
    from slipfold.models.registry import model_named, model_of_file, with_law

    law = None if friction is None else _law_named(friction)
    if given.endswith(".toml"):
        return model_of_file(given, changes, law)
    return model_named(given, **with_law(given, law), **changes)


def _law_named(name: str) -> FrictionLaw:
    """Return the law of a name, with its default values."""
    from slipfold.models.definitions.source import Source
    from slipfold.models.friction.record import friction_laws, read_law

    exact = {law.lower(): law for law in friction_laws()}
    value = exact.get(name.lower(), name)
    return Source({}, "--friction").read(read_law, value, ("--friction",))


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


# -- values ------------------------------------------------------------------------------------


def parse_assignments(texts: Sequence[str] | None, option: str = "--set") -> dict[str, str]:
    """Split every ``NAME=VALUE``.

    >>> parse_assignments(["f=12.5", "alpha=60deg"])
    {'f': '12.5', 'alpha': '60deg'}
    """
    result: dict[str, str] = {}
    for text in texts or ():
        name, equals, value = (part.strip() for part in text.partition("="))
        if not (name and equals and value):
            raise InputError(
                f"{option} {text!r} is not of the form NAME=VALUE; write e.g. {option} f=12.5"
            )
        if name in result:
            raise InputError(
                f"{name} is set twice, to {result[name]} and to {value}; give {option} {name}= once"
            )
        result[name] = value
    return result


def parse_states(texts: Sequence[str] | None, model: Model) -> dict[str, float] | None:
    """Read the starting states that are given; None if none is."""
    from slipfold.models.units import parse_quantity

    units = {item.name: item.unit for item in model.states}
    given = parse_assignments(texts, "--start")
    result = {name: parse_quantity(given[name], units.get(name, ""), name) for name in given}
    return result or None


def parse_box(
    texts: Sequence[str] | None, option: str = "--box"
) -> dict[str, tuple[str, str]] | None:
    """Read intervals of states, ``NAME=LOWER:UPPER``; None if none is given.

    >>> parse_box(["y=-0.5:0.5"])
    {'y': ('-0.5', '0.5')}
    """
    result = {}
    for name, text in parse_assignments(texts, option).items():
        lower, colon, upper = (part.strip() for part in text.partition(":"))
        if not (lower and colon and upper) or ":" in upper:
            raise InputError(
                f"{option} {name}={text} is not of the form NAME=LOWER:UPPER; write e.g. "
                f"{option} {name}=-1:1"
            )
        result[name] = (lower, upper)
    return result or None


def parse_points(text: str, option: str = "--points", minimum: int = 2) -> tuple[int, int]:
    """Read the number of points along both axes, or along each.

    >>> parse_points("200"), parse_points("300x200")
    ((200, 200), (300, 200))
    """
    first, times, second = text.partition("x")
    count = parse_whole(first, option, minimum)
    return count, parse_whole(second, option, minimum) if times else count


def parse_pair(text: str, option: str) -> tuple[str, str]:
    """Read ``FROM:TO``.

    >>> parse_pair("40mN:60mN", "--outside")
    ('40mN', '60mN')
    """
    first, colon, last = text.partition(":")
    if not colon:
        raise InputError(f"{option}={text} has no two ends; give FROM:TO")
    return first, last


def equidistant(span: tuple[float, float], count: int) -> list[float]:
    """Return values spread evenly over a span, in its order.

    >>> equidistant((1.0, 2.0), 3)
    [1.0, 1.5, 2.0]
    """
    first, last = span
    step = (last - first) / max(count - 1, 1)
    return [first + k * step for k in range(count - 1)] + [last]


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
        raise InputError(f"{option} {text} is not a whole number {bounds}; give e.g. {option} 4")
    return value


def parse_span(texts: Sequence[str], model: Model) -> tuple[str, tuple[float, float]]:
    """Read ``NAME=FIRST:LAST``. A unit behind the last value alone goes for both.

    >>> from slipfold.models.sliding_oscillator import SlidingOscillator
    >>> parse_span(["f=11:14Hz"], SlidingOscillator())
    ('f', (11.0, 14.0))
    """
    if len(texts) != 1:
        raise InputError(
            f"--vary is given {len(texts)} times, but a response is followed in one parameter; "
            "give it once"
        )
    return _parse_interval(texts[0], model)


def parse_window(
    texts: Sequence[str], model: Model, what: str = "a locus"
) -> tuple[tuple[str, str], tuple[tuple[float, float], tuple[float, float]]]:
    """Read ``NAME=FIRST:LAST`` twice, for two parameters.

    >>> from slipfold.models.sliding_oscillator import SlidingOscillator
    >>> parse_window(["f=11:14Hz", "Nd=0:0.5"], SlidingOscillator())
    (('f', 'Nd'), ((11.0, 14.0), (0.0, 0.5)))
    """
    if len(texts) != 2:
        times = "once" if len(texts) == 1 else f"{len(texts)} times"
        raise InputError(
            f"--vary is given {times}, but {what} has two parameters; give it twice, e.g. "
            "--vary f=11.5:13.5 --vary Nd=0:0.98"
        )
    (first, one), (second, other) = (_parse_interval(text, model) for text in texts)
    return (first, second), (one, other)


def refuse_varied(given: Mapping[str, str], varied: Sequence[str]) -> None:
    """Raise if a parameter is set although it is varied."""
    for name in varied:
        if name in given:
            raise InputError(
                f"{name} is varied, so it cannot be set to {given[name]} as well; "
                f"leave out --set {name}={given[name]}"
            )


def parse_bounds(texts: Sequence[str], model: Model, option: str) -> dict[str, tuple[float, float]]:
    """Read every ``NAME=LOWER:UPPER``.

    >>> from slipfold.models.sliding_oscillator import SlidingOscillator
    >>> parse_bounds(["mu=0.3:0.7", "L=40:60mm"], SlidingOscillator(), "--fit")
    {'mu': (0.3, 0.7), 'L': (0.04, 0.06)}
    """
    result: dict[str, tuple[float, float]] = {}
    for text in texts:
        name, ends = _parse_interval(text, model, f"{option} mu=0.3:0.7")
        if name in result:
            raise InputError(f"{name} has bounds twice; give {option} {name}= once")
        result[name] = ends
    return result


def _parse_interval(
    text: str, model: Model, example: str = "--vary Nd=0:0.98"
) -> tuple[str, tuple[float, float]]:
    from slipfold.models.units import parse_quantity, units_of

    name, _, values = (part.strip() for part in text.partition("="))
    first, colon, last = (part.strip() for part in values.partition(":"))
    if not (name and first and colon and last) or ":" in last:
        raise InputError(
            f"{example.split()[0]} {text!r} is not of the form NAME=FIRST:LAST; write e.g. "
            f"{example}"
        )
    unit = model.parameter(name).unit
    suffix = _NUMBER.sub("", last, count=1)
    if suffix in units_of(unit) and _NUMBER.fullmatch(first):
        first += suffix
    return name, (parse_quantity(first, unit, name), parse_quantity(last, unit, name))


def parse_event(text: str, model: Model, vary: str, stop: bool = False) -> Event:
    """Read ``NAME=VALUE`` or ``MEASURE(NAME)=VALUE``.

    >>> from slipfold.models.sliding_oscillator import SlidingOscillator
    >>> parse_event("min(Vrel)=200mm/s", SlidingOscillator(), "Nd")
    Event(name='Vrel', value=0.2, measure='min', stop=False)
    """
    from slipfold.branches.settings import Event
    from slipfold.errors import suggest
    from slipfold.models.units import parse_quantity

    match = _EVENT.fullmatch(text)
    if match is None:
        raise InputError(
            f"event {text!r} is not of the form NAME=VALUE or MEASURE(NAME)=VALUE; "
            'write e.g. "min(Vrel)=0.2"'
        )
    measure, name, value = match[1], match[2] or match[3], match[4]
    if name == vary and measure is None:
        unit = model.parameter(vary).unit
        return Event(name, parse_quantity(value, unit, name), "parameter", stop)
    units = {state.name: state.unit for state in model.states}
    units |= {output.name: output.unit for output in model.outputs()}
    if name not in units:
        raise InputError(
            f"{model.name} has no output {name!r}; {suggest(name, [*units, vary])}"
            f"it has {', '.join(units)}"
        )
    return Event(name, parse_quantity(value, units[name], name), measure or "max", stop)
