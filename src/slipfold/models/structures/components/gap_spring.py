"""A spring that acts beyond a gap only, rounded off at the touch."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, ClassVar

import heyoka as hy

from slipfold.errors import InputError
from slipfold.models.friction.quantities import described
from slipfold.models.output import Expression, Symbols
from slipfold.models.parameter import Parameter
from slipfold.models.structures.components.component import Motion
from slipfold.models.structures.components.one_direction import OneDirection
from slipfold.models.structures.components.sums import total
from slipfold.models.structures.shown import shown
from slipfold.models.suggestion import suggest

_SIDES = {"above": (1.0,), "below": (-1.0,), "both": (1.0, -1.0)}
"""Signs of the displacements at which the spring is touched."""


_ROUNDING = Parameter(
    "e",
    1.0,
    "m",
    "length over which the touch of a stop is rounded off",
    0,
    lower_open=True,
    symbol=r"$\varepsilon$",
)


@dataclass(frozen=True)
class GapSpring(OneDirection):
    r"""A stop beyond a gap, rounded off over a length; with no gap a unilateral spring.

    .. math::

        F = -k\, s(u - g), \qquad s(w) = \tfrac12 \bigl(w + \sqrt{w^2 + \varepsilon^2}\bigr)

    for a stop above; below it is the mirror image. The exact stop, :math:`\max(w, 0)`, is the limit
    of small :math:`\varepsilon`: s is too large by :math:`\varepsilon/2` at the touch and by
    :math:`\varepsilon^2/(4 |w|)` away from it.

    Parameters
    ----------
    at
        Degree of freedom, or weights by name.
    k
        Stiffness of the stop in N/m.
    gap
        Displacement at which it is touched, in m; negative for a stop that is pressed at rest.
    e
        Length over which the touch is rounded off, in m. It must be given: the exact stop has a
        corner, which smooth equations cannot hold.
    side
        ``"above"``, ``"below"`` or ``"both"``.
    name
        Tells springs apart; empty if there is one only.

    References
    ----------
    S. W. Shaw and P. J. Holmes, A periodically forced piecewise linear oscillator, Journal of Sound
    and Vibration 90 (1983) 129-155, on the exact stop.

    Examples
    --------
    >>> GapSpring("tip", k=1e4, gap="1mm", e="10um").gap
    0.001
    """

    title: ClassVar[str] = "gap spring"

    k: float = described(
        Parameter("k", 1.0, "N/m", "stiffness of a stop", 0, lower_open=True, symbol="$k$")
    )
    gap: float = described(Parameter("gap", 0.0, "m", "gap before a stop", symbol="$g$"))
    e: Any = field(default=None, metadata={"parameter": _ROUNDING})
    side: Any = "above"

    def prepare(self) -> None:
        """Read the direction; refuse the exact stop and unknown sides."""
        super().prepare()
        if self.e is None:
            raise InputError(
                "a gap spring without e has a corner where it is touched, and motion through "
                "corners cannot be computed yet; give e, the length over which the touch is "
                'rounded off, such as e="10um"'
            )
        if not isinstance(self.side, str) or self.side not in _SIDES:
            raise InputError(
                f"side = {shown(self.side)} is not known; {suggest(str(self.side), _SIDES)}give "
                "above, below or both"
            )

    def coefficients(self, p: Symbols) -> dict[str, Expression]:
        """Half the stiffness, the gap, and the square of the rounding."""
        return {"half": 0.5 * p["k"], "gap": p["gap"], "square": p["e"] * p["e"], "e": p["e"]}

    def forces(
        self, motion: Motion, c: Symbols, phase: Expression
    ) -> tuple[Expression | None, ...]:
        """``-k s(u - gap)``, and its mirror image."""
        (u,) = motion.displacement
        parts = []
        for sign in _SIDES[self.side]:
            depth = sign * u - c["gap"]
            parts.append(-sign * c["half"] * (depth + hy.sqrt(depth * depth + c["square"])))
        return (total(parts),)

    def potential(self, motion: Motion, c: Symbols) -> Expression | None:
        """Return the work that pressing the stop takes, zero at the touch."""
        (u,) = motion.displacement
        parts = []
        for sign in _SIDES[self.side]:
            depth = sign * u - c["gap"]
            root = hy.sqrt(depth * depth + c["square"])
            curved = depth * root + c["square"] * hy.asinh(depth / c["e"])
            parts.append(0.5 * c["half"] * (depth * depth + curved))
        return total(parts)
