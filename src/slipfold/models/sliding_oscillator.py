"""The source paper's structure: two degrees of freedom, sliding on a moving plate."""

from __future__ import annotations

import math
from collections.abc import Hashable, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, ClassVar, Self

import heyoka as hy
import numpy as np

from slipfold.arrays import Array
from slipfold.errors import InputError
from slipfold.models.friction.contact import Contact, contact_outputs
from slipfold.models.friction.law import FrictionLaw, cos, sin
from slipfold.models.friction.without_memory import Coulomb
from slipfold.models.parametric import described
from slipfold.models.quantities import (
    COLLAPSE_LIMIT,
    PULSATING_LIMIT,
    STICK_LIMIT,
    Expression,
    Output,
    Parameter,
    State,
    Symbols,
    nonnegative,
    positive,
)
from slipfold.models.structures.component import LocalState
from slipfold.models.structures.contacts import FrictionContact, ModulatedLoad
from slipfold.models.unforced import MechanicalModel


@dataclass(frozen=True)
class PaperFriction(FrictionLaw):
    """Coulomb's law with one coefficient."""

    title: ClassVar[str] = "Coulomb"
    rate_independent: ClassVar[bool] = True

    mu: float = described(nonnegative("mu", 0.5, "", "friction coefficient", r"$\mu$"))

    def formula(self, speed: Expression, p: Symbols) -> Expression:
        """``mu``."""
        return p["mu"]


PAPER = PaperFriction()

TIP = "tip_"
"""Beginning of the names of the contact's coefficients."""


@lru_cache(maxsize=64)
def _contact_with(law: FrictionLaw) -> FrictionContact:
    """Return the contact of the tip with the plate, with default values."""
    contact = FrictionContact(along=("x", "y"), law=law, load=ModulatedLoad(), name="tip")
    return contact.kind


OUTPUTS = (
    *("N", "Vrel", "Vrel_ratio", "l", "Fx", "Fy", "friction_direction", "power_plate"),
    *("power_friction", "power_structure", "power_pulsation", "power_damping"),
)

_DIRECTION = "direction of the friction force from the x axis"
_INTO_STRUCTURE = "power friction puts into the structure: plate less heat"
_DAMPED = "power lost to structural damping"
_LENGTH = "length of the spring over L"
_PULSATION = "fraction of power_structure due to the pulsating part of the normal force"


def spring_length_squared(q: Symbols) -> Expression:
    """Return the square of l/L."""
    height = 1.0 + q["y"]
    return height * height + q["x"] * q["x"]


def _damping_power(q: Symbols, c: Symbols, phase: Expression) -> Expression:
    lost_y = c["m1"] * c["damping1"] * q["vy"] * q["vy"]
    lost_x = c["m2"] * c["damping2"] * q["vx"] * q["vx"]
    return c["L"] * c["L"] * (lost_x + lost_y)


class SlidingOscillator(MechanicalModel):
    r"""Two-degree-of-freedom oscillator pressed on a moving plate by a pulsing normal force.

    .. math::

        m_1 \ddot y + c_1 \dot y + k_1 y + k_{ext}(l-L)(L+y)/l
            &= \mu N(t) (V_d \sin\alpha - \dot y)/V_{rel} \\
        m_2 \ddot x + c_2 \dot x + k_2 x + k_{ext}(l-L) x/l
            &= \mu N(t) (V_d \cos\alpha - \dot x)/V_{rel}

    with :math:`N = N_s + N_d \cos 2\pi f t`, equations (1)-(7) of the source paper. The states are
    ``x y vx vy``: x/L, y/L and their rates in 1/s. The phase is zero where N is largest.

    Another friction law takes the place of :math:`\mu`: its coefficient depends on
    :math:`V_{rel}`, its parameters become parameters of the oscillator, and where it has a memory
    (Dahl, LuGre, Bouc-Wen, Jenkins) its deflections ``zx zy`` are further states.

    Parameters
    ----------
    friction
        Friction law, such as ``Stribeck(vs=0.2)``; Coulomb's with the parameter ``mu`` if None.
    **values
        ``k1 zeta1 f1 k2 zeta2 f2 kext L f Nd Ns mu alpha Vd`` where they differ from the paper's
        base case; SI units (``alpha`` in rad), or text with a unit (``alpha="60deg"``). With a
        friction law its parameters stand in place of ``mu``; a value given here goes before the
        law's own.

    Raises
    ------
    InputError
        For an unknown parameter, a wrong unit, a value outside its bounds, ``Nd >= Ns`` or a
        friction law that cannot be used.

    Examples
    --------
    >>> model = SlidingOscillator(Nd=0.1, alpha="60deg")
    >>> model.replace(f=12.2)
    SlidingOscillator(f=12.2, Nd=0.1)
    >>> from slipfold import RationalStribeck
    >>> SlidingOscillator(friction=RationalStribeck(mu_s=0.4, d=2.0)).replace(d=1.5, Nd=0.1)
    SlidingOscillator(friction=RationalStribeck(mu_s=0.4, d=1.5), Nd=0.1)
    """

    name = "sliding"
    title = "structure sliding on a moving plate, 2:1 internal resonance"
    forcing_amplitude = "Nd"
    states = (
        State("x", "", "horizontal displacement over L", "$x/L$"),
        State("y", "", "vertical displacement over L", "$y/L$"),
        State("vx", "1/s", "rate of x/L", r"$\dot x/L$ (1/s)"),
        State("vy", "1/s", "rate of y/L", r"$\dot y/L$ (1/s)"),
    )
    parameters = (
        positive("k1", 317.98, "N/m", "vertical stiffness", "$k_1$"),
        nonnegative("zeta1", 0.006, "", "vertical damping ratio", r"$\zeta_1$"),
        positive("f1", 6.12, "Hz", "vertical natural frequency without the spring", "$f_1$"),
        positive("k2", 362.58, "N/m", "horizontal stiffness", "$k_2$"),
        nonnegative("zeta2", 0.0057, "", "horizontal damping ratio", r"$\zeta_2$"),
        positive("f2", 6.59, "Hz", "horizontal natural frequency without the spring", "$f_2$"),
        nonnegative("kext", 1000.0, "N/m", "stiffness of the coupling spring", "$k_{ext}$"),
        positive("L", 5e-3, "m", "length of the unstretched spring", "$L$"),
        positive("f", 12.5, "Hz", "frequency of the normal force", "$f$"),
        nonnegative("Nd", 0.0, "N", "amplitude of the normal force's pulsation", "$N_d$"),
        positive("Ns", 1.0, "N", "static normal force", "$N_s$"),
        *PAPER.parameters,
        Parameter(
            "alpha",
            math.pi / 3,
            "rad",
            "direction of the plate's motion from the x axis",
            symbol=r"$\alpha$",
        ),
        nonnegative("Vd", 0.6, "m/s", "speed of the plate", "$V_d$"),
    )
    limits = (STICK_LIMIT, PULSATING_LIMIT, COLLAPSE_LIMIT)

    _contact: FrictionContact = _contact_with(PAPER)

    def __init__(self, friction: FrictionLaw | None = None, **values: float | str) -> None:
        if friction is not None:
            self._adopt(friction)
            values = {**friction.values, **values}
        super().__init__(**values)

    def _adopt(self, law: FrictionLaw) -> None:
        """Take over parameters, memory and limits of a friction law."""
        cls = type(self)
        if not isinstance(law, FrictionLaw):
            raise InputError(
                f"friction = {law!r} is not a friction law; give one such as Coulomb(mu_k=0.4), or "
                "mu=0.4 alone"
            )
        kept = tuple(item for item in cls.parameters if item.name != "mu")
        taken = {"friction", *OUTPUTS, *(item.name for item in kept), *(s.name for s in cls.states)}
        own = [item.name for item in law.parameters] + [item.name for item in law.memory(2)]
        for name in own:
            if name in taken:
                raise InputError(
                    f"{type(law).__name__} calls something {name!r}, and so does {self.name}; "
                    "give the law another name for it"
                )
        self._take(
            _contact=_contact_with(law.kind),
            parameters=(*kept, *law.parameters),
            states=(*cls.states, *law.memory(2)),
            limits=tuple(item for item in cls.limits if law.sticks or item != STICK_LIMIT),
        )

    @property
    def _law(self) -> FrictionLaw:
        """The friction law with default values."""
        return self._contact.law

    @property
    def surface_speeds(self) -> Mapping[str, bool]:
        """``Vd``."""
        return {"Vd": self._law.sticks}

    @property
    def structure(self) -> Mapping[str, Hashable]:
        """The friction law with default values: its own values are among the parameters."""
        return {} if self._law == PAPER else {"friction": self._law}

    @property
    def friction(self) -> FrictionLaw:
        """The friction law with its present values."""
        if self._law == PAPER:
            return Coulomb(mu_s=self._values["mu"], mu_k=self._values["mu"])
        return self._contact._law_with(self._values)

    def replace(self, **changes: Any) -> Self:
        """Return a new model with some parameters changed, or with another friction law.

        Parameters
        ----------
        **changes
            New values by name, numbers in SI units or text with a unit. With ``friction=`` another
            law comes with its values, with ``friction=None`` Coulomb's with the base case's ``mu``.
        """
        if "friction" not in changes:
            return super().replace(**changes)
        own = self._law.values
        kept = {name: value for name, value in self._values.items() if name not in own}
        return type(self)(**{**kept, **changes})

    def __repr__(self) -> str:
        """Constructor call with the law and the parameters that differ from the defaults."""
        if not self.structure:
            return super().__repr__()
        own = self._law.values
        given = [
            f"{item.name}={self._values[item.name]:.12g}"
            for item in self.parameters
            if item.name not in own and self._values[item.name] != item.default
        ]
        return f"{type(self).__name__}({', '.join([f'friction={self.friction!r}', *given])})"

    def check(self, values: Mapping[str, float]) -> None:
        """Refuse a pulsation that would lift the tip off the plate."""
        if values["Nd"] >= values["Ns"]:
            raise InputError(
                f"Nd = {values['Nd']:g} N is not below Ns = {values['Ns']:g} N, so the tip would "
                "lift off the plate; give Nd < Ns"
            )
        self._law.check(values)

    def coefficients(self, p: Symbols) -> dict[str, Expression]:
        """Mass-normalized stiffness, damping, friction and plate velocity."""
        w1, w2 = 2 * math.pi * p["f1"], 2 * math.pi * p["f2"]
        m1, m2 = p["k1"] / (w1 * w1), p["k2"] / (w2 * w2)
        return {
            "L": p["L"],
            "m1": m1,
            "m2": m2,
            "damping1": 2 * p["zeta1"] * w1,
            "damping2": 2 * p["zeta2"] * w2,
            "stiffness1": w1 * w1,
            "stiffness2": w2 * w2,
            "spring1": p["kext"] / m1,
            "spring2": p["kext"] / m2,
            "push_static": p["Ns"] / (m2 * p["L"]),
            "push_pulsing": p["Nd"] / (m2 * p["L"]),
            "mass_ratio": m2 / m1,
            "drive_x": p["Vd"] * cos(p["alpha"]) / p["L"],
            "drive_y": p["Vd"] * sin(p["alpha"]) / p["L"],
            **{f"{TIP}{key}": part for key, part in self._contact._coefficients(p).items()},
        }

    def rates(self, q: Symbols, c: Symbols, phase: Expression) -> dict[str, Expression]:
        """Equations of motion (1)-(2) of the source paper, divided by mass and L."""
        tip = self._tip(q, c, phase)
        push_x, push_y = self._pushed(tip, q, c, phase)
        stretch = 1.0 - spring_length_squared(q) ** -0.5
        memory = zip(self._law.memory(2), tip.memory_rates, strict=True)
        return {
            "x": q["vx"],
            "y": q["vy"],
            "vx": push_x
            - c["damping2"] * q["vx"]
            - (c["stiffness2"] + c["spring2"] * stretch) * q["x"],
            "vy": push_y
            - c["damping1"] * q["vy"]
            - c["stiffness1"] * q["y"]
            - c["spring1"] * stretch * (1.0 + q["y"]),
            **{state.name: rate for state, rate in memory},
        }

    def _pushed(
        self, tip: Contact, q: Symbols, c: Symbols, phase: Expression
    ) -> tuple[Expression, Expression]:
        """Return the accelerations over L by friction, with the minimum of products."""
        if tip.given:
            x, y = (part / (c["m2"] * c["L"]) for part in tip.given)
            return x, c["mass_ratio"] * y
        load = LocalState(q, {"Ns": c["push_static"], "Nd": c["push_pulsing"]}, phase, u=(), v=())
        tip = replace(tip, normal=self._contact.load._force(load))
        if self._law.rate_independent:
            tip = replace(tip, slip=(c["drive_x"] - q["vx"], c["drive_y"] - q["vy"]))
        x, y = tip.force
        return x, c["mass_ratio"] * y

    def _tip(self, q: Symbols, c: Symbols, phase: Expression) -> Contact:
        """Return the contact of tip and plate."""
        own = {key.removeprefix(TIP): part for key, part in c.items() if key.startswith(TIP)}
        memory = tuple(q[state.name] for state in self._contact.memory())
        zero = (0.0, 0.0)
        local = LocalState(q, own, phase, zero, zero, memory, a=zero if memory else ())
        # Drive and velocity are subtracted over L, as in the rates.
        slip = (c["L"] * (c["drive_x"] - q["vx"]), c["L"] * (c["drive_y"] - q["vy"]))
        return replace(self._contact._contact(local), slip=slip, limits=(STICK_LIMIT.name,))

    def contacts(self, q: Symbols, c: Symbols, phase: Expression) -> tuple[Contact, ...]:
        """Return the tip on the plate, unless its law never sticks."""
        return (self._tip(q, c, phase),) if self._law.sticks else ()

    def period(self, p: Symbols) -> Expression:
        """Return the forcing period 1/f in seconds."""
        return 1.0 / p["f"]

    @property
    def start(self) -> Array:
        """Zero, with the memory that a friction law has after a long slip at the plate's speed."""
        return np.array([0.0, 0.0, 0.0, 0.0, *self._contact._steady_memory(self._values)])

    def declared_scales(self) -> Array:
        """Displacements of order L, rates of order 2 pi f, memory as the law says."""
        rate = 2 * math.pi * self._values["f"]
        memory = [self.friction.memory_scale for _ in self.states[4:]]
        return np.array([1.0, 1.0, rate, rate, *memory])

    def outputs(self) -> tuple[Output, ...]:
        """Normal force, friction, relative speed, spring length and powers."""
        outputs = contact_outputs(self._tip, self._law, 2)
        for item in (
            Output("l", lambda q, *_: hy.sqrt(spring_length_squared(q)), "", _LENGTH, "$l/L$"),
            Output("friction_direction", self._direction, "rad", _DIRECTION, r"$\arg F$ (rad)"),
            Output("power_structure", self._structure_power, "W", _INTO_STRUCTURE, "$P$ (W)"),
            Output("power_pulsation", self._pulsation_power, "W", _PULSATION, "$P$ (W)"),
            Output("power_damping", _damping_power, "W", _DAMPED, "$P$ (W)"),
        ):
            outputs[item.name] = item
        return tuple(outputs[name] for name in OUTPUTS)

    def _direction(self, q: Symbols, c: Symbols, phase: Expression) -> Expression:
        tip = self._tip(q, c, phase)
        # Without memory the force lies along the slip, which takes less to compute.
        x, y = tip.force if tip.given or tip.memory else tip.slip
        return hy.atan2(y, x)

    def _structure_power(self, q: Symbols, c: Symbols, phase: Expression) -> Expression:
        return self._tip(q, c, phase).power((c["L"] * q["vx"], c["L"] * q["vy"]))

    def _pulsation_power(self, q: Symbols, c: Symbols, phase: Expression) -> Expression:
        pulsation = c[f"{TIP}Nd"] * hy.cos(2 * math.pi * phase)
        return self._structure_power(q, c, phase) * pulsation / self._tip(q, c, phase).normal

    # -- quantities that do not depend on the state ----------------------------------------------

    @property
    def m1(self) -> float:
        """Vertical modal mass in kg: k1/(2 pi f1)^2."""
        return self._values["k1"] / (2 * math.pi * self._values["f1"]) ** 2

    @property
    def m2(self) -> float:
        """Horizontal modal mass in kg: k2/(2 pi f2)^2."""
        return self._values["k2"] / (2 * math.pi * self._values["f2"]) ** 2

    @property
    def c1(self) -> float:
        """Vertical damping in N s/m: 4 pi zeta1 m1 f1."""
        return 4 * math.pi * self._values["zeta1"] * self.m1 * self._values["f1"]

    @property
    def c2(self) -> float:
        """Horizontal damping in N s/m: 4 pi zeta2 m2 f2."""
        return 4 * math.pi * self._values["zeta2"] * self.m2 * self._values["f2"]
