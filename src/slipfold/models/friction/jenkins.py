"""Elastic Coulomb friction: the Jenkins element, and Iwan's contact of several in parallel."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from slipfold.arrays import Array
from slipfold.errors import InputError
from slipfold.models.formulas.functions import whole_power
from slipfold.models.friction.law import (
    KINETIC,
    REST_SPEED,
    ContactState,
    FrictionLaw,
    MemoryLaw,
    sqrt,
)
from slipfold.models.friction.with_memory import checked_exponent
from slipfold.models.parametric import described, structural
from slipfold.models.quantities import Expression, State, Symbols, positive

_CREEP = 1e-4
"""Fraction of the fading that acts at any deflection, so that a contact on a body at rest has one
equilibrium instead of a line of equilibria. It changes the energy of a cycle by less."""

Amplitude = Annotated[float, "Amplitude a of a displacement with two turning points in m."]
ConstantForce = Annotated[float, "Constant normal force in N."]


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
    vectors. A ten-thousandth of the fading acts at any z, so that a contact at rest has one
    equilibrium; there z decays at the rate :math:`5 \cdot 10^{-5} \delta`. The law is that of Bouc
    and Wen with b = c, with the limit following the normal force; as the exponent n grows it tends
    to the sharp element. The relative error of the force is of order 1/n at the knee and of order
    :math:`1/n^2` over a cycle: at an amplitude of four times that of first slip and a small e the
    error of the energy of a cycle is 0.34% for n = 8 and 0.094% for n = 16. In steady slip it is
    :math:`(\varepsilon/v)^2/(4 n)`. A stiff contact and a large exponent take more time: the
    fastest rate is :math:`n k_t v/(N \mu_k)`, and N is of the order of `en` squared where a
    `ComplianceLoad` opens. A hundredth of the largest slip speed is a good value of `e`; smaller
    ones make a sharp corner where the slip reverses, and there a branch may fail.

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
    exponent: int = structural(
        "sharpness n of the knee in a model, an even whole number", 16, checked_exponent
    )

    def formula(self, speed: Expression, p: Symbols) -> Expression:
        """``mu_k``, in steady slip."""
        return p["mu_k"]

    def forces(self, contact: ContactState, p: Symbols) -> tuple[Expression, ...]:
        """``mu_k N z``."""
        return tuple(contact.normal * (p["mu_k"] * z) for z in contact.memory)

    def memory_rates(self, contact: ContactState, p: Symbols) -> tuple[Expression, ...]:
        """``w - z |z|^(n-2) max(w·z, 0)`` with ``w = kt v/(mu_k N) - z N'/N``, rounded off."""
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
        """One, less about ``e^2/(4 n v^2)`` for ``v`` well above ``e`` by the rounding."""
        ratio, n, z = (self.e / speed) ** 2, self.exponent, 1.0
        for _ in range(8):  # to rounding: every step gains a factor of the order of `ratio`
            fading = (z ** (n - 2) + _CREEP) / (1 + _CREEP) * (z + math.sqrt(z * z + ratio)) / 2
            z -= (z * fading - 1) / n
        return z

    # -- closed forms of the sharp element -------------------------------------------------------

    def stiffness(self, amplitude: Amplitude, normal: ConstantForce = 1.0) -> float:
        """Return the harmonic equivalent stiffness in N/m.

        It is ``(kt/pi)(th - sin(2 th)/2)`` with ``th = acos(1 - 2 mu_k N/(kt a))``, and ``kt``
        where the slider does not move.
        """
        angle = math.acos(1 - 2 * min(self._slip_ratio(amplitude, normal), 1.0))
        return self.kt * (angle - math.sin(2 * angle) / 2) / math.pi

    def loss_stiffness(self, amplitude: Amplitude, normal: ConstantForce = 1.0) -> float:
        """Return ``k'' = 4 mu_k N/(pi a) (1 - mu_k N/(kt a))`` in N/m; over frequency: damping."""
        return self.energy(amplitude, normal) / (math.pi * amplitude**2)

    def energy(self, amplitude: Amplitude, normal: ConstantForce = 1.0) -> float:
        """Return the energy lost in a cycle in J, ``4 mu_k N (a - mu_k N/kt)``."""
        slipping = max(1 - self._slip_ratio(amplitude, normal), 0.0)
        return 4 * normal * amplitude * self.mu_k * slipping

    def along(self, displacement: ArrayLike, normal: ConstantForce = 1.0) -> Array:
        """Return the forces in N along a path of the moving surface, shape (m,), from no force.

        Parameters
        ----------
        displacement
            Displacements on a line in m, shape (m,), monotonic from each to the next.
        """
        path, limit = np.asarray(displacement, dtype=float), self.mu_k * normal
        forces = np.zeros(len(path))
        for i, step in enumerate(np.diff(path), 1):
            forces[i] = np.clip(forces[i - 1] + self.kt * step, -limit, limit)
        return forces

    def _slip_ratio(self, amplitude: float, normal: float) -> float:
        """Return the displacement at which the slider begins to slip over the amplitude."""
        for name, value, unit in (("amplitude", amplitude, "m"), ("normal", normal, "N")):
            if not value > 0:
                raise InputError(f"{name} = {value:g} {unit} is not positive; give {name} > 0")
        return self.mu_k * normal / (self.kt * amplitude)


def _checked_elements(elements: Any, title: str) -> tuple[Jenkins, ...]:
    given = tuple(elements) if isinstance(elements, tuple | list) else ()
    if not given or not all(isinstance(item, Jenkins) for item in given):
        raise InputError(
            f"elements = {elements!r} are not Jenkins elements; give e.g. "
            "(Jenkins(mu_k=0.1), Jenkins(mu_k=0.3))"
        )
    return given


@dataclass(frozen=True)
class Iwan(FrictionLaw):
    """Jenkins elements in parallel, which begin to slip one after the other.

    Parameters and memory of the elements have their numbers: ``mu_k1 kt1 e1 mu_k2 kt2 e2 ...``.
    In a model each has a knee in place of its corner, see `Jenkins`.

    References
    ----------
    W. D. Iwan, A distributed-element model for hysteresis and its steady-state dynamic response,
    Journal of Applied Mechanics 33 (1966) 893-900.

    Examples
    --------
    >>> contact = Iwan((Jenkins(mu_k=0.1, kt=20), Jenkins(mu_k=0.3, kt=20)))
    >>> round(contact.coefficient(0.1), 12)
    0.4
    >>> contact.replace(kt2=50.0).elements[1].kt, contact.parameters[1].symbol
    (50.0, '$k_{t1}$')
    """

    title: ClassVar[str] = "Iwan (Jenkins in parallel)"
    sticks: ClassVar[bool] = False

    elements: tuple[Jenkins, ...] = structural(
        "the elements; each bears the normal force, so that their friction coefficients add up",
        (Jenkins(),),
        _checked_elements,
    )

    def memory(self, dimensions: int) -> tuple[State, ...]:
        """Return the states of all elements, with their numbers."""
        return tuple(
            State(f"{state.name}{position}", state.unit, f"{state.doc}, element {position}")
            for position, element in enumerate(self.elements, 1)
            for state in element.memory(dimensions)
        )

    def steady_memory(self, slip: Sequence[float]) -> tuple[float, ...]:
        """Return the memory after a long slip at a constant velocity."""
        return tuple(part for element in self.elements for part in element.steady_memory(slip))

    def formula(self, speed: Expression, p: Symbols) -> Expression:
        """Sum of ``mu_k`` over the elements, in steady slip."""
        return sum(p[f"mu_k{position}"] for position in range(1, len(self.elements) + 1))

    def forces(self, contact: ContactState, p: Symbols) -> tuple[Expression, ...]:
        """Sum of ``mu_k N z`` over the elements."""
        size, numbers = len(contact.slip), range(len(self.elements))
        return tuple(
            contact.normal
            * sum(p[f"mu_k{n + 1}"] * contact.memory[n * size + axis] for n in numbers)
            for axis in range(size)
        )

    def memory_rates(self, contact: ContactState, p: Symbols) -> tuple[Expression, ...]:
        """``w - z |z|^(n-2) max(w·z, 0)``, ``w = kt v/(mu_k N) - z N'/N``, of each element."""
        size = len(contact.slip)
        rates: list[Expression] = []
        for n, element in enumerate(self.elements):
            own = dataclasses.replace(contact, memory=contact.memory[n * size : (n + 1) * size])
            rates += element.memory_rates(
                own, {name: p[f"{name}{n + 1}"] for name in element.values}
            )
        return tuple(rates)
