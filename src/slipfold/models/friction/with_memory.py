"""Friction laws with a memory: bristles that bend (Dahl, LuGre), smooth hysteresis (Bouc-Wen)."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar

from slipfold.errors import InputError
from slipfold.models.formulas.functions import whole_power
from slipfold.models.friction.law import (
    KINETIC,
    REST_SPEED,
    STATIC,
    STRIBECK_SPEED,
    VISCOUS,
    ContactState,
    MemoryLaw,
    exp,
    sqrt,
)
from slipfold.models.parametric import described, structural
from slipfold.models.quantities import Expression, Parameter, Symbols, nonnegative, positive

BRISTLE_STIFFNESS = positive(
    "s0", 1e4, "1/m", "stiffness of the contact over the normal force", r"$\sigma_0$"
)


def checked_exponent(exponent: Any, title: str) -> int:
    """Return the exponent of a knee as a whole number."""
    number = isinstance(exponent, int | float) and not isinstance(exponent, bool)
    if not (number and exponent >= 2 and exponent % 2 == 0):
        raise InputError(
            f"exponent = {exponent!r} is not an even whole number; with others |z| is not smooth "
            "at z = 0, give e.g. 2"
        )
    return int(exponent)


@dataclass(frozen=True)
class _Bristles(MemoryLaw):
    """Common part: ``z' = v - s0 |v| z/g(|v|)`` with |v| rounded off at rest."""

    @abstractmethod
    def _level(self, square: Expression, p: Symbols) -> Expression:
        """Return the coefficient g to which steady slip bends the bristles."""

    @property
    def memory_scale(self) -> float:
        """Deflection under the largest friction, in m."""
        p = self.values
        return max(float(self._level(0.0, p)), 1e-3) / p["s0"]

    def memory_rates(self, contact: ContactState, p: Symbols) -> tuple[Expression, ...]:
        """``v - s0 |v| z/g(|v|)``."""
        square = contact.square
        fading = p["s0"] * _rounded(square, p) / self._level(square, p)
        return tuple(v - fading * z for v, z in zip(contact.slip, contact.memory, strict=True))

    def steady_deflection(self, speed: float) -> float:
        """``g v/(s0 sqrt(v^2 + e^2))``, in m."""
        p, square = self.values, speed * speed
        return float(self._level(square, p) * speed / (p["s0"] * _rounded(square, p)))


@dataclass(frozen=True)
class Dahl(_Bristles):
    r"""Dahl's law: a contact that yields like a spring before it slips, with the exponent 1.

    .. math::

        \dot z = v - \sigma_0 |v| z/\mu_k, \qquad F = N \sigma_0 z

    With a constant normal force this is :math:`\dot F = N \sigma_0 v (1 - F \operatorname{sgn}
    v/(N \mu_k))`. In the plane z and v are vectors and ``|v|`` is the modulus of v as a whole,
    so that the law is isotropic. It is rounded off to :math:`\sqrt{v^2 + \varepsilon^2}`, so that
    slip may reverse; at rest the bristles therefore creep with the rate
    :math:`\sigma_0 \varepsilon/\mu_k`. A small e is a sharp corner where the slip passes through
    zero, and there a branch may fail.

    References
    ----------
    P. R. Dahl, A solid friction model, The Aerospace Corporation, TOR-0158(3107-18)-1, 1968.

    Examples
    --------
    >>> law = Dahl(mu_k=0.4, s0=1e3)
    >>> [round(part, 6) for part in law.force((0.1,), 2.0, memory=(2e-4,))]
    [0.4]
    """

    title: ClassVar[str] = "Dahl"

    mu_k: float = described(replace(KINETIC, default=0.5, lower_open=True))
    s0: float = described(BRISTLE_STIFFNESS)
    e: float = described(REST_SPEED)

    def _level(self, square: Expression, p: Symbols) -> Expression:
        return p["mu_k"]

    def formula(self, speed: Expression, p: Symbols) -> Expression:
        """``g(v) v/sqrt(v^2 + e^2)``, ``g(v) = mu_k``."""
        return p["mu_k"] * speed / _rounded(speed * speed, p)

    def forces(self, contact: ContactState, p: Symbols) -> tuple[Expression, ...]:
        """``N s0 z``."""
        return tuple(contact.normal * (p["s0"] * z) for z in contact.memory)


@dataclass(frozen=True)
class LuGre(_Bristles):
    r"""The LuGre law: bending bristles whose hold weakens with the slip speed.

    .. math::

        \dot z = v - \sigma_0 |v| z/g(|v|), \quad
        g = \mu_k + (\mu_s - \mu_k) e^{-(v/v_s)^2}, \quad
        F = N (\sigma_0 z + \sigma_1 \dot z + \sigma_2 v)

    As in `Dahl`, ``|v|`` is the modulus of the vector v in the plane, rounded off to
    :math:`\sqrt{v^2 + \varepsilon^2}`; the bristles creep with the rate
    :math:`\sigma_0 \varepsilon/\mu_s` at rest.

    References
    ----------
    C. Canudas de Wit, H. Olsson, K. J. Åström and P. Lischinsky, A new model for control of systems
    with friction, IEEE Transactions on Automatic Control 40 (1995) 419-425; with the normal force
    as a factor and in the plane: E. Velenis, P. Tsiotras, C. Canudas-de-Wit and M. Sorine, Dynamic
    tyre friction models for combined longitudinal and lateral vehicle motion, Vehicle System
    Dynamics, 2005.

    Examples
    --------
    >>> law = LuGre(mu_s=0.5, mu_k=0.3, vs=0.1)
    >>> slip = (0.3, 0.4)
    >>> [round(part, 6) for part in law.force(slip, 2.0, law.steady_memory(slip))]
    [0.36, 0.48]
    """

    title: ClassVar[str] = "LuGre"

    mu_s: float = described(STATIC)
    mu_k: float = described(replace(KINETIC, lower_open=True))
    vs: float = described(STRIBECK_SPEED)
    s0: float = described(BRISTLE_STIFFNESS)
    s1: float = described(
        nonnegative(
            "s1", 0.1, "s/m", "damping of the bristles over the normal force", r"$\sigma_1$"
        )
    )
    s2: float = described(VISCOUS)
    e: float = described(REST_SPEED)

    def _level(self, square: Expression, p: Symbols) -> Expression:
        ratio = square / (p["vs"] * p["vs"])
        return p["mu_k"] + (p["mu_s"] - p["mu_k"]) * exp(-ratio)

    def formula(self, speed: Expression, p: Symbols) -> Expression:
        """``g(v) v/sqrt(v^2 + e^2) + s2 v``, ``g(v) = mu_k + (mu_s - mu_k) exp(-(v/vs)^2)``."""
        square = speed * speed
        return speed * (self._level(square, p) / _rounded(square, p) + p["s2"])

    def forces(self, contact: ContactState, p: Symbols) -> tuple[Expression, ...]:
        """``N (s0 z + s1 z' + s2 v)``."""
        rates = self.memory_rates(contact, p)
        return tuple(
            contact.normal * (p["s0"] * z + p["s1"] * rate + p["s2"] * v)
            for v, z, rate in zip(contact.slip, contact.memory, rates, strict=True)
        )


def _rounded(square: Expression, p: Symbols) -> Expression:
    """Return sqrt(v^2 + e^2), smooth at rest."""
    return sqrt(square + p["e"] * p["e"])


@dataclass(frozen=True)
class BoucWen(MemoryLaw):
    r"""Bouc-Wen hysteresis as a friction law; the knee sharpens with the exponent.

    .. math::

        \dot z = A v - b |v| |z|^{n-1} z - c v |z|^n, \qquad F = N z

    with a deflection z that has no unit. The friction coefficient in steady slip is
    :math:`(A/(b + c))^{1/n}`. In the plane

    .. math::

        \dot z = A v - |z|^{n-2} z\, (b |v \cdot z| + c\, v \cdot z)

    which is the same on a line and isotropic. :math:`|v \cdot z|` is rounded off at
    :math:`\varepsilon \mu`, so that slip may reverse; speeds of interest are well above
    :math:`\varepsilon`. With ``|c| > b`` the contact would give energy. With b = c it unloads along
    a straight line, and as n grows the law tends to the elastic Coulomb contact of a Jenkins
    element under a constant normal force.

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
        positive("A", 1e4, "1/m", "stiffness of the contact over the normal force", "$A$")
    )
    b: float = described(
        nonnegative("b", 2e4, "1/m", "shape of the loop: part that depends on |v|", "$b$")
    )
    c: float = described(
        Parameter("c", 2e4, "1/m", "shape of the loop: part that depends on v", symbol="$c$")
    )
    e: float = described(REST_SPEED)
    exponent: int = structural("the exponent n, an even whole number", 2, checked_exponent)

    def check(self, values: Mapping[str, float]) -> None:
        """Refuse shapes whose deflection is unbounded or that give energy."""
        super().check(values)
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

    @property
    def memory_scale(self) -> float:
        """The friction coefficient in steady slip."""
        return float(self._limit(self.values))

    def formula(self, speed: Expression, p: Symbols) -> Expression:
        """``(A/(b + c))^(1/n)``, whatever the speed."""
        return self._limit(p)

    def forces(self, contact: ContactState, p: Symbols) -> tuple[Expression, ...]:
        """``N z``."""
        return tuple(contact.normal * z for z in contact.memory)

    def memory_rates(self, contact: ContactState, p: Symbols) -> tuple[Expression, ...]:
        """``A v - |z|^(n-2) z (b |v·z| + c v·z)``."""
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
