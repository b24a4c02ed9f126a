"""Basins of attraction on a plane of initial states, in one call."""

from __future__ import annotations

from collections.abc import Mapping
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from slipfold.arrays import Array
from slipfold.computations.given import checked_count, checked_model
from slipfold.errors import InputError
from slipfold.flow.simulate import checked_periods, initial_state
from slipfold.flow.sizes.typical_sizes import measured
from slipfold.long_term.basin_boundaries import find_basins
from slipfold.long_term.box import checked_box
from slipfold.models.model import Model
from slipfold.progress import Observer
from slipfold.results.attractors import PHASE, Basins
from slipfold.results.records import provenance


def basins(
    model: Model,
    plane: Mapping[str, tuple[float | str, float | str]],
    state: ArrayLike | Mapping[str, float] | None = None,
    *,
    points: int | tuple[int, int] = 200,
    periods: int | None = None,
    observer: Observer | None = None,
    **parameters: float | str,
) -> Basins:
    """Tell what motions from a plane of starting states settle on.

    A grid of starts, each labelled with the attractor that its motion comes to. Attractors are
    found and verified on the way, as by `slipfold.attractors`. One axis may be the phase of the
    forcing at which a start is released. Where boundaries are fractal one start does not stand for
    its cell: motions start at the corners of cells, too, and where labels differ again from states
    that are moved by the error of the integration. `Basins.uncertain` marks these cells.

    Parameters
    ----------
    model
        The model, e.g. ``SlidingOscillator()``.
    plane
        Least and largest value of two states at phase zero, by name: numbers in the unit of the
        state, or text with a unit. The first goes to the right. One of them may be ``"phase"``, in
        forcing periods from 0 to 1, at which the states are those of the start.
    state
        The other states of the start: shape (n_states,), or some by name; what is not given is the
        model's start.
    points
        Starts along both states, or along each.
    periods
        Forcing periods, of an autonomous model intervals of its pace, after which a motion that has
        come to nothing known is measured by its exponents; 1024 if None.
    observer
        Called every 16 periods and after each find with a `slipfold.Progress`. If it raises
        `KeyboardInterrupt`, or the user does, what was found by then is returned.
    **parameters
        Parameters of the model to change first: numbers in SI units, or text with a unit.

    Returns
    -------
    Basins
        The grid with its labels, the attractors and their shares.

    Raises
    ------
    InputError
        If the plane, a number or a parameter cannot be used.

    Examples
    --------
    >>> import slipfold as sf
    >>> plane = {"x": (-0.5, 0.5), "y": (-0.5, 0.5)}
    >>> found = sf.basins(sf.SlidingOscillator(), plane, points=(12, 8), f=12.2, Nd=0.1)
    >>> found.labels.shape, sorted(item.period for item in found)
    ((8, 12), [1, 2])
    """
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
    known = [item.name for item in changed.states]
    box = checked_box(changed, {name: plane[name] for name in names if not _is_phase(name, known)})
    ends = [
        _phases(changed, plane[name])
        if _is_phase(name, known)
        else (box.low[known.index(name)], box.high[known.index(name)])
        for name in names
    ]
    counts = points if isinstance(points, tuple) else (points, points)
    if len(counts) != 2:
        raise InputError(f"points = {points!r} are not one or two numbers; give e.g. (300, 200)")
    axes = [
        np.linspace(low, high, checked_count(count, "points", least=2))
        for (low, high), count in zip(ends, counts, strict=True)
    ]

    def starts_at(*coordinates: Array) -> tuple[Array, Array]:
        starts, phases = np.tile(start, (len(coordinates[0]), 1)), np.zeros(len(coordinates[0]))
        for name, values in zip(names, coordinates, strict=True):
            if _is_phase(name, known):
                phases = values
            else:
                starts[:, known.index(name)] = values
        return starts, phases

    most, started = checked_periods(periods), perf_counter()
    found = find_basins(changed, (axes[0], axes[1]), starts_at, most, observer)
    return Basins(
        model=changed,
        plane=(names[0], names[1]),
        first=axes[0],
        second=axes[1],
        state=start,
        labels=found.labels,
        uncertain=found.uncertain,
        attractors=found.attractors,
        ends=found.searched.ends,
        asked=most,
        interrupted=found.interrupted,
        provenance=provenance(perf_counter() - started),
    )


def _is_phase(name: str, states: list[str]) -> bool:
    return name == PHASE.name and name not in states


def _phases(model: Model, given: Any) -> tuple[float, float]:
    if not model.forced:
        raise InputError(f"nothing forces {model.name}, so its starts have no phase; give states")
    try:
        low, high = (float(end) for end in given)
    except (TypeError, ValueError):
        raise InputError(f"the phases {given!r} are not two numbers; give e.g. (0, 1)") from None
    if not 0 <= low < high <= 1:
        raise InputError(
            f"the phases from {low:g} to {high:g} do not grow within 0 to 1; give e.g. (0, 1)"
        )
    return low, high
