"""Averages along a trajectory: Lyapunov exponents and rotation numbers, and what they imply."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from slipfold.arrays import Array, Mask
from slipfold.errors import InputError
from slipfold.flow.equilibrium import with_duration
from slipfold.flow.flow import flow_of
from slipfold.flow.hybrid_trajectory import smooth_phases
from slipfold.flow.linearized_trajectory import linearized_trajectory
from slipfold.flow.settlement import Settlement
from slipfold.flow.simulate import (
    HybridIntegration,
    SmoothIntegration,
    reaches_stick_limit,
    starts_in_slip,
)
from slipfold.models.angles import embedded
from slipfold.models.model import Model
from slipfold.models.quantities import DURATION
from slipfold.progress import Observer, Progress


class Average(NamedTuple):
    """Averages of some values along a trajectory, and how much they may be off."""

    values: Array  # shape (k,)
    errors: Array  # shape (k,)


def average(values: Array) -> Average:
    """Average values along a trajectory with smooth weights that vanish at both of its ends.

    Along a periodic or quasi-periodic trajectory errors fall faster than any power of the length
    (Das, Saiki, Sander and Yorke, Nonlinearity 30 (2017) 4111); along a chaotic one they fall with
    its square root, as those of the mean do. The error is the largest difference from the same
    averages over each half and over the middle.

    What is minus infinity at once is so on average, for certain. Shapes: values (m, k).

    >>> import numpy as np
    >>> turns = np.arange(1000) * 0.381966
    >>> found = average(np.cos(2 * np.pi * turns)[:, None] + 3)
    >>> bool(abs(found.values[0] - 3) < 1e-12), bool(found.errors[0] < 1e-9)
    (True, True)
    """
    count = len(values)
    lost = np.isneginf(values).any(axis=0)
    kept = np.where(lost, 0.0, values)
    whole = bump(count) @ kept
    half, quarter = count // 2, count // 4
    parts = (kept[:half], kept[half:], kept[quarter : quarter + half])
    apart = [np.abs(bump(len(part)) @ part - whole) for part in parts]
    return Average(np.where(lost, -np.inf, whole), np.max(apart, axis=0))


def bump(count: int) -> Array:
    """Return weights that add up to one, with all derivatives zero at the ends, shape (m,)."""
    position = (np.arange(count) + 0.5) / count
    weights = np.exp(-1 / (position * (1 - position)))
    return np.asarray(weights / weights.sum())


class EXPONENTS:
    """Accuracy of exponents and of rotation numbers."""

    lines: int = 6  # strongest of a spectrum, which have to be multiples of one
    multiples: int = 32  # largest of these
    match: float = 1e-6  # distance of a line from a multiple, in revolutions
    # Turns over all states below which a line may be a drift: the weights are as wide in frequency
    resolved: float = 4.0
    # Beats beyond which averages converge fast: with fewer the number of turns is known to one
    beats: float = 8.0
    sure: float = 3.0  # errors by which an exponent differs from zero
    fading: float = 0.75  # of that over the quarter before: halved if growth is linear
    rounding: float = 1e-10  # of a zero exponent per period
    pilot: int = 8  # periods that show how unequally perturbations grow
    lost: float = 36.0  # logarithm of a decay of which no digits are left
    spread: float = 12.0  # of logarithms of growth in one linearization
    removed: float = 1e-12  # growth over a period, over the largest, that stick left to rounding
    first: int = 250  # periods before the first estimate; each later one takes twice as many
    max_periods: int = 32_000  # by default if the classification is known or periods are expensive
    longest: int = 128_000  # by default else: 9 s with four states
    converged: float = 1e-9  # distance from a periodic response, in scaled states


@dataclass(frozen=True)
class Rotation:
    """How the closed curve on which a trajectory passes phase zero is turned."""

    number: float  # the rotation number, from 0 to 1/2: revolutions of the curve over `period`
    period: int  # forcing periods after which the curve is mapped onto itself
    # Of the number, estimated: the largest difference from parts of the trajectory, and a turn over
    # all of it near a resonance if few beats are seen
    error: float
    resonance: Fraction | None  # p/q near the number: the curve nearly closes after q returns
    # Forcing periods after which it has closed once more or less than at the resonance, else NaN:
    # averages along the trajectory converge only beyond several of them
    beat: float

    @property
    def sentence(self) -> str:
        """The same in words."""
        over = "a forcing period" if self.period == 1 else f"{self.period} forcing periods"
        text = f"its rotation number is {self.number:.6g} +- {self.error:.0e} over {over}"
        if self.resonance is None:
            return text
        beats = f" (beats of {self.beat:.4g} periods)" if math.isfinite(self.beat) else ""
        return f"{text}, near the resonance {self.resonance}{beats}"


def rotation_of(states: Array, scales: Array, angle_periods: Array) -> Rotation | None:
    """Return the rotation number of a torus from states at phase zero; None if it is unclear.

    On a torus of two frequencies all lines of the spectrum of states k periods apart are multiples
    of one line, the rotation number. Shapes: states (m, n); scales, angle_periods (n,).
    """
    if len(states) < 4:  # half of them have no spectrum
        return None
    signal = embedded(states, scales, angle_periods)
    # Lines near a resonance lie close together.
    signal = signal[-min(65536, (len(signal) + 1) // 2) :]
    count = len(signal)
    lines = _lines(signal)
    for period in range(1, 9):  # periods after which the curve returns to itself
        numbers = _folded(period * lines)
        result = _generator(numbers[numbers > EXPONENTS.match])
        if result is None:
            continue
        if result * count < EXPONENTS.resolved * period:
            return None
        first, half = count // 4, count // 2
        windows = (signal[:half], signal[first : first + half], signal[half:])
        apart = [np.abs(_folded(period * _lines(part)) - result).min() for part in windows]
        return _rotation(result, period, float(max(apart)), count)
    return None


def _lines(signal: Array) -> Array:
    """Return the frequencies of the strongest lines in revolutions per period."""
    count = len(signal)
    weights, times = bump(count)[:, None], np.arange(count)
    rest, result, strongest = signal - bump(count) @ signal, list[float](), 0.0
    for _ in range(EXPONENTS.lines):
        line = _strongest(weights * rest)
        wave = np.exp(2j * np.pi * line * times)
        amplitude = wave.conj() @ (weights * rest)
        factor = 1.0 if 0.5 - line < 1 / count else 2.0
        rest = rest - factor * np.real(wave[:, None] * amplitude)
        strongest = max(strongest, float(np.abs(amplitude).max()))
        if np.abs(amplitude).max() < 1e-4 * strongest:  # faint
            break
        result.append(line)
    return np.array(result)


def _strongest(weighted: Array) -> float:
    """Return the frequency of the largest power: where its slope vanishes, by Newton's method."""
    finer, count = 2, len(weighted)
    power = (np.abs(np.fft.rfft(weighted, finer * count, axis=0)) ** 2).sum(axis=1)
    line = (power[finer:].argmax() + finer) / (finer * count)
    low, high = line - 1 / count, min(line + 1 / count, 0.5)
    moments = 2j * np.pi * (np.arange(count) - count / 2)
    for _ in range(4):
        waved = np.exp(-moments * line)[:, None] * weighted
        value, slope, bend = waved.sum(axis=0), moments @ waved, moments**2 @ waved
        second = (np.vdot(slope, slope) + np.vdot(value, bend)).real
        if not second < 0:
            break
        line = float(np.clip(line + np.vdot(value, slope).real / second, low, high))
    return line


def _generator(lines: Array) -> float | None:
    """Return the line of which all are multiples, the lowest ones if there are several."""
    best, order = None, EXPONENTS.multiples + 1
    for line in lines:
        multiples = _folded(np.arange(1, EXPONENTS.multiples + 1) * line)
        apart = np.abs(lines[:, None] - multiples)
        matches = apart <= EXPONENTS.match * np.arange(1, EXPONENTS.multiples + 1)
        if matches.any(axis=1).all():
            needed = int(matches.argmax(axis=1).max()) + 1
            if needed < order:
                best, order = float(line), needed
    return best


def _folded(revolutions: Array) -> Array:
    """Return revolutions from 0 to 1/2: whole ones and the direction are not seen."""
    return np.asarray(np.abs(revolutions - np.round(revolutions)))


def _rotation(number: float, period: int, error: float, count: int) -> Rotation:
    """Return a rotation number with the resonance that it is near; `count` states show it."""
    resonance, beat = None, float("nan")
    for q in range(1, 201):
        p = round(q * number)
        off = abs(q * number - p)
        # Hurwitz: infinitely many fractions come as near as 0.447 to any number.
        longer = period / off if off else math.inf
        if p and off * q < 0.1 and not longer <= beat:
            resonance, beat = Fraction(p, q), longer
            if count < EXPONENTS.beats * beat:
                error = max(error, period / (q * count))
    return Rotation(number, period, error, resonance, beat)


@dataclass(frozen=True)
class Classification:
    """The classification of a trajectory, with a sentence."""

    kind: str  # equilibrium, periodic, torus, chaos or undecided
    message: str
    period: int | None = None  # forcing periods
    duration: float | None = None  # s, of a cycle
    rotation: float | None = None  # of a torus, in revolutions over some forcing periods
    resonance: str | None = None  # p/q that this is near

    def with_rotation(self, rotation: Rotation | None) -> Classification:
        """Return the classification with the rotation number of a torus, if there is one."""
        if rotation is None:
            return self
        near = None if rotation.resonance is None else str(rotation.resonance)
        message = f"{self.message}; {rotation.sentence}"
        return replace(self, message=message, rotation=rotation.number, resonance=near)

    @property
    def known(self) -> bool:
        """Whether more periods would add nothing."""
        repeats = (self.period or self.duration) is not None
        return repeats if self.kind == "periodic" else self.kind != "undecided"


def classify(
    exponents: Array,
    errors: Array,
    settlement: Settlement,
    seconds: float | None,
    angle_periods: Array,
) -> Classification:
    """Classify a trajectory by exponents per period, in descending order, and by convergence.

    `seconds` is the length of an interval of an autonomous model, whose exponent along the
    trajectory is zero. An exponent with an infinite error is an upper bound.

    Shapes: exponents, errors, angle_periods (n,).
    """
    if settlement.settled:
        return _settled(settlement, exponents[0] > EXPONENTS.sure * errors[0] + EXPONENTS.rounding)
    again = settlement.neutral_round
    if again is not None:
        message = f"periodic: it repeats after {again:.9g} s; nothing attracts trajectories to it"
        return Classification("periodic", message, duration=again)
    slack = EXPONENTS.sure * errors + EXPONENTS.rounding
    if exponents[0] > slack[0]:
        return Classification(
            "chaos", f"chaotic: nearby trajectories diverge, {_doubling(exponents[0], seconds)}"
        )
    zero = np.isfinite(errors) & (np.abs(exponents) <= slack)
    doubtful = int(np.where(zero, errors, 0.0).argmax())
    if zero[doubtful] and errors[doubtful] > 2e-5:  # those of chaos are larger
        return Classification(
            "undecided",
            f"undecided: exponent {doubtful + 1}, {exponents[doubtful]:.2g} a period, is known to "
            f"{errors[doubtful]:.0e} only; give more periods",
        )
    # Perturbations along a torus neither grow nor decay; others may not either. A torus has fewer
    # dimensions than the states, unless all of these are angles (invariance of domain).
    phase = seconds is None  # of the forcing: a frequency without an exponent
    room = len(exponents) - (not angle_periods.all())
    highest = min(int(zero.sum()), room) + phase
    if highest == 0:
        return Classification("equilibrium", "it approaches an equilibrium")
    if highest == 1:
        return Classification(
            "periodic", "periodic: nearby trajectories do not diverge; more periods show its period"
        )
    number = "2" if highest == 2 else f"at most {highest}"
    return Classification("torus", f"quasi-periodic, on a torus of {number} frequencies")


def _settled(settlement: Settlement, grows: bool) -> Classification:
    message = settlement.message + ("; what disturbs it grows" if grows else "")
    if settlement.kind == "equilibrium":
        return Classification("equilibrium", message)
    period = None if settlement.kind == "cycle" else settlement.period
    return Classification("periodic", message, period, settlement.duration)


def _doubling(exponent: float, seconds: float | None) -> str:
    doubles = math.log(2) / exponent
    if seconds is None:
        return f"twice as far after {doubles:.3g} forcing periods"
    return f"twice as far after {doubles * seconds:.3g} s"


class Growth:
    """A trajectory in progress with the growth of perturbations along it.

    They are kept orthogonal (Benettin, Galgani, Giorgilli and Strelcyn, Meccanica 15 (1980) 9), so
    that ratios of the growth of volumes of 1, 2, ... dimensions give the exponents. At events of a
    trajectory with stick perturbations jump or vanish.
    """

    def __init__(self, integration: SmoothIntegration | HybridIntegration) -> None:
        self.integration = integration
        self.model = integration.model
        n = len(self.model.states)
        self._frame: Array = np.eye(n)
        # Directions that decay to rounding within a part: their exponents are upper bounds
        self.unresolved: Mask = np.zeros(n, dtype=bool)
        self._logarithms: list[Array] = []
        # Extents of the states, over their characteristic scales: units of the frame
        self._extents: Array = np.ones(n)
        self._parts = 0  # into which periods are cut; 0 if that is not known yet

    @property
    def logarithms(self) -> Array:
        """Logarithms of the growth in each period, shape (periods, n)."""
        return np.concatenate(self._logarithms)

    @property
    def periods(self) -> int:
        """Complete periods so far."""
        return sum(len(part) for part in self._logarithms)

    def advance(self, periods: int) -> None:
        """Continue for some periods, or until it ends."""
        matrices = self._in_extents(self.derivatives(periods))
        result = np.zeros((len(matrices), matrices.shape[-1]))
        for row, pieces in zip(result, matrices, strict=True):
            for matrix in pieces:
                self._frame, triangle = np.linalg.qr(matrix @ self._frame)
                factors = np.abs(np.diag(triangle))
                lost = factors <= EXPONENTS.removed * factors.max()
                if isinstance(self.integration, HybridIntegration):
                    factors[lost] = 0.0
                else:
                    self.unresolved |= lost
                with np.errstate(divide="ignore"):
                    row += np.log(factors)
        self._logarithms.append(result)

    def derivatives(self, periods: int) -> Array:
        """Continue; return the derivatives of the ends of pieces of equal length.

        Shapes: returns (periods, parts, n, n), in scaled states.
        """
        integration, before = self.integration, self.integration.periods
        integration.advance(periods)
        starts = integration.states[before:-1]
        if isinstance(integration, HybridIntegration):
            return self._through_stick(integration, starts, before)
        if not len(starts):
            return np.empty((0, 1, *self._frame.shape))
        if not self._parts:
            self._extents = self._extents_of(starts[: EXPONENTS.pilot])
            self._parts = self._parts_of(starts[: EXPONENTS.pilot])
        return self._in_slip(starts, self._parts)

    def _in_extents(self, matrices: Array) -> Array:
        return matrices * (self._extents / self._extents[:, None])

    def _extents_of(self, starts: Array) -> Array:
        """Return the extent of each state over its characteristic scale; one where it is constant.

        Characteristic scales may be thousands of times too large, as for the displacement of a hard
        spring, and growth would look that unequal.
        """
        model, zero = self.model, np.zeros(len(starts))
        flow = flow_of(model)
        states = flow.sample(starts, zero, zero + 1, 16, flow.constants_of(model))
        moved = np.ptp(states, axis=(0, 1))
        moves = moved > 1e-9 * np.abs(states).max(axis=(0, 1))  # else rounding
        return np.where(moves, moved / model.state_scales(), 1.0)

    def _parts_of(self, starts: Array) -> int:
        """Return the number of parts of a period such that each resolves the smallest growth."""
        parts = 1
        while parts < 256:
            matrices = self._in_extents(self._in_slip(starts, parts))
            sizes = np.linalg.svd(matrices, compute_uv=False)
            with np.errstate(divide="ignore"):
                spread = np.log(sizes[..., 0] / sizes[..., -1])
            if spread.max(initial=0.0) <= EXPONENTS.spread:
                break
            parts *= 2
        return parts

    def _in_slip(self, starts: Array, parts: int) -> Array:
        """Return the derivatives of all parts of some periods, linearized in one batch."""
        n, flow = starts.shape[1], flow_of(self.model)
        constants, scales = flow.constants_of(self.model), self.model.state_scales()
        zero = np.zeros(len(starts))
        states = flow.sample(starts, zero, zero + 1, parts, constants).reshape(-1, n)
        begin = np.tile(np.arange(parts) / parts, len(starts))
        still = np.zeros((len(constants.values), 0))
        matrices = flow.linearize(states, begin, begin + 1 / parts, constants, still)[1]
        if not np.isfinite(matrices).all():
            raise InputError(
                "the derivatives of the trajectory are lost, so it has no exponents: it is too "
                "stiff, or grows too fast; change a parameter"
            )
        return np.reshape(matrices * (scales / scales[:, None]), (-1, parts, n, n))

    def _through_stick(self, integration: HybridIntegration, starts: Array, before: int) -> Array:
        """Return the derivatives of some periods, from event to event."""
        system, scales = integration.system, self.model.state_scales()
        still = np.zeros((len(system.constants.values), 0))
        result = np.empty((len(starts), 1, len(scales), len(scales)))
        for matrices, start, mode in zip(result, starts, integration.modes[before:], strict=False):
            passed = list(smooth_phases(system, mode, start, 1.0))
            matrix = linearized_trajectory(system, start, passed, still).matrix
            matrices[0] = matrix * (scales / scales[:, None])
        return result


def growth_from(model: Model, start: Array) -> Growth:
    """Begin a trajectory with the growth of its perturbations. Shapes: start (n,)."""
    if not starts_in_slip(model, start):
        return growth_through_stick(model, start)
    model = model if model.forced else with_duration(model, start, None)[0]
    return Growth(SmoothIntegration(model, start))


def growth_through_stick(model: Model, start: Array) -> Growth:
    """Begin a trajectory with stick. Shapes: start (n,)."""
    return Growth(HybridIntegration.begin(model, start, own_duration=True))


class ExponentEstimate(NamedTuple):
    """Exponents per period after some periods."""

    periods: int
    exponents: Array  # shape (n,)
    errors: Array  # shape (n,)

    @property
    def error(self) -> float:
        """The largest error but for directions that decay to rounding within a period."""
        return float(self.errors[self.exponents > -EXPONENTS.lost].max(initial=0.0))


@dataclass(frozen=True, eq=False)
class Exponents:
    """Exponents per period, in descending order, and the classification."""

    model: Model
    state: Array  # the last one, shape (n,)
    estimates: tuple[ExponentEstimate, ...]
    classification: Classification
    interrupted: bool


def find_exponents(
    model: Model,
    start: Array,
    periods: int | None,
    tolerance: float,
    observer: Observer | None = None,
) -> Exponents:
    """Follow a trajectory until its exponents are known to a tolerance, or for some periods.

    Shapes: start (n,).
    """
    try:
        return follow_exponents(growth_from(model, start), periods, tolerance, observer)
    except _Sticks:
        return follow_exponents(growth_through_stick(model, start), periods, tolerance, observer)


class _Sticks(Exception):
    """The trajectory continues through stick."""


def follow_exponents(
    growth: Growth, periods: int | None, tolerance: float, observer: Observer | None
) -> Exponents:
    """Continue until the exponents are known; keep results so far if interrupted."""
    integration = growth.integration
    smooth = isinstance(integration, SmoothIntegration)
    cheap = smooth and len(growth.model.states) <= 6
    maximum = (
        (EXPONENTS.longest if cheap else EXPONENTS.max_periods) if periods is None else periods
    )
    ends = _ends(maximum)
    estimates: list[ExponentEstimate] = []
    interrupted = False
    try:
        for end in ends:
            while growth.periods < end:
                growth.advance(min(EXPONENTS.first, end - growth.periods))
                _refuse_ended(growth)
                if observer is not None:
                    known = tuple(estimates[-1].exponents.tolist()) if estimates else ()
                    shown = "  ".join(f"{exponent:.6g}" for exponent in known) or "not yet"
                    text, values = f"exponents a period: {shown}", {"exponents": known}
                    observer(Progress("periods", growth.periods, maximum, text, values))
            estimates.append(_estimate(growth))
            enough = estimates[-1].error <= tolerance or end >= EXPONENTS.max_periods
            if periods is None and enough and _classification(growth, estimates[-1]).known:
                break
    except KeyboardInterrupt:
        if growth.periods < EXPONENTS.first:
            raise
        interrupted = True
        estimates.append(_estimate(growth))
    classification = _classification(growth, estimates[-1])
    try:
        if growth.model.forced and classification.kind in ("torus", "undecided"):
            scales, angle_periods = growth.model.state_scales(), growth.model.angle_periods
            rotation = rotation_of(integration.states, scales, angle_periods)
            classification = classification.with_rotation(rotation)
    except KeyboardInterrupt:
        interrupted = True
    removed = int(np.isneginf(estimates[-1].exponents).sum())
    if removed:
        message = (
            f"{classification.message}; sliding or stick removes perturbations in {removed} of "
            f"{len(estimates[-1].exponents)} directions in finite time, so that their exponents "
            "are minus infinity"
        )
        classification = replace(classification, message=message)
    state = integration.states[-1]
    return Exponents(growth.model, state, tuple(estimates), classification, interrupted)


def _classification(growth: Growth, last: ExponentEstimate) -> Classification:
    model = growth.model
    seconds = None if model.forced else model.values[DURATION.name]
    settlement = growth.integration.settlement(EXPONENTS.converged)
    return classify(last.exponents, last.errors, settlement, seconds, model.angle_periods)


def _ends(maximum: int) -> list[int]:
    """Return the numbers of periods after which exponents are estimated."""
    ends = [EXPONENTS.first]
    while 2 * ends[-1] < maximum:
        ends.append(2 * ends[-1])
    return [*(end for end in ends if end < maximum), maximum]


def _refuse_ended(growth: Growth) -> None:
    stopped = growth.integration.stopped
    if stopped is None:
        return
    if reaches_stick_limit(stopped, growth.model):
        raise _Sticks
    raise InputError(
        f"the trajectory has no exponents, it ends after {stopped.time:.6g} s: {stopped.reason}; "
        "start elsewhere or change a parameter"
    )


def _estimate(growth: Growth) -> ExponentEstimate:
    """Average over the second half, when the frame has turned into the directions of growth.

    Perturbations that grow linearly, as between tori of other frequencies, have averages that halve
    each time that a trajectory is twice as long: the exponent is zero within their difference.
    """
    rates = growth.logarithms
    half = len(rates) // 2
    later = average(rates[half:])
    values, errors = later.values, later.errors
    with np.errstate(invalid="ignore"):  # of what is minus infinity
        earlier = bump(half - half // 2) @ rates[half // 2 : half]
        fading = np.abs(values) < EXPONENTS.fading * np.abs(earlier)
        fading &= np.abs(values) > EXPONENTS.sure * errors  # else it is known to be zero so far
        errors = np.where(fading, np.fmax(errors, np.abs(earlier - values)), errors)
    errors = np.where(growth.unresolved, np.inf, errors)
    order = np.argsort(-values, kind="stable")
    return ExponentEstimate(growth.periods, values[order], errors[order])
