"""The Bouc-Wen law: smooth hysteresis with an adjustable knee."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from slipfold.errors import InputError
from slipfold.models.formulas.whole_power import whole_power
from slipfold.models.friction.contact_state import ContactState
from slipfold.models.friction.functions import sqrt
from slipfold.models.friction.memory_law import MemoryLaw
from slipfold.models.friction.quantities import REST_SPEED, checked_exponent, described
from slipfold.models.output import Expression, Symbols
from slipfold.models.parameter import Parameter


@dataclass(frozen=True)
class BoucWen(MemoryLaw):
    r"""Bouc-Wen hysteresis as a friction law; the knee sharpens with the exponent.

    .. math::

        \dot z = A v - b |v| |z|^{n-1} z - c v |z|^n, \qquad F = N z

    with a deflection z that has no unit. The friction coefficient in steady slip is
    :math:`(A/(b + c))^{1/n}`. In the plane

    .. math::

        \dot z = A v - |z|^{n-2} z\, (b |v \cdot z| + c\, v \cdot z)

    which is the same on a line and treats all directions alike. :math:`|v \cdot z|` is rounded off
    at :math:`\varepsilon \mu`, so that slip may reverse; speeds of interest are well above
    :math:`\varepsilon`. With b = c a contact unloads along a straight line, and as n grows the law
    tends to the elastic Coulomb contact of a Jenkins element under a constant normal force.

    Parameters
    ----------
    A
        Stiffness of the contact over the normal force, in 1/m.
    b, c
        Shape of the loop, in 1/m; ``|c| <= b``, or the contact would give energy.
    e
        Speed below which \|v\| is rounded off, in m/s.
    exponent
        The exponent n, an even whole number.

    References
    ----------
    R. Bouc, Modèle mathématique d'hystérésis, Acustica 24 (1971) 16-25; Y. K. Wen, Method for
    random vibration of hysteretic systems, Journal of the Engineering Mechanics Division 102 (1976)
    249-263; in the plane, though not alike in all directions: Y. J. Park, Y. K. Wen and
    A. H.-S. Ang, Earthquake Engineering and Structural Dynamics 14 (1986).

    Examples
    --------
    >>> round(BoucWen(A=1e3, b=2e3, c=2e3).coefficient(0.1), 12)
    0.5
    """

    title: ClassVar[str] = "Bouc-Wen"
    unit: ClassVar[str] = ""

    A: float = described(
        Parameter(
            "A", 1e4, "1/m", "stiffness of the contact over the normal force", 0, lower_open=True
        )
    )
    b: float = described(
        Parameter("b", 2e4, "1/m", "shape of the loop: share that depends on |v|", 0)
    )
    c: float = described(Parameter("c", 2e4, "1/m", "shape of the loop: share that depends on v"))
    e: float = described(REST_SPEED)
    exponent: int = 2

    def check(self, values: Mapping[str, float]) -> None:
        """Refuse shapes whose deflection is unbounded or that give energy."""
        b, c = values["b"], values["c"]
        if not b + c > 0:
            raise InputError(
                f"b + c = {b + c:g} 1/m is not positive, so the friction force would have no "
                "limit; give b + c > 0"
            )
        if abs(c) > b:
            raise InputError(
                f"c = {c:g} 1/m is larger than b = {b:g} 1/m, so the contact would give energy; "
                "give |c| <= b"
            )

    def check_structure(self) -> None:
        """Refuse exponents for which the equations are not smooth."""
        object.__setattr__(self, "exponent", checked_exponent(self.exponent))

    @property
    def memory_scale(self) -> float:
        """The friction coefficient in steady slip."""
        return float(self._limit(self.values))

    def formula(self, speed: Expression, p: Symbols) -> Expression:
        """``(A/(b + c))^(1/n)``, whatever the speed."""
        return self._limit(p)

    def traction(self, contact: ContactState, p: Symbols) -> tuple[Expression, ...]:
        """The deflection itself."""
        return contact.memory

    def rates_of_memory(self, contact: ContactState, p: Symbols) -> tuple[Expression, ...]:
        """``A v - |z|^(n-2) z (b |v.z| + c v.z)``."""
        slip, memory = contact.slip, contact.memory
        power = sum(v * z for v, z in zip(slip, memory, strict=True))
        floor = p["e"] * self._limit(p)
        fading = p["b"] * sqrt(power * power + floor * floor) + p["c"] * power
        square = sum(z * z for z in memory)
        fading = fading * whole_power(square, self.exponent // 2 - 1)
        return tuple(p["A"] * v - fading * z for v, z in zip(slip, memory, strict=True))

    def steady_deflection(self, speed: float) -> float:
        """The friction coefficient in steady slip, whatever the speed."""
        return self.memory_scale

    def _limit(self, p: Symbols) -> Expression:
        return (p["A"] / (p["b"] + p["c"])) ** (1.0 / self.exponent)
