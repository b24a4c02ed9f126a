"""Parameters chosen so that a threshold lies where it is wanted, in one call."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from time import perf_counter
from typing import Any

import numpy as np

from slipfold.arrays import Array
from slipfold.branches.special_point import SpecialPoint, sensitive_to
from slipfold.computations.given import checked_point
from slipfold.design_space.confirmed import is_confirmed
from slipfold.design_space.optimum import Choice, Demand, choose_least
from slipfold.design_space.placed_orbit import PlacedOrbit
from slipfold.design_space.placed_point import PlacedPoint
from slipfold.errors import InputError
from slipfold.models.parameter import Parameter
from slipfold.models.quantity import parse_quantity
from slipfold.models.suggestion import suggest
from slipfold.progress import Observer, Progress
from slipfold.results.diagram import Labelled
from slipfold.results.records import provenance
from slipfold.results.thresholds import Design

Number = float | str

STARTS = 4
"""Places besides the start from which the least level is sought: it may have several minima."""

INTERRUPTED = "interrupted before this was reached"


def design(
    point: SpecialPoint | Labelled,
    choose: Mapping[str, tuple[Number, Number]],
    *,
    load: Number,
    above: Number | Sequence[Number] | None = None,
    outside: tuple[Number, Number] | None = None,
    keep: Mapping[str, tuple[SpecialPoint | Labelled, Number]] | None = None,
    state: str | None = None,
    observer: Observer | None = None,
) -> Design:
    """Choose parameters so that a threshold lies where it is wanted, at the least vibration.

    The vibration is that of the response of period 1 under a load, a value of the parameter that
    was followed: root mean square of a state about its mean. Thresholds and vibration have exact
    derivatives; the search (SLSQP of SciPy) begins at the point's own values and at four other
    places, and the best result counts.

    Parameters
    ----------
    point
        The threshold: a special point of a branch of a forced model, LP, PD, NS, GRAZE or LIFT.
    choose
        Parameters to choose, by name, each with its least and largest value.
    load
        Value of the parameter that was followed at which the vibration is measured.
    above
        What the threshold is to lie above. Of several values a design each: the curve of the least
        vibration over the threshold.
    outside
        A window that the threshold is to leave, on whichever side vibrates less.
    keep
        Further thresholds by a name of yours, each with what it is to stay above.
    state
        The state whose vibration is made small; the first one if None.
    observer
        Called before every search with a `slipfold.Progress`. If it raises
        `KeyboardInterrupt`, or the user does, what is known by then is returned.

    Returns
    -------
    Design
        Parameters, thresholds and vibration; where nothing is found, why.

    Raises
    ------
    InputError
        If the model is not forced, or something given cannot be used.

    Examples
    --------
    >>> import slipfold as sf
    >>> diagram = sf.response(sf.SlidingOscillator(), vary="Nd", span=(0, 0.05), f=12.5)
    >>> choose = {"alpha": ("50deg", "70deg"), "Vd": (0.4, 0.8)}
    >>> found = sf.design(diagram.special[0], choose, above="50mN", load="20mN", state="x")
    >>> found.values.round(4).tolist(), found.thresholds.round(4).tolist()
    ([[0.8727, 0.4]], [[0.0816]])
    """
    point = checked_point(point)
    model, vary = point.model, point.vary
    if not model.forced:
        raise InputError(
            f"{model.name} is not forced, so that it does not vibrate below its threshold; "
            "design is for forced models"
        )
    bounds = _bounds(point, choose)
    names, parameter = tuple(bounds), model.parameter(vary)
    sides = _demands(parameter, above, outside)
    kept = _kept(point, keep or {})
    at = _number(load, parameter)
    watched = _state(point, state)
    started = perf_counter()
    begin = np.array([model.values[name] for name in names])
    orbit = PlacedOrbit.at(model.replace(**{vary: at}), names)
    placed = PlacedPoint.at(point, names)
    stay = [Demand(PlacedPoint.at(other, names), "above", least) for other, least in kept.values()]

    def find(side: str, bound: float, start: Array) -> Choice:
        demands = [Demand(placed, side, bound), *stay]
        return choose_least(orbit, watched, demands, bounds, start)

    nothing = Choice.none(len(names), 1 + len(kept), INTERRUPTED)
    choices, settled = _searched(find, sides, _starts(begin, bounds), nothing, observer)
    if outside is not None and settled:
        least = choices.index(_best(choices))
        choices, sides = [choices[least]], [sides[least]]
    confirmed = np.zeros(len(choices), dtype=bool)
    try:
        for row, choice in enumerate(choices):
            confirmed[row] = _is_confirmed(point, names, choice, at)
    except KeyboardInterrupt:
        settled = False
    return Design(
        model=model,
        type=point.type,
        vary=vary,
        value=placed.value,
        period=point.period,
        names=names,
        bounds=np.array(list(bounds.values())),
        load=at,
        state=model.states[watched].name,
        level=orbit.level(watched)[0],
        kept=tuple(kept),
        least=tuple(least for _, least in kept.values()),
        sides=tuple(side for side, _ in sides),
        wanted=np.array([bound for _, bound in sides]),
        values=np.array([choice.values for choice in choices]),
        thresholds=np.array([choice.thresholds for choice in choices]),
        levels=np.array([choice.level for choice in choices]),
        reasons=np.array([choice.reason for choice in choices], dtype=np.str_),
        confirmed=confirmed,
        interrupted=not settled,
        provenance=provenance(perf_counter() - started),
    )


def _bounds(
    point: SpecialPoint, choose: Mapping[str, tuple[Number, Number]]
) -> dict[str, tuple[float, float]]:
    if not choose:
        raise InputError(
            'there is nothing to choose; give bounds by name, e.g. choose={"Vd": (0.4, 0.8)}'
        )
    bounds, known = {}, sensitive_to(point.model, point.vary)
    for name, ends in choose.items():
        parameter = point.model.parameter(name)
        if name not in known:
            raise InputError(
                f"{name} cannot be chosen, since the threshold is a value of it; give others"
            )
        try:
            least, most = ends
        except (TypeError, ValueError):
            raise InputError(
                f"choose[{name!r}] = {ends!r} is no pair of bounds; give two"
            ) from None
        low, high = (parameter.check(_number(end, parameter)) for end in (least, most))
        if not low < high:
            raise InputError(
                f"{name} is to be from {low:g} to {high:g}; give the least value first"
            )
        bounds[name] = low, high
    return bounds


def _demands(parameter: Parameter, above: Any, outside: Any) -> list[tuple[str, float]]:
    """Return on which sides of what the threshold may be, one search each."""
    if (above is None) == (outside is None):
        raise InputError(
            "give either above (--above), what the threshold is to exceed, or outside (--outside), "
            "a window that it is to leave"
        )
    if outside is not None:
        low, high = (_number(end, parameter) for end in outside)
        return [("above", high), ("below", low)]
    single = isinstance(above, str) or np.ndim(above) == 0
    return [("above", _number(each, parameter)) for each in ([above] if single else above)]


def _kept(
    point: SpecialPoint, keep: Mapping[str, tuple[SpecialPoint | Labelled, Number]]
) -> dict[str, tuple[SpecialPoint, float]]:
    found = {}
    for name, (given, least) in keep.items():
        other = checked_point(given)
        if other.model.kind != point.model.kind:
            raise InputError(
                f"keep[{name!r}] belongs to another model; give a threshold of this one"
            )
        for each, value in other.model.values.items():
            if each not in (point.vary, other.vary) and value != point.model.values[each]:
                raise InputError(
                    f"keep[{name!r}] was found at {each} = {value:g}, the threshold at "
                    f"{point.model.values[each]:g}; give points of one diagram"
                )
        found[name] = other, _number(least, other.model.parameter(other.vary))
    return found


def _state(point: SpecialPoint, state: str | None) -> int:
    names = [item.name for item in point.model.states]
    if state is None:
        return 0
    if state not in names:
        raise InputError(f"no state {state!r}; {suggest(state, names)}there are {', '.join(names)}")
    return names.index(state)


def _starts(begin: Array, bounds: Mapping[str, tuple[float, float]]) -> list[Array]:
    """Return where searches begin: at the point's own values, and evenly over the bounds."""
    from scipy.stats import qmc

    low, high = np.array(list(bounds.values())).T
    shares = qmc.Halton(len(low), scramble=False).random(STARTS + 1)[1:]
    return [np.clip(begin, low, high), *(low + shares * (high - low))]


def _searched(
    find: Callable[[str, float, Array], Choice],
    sides: Sequence[tuple[str, float]],
    starts: Sequence[Array],
    nothing: Choice,
    observer: Observer | None,
) -> tuple[list[Choice], bool]:
    """Return the best choice for each side of what is wanted, and whether all searches are done."""
    choices, total, done = [nothing for _ in sides], len(sides) * len(starts), 0
    try:
        for row, (side, bound) in enumerate(sides):
            tried = []
            for start in starts:
                if observer is not None:
                    observer(Progress("searches", done, total))
                tried.append(find(side, bound, start))
                done += 1
                best = _best(tried)
                if not best.reason or len(tried) == len(starts):
                    choices[row] = best
    except KeyboardInterrupt:
        pass
    return choices, done == total


def _best(tried: Sequence[Choice]) -> Choice:
    good = [choice for choice in tried if not choice.reason]
    return min(good, key=lambda choice: choice.level) if good else tried[0]


def _is_confirmed(point: SpecialPoint, names: tuple[str, ...], choice: Choice, load: float) -> bool:
    if choice.reason:
        return False
    values = dict(zip(names, choice.values.tolist(), strict=True))
    return is_confirmed(point, values, float(choice.thresholds[0]), load)


def _number(given: Number, parameter: Parameter) -> float:
    return parse_quantity(given, parameter.unit, parameter.name)
