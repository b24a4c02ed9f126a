"""How perturbations of a motion grow, forcing period by forcing period."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np

from slipfold.arrays import Array
from slipfold.errors import InputError
from slipfold.flow.equilibrium import paced
from slipfold.flow.flow import flow_of
from slipfold.flow.guarded_flow import Stop
from slipfold.flow.linearised_motion import linearised_motion
from slipfold.flow.settlement import Settlement
from slipfold.flow.simulate import Motion, begun, slips_at_first, trajectory_of
from slipfold.flow.switched_motion import SwitchedMotion, legs
from slipfold.models.model import Model

PILOT = 8
"""Periods from which it is seen how unequally perturbations grow."""

SAMPLES = 16
"""Samples of each of them from which it is seen how far states move."""

STILL = 1e-9
"""Share of its size below which a state does not move but for rounding."""

SPREAD = 12.0
"""Difference of logarithms of growth over which derivatives are carried at once: of 36, with which
all digits of the least growth would be lost."""

MOST_PARTS = 256
"""Parts into which a period is cut at most."""

LOST = 1e-12
"""Growth over a period, of the largest, below which stick has taken a perturbation away: what is
left of it is rounding."""


class Growth(ABC):
    """A motion that goes on, with the growth of perturbations along it.

    They are kept orthogonal (Benettin, Galgani, Giorgilli and Strelcyn, Meccanica 15 (1980) 9): in
    each period the logarithms of the factors by which volumes of 1, 2, ... dimensions grow, divided
    by one another.
    """

    _motion: Motion | SwitchedMotion
    switches = False
    """Whether periods are followed from event to event, which takes long."""

    def __init__(self) -> None:
        self.model = self._motion.model
        self._frame: Array = np.eye(self.state.size)
        self._logarithms: list[Array] = []
        # How far states move, over their typical sizes: in these the frame is told
        self._extents: Array = np.ones(self.state.size)

    @property
    def logarithms(self) -> Array:
        """Logarithms of the growth in each period, shape (periods, n)."""
        return np.concatenate(self._logarithms)

    @property
    def periods(self) -> int:
        """Whole periods so far."""
        return sum(len(part) for part in self._logarithms)

    @property
    def stopped(self) -> Stop | None:
        """Why the motion ended, if it did."""
        return self._motion.stopped

    @property
    def strobe(self) -> Array:
        """States at the start of every period so far, shape (periods + 1, n)."""
        return self._motion.strobe

    @property
    def state(self) -> Array:
        """The state that it has come to, shape (n,)."""
        return self._motion.strobe[-1]

    @abstractmethod
    def settlement(self, tolerance: float) -> Settlement:
        """Return whether the motion has settled, and on what."""

    @abstractmethod
    def carried(self, periods: int) -> Array:
        """Go on; return the derivatives of the ends of pieces of equal length.

        Shapes: returns (periods, parts, n, n), in scaled states.
        """

    def go_on(self, periods: int) -> None:
        """Go on for some periods, as far as it comes."""
        matrices = self._in_extents(self.carried(periods))
        found = np.zeros((len(matrices), matrices.shape[-1]))
        for row, pieces in zip(found, matrices, strict=True):
            for matrix in pieces:
                self._frame, factors = np.linalg.qr(matrix @ self._frame)
                row += self._logarithms_of(np.abs(np.diag(factors)))
        self._logarithms.append(found)

    def _in_extents(self, matrices: Array) -> Array:
        return matrices * (self._extents / self._extents[:, None])

    def _logarithms_of(self, factors: Array) -> Array:
        with np.errstate(divide="ignore"):
            return np.log(factors)


class _SmoothGrowth(Growth):
    """That of a motion without events; all periods are linearised side by side."""

    def __init__(self, model: Model, start: Array) -> None:
        self._motion: Motion = Motion(model, start)
        self._parts = 0
        super().__init__()

    def settlement(self, tolerance: float) -> Settlement:
        return self._motion.settlement(tolerance)

    def carried(self, periods: int) -> Array:
        before = self._motion.periods
        self._motion.go_on(periods)
        starts = self._motion.strobe[before:-1]
        if not len(starts):
            return np.empty((0, 1, self.state.size, self.state.size))
        if not self._parts:
            self._extents = self._extents_of(starts[:PILOT])
            self._parts = self._parts_of(starts[:PILOT])
        return self._derivatives(starts, self._parts)

    def _extents_of(self, starts: Array) -> Array:
        """Return how far each state moves, over its typical size; one where it rests.

        Typical sizes are found before anything moves: of a hard spring the displacement's may be
        thousands of times too large, and growth looks that unequal.
        """
        model, zero = self._motion.model, np.zeros(len(starts))
        flow = flow_of(model)
        states = flow.sample(starts, zero, zero + 1, SAMPLES, flow.constants_of(model))
        moved = np.ptp(states, axis=(0, 1))
        moves = moved > STILL * np.abs(states).max(axis=(0, 1))
        return np.where(moves, moved / model.state_scales(), 1.0)

    def _parts_of(self, starts: Array) -> int:
        """Return into how many parts periods are cut, so that each keeps the least growth."""
        parts = 1
        while parts < MOST_PARTS:
            matrices = self._in_extents(self._derivatives(starts, parts))
            sizes = np.linalg.svd(matrices, compute_uv=False)
            with np.errstate(divide="ignore"):
                spread = np.log(sizes[..., 0] / sizes[..., -1])
            if spread.max(initial=0.0) <= SPREAD:
                break
            parts *= 2
        return parts

    def _derivatives(self, starts: Array, parts: int) -> Array:
        model, n = self._motion.model, starts.shape[1]
        flow = flow_of(model)
        constants, scales = flow.constants_of(model), model.state_scales()
        zero = np.zeros(len(starts))
        states = flow.sample(starts, zero, zero + 1, parts, constants).reshape(-1, n)
        begin = np.tile(np.arange(parts) / parts, len(starts))
        still = np.zeros((len(constants.values), 0))
        matrices = flow.linearise(states, begin, begin + 1 / parts, constants, still)[1]
        if not np.isfinite(matrices).all():
            raise InputError(
                "the derivatives of the motion are lost, so it has no exponents: it is too stiff, "
                "or grows too fast; change a parameter"
            )
        return np.reshape(matrices * (scales / scales[:, None]), (-1, parts, n, n))


class _SwitchedGrowth(Growth):
    """That of a motion through stick and slip: at events perturbations jump, or are lost."""

    switches = True

    def __init__(self, motion: SwitchedMotion) -> None:
        self._motion: SwitchedMotion = motion
        super().__init__()

    def settlement(self, tolerance: float) -> Settlement:
        return trajectory_of(self._motion, tolerance).settlement

    def carried(self, periods: int) -> Array:
        motion, before = self._motion, self._motion.periods
        motion.go_on(periods)
        flow, constants, weights = motion.flow, motion.constants, motion.weights
        scales, still = motion.model.state_scales(), np.zeros((len(constants.values), 0))
        n, strobe = len(scales), motion.strobe
        found = np.empty((motion.periods - before, 1, n, n))
        for row, place in enumerate(range(before, motion.periods)):
            passed = list(legs(flow, motion.modes[place], strobe[place], 1.0, constants, weights))
            part = linearised_motion(flow, strobe[place], passed, constants, weights, still)
            found[row, 0] = part.matrix * (scales / scales[:, None])
        return found

    def _logarithms_of(self, factors: Array) -> Array:
        lost = factors <= LOST * factors.max()
        return super()._logarithms_of(np.where(lost, 0.0, factors))


def growth_from(model: Model, start: Array) -> Growth:
    """Begin a motion with the growth of its perturbations. Shapes: start (n,)."""
    if not slips_at_first(model, start):
        return growth_through_stick(model, start)
    return _SmoothGrowth(model if model.forced else paced(model, start, None)[0], start)


def growth_through_stick(model: Model, start: Array) -> Growth:
    """Begin a motion that sticks, or will. Shapes: start (n,)."""
    return _SwitchedGrowth(begun(model, start, paced=True))
