"""The motion of a model in time, in one call."""

from __future__ import annotations

from collections.abc import Mapping
from time import perf_counter
from typing import TYPE_CHECKING

from slipfold.checks.checked import Checked
from slipfold.checks.motions import check_motion, check_switched_motion
from slipfold.computations.given import checked_model
from slipfold.flow.switched.simulate import simulate_smooth_or_switched
from slipfold.flow.trajectory import Trajectory
from slipfold.models.model import Model
from slipfold.progress import Observer, Progress
from slipfold.results.records import provenance
from slipfold.results.simulation import Simulation

if TYPE_CHECKING:
    from numpy.typing import ArrayLike


def simulate(
    model: Model,
    periods: int | None = None,
    state: ArrayLike | Mapping[str, float] | None = None,
    *,
    tolerance: float = 1e-9,
    observer: Observer | None = None,
    **parameters: float | str,
) -> Simulation:
    """Integrate a model, and say whether its motion has settled, and on what.

    Parameters
    ----------
    model
        The model, e.g. ``SlidingOscillator()``.
    periods
        Forcing periods to integrate, 1000 if None; of an autonomous model intervals of its
        ``duration``. If None it is integrated until it settles, 16,000 intervals at most, in
        intervals that suit its motion.
    state
        Initial state at phase zero, shape (n_states,), or some states by name; what is not given is
        the model's own start. One on an unstable equilibrium of an autonomous model, where a motion
        would stay for ever, is pushed off it by 1e-6; the settlement says so.
    tolerance
        Distance from a periodic response, a cycle or an equilibrium at which the motion counts as
        settled, in scaled states.
    observer
        Called every few periods and before the checks, with a
        `slipfold.Progress`. If it raises `KeyboardInterrupt`, or the user does,
        the motion is returned as far as it came, and its `stopped` says so.
    **parameters
        Parameters of the model to change first: numbers in SI units, or text with a unit.

    Returns
    -------
    Simulation
        Ends early, with the reason, where the model meets one of its limits.

    Raises
    ------
    InputError
        If a parameter, `periods`, `state` or `tolerance` cannot be used.

    Examples
    --------
    >>> import slipfold as sf
    >>> sf.simulate(sf.SlidingOscillator(), periods=1000, f=12.2, Nd=0.05).settlement.period
    1
    >>> cycle = sf.simulate(sf.built_in_models()["vanderpol-free"]()).settlement
    >>> cycle.kind, round(cycle.duration, 6)
    ('cycle', 6.663287)
    """
    model = checked_model(model)
    changed = model.replace(**parameters)
    started = perf_counter()
    watch = observer or _unobserved
    found = simulate_smooth_or_switched(
        changed, periods, state, tolerance=tolerance, observer=watch
    )
    return Simulation(
        model=found.model,
        strobe=found.strobe,
        settlement=found.settlement,
        stopped=found.stopped,
        sticking=found.sticking,
        asked=found.periods if periods is None else int(periods),
        tolerance=float(tolerance),
        provenance=provenance(perf_counter() - started),
        checked=_checked(found, watch),
    )


def _unobserved(progress: Progress) -> None:
    """Keep a motion that nobody watches, too, where it is interrupted."""


def _checked(motion: Trajectory, observer: Observer) -> Checked:
    """Check a motion, unless it was interrupted."""
    if motion.stopped is not None and motion.stopped.kind == "interrupted":
        return Checked((), interrupted=True)
    try:
        observer(Progress("checks", 0))
    except KeyboardInterrupt:
        return Checked((), interrupted=True)
    return check_motion(motion) if motion.sticking is None else check_switched_motion(motion)
