"""Springs along one direction: linear with a damper, cubic, polynomial."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, Self

from slipfold.errors import InputError
from slipfold.models.formulas.whole_power import whole_power
from slipfold.models.friction.quantities import described
from slipfold.models.output import Expression, Symbols
from slipfold.models.parameter import Parameter
from slipfold.models.quantity import parse_quantity
from slipfold.models.structures.components.component import Motion
from slipfold.models.structures.components.one_direction import OneDirection
from slipfold.models.structures.components.sums import total
from slipfold.models.structures.shown import shown

HIGHEST = 15
"""Highest power of a polynomial: beyond it, fitted coefficients are seldom worth anything."""


@dataclass(frozen=True)
class LinearSpring(OneDirection):
    r"""A linear spring with a damper beside it: the force :math:`-(k u + c \dot u)`.

    Parameters
    ----------
    at
        Degree of freedom, or weights by name, such as ``{"a": 1, "b": -1}`` between two.
    k
        Stiffness in N/m; negative for one that pushes away from rest.
    c
        Damping in N s/m.
    name
        Tells springs apart; empty if there is one only.

    Examples
    --------
    >>> LinearSpring("tip", k="2 kN/m").k
    2000.0
    """

    title: ClassVar[str] = "linear spring"

    k: float = described(Parameter("k", 1.0, "N/m", "stiffness of a spring", symbol="$k$"))
    c: float = described(Parameter("c", 0.0, "N s/m", "damping beside a spring", 0, symbol="$c$"))

    def forces(
        self, motion: Motion, c: Symbols, phase: Expression
    ) -> tuple[Expression | None, ...]:
        """``-(k u + c v)``."""
        (u,), (v,) = motion.displacement, motion.velocity
        return (-(c["k"] * u + c["c"] * v),)

    def potential(self, motion: Motion, c: Symbols) -> Expression | None:
        """``k u^2/2``."""
        (u,) = motion.displacement
        return 0.5 * c["k"] * u * u

    def dissipation(self, motion: Motion, c: Symbols) -> Expression | None:
        """``c v^2``."""
        (v,) = motion.velocity
        return c["c"] * v * v


@dataclass(frozen=True)
class CubicSpring(OneDirection):
    r"""A cubic spring: the force :math:`-k_3 u^3`.

    Parameters
    ----------
    at
        Degree of freedom, or weights by name.
    k3
        Cubic stiffness in N/m^3; negative for one that softens.
    name
        Tells springs apart; empty if there is one only.

    Examples
    --------
    >>> CubicSpring("tip", k3=1e6).at
    Direction(weights=(('tip', 1.0),))
    """

    title: ClassVar[str] = "cubic spring"

    k3: float = described(Parameter("k3", 0.0, "N/m^3", "cubic stiffness", symbol="$k_3$"))

    def forces(
        self, motion: Motion, c: Symbols, phase: Expression
    ) -> tuple[Expression | None, ...]:
        """``-k3 u^3``."""
        (u,) = motion.displacement
        return (-c["k3"] * whole_power(u, 3),)

    def potential(self, motion: Motion, c: Symbols) -> Expression | None:
        """``k3 u^4/4``."""
        (u,) = motion.displacement
        return 0.25 * c["k3"] * whole_power(u, 4)


@dataclass(frozen=True)
class PolynomialSpring(OneDirection):
    r"""A polynomial spring: the force :math:`-\sum_n k_n u^n`.

    Parameters
    ----------
    at
        Degree of freedom, or weights by name.
    stiffness
        Coefficient by power, such as ``{1: -100.0, 3: 2e6}``; ``k_n`` in N/m^n becomes the
        parameter ``kn``, e.g. ``k3``.
    name
        Tells springs apart; empty if there is one only.

    Examples
    --------
    >>> [item.name for item in PolynomialSpring("tip", {1: -100.0, 3: 2e6}).parameters]
    ['k1', 'k3']
    """

    title: ClassVar[str] = "polynomial spring"

    stiffness: Any = field()

    def prepare(self) -> None:
        """Read the direction and the coefficients."""
        super().prepare()
        # A spring that is made anew from its own fields has pairs already.
        own = isinstance(self.stiffness, tuple) and all(
            isinstance(item, tuple) and len(item) == 2 for item in self.stiffness
        )
        pairs = self.stiffness if own else ()
        given = dict(self.stiffness if isinstance(self.stiffness, Mapping) else pairs)
        powers = [n for n in given if isinstance(n, int) and 1 <= n <= HIGHEST]
        if not given or len(powers) != len(given):
            raise InputError(
                f"stiffness = {shown(self.stiffness)} is no polynomial; give coefficients by "
                f"power, whole numbers from 1 to {HIGHEST}, such as {{1: -100.0, 3: 2e6}}"
            )
        checked = {
            n: self._parameter(n).check(parse_quantity(given[n], _unit(n), f"k{n}")) for n in powers
        }
        object.__setattr__(self, "stiffness", tuple(sorted(checked.items())))

    @staticmethod
    def _parameter(n: int) -> Parameter:
        return Parameter(f"k{n}", 0.0, _unit(n), f"coefficient of u^{n}", symbol=f"$k_{{{n}}}$")

    @property
    def own_parameters(self) -> tuple[Parameter, ...]:
        """One a power."""
        return tuple(self._parameter(n) for n, _ in self.stiffness)

    @property
    def own_values(self) -> dict[str, float]:
        """Values of the coefficients by name, in SI units."""
        return {f"k{n}": value for n, value in self.stiffness}

    @property
    def kind(self) -> Self:
        """The spring with all coefficients zero."""
        return replace(self, stiffness=tuple((n, 0.0) for n, _ in self.stiffness))

    def forces(
        self, motion: Motion, c: Symbols, phase: Expression
    ) -> tuple[Expression | None, ...]:
        """``-sum kn u^n``."""
        (u,) = motion.displacement
        return (-total([c[f"k{n}"] * whole_power(u, n) for n, _ in self.stiffness]),)

    def potential(self, motion: Motion, c: Symbols) -> Expression | None:
        """``sum kn u^(n + 1)/(n + 1)``."""
        (u,) = motion.displacement
        return total([c[f"k{n}"] * whole_power(u, n + 1) / (n + 1.0) for n, _ in self.stiffness])


def _unit(n: int) -> str:
    return "N/m" if n == 1 else f"N/m^{n}"
