"""What a user asks of the sliding oscillator besides its states: forces, slip, lengths, powers."""

from __future__ import annotations

import math

import heyoka as hy

from slipfold.models.contact import friction_name, normal_name
from slipfold.models.friction.law import FrictionLaw
from slipfold.models.output import Expression, Output, Symbols

TIP = "tip"
"""The contact of tip and plate."""

LAW_PREFIX = "law_"
"""What the names of a friction law's parameters begin with among the coefficients."""


def spring_length_squared(q: Symbols) -> Expression:
    """Return the square of l/L."""
    height = 1.0 + q["y"]
    return height * height + q["x"] * q["x"]


def _spring_length(q: Symbols, c: Symbols, phase: Expression) -> Expression:
    return hy.sqrt(spring_length_squared(q))


def _normal_force(q: Symbols, c: Symbols, phase: Expression) -> Expression:
    if normal_name(TIP) in q:
        return q[normal_name(TIP)]
    return c["Ns"] + c["Nd"] * hy.cos(2 * math.pi * phase)


def relative_velocity(q: Symbols, c: Symbols) -> tuple[Expression, Expression]:
    """Return the velocity of the plate relative to the tip."""
    return c["L"] * (c["plate_x"] - q["vx"]), c["L"] * (c["plate_y"] - q["vy"])


def _relative_speed(q: Symbols, c: Symbols, phase: Expression) -> Expression:
    slip_x, slip_y = relative_velocity(q, c)
    return hy.sqrt(slip_x * slip_x + slip_y * slip_y)


def _relative_speed_ratio(q: Symbols, c: Symbols, phase: Expression) -> Expression:
    return _relative_speed(q, c, phase) / c["Vd"]


def law_parameters(law: FrictionLaw, c: Symbols) -> Symbols:
    """Return the law's parameters by their own names."""
    return {item.name: c[f"{LAW_PREFIX}{item.name}"] for item in law.parameters}


def _power_damping(q: Symbols, c: Symbols, phase: Expression) -> Expression:
    lost_y = c["m1"] * c["damping1"] * q["vy"] * q["vy"]
    lost_x = c["m2"] * c["damping2"] * q["vx"] * q["vx"]
    return c["L"] * c["L"] * (lost_x + lost_y)


class _Contact:
    """The friction force under a law, Coulomb's with the coefficient ``mu`` if None, and powers."""

    def __init__(self, law: FrictionLaw | None) -> None:
        self.law = law
        self.memory = () if law is None else tuple(state.name for state in law.memory(2))

    @property
    def losses(self) -> str:
        """What becomes of the power that slip puts into the contact."""
        stored = " and stored in the contact" if self.memory else ""
        return f"power lost to friction heat{stored}"

    def force(self, q: Symbols, c: Symbols, phase: Expression) -> tuple[Expression, Expression]:
        if normal_name(TIP) in q:
            return q[friction_name(TIP, 0)], q[friction_name(TIP, 1)]
        slip_x, slip_y = relative_velocity(q, c)
        normal = _normal_force(q, c, phase)
        if self.law is None:
            size, speed = c["mu"] * normal, _relative_speed(q, c, phase)
            return size * slip_x / speed, size * slip_y / speed
        memory = [q[name] for name in self.memory]
        x, y = self.law.force((slip_x, slip_y), normal, memory, law_parameters(self.law, c))
        return x, y

    def friction_x(self, q: Symbols, c: Symbols, phase: Expression) -> Expression:
        return self.force(q, c, phase)[0]

    def friction_y(self, q: Symbols, c: Symbols, phase: Expression) -> Expression:
        return self.force(q, c, phase)[1]

    def friction_direction(self, q: Symbols, c: Symbols, phase: Expression) -> Expression:
        # Without memory the force lies along the slip, which takes less to compute.
        given = self.memory or normal_name(TIP) in q
        x, y = self.force(q, c, phase) if given else relative_velocity(q, c)
        return hy.atan2(y, x)

    def power_plate(self, q: Symbols, c: Symbols, phase: Expression) -> Expression:
        return c["L"] * (
            self.friction_x(q, c, phase) * c["plate_x"]
            + self.friction_y(q, c, phase) * c["plate_y"]
        )

    def power_friction(self, q: Symbols, c: Symbols, phase: Expression) -> Expression:
        if self.law is None and normal_name(TIP) not in q:
            return c["mu"] * _normal_force(q, c, phase) * _relative_speed(q, c, phase)
        (x, y), (slip_x, slip_y) = self.force(q, c, phase), relative_velocity(q, c)
        return x * slip_x + y * slip_y

    def power_structure(self, q: Symbols, c: Symbols, phase: Expression) -> Expression:
        return c["L"] * (
            self.friction_x(q, c, phase) * q["vx"] + self.friction_y(q, c, phase) * q["vy"]
        )

    def power_pulsation(self, q: Symbols, c: Symbols, phase: Expression) -> Expression:
        pulsing = c["Nd"] * hy.cos(2 * math.pi * phase)
        return self.power_structure(q, c, phase) * pulsing / _normal_force(q, c, phase)


def sliding_outputs(law: FrictionLaw | None = None) -> tuple[Output, ...]:
    """Return the outputs of the oscillator under a friction law."""
    contact = _Contact(law)
    return (
        Output("N", _normal_force, "N", "normal force", "$N$ (N)"),
        Output(
            "Vrel",
            _relative_speed,
            "m/s",
            "speed of the plate relative to the tip",
            "$V_{rel}$ (m/s)",
        ),
        Output(
            "Vrel_ratio",
            _relative_speed_ratio,
            "",
            "relative speed over plate speed",
            "$V_{rel}/V_d$",
        ),
        Output("l", _spring_length, "", "length of the spring over L", "$l/L$"),
        Output("Fx", contact.friction_x, "N", "friction force on the tip, horizontal", "$F_x$ (N)"),
        Output("Fy", contact.friction_y, "N", "friction force on the tip, vertical", "$F_y$ (N)"),
        Output(
            "friction_direction",
            contact.friction_direction,
            "rad",
            "direction of the friction force from the x axis",
            r"$\arg F$ (rad)",
        ),
        Output(
            "power_plate", contact.power_plate, "W", "power put in by the plate's drive", "$P$ (W)"
        ),
        Output("power_friction", contact.power_friction, "W", contact.losses, "$P$ (W)"),
        Output(
            "power_structure",
            contact.power_structure,
            "W",
            "power friction puts into the structure: plate less heat",
            "$P$ (W)",
        ),
        Output(
            "power_pulsation",
            contact.power_pulsation,
            "W",
            "share of power_structure due to the pulsing part of the normal force",
            "$P$ (W)",
        ),
        Output("power_damping", _power_damping, "W", "power lost to structural damping", "$P$ (W)"),
    )
