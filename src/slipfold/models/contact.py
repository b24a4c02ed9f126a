"""A contact with exact dry friction, as the equations of its three states need it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from slipfold.models.output import Expression


def normal_name(contact: str) -> str:
    """Return the name under which equations look for a normal force that is given."""
    return f"normal force of {contact}"


def friction_name(contact: str, axis: int) -> str:
    """Return the name under which they look for a component of friction that is given."""
    return f"friction {axis} of {contact}"


@dataclass(frozen=True)
class Contact:
    """A place where a model rubs and may stick; symbols of its states, coefficients and phase.

    A model with contacts takes the forces in them from among its states where they are given there,
    under the names `normal_name` and `friction_name`, instead of from its laws.
    """

    name: str
    # Velocity of the counter-body relative to the body in m/s, linear in the states, and that of
    # the counter-body; one or two components
    slip: tuple[Expression, ...]
    plate: tuple[Expression, ...]
    normal: Expression  # normal force in N
    friction: Callable[[Expression], Expression]  # coefficient in slip, of the slip speed
    holding: Expression  # coefficient up to which it sticks
    opens: bool = False  # whether the normal force may vanish, and friction with it
    # Names of the model's limits that mean nothing to a motion that may stick and open
    limits: tuple[str, ...] = ()

    @property
    def friction_names(self) -> tuple[str, ...]:
        """Names of the components of its friction."""
        return tuple(friction_name(self.name, axis) for axis in range(len(self.slip)))
