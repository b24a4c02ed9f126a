"""What solutions do in the long run: ``slipfold simulate``, ``lyapunov``, ``basins`` and more."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Annotated

from slipfold.cli.reading import (
    GivenModel,
    OutputFiles,
    Reader,
    Values,
    Varied,
    command,
    option,
    parse_assignments,
    parse_window,
    refuse_varied,
    vary_option,
)
from slipfold.cli.running import DONE, FAILED, INTERRUPTED, Outputs, note
from slipfold.errors import InputError
from slipfold.options import (
    BasinPoints,
    Box,
    ExponentPeriods,
    ExponentTolerance,
    Periods,
    Plane,
    Points,
    RegimePoints,
    RegimeTransient,
    Runs,
    SearchPeriods,
    Seed,
    Starts,
    State,
    SteadyTolerance,
    SweepPeriods,
    SweepStarts,
    SweepTransient,
)

if TYPE_CHECKING:
    from slipfold.results.simulation import Simulation

RUNS = {"both": ("up", "down"), "up": ("up",), "down": ("down",), "none": ()}


def _read_window(given: Values, values: Values) -> dict[str, tuple[float, float]]:
    names, spans = parse_window(given["vary"], values["model"], "a map of regimes")
    refuse_varied(parse_assignments(given["set_"]), names)
    return dict(zip(names, spans, strict=True))


WINDOW = option(
    "vary", vary_option("A parameter and its ends; give two. Sweeps go along the second.")
)

Window = Annotated[dict[str, tuple[float, float]], Reader((WINDOW,), _read_window)]


@command
def simulate(
    model: GivenModel,
    outputs: OutputFiles,
    periods: Periods = None,
    state: State = None,
    tolerance: SteadyTolerance = 1e-9,
) -> int:
    """Integrate from rest or a given state; say whether and on what the solution becomes steady.

    Ctrl-C keeps the solution as far as it came. Exit status: 0 done, 2 bad input, 3 the solution
    became singular, 130 interrupted.
    """
    from slipfold.computations.long_term import simulate as compute

    solution = outputs.of(partial(compute, model, periods, state, tolerance=tolerance))
    return _conclude(solution, outputs, "forcing period" if model.forced else "interval")


def _conclude(solution: Simulation, outputs: Outputs, unit: str) -> int:
    if solution.interrupted:
        ended = solution.stopped is not None and solution.stopped.kind == "interrupted"
        where = f"after {solution.periods} {unit}s" if ended else "before all checks were done"
        note(f"interrupted {where}; {outputs.kept}")
        return INTERRUPTED
    if solution.stopped is None:
        return DONE
    note(f"stopped early: {solution.stopped.reason}")
    return FAILED if solution.stopped.kind in ("singular", "stiff") else DONE


@command
def lyapunov(
    model: GivenModel,
    outputs: OutputFiles,
    periods: ExponentPeriods = None,
    state: State = None,
    tolerance: ExponentTolerance = 1e-8,
) -> int:
    """Tell periodic, quasi-periodic and chaotic solutions apart by their Lyapunov exponents.

    Exit status: 0 done, 2 bad input, 130 interrupted; what was known by then is kept.
    """
    from slipfold.computations.long_term import lyapunov as compute

    return outputs.status_of(partial(compute, model, periods, state, tolerance=tolerance))


@command
def attractors(
    model: GivenModel,
    outputs: OutputFiles,
    box: Box = None,
    starts: Starts = 256,
    seed: Seed = 0,
    periods: SearchPeriods = None,
) -> int:
    """Find all responses, cycles, equilibria, tori and chaos that a box of starts leads to.

    Exit status: 0 done, 2 bad input, 130 interrupted; what was found by then is kept.
    """
    from slipfold.computations.long_term import attractors as compute

    result = partial(compute, model, box, starts=starts, seed=seed, periods=periods)
    return outputs.status_of(result)


@command
def basins(
    model: GivenModel,
    outputs: OutputFiles,
    plane: Plane,
    points: BasinPoints = 200,
    state: State = None,
    periods: SearchPeriods = None,
) -> int:
    """Compute which response, cycle, equilibrium, torus or chaos each start leads to.

    Draw the result with slipfold plot. Exit status: 0 done, 2 bad input, 130 interrupted; what was
    found by then is kept.
    """
    from slipfold.computations.long_term import basins as compute

    return outputs.status_of(partial(compute, model, plane, state, points=points, periods=periods))


@command
def basin_fractions(
    model: GivenModel,
    varied: Varied,
    outputs: OutputFiles,
    box: Box = None,
    points: Points = 20,
    starts: Starts = 256,
    seed: Seed = 0,
    periods: SearchPeriods = None,
) -> int:
    """Compute the fraction of starts that each response, torus or chaos attracts over a parameter.

    Draw the result with slipfold plot. Exit status: 0 done, 2 bad input, 130 interrupted; the
    values finished by then are kept.
    """
    from slipfold.computations.long_term import basin_fractions as compute

    result = partial(compute, model, *varied, box, points=points, starts=starts, seed=seed)
    return outputs.status_of(partial(result, periods=periods))


@command
def sweep(
    model: GivenModel,
    varied: Varied,
    outputs: OutputFiles,
    points: Points = 200,
    runs: Runs = "both",
    starts: SweepStarts = 8,
    box: Box = None,
    seed: Seed = 0,
    state: State = None,
    transient: SweepTransient = 500,
    periods: SweepPeriods = 64,
) -> int:
    """Sweep a parameter up and down, and start again at each value; store a state each period.

    Exit status: 0 done, 2 bad input, 130 interrupted; what was finished by then is kept.
    """
    from slipfold.computations.long_term import sweep as compute

    chosen = str(runs)
    if chosen not in RUNS:
        raise InputError(f"--runs {runs} is unknown; give {', '.join(RUNS)}")
    result = partial(compute, model, *varied, points=points, runs=RUNS[chosen], starts=starts)
    given = {"transient": transient, "periods": periods}
    return outputs.status_of(partial(result, box=box, seed=seed, state=state, **given))


@command
def regimes(
    model: GivenModel,
    window: Window,
    outputs: OutputFiles,
    points: RegimePoints = (60, 50),
    transient: RegimeTransient = 400,
    state: State = None,
) -> int:
    """Map where solutions repeat and how soon, where they are tori, chaotic, or stick.

    Exit status: 0 done, 2 bad input, 130 interrupted; what was known by then is kept.
    """
    from slipfold.computations.long_term import regimes as compute

    result = partial(compute, model, window, points=points, state=state, transient=transient)
    return outputs.status_of(result)
