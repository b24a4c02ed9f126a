"""Points of motions over a parameter, in one call."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from time import perf_counter
from typing import TYPE_CHECKING

from slipfold.computations.given import (
    checked_count,
    checked_model,
    refuse_varied,
    spread_values,
    starts_given,
)
from slipfold.errors import InputError
from slipfold.flow.simulate import initial_state
from slipfold.long_term.sweep import DOWN, UP, find_sweep
from slipfold.models.model import Model
from slipfold.progress import Observer
from slipfold.results.records import provenance
from slipfold.results.trajectories import Sweep

if TYPE_CHECKING:
    from numpy.typing import ArrayLike


def sweep(
    model: Model,
    vary: str,
    span: tuple[float | str, float | str],
    *,
    points: int = 200,
    runs: Sequence[str] = (UP, DOWN),
    starts: int = 8,
    box: Mapping[str, tuple[float | str, float | str]] | None = None,
    seed: int = 0,
    state: ArrayLike | Mapping[str, float] | None = None,
    transient: int = 500,
    periods: int = 64,
    observer: Observer | None = None,
    **parameters: float | str,
) -> Sweep:
    """Look at motions at many values of a parameter, once a forcing period.

    In a sweep each value begins with the last state of the one before: up from the model's start,
    then down from where that came to, so that hysteresis shows. From `starts` states of a box
    motions begin anew at each value, all of them side by side. Motions go on through stick and
    slip.

    Parameters
    ----------
    model
        The model, e.g. ``SlidingOscillator()``; it has to be forced.
    vary
        Name of the parameter.
    span
        Its ends: numbers in SI units, or text with a unit.
    points
        Number of values, evenly spread.
    runs
        ``"up"``, ``"down"``, both or none.
    starts
        Motions at each value besides; 0 for none.
    box
        Least and largest value of some states of these starts, by name; others are those of the
        model's start. If None all states, by one and a half times their typical sizes.
    seed
        Of the starts; the same one gives the same starts.
    state
        State from which the first sweep begins, shape (n_states,), or some states by name; what is
        not given is the model's own start.
    transient
        Forcing periods left out at each value.
    periods
        Forcing periods kept after them.
    observer
        Called as motions go on with a `slipfold.Progress`. If it raises `KeyboardInterrupt`,
        or the user does, what was finished by then is returned.
    **parameters
        Parameters of the model to change first: numbers in SI units, or text with a unit.

    Returns
    -------
    Sweep
        The states at phase zero.

    Raises
    ------
    InputError
        If a name or a number cannot be used, or nothing forces the model.

    Examples
    --------
    >>> import slipfold as sf
    >>> found = sf.sweep(sf.SlidingOscillator(), "Nd", (0.05, 0.15), points=5, starts=0, f=12.2)
    >>> found.runs, [found.repeats(run).tolist() for run in found.runs]
    (('up', 'down'), [[1, 1, 1, 1, 2], [1, 2, 2, 2, 2]])
    """
    refuse_varied((vary,), parameters, "span")
    changed = checked_model(model).replace(**parameters)
    if not changed.forced:
        raise InputError(
            f"nothing forces {changed.name}, so there is no phase at which to look at its motions; "
            "use attractors"
        )
    values = spread_values(changed.variable_parameter(vary), span, points)
    unknown = [name for name in runs if name not in (UP, DOWN)]
    if unknown or isinstance(runs, str):
        raise InputError(f"runs = {runs!r} are not of up and down; give e.g. ('up', 'down')")
    wanted = tuple(name for name in (UP, DOWN) if name in runs)
    _, places = starts_given(changed, box, starts, seed, least=0)
    if not wanted and not len(places):
        raise InputError("neither a sweep nor a start is asked for; give runs or starts")
    begun = perf_counter()
    found = find_sweep(
        changed,
        vary,
        values,
        wanted,
        initial_state(changed, state),
        places,
        checked_count(transient, "transient", least=0),
        checked_count(periods, "periods", least=2),
        observer,
    )
    return Sweep(
        model=found.model,
        vary=vary,
        values=values,
        runs=found.runs,
        states=found.states,
        stuck=found.stuck,
        reasons=found.reasons.astype(str),
        transient=int(transient),
        interrupted=found.interrupted,
        provenance=provenance(perf_counter() - begun),
    )
