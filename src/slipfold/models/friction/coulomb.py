"""Coulomb's law, alone and with viscous friction."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import ClassVar

from slipfold.models.friction.law import FrictionLaw
from slipfold.models.friction.quantities import KINETIC, STATIC, VISCOUS, check_static, described
from slipfold.models.output import Expression, Symbols


@dataclass(frozen=True)
class Coulomb(FrictionLaw):
    r"""Coulomb friction, set-valued at rest.

    .. math::

        \mu(v) = \mu_k \quad (v > 0), \qquad |F| \le N \mu_s \quad (v = 0)

    Where every motion slides, ``mu_k`` alone acts; ``mu_s`` says when a contact at rest lets go.

    Parameters
    ----------
    mu_s
        Static friction coefficient, at least `mu_k`; no unit.
    mu_k
        Kinetic friction coefficient; no unit.

    References
    ----------
    C. A. Coulomb, Théorie des machines simples, 1785; as a set-valued law: R. I. Leine and
    H. Nijmeijer, Dynamics and Bifurcations of Non-Smooth Mechanical Systems, Springer 2004.

    Examples
    --------
    >>> Coulomb(mu_s=0.5, mu_k=0.4).force((3.0, 4.0), normal=2.0)
    (0.48, 0.64)
    """

    title: ClassVar[str] = "Coulomb"

    mu_s: float = described(STATIC)
    mu_k: float = described(replace(KINETIC, default=0.5))

    def check(self, values: Mapping[str, float]) -> None:
        """Refuse ``mu_s < mu_k``."""
        check_static(values)

    def holding(self, p: Symbols) -> Expression:
        """``mu_s``."""
        return p["mu_s"]

    def formula(self, speed: Expression, p: Symbols) -> Expression:
        """``mu_k``."""
        return p["mu_k"]


@dataclass(frozen=True)
class CoulombViscous(FrictionLaw):
    r"""Coulomb friction and a part that grows with the slip speed.

    .. math::

        \mu(v) = \mu_k + \sigma_2 v \quad (v > 0), \qquad |F| \le N \mu_s \quad (v = 0)

    Parameters
    ----------
    mu_s
        Static friction coefficient, at least `mu_k`; no unit.
    mu_k
        Kinetic friction coefficient; no unit.
    s2
        Viscous friction: coefficient per slip speed, in s/m.

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

    mu_s: float = described(STATIC)
    mu_k: float = described(replace(KINETIC, default=0.5))
    s2: float = described(replace(VISCOUS, default=0.1))

    def check(self, values: Mapping[str, float]) -> None:
        """Refuse ``mu_s < mu_k``."""
        check_static(values)

    def holding(self, p: Symbols) -> Expression:
        """``mu_s``."""
        return p["mu_s"]

    def formula(self, speed: Expression, p: Symbols) -> Expression:
        """``mu_k + s2 v``."""
        return p["mu_k"] + p["s2"] * speed
