"""A straight spring whose force keeps its direction to the anchor, at any displacement."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar

import heyoka as hy

from slipfold.errors import InputError
from slipfold.models.friction.quantities import described
from slipfold.models.output import Expression, Limit, Symbols
from slipfold.models.parameter import Parameter
from slipfold.models.structures.components.component import Component, Measure, Motion
from slipfold.models.structures.components.direction import Direction, as_directions
from slipfold.models.structures.components.sums import product, total
from slipfold.models.structures.shown import shown

COLLAPSE = 1e-4
"""Length over unstretched length at which a branch ends: the direction of the force is lost."""


@dataclass(frozen=True)
class GeometricSpring(Component):
    r"""A linear spring between a fixed anchor and a point of the structure, geometrically exact.

    .. math::

        F = -k (l - L)\, r/l, \qquad r = u + s L\, e, \qquad l = |r|

    with the displacement u of the point and the unit vector e from the anchor to the point at rest.

    Parameters
    ----------
    at
        One to three directions at right angles, in which the point moves.
    axis
        Direction from the anchor to the point at rest, one component a direction; scaled to
        length 1. One more component is one across all directions, in which the point cannot move:
        ``axis=(0, 1)`` with one direction is a spring across it.
    k
        Stiffness in N/m.
    L
        Unstretched length in m.
    stretch
        Length at rest over unstretched length s.
    name
        Tells springs apart; empty if there is one only.

    Examples
    --------
    >>> GeometricSpring(("x", "y"), axis=(0, 2), k=1000, L="5mm").axis
    (0.0, 1.0)
    """

    title: ClassVar[str] = "geometric spring"

    at: Any
    axis: Any
    k: float = described(Parameter("k", 1.0, "N/m", "stiffness of a spring", 0, symbol="$k$"))
    L: float = described(
        Parameter("L", 1.0, "m", "unstretched length of a spring", 0, lower_open=True, symbol="$L$")
    )
    stretch: float = described(
        Parameter("stretch", 1.0, "", "length of a spring at rest over L", 0, lower_open=True)
    )

    def prepare(self) -> None:
        """Read the directions and the axis."""
        at = as_directions(self.at, f"a {self.title}", 3)
        object.__setattr__(self, "at", at)
        try:
            axis = [float(part) for part in self.axis]
        except (TypeError, ValueError):
            axis = []
        length = math.hypot(*axis)
        if len(axis) not in (len(at), len(at) + 1) or not math.isfinite(length):
            raise InputError(
                f"axis = {shown(self.axis)} does not fit a {self.title} along {len(at)} "
                f"directions; give {len(at)} finite components, or one more for the part "
                "across them"
            )
        if length == 0:
            raise InputError(
                f"the axis of a {self.title} is zero; give the direction from its anchor to the "
                "point it holds"
            )
        # Twice the same spring must be the same model: an axis of length 1 stays as it is.
        if length != 1:
            axis = [part / length for part in axis]
        object.__setattr__(self, "axis", tuple(axis))

    @property
    def directions(self) -> tuple[Direction | None, ...]:
        """The directions in which the point moves."""
        return tuple(self.at)

    def coefficients(self, p: Symbols) -> dict[str, Expression]:
        """Force at a stretch of one length, the length, its inverse, the stretch."""
        return {
            "force": p["k"] * p["L"],
            "inverse": 1.0 / p["L"],
            "L": p["L"],
            "stretch": p["stretch"],
        }

    def _arrow(self, motion: Motion, c: Symbols) -> list[Expression]:
        """Return the vector from the anchor to the point, over L."""
        moved = [u * c["inverse"] for u in motion.displacement]
        rest = [product(part, c["stretch"]) if part else None for part in self.axis]
        arrow = [u if r is None else u + r for u, r in zip(moved, rest, strict=False)]
        return arrow + [r for r in rest[len(moved) :] if r is not None]

    def _length(self, motion: Motion, c: Symbols, phase: Expression) -> Expression:
        return hy.sqrt(total([part * part for part in self._arrow(motion, c)]))

    def forces(
        self, motion: Motion, c: Symbols, phase: Expression
    ) -> tuple[Expression | None, ...]:
        """``-k (l - L) r/l``."""
        arrow = self._arrow(motion, c)
        inverse_length = total([part * part for part in arrow]) ** -0.5
        pull = c["force"] * (inverse_length - 1.0)
        return tuple(pull * part for part in arrow[: len(self.at)])

    def potential(self, motion: Motion, c: Symbols) -> Expression | None:
        """``k (l - L)^2/2``."""
        change = self._length(motion, c, hy.expression(0.0)) - 1.0
        return 0.5 * c["force"] * c["L"] * change * change

    def measures(self) -> tuple[Measure, ...]:
        """Return the length."""
        return (Measure("l", self._length, "", "length of a spring over L", "$l/L$"),)

    def limits(self) -> tuple[Limit, ...]:
        """Return the limit at which the spring collapses."""
        reason = (
            "spring collapsed: l/L fell to {value:.3g}; the model ends here, stay below this value"
        )
        return (Limit("spring collapse", "l", COLLAPSE, reason),)
