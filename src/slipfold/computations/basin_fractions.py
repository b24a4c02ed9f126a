"""The share of starts that each attractor wins along a parameter, in one call."""

from __future__ import annotations

from collections.abc import Mapping
from time import perf_counter

from slipfold.computations.given import (
    checked_model,
    refuse_varied,
    spread_values,
    starts_given,
)
from slipfold.flow.simulate import checked_periods
from slipfold.flow.sizes.typical_sizes import measured
from slipfold.long_term.basin_fractions import find_fractions
from slipfold.models.model import Model
from slipfold.progress import Observer
from slipfold.results.attractors import BasinFractions
from slipfold.results.records import provenance


def basin_fractions(
    model: Model,
    vary: str,
    span: tuple[float | str, float | str],
    box: Mapping[str, tuple[float | str, float | str]] | None = None,
    *,
    points: int = 20,
    starts: int = 256,
    seed: int = 0,
    periods: int | None = None,
    observer: Observer | None = None,
    **parameters: float | str,
) -> BasinFractions:
    """Tell which share of the starts in a box each attractor wins, along a parameter.

    At each value attractors are found and verified as by `slipfold.attractors`, from the same
    starts, and from the attractors of the value before. One that motions come to from there, and
    that is of the same kind and period, has the same number.

    Parameters
    ----------
    model
        The model, e.g. ``SlidingOscillator()``.
    vary
        Name of the parameter.
    span
        Its ends: numbers in SI units, or text with a unit.
    box
        Least and largest value of some states at phase zero, by name: numbers in the unit of the
        state, or text with a unit; others are those of the model's start. If None all states, by
        one and a half times their typical sizes about the start in the middle of the span.
    points
        Number of values, evenly spread.
    starts
        How many motions at each value.
    seed
        Of the starts; the same one gives the same starts.
    periods
        Forcing periods, of an autonomous model intervals of its pace, after which a motion that
        has come to nothing known is measured by its exponents; 1024 if None.
    observer
        Called every 16 periods and after each find with a `slipfold.Progress` of all values.
        If it raises `KeyboardInterrupt`, or the user does, the values finished by then are
        returned.
    **parameters
        Parameters of the model to change first: numbers in SI units, or text with a unit.

    Returns
    -------
    BasinFractions
        The attractors at each value, and the shares of the starts with their bounds.

    Raises
    ------
    InputError
        If a name, the box or a number cannot be used.

    Examples
    --------
    >>> import slipfold as sf
    >>> duffing, box = sf.built_in_models()["duffing"](), {"q": (-3, 3), "v": (-3, 3)}
    >>> found = sf.basin_fractions(duffing, "W", (1, 1.4), box, points=3, starts=64)
    >>> [len(items) for items in found.attractors]
    [1, 2, 1]
    """
    refuse_varied((vary,), parameters, "span")
    changed = checked_model(model).replace(**parameters)
    values = spread_values(changed.variable_parameter(vary), span, points)
    changed = measured(changed.replace(**{vary: 0.5 * (values[0] + values[-1])}))
    where, places = starts_given(changed, box, starts, seed)
    most = checked_periods(periods)
    begun = perf_counter()
    found = find_fractions(changed, vary, values, places, most, observer)
    return BasinFractions(
        model=changed,
        vary=vary,
        values=values,
        box=where,
        seed=int(seed),
        asked=most,
        starts=places,
        labels=found.labels,
        attractors=found.attractors,
        ends=found.ends,
        interrupted=found.interrupted,
        provenance=provenance(perf_counter() - begun),
    )
