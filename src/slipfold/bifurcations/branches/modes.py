"""Nonlinear modes: cycles that leave rest where negative damping balances that of a linear mode."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from slipfold.arrays import Array
from slipfold.bifurcations.branches.branch import Branch
from slipfold.bifurcations.branches.response import BranchTree
from slipfold.bifurcations.branches.settings import Event, Settings
from slipfold.bifurcations.branches.start import measured_over, method_for
from slipfold.bifurcations.branches.stops import stop_in_family
from slipfold.continuation.curve_set import FollowedCurve, Start
from slipfold.continuation.end import End
from slipfold.continuation.traced_curve import Monitor
from slipfold.errors import InputError
from slipfold.models.equilibria import find_static_point
from slipfold.models.model import evaluation_of
from slipfold.models.nonlinear_mode import XI, NonlinearMode
from slipfold.orbits.critical import hopf_cycle
from slipfold.orbits.eigenvalues import unit_of_time
from slipfold.orbits.kinds import Equilibria
from slipfold.orbits.orbit_curve import OrbitPoint, Orbits
from slipfold.progress import Observer


class MODES:
    """How the negative damping is found that balances a linear mode."""

    steps: int = 30  # of Newton's method; three are needed where modes part
    close: float = 1e-14  # real part over the frequency that counts as none


@dataclass(frozen=True, eq=False)
class Balanced:
    """A linear mode about rest, with the negative damping that balances its own."""

    rest: Array  # shape (n,)
    xi: float
    frequency: float  # rad/s


def balanced_mode(model: NonlinearMode, number: int) -> Balanced:
    """Return a linear mode, the lowest natural frequency first, on the imaginary axis.

    Rest does not depend on what is proportional to velocities. So the real part of the eigenvalue
    is a function of the negative damping alone, whose derivative the eigenvectors give.
    """
    rest = find_static_point(model)
    jacobian = evaluation_of(model).jacobian
    own = jacobian(model.replace(xi=0.0), rest)
    slope = jacobian(model.replace(xi=1.0), rest) - own
    values = np.linalg.eigvals(own)
    vibrating = sorted(values[values.imag > 0].tolist(), key=abs)
    if number > len(vibrating):
        most = f"give at most {len(vibrating)}" if vibrating else "raise e of a Regularized law"
        raise InputError(
            f"mode = {number}, but {model.name} has {len(vibrating)} that vibrate about rest "
            f"with less than critical damping; {most}"
        )
    value, xi = vibrating[number - 1], 0.0
    for _ in range(MODES.steps):
        if abs(value.real) < MODES.close * abs(value):
            break
        values, vectors = np.linalg.eig(own + xi * slope)
        at = int(np.abs(values - value).argmin())
        rate = (np.linalg.inv(vectors)[at] @ slope @ vectors[:, at]).real
        xi -= float(values[at].real / rate)
        values = np.linalg.eigvals(own + xi * slope)
        value = complex(values[np.abs(values - 1j * value.imag).argmin()])
    else:
        raise InputError(
            f"negative damping does not balance mode {number} of {model.name}, at "
            f"{abs(value) / (2 * np.pi):.6g} Hz: it is not damped like a vibration"
        )
    return Balanced(rest, xi, float(value.imag))


def trace_mode(
    model: NonlinearMode,
    mode: Balanced,
    span: tuple[float, float],
    event: Event,
    settings: Settings,
    observer: Observer | None = None,
) -> tuple[Branch, ...]:
    """Follow the cycles that leave a balanced mode, over the negative damping, to an event."""
    there = measured_over(model, XI.name, span).replace(xi=mode.xi)
    paced = there.replace(duration=unit_of_time(evaluation_of(there).jacobian(there, mode.rest)))
    orbits = Equilibria(paced, {XI.name: span[1] - span[0]})
    z = orbits.join(mode.rest[None], mode.xi)
    residual, method = orbits.residual(z, orbits.defect(z)), partial(method_for, settings)
    start = hopf_cycle(orbits, z, residual, method, frequency=mode.frequency)
    tree = _Modes(model.parameter(XI.name), span, settings, (event,), observer, False)
    tree.explore(Start(start.curve, (start,), departs=True))
    reason = f"leaves rest where xi = {mode.xi:.9g} balances the damping of a linear mode"
    return tree.assembled(End("bifurcation", reason, (mode.xi,)))


class _Modes(BranchTree):
    """The cycles of one mode, without others that leave them.

    Without damping they are a family with one value of the parameter, which does not end them.
    """

    def _monitors(
        self, orbits: Orbits, first: OrbitPoint, departs: bool, several: bool = False
    ) -> list[Monitor[OrbitPoint]]:
        monitors = super()._monitors(orbits, first, departs, several)
        return [item for item in monitors if item is not stop_in_family]

    def children(self, followed: FollowedCurve[OrbitPoint]) -> Sequence[Start[OrbitPoint]]:
        """Return none."""
        return ()
