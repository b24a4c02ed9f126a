"""All attractors from a box of starts, in one call."""

from __future__ import annotations

from collections.abc import Mapping
from time import perf_counter

from slipfold.computations.given import checked_model, starts_given
from slipfold.flow.simulate import checked_periods
from slipfold.flow.sizes.typical_sizes import measured
from slipfold.long_term.search import search
from slipfold.models.model import Model
from slipfold.progress import Observer
from slipfold.results.attractors import Attractors
from slipfold.results.records import provenance


def attractors(
    model: Model,
    box: Mapping[str, tuple[float | str, float | str]] | None = None,
    *,
    starts: int = 256,
    seed: int = 0,
    periods: int | None = None,
    observer: Observer | None = None,
    **parameters: float | str,
) -> Attractors:
    """Find everything that motions from a box of starting states settle on.

    Starts are spread evenly over the box. What a motion nearly repeats on is corrected by Newton's
    method and taken if its multipliers, or eigenvalues, lie inside; what never repeats is told by
    its Lyapunov exponents. A motion ends as soon as it comes so near to something known that it
    is taken to stay there; of what repeats, all of 24 motions tried from that distance came nearer.
    None is taken for an attractor that was not verified: motions that ended at a limit of the model
    and those that are undecided are counted.

    Parameters
    ----------
    model
        The model, e.g. ``SlidingOscillator()``.
    box
        Least and largest value of some states at phase zero, by name: numbers in the unit of the
        state, or text with a unit; others are those of the model's start. If None all states, by
        one and a half times their typical sizes about the start.
    starts
        How many motions.
    seed
        Of the starts; the same one gives the same starts.
    periods
        Forcing periods, of an autonomous model intervals of its pace, after which a motion that
        has come to nothing known is measured by its exponents; 1024 if None.
    observer
        Called every 16 periods and after each find with a `slipfold.Progress`. If it raises
        `KeyboardInterrupt`, or the user does, what was found by then is returned.
    **parameters
        Parameters of the model to change first: numbers in SI units, or text with a unit.

    Returns
    -------
    Attractors
        What was found, and how many starts came to each.

    Raises
    ------
    InputError
        If the box, a number or a parameter cannot be used.

    Examples
    --------
    >>> import slipfold as sf
    >>> box = {"x": (-0.5, 0.5), "y": (-0.5, 0.5), "vx": (-20, 20), "vy": (-20, 20)}
    >>> found = sf.attractors(sf.SlidingOscillator(), box, starts=32, f=12.2, Nd=0.1)
    >>> sorted((item.kind, item.period) for item in found)
    [('periodic', 1), ('periodic', 2)]
    """
    changed = measured(checked_model(model).replace(**parameters))
    where, places = starts_given(changed, box, starts, seed)
    most = checked_periods(periods)
    started = perf_counter()
    found = search(changed, places, most, observer)
    return Attractors(
        model=changed,
        box=where,
        seed=int(seed),
        asked=most,
        starts=places,
        labels=found.labels,
        attractors=found.attractors,
        ends=found.ends,
        interrupted=found.interrupted,
        provenance=provenance(perf_counter() - started),
    )
