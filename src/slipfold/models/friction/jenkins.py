"""Elastic Coulomb contacts: the Jenkins element, and Iwan's parallel arrangement of several."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from slipfold.errors import InputError
from slipfold.models.friction.law import FrictionLaw
from slipfold.models.friction.quantities import KINETIC, described
from slipfold.models.output import Expression, Symbols
from slipfold.models.parameter import Parameter

__all__ = ["Iwan", "Jenkins"]

_REFUSAL = (
    "{name} switches between stick and slip, and motion through such switches cannot be computed "
    "yet; BoucWen with b = c and a large exponent is its smooth relative"
)


@dataclass(frozen=True)
class Jenkins(FrictionLaw):
    r"""A spring in series with a Coulomb slider: elastic Coulomb friction.

    .. math::

        \dot F = k_t v \ \text{while}\ |F| < N \mu_k \ \text{or the slip reverses}, \qquad
        |F| \le N \mu_k

    The force is piecewise smooth. Its harmonic equivalents and its force along a given path are
    exact here; a model of smooth equations refuses the law.

    Parameters
    ----------
    mu_k
        Friction coefficient of the slider; no unit.
    kt
        Stiffness of the spring, in N/m.

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
    sticks: ClassVar[bool] = False
    refusal: ClassVar[str] = _REFUSAL.format(name="Jenkins")

    mu_k: float = described(replace(KINETIC, default=0.5, lower_open=True))
    kt: float = described(
        Parameter("kt", 1e4, "N/m", "stiffness of the contact", 0, lower_open=True, symbol="$k_t$")
    )

    def formula(self, speed: Expression, p: Symbols) -> Expression:
        """``mu_k``, in steady slip.

        Parameters
        ----------
        speed
            Slip speed in m/s.
        p
            The parameters by name.
        """
        return p["mu_k"]

    def traction(
        self, slip: tuple[Expression, ...], memory: tuple[Expression, ...], p: Symbols
    ) -> tuple[Expression, ...]:
        """Refuse: the force depends on the path, which `along` takes.

        Parameters
        ----------
        slip, memory, p
            Not used.
        """
        raise InputError(f"{self.refusal}; along() gives the force on a given path")

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
        """Return the force along a path of the counter-body on a line.

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
    """

    title: ClassVar[str] = "Iwan (Jenkins in parallel)"
    sticks: ClassVar[bool] = False
    refusal: ClassVar[str] = _REFUSAL.format(name="Iwan")

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

    def formula(self, speed: Expression, p: Symbols) -> Expression:
        """Sum of the elements' friction coefficients, in steady slip.

        Parameters
        ----------
        speed
            Slip speed in m/s.
        p
            Nothing: the elements are fixed.
        """
        return sum(element.mu_k for element in self.elements)

    def traction(
        self, slip: tuple[Expression, ...], memory: tuple[Expression, ...], p: Symbols
    ) -> tuple[Expression, ...]:
        """Refuse: the force depends on the path, which `along` takes.

        Parameters
        ----------
        slip, memory, p
            Not used.
        """
        raise InputError(f"{self.refusal}; along() gives the force on a given path")

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
