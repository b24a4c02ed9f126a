"""Lyapunov exponents of a motion, in one call."""

from __future__ import annotations

from collections.abc import Mapping
from time import perf_counter
from typing import TYPE_CHECKING

from slipfold.computations.given import checked_model
from slipfold.flow.simulate import checked_periods, checked_tolerance, initial_state
from slipfold.long_term.exponents import Estimate, find_exponents
from slipfold.models.model import Model
from slipfold.models.parameter import DURATION
from slipfold.progress import Observer
from slipfold.results.records import provenance
from slipfold.results.trajectories import LyapunovExponents

if TYPE_CHECKING:
    from numpy.typing import ArrayLike


def lyapunov(
    model: Model,
    periods: int | None = None,
    state: ArrayLike | Mapping[str, float] | None = None,
    *,
    tolerance: float = 1e-8,
    observer: Observer | None = None,
    **parameters: float | str,
) -> LyapunovExponents:
    """Follow a motion and the growth of its perturbations; tell a torus from chaos by it.

    All exponents, by orthogonal directions carried along with the exact derivatives of the flow,
    through stick and slip as well. They are averaged over the second half of the motion with
    smooth weights: along periodic and quasi-periodic motions errors fall faster than any power of
    its length, along chaotic ones with the square root.

    Parameters
    ----------
    model
        The model, e.g. ``SlidingOscillator()``.
    periods
        Forcing periods to follow; of an autonomous model intervals of its ``duration``. If None as
        many as it takes: 32,000 at most, or 128,000 if it is not known by then what the motion is,
        nothing sticks and there are six states at most. The rotation number of a torus, and a
        resonance near it, are part of the verdict.
    state
        Initial state at phase zero, shape (n_states,), or some states by name; what is not given is
        the model's own start.
    tolerance
        Error of all exponents, per forcing period or interval, at which the motion ends if
        `periods` is None. Chaotic motions do not reach a small one.
    observer
        Called after every 250 periods with a `slipfold.Progress`. If it raises
        `KeyboardInterrupt`, or the user does, what is known by then is returned, once 250 periods
        are done.
    **parameters
        Parameters of the model to change first: numbers in SI units, or text with a unit.

    Returns
    -------
    LyapunovExponents
        The exponents with their errors, and the verdict.

    Raises
    ------
    InputError
        If a parameter, `periods`, `state` or `tolerance` cannot be used, or the motion ends at a
        limit of the model.

    Examples
    --------
    >>> import slipfold as sf
    >>> found = sf.lyapunov(sf.SlidingOscillator(), f=12.5, Nd=0.06)
    >>> found.verdict.kind, found.exponents[1:].round(6).tolist()
    ('torus', [-0.005012, -0.117078, -0.269766])
    """
    changed = checked_model(model).replace(**parameters)
    start = initial_state(changed, state)
    started = perf_counter()
    found = find_exponents(
        changed, start, checked_periods(periods), checked_tolerance(tolerance), observer
    )
    unit = 1.0 if changed.forced else float(found.model.values[DURATION.name])
    return LyapunovExponents(
        model=found.model,
        estimates=tuple(
            Estimate(each.periods, each.exponents / unit, each.errors / unit)
            for each in found.estimates
        ),
        verdict=found.verdict,
        start=start,
        state=found.state,
        tolerance=float(tolerance),
        asked=None if periods is None else int(periods),
        interrupted=found.interrupted,
        provenance=provenance(perf_counter() - started),
    )
