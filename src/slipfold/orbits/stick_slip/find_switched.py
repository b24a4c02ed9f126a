"""A periodic orbit through stick and slip, from a motion that settles on it."""

from __future__ import annotations

from slipfold.arrays import Array
from slipfold.continuation.newton import Correction, correct
from slipfold.errors import InputError
from slipfold.flow.switched.simulate import simulate_switched
from slipfold.flow.trajectory import Trajectory
from slipfold.models.model import Model
from slipfold.orbits.carry_to import hold_parameter
from slipfold.orbits.discretisations.switched_shooting import SwitchedShooting
from slipfold.orbits.kinds import orbits_of
from slipfold.orbits.orbit_curve import Orbits

SETTLED = 1e-6
"""Change from round to round, in scaled states, at which Newton's method takes over."""

ITERATIONS = 20


def find_switched(
    model: Model,
    vary: str,
    width: float,
    period: int | None,
    state: Array | None,
    *,
    tolerance: float = 1e-10,
    settle: int = 400,
) -> tuple[Orbits, Correction]:
    """Return an orbit near what a motion with stick and slip comes to, and its correction.

    Without a period it has that of the motion. Shapes: state (n,).
    """
    start = model.start if state is None else state
    motion = simulate_switched(model, settle if model.forced else None, start, SETTLED)
    if motion.stopped is not None:
        raise InputError(f"no orbit was found: {motion.stopped.reason}")
    settlement = motion.settlement
    if not model.forced and settlement.kind != "cycle":
        raise InputError(
            f"the motion of {model.name} comes to no cycle: {settlement.message}; give a state "
            "near one"
        )
    for name in _resting(motion) if model.forced else ():
        raise InputError(
            f"the contact {name} of {model.name} sticks for good, so it may rest anywhere "
            "in a range and no orbit stands alone; begin where it slips"
        )
    model, node = motion.model, motion.strobe[-1]
    if settlement.duration is not None and not model.forced:
        model = model.replace(duration=settlement.duration)
    period = (period or settlement.period or 1) if model.forced else 1
    orbits = orbits_of(model, {vary: width}, period, 1, by=SwitchedShooting)
    by = orbits.by
    assert isinstance(by, SwitchedShooting)
    constants = orbits.flow.constants_of(model)
    better = by.better(node[None], constants)
    if better is not None:
        node = by.states(node[None], constants, better.start)[0]
        orbits = orbits.described_by(better)
    guess = orbits.unknown(node[None], model)
    row = hold_parameter(len(guess) - 1)
    return orbits, correct(orbits, guess, row, tolerance=tolerance, iterations=ITERATIONS)


def _resting(motion: Trajectory) -> list[str]:
    """Return the contacts that stick throughout the last forcing period."""
    last = motion.periods
    return [
        item.contact
        for item in (motion.sticking.intervals if motion.sticking is not None else ())
        if item.state == "stick" and item.begin <= last - 1 and item.end >= last
    ]
