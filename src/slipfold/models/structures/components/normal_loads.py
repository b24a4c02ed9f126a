"""What presses a friction contact: a constant, a modulated or a displacement-dependent force."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar

from slipfold.errors import InputError
from slipfold.models.friction.quantities import described
from slipfold.models.output import Expression, Limit, Symbols
from slipfold.models.parameter import Parameter
from slipfold.models.structures.components.direction import Direction, as_direction
from slipfold.models.structures.components.harmonics import checked_harmonic
from slipfold.models.structures.components.trigonometry import wave
from slipfold.models.structures.parametric import Parametric

_STATIC = Parameter("Ns", 1.0, "N", "static normal force", 0, lower_open=True, symbol="$N_s$")

LOST = 1e-9
"""Normal force in N at which a branch ends: a contact cannot pull."""


@dataclass(frozen=True)
class NormalLoad(Parametric, ABC):
    """The normal force of a contact.

    Parameters
    ----------
    normal
        Degree of freedom, or weights by name, along which the force pushes the structure away from
        the counter-body; None if the structure cannot move that way.
    """

    title: ClassVar[str] = "normal load"

    opens: ClassVar[bool] = False
    """Whether the force may vanish in motion."""

    normal: Any = field(default=None, kw_only=True)

    def prepare(self) -> None:
        """Read the direction."""
        if self.normal is not None:
            object.__setattr__(self, "normal", as_direction(self.normal, f"a {self.title}"))

    @property
    def direction(self) -> Direction | None:
        """Where the force pushes the structure; None if nowhere."""
        direction: Direction | None = self.normal
        return direction

    @property
    def amplitudes(self) -> tuple[str, ...]:
        """Names of the parameters that switch off what is periodic in time."""
        return ()

    def limits(self) -> tuple[Limit, ...]:
        """Return the limit at which contact is lost."""
        return ()

    @abstractmethod
    def force(self, u: Expression, v: Expression, c: Symbols, phase: Expression) -> Expression:
        """Return the normal force in N.

        Parameters
        ----------
        u, v
            Displacement in m and velocity in m/s along the normal; None without one.
        c
            The parameters by name.
        phase
            Time divided by the forcing period.
        """

    def rate(self, v: Expression, a: Expression, c: Symbols, phase: Expression) -> Expression:
        """Return the rate of the normal force in N/s; zero unless a subclass says otherwise.

        Parameters
        ----------
        v, a
            Velocity in m/s and acceleration in m/s^2 along the normal; None without one.
        c
            The parameters by name, and ``f`` if the force is periodic in time.
        phase
            Time divided by the forcing period.
        """
        return 0.0


@dataclass(frozen=True)
class ConstantLoad(NormalLoad):
    """A constant normal force.

    Parameters
    ----------
    Ns
        The force in N.
    normal
        Direction in which it pushes the structure; None if the structure cannot move that way.

    Examples
    --------
    >>> ConstantLoad(Ns="2 kN").Ns
    2000.0
    """

    title: ClassVar[str] = "constant load"

    Ns: float = described(_STATIC)

    def force(self, u: Expression, v: Expression, c: Symbols, phase: Expression) -> Expression:
        """``Ns``."""
        return c["Ns"]


@dataclass(frozen=True)
class ModulatedLoad(NormalLoad):
    r"""A normal force that pulsates: :math:`N = N_s + N_d \cos 2\pi h f t`.

    Parameters
    ----------
    Ns
        Its mean in N.
    Nd
        Its amplitude in N, less than `Ns`.
    harmonic
        The whole number h: how often it pulsates in a forcing period.
    normal
        Direction in which it pushes the structure; None if the structure cannot move that way.

    Examples
    --------
    >>> ModulatedLoad(Ns=1, Nd=0.2).Nd
    0.2
    """

    title: ClassVar[str] = "modulated load"

    Ns: float = described(_STATIC)
    Nd: float = described(
        Parameter("Nd", 0.0, "N", "amplitude of the normal force's pulsation", 0, symbol="$N_d$")
    )
    harmonic: int = 1

    def prepare(self) -> None:
        """Read the direction and the harmonic."""
        super().prepare()
        object.__setattr__(self, "harmonic", checked_harmonic(self.harmonic, self.title))

    def check(self, values: Mapping[str, float]) -> None:
        """Refuse a pulsation that would lift the structure off."""
        if values["Nd"] >= values["Ns"]:
            raise InputError(
                f"Nd = {values['Nd']:g} N is not below Ns = {values['Ns']:g} N, so the contact "
                "would open; give Nd < Ns"
            )

    @property
    def amplitudes(self) -> tuple[str, ...]:
        """``Nd``."""
        return ("Nd",)

    def limits(self) -> tuple[Limit, ...]:
        """Return the limit at which contact is lost."""
        reason = "lost contact: the normal force fell to {value:.3g} N; keep Nd < Ns"
        return (Limit("lost contact", "N", LOST, reason),)

    def force(self, u: Expression, v: Expression, c: Symbols, phase: Expression) -> Expression:
        """``Ns + Nd cos(2 pi h f t)``."""
        return c["Ns"] + c["Nd"] * wave(self.harmonic, phase)[0]

    def rate(self, v: Expression, a: Expression, c: Symbols, phase: Expression) -> Expression:
        """``-2 pi h f Nd sin(2 pi h f t)``."""
        frequency = 2 * math.pi * self.harmonic * c["f"]
        return -frequency * c["Nd"] * wave(self.harmonic, phase)[1]


@dataclass(frozen=True)
class ContactLoad(NormalLoad):
    r"""A normal force from the contact's stiffness: :math:`N = N_s - k_n u_n - c_n \dot u_n`.

    It couples the normal motion with friction, from which squeal by mode coupling comes.

    Parameters
    ----------
    normal
        Degree of freedom, or weights by name: the direction away from the counter-body.
    Ns
        Normal force at zero displacement in N.
    kn
        Stiffness of the contact in N/m.
    cn
        Damping of the contact in N s/m.

    References
    ----------
    N. Hoffmann, M. Fischer, R. Allgaier and L. Gaul, A minimal model for studying properties of the
    mode-coupling type instability in friction induced oscillations, Mechanics Research
    Communications 29 (2002) 197-205.

    Examples
    --------
    >>> ContactLoad("y", Ns=10, kn=1e4).direction
    Direction(weights=(('y', 1.0),))
    """

    title: ClassVar[str] = "contact load"

    opens: ClassVar[bool] = True

    normal: Any
    Ns: float = described(_STATIC)
    kn: float = described(
        Parameter("kn", 1.0, "N/m", "normal stiffness of a contact", 0, symbol="$k_n$")
    )
    cn: float = described(
        Parameter("cn", 0.0, "N s/m", "normal damping of a contact", 0, symbol="$c_n$")
    )

    def prepare(self) -> None:
        """Refuse a load without a direction."""
        if self.normal is None:
            raise InputError(
                "a contact load needs the direction that it depends on; give normal, such as "
                'normal="y", or take a ConstantLoad'
            )
        super().prepare()

    @property
    def own_parameters(self) -> tuple[Parameter, ...]:
        """``Ns`` of any sign but the contact must be pressed: ``N`` is watched instead."""
        return tuple(
            replace(item, lower=-float("inf"), lower_open=False) if item.name == "Ns" else item
            for item in super().own_parameters
        )

    def limits(self) -> tuple[Limit, ...]:
        """Return the limit at which contact is lost."""
        reason = (
            "lost contact: the normal force fell to {value:.3g} N; simulate and response go on in "
            "free flight, with an exact law of friction; press harder or stay below this value"
        )
        return (Limit("lost contact", "N", LOST, reason),)

    def force(self, u: Expression, v: Expression, c: Symbols, phase: Expression) -> Expression:
        """``Ns - kn u - cn v``."""
        return c["Ns"] - c["kn"] * u - c["cn"] * v

    def rate(self, v: Expression, a: Expression, c: Symbols, phase: Expression) -> Expression:
        """``-kn v - cn a``."""
        return -c["kn"] * v - c["cn"] * a
