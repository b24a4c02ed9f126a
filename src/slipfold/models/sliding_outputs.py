"""What a user asks of the sliding oscillator besides its states: forces, slip, lengths, powers."""

from __future__ import annotations

import math

import heyoka as hy

from slipfold.models.output import Expression, Output, Symbols

__all__ = ["SLIDING_OUTPUTS", "spring_length_squared"]


def spring_length_squared(q: Symbols) -> Expression:
    """Return the square of l/L.

    Parameters
    ----------
    q
        The states by name.
    """
    height = 1.0 + q["y"]
    return height * height + q["x"] * q["x"]


def _spring_length(q: Symbols, c: Symbols, phase: Expression) -> Expression:
    return hy.sqrt(spring_length_squared(q))


def _normal_force(q: Symbols, c: Symbols, phase: Expression) -> Expression:
    return c["Ns"] + c["Nd"] * hy.cos(2 * math.pi * phase)


def _slip(q: Symbols, c: Symbols) -> tuple[Expression, Expression]:
    return c["L"] * (c["plate_x"] - q["vx"]), c["L"] * (c["plate_y"] - q["vy"])


def _relative_speed(q: Symbols, c: Symbols, phase: Expression) -> Expression:
    slip_x, slip_y = _slip(q, c)
    return hy.sqrt(slip_x * slip_x + slip_y * slip_y)


def _relative_speed_ratio(q: Symbols, c: Symbols, phase: Expression) -> Expression:
    return _relative_speed(q, c, phase) / c["Vd"]


def _friction_x(q: Symbols, c: Symbols, phase: Expression) -> Expression:
    return c["mu"] * _normal_force(q, c, phase) * _slip(q, c)[0] / _relative_speed(q, c, phase)


def _friction_y(q: Symbols, c: Symbols, phase: Expression) -> Expression:
    return c["mu"] * _normal_force(q, c, phase) * _slip(q, c)[1] / _relative_speed(q, c, phase)


def _friction_direction(q: Symbols, c: Symbols, phase: Expression) -> Expression:
    slip_x, slip_y = _slip(q, c)
    return hy.atan2(slip_y, slip_x)


def _power_plate(q: Symbols, c: Symbols, phase: Expression) -> Expression:
    return c["L"] * (
        _friction_x(q, c, phase) * c["plate_x"] + _friction_y(q, c, phase) * c["plate_y"]
    )


def _power_friction(q: Symbols, c: Symbols, phase: Expression) -> Expression:
    return c["mu"] * _normal_force(q, c, phase) * _relative_speed(q, c, phase)


def _power_structure(q: Symbols, c: Symbols, phase: Expression) -> Expression:
    return c["L"] * (_friction_x(q, c, phase) * q["vx"] + _friction_y(q, c, phase) * q["vy"])


def _power_pulsation(q: Symbols, c: Symbols, phase: Expression) -> Expression:
    pulsing = c["Nd"] * hy.cos(2 * math.pi * phase)
    return _power_structure(q, c, phase) * pulsing / _normal_force(q, c, phase)


def _power_damping(q: Symbols, c: Symbols, phase: Expression) -> Expression:
    lost_y = c["m1"] * c["damping1"] * q["vy"] * q["vy"]
    lost_x = c["m2"] * c["damping2"] * q["vx"] * q["vx"]
    return c["L"] * c["L"] * (lost_x + lost_y)


SLIDING_OUTPUTS: tuple[Output, ...] = (
    Output("N", _normal_force, "N", "normal force", "$N$ (N)"),
    Output(
        "Vrel", _relative_speed, "m/s", "speed of the plate relative to the tip", "$V_{rel}$ (m/s)"
    ),
    Output(
        "Vrel_ratio", _relative_speed_ratio, "", "relative speed over plate speed", "$V_{rel}/V_d$"
    ),
    Output("l", _spring_length, "", "length of the spring over L", "$l/L$"),
    Output("Fx", _friction_x, "N", "friction force on the tip, horizontal", "$F_x$ (N)"),
    Output("Fy", _friction_y, "N", "friction force on the tip, vertical", "$F_y$ (N)"),
    Output(
        "friction_direction",
        _friction_direction,
        "rad",
        "direction of the friction force from the x axis",
        r"$\arg F$ (rad)",
    ),
    Output("power_plate", _power_plate, "W", "power put in by the plate's drive", "$P$ (W)"),
    Output("power_friction", _power_friction, "W", "power lost to friction heat", "$P$ (W)"),
    Output(
        "power_structure",
        _power_structure,
        "W",
        "power friction puts into the structure: plate less heat",
        "$P$ (W)",
    ),
    Output(
        "power_pulsation",
        _power_pulsation,
        "W",
        "share of power_structure due to the pulsing part of the normal force",
        "$P$ (W)",
    ),
    Output("power_damping", _power_damping, "W", "power lost to structural damping", "$P$ (W)"),
)
