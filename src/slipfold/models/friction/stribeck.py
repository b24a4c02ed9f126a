"""Laws whose friction falls with the slip speed: exponential, rational, cubic."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from slipfold.errors import InputError
from slipfold.models.friction.functions import exp
from slipfold.models.friction.law import FrictionLaw
from slipfold.models.friction.quantities import (
    KINETIC,
    STATIC,
    STRIBECK_SPEED,
    VISCOUS,
    check_static,
    described,
)
from slipfold.models.output import Expression, Symbols
from slipfold.models.parameter import Parameter

_EXPONENTS = (1, 2)


@dataclass(frozen=True)
class Stribeck(FrictionLaw):
    r"""Friction that falls exponentially from the static to the kinetic coefficient.

    .. math::

        \mu(v) = \mu_k + (\mu_s - \mu_k) e^{-(v/v_s)^n} + \sigma_2 v

    Parameters
    ----------
    mu_s
        Static friction coefficient, at least `mu_k`; no unit.
    mu_k
        Kinetic friction coefficient; no unit.
    vs
        Speed over which friction falls, in m/s.
    s2
        Viscous friction: coefficient per slip speed, in s/m.
    exponent
        The exponent n: 1 (Tustin) or 2 (Gaussian).

    References
    ----------
    A. Tustin, IEE Journal 94 (1947) 143-151 (n = 1); L. C. Bo and D. Pavelescu, The friction-speed
    relation and its influence on the critical velocity of stick-slip motion, Wear 82 (1982)
    277-289; B. Armstrong-Hélouvry, P. Dupont and C. Canudas de Wit, Automatica 30 (1994) 1083-1138.

    Examples
    --------
    >>> law = Stribeck(mu_s=0.4, mu_k=0.3, vs="100 mm/s")
    >>> round(law.coefficient(0.1), 6), round(law.slope(0.1), 6)
    (0.336788, -0.367879)
    """

    title: ClassVar[str] = "exponential Stribeck"

    mu_s: float = described(STATIC)
    mu_k: float = described(KINETIC)
    vs: float = described(STRIBECK_SPEED)
    s2: float = described(VISCOUS)
    exponent: int = 1

    def check(self, values: Mapping[str, float]) -> None:
        """Refuse ``mu_s < mu_k``."""
        check_static(values)

    def check_structure(self) -> None:
        """Refuse an exponent other than 1 and 2."""
        if self.exponent not in _EXPONENTS:
            raise InputError(f"exponent = {self.exponent!r} is not known; give 1 or 2")
        object.__setattr__(self, "exponent", int(self.exponent))

    @property
    def typical_speed(self) -> float:
        """``vs``."""
        return self.vs

    def formula(self, speed: Expression, p: Symbols) -> Expression:
        """``mu_k + (mu_s - mu_k) exp(-(v/vs)^n) + s2 v``."""
        ratio = speed / p["vs"]
        power = ratio if self.exponent == 1 else ratio * ratio
        return p["mu_k"] + (p["mu_s"] - p["mu_k"]) * exp(-power) + p["s2"] * speed


@dataclass(frozen=True)
class RationalStribeck(FrictionLaw):
    r"""Friction that falls as a hyperbola, without a lower level.

    .. math::

        \mu(v) = \mu_s/(1 + \delta v)

    Parameters
    ----------
    mu_s
        Static friction coefficient; no unit.
    d
        The inverse of the speed at which friction is halved, in s/m.

    References
    ----------
    R. I. Leine, D. H. van Campen, A. de Kraker and L. van den Steen, Stick-slip vibrations induced
    by alternate friction models, Nonlinear Dynamics 16 (1998) 41-54.

    Examples
    --------
    >>> RationalStribeck(mu_s=1.0, d=3.0).coefficient(1.0)
    0.25
    """

    title: ClassVar[str] = "rational Stribeck"

    mu_s: float = described(STATIC)
    d: float = described(
        Parameter(
            "d",
            3.0,
            "s/m",
            "inverse of the speed at which friction is halved",
            0,
            symbol=r"$\delta$",
        )
    )

    @property
    def typical_speed(self) -> float:
        """``1/d``, no more than 1 m/s."""
        return 1.0 / max(self.d, 1.0)

    def formula(self, speed: Expression, p: Symbols) -> Expression:
        """``mu_s/(1 + d v)``."""
        return p["mu_s"] / (1.0 + p["d"] * speed)


@dataclass(frozen=True)
class CubicStribeck(FrictionLaw):
    r"""Friction that falls to a minimum and rises again, as a cubic.

    .. math::

        \mu(v) = \mu_s - a v + b v^3, \quad
        a = \tfrac32 (\mu_s - \mu_m)/v_m, \quad b = (\mu_s - \mu_m)/(2 v_m^3)

    so that the minimum ``mu_m`` lies at the speed ``vm``. Well above ``vm`` the cubic grows beyond
    any friction; the law is meant for speeds up to about twice ``vm``.

    Parameters
    ----------
    mu_s
        Static friction coefficient, at least `mu_m`; no unit.
    mu_m
        Smallest friction coefficient; no unit.
    vm
        Speed of the smallest friction, in m/s.

    References
    ----------
    J. J. Thomsen and A. Fidlin, Analytical approximations for stick-slip vibration amplitudes,
    International Journal of Non-Linear Mechanics 38 (2003) 389-403.

    Examples
    --------
    >>> law = CubicStribeck(mu_s=0.4, mu_m=0.25, vm=0.5)
    >>> round(law.a, 12), round(law.b, 12), round(law.coefficient(0.5), 12)
    (0.45, 0.6, 0.25)
    """

    title: ClassVar[str] = "cubic Stribeck"

    mu_s: float = described(STATIC)
    mu_m: float = described(
        Parameter("mu_m", 0.3, "", "smallest friction coefficient", 0, symbol=r"$\mu_m$")
    )
    vm: float = described(
        Parameter(
            "vm", 0.5, "m/s", "speed of the smallest friction", 0, lower_open=True, symbol="$v_m$"
        )
    )

    def check(self, values: Mapping[str, float]) -> None:
        """Refuse ``mu_s < mu_m``."""
        if values["mu_s"] < values["mu_m"]:
            raise InputError(
                f"mu_s = {values['mu_s']:g} is below mu_m = {values['mu_m']:g}, the smallest "
                "friction coefficient; give mu_s >= mu_m"
            )

    @property
    def a(self) -> float:
        """The linear coefficient, ``1.5 (mu_s - mu_m)/vm``, in s/m."""
        return 1.5 * (self.mu_s - self.mu_m) / self.vm

    @property
    def b(self) -> float:
        """The cubic coefficient, ``(mu_s - mu_m)/(2 vm^3)``, in (s/m)^3."""
        return (self.mu_s - self.mu_m) / (2 * self.vm**3)

    @property
    def typical_speed(self) -> float:
        """A third of ``vm``."""
        return self.vm / 3

    def formula(self, speed: Expression, p: Symbols) -> Expression:
        """``mu_s - a v + b v^3``."""
        ratio = speed / p["vm"]
        fall = ratio * (1.5 - 0.5 * (ratio * ratio))
        return p["mu_s"] - (p["mu_s"] - p["mu_m"]) * fall
