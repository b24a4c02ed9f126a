"""Friction contacts of a structure and their normal forces."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import heyoka as hy

from slipfold.errors import InputError
from slipfold.models.formulas.values import as_symbol
from slipfold.models.friction.contact import Contact, contact_outputs
from slipfold.models.friction.law import FrictionLaw, cos, sin, sqrt
from slipfold.models.friction.without_memory import Coulomb
from slipfold.models.parametric import Parametric, declared, described, structural
from slipfold.models.quantities import (
    PULSATING_LIMIT,
    STICK_LIMIT,
    Expression,
    Limit,
    Output,
    Parameter,
    State,
    Symbols,
    nonnegative,
    positive,
)
from slipfold.models.structures.component import (
    Component,
    Direction,
    Forces,
    LocalState,
    as_direction,
    as_directions,
    brief,
    checked_harmonic,
    total,
)
from slipfold.models.units import parse_quantity

_STATIC = positive("Ns", 1.0, "N", "static normal force", "$N_s$")


@dataclass(frozen=True)
class NormalLoad(Parametric, ABC):
    """The normal force of a contact, which may push the structure along a direction `normal`."""

    title: ClassVar[str] = "normal load"

    opens: ClassVar[bool] = False
    """Whether the force may vanish in motion."""

    amplitudes: ClassVar[tuple[str, ...]] = ()
    """Names of the parameters that switch off what is periodic in time."""

    limits: ClassVar[tuple[Limit, ...]] = ()
    """The limit at which contact is lost."""

    normal: Any = structural(
        "direction in which it pushes the structure; None if it cannot move that way",
        None,
        as_direction,
        kw_only=True,
    )

    @abstractmethod
    def _force(self, local: LocalState) -> Expression:
        """Return the normal force in N."""

    def _rate(self, local: LocalState) -> Expression:
        """Return the rate of the normal force in N/s."""
        u, v, phase = (hy.expression(name) for name in ("u", "v", "phase"))
        moves = bool(local.u)
        at = replace(local, u=(u,) if moves else (), v=(v,) if moves else (), phase=phase)
        force = as_symbol(self._force(at))
        terms = [(phase, local.c["f"])] if self.amplitudes else []
        terms += [(u, local.v[0]), (v, local.a[0])] if moves else []
        rate = total([hy.diff(force, symbol) * slope for symbol, slope in terms])
        known = {"u": local.u[0], "v": local.v[0]} if moves else {}
        return hy.subs(rate, {**known, "phase": local.phase})


@dataclass(frozen=True)
class ConstantLoad(NormalLoad):
    """A constant normal force.

    Examples
    --------
    >>> ConstantLoad(Ns="2 kN").Ns
    2000.0
    """

    title: ClassVar[str] = "constant load"

    Ns: float = described(_STATIC)

    def _force(self, local: LocalState) -> Expression:
        return local.c["Ns"]


@dataclass(frozen=True)
class ModulatedLoad(NormalLoad):
    r"""A normal force that pulsates: :math:`N = N_s + N_d \cos 2\pi h f t`, h being `harmonic`.

    `Nd` is less than `Ns`.

    Examples
    --------
    >>> ModulatedLoad(Ns=1, Nd=0.2).Nd
    0.2
    """

    title: ClassVar[str] = "modulated load"
    amplitudes: ClassVar[tuple[str, ...]] = ("Nd",)
    limits: ClassVar[tuple[Limit, ...]] = (PULSATING_LIMIT,)

    Ns: float = described(_STATIC)
    Nd: float = described(
        nonnegative("Nd", 0.0, "N", "amplitude of the normal force's pulsation", "$N_d$")
    )
    harmonic: int = structural(
        "number of pulsations in a forcing period, a whole number", 1, checked_harmonic
    )

    def check(self, values: Mapping[str, float]) -> None:
        """Refuse a pulsation that would lift the structure off."""
        if values["Nd"] >= values["Ns"]:
            raise InputError(
                f"Nd = {values['Nd']:g} N is not below Ns = {values['Ns']:g} N, so the contact "
                "would open; give Nd < Ns"
            )

    def _force(self, local: LocalState) -> Expression:
        return local.c["Ns"] + local.c["Nd"] * cos(2 * math.pi * self.harmonic * local.phase)


@dataclass(frozen=True)
class ContactLoad(NormalLoad):
    r"""A normal force from the contact's stiffness: :math:`N = N_s - k_n u_n - c_n \dot u_n`.

    It couples the normal motion with friction, from which squeal by mode coupling comes.

    References
    ----------
    N. Hoffmann, M. Fischer, R. Allgaier and L. Gaul, A minimal model for studying properties of the
    mode-coupling type instability in friction induced oscillations, Mechanics Research
    Communications 29 (2002) 197-205.

    Examples
    --------
    >>> ContactLoad("y", Ns=10, kn=1e4).normal
    Direction(weights=(('y', 1.0),))
    """

    title: ClassVar[str] = "contact load"
    opens: ClassVar[bool] = True
    limits: ClassVar[tuple[Limit, ...]] = (
        replace(
            PULSATING_LIMIT,
            reason="lost contact: the normal force fell to {value:.3g} N; simulate and response "
            "continue in free flight, with an exact law of friction; with another law give a "
            "ComplianceLoad, press harder or stay below this value",
        ),
    )

    normal: Any = structural(
        "degree of freedom, or weights by name: the direction away from the moving surface",
        read=as_direction,
    )
    # Of any sign: the contact must be pressed, but by the force as a whole.
    Ns: float = described(
        Parameter("Ns", 1.0, "N", "normal force at zero displacement", symbol="$N_s$")
    )
    kn: float = described(nonnegative("kn", 1.0, "N/m", "normal stiffness of a contact", "$k_n$"))
    cn: float = described(nonnegative("cn", 0.0, "N s/m", "normal damping of a contact", "$c_n$"))

    def _force(self, local: LocalState) -> Expression:
        (u,), (v,), c = local.u, local.v, local.c
        return c["Ns"] - c["kn"] * u - c["cn"] * v


def _checked_exponent(value: Any, title: str) -> float:
    number = parse_quantity(value, "", "exponent")
    if not 1 <= number <= MAX_EXPONENT:
        raise InputError(
            f"a {title} has the exponent {brief(value)}; give a number from 1 to {MAX_EXPONENT:g}"
        )
    return number


MAX_EXPONENT = 10.0
"""Highest exponent of a compliance: measured ones are between 1 and 3.5."""


@dataclass(frozen=True)
class ComplianceLoad(NormalLoad):
    r"""A normal force that grows with a power of the approach: normal compliance.

    .. math::

        N = N_s \Bigl(\frac{s(d - u_n)}{d}\Bigr)^m, \qquad
        s(w) = \tfrac12 \bigl(w + \sqrt{w^2 + \varepsilon^2}\bigr)

    with the displacement :math:`u_n` away from the surface, the force :math:`N_s` at rest, the
    approach d there and the exponent m. With m = 1 it is a unilateral spring of the stiffness
    :math:`N_s/d`. Separation is rounded off as with a `GapSpring`, so that the force never
    vanishes: motion goes on through contact and separation with any friction law.

    References
    ----------
    J. A. C. Martins and J. T. Oden, Existence and uniqueness results for dynamic contact problems
    with nonlinear normal and friction interface laws, Nonlinear Analysis 11 (1987) 407-428.

    Examples
    --------
    >>> ComplianceLoad("y", Ns=10, d="5um", en="0.1um", exponent=2).exponent
    2.0
    """

    title: ClassVar[str] = "compliance load"

    normal: Any = structural(
        "degree of freedom, or weights by name: the direction away from the surface",
        read=as_direction,
    )
    Ns: float = described(_STATIC)
    d: float = described(positive("d", 1.0, "m", "approach of the surfaces at rest", "$d$"))
    en: Any = described(
        positive("en", 1.0, "m", "length over which separation is rounded off", r"$\varepsilon_n$"),
        None,
    )
    exponent: float = structural("power m of the approach, from 1 to 10", 1.0, _checked_exponent)

    def prepare(self) -> None:
        """Refuse exact separation."""
        if self.en is None:
            raise InputError(
                "a compliance load without en has a corner where the surfaces part; give en, the "
                "length over which it is rounded off, or a ContactLoad, which opens exactly"
            )

    def _force(self, local: LocalState) -> Expression:
        (u,), c = local.u, local.c
        way = c["d"] - u
        pressed = (way + sqrt(way * way + c["en"] * c["en"])) / (2.0 * c["d"])
        return c["Ns"] * (pressed if self.exponent == 1 else pressed**self.exponent)


def _load(value: Any, title: str) -> Any:
    """Return a normal load; a number, or text with a unit, is a constant one."""
    return ConstantLoad(value) if isinstance(value, int | float | str) else value


@dataclass(frozen=True)
class FrictionContact(Component):
    r"""A contact that slides on a moving surface: friction along the slip, and a normal force.

    .. math::

        F = N \mu(|v|) v/|v|, \qquad v = V_d (\cos\alpha, \sin\alpha) - \dot u

    with the displacement u of the structure along one or two directions; along one
    :math:`v = V_d - \dot u` and there is no angle. A surface at rest is a wall.

    Examples
    --------
    >>> from slipfold import Stribeck
    >>> contact = FrictionContact("tip", Stribeck(mu_s=0.4), load=2.0, Vd=0.5)
    >>> [item.name for item in contact.parameters]
    ['Ns', 'Vd', 'mu_s', 'mu_k', 'vs', 's2']
    """

    title: ClassVar[str] = "friction contact"

    along: Any = structural(
        "one or two directions at right angles in which the contact slides: degrees of freedom, or "
        "weights by name",
        read=as_directions,
    )
    law: FrictionLaw = structural(
        "friction law; its parameters are parameters of the contact",
        default_factory=Coulomb,
        metadata={"entry": "friction"},
    )
    load: Any = structural(
        "normal force; a number in N is a constant one", read=_load, default_factory=ConstantLoad
    )
    Vd: float = described(
        Parameter("Vd", 1.0, "m/s", "velocity of the moving surface", symbol="$V_d$")
    )
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
        """Check law, load and the direction of the moving surface."""
        if not isinstance(self.law, FrictionLaw):
            raise InputError(
                f"law = {brief(self.law)} is not a friction law; give one such as Coulomb(mu_k=0.4)"
            )
        if not isinstance(self.load, NormalLoad):
            raise InputError(
                f"load = {brief(self.load)} is not a normal force; give a number in N, or one such "
                "as ModulatedLoad(Ns=1, Nd=0.1)"
            )
        angle: Any = self.alpha
        straight = isinstance(angle, int | float) and angle == 0
        if not self.planar and not straight:
            raise InputError(
                f"alpha = {brief(self.alpha)} has no meaning for a contact along one direction; "
                "leave it out, or give two directions"
            )
        names = [item.name for item in self.parameters]
        for name in names:
            if names.count(name) > 1:
                raise InputError(
                    f"{type(self.law).__name__} calls a parameter {brief(name)}, and so does the "
                    "contact; give the law another name for it"
                )

    def _pairs(self) -> Iterator[tuple[Parameter, float]]:
        speed, angle = declared(FrictionContact)
        yield from self.load._pairs()
        yield speed, self.Vd
        if self.planar:
            yield angle, self.alpha
        yield from self.law._pairs()

    @property
    def planar(self) -> bool:
        """Whether it slides in a plane."""
        return len(self.along) == 2

    @property
    def key(self) -> str:
        """Name of the contact in histories."""
        return self.label or "contact"

    @property
    def _directions(self) -> tuple[Direction | None, ...]:
        normal = self.load.normal
        return tuple(self.along) if normal is None else (*self.along, normal)

    @property
    def _amplitudes(self) -> tuple[str, ...]:
        return tuple(self.load.amplitudes)

    def _coefficients(self, p: Symbols) -> dict[str, Expression]:
        """Parameters of load and law, and the velocity of the moving surface."""
        result = {item.name: p[item.name] for item in self.parameters if item.name != "alpha"}
        if self.memory() and self._amplitudes:
            result["f"] = p["f"]
        if self.planar:
            result |= {"plate_x": p["Vd"] * cos(p["alpha"]), "plate_y": p["Vd"] * sin(p["alpha"])}
        return result

    # -- equations -----------------------------------------------------------------------------

    def _contact(self, local: LocalState, *_: Any) -> Contact:
        """Return the contact in symbols."""
        c, size = local.c, len(self.along)
        plate = (c["plate_x"], c["plate_y"]) if self.planar else (c["Vd"],)
        passed = self.limits() if self.load.opens else self._stick  # by stick and free flight
        across = replace(local, u=local.u[size:], v=local.v[size:], a=local.a[size:])
        return Contact(
            slip=tuple(w - v for w, v in zip(plate, local.v, strict=False)),
            memory=local.memory,
            normal=self.load._force(across),
            normal_rate=self.load._rate(across) if local.a else 0.0,
            name=self.key,
            plate=plate,
            plate_speed=sqrt(c["Vd"] * c["Vd"]),
            law=self.law,
            values=c,
            opens=self.load.opens,
            limits=tuple(map(self._limit_name, passed)),
        ).in_states(local.q)

    def _forces(self, local: LocalState) -> Forces:
        """Friction along the slip, and the normal force."""
        contact = self._contact(local)
        return contact.force if self.load.normal is None else (*contact.force, contact.normal)

    def memory(self) -> tuple[State, ...]:
        """Return the memory of the law."""
        return self.law.memory(len(self.along))

    def _steady_memory(self, values: Mapping[str, float]) -> tuple[float, ...]:
        """Return the law's memory after a long slip on the moving surface."""
        angle = values["alpha"] if self.planar else 0.0
        plate = (values["Vd"] * math.cos(angle), values["Vd"] * math.sin(angle))
        return self._law_with(values).steady_memory(plate[: len(self.along)])

    def _law_with(self, values: Mapping[str, float]) -> FrictionLaw:
        """Return the law with parameter values."""
        return self.law.replace(**{name: values[name] for name in self.law.values})

    # -- outputs and limits --------------------------------------------------------------------

    def _measures(self) -> tuple[Output, ...]:
        outputs = contact_outputs(self._contact, self.law, len(self.along))
        return tuple(
            output for name, output in outputs.items() if name != "Vrel_ratio" or self.law.sticks
        )

    def limits(self) -> tuple[Limit, ...]:
        """Return the limits at which it sticks or opens."""
        return (*self._stick, *self.load.limits)

    @property
    def _stick(self) -> tuple[Limit, ...]:
        return (STICK_LIMIT,) if self.law.sticks else ()
