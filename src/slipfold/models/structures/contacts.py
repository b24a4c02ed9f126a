"""Friction contacts of a structure, and what presses them."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, Self

import heyoka as hy

from slipfold.errors import InputError
from slipfold.models.friction.law import FrictionLaw
from slipfold.models.friction.quantities import declared, described
from slipfold.models.friction.without_memory import Coulomb
from slipfold.models.output import (
    PULSATING_LIMIT,
    STICK_LIMIT,
    Contact,
    Expression,
    Limit,
    Output,
    Symbols,
)
from slipfold.models.parameter import Parameter, State, nonnegative, positive
from slipfold.models.structures.component import (
    Component,
    Direction,
    Forces,
    Motion,
    Parametric,
    as_direction,
    as_directions,
    checked_harmonic,
    cos_sin,
    shown,
    total,
    wave,
)

_STATIC = positive("Ns", 1.0, "N", "static normal force", "$N_s$")


@dataclass(frozen=True)
class NormalLoad(Parametric, ABC):
    """The normal force of a contact, which may push the structure along a direction `normal`."""

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
        nonnegative("Nd", 0.0, "N", "amplitude of the normal force's pulsation", "$N_d$")
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
        return (PULSATING_LIMIT,)

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
        Degree of freedom, or weights by name: the direction away from the moving surface.
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
    kn: float = described(nonnegative("kn", 1.0, "N/m", "normal stiffness of a contact", "$k_n$"))
    cn: float = described(nonnegative("cn", 0.0, "N s/m", "normal damping of a contact", "$c_n$"))

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
            "lost contact: the normal force fell to {value:.3g} N; simulate and response continue "
            "in free flight, with an exact law of friction; press harder or stay below this value"
        )
        return (replace(PULSATING_LIMIT, reason=reason),)

    def force(self, u: Expression, v: Expression, c: Symbols, phase: Expression) -> Expression:
        """``Ns - kn u - cn v``."""
        return c["Ns"] - c["kn"] * u - c["cn"] * v

    def rate(self, v: Expression, a: Expression, c: Symbols, phase: Expression) -> Expression:
        """``-kn v - cn a``."""
        return -c["kn"] * v - c["cn"] * a


@dataclass(frozen=True)
class FrictionContact(Component):
    r"""A contact that slides on a moving surface: friction along the slip, and a normal force.

    .. math::

        F = N \mu(|v|) v/|v|, \qquad v = V_d (\cos\alpha, \sin\alpha) - \dot u

    with the displacement u of the structure along one or two directions; along one
    :math:`v = V_d - \dot u`.

    Parameters
    ----------
    along
        One or two directions at right angles in which the contact slides: degrees of freedom, or
        weights by name.
    law
        Friction law; its parameters are parameters of the contact.
    load
        Normal force; a number in N is a constant one.
    Vd
        Speed of the moving surface in m/s; 0 is a wall.
    alpha
        Direction of its motion from the first direction towards the second, in rad; with one
        direction there is none.
    name
        Tells contacts apart; empty if there is one only.

    Examples
    --------
    >>> from slipfold.models.friction import Stribeck
    >>> contact = FrictionContact("tip", Stribeck(mu_s=0.4), load=2.0, Vd=0.5, name="belt")
    >>> [item.name for item in contact.parameters]
    ['Ns_belt', 'Vd_belt', 'mu_s_belt', 'mu_k_belt', 'vs_belt', 's2_belt']
    """

    title: ClassVar[str] = "friction contact"

    along: Any
    law: FrictionLaw = field(default_factory=Coulomb, metadata={"entry": "friction"})
    load: Any = field(default_factory=ConstantLoad)
    Vd: float = described(nonnegative("Vd", 1.0, "m/s", "speed of the moving surface", "$V_d$"))
    alpha: float = described(
        Parameter(
            "alpha",
            0.0,
            "rad",
            "direction of the moving surface's motion from the first direction of the contact",
            symbol=r"$\alpha$",
        )
    )

    def prepare(self) -> None:
        """Check directions, law and load."""
        object.__setattr__(self, "along", as_directions(self.along, f"a {self.title}", 2))
        if not isinstance(self.law, FrictionLaw):
            raise InputError(
                f"law = {shown(self.law)} is not a friction law; give one such as Coulomb(mu_k=0.4)"
            )
        if isinstance(self.load, int | float | str):
            force: Any = self.load  # also text with a unit
            object.__setattr__(self, "load", ConstantLoad(force))
        if not isinstance(self.load, NormalLoad):
            raise InputError(
                f"load = {shown(self.load)} is not a normal force; give a number in N, or one such "
                "as ModulatedLoad(Ns=1, Nd=0.1)"
            )
        angle: Any = self.alpha
        straight = isinstance(angle, int | float) and angle == 0
        if not self.planar and not straight:
            raise InputError(
                f"alpha = {shown(self.alpha)} has no meaning for a contact along one direction; "
                "leave it out, or give two directions"
            )
        self._refuse_doubles()

    def _refuse_doubles(self) -> None:
        names = [item.name for item in self.own_parameters]
        for name in names:
            if names.count(name) > 1:
                raise InputError(
                    f"{type(self.law).__name__} calls a parameter {shown(name)}, and so does the "
                    "contact; give the law another name for it"
                )

    @property
    def planar(self) -> bool:
        """Whether it slides in a plane."""
        return len(self.along) == 2

    @property
    def own_parameters(self) -> tuple[Parameter, ...]:
        """Those of the load, speed and direction of the moving surface, those of the law."""
        speed, angle = declared(FrictionContact)
        mine = (speed, angle) if self.planar else (speed,)
        return (*self.load.own_parameters, *mine, *self.law.parameters)

    @property
    def own_values(self) -> dict[str, float]:
        """Values of the parameters by name, in SI units."""
        angle = {"alpha": self.alpha} if self.planar else {}
        return {**self.load.own_values, "Vd": self.Vd, **angle, **self.law.values}

    @property
    def kind(self) -> Self:
        """The contact with default values."""
        return replace(self, law=self.law.kind, load=self.load.kind, Vd=1.0, alpha=0.0)

    def check(self, values: Mapping[str, float]) -> None:
        """Refuse values that contradict each other in the load or the law."""
        self.load.check(values)
        self.law.check(values)

    @property
    def directions(self) -> tuple[Direction | None, ...]:
        """Where it slides, then where it is pressed."""
        normal = self.load.direction
        return tuple(self.along) if normal is None else (*self.along, normal)

    @property
    def amplitudes(self) -> tuple[str, ...]:
        """That of the load."""
        return tuple(self.load.amplitudes)

    def coefficients(self, p: Symbols) -> dict[str, Expression]:
        """Parameters of load and law, and the velocity of the moving surface."""
        result = {item.name: p[item.name] for item in self.own_parameters if item.name != "alpha"}
        if self.memory() and self.amplitudes:
            result["f"] = p["f"]
        if self.planar:
            cos, sin = cos_sin(p["alpha"])
            result |= {"plate_x": p["Vd"] * cos, "plate_y": p["Vd"] * sin}
        return result

    # -- forces --------------------------------------------------------------------------------

    def _plate(self, c: Symbols) -> tuple[Expression, ...]:
        """Return the velocity of the moving surface."""
        return (c["plate_x"], c["plate_y"]) if self.planar else (c["Vd"],)

    def _slip(self, motion: Motion, c: Symbols) -> tuple[Expression, ...]:
        plate = self._plate(c)
        return tuple(w - v for w, v in zip(plate, motion.velocity, strict=False))

    def _normal(self, motion: Motion, c: Symbols, phase: Expression) -> Expression:
        if motion.normal is not None:
            return motion.normal
        place = len(self.along)
        pressed = self.load.direction is not None
        u = motion.displacement[place] if pressed else None
        v = motion.velocity[place] if pressed else None
        return self.load.force(u, v, c, phase)

    def _normal_rate(self, motion: Motion, c: Symbols, phase: Expression) -> Expression:
        place = len(self.along)
        pressed = self.load.direction is not None
        v = motion.velocity[place] if pressed else None
        a = motion.acceleration[place] if pressed else None
        return self.load.rate(v, a, c, phase)

    def _friction(self, motion: Motion, c: Symbols, phase: Expression) -> tuple[Expression, ...]:
        if motion.friction is not None:
            return motion.friction
        slip, normal = self._slip(motion, c), self._normal(motion, c, phase)
        return self.law.force(slip, normal, motion.memory, c)

    def forces(self, motion: Motion, c: Symbols, phase: Expression) -> Forces:
        """Friction along the slip, and the normal force."""
        friction = self._friction(motion, c, phase)
        if self.load.direction is None:
            return friction
        return (*friction, self._normal(motion, c, phase))

    def memory(self) -> tuple[State, ...]:
        """Return the memory of the law."""
        return self.law.memory(len(self.along))

    def memory_rates(self, motion: Motion, c: Symbols, phase: Expression) -> tuple[Expression, ...]:
        """Return the rates of the law's memory, per second."""
        normal, rate = self._normal(motion, c, phase), self._normal_rate(motion, c, phase)
        return self.law.memory_rates(self._slip(motion, c), motion.memory, c, normal, rate)

    def steady_memory(self, values: Mapping[str, float]) -> tuple[float, ...]:
        """Return the law's memory after a long slip; zero where the moving surface is at rest."""
        states = self.memory()
        if not states or not values["Vd"]:
            return (0.0,) * len(states)
        angle = values["alpha"] if self.planar else 0.0
        plate = (values["Vd"] * math.cos(angle), values["Vd"] * math.sin(angle))
        return self._law_of(values).steady_memory(plate[: len(self.along)])

    def memory_scale(self, values: Mapping[str, float]) -> float:
        """Return the typical size of the law's memory."""
        return self._law_of(values).memory_scale

    def _law_of(self, values: Mapping[str, float]) -> FrictionLaw:
        return self.law.replace(**{item.name: values[item.name] for item in self.law.parameters})

    def contact(self, motion: Motion, c: Symbols, phase: Expression) -> Contact | None:
        """Return what a motion that sticks needs of it; None if the law never sticks.

        Parameters
        ----------
        motion
            How the structure moves there.
        c
            The coefficients by their own names.
        phase
            Time divided by the forcing period.
        """
        if not self.law.sticks:
            return None
        return Contact(
            self.key,
            self._slip(motion, c),
            self._plate(c),
            self._normal(motion, c, phase),
            friction=lambda speed: self.law.formula(speed, c),
            holding=self.law.holding(c),
            opens=self.load.opens,
        )

    @property
    def key(self) -> str:
        """What histories call it."""
        return self.name or "contact"

    # -- what is watched -----------------------------------------------------------------------

    def _speed(self, motion: Motion, c: Symbols, phase: Expression) -> Expression:
        return hy.sqrt(total([part * part for part in self._slip(motion, c)]))

    def _speed_ratio(self, motion: Motion, c: Symbols, phase: Expression) -> Expression:
        return self._speed(motion, c, phase) / c["Vd"]

    def _friction_x(self, motion: Motion, c: Symbols, phase: Expression) -> Expression:
        return self._friction(motion, c, phase)[0]

    def _friction_y(self, motion: Motion, c: Symbols, phase: Expression) -> Expression:
        return self._friction(motion, c, phase)[1]

    def _power_plate(self, motion: Motion, c: Symbols, phase: Expression) -> Expression:
        pairs = zip(self._friction(motion, c, phase), self._plate(c), strict=True)
        return total([force * speed for force, speed in pairs])

    def _power_friction(self, motion: Motion, c: Symbols, phase: Expression) -> Expression:
        pairs = zip(self._friction(motion, c, phase), self._slip(motion, c), strict=True)
        return total([force * speed for force, speed in pairs])

    def measures(self) -> tuple[Output, ...]:
        """Return normal force, slip speed, friction force and powers."""
        moved = "$V_{rel}$ (m/s)"
        found = [
            Output("N", self._normal, "N", "normal force of a contact", "$N$ (N)"),
            Output("Vrel", self._speed, "m/s", "slip speed of a contact", moved),
            Output("Fx", self._friction_x, "N", "friction force on the structure", "$F_x$ (N)"),
        ]
        if self.planar:
            doc = "friction force on the structure along the second direction"
            found.append(Output("Fy", self._friction_y, "N", doc, "$F_y$ (N)"))
        if self.law.sticks:
            doc = "slip speed over the moving surface's speed"
            found.append(Output("Vrel_ratio", self._speed_ratio, "", doc, "$V_{rel}/V_d$"))
        doc = "power put in by the moving surface's drive"
        found.append(Output("power_plate", self._power_plate, "W", doc, "$P$ (W)"))
        stored = " and stored in the contact" if self.memory() else ""
        doc = f"power lost to friction heat{stored}"
        found.append(Output("power_friction", self._power_friction, "W", doc, "$P$ (W)"))
        return tuple(found)

    def limits(self) -> tuple[Limit, ...]:
        """Return the limits at which it sticks or opens."""
        return (*self._stick(), *self.load.limits())

    def passed(self) -> tuple[Limit, ...]:
        """Return those of its limits that a motion through stick and free flight passes."""
        return self.limits() if self.load.opens else self._stick()

    def _stick(self) -> tuple[Limit, ...]:
        return (STICK_LIMIT,) if self.law.sticks else ()
