"""A periodic orbit as data: where it passes, how it repeats, how perturbations grow."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.errors import InputError
from slipfold.flow.contact_trajectory import Samples, sample_hybrid
from slipfold.flow.flow import flow_of
from slipfold.flow.hybrid_flow import hybrid_flow_of, hybrid_system
from slipfold.flow.hybrid_trajectory import first_mode
from slipfold.flow.modes import Mode, reported_mode
from slipfold.flow.trajectory import LastRound, StickTime, round_with_stick
from slipfold.models.angles import count_revolutions, distances, revolutions_by_name
from slipfold.models.levels import POWERS, quantity_of, reference_of
from slipfold.models.model import Model
from slipfold.models.quantities import OutputName
from slipfold.orbits.extrema import (
    AVERAGED,
    Extrema,
    contact_extrema,
    find_extrema,
    revolutions_of_segments,
)
from slipfold.read_only import Documented
from slipfold.text import (
    OneLine,
    PrintedTable,
    headed,
    multipliers_text,
    number_text,
    outside,
    revolutions_text,
)

if TYPE_CHECKING:
    from slipfold.orbits.check import OrbitCheck
    from slipfold.orbits.harmonic_balance import HarmonicBalance


class MEANS:
    """How samples for the mean of an output are doubled."""

    fewest: int = 64  # samples of a forcing period at first
    most: int = 8192  # and at last: corners of an output leave 1e-9, jumps 1e-4
    change: float = 1e-12  # of the mean, over the mean modulus, that is rounding


SampleCount = Annotated[int, "At least this many samples; rounded up to a multiple of the nodes."]


class Measured(Documented):
    """One orbit or many of which an output is measured; of many, results have the shape (n,)."""

    def extrema_of(self, output: OutputName) -> Extrema:
        """Return minimum and maximum of one output, in less time than those of all."""
        raise NotImplementedError

    def mean(self, output: OutputName) -> Any:
        """Return the mean of one output over the period.

        The mean of a power times `duration` is the energy of a cycle: that which a contact with the
        name ``"tip"`` dissipates is ``orbit.mean("power_friction_tip") * orbit.duration``. Samples
        are doubled until the mean no longer changes; of smooth outputs it has all digits then, of
        those with corners, as speeds where a contact sticks, about nine, and of those that jump
        there, as friction forces, four.

        Examples
        --------
        >>> import slipfold as sf
        >>> orbit = sf.periodic_orbit(sf.built_in_models()["duffing"](W=0.5))
        >>> abs(orbit.mean("v")) < 1e-12
        True
        """
        return self._each(lambda orbit: float(orbit._mean(output, lambda *_: 1.0)))

    def rms(self, output: OutputName) -> Any:
        """Return the root mean square of one output over the period, its mean included."""
        return self._each(lambda orbit: math.sqrt(orbit._mean(output, lambda _, values: values)))

    def harmonic(self, output: OutputName, number: int = 1) -> Any:
        """Return the amplitude of a harmonic of one output.

        Parameters
        ----------
        number
            That of the harmonic: its frequency is so many times that of the forcing, or of a cycle.
        """
        if not (number >= 1 and number % 1 == 0):
            raise InputError(f"no harmonic {number!r} of {output!r}; give a whole number from 1")

        def amplitude(orbit: PeriodicOrbit) -> float:
            turn = -2j * math.pi * number * orbit.period / orbit.duration
            mean = orbit._mean(output, lambda time, _: np.exp(turn * time), 4 * int(number))
            return 2 * abs(mean)

        return self._each(amplitude)

    def level(self, output: OutputName, reference: float | str | None = None) -> Any:
        """Return the level of one output in dB.

        It is 20 times the decimal logarithm of the root mean square over the reference; of powers
        and energies, 10 times that of the modulus of the mean over the reference.

        Parameters
        ----------
        reference
            In the unit of the output, or text with a unit, such as ``"1 um"``; that of ISO 1683 if
            None: 1 pm, 1 nm/s, 1 um/s^2, 1 uN, 20 uPa, 1 pJ or 1 pW.
        """

        def level(orbit: PeriodicOrbit) -> float:
            unit = quantity_of(orbit.model, output).unit
            size = abs(orbit.mean(output)) if unit in POWERS else orbit.rms(output)
            return reference_of(unit, reference).level(size)

        return self._each(level)

    def _each(self, measure: Callable[[PeriodicOrbit], float]) -> Any:
        """Return a number of each orbit."""
        raise NotImplementedError


def measured_of(given: Measured, measure: str, output: str) -> Array:
    """Return a measure of one output over each orbit, shape (n,)."""
    if measure in AVERAGED:
        return np.atleast_1d(getattr(given, measure)(output))
    return given.extrema_of(output).measured(measure, output)


@dataclass(frozen=True, eq=False, repr=False)
class PeriodicOrbit(Measured, OneLine):
    """A periodic orbit, forced or a cycle of an autonomous model; frozen.

    Examples
    --------
    >>> import slipfold as sf
    >>> orbit = sf.periodic_orbit(sf.SlidingOscillator(f=12.5, Nd=0.05))
    >>> orbit.stable
    False
    >>> round(float(orbit.multipliers[0].real), 6)
    -1.164144
    """

    model: Annotated[Model, "The model with the parameter values of the orbit."]
    period: Annotated[int, "Period in forcing periods."]
    nodes: Annotated[
        NDArray[np.float64], "States at `period` * j / m for j = 0 ... m - 1, shape (m, n_states)."
    ]
    multipliers: Annotated[
        NDArray[np.complex128],
        "Floquet multipliers, complex, shape (n_states,), largest modulus first.",
    ]
    residual: Annotated[float, "How far the orbit fails to close, in scaled states."]

    def _line(self) -> str:
        judged = multipliers_text(self.multipliers, cycle=not self.model.forced)
        details = ", ".join(filter(None, [judged, revolutions_text(self.revolutions)]))
        return f"PeriodicOrbit of {self.model.name}: period {self.period}, {details}"

    def _rows(self) -> PrintedTable:
        states = zip(self.model.states, self.state, strict=True)
        numbered = enumerate(self.multipliers, 1)
        return PrintedTable(
            ["", ""],
            [
                *([headed(item), number_text(value, 10)] for item, value in states),
                *([f"multiplier {number}", f"{value:.6g}"] for number, value in numbered),
            ],
        )

    @property
    def state(self) -> NDArray[np.float64]:
        """State at phase zero, shape (n_states,)."""
        return self.nodes[0]

    @property
    def stable(self) -> bool:
        """Whether no multiplier lies outside the unit circle; without damping all lie on it."""
        return not outside(self.multipliers).any()

    @property
    def duration(self) -> float:
        """Period in seconds."""
        return self.period * flow_of(self.model).constants_of(self.model).period

    @property
    def sticking(self) -> tuple[StickTime, ...]:
        """When contacts stick, from phase zero in forcing periods, of cycles in s."""
        return ()

    @property
    def stuck_fraction(self) -> float:
        """Fraction of the period in which a contact sticks."""
        return 0.0

    @cached_property
    def revolutions(self) -> dict[str, int]:
        """Revolutions that each angle makes in a period, by name; none where no state is one."""
        return revolutions_by_name(self.model.states, self._revolutions_of_segments.sum(axis=0))

    @cached_property
    def _revolutions_of_segments(self) -> NDArray[np.float64]:
        """Revolutions by which each segment ends ahead of the next node, shape (m, n_states)."""
        flow = flow_of(self.model)
        constants = flow.constants_of(self.model)
        return revolutions_of_segments(self.model, flow, self.nodes[None], self.period, constants)[
            0
        ]

    def sample(self, count: SampleCount = 256) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Sample the states over one period.

        Returns
        -------
        time : ndarray, shape (count,)
            Seconds, from 0; the end of the period is left out.
        states : ndarray, shape (count, n_states)
            States; angles continue beyond a turn.
        """
        flow = flow_of(self.model)
        segments = len(self.nodes)
        each = -(-count // segments)
        edges = np.linspace(0, self.period, segments + 1)
        constants = flow.constants_of(self.model)
        states = flow.sample(self.nodes, edges[:-1], edges[1:], each, constants)
        before = np.cumsum(self._revolutions_of_segments, axis=0) - self._revolutions_of_segments
        states = states + (before * self.model.angle_periods)[:, None]
        time: NDArray[np.float64] = np.arange(segments * each, dtype=float)
        time *= self.duration / (segments * each)
        return time, states.reshape(segments * each, -1)

    def output(
        self, name: OutputName, count: int = 256
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Sample one output over one period.

        Parameters
        ----------
        count
            At least this many samples.

        Returns
        -------
        time, values : ndarray, shape (count,)
            Seconds and values in the unit of the output.
        """
        time, values = self.outputs(count)
        return time, values[:, flow_of(self.model).output_index(name)]

    def outputs(self, count: SampleCount = 256) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Sample all outputs over one period.

        Returns
        -------
        time : ndarray, shape (count,)
            Seconds, from 0; the end of the period is left out.
        values : ndarray, shape (count, n_outputs)
            Outputs, the states first, each in its unit.
        """
        flow = flow_of(self.model)
        time, states = self.sample(count)
        constants = flow.constants_of(self.model)
        return time, flow.outputs(states, time / constants.period, constants)

    def _each(self, measure: Callable[[PeriodicOrbit], float]) -> float:
        return measure(self)

    def _mean(
        self, output: str, weights: Callable[[Array, Array], Any], fewest: int = MEANS.fewest
    ) -> Any:
        """Return the mean of one output times weights that times and values give.

        The weights need so many samples of a forcing period at first: of fewer, they are others.
        """
        count, before = max(fewest, MEANS.fewest) * self.period, np.inf
        most = max(MEANS.most * self.period, 2 * count)
        while True:
            time, values = self.output(output, count)
            values = values * weights(time, values)
            mean = values.mean()
            settled = abs(mean - before) <= MEANS.change * float(np.abs(values).mean())
            if settled or count >= most:
                return mean
            count, before = 2 * count, mean

    def check(self, tolerance: float = 1e-8) -> OrbitCheck:
        """Compute the orbit again by collocation, with other points on another mesh.

        Parameters
        ----------
        tolerance
            What is allowed of each difference: of states (scaled), duration and multipliers.

        Returns
        -------
        OrbitCheck
            The differences and the orbit by collocation; it prints as a sentence.

        Raises
        ------
        InputError
            If no mesh of collocation fits the orbit.

        Examples
        --------
        >>> import slipfold as sf
        >>> sf.periodic_orbit(sf.SlidingOscillator(f=12.5, Nd=0.05)).check().passed
        True
        """
        from slipfold.orbits.check import OrbitCheck, orbit_by_collocation
        from slipfold.orbits.multipliers import multiplier_difference

        found = orbit_by_collocation(self.model, self.nodes, self.period, self.multipliers)
        return OrbitCheck(
            found,
            float(distances(self.model, found.anchors, self.nodes).max()),
            abs(found.duration / self.duration - 1),
            multiplier_difference(self.multipliers, found.multipliers),
            tolerance,
        )

    def harmonic_balance(self, tolerance: float = 1e-8, largest: int = 1000) -> HarmonicBalance:
        """Compute the orbit again as a Fourier series, its multipliers by Hill's determinant.

        Linear equations are condensed to the forces that vary, as those at contacts do, so that
        fast modes cost nothing.

        Parameters
        ----------
        tolerance
            What is allowed of each difference: of states (scaled), duration and multipliers, and
            of the harmonics that are left out.
        largest
            Most unknowns of the condensed equations: each force that varies has one for every
            coefficient of its series. A step of 1,000 takes 0.3 s, and grows with their cube.

        Returns
        -------
        HarmonicBalance
            The differences and the series; it prints as a sentence.

        Raises
        ------
        InputError
            If the orbit sticks, or an angle revolves on it.

        Examples
        --------
        >>> import slipfold as sf
        >>> sf.periodic_orbit(sf.SlidingOscillator(f=12.5, Nd=0.05)).harmonic_balance().passed
        True
        """
        from slipfold.orbits.harmonic_balance import BALANCE, balance

        if any(self.revolutions.values()):
            raise InputError(
                f"an angle of {self.model.name} revolves on this orbit, so it is no Fourier "
                "series; use check(), which computes it by collocation"
            )
        samples = self.sample(BALANCE.guess * self.period)[1]
        given = self.model, self.nodes, self.period, self.multipliers, samples
        return balance(*given, tolerance, largest)

    @cached_property
    def multiplier_uncertainty(self) -> NDArray[np.float64]:
        """Computed uncertainty of each multiplier, shape (n_states,).

        How much it moves when the monodromy matrix is integrated again with other steps.
        """
        from slipfold.orbits.uncertainty import multiplier_uncertainty

        given = self.model, self.model.vector[None], self.nodes[None], self.period
        return multiplier_uncertainty(*given, self.multipliers[None])[0]

    @cached_property
    def extrema(self) -> Extrema:
        """Minimum and maximum of every output over the continuous orbit."""
        return find_extrema(self.model, self.model.vector[None], self.nodes[None], self.period)

    def extrema_of(self, output: str) -> Extrema:
        """Return minimum and maximum of one output."""
        if "extrema" in vars(self):
            return self.extrema
        vector, nodes = self.model.vector[None], self.nodes[None]
        return find_extrema(self.model, vector, nodes, self.period, (output,))


@dataclass(frozen=True, eq=False, repr=False)
class StickSlipOrbit(PeriodicOrbit):
    """A periodic orbit whose contacts stick, slip back and forth, or open on the way; frozen.

    Its multipliers are those of the true linearization, jumps at the changes included: what a stuck
    contact loses has the multiplier zero.
    """

    @property
    def sticking(self) -> tuple[StickTime, ...]:
        """When contacts stick, from phase zero."""
        return self._round.sticking

    @property
    def stuck_fraction(self) -> float:
        """Fraction of the period in which a contact sticks."""
        return self._round.fraction

    def sample(self, count: int = 256) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Sample the states over one period, through stick and slip."""
        phases: Array = np.arange(count, dtype=float) * (self.period / count)
        return phases * self._forcing_period, self._samples(phases).states

    def outputs(self, count: int = 256) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Sample all outputs over one period, through stick and slip."""
        phases: Array = np.arange(count, dtype=float) * (self.period / count)
        return phases * self._forcing_period, self._samples(phases).outputs()

    @property
    def _forcing_period(self) -> float:
        return self.duration / self.period

    def check(self, tolerance: float = 1e-8) -> OrbitCheck:
        """Refuse: collocation, the second method, does not go through stick and slip."""
        raise InputError(
            "an orbit that sticks cannot be computed again by collocation; its "
            "multiplier_uncertainty comes from other steps of the same method"
        )

    def harmonic_balance(self, tolerance: float = 1e-8, largest: int = 1000) -> HarmonicBalance:
        """Refuse: forces that jump have a Fourier series that converges too slowly for a check."""
        raise InputError(
            "an orbit that sticks has forces that jump, which a Fourier series cannot represent to "
            "many digits; use Regularized(law, e=...), whose orbits harmonic balance can compute"
        )

    @cached_property
    def revolutions(self) -> dict[str, int]:
        """Revolutions that each angle makes in a period, by name; none where no state is one."""
        end = self._samples(np.array([0.0, float(self.period)])).states[-1]
        return revolutions_by_name(
            self.model.states, count_revolutions(end - self.state, self.model.angle_periods)
        )

    @cached_property
    def multiplier_uncertainty(self) -> NDArray[np.float64]:
        """Computed uncertainty of each multiplier, started elsewhere on the orbit."""
        from slipfold.orbits.switched_shooting import SwitchedShooting
        from slipfold.orbits.uncertainty import multiplier_uncertainty

        given = self.model, self.model.vector[None], self.nodes[None, :1], self.period
        change = multiplier_uncertainty(*given, self.multipliers[None], SwitchedShooting)[0]
        planar = hybrid_flow_of(self.model).planar
        # The linearization leaves out where slip in the plane begins and ends.
        return np.maximum(change, 5e-7) if planar and self.stuck_fraction else change

    @cached_property
    def extrema(self) -> Extrema:
        """Minimum and maximum of every output: of states wherever they lie, of others sampled."""
        found, n = self._round, len(self.state)
        low, high = contact_extrema(self.model, self.state, self.first_mode, self.period)
        low[:n], high[:n] = found.minimum, found.maximum
        if np.isnan(found.fraction):  # of part of a round they would be others
            low[:], high[:] = np.nan, np.nan
        return Extrema(flow_of(self.model).output_names, low[None], high[None])

    def extrema_of(self, output: str) -> Extrema:
        """Return minimum and maximum of one output."""
        flow_of(self.model).output_index(output)
        return self.extrema

    @cached_property
    def _round(self) -> LastRound:
        names = [item.name for item in hybrid_flow_of(self.model).contacts]
        return round_with_stick(
            self.model, self.state, self.first_mode, names, self.period, repeats=True
        )

    @cached_property
    def first_mode(self) -> Mode:
        """What its contacts do at phase zero."""
        return reported_mode(first_mode(hybrid_system(self.model, self.state), self.state))

    def _samples(self, phases: Array) -> Samples:
        return sample_hybrid(self.model, self.state, self.first_mode, phases)
