"""Iwan's contact: Jenkins elements in parallel."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from slipfold.errors import InputError
from slipfold.models.friction.contact_state import ContactState
from slipfold.models.friction.jenkins import Jenkins
from slipfold.models.friction.law import FrictionLaw
from slipfold.models.output import Expression, Symbols
from slipfold.models.parameter import Parameter, State


@dataclass(frozen=True)
class Iwan(FrictionLaw):
    """Jenkins elements in parallel, which give way one after the other.

    Parameters and memory of the elements carry their numbers: ``mu_k1 kt1 e1 mu_k2 kt2 e2 ...``.
    In a model each has a knee in place of its corner, see `Jenkins`.

    Parameters
    ----------
    elements
        The elements; each bears the normal force, so that their friction coefficients add up.

    References
    ----------
    W. D. Iwan, A distributed-element model for hysteresis and its steady-state dynamic response,
    Journal of Applied Mechanics 33 (1966) 893-900.

    Examples
    --------
    >>> contact = Iwan((Jenkins(mu_k=0.1, kt=20), Jenkins(mu_k=0.3, kt=20)))
    >>> round(contact.coefficient(0.1), 12)
    0.4
    >>> contact.replace(kt2=50.0).elements[1].kt
    50.0
    """

    title: ClassVar[str] = "Iwan (Jenkins in parallel)"
    sticks: ClassVar[bool] = False

    elements: tuple[Jenkins, ...] = (Jenkins(),)

    def check_structure(self) -> None:
        """Refuse what is not one or more Jenkins elements."""
        elements: Any = self.elements
        given = tuple(elements) if isinstance(elements, tuple | list) else ()
        if not given or not all(isinstance(item, Jenkins) for item in given):
            raise InputError(
                f"elements = {self.elements!r} are not Jenkins elements; give e.g. "
                "(Jenkins(mu_k=0.1), Jenkins(mu_k=0.3))"
            )
        object.__setattr__(self, "elements", given)

    # -- parameters and memory, numbered --------------------------------------------------------

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """Those of the elements, with their numbers."""
        return tuple(
            dataclasses.replace(
                item, name=f"{item.name}{place}", doc=f"{item.doc}, element {place}", symbol=""
            )
            for place, element in enumerate(self.elements, 1)
            for item in element.parameters
        )

    @property
    def values(self) -> dict[str, float]:
        """Values of the parameters by name, in SI units."""
        return {
            f"{name}{place}": value
            for place, element in enumerate(self.elements, 1)
            for name, value in element.values.items()
        }

    @property
    def kind(self) -> Self:
        """The contact with default values."""
        return type(self)(tuple(element.kind for element in self.elements))

    def replace(self, **changes: Any) -> Self:
        """Return a new contact with some values of its elements changed.

        Parameters
        ----------
        **changes
            New values by name, numbers in SI units or text with a unit; or ``elements``.

        Raises
        ------
        InputError
            For an unknown name or a value that cannot be used.
        """
        known = self.values
        own = {name: changes.pop(name) for name in known if name in changes}
        contact = super().replace(**changes)
        if not own:
            return contact
        elements = tuple(
            element.replace(**_numbered(own, element.values, place))
            for place, element in enumerate(contact.elements, 1)
        )
        return type(self)(elements)

    def memory(self, dimensions: int) -> tuple[State, ...]:
        """Return the states of all elements, with their numbers."""
        return tuple(
            State(f"{state.name}{place}", state.unit, f"{state.doc}, element {place}")
            for place, element in enumerate(self.elements, 1)
            for state in element.memory(dimensions)
        )

    def steady_memory(self, slip: Sequence[float]) -> tuple[float, ...]:
        """Return the memory after a long slip at a constant velocity."""
        return tuple(part for element in self.elements for part in element.steady_memory(slip))

    # -- forces --------------------------------------------------------------------------------

    def formula(self, speed: Expression, p: Symbols) -> Expression:
        """Sum of the elements' friction coefficients, in steady slip."""
        return sum(p[f"mu_k{place}"] for place in range(1, len(self.elements) + 1))

    def traction(self, contact: ContactState, p: Symbols) -> tuple[Expression, ...]:
        """Sum of those of the elements."""
        parts = [element.traction(own, q) for element, own, q in self._apart(contact, p)]
        return tuple(sum(components) for components in zip(*parts, strict=True))

    def rates_of_memory(self, contact: ContactState, p: Symbols) -> tuple[Expression, ...]:
        """Those of the elements."""
        return tuple(
            rate
            for element, own, q in self._apart(contact, p)
            for rate in element.rates_of_memory(own, q)
        )

    def _apart(
        self, contact: ContactState, p: Symbols
    ) -> Iterator[tuple[Jenkins, ContactState, dict[str, Expression]]]:
        """Give each element with what it sees of the contact, and its parameters."""
        size = len(contact.slip)
        for place, element in enumerate(self.elements, 1):
            memory = contact.memory[(place - 1) * size : place * size]
            own = {name: p[f"{name}{place}"] for name in element.values}
            yield element, dataclasses.replace(contact, memory=memory), own

    # -- closed forms of the sharp elements -----------------------------------------------------

    def stiffness(self, amplitude: float, normal: float = 1.0) -> float:
        """Return the harmonic equivalent stiffness in N/m.

        Parameters
        ----------
        amplitude
            Amplitude of a harmonic displacement in m.
        normal
            Constant normal force in N.
        """
        return sum(element.stiffness(amplitude, normal) for element in self.elements)

    def loss_stiffness(self, amplitude: float, normal: float = 1.0) -> float:
        """Return the harmonic equivalent loss stiffness in N/m.

        Parameters
        ----------
        amplitude
            Amplitude of a harmonic displacement in m.
        normal
            Constant normal force in N.
        """
        return sum(element.loss_stiffness(amplitude, normal) for element in self.elements)

    def energy(self, amplitude: float, normal: float = 1.0) -> float:
        """Return the energy lost in a cycle, in J.

        Parameters
        ----------
        amplitude
            Amplitude of a periodic displacement with two turning points, in m.
        normal
            Constant normal force in N.
        """
        return sum(element.energy(amplitude, normal) for element in self.elements)

    def along(self, displacement: ArrayLike, normal: float = 1.0) -> NDArray[np.float64]:
        """Return the force along a path of the counter-body on a line, from no force.

        Parameters
        ----------
        displacement
            Displacements in m, shape (m,), monotonic from each to the next; the force is exact.
        normal
            Constant normal force in N.

        Returns
        -------
        ndarray, shape (m,)
            Forces on the body in N.
        """
        forces = [element.along(displacement, normal) for element in self.elements]
        return np.asarray(np.sum(forces, axis=0))


def _numbered(changes: dict[str, Any], names: Any, place: int) -> dict[str, Any]:
    """Return the changes that belong to one element, by its own names."""
    return {name: changes[f"{name}{place}"] for name in names if f"{name}{place}" in changes}
