"""Friction laws made smooth at rest: the jump at zero slip becomes a steep rise."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Self

from slipfold.errors import InputError
from slipfold.models.friction.contact_state import ContactState
from slipfold.models.friction.functions import arctan, sqrt, tanh
from slipfold.models.friction.law import FrictionLaw
from slipfold.models.friction.quantities import declared, described
from slipfold.models.output import Expression, Symbols
from slipfold.models.parameter import Parameter
from slipfold.models.suggestion import suggest

_SHAPES = ("tanh", "atan", "sqrt")

_FLOOR = 1e-8
"""|v| is read as sqrt(v^2 + (1e-8 e)^2): the same number to rounding, and smooth at rest."""


@dataclass(frozen=True)
class Regularised(FrictionLaw):
    r"""A law without memory that rises from zero over a small slip speed instead of jumping.

    .. math::

        \mu(v) = \mu_{law}(v)\, g(v/\varepsilon), \quad
        g(s) = \tanh s,\ \tfrac{2}{\pi} \arctan s\ \text{or}\ s/\sqrt{s^2 + 1}

    with the modulus v of the slip velocity, so that the force keeps its direction in the plane. The
    contact never sticks: it creeps under any load. As e goes to 0 motion follows the law, but
    slowly: the period of a stick-slip motion may still be wrong by 1% at a small e.

    Parameters
    ----------
    law
        The law, one without memory; its parameters are parameters of this one.
    shape
        ``"tanh"``, ``"atan"`` or ``"sqrt"``.
    e
        Slip speed of the rise, in m/s.

    References
    ----------
    P. Wriggers, Computational Contact Mechanics, Springer 2006, on the regularisation of Coulomb's
    law (``"tanh"``, ``"sqrt"``); R. I. Leine, D. H. van Campen, A. de Kraker and L. van den Steen,
    Nonlinear Dynamics 16 (1998) 41-54 (``"atan"``).

    Examples
    --------
    >>> from slipfold.models.friction import Coulomb
    >>> law = Regularised(Coulomb(mu_k=0.5), "sqrt", e=0.03)
    >>> round(law.coefficient(0.04), 12), law.sticks
    (0.4, False)
    """

    title: ClassVar[str] = "regularised"
    sticks: ClassVar[bool] = False

    law: FrictionLaw
    shape: str = "tanh"
    e: float = described(
        Parameter(
            "e",
            1e-3,
            "m/s",
            "slip speed over which friction rises from zero",
            0,
            lower_open=True,
            symbol=r"$\varepsilon$",
        )
    )

    def check_structure(self) -> None:
        """Refuse laws that are smooth or no laws at all, and unknown shapes."""
        if not isinstance(self.law, FrictionLaw):
            raise InputError(f"{self.law!r} is no friction law; give one such as Coulomb()")
        if not self.law.sticks:
            raise InputError(
                f"{type(self.law).__name__} does not jump at zero slip; regularise a law that does"
            )
        if self.shape not in _SHAPES:
            raise InputError(
                f"shape = {self.shape!r} is not known; {suggest(str(self.shape), _SHAPES)}"
                f"give {', '.join(_SHAPES[:-1])} or {_SHAPES[-1]}"
            )

    def check(self, values: Mapping[str, float]) -> None:
        """Refuse values that contradict each other in the law."""
        self.law.check(values)

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """Those of the law, and ``e``."""
        return (*self.law.parameters, *declared(Regularised))

    @property
    def values(self) -> dict[str, float]:
        """Values of the parameters by name, in SI units."""
        return {**self.law.values, "e": self.e}

    @property
    def kind(self) -> Self:
        """The law with default values."""
        return type(self)(self.law.kind, self.shape)

    @property
    def label(self) -> str:
        """What figures call the law."""
        return f"{self.law.label}, regularised ({self.shape})"

    @property
    def typical_speed(self) -> float:
        """That of the law; no less than 5 e."""
        return max(self.law.typical_speed, 5 * self.e)

    def replace(self, **changes: Any) -> Self:
        """Return a new law with some values changed, its own or the law's.

        Raises
        ------
        InputError
            For an unknown name or a value that cannot be used.
        """
        own = {name: value for name, value in changes.items() if name in ("law", "shape", "e")}
        inner = {name: value for name, value in changes.items() if name not in own}
        law = own.pop("law", self.law)
        return super().replace(law=law.replace(**inner) if inner else law, **own)

    def formula(self, speed: Expression, p: Symbols) -> Expression:
        """The law's coefficient times the rise."""
        return self.law.formula(speed, p) * self._rise(speed / p["e"])

    def traction(self, contact: ContactState, p: Symbols) -> tuple[Expression, ...]:
        """Friction force over normal force, smooth at rest."""
        slip, square = contact.slip, contact.square
        floor = _FLOOR * p["e"]
        speed = sqrt(square + floor * floor)
        mu = self.law.formula(speed, p)
        if len(slip) == 1:
            # The rise is odd, so a line needs no division by a speed that may vanish.
            return (mu * self._rise(slip[0] / p["e"]),)
        if self.shape == "sqrt":
            drag = mu * (square + p["e"] * p["e"]) ** -0.5
        else:
            drag = mu * self._rise(speed / p["e"]) / speed
        return tuple(drag * component for component in slip)

    def _rise(self, ratio: Expression) -> Expression:
        if self.shape == "tanh":
            return tanh(ratio)
        if self.shape == "atan":
            return (2 / math.pi) * arctan(ratio)
        return ratio * (ratio * ratio + 1.0) ** -0.5
