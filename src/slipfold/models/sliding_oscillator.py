"""The source paper's structure: two degrees of freedom, sliding on a moving plate."""

from __future__ import annotations

import math
from collections.abc import Hashable, Mapping
from dataclasses import replace
from functools import partial
from typing import Any, Self

import heyoka as hy
import numpy as np
from numpy.typing import NDArray

from slipfold.errors import InputError
from slipfold.models.equilibria import find_static_point
from slipfold.models.friction import Coulomb, FrictionLaw
from slipfold.models.linear_modes import Modes, find_modes
from slipfold.models.model import Model, evaluation_of
from slipfold.models.output import (
    COLLAPSE_LIMIT,
    PULSATING_LIMIT,
    STICK_LIMIT,
    Contact,
    Expression,
    Output,
    Symbols,
    friction_name,
    normal_name,
)
from slipfold.models.parameter import Parameter, State, nonnegative, positive
from slipfold.models.structures.component import cos_sin
from slipfold.models.unforced import Unforced

TIP = "tip"
"""The contact of tip and plate."""

LAW_PREFIX = "law_"
"""What the names of a friction law's parameters begin with among the coefficients."""


def spring_length_squared(q: Symbols) -> Expression:
    """Return the square of l/L."""
    height = 1.0 + q["y"]
    return height * height + q["x"] * q["x"]


def law_parameters(law: FrictionLaw, c: Symbols) -> Symbols:
    """Return the law's parameters by their own names."""
    return {item.name: c[f"{LAW_PREFIX}{item.name}"] for item in law.parameters}


class _TipState:
    """Forces, slip and powers at a state; the friction is Coulomb's with ``mu`` without a law."""

    def __init__(self, law: FrictionLaw | None, q: Symbols, c: Symbols, phase: Expression) -> None:
        self.law, self.q, self.c = law, q, c
        self.pulsing = c["Nd"] * hy.cos(2 * math.pi * phase)
        self.slip = (c["L"] * (c["plate_x"] - q["vx"]), c["L"] * (c["plate_y"] - q["vy"]))
        self.given = normal_name(TIP) in q
        self.N = q[normal_name(TIP)] if self.given else c["Ns"] + self.pulsing

    @property
    def Vrel(self) -> Expression:
        x, y = self.slip
        return hy.sqrt(x * x + y * y)

    @property
    def Vrel_ratio(self) -> Expression:
        return self.Vrel / self.c["Vd"]

    @property
    def l(self) -> Expression:  # noqa: E743 (the name of the output)
        return hy.sqrt(spring_length_squared(self.q))

    @property
    def force(self) -> tuple[Expression, ...]:
        if self.given:
            return self.q[friction_name(TIP, 0)], self.q[friction_name(TIP, 1)]
        if self.law is None:
            size, speed = self.c["mu"] * self.N, self.Vrel
            return tuple(size * part / speed for part in self.slip)
        memory = [self.q[state.name] for state in self.law.memory(2)]
        return self.law.force(self.slip, self.N, memory, law_parameters(self.law, self.c))

    @property
    def Fx(self) -> Expression:
        return self.force[0]

    @property
    def Fy(self) -> Expression:
        return self.force[1]

    @property
    def friction_direction(self) -> Expression:
        # Without memory the force lies along the slip, which takes less to compute.
        remembers = self.law is not None and self.law.memory(2)
        x, y = self.force if self.given or remembers else self.slip
        return hy.atan2(y, x)

    @property
    def power_plate(self) -> Expression:
        return self.c["L"] * (self.Fx * self.c["plate_x"] + self.Fy * self.c["plate_y"])

    @property
    def power_friction(self) -> Expression:
        if self.law is None and not self.given:
            return self.c["mu"] * self.N * self.Vrel
        (x, y), (slip_x, slip_y) = self.force, self.slip
        return x * slip_x + y * slip_y

    @property
    def power_structure(self) -> Expression:
        return self.c["L"] * (self.Fx * self.q["vx"] + self.Fy * self.q["vy"])

    @property
    def power_pulsation(self) -> Expression:
        return self.power_structure * self.pulsing / self.N

    @property
    def power_damping(self) -> Expression:
        q, c = self.q, self.c
        lost_y = c["m1"] * c["damping1"] * q["vy"] * q["vy"]
        lost_x = c["m2"] * c["damping2"] * q["vx"] * q["vx"]
        return c["L"] * c["L"] * (lost_x + lost_y)


_DIRECTION = "direction of the friction force from the x axis"
_PULSATION = "share of power_structure due to the pulsing part of the normal force"

_OUTPUTS = (
    ("N", "N", "normal force", "$N$ (N)"),
    ("Vrel", "m/s", "speed of the plate relative to the tip", "$V_{rel}$ (m/s)"),
    ("Vrel_ratio", "", "relative speed over plate speed", "$V_{rel}/V_d$"),
    ("l", "", "length of the spring over L", "$l/L$"),
    ("Fx", "N", "friction force on the tip, horizontal", "$F_x$ (N)"),
    ("Fy", "N", "friction force on the tip, vertical", "$F_y$ (N)"),
    ("friction_direction", "rad", _DIRECTION, r"$\arg F$ (rad)"),
    ("power_plate", "W", "power put in by the plate's drive", "$P$ (W)"),
    ("power_friction", "W", "power lost to friction heat", "$P$ (W)"),
    ("power_structure", "W", "power friction puts into the structure: plate less heat", "$P$ (W)"),
    ("power_pulsation", "W", _PULSATION, "$P$ (W)"),
    ("power_damping", "W", "power lost to structural damping", "$P$ (W)"),
)
"""Name, which `_TipState` has as well, unit, meaning and label of each output."""


def sliding_outputs(law: FrictionLaw | None = None) -> tuple[Output, ...]:
    """Return the outputs of the oscillator under a friction law."""
    stores = law is not None and law.memory(2)
    return tuple(
        Output(
            name,
            partial(_output, name, law),
            unit,
            f"{doc} and stored in the contact" if stores and name == "power_friction" else doc,
            label,
        )
        for name, unit, doc, label in _OUTPUTS
    )


def _output(
    name: str, law: FrictionLaw | None, q: Symbols, c: Symbols, phase: Expression
) -> Expression:
    return getattr(_TipState(law, q, c, phase), name)


class SlidingOscillator(Model):
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
    >>> from slipfold.models.friction import RationalStribeck
    >>> SlidingOscillator(friction=RationalStribeck(mu_s=0.4, d=2.0)).replace(d=1.5, Nd=0.1)
    SlidingOscillator(friction=RationalStribeck(mu_s=0.4, d=1.5), Nd=0.1)
    """

    name = "sliding"
    title = "structure sliding on a moving plate, 2:1 internal resonance"
    quiet = "Nd"
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
        nonnegative("mu", 0.5, "", "friction coefficient", r"$\mu$"),
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

    _law: FrictionLaw | None
    """The friction law with default values; None for Coulomb's with ``mu``."""

    def __init__(self, friction: FrictionLaw | None = None, **values: float | str) -> None:
        self._take(_law=None)
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
        taken = {item.name for item in kept} | {item.name for item in cls.states} | {"friction"}
        taken |= {item.name for item in sliding_outputs()}
        own = [item.name for item in law.parameters] + [item.name for item in law.memory(2)]
        for name in own:
            if name in taken:
                raise InputError(
                    f"{type(law).__name__} calls something {name!r}, and so does {self.name}; "
                    "give the law another name for it"
                )
        states = (*cls.states, *law.memory(2))
        self._take(_law=law.kind, parameters=(*kept, *law.parameters), states=states)
        if not law.sticks:
            limits = tuple(item for item in cls.limits if item.name != "stick")
            self._take(limits=limits)

    @property
    def variable_parameters(self) -> tuple[Parameter, ...]:
        """All; where the law sticks only a plate that moves is slid on steadily."""
        sticks, found = self._law is None or self._law.sticks, super().variable_parameters
        return tuple(replace(p, lower_open=sticks) if p.name == "Vd" else p for p in found)

    @property
    def structure(self) -> Mapping[str, Hashable]:
        """The friction law with default values: its own values are among the parameters."""
        return {} if self._law is None else {"friction": self._law}

    @property
    def friction(self) -> FrictionLaw:
        """The friction law with its present values."""
        if self._law is None:
            return Coulomb(mu_s=self._values["mu"], mu_k=self._values["mu"])
        names = [item.name for item in self._law.parameters]
        return self._law.replace(**{name: self._values[name] for name in names})

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
        own = {"mu"} if self._law is None else {item.name for item in self._law.parameters}
        kept = {name: value for name, value in self._values.items() if name not in own}
        return type(self)(**{**kept, **changes})

    def __repr__(self) -> str:
        """Constructor call with the law and the parameters that differ from the defaults."""
        if self._law is None:
            return super().__repr__()
        own = {item.name for item in self._law.parameters}
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
        if self._law is not None:
            self._law.check(values)

    def coefficients(self, p: Symbols) -> dict[str, Expression]:
        """Mass-normalized stiffness, damping, friction and plate velocity."""
        w1, w2 = 2 * math.pi * p["f1"], 2 * math.pi * p["f2"]
        m1, m2 = p["k1"] / (w1 * w1), p["k2"] / (w2 * w2)
        cos, sin = cos_sin(p["alpha"])
        mu = p["mu"] if self._law is None else 1.0
        coefficients = {
            "L": p["L"],
            "m1": m1,
            "m2": m2,
            "damping1": 2 * p["zeta1"] * w1,
            "damping2": 2 * p["zeta2"] * w2,
            "stiffness1": w1 * w1,
            "stiffness2": w2 * w2,
            "spring1": p["kext"] / m1,
            "spring2": p["kext"] / m2,
            "mass_ratio": m2 / m1,
            "friction_static": mu * p["Ns"] / (m2 * p["L"]),
            "friction_pulsing": mu * p["Nd"] / (m2 * p["L"]),
            "plate_x": p["Vd"] * cos / p["L"],
            "plate_y": p["Vd"] * sin / p["L"],
            "Vd": p["Vd"],
            "Ns": p["Ns"],
            "Nd": p["Nd"],
        }
        if self._law is None:
            return {**coefficients, "mu": mu}
        own = {f"{LAW_PREFIX}{item.name}": p[item.name] for item in self._law.parameters}
        return {**coefficients, "f": p["f"], **own}

    def rates(self, q: Symbols, c: Symbols, phase: Expression) -> dict[str, Expression]:
        """Equations of motion (1)-(2) of the source paper, divided by mass and L."""
        height = 1.0 + q["y"]
        stretch = 1.0 - spring_length_squared(q) ** -0.5
        push_x, push_y, memory = self._friction_terms(q, c, phase)
        return {
            "x": q["vx"],
            "y": q["vy"],
            "vx": push_x
            - c["damping2"] * q["vx"]
            - (c["stiffness2"] + c["spring2"] * stretch) * q["x"],
            "vy": push_y
            - c["damping1"] * q["vy"]
            - c["stiffness1"] * q["y"]
            - c["spring1"] * stretch * height,
            **memory,
        }

    def _friction_terms(
        self, q: Symbols, c: Symbols, phase: Expression
    ) -> tuple[Expression, Expression, dict[str, Expression]]:
        """Accelerations over L that friction gives, and the rates of its memory."""
        if normal_name(TIP) in q:
            push_x, push_y = (q[friction_name(TIP, axis)] / (c["m2"] * c["L"]) for axis in (0, 1))
            return push_x, c["mass_ratio"] * push_y, {}
        slip_x, slip_y = c["plate_x"] - q["vx"], c["plate_y"] - q["vy"]
        load = c["friction_static"] + c["friction_pulsing"] * hy.cos(2 * math.pi * phase)
        law = self._law
        if law is None:
            drag = load * (slip_x * slip_x + slip_y * slip_y) ** -0.5
            return drag * slip_x, c["mass_ratio"] * drag * slip_y, {}
        slip, p = (c["L"] * slip_x, c["L"] * slip_y), law_parameters(law, c)
        names = [state.name for state in law.memory(2)]
        memory = [q[name] for name in names]
        push_x, push_y = law.force(slip, load, memory, p)
        turn = 2 * math.pi * phase
        normal = c["Ns"] + c["Nd"] * hy.cos(turn)
        normal_rate = -2 * math.pi * c["f"] * c["Nd"] * hy.sin(turn)
        rates = law.memory_rates(slip, memory, p, normal, normal_rate)
        return push_x, c["mass_ratio"] * push_y, dict(zip(names, rates, strict=True))

    def contacts(self, q: Symbols, c: Symbols, phase: Expression) -> tuple[Contact, ...]:
        """Return the tip on the plate, unless its law never sticks."""
        law = Coulomb() if self._law is None else self._law
        if not law.sticks:
            return ()
        own = {"mu_s": c["mu"], "mu_k": c["mu"]} if self._law is None else law_parameters(law, c)
        tip = _TipState(self._law, q, c, phase)
        return (
            Contact(
                TIP,
                tip.slip,
                (c["L"] * c["plate_x"], c["L"] * c["plate_y"]),
                c["Ns"] + tip.pulsing,
                friction=lambda speed: law.formula(speed, own),
                holding=law.holding(own),
                limits=("stick",),
            ),
        )

    def period(self, p: Symbols) -> Expression:
        """Return the forcing period 1/f in seconds."""
        return 1.0 / p["f"]

    @property
    def start(self) -> NDArray[np.float64]:
        """Zero, with the memory that a friction law has after a long slip at the plate's speed."""
        angle, speed = self._values["alpha"], self._values["Vd"]
        slip = (speed * math.cos(angle), speed * math.sin(angle))
        deflections = len(self.states[4:])
        moves = deflections and speed
        memory = self.friction.steady_memory(slip) if moves else (0.0,) * deflections
        return np.array([0.0, 0.0, 0.0, 0.0, *memory])

    def declared_scales(self) -> NDArray[np.float64]:
        """Displacements of order L, rates of order 2 pi f, memory as the law says."""
        rate = 2 * math.pi * self._values["f"]
        memory = [] if self._law is None else [self.friction.memory_scale] * len(self.states[4:])
        return np.array([1.0, 1.0, rate, rate, *memory])

    def outputs(self) -> tuple[Output, ...]:
        """Normal force, friction, relative speed, spring length and powers."""
        return sliding_outputs(self._law)

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

    def static_point(self) -> NDArray[np.float64]:
        """Return the state in which the tip rests under the steady drag (Nd = 0).

        Returns
        -------
        ndarray, shape (n_states,)
            ``x y vx vy``, the rates being zero, and the memory of a friction law that has one.

        Raises
        ------
        InputError
            If the drag is more than the structure can hold.
        """
        return find_static_point(self)

    def steady(self, **values: float | str) -> Unforced:
        """Return the oscillator under a constant normal force, as an autonomous model.

        Its equilibrium is steady sliding, to be followed in ``Vd``, ``Ns``, ``alpha``, ``mu`` or
        the parameters of the friction law. Where the friction of the law falls fast enough with
        the speed it loses its stability in a Hopf point, at which a vibration is born.

        Parameters
        ----------
        **values
            Parameter values that differ from those of this oscillator; there are no ``f`` and
            ``Nd`` any more, but a ``duration``.

        Examples
        --------
        >>> from slipfold.branches.response import trace_response
        >>> from slipfold.models import Stribeck
        >>> law = Stribeck(mu_s=0.9, mu_k=0.3, vs=0.3)
        >>> model = SlidingOscillator(friction=law).steady()
        >>> [point.type for point in trace_response(model, "Vd", (1.5, 0.6))[0].special]
        ['HB']
        """
        return Unforced(self, **values)

    def modes(self, friction: bool = True) -> Modes:
        """Return the linear modes about the loaded static point.

        Parameters
        ----------
        friction
            Whether friction follows the motion, which adds the damping
            ``Ns (mu' e e^T + (mu/Vd)(I - e e^T))`` with the coefficient mu at the speed Vd and its
            slope mu'; Coulomb's law has no slope. If not, it acts as a constant load: same point,
            same stiffness. The modes of the structure without any load are those of
            ``model.replace(mu=0)``.

        Returns
        -------
        Modes
            Two modes unless one is overdamped. A law with memory adds modes that decay without
            vibration, in which the contact recovers.

        Examples
        --------
        >>> modes = SlidingOscillator().modes()
        >>> [f"{value:.4f}" for value in modes.frequency]
        ['7.1383', '12.4607']
        """
        point = self.static_point()
        model = self.replace(Nd=0.0)
        if not friction:
            model = model.replace(friction=None, mu=0.0)
            point = point[: len(model.states)]
        return find_modes(evaluation_of(model).jacobian(model, point), ("x", "y"))
