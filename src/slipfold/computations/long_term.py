"""What solutions do in the long run: simulations, exponents, attractors, basins, sweeps, regimes.

Each function imports what it computes with: a command imports nothing of the others.
"""

from __future__ import annotations

from collections.abc import Mapping
from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np

from slipfold import options
from slipfold.arrays import Array
from slipfold.computations.arguments import (
    checked_forced,
    checked_model,
    equidistant,
    refuse_varied,
)
from slipfold.declarations import documented
from slipfold.errors import InputError
from slipfold.flow.scales import measured
from slipfold.flow.simulate import initial_state
from slipfold.models.model import Model
from slipfold.models.quantities import DURATION, Parameter
from slipfold.models.units import interval
from slipfold.progress import Observer, Progress
from slipfold.results.records import provenance

if TYPE_CHECKING:
    from slipfold.flow.trajectory import Trajectory
    from slipfold.long_term.search import Box
    from slipfold.results.attractors import Attractors, BasinFractions, Basins
    from slipfold.results.checks.checked import Checked
    from slipfold.results.simulation import Simulation
    from slipfold.results.trajectories import LyapunovExponents, RegimeMap, Sweep


@documented
def simulate(
    model: Model,
    periods: options.Periods = None,
    state: options.State = None,
    *,
    tolerance: options.SteadyTolerance = 1e-9,
    on_progress: Observer | None = None,
    **parameters: float | str,
) -> Simulation:
    """Integrate a model, and report the steady state if the solution reaches one.

    Returns
    -------
    Simulation
        Ends early, with the reason, where the model meets one of its limits.

    Examples
    --------
    >>> import slipfold as sf
    >>> result = sf.simulate(sf.SlidingOscillator(), periods=1000, f=12.2, Nd=0.15)
    >>> result.settlement.period, round(result.spectrum().line("x", 0.5), 6)
    (2, 0.276327)
    >>> cycle = sf.simulate(sf.built_in_models()["vanderpol-free"]()).settlement
    >>> cycle.kind, round(cycle.duration, 6)
    ('cycle', 6.663287)
    """
    from slipfold.flow.simulate import simulate
    from slipfold.results.simulation import Simulation

    changed = checked_model(model).replace(**parameters)
    started = perf_counter()
    watch = on_progress or (lambda progress: None)  # so that an interrupted solution is stored
    result = simulate(changed, periods, state, tolerance=tolerance, observer=watch)
    return Simulation(
        model=result.model,
        states=result.states,
        settlement=result.settlement,
        stopped=result.stopped,
        sticking=result.sticking,
        requested=result.periods if periods is None else periods,
        tolerance=tolerance,
        provenance=provenance(perf_counter() - started),
        checked=_checked(result, watch),
    )


def _checked(trajectory: Trajectory, on_progress: Observer) -> Checked:
    """Check a solution, unless it was interrupted."""
    from slipfold.results.checks.checked import Checked
    from slipfold.results.checks.trajectories import check_trajectory

    if trajectory.stopped is not None and trajectory.stopped.kind == "interrupted":
        return Checked((), interrupted=True)
    try:
        on_progress(Progress("checks", 0))
    except KeyboardInterrupt:
        return Checked((), interrupted=True)
    return check_trajectory(trajectory)


@documented
def lyapunov(
    model: Model,
    periods: options.ExponentPeriods = None,
    state: options.State = None,
    *,
    tolerance: options.ExponentTolerance = 1e-8,
    on_progress: Observer | None = None,
    **parameters: float | str,
) -> LyapunovExponents:
    """Compute all Lyapunov exponents of a solution, and use them to distinguish a torus from chaos.

    Orthogonal perturbations are propagated with the exact derivatives of the flow, also across
    sticking phases. The exponents are averaged over the second half of the solution with smooth
    weights: along periodic and quasi-periodic solutions errors fall faster than any power of its
    length, along chaotic ones with the square root. An interruption keeps what is known once 250
    periods are done.

    Returns
    -------
    LyapunovExponents
        The exponents with their errors, and the kind of solution.

    Raises
    ------
    InputError
        If a parameter, `periods`, `state` or `tolerance` cannot be used, or the solution ends at a
        limit of the model.

    Examples
    --------
    >>> import slipfold as sf
    >>> result = sf.lyapunov(sf.SlidingOscillator(), 2000, f=12.5, Nd=0.06)
    >>> result.classification.kind, result.exponents[1:].round(4).tolist()
    ('torus', [-0.005, -0.1171, -0.2698])
    """
    from slipfold.long_term.exponents import ExponentEstimate, find_exponents
    from slipfold.results.trajectories import LyapunovExponents

    changed = checked_model(model).replace(**parameters)
    start = initial_state(changed, state)
    started = perf_counter()
    result = find_exponents(changed, start, periods, tolerance, on_progress)
    unit = 1.0 if changed.forced else float(result.model.values[DURATION.name])
    return LyapunovExponents(
        model=result.model,
        estimates=tuple(
            ExponentEstimate(each.periods, each.exponents / unit, each.errors / unit)
            for each in result.estimates
        ),
        classification=result.classification,
        start=start,
        state=result.state,
        tolerance=tolerance,
        requested=periods,
        interrupted=result.interrupted,
        provenance=provenance(perf_counter() - started),
    )


@documented
def attractors(
    model: Model,
    box: options.Box = None,
    *,
    starts: options.Starts = 256,
    seed: options.Seed = 0,
    periods: options.SearchPeriods = None,
    on_progress: Observer | None = None,
    **parameters: float | str,
) -> Attractors:
    """Find the attractors that solutions from a box of starting states converge to.

    Starts are spread evenly over the box. A solution that nearly repeats is corrected by Newton's
    method; the orbit is an attractor if its multipliers, or eigenvalues, lie inside. What never
    repeats is classified by its Lyapunov exponents. A solution ends where it is so close to a known
    attractor that it is taken to converge; of those that repeat, all of 24 solutions tried from
    that distance came closer. Every attractor is verified: solutions that ended at a limit of the
    model and undecided ones are counted separately.

    Returns
    -------
    Attractors
        The attractors, and how many starts converge to each.

    Examples
    --------
    >>> import slipfold as sf
    >>> box = {"x": (-0.5, 0.5), "y": (-0.5, 0.5), "vx": (-20, 20), "vy": (-20, 20)}
    >>> result = sf.attractors(sf.SlidingOscillator(), box, starts=32, f=12.2, Nd=0.1)
    >>> sorted((item.kind, item.period) for item in result)
    [('periodic', 1), ('periodic', 2)]
    """
    from slipfold.long_term.search import search
    from slipfold.results.attractors import Attractors

    changed = measured(checked_model(model).replace(**parameters))
    where, states = _starts_in(changed, box, starts, seed)
    started = perf_counter()
    result = search(changed, states, periods, on_progress)
    return Attractors(
        model=changed,
        box=where,
        seed=seed,
        requested=periods,
        starts=states,
        labels=result.labels,
        attractors=result.attractors,
        ends=result.ends,
        interrupted=result.interrupted,
        provenance=provenance(perf_counter() - started),
    )


@documented
def basin_fractions(
    model: Model,
    vary: options.Vary,
    span: options.Span,
    box: options.Box = None,
    *,
    points: options.Points = 20,
    starts: options.Starts = 256,
    seed: options.Seed = 0,
    periods: options.SearchPeriods = None,
    on_progress: Observer | None = None,
    **parameters: float | str,
) -> BasinFractions:
    """Compute the fraction of starts that each attractor attracts, along a parameter.

    At each value attractors are found and verified as by `slipfold.attractors`, from the same
    starts, and from the attractors of the value before. An attractor that solutions converge to
    from there, and that is of the same kind and period, has the same number.

    Returns
    -------
    BasinFractions
        The attractors at each value, and the fractions of the starts with their bounds.

    Examples
    --------
    >>> import slipfold as sf
    >>> duffing, box = sf.built_in_models()["duffing"](), {"q": (-3, 3), "v": (-3, 3)}
    >>> result = sf.basin_fractions(duffing, "W", (1, 1.4), box, points=3, starts=64)
    >>> result.numbers, [len(items) for items in result.attractors]
    ((1, 2), [1, 2, 1])
    """
    from slipfold.long_term.search import find_fractions
    from slipfold.results.attractors import BasinFractions

    refuse_varied((vary,), parameters, "span")
    changed = checked_model(model).replace(**parameters)
    values = equidistant(changed.variable_parameter(vary), span, points)
    changed = measured(changed.replace(**{vary: 0.5 * (values[0] + values[-1])}))
    where, states = _starts_in(changed, box, starts, seed)
    started = perf_counter()
    result = find_fractions(changed, vary, values, states, periods, on_progress)
    return BasinFractions(
        model=changed,
        vary=vary,
        values=values,
        box=where,
        seed=seed,
        requested=periods,
        starts=states,
        provenance=provenance(perf_counter() - started),
        **vars(result),
    )


@documented
def basins(
    model: Model,
    plane: options.Plane,
    state: options.State = None,
    *,
    points: options.BasinPoints = 200,
    periods: options.SearchPeriods = None,
    on_progress: Observer | None = None,
    **parameters: float | str,
) -> Basins:
    """Compute which attractor each start on a plane of states leads to.

    Attractors are found and verified as by `slipfold.attractors`. One axis may be the phase of the
    forcing at which a start is released. Where boundaries are fractal one start does not represent
    its cell: solutions also start at the corners of cells, and where labels differ again from
    states moved by the error of the integration. `Basins.uncertain` marks these cells.

    Returns
    -------
    Basins
        The grid with its labels, the attractors and their fractions.

    Examples
    --------
    >>> import slipfold as sf
    >>> plane = {"x": (-0.5, 0.5), "y": (-0.5, 0.5)}
    >>> result = sf.basins(sf.SlidingOscillator(), plane, points=(12, 8), f=12.2, Nd=0.1)
    >>> result.labels.shape, sorted(item.period for item in result)
    ((8, 12), [1, 2])
    """
    from slipfold.long_term.search import find_basins
    from slipfold.results.attractors import Basins

    changed = measured(checked_model(model).replace(**parameters))
    start = initial_state(changed, state)
    given: Any = plane
    names = tuple(given) if isinstance(given, Mapping) else ()
    if len(names) != 2:
        own = f"it has {', '.join(names)}" if names else "it has none"
        raise InputError(
            f"the plane does not name two states: {own}; give two, each with its ends (on the "
            "command line --plane twice)"
        )
    assert isinstance(points, tuple)  # one number is taken for both axes
    axes = _axes(changed, plane, points)
    known = [item.name for item in changed.states]

    def starts_at(*coordinates: Array) -> tuple[Array, Array]:
        starts, phases = np.tile(start, (len(coordinates[0]), 1)), np.zeros(len(coordinates[0]))
        for name, values in zip(names, coordinates, strict=True):
            if name in known:
                starts[:, known.index(name)] = values
            else:
                phases = values
        return starts, phases

    started = perf_counter()
    result, uncertain = find_basins(changed, (axes[0], axes[1]), starts_at, periods, on_progress)
    return Basins(
        model=changed,
        plane=(names[0], names[1]),
        first=axes[0],
        second=axes[1],
        state=start,
        labels=result.labels,
        uncertain=uncertain,
        attractors=result.attractors,
        ends=result.ends,
        requested=periods,
        interrupted=result.interrupted,
        provenance=provenance(perf_counter() - started),
    )


def _starts_in(model: Model, box: Any, starts: int, seed: int) -> tuple[Box, Array]:
    """Return a box, that around the model's start if none is given, and starts in it, or raise.

    Shapes: returns the box and (n_starts, n_states).
    """
    from slipfold.long_term.search import box_around, checked_box

    where = box_around(model) if box is None else checked_box(model, box)
    return where, where.starts(starts, seed) if starts else np.empty((0, len(model.states)))


def _axes(model: Model, plane: Mapping[str, Any], points: tuple[int, int]) -> list[Array]:
    """Return the coordinates of starts along both axes; one axis may be the phase."""
    from slipfold.long_term.search import checked_box
    from slipfold.results.attractors import PHASE

    known = [item.name for item in model.states]
    phase = PHASE.name if PHASE.name in plane and PHASE.name not in known else None
    box = checked_box(model, {name: ends for name, ends in plane.items() if name != phase})
    axes = []
    for (name, ends), count in zip(plane.items(), points, strict=True):
        if name == phase:
            checked_forced(model, "its starts have no phase; give states")
            low, high = interval(Parameter(name, 0.0, "", PHASE.doc, 0, 1), ends, rising=True)
        else:
            low, high = box.low[known.index(name)], box.high[known.index(name)]
        axes.append(np.linspace(low, high, count))
    return axes


@documented
def sweep(
    model: Model,
    vary: options.Vary,
    span: options.Span,
    *,
    points: options.Points = 200,
    runs: options.Runs = ("up", "down"),
    starts: options.SweepStarts = 8,
    box: options.Box = None,
    seed: options.Seed = 0,
    state: options.State = None,
    transient: options.SweepTransient = 500,
    periods: options.SweepPeriods = 64,
    on_progress: Observer | None = None,
    **parameters: float | str,
) -> Sweep:
    """Sample solutions at many values of a parameter, once a forcing period.

    In a sweep each value starts from the last state of the one before: up from the starting state,
    then down from the state reached there, so that hysteresis shows. In addition solutions start
    again at each value from states of a box.

    Returns
    -------
    Sweep
        The states at phase zero.

    Examples
    --------
    >>> import slipfold as sf
    >>> result = sf.sweep(sf.SlidingOscillator(), "Nd", (0.05, 0.15), points=5, starts=0, f=12.2)
    >>> result.runs, [result.repeats(run).tolist() for run in result.runs]
    (('up', 'down'), [[1, 1, 1, 1, 2], [1, 2, 2, 2, 2]])
    """
    from slipfold.long_term.sweep import DOWN, UP, SweepRun
    from slipfold.results.trajectories import Sweep

    refuse_varied((vary,), parameters, "span")
    changed = checked_forced(checked_model(model).replace(**parameters))
    values = equidistant(changed.variable_parameter(vary), span, points)
    if isinstance(runs, str) or not {UP, DOWN}.issuperset(runs):
        raise InputError(f"runs = {runs!r} are not of up and down; give e.g. ('up', 'down')")
    directions = tuple(name for name in (UP, DOWN) if name in runs)
    at = changed.replace(**{vary: float(values[len(values) // 2])})
    _, states = _starts_in(measured(at) if starts and box is None else at, box, starts, seed)
    if not directions and not len(states):
        raise InputError("neither a sweep nor a start is requested; give runs or starts")
    started = perf_counter()
    work = SweepRun(
        changed,
        vary,
        values,
        directions,
        initial_state(changed, state),
        states,
        transient,
        periods,
        on_progress,
    )
    interrupted = work.run()
    return Sweep(
        model=work.model,
        vary=vary,
        values=values,
        runs=work.names,
        states=work.states,
        stuck=work.stuck,
        reasons=work.reasons.astype(str),
        transient=transient,
        interrupted=interrupted,
        provenance=provenance(perf_counter() - started),
    )


@documented
def regimes(
    model: Model,
    vary: options.ParameterPlane,
    *,
    points: options.RegimePoints = (60, 50),
    state: options.State = None,
    transient: options.RegimeTransient = 400,
    on_progress: Observer | None = None,
    **parameters: float | str,
) -> RegimeMap:
    """Map where solutions repeat and how soon, are tori or chaotic, and where they stick.

    Three solutions in each cell of a grid: from the starting state, and swept up and down along the
    second parameter, from the last state of the neighboring cell. Then every solution is continued
    into the four neighboring cells, and from there again, until no cell gains a solution that it
    does not have. What does not repeat after the transient is followed for a thousand forcing
    periods, then four thousand, together with a solution close to it, whose distance distinguishes
    chaos, tori and slow convergence. After an interruption other cells are ``"not done"``.

    Returns
    -------
    RegimeMap
        The kinds and periods of the solutions.

    Examples
    --------
    >>> import slipfold as sf
    >>> plane = {"f": (12.2, 13.5), "Nd": (0.02, 0.2)}
    >>> result = sf.regimes(sf.SlidingOscillator(), plane, points=(2, 2))
    >>> result.names("up").tolist(), result.at(f=12.2, Nd=0.2)["rest"]
    ([['period 1', 'period 2'], ['period 1', 'period 1']], 'period 2')
    """
    from slipfold.long_term.regimes import RUNS, find_regimes
    from slipfold.results.trajectories import RegimeMap

    changed = checked_model(model).replace(**parameters)
    given: Any = vary
    if not isinstance(given, Mapping) or len(given) != 2:
        raise InputError(
            f"vary = {given!r} does not name two parameters with their spans; give e.g. "
            "{'f': (11.5, 13.5), 'Nd': (0, 0.5)}"
        )
    refuse_varied(vary, parameters, "vary")
    checked_forced(changed)
    over = {
        name: equidistant(changed.variable_parameter(name), span, count)
        for (name, span), count in zip(vary.items(), points, strict=True)
    }
    started = perf_counter()
    work, interrupted = find_regimes(
        changed, over, initial_state(changed, state), transient, on_progress
    )
    known = work.known
    further = range(1, len(known.kinds) - len(RUNS) + 1)
    shape = len(known.kinds), *map(len, over.values())
    return RegimeMap(
        model=work.model,
        over=over,
        runs=(*RUNS, *(f"continued {number}" for number in further)),
        kinds=work.reported_kinds.reshape(shape),
        periods=known.periods.reshape(shape),
        exponents=known.exponents.reshape(shape),
        states=known.states.reshape(*shape, -1),
        means=known.means.reshape(*shape, -1),
        transient=transient,
        interrupted=interrupted,
        provenance=provenance(perf_counter() - started),
    )
