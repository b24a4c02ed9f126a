"""Elastic Coulomb friction: the Jenkins element, and Iwan's contact of several in parallel."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from slipfold.errors import InputError
from slipfold.models.formulas.functions import whole_power
from slipfold.models.friction.law import ContactState, FrictionLaw, MemoryLaw
from slipfold.models.friction.quantities import (
    KINETIC,
    REST_SPEED,
    checked_exponent,
    described,
    sqrt,
)
from slipfold.models.output import Expression, Symbols
from slipfold.models.parameter import Parameter, State, positive

_CREEP = 1e-4
"""Share of the fading that is there at any deflection: with it alone does a contact on a body at
rest have one point of rest, and not a line of them. It changes the energy of a cycle by less."""


@dataclass(frozen=True)
class Jenkins(MemoryLaw):
    r"""A spring in series with a Coulomb slider: elastic Coulomb friction.

    .. math::

        \dot F = k_t v \ \text{while}\ |F| < N \mu_k \ \text{or the slip reverses}, \qquad
        |F| \le N \mu_k

    `stiffness`, `loss_stiffness`, `energy` and `along` are those of this sharp element. A model
    needs smooth equations, and there the corner is a knee: with the force over its limit as memory,
    :math:`z = F/(N \mu_k)`, and the rate that it has while the slider holds,
    :math:`w = k_t v/(N \mu_k) - z \dot N/N`,

    .. math::

        \dot z = w - z |z|^{n-2} \max(w \cdot z, 0)

    so that \|z\| stays below 1 whatever the slip and the normal force do, and a contact unloads
    with the stiffness of the spring. The maximum is rounded off as :math:`(x + \sqrt{x^2 +
    \delta^2})/2` with :math:`\delta = k_t \varepsilon/(N \mu_k)`. In the plane z and v are
    vectors. The law is that of Bouc and Wen with b = c, with the limit following the normal force;
    as the exponent n grows it tends to the sharp element. At the knee the force is wrong by a share
    of order 1/n, over a cycle by one of order :math:`1/n^2`: at an amplitude of four times that of
    first slip and a small e the energy of a cycle is wrong by 0.34% for n = 8 and by 0.094% for
    n = 16. In steady slip the force is wrong by the share :math:`(\varepsilon/v)^2/(4 n)` that the
    rounding takes. A stiff contact and a large exponent take more time: the fastest rate is
    :math:`n k_t v/(N \mu_k)`.

    Parameters
    ----------
    mu_k
        Friction coefficient of the slider; no unit.
    kt
        Stiffness of the spring, in N/m.
    e
        Speed below which the change from slip to unloading is rounded off, in m/s; a hundredth of
        the largest slip speed is a good value. Smaller ones make a sharp corner where the slip
        reverses, and there a branch may fail.
    exponent
        Sharpness n of the knee in a model, an even whole number.

    References
    ----------
    G. M. Jenkins, Analysis of the stress-strain relationships in reactor grade graphite, British
    Journal of Applied Physics 13 (1962) 30-32; harmonic equivalents: M. Krack and J. Gross,
    Harmonic Balance for Nonlinear Vibration Problems, Springer 2019.

    Examples
    --------
    >>> element = Jenkins(mu_k=0.5, kt=20)
    >>> round(element.stiffness(0.2, normal=2.0), 12)
    3.910022189558
    """

    title: ClassVar[str] = "Jenkins (elastic Coulomb)"
    unit: ClassVar[str] = ""
    meaning: ClassVar[str] = "friction force over its limit"

    mu_k: float = described(replace(KINETIC, default=0.5, lower_open=True))
    kt: float = described(positive("kt", 1e3, "N/m", "stiffness of the contact", "$k_t$"))

    e: float = described(
        replace(
            REST_SPEED,
            default=1e-2,
            doc="speed below which the change from slip to unloading is rounded off",
        )
    )
    exponent: int = 16

    def check_structure(self) -> None:
        """Refuse exponents for which the equations are not smooth."""
        object.__setattr__(self, "exponent", checked_exponent(self.exponent))

    def formula(self, speed: Expression, p: Symbols) -> Expression:
        """``mu_k``, in steady slip."""
        return p["mu_k"]

    def traction(self, contact: ContactState, p: Symbols) -> tuple[Expression, ...]:
        """``mu_k z``."""
        return tuple(p["mu_k"] * z for z in contact.memory)

    def rates_of_memory(self, contact: ContactState, p: Symbols) -> tuple[Expression, ...]:
        """``w - z |z|^(n-2) max(w.z, 0)`` with ``w = kt v/(mu_k N) - z N'/N``, rounded off."""
        inverse, memory = p["kt"] / (p["mu_k"] * contact.normal), contact.memory
        fading = contact.normal_rate / contact.normal
        held = [inverse * v - fading * z for v, z in zip(contact.slip, memory, strict=True)]
        gain = sum(w * z for w, z in zip(held, memory, strict=True))
        floor = inverse * p["e"]
        slipping = 0.5 * (gain + sqrt(gain * gain + floor * floor))
        square = sum(z * z for z in memory)
        knee = whole_power(square, self.exponent // 2 - 1)
        drop = slipping * (knee + _CREEP) / (1 + _CREEP)
        return tuple(w - drop * z for w, z in zip(held, memory, strict=True))

    def steady_deflection(self, speed: float) -> float:
        """One, less what the rounding takes: about ``e^2/(4 n v^2)`` for ``v`` well above ``e``."""
        share, n, z = (self.e / speed) ** 2, self.exponent, 1.0
        for _ in range(8):  # to rounding: every step gains a factor of the order of `share`
            fading = (z ** (n - 2) + _CREEP) / (1 + _CREEP) * (z + math.sqrt(z * z + share)) / 2
            z -= (z * fading - 1) / n
        return z

    def stiffness(self, amplitude: float, normal: float = 1.0) -> float:
        """Return the harmonic equivalent stiffness ``k' = (kt/pi)(th - sin(2 th)/2)`` in N/m.

        With ``th = acos(1 - 2 mu_k N/(kt a))``; ``kt`` where the slider does not move.

        Parameters
        ----------
        amplitude
            Amplitude a of a harmonic displacement in m.
        normal
            Constant normal force in N.
        """
        ratio = self._slip_share(amplitude, normal)
        if ratio >= 1:
            return self.kt
        th = math.acos(1 - 2 * ratio)
        return self.kt / math.pi * (th - math.sin(2 * th) / 2)

    def loss_stiffness(self, amplitude: float, normal: float = 1.0) -> float:
        """Return ``k'' = 4 mu_k N/(pi a) (1 - mu_k N/(kt a))`` in N/m; over the frequency: damping.

        Parameters
        ----------
        amplitude
            Amplitude a of a harmonic displacement in m.
        normal
            Constant normal force in N.
        """
        return self.energy(amplitude, normal) / (math.pi * amplitude**2)

    def energy(self, amplitude: float, normal: float = 1.0) -> float:
        """Return the energy lost in a cycle, ``4 mu_k N (a - mu_k N/kt)``, in J.

        Parameters
        ----------
        amplitude
            Amplitude a of a periodic displacement with two turning points, in m.
        normal
            Constant normal force in N.
        """
        ratio = self._slip_share(amplitude, normal)
        return 4 * self.mu_k * normal * amplitude * max(1 - ratio, 0.0)

    def along(
        self, displacement: ArrayLike, normal: float = 1.0, force: float = 0.0
    ) -> NDArray[np.float64]:
        """Return the force along a path of the moving surface on a line.

        Parameters
        ----------
        displacement
            Displacements in m, shape (m,), monotonic from each to the next; the force is exact.
        normal
            Constant normal force in N.
        force
            Force at the first displacement, in N.

        Returns
        -------
        ndarray, shape (m,)
            Forces on the body in N.
        """
        path = np.asarray(displacement, dtype=float)
        limit = self.mu_k * normal
        forces = np.empty_like(path)
        forces[0] = force
        for i in range(1, len(path)):
            trial = forces[i - 1] + self.kt * (path[i] - path[i - 1])
            forces[i] = min(max(trial, -limit), limit)
        return forces

    def _slip_share(self, amplitude: float, normal: float) -> float:
        """Return the displacement at which the slider gives way over the amplitude."""
        if not amplitude > 0:
            raise InputError(f"amplitude = {amplitude:g} m is not positive; give amplitude > 0")
        if not normal > 0:
            raise InputError(f"normal = {normal:g} N is not positive; give normal > 0")
        return self.mu_k * normal / (self.kt * amplitude)


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
        """Return the force along a path of the moving surface on a line, from no force.

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
