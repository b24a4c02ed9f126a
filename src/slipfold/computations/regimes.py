"""What motions do over a plane of two parameters, in one call."""

from __future__ import annotations

from collections.abc import Mapping
from time import perf_counter
from typing import TYPE_CHECKING

from slipfold.computations.given import checked_count, checked_model, refuse_varied, spread_values
from slipfold.errors import InputError
from slipfold.flow.simulate import initial_state
from slipfold.long_term.regimes import find_regimes
from slipfold.models.model import Model
from slipfold.progress import Observer
from slipfold.results.records import provenance
from slipfold.results.trajectories import RegimeMap

if TYPE_CHECKING:
    from numpy.typing import ArrayLike


def regimes(
    model: Model,
    vary: Mapping[str, tuple[float | str, float | str]],
    *,
    points: tuple[int, int] = (60, 50),
    state: ArrayLike | Mapping[str, float] | None = None,
    transient: int = 400,
    observer: Observer | None = None,
    **parameters: float | str,
) -> RegimeMap:
    """Say of motions over a plane whether they repeat and how soon, are tori or chaotic, or stick.

    Three motions in each cell of a grid: from the model's start, and swept up and down along the
    second parameter, from the last state of the neighbouring cell. Then every motion is continued
    to the four cells beside it, and from there again, until none of these finds a motion that a
    cell does not have. What does not repeat after the transient is followed for a thousand forcing
    periods, then four thousand, beside a motion close to it, whose distance tells chaos, tori and
    slow ways to a response apart.

    Parameters
    ----------
    model
        The model, e.g. ``SlidingOscillator()``; it has to be forced.
    vary
        Names of two parameters with their first and last value: numbers in SI units, or text with a
        unit.
    points
        Number of values of each.
    state
        State from which motions start, shape (n_states,), or some states by name; what is not given
        is the model's own start.
    transient
        Forcing periods after which it is seen whether a motion repeats.
    observer
        Called after each period of some motions with a `slipfold.Progress`; the total grows
        with motions that do not repeat. If it raises `KeyboardInterrupt`, or the user does, what is
        known by then is returned, other cells ``"not done"``.
    **parameters
        Parameters of the model to change first: numbers in SI units, or text with a unit.

    Returns
    -------
    RegimeMap
        What the motions do.

    Raises
    ------
    InputError
        If a name or a number cannot be used, or nothing forces the model.

    Examples
    --------
    >>> import slipfold as sf
    >>> plane = {"f": (12.2, 13.5), "Nd": (0.02, 0.2)}
    >>> found = sf.regimes(sf.SlidingOscillator(), plane, points=(2, 2))
    >>> found.names("up").tolist()
    [['period 1', 'period 2'], ['period 1', 'period 1']]
    """
    changed = checked_model(model).replace(**parameters)
    wanted = f"vary = {vary!r} does not name two parameters with their spans; give e.g. {_EXAMPLE}"
    if not isinstance(vary, Mapping):
        raise InputError(wanted)
    if len(vary) != 2:
        raise InputError(wanted)
    refuse_varied(vary, parameters, "vary")
    if not changed.forced:
        raise InputError(
            f"nothing forces {changed.name}, so there is no phase at which to look at its motions; "
            "use attractors"
        )
    try:
        first, second = points
    except (TypeError, ValueError):
        raise InputError(f"points = {points!r} are not two numbers; give e.g. (60, 50)") from None
    places = []
    for (name, span), number in zip(vary.items(), (first, second), strict=True):
        places.append(spread_values(changed.variable_parameter(name), span, number))
    one, other = vary
    begun = perf_counter()
    found = find_regimes(
        changed,
        (one, other),
        (places[0], places[1]),
        initial_state(changed, state),
        checked_count(transient, "transient"),
        observer,
    )
    return RegimeMap(
        model=found.model,
        over=dict(zip(vary, places, strict=True)),
        runs=found.runs,
        kinds=found.kinds.astype(str),
        periods=found.periods,
        exponents=found.exponents,
        states=found.states,
        means=found.means,
        transient=int(transient),
        interrupted=found.interrupted,
        provenance=provenance(perf_counter() - begun),
    )


_EXAMPLE = "{'f': (11.5, 13.5), 'Nd': (0, 0.5)}"
