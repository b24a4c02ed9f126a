"""Friction laws without memory: Coulomb's, those that fall with the slip speed, smooth ones."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any, ClassVar

from slipfold.errors import InputError, about, suggest
from slipfold.models.friction.law import (
    KINETIC,
    STATIC,
    STRIBECK_SPEED,
    VISCOUS,
    ContactState,
    FrictionLaw,
    arctan,
    exp,
    sqrt,
    tanh,
)
from slipfold.models.parametric import described, structural
from slipfold.models.quantities import Expression, Symbols, nonnegative, positive
from slipfold.models.units import parse_quantity

_CONSTANT = replace(KINETIC, default=STATIC.default)


@dataclass(frozen=True)
class _ConstantCoefficients(FrictionLaw):
    """Base of laws with two coefficients, of which one that is given alone is both."""

    mu_s: Any = described(STATIC, None)
    mu_k: Any = described(_CONSTANT, None)

    def prepare(self) -> None:
        """Let the one coefficient be that of slip."""
        super().prepare()
        if self.mu_k is None:
            alone, value = self.mu_s is not None, STATIC.default
            if alone:
                with about("mu_s"):
                    value = STATIC.check(parse_quantity(self.mu_s, STATIC.unit, "mu_s"))
            object.__setattr__(self, "mu_k", value)
            object.__setattr__(self, "mu_s", None if alone else STATIC.default)


@dataclass(frozen=True)
class Coulomb(_ConstantCoefficients):
    r"""Coulomb friction, set-valued at rest.

    .. math::

        \mu(v) = \mu_k \quad (v > 0), \qquad |F| \le N \mu_s \quad (v = 0)

    In slip ``mu_k`` alone acts; ``mu_s`` says when a contact begins to slip. If one of them is
    given, it is both: the law has one parameter, ``mu_k``, and a change of it changes both.

    References
    ----------
    C. A. Coulomb, Théorie des machines simples, 1785; as a set-valued law: R. I. Leine and
    H. Nijmeijer, Dynamics and Bifurcations of Non-Smooth Mechanical Systems, Springer 2004.

    Examples
    --------
    >>> Coulomb(mu_s=0.5, mu_k=0.4).force((0.0, 3.0), normal=2.0)
    (0.0, 0.8)
    >>> Coulomb(mu_k=0.3).values, Coulomb(mu_k=0.3).stiction
    ({'mu_k': 0.3}, 0.3)
    """

    title: ClassVar[str] = "Coulomb"
    rate_independent: ClassVar[bool] = True

    def formula(self, speed: Expression, p: Symbols) -> Expression:
        """``mu_k``."""
        return p["mu_k"]


@dataclass(frozen=True)
class CoulombViscous(_ConstantCoefficients):
    r"""Coulomb friction and a part that grows with the slip speed.

    .. math::

        \mu(v) = \mu_k + \sigma_2 v \quad (v > 0), \qquad |F| \le N \mu_s \quad (v = 0)

    If one of ``mu_s`` and ``mu_k`` is given, it is both, and the parameter ``mu_k``.

    References
    ----------
    H. Olsson, K. J. Åström, C. Canudas de Wit, M. Gäfvert and P. Lischinsky, Friction models and
    friction compensation, European Journal of Control 4 (1998) 176-195.

    Examples
    --------
    >>> CoulombViscous(mu_k=0.4, s2=0.1).coefficient(2.0)
    0.6000000000000001
    """

    title: ClassVar[str] = "Coulomb and viscous"

    s2: float = described(replace(VISCOUS, default=0.1))

    def formula(self, speed: Expression, p: Symbols) -> Expression:
        """``mu_k + s2 v``."""
        return p["mu_k"] + p["s2"] * speed


def _checked_exponent(exponent: Any, title: str) -> int:
    if exponent not in (1, 2):
        raise InputError(f"exponent = {exponent!r} is not known; give 1 or 2")
    return int(exponent)


@dataclass(frozen=True)
class Stribeck(FrictionLaw):
    r"""Friction that falls exponentially from the static to the kinetic coefficient.

    .. math::

        \mu(v) = \mu_k + (\mu_s - \mu_k) e^{-(v/v_s)^n} + \sigma_2 v

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
    exponent: int = structural("the exponent n: 1 (Tustin) or 2 (Gaussian)", 1, _checked_exponent)

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
        nonnegative(
            "d", 3.0, "s/m", "inverse of the speed at which friction is halved", r"$\delta$"
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

    References
    ----------
    J. J. Thomsen and A. Fidlin, Analytical approximations for stick-slip vibration amplitudes,
    International Journal of Non-Linear Mechanics 38 (2003) 389-403.

    Examples
    --------
    >>> round(CubicStribeck(mu_s=0.4, mu_m=0.25, vm=0.5).coefficient(0.5), 12)
    0.25
    """

    title: ClassVar[str] = "cubic Stribeck"

    mu_s: float = described(STATIC)
    mu_m: float = described(
        nonnegative("mu_m", 0.3, "", "smallest friction coefficient", r"$\mu_m$")
    )
    vm: float = described(positive("vm", 0.5, "m/s", "speed of the smallest friction", "$v_m$"))

    @property
    def typical_speed(self) -> float:
        """A third of ``vm``."""
        return self.vm / 3

    def formula(self, speed: Expression, p: Symbols) -> Expression:
        """``mu_s - (mu_s - mu_m) v (3 - v^2/vm^2)/(2 vm)``."""
        ratio = speed / p["vm"]
        fall = ratio * (1.5 - 0.5 * (ratio * ratio))
        return p["mu_s"] - (p["mu_s"] - p["mu_m"]) * fall


_SHAPES = ("tanh", "atan", "sqrt")

_FLOOR = 1e-8
"""|v| is read as sqrt(v^2 + (1e-8 e)^2): the same number to rounding, and smooth at rest."""


@dataclass(frozen=True)
class Regularized(FrictionLaw):
    r"""A law without memory that rises from zero over a small slip speed instead of jumping.

    .. math::

        \mu(v) = \mu_{law}(v)\, g(v/\varepsilon), \quad
        g(s) = \tanh s,\ \tfrac{2}{\pi} \arctan s\ \text{or}\ s/\sqrt{s^2 + 1}

    with the modulus v of the slip velocity, so that the force keeps its direction in the plane. The
    contact never sticks: it creeps under any load. As e goes to 0 trajectories converge to those of
    the law, but slowly: the period of a stick-slip orbit may still be wrong by 1% at a small e.

    References
    ----------
    P. Wriggers, Computational Contact Mechanics, Springer 2006, on the regularization of Coulomb's
    law (``"tanh"``, ``"sqrt"``); R. I. Leine, D. H. van Campen, A. de Kraker and L. van den Steen,
    Nonlinear Dynamics 16 (1998) 41-54 (``"atan"``).

    Examples
    --------
    >>> from slipfold import Coulomb
    >>> law = Regularized(Coulomb(mu_k=0.5), "sqrt", e=0.03)
    >>> round(law.coefficient(0.04), 12), law.sticks
    (0.4, False)
    """

    title: ClassVar[str] = "regularized"
    sticks: ClassVar[bool] = False

    law: FrictionLaw = structural(
        "the law, one without memory; its parameters are parameters of this one",
        metadata={"entry": "of"},
    )
    shape: str = structural('``"tanh"``, ``"atan"`` or ``"sqrt"``', "tanh")
    e: float = described(
        positive(
            "e", 1e-3, "m/s", "slip speed over which friction rises from zero", r"$\varepsilon$"
        )
    )

    def prepare(self) -> None:
        """Refuse laws that are smooth or no laws at all, and unknown shapes."""
        if not isinstance(self.law, FrictionLaw):
            raise InputError(f"{self.law!r} is not a friction law; give one such as Coulomb()")
        if not self.law.sticks:
            raise InputError(
                f"{type(self.law).__name__} does not jump at zero slip; regularize a law that does"
            )
        if self.shape not in _SHAPES:
            raise InputError(
                f"shape = {self.shape!r} is not known; {suggest(str(self.shape), _SHAPES)}"
                f"give {', '.join(_SHAPES[:-1])} or {_SHAPES[-1]}"
            )

    @property
    def label(self) -> str:
        """What figures call the law."""
        return f"{self.law.label}, regularized ({self.shape})"

    @property
    def typical_speed(self) -> float:
        """The maximum of that of the law and 5 e."""
        return max(self.law.typical_speed, 5 * self.e)

    def formula(self, speed: Expression, p: Symbols) -> Expression:
        """``mu0(v) g(v/e)``, ``g(x)`` = ``tanh(x)``, ``2 atan(x)/pi`` or ``x/sqrt(x^2 + 1)``."""
        return self.law.formula(speed, p) * self._rise(speed / p["e"])

    def forces(self, contact: ContactState, p: Symbols) -> tuple[Expression, ...]:
        """Return the friction force, smooth at rest."""
        slip, square = contact.slip, contact.square
        floor = _FLOOR * p["e"]
        speed = sqrt(square + floor * floor)
        size = contact.normal * self.law.formula(speed, p)
        if len(slip) == 1:
            # The rise is odd, so a line needs no division by a speed that may vanish.
            return (size * self._rise(slip[0] / p["e"]),)
        if self.shape == "sqrt":
            drag = size * (square + p["e"] * p["e"]) ** -0.5
        else:
            drag = size * self._rise(speed / p["e"]) / speed
        return tuple(drag * component for component in slip)

    def _rise(self, ratio: Expression) -> Expression:
        if self.shape == "tanh":
            return tanh(ratio)
        if self.shape == "atan":
            return (2 / math.pi) * arctan(ratio)
        return ratio * (ratio * ratio + 1.0) ** -0.5
