"""Thresholds over a grid, with uncertain parameters, and by design."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from slipfold import options
from slipfold.arrays import Array
from slipfold.bifurcations.branches.special_point import SpecialPoint, sensitive_to
from slipfold.computations.arguments import (
    checked_forced,
    checked_model,
    checked_point,
    checked_values,
    refuse_varied,
)
from slipfold.declarations import documented
from slipfold.errors import InputError, index_of
from slipfold.flow.flow import flow_of
from slipfold.models.equilibria import check_followed
from slipfold.models.model import Model
from slipfold.models.quantities import Parameter
from slipfold.models.units import interval, parse_quantity
from slipfold.orbits.meshes import INTERVALS
from slipfold.orbits.periodic_orbit import PeriodicOrbit
from slipfold.progress import Observer, Progress
from slipfold.results.records import provenance
from slipfold.text import place_text

if TYPE_CHECKING:
    from slipfold.parameter_space.distributions import Distribution
    from slipfold.parameter_space.optimum import Choice
    from slipfold.results.checks.checked import Checked
    from slipfold.results.checks.curves import Candidate
    from slipfold.results.thresholds import Design, ThresholdMap
    from slipfold.results.uncertainty import ThresholdUncertainty

STARTS = 4
"""Further starts from which the minimum of the level is sought: there may be several minima."""

NO_VIBRATION = "it does not vibrate below its threshold; give a threshold of a forced model"

INTERRUPTED = "interrupted before this was reached"


@documented
def threshold_map(
    model: Model,
    threshold: options.Threshold,
    type: options.ThresholdType = "PD",
    *,
    over: options.Over,
    span: options.Span,
    on_progress: Observer | None = None,
    **parameters: float | str,
) -> ThresholdMap:
    """Compute where the response of period 1 first loses its stability, over a grid of parameters.

    Returns
    -------
    ThresholdMap
        Thresholds, and why some points have none.

    Examples
    --------
    >>> import slipfold as sf
    >>> over = {"Vd": [0.4, 0.6, 1.0], "alpha": ["60deg"]}
    >>> result = sf.threshold_map(sf.SlidingOscillator(), "Nd", over=over, span=(0, "50mN"))
    >>> result.values[:, 0].round(8).tolist(), result.failures
    ([nan, 0.04357891, 0.03429776], {'no PD in the span': 1})
    """
    from slipfold.parameter_space.threshold_map import find_threshold_map
    from slipfold.results.thresholds import ThresholdMap

    changed, grid = _checked_grid(checked_model(model), threshold, over, parameters)
    if type != "PD":
        raise InputError(
            f"type = {type!r} cannot be mapped; give 'PD', or follow the bifurcation as a locus"
        )
    ends, started = interval(changed.variable_parameter(threshold), span), perf_counter()
    measured, arrays = find_threshold_map(changed, threshold, grid, ends, on_progress)
    origin = provenance(perf_counter() - started)
    found = ThresholdMap(measured, threshold, type, grid, ends, **arrays, provenance=origin)
    checked = check_thresholds(found)
    return replace(found, checked=checked, provenance=provenance(perf_counter() - started))


def _checked_grid(
    model: Model, threshold: str, over: Any, parameters: Mapping[str, Any]
) -> tuple[Model, Mapping[str, Array]]:
    """Return the model with its parameters and the values of two others that span a grid."""
    axes = [parameter.name for parameter in model.parameters[:2]]
    example = f"give their values by name, e.g. {{{axes[0]!r}: [...], {axes[-1]!r}: [...]}}"
    if not isinstance(over, Mapping) or len(over) != 2:
        raise InputError(f"over = {over!r} does not name two parameters; {example}")
    if threshold in over:
        raise InputError(
            f"{threshold} is the threshold that is sought, so it cannot span the grid as well; "
            "give another parameter in over"
        )
    refuse_varied((threshold, *over), parameters, "over or in the span")
    changed = model.replace(**parameters)
    check_followed(changed)
    return changed, {name: _axis_values(changed, name, values) for name, values in over.items()}


def _axis_values(model: Model, name: str, values: Any) -> Array:
    checked = checked_values(model.variable_parameter(name), values)
    ordered = np.sort(checked)
    repeated = ordered[1:][np.diff(ordered) == 0]
    if len(repeated):
        raise InputError(f"{name} = {repeated[0]:g} occurs twice in over; give each value once")
    return checked


def check_thresholds(found: ThresholdMap) -> Checked:
    """Check the orbits at some thresholds and that one of their multipliers is -1 there.

    The highest threshold and the lowest come first, then those between. Nothing is checked of an
    interrupted map.
    """
    from slipfold.results.checks.checked import CHECKS, Checked
    from slipfold.results.checks.curves import check_some

    if found.interrupted:
        return Checked((), interrupted=True)
    followed = int(found.followed.sum())
    points = CHECKS.threshold * (found.values.size - followed) + CHECKS.followed * followed
    return check_some(_candidates(found), max(points, CHECKS.map))


def _candidates(found: ThresholdMap) -> Iterator[Candidate]:
    from slipfold.results.checks.curves import Candidate, spread

    known = np.argwhere(np.isfinite(found.values))
    ordered = known[np.argsort(found.values[tuple(known.T)], kind="stable")]
    for place in spread(len(ordered)) if len(ordered) else ():
        first, second = ordered[place].tolist()
        model = found.model_at(first, second)
        names = (found.threshold, *found.axes)
        at = place_text(model, names, [model.values[name] for name in names])
        # The critical multiplier is what it is said to be; the orbit may be one of a mesh.
        flow = flow_of(model)
        start, one_period = found.states[first, second][None], (np.zeros(1), np.ones(1))
        nodes = flow.sample(start, *one_period, INTERVALS, flow.constants_of(model))[0]
        multipliers = found.multipliers[first, second].copy()
        multipliers[np.argmin(np.abs(multipliers + 1))] = -1
        orbit = PeriodicOrbit(model, 1, nodes, multipliers, float(found.residuals[first, second]))
        yield Candidate(f"{found.type} at {at}", orbit, resting=False)


@documented
def uncertainty(
    point: options.Point,
    distributions: options.Distributions,
    *,
    correlation: options.Correlation = None,
    samples: options.Samples = 1024,
    seed: options.Seed = 0,
    loads: options.Loads = (),
    indices: options.Indices = False,
    on_progress: Observer | None = None,
) -> ThresholdUncertainty:
    """Compute the distribution of a threshold of uncertain parameters, by gradients and by samples.

    Each sample is the same special point, located at its own parameter values; another bifurcation
    before it is not searched. Samples where it has vanished or is not found are left out of bands,
    and counted; probabilities have an interval that covers both cases.

    Returns
    -------
    ThresholdUncertainty
        Samples with their thresholds, gradients, bands and probabilities by both ways.

    Raises
    ------
    InputError
        If a distribution or correlation cannot be used, or the point has no gradients or is not
        found again.

    Examples
    --------
    >>> import slipfold as sf
    >>> diagram = sf.response(sf.SlidingOscillator(), vary="Nd", span=(0, 0.05), f=12.5)
    >>> distributions = {"mu": "normal 5%", "Vd": "uniform 1%"}
    >>> result = sf.uncertainty(diagram.special[0], distributions, samples=64)
    >>> [round(end, 4) for end in result.band(0.95, by="gradients")]
    [0.043, 0.0441]
    >>> [round(end, 4) for end in result.band(0.95)]
    [0.0431, 0.0442]
    """
    from slipfold.parameter_space.distributions import parse_correlation
    from slipfold.parameter_space.optimum import ParameterizedPoint
    from slipfold.parameter_space.sampling import (
        INTERRUPTED,
        drawn,
        index_design,
        indices_of,
        thresholds_at,
    )
    from slipfold.results.uncertainty import ThresholdUncertainty

    point = checked_point(point)
    model = point.model
    known = checked_distributions(model, point.vary, distributions)
    parameter = model.parameter(point.vary)
    levels = tuple(_load(value, parameter) for value in loads)
    names = tuple(item.name for item in known)
    matrix = parse_correlation(correlation, names)
    if indices and not np.array_equal(matrix, np.eye(len(known))):
        raise InputError(
            "Sobol indices are of independent parameters; leave out correlation or indices"
        )
    started = perf_counter()
    placed = ParameterizedPoint.at(point, names)
    draws = drawn("sobol", samples, seed, known, correlation=matrix)
    more = index_design(known, samples, seed) if indices else np.empty((0, len(known)))
    total = len(draws) + len(more)

    def send(done: int, failures: int) -> None:
        if on_progress is not None:
            on_progress(Progress("samples", done, total, values={"failures": failures}))

    result, reasons = thresholds_at(placed, np.concatenate([draws, more]), send)
    missing, sobol = _missing(reasons[samples:]), None
    if indices and not missing:
        sobol = indices_of(result[samples:], names, seed)
    return ThresholdUncertainty(
        model=model,
        type=point.type,
        vary=point.vary,
        value=placed.value,
        period=point.period,
        distributions=known,
        gradient=placed.gradient,
        samples=draws,
        thresholds=result[:samples],
        reasons=reasons[:samples],
        seed=seed,
        loads=levels,
        correlation=matrix,
        indices=sobol,
        no_indices=missing,
        interrupted=bool((reasons == INTERRUPTED).any()),
        provenance=provenance(perf_counter() - started),
    )


def _load(value: float | str, parameter: Parameter) -> float:
    load = parse_quantity(value, parameter.unit, parameter.name)
    if not np.isfinite(load):
        raise InputError(f"the load {parameter.name} = {value!r} is not finite; give a number")
    return load


def checked_distributions(
    model: Model, vary: str, distributions: Mapping[str, str | Mapping[str, Any]]
) -> tuple[Distribution, ...]:
    """Read the distributions of parameters of a threshold in another one."""
    from slipfold.parameter_space.distributions import parse_distribution

    if not distributions:
        raise InputError(
            'no parameter is uncertain; give some, e.g. distributions={"mu": "normal 5%"}'
        )
    for name in distributions:
        _checked_name(model, vary, name)
    return tuple(
        parse_distribution(text, model.parameter(name), model.values[name])
        for name, text in distributions.items()
    )


def _checked_name(model: Model, vary: str, name: str) -> None:
    parameter = model.parameter(name)
    if parameter.name not in sensitive_to(model, vary):
        raise InputError(
            f"{name} cannot be uncertain, since the threshold is a value of {vary}; give others"
            if name == vary
            else f"{name} belongs to an orbit and cannot be uncertain; give parameters of the model"
        )


def _missing(reasons: NDArray[np.str_]) -> str:
    """Return why indices are missing: they need the thresholds of all their samples."""
    from slipfold.parameter_space.sampling import INTERRUPTED

    if (reasons == INTERRUPTED).any():
        return "interrupted before all of their samples were reached"
    failed = reasons[reasons != ""]
    if not len(failed):
        return ""
    return f"{len(failed)} of {len(reasons)} samples have no threshold; first: {failed[0]}"


@documented
def design(
    point: options.Point,
    choose: options.Choose,
    *,
    load: options.Load,
    above: options.Above = None,
    outside: options.Outside = None,
    keep: options.Keep = None,
    state: options.DesignState = None,
    on_progress: Observer | None = None,
) -> Design:
    """Choose parameters that minimize the vibration while a threshold meets a bound.

    The vibration is that of the response of period 1 under a load, a value of the parameter that
    was followed: root mean square of a state about its mean. Thresholds and vibration have exact
    derivatives; the search (SLSQP of SciPy) starts from the point's own values and from four other
    points, and the best result counts.

    Returns
    -------
    Design
        Parameters, thresholds and vibration; where there is no design, the reason.

    Examples
    --------
    >>> import slipfold as sf
    >>> diagram = sf.response(sf.SlidingOscillator(), vary="Nd", span=(0, 0.05), f=12.5)
    >>> choose = {"alpha": ("50deg", "70deg"), "Vd": (0.4, 0.8)}
    >>> result = sf.design(diagram.special[0], choose, above="50mN", load="20mN", state="x")
    >>> result.values.round(4).tolist(), result.thresholds.round(4).tolist()
    ([[0.8727, 0.4]], [[0.0816]])
    """
    from slipfold.parameter_space.optimum import (
        Choice,
        ParameterizedOrbit,
        ParameterizedPoint,
        Requirement,
        minimize_level,
    )
    from slipfold.results.thresholds import Design

    point = checked_point(point)
    model, vary = checked_forced(point.model, NO_VIBRATION), point.vary
    bounds = _bounds(point, choose)
    names, parameter = tuple(bounds), model.parameter(vary)
    sides = _demands(parameter, above, outside)
    kept = _kept(point, keep or {})
    at = _number(load, parameter)
    watched = _state(point, state)
    started = perf_counter()
    orbit = ParameterizedOrbit.at(model.replace(**{vary: at}), names)
    placed = ParameterizedPoint.at(point, names)
    stay = [
        Requirement(ParameterizedPoint.at(other, names), "above", bound)
        for other, bound in kept.values()
    ]

    def find(side: str, bound: float, start: Array) -> Choice:
        requirements = [Requirement(placed, side, bound), *stay]
        return minimize_level(orbit, watched, requirements, bounds, start)

    nothing = Choice.none(len(names), 1 + len(kept), INTERRUPTED)
    choices, complete = _searched(find, sides, _starts(model, bounds), nothing, on_progress)
    if outside is not None and complete:
        best = choices.index(_best(choices))
        choices, sides = [choices[best]], [sides[best]]
    confirmed, checked = _confirmed(point, names, choices, at)
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
        lower_bounds=tuple(bound for _, bound in kept.values()),
        sides=tuple(side for side, _ in sides),
        wanted=np.array([bound for _, bound in sides]),
        values=np.array([choice.values for choice in choices]),
        thresholds=np.array([choice.thresholds for choice in choices]),
        levels=np.array([choice.level for choice in choices]),
        reasons=np.array([choice.reason for choice in choices], dtype=np.str_),
        confirmed=confirmed,
        interrupted=not (complete and checked),
        provenance=provenance(perf_counter() - started),
    )


def _bounds(
    point: SpecialPoint, choose: Mapping[str, tuple[options.Number, options.Number]]
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
        bounds[name] = interval(parameter, ends, "range", rising=True)
    return bounds


def _demands(parameter: Parameter, above: Any, outside: Any) -> list[tuple[str, float]]:
    """Return the sides and bounds of the threshold, one search each."""
    if (above is None) == (outside is None):
        raise InputError(
            "give either above (--above), a lower bound of the threshold, or outside (--outside), "
            "an interval that the threshold must leave"
        )
    if outside is not None:
        low, high = interval(parameter, outside, "interval", rising=True)
        return [("above", high), ("below", low)]
    single = isinstance(above, str) or np.ndim(above) == 0
    return [("above", _number(each, parameter)) for each in ([above] if single else above)]


def _kept(
    point: SpecialPoint, keep: Mapping[str, tuple[SpecialPoint | options.HasPoint, options.Number]]
) -> dict[str, tuple[SpecialPoint, float]]:
    result = {}
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
        result[name] = other, _number(least, other.model.parameter(other.vary))
    return result


def _state(point: SpecialPoint, state: str | None) -> int:
    names = [item.name for item in point.model.states]
    return 0 if state is None else index_of(state, names, "state")


def _starts(model: Model, bounds: Mapping[str, tuple[float, float]]) -> list[Array]:
    """Return the starts of searches: the model's own values, and evenly over the bounds."""
    from scipy.stats import qmc

    own = np.array([model.values[name] for name in bounds])
    low, high = np.array(list(bounds.values())).T
    fractions = qmc.Halton(len(low), scramble=False).random(STARTS + 1)[1:]
    return [np.clip(own, low, high), *(low + fractions * (high - low))]


def _searched(
    find: Callable[[str, float, Array], Choice],
    sides: Sequence[tuple[str, float]],
    starts: Sequence[Array],
    nothing: Choice,
    on_progress: Observer | None,
) -> tuple[list[Choice], bool]:
    """Return the best choice for each requirement, and whether all searches are done."""
    choices, total, done = [nothing for _ in sides], len(sides) * len(starts), 0
    try:
        for row, (side, bound) in enumerate(sides):
            tried = []
            for start in starts:
                if on_progress is not None:
                    on_progress(Progress("searches", done, total))
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


def _confirmed(
    point: SpecialPoint, names: tuple[str, ...], choices: Sequence[Choice], load: float
) -> tuple[NDArray[np.bool_], bool]:
    """Return which choices a response confirms, and whether all were examined."""
    from slipfold.parameter_space.optimum import is_confirmed

    confirmed = np.zeros(len(choices), dtype=bool)
    try:
        for row, choice in enumerate(choices):
            if not choice.reason:
                values = dict(zip(names, choice.values.tolist(), strict=True))
                confirmed[row] = is_confirmed(point, values, float(choice.thresholds[0]), load)
    except KeyboardInterrupt:
        return confirmed, False
    return confirmed, True


def _number(given: options.Number, parameter: Parameter) -> float:
    return parse_quantity(given, parameter.unit, parameter.name)
