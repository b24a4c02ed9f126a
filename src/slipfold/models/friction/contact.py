"""A friction contact in the symbols of a model: slip, normal force, friction law."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from slipfold.models.formulas.values import as_symbol
from slipfold.models.friction.law import ContactState, FrictionLaw
from slipfold.models.quantities import Expression, Output, Symbols


def normal_name(contact: str) -> str:
    """Return the name of a given normal force among the states."""
    return f"normal force of {contact}"


def friction_name(contact: str, axis: int) -> str:
    """Return the name of a given component of friction among the states."""
    return f"friction {axis} of {contact}"


@dataclass(frozen=True, kw_only=True)
class Contact(ContactState):
    """A contact of a model, which may stick; symbols of states, coefficients and phase.

    Forces that are given among the states, under the names `normal_name` and `friction_name`,
    replace those of the law.
    """

    name: str
    # Velocity of the moving surface in m/s; the slip is linear in the states
    plate: tuple[Expression, ...]
    plate_speed: Expression  # its modulus
    law: FrictionLaw
    values: Symbols  # parameters of the law, among others
    given: tuple[Expression, ...] = ()  # friction force in N, where it does not follow from the law
    opens: bool = False  # whether the normal force may vanish, and friction with it
    # Names of limits of the model that do not apply to trajectories that may stick and open
    limits: tuple[str, ...] = ()

    def in_states(self, q: Symbols) -> Contact:
        """Return the contact with the forces given among the states, if there are any."""
        if normal_name(self.name) not in q:
            return self
        given = tuple(q[name] for name in self.friction_names)
        return replace(self, normal=q[normal_name(self.name)], given=given)

    @property
    def friction_names(self) -> tuple[str, ...]:
        """Names of the components of its friction."""
        return tuple(friction_name(self.name, axis) for axis in range(len(self.slip)))

    def friction(self, speed: Expression) -> Expression:
        """Return the friction coefficient at a slip speed."""
        return as_symbol(self.law.formula(speed, self.values))

    @property
    def holding(self) -> Expression:
        """Friction coefficient up to which it sticks."""
        return as_symbol(self.law.holding(self.values))

    @property
    def force(self) -> tuple[Expression, ...]:
        """Friction force on the body in N."""
        return self.given or self.law.forces(self, self.values)

    @property
    def memory_rates(self) -> tuple[Expression, ...]:
        """Rates of the memory per second."""
        return self.law.memory_rates(self, self.values)

    def power(self, velocity: tuple[Expression, ...]) -> Expression:
        """Return the power of the friction force at a velocity."""
        return sum(force * part for force, part in zip(self.force, velocity, strict=True))


_ALONG = "friction force on the structure along"
_RATIO = "slip speed over the moving surface's speed"
_DRIVEN = "power put in by the moving surface's drive"
_LOST = "power lost to friction heat"


def contact_outputs(
    contact_of: Callable[..., Contact], law: FrictionLaw, dimensions: int
) -> dict[str, Output]:
    """Return the outputs of a contact by name.

    `contact_of` has the arguments of the expression of an output.
    """
    stored = " and stored in the contact" if law.memory(dimensions) else ""
    quantities: dict[str, tuple[Callable[[Contact], Expression], str, str, str]] = {
        "N": (lambda one: one.normal, "N", "normal force of a contact", "$N$ (N)"),
        "Vrel": (lambda one: one.speed, "m/s", "slip speed of a contact", "$V_{rel}$ (m/s)"),
        "Fx": (lambda one: one.force[0], "N", "friction force on the structure", "$F_x$ (N)"),
        "Fy": (lambda one: one.force[1], "N", f"{_ALONG} the second direction", "$F_y$ (N)"),
        "Vrel_ratio": (lambda one: one.speed / one.plate_speed, "", _RATIO, "$V_{rel}/V_d$"),
        "power_plate": (lambda one: one.power(one.plate), "W", _DRIVEN, "$P$ (W)"),
        "power_friction": (lambda one: one.power(one.slip), "W", f"{_LOST}{stored}", "$P$ (W)"),
    }
    return {
        name: Output(name, lambda *at, of=function: of(contact_of(*at)), unit, doc, label)
        for name, (function, unit, doc, label) in quantities.items()
        if dimensions == 2 or name != "Fy"
    }
