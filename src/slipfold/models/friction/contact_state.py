"""What a friction law sees of a contact: slip, memory and normal force."""

from __future__ import annotations

from dataclasses import dataclass

from slipfold.models.output import Expression


@dataclass(frozen=True)
class ContactState:
    """The state of a contact in numbers, arrays or symbols.

    Parameters
    ----------
    slip
        Velocity of the counter-body relative to the body in m/s, one or two components.
    memory
        The contact's memory, if the law has one.
    normal
        Normal force in N.
    normal_rate
        Its rate in N/s.
    """

    slip: tuple[Expression, ...]
    memory: tuple[Expression, ...] = ()
    normal: Expression = 1.0
    normal_rate: Expression = 0.0

    @property
    def square(self) -> Expression:
        """Square of the slip speed."""
        return sum(component * component for component in self.slip)
