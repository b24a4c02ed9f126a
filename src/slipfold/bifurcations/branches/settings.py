"""Options of continuation in small groups, with defaults that hold on all reference cases."""

from __future__ import annotations

import math
from dataclasses import dataclass
from numbers import Real

from slipfold.continuation.settings import Stepping
from slipfold.errors import InputError, suggest

DISCRETIZATIONS = ("automatic", "shooting", "collocation")


@dataclass(frozen=True, repr=False)
class Settings(Stepping):
    """All options of continuation.

    Parameters
    ----------
    newton
        Convergence criteria of Newton's method.
    steps
        Lengths of steps along a branch.
    largest_period
        Doubled branches are followed up to this period, in forcing periods. With zero no cycles
        of an autonomous model are followed, but equilibria alone.
    snaking_period
        The same for branches that leave one which snakes towards a homoclinic orbit, and so has
        infinitely many doublings, and once more than 20 doublings were found.
    largest_duration
        A branch of cycles ends where one round lasts this many times as long as at its first point.
        Near a homoclinic orbit the duration grows without bound; then eight segments of equal time
        are few, and there may be infinitely many bifurcations. So it does in slow relaxation.

    discretization
        By what periodic orbits are computed: ``"shooting"``, or ``"collocation"`` on a mesh that
        adapts itself, for stiff motion and for motion that grows and decays by many orders of
        magnitude within a period. Special points are the same. ``"automatic"`` is shooting, which
        is quicker, over segments that adapt themselves to such growth, and on each branch
        collocation from where shooting cannot continue; from its beginning where the fastest
        vibration turns 200 times within a period, of forced orbits if it decays as well. Forced
        orbits of structures with many or fast modes, and without contacts that stick, are computed
        by shooting in which the modes are exact.

    Examples
    --------
    >>> import slipfold as sf
    >>> sf.Settings(steps=sf.Steps(largest=0.05)).newton.tolerance
    1e-10
    """

    largest_period: int = 8
    snaking_period: int = 2
    largest_duration: float = 100.0
    discretization: str = "automatic"

    def __post_init__(self) -> None:
        """Refuse a period or a duration that no response has."""
        if self.discretization not in DISCRETIZATIONS:
            raise InputError(
                f"discretization = {self.discretization!r} is not known; "
                f"{suggest(str(self.discretization), DISCRETIZATIONS)}give one of "
                f"{', '.join(DISCRETIZATIONS)}"
            )
        if not self.largest_duration > 1:
            raise InputError(
                f"largest_duration = {self.largest_duration:g} leaves no branch of cycles; give "
                "more than 1, in units of the first cycle's duration"
            )
        if self.largest_period < 0:
            raise InputError(
                f"largest_period = {self.largest_period} is below 0; give 1 to follow the response "
                "alone, 8 for its doublings, 0 for equilibria without their cycles"
            )


MEASURES = ("max", "min", "peak_to_peak", "rms", "harmonic", "parameter")


@dataclass(frozen=True)
class Event:
    """A value of an output or of the parameter, or an extremum, that is to be found on the branch.

    Parameters
    ----------
    name
        Name of the event in results: a state or output, or the parameter that is varied.
    value
        The value to be found, in its unit. None for where the measure has a maximum or minimum
        along the branch, such as the peak of a resonance: a special point of type MAX or MIN.
    measure
        ``"max"``, ``"min"``, ``"peak_to_peak"``, ``"rms"`` or ``"harmonic"``, the amplitude of the
        first harmonic, of the output over the orbit, or ``"parameter"`` for a value of the
        parameter itself.
    stop
        Whether the branch ends there.

    Examples
    --------
    >>> Event("x", 0.3)
    Event(name='x', value=0.3, measure='max', stop=False)

    The resonance of a linear oscillator with the damping ratio 0.1 has its peak at sqrt(0.98):

    >>> import slipfold as sf
    >>> model = sf.System(
    ...     name="linear",
    ...     parameters={"W": 0.5},
    ...     states={"x": "v", "v": "cos(W*t) - 0.2*v - x"},
    ...     forcing={"period": "2*pi/W"},
    ... )
    >>> (peak,) = sf.response(model, "W", (0.5, 1.5), events=[sf.Event("x")]).branches[0].special
    >>> peak.type, round(peak.value, 9), round(0.98**0.5, 9)
    ('MAX', 0.989949494, 0.989949494)
    """

    name: str
    value: float | None = None
    measure: str = "max"
    stop: bool = False

    def __str__(self) -> str:
        """Return what is measured, as in ``"max x"``."""
        return f"{self.measure} {self.name}"

    def __post_init__(self) -> None:
        """Refuse an unknown measure or a value that is none."""
        if self.value is None and self.measure == "parameter":
            raise InputError(
                f"event on parameter {self.name!r} has no value; give one, since a parameter has "
                "its extrema at folds, which are always located"
            )
        if self.value is not None and not _is_finite(self.value):
            raise InputError(
                f"event value = {self.value!r} is not a finite number; give one in the unit of "
                f"{self.name}"
            )
        if self.measure not in MEASURES:
            raise InputError(
                f"event measure {self.measure!r} is unknown; give one of {', '.join(MEASURES)}"
            )


def _is_finite(value: object) -> bool:
    return isinstance(value, Real) and math.isfinite(value)
