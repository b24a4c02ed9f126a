"""Springs: linear with a damper, cubic, polynomial, gap, tabulated, geometrically exact."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, ClassVar, Self

import heyoka as hy
import numpy as np

from slipfold.arrays import Array, as_numbers
from slipfold.errors import InputError, suggest
from slipfold.models.formulas.functions import whole_power
from slipfold.models.parametric import described, structural
from slipfold.models.quantities import (
    COLLAPSE_LIMIT,
    Expression,
    Limit,
    Output,
    Parameter,
    Symbols,
    nonnegative,
    positive,
)
from slipfold.models.structures.component import (
    Component,
    Direction,
    Forces,
    LocalState,
    OneDirection,
    as_directions,
    brief,
    total,
    weighted_sum,
)
from slipfold.models.units import parse_quantity


@dataclass(frozen=True)
class LinearSpring(OneDirection):
    r"""A linear spring with a damper in parallel: the force :math:`-(k u + c \dot u)`.

    Examples
    --------
    >>> LinearSpring("tip", k="2 kN/m").k
    2000.0
    """

    title: ClassVar[str] = "linear spring"

    k: float = described(Parameter("k", 1.0, "N/m", "stiffness of a spring", symbol="$k$"))
    c: float = described(nonnegative("c", 0.0, "N s/m", "damping in parallel with a spring", "$c$"))

    def _forces(self, local: LocalState) -> Forces:
        (u,), (v,), c = local.u, local.v, local.c
        return (-(c["k"] * u + c["c"] * v),)

    def _potential(self, local: LocalState) -> Expression:
        (u,), c = local.u, local.c
        return 0.5 * c["k"] * u * u

    def _dissipation(self, local: LocalState) -> Expression:
        (v,), c = local.v, local.c
        return c["c"] * v * v


class _PowersSpring(OneDirection):
    """A spring whose force is a sum of powers with the coefficients ``kn``."""

    def _forces(self, local: LocalState) -> Forces:
        (u,) = local.u
        return (-total([k * whole_power(u, int(key[1:])) for key, k in local.c.items()]),)

    def _potential(self, local: LocalState) -> Expression:
        (u,), powers = local.u, [(int(key[1:]), k) for key, k in local.c.items()]
        return total([k * whole_power(u, n + 1) / (n + 1.0) for n, k in powers])


@dataclass(frozen=True)
class CubicSpring(_PowersSpring):
    r"""A cubic spring: the force :math:`-k_3 u^3`; with a negative stiffness it softens.

    Examples
    --------
    >>> CubicSpring("tip", k3=1e6).at
    Direction(weights=(('tip', 1.0),))
    """

    title: ClassVar[str] = "cubic spring"

    k3: float = described(Parameter("k3", 0.0, "N/m^3", "cubic stiffness", symbol="$k_3$"))


MAX_POWER = 15
"""Highest power of a polynomial: beyond it, fitted coefficients are seldom worth anything."""


def _coefficient(n: int) -> Parameter:
    unit = "N/m" if n == 1 else f"N/m^{n}"
    return Parameter(f"k{n}", 0.0, unit, f"coefficient of u^{n}", symbol=f"$k_{{{n}}}$")


def _checked_stiffness(value: Any, title: str) -> tuple[tuple[int, float], ...]:
    """Return power and coefficient of each term."""
    # A spring that is made again from its own fields has pairs already.
    own = isinstance(value, tuple) and all(
        isinstance(item, tuple) and len(item) == 2 for item in value
    )
    given = dict(value) if own or isinstance(value, Mapping) else {}
    powers = [n for n in given if isinstance(n, int) and 1 <= n <= MAX_POWER]
    if not given or len(powers) != len(given):
        raise InputError(
            f"stiffness = {brief(value)} is not a polynomial; give coefficients by "
            f"power, whole numbers from 1 to {MAX_POWER}, such as {{1: -100.0, 3: 2e6}}"
        )
    items = ((n, _coefficient(n)) for n in sorted(powers))
    return tuple((n, one.check(parse_quantity(given[n], one.unit, one.name))) for n, one in items)


@dataclass(frozen=True)
class PolynomialSpring(_PowersSpring):
    r"""A polynomial spring: the force :math:`-\sum_n k_n u^n`.

    Examples
    --------
    >>> [item.name for item in PolynomialSpring("tip", {1: -100.0, 3: 2e6}).parameters]
    ['k1', 'k3']
    """

    title: ClassVar[str] = "polynomial spring"

    stiffness: Any = structural(
        "coefficient by power, such as ``{1: -100.0, 3: 2e6}``; ``k_n`` in N/m^n becomes the "
        "parameter ``kn``, e.g. ``k3``",
        read=_checked_stiffness,
    )

    def _pairs(self) -> Iterator[tuple[Parameter, float]]:
        return ((_coefficient(n), value) for n, value in self.stiffness)

    @property
    def kind(self) -> Self:
        """The spring with all coefficients zero."""
        return replace(self, stiffness=tuple((n, 0.0) for n, _ in self.stiffness))


_SIDES = {"above": (1.0,), "below": (-1.0,), "both": (1.0, -1.0)}
"""Signs of the displacements at which there is contact."""


_ROUNDING = positive(
    "e", 1.0, "m", "length over which contact with a stop is rounded off", r"$\varepsilon$"
)


def _pressed(depth: Expression, c: Symbols) -> Expression:
    """Return twice the positive part of a depth, rounded off."""
    return depth + hy.sqrt(depth * depth + c["square"])


def _pressing(depth: Expression, c: Symbols) -> Expression:
    """Return four times its integral, zero at contact."""
    root = hy.sqrt(depth * depth + c["square"])
    return depth * depth + (depth * root + c["square"] * hy.asinh(depth / c["e"]))


@dataclass(frozen=True)
class GapSpring(OneDirection):
    r"""A stop beyond a gap, rounded off over a length; with no gap a unilateral spring.

    .. math::

        F = -k\, s(u - g), \qquad s(w) = \tfrac12 \bigl(w + \sqrt{w^2 + \varepsilon^2}\bigr)

    for a stop above; below it is the mirror image. The exact stop, :math:`\max(w, 0)`, is the limit
    of small :math:`\varepsilon`: s is too large by :math:`\varepsilon/2` at contact and by
    :math:`\varepsilon^2/(4 |w|)` away from it. The length `e` must be given: the exact stop has a
    corner, which smooth equations cannot hold. A negative `gap` presses the stop at rest.

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

    k: float = described(positive("k", 1.0, "N/m", "stiffness of a stop", "$k$"))
    gap: float = described(Parameter("gap", 0.0, "m", "gap before a stop", symbol="$g$"))
    e: Any = described(_ROUNDING, None)
    side: Any = structural('``"above"``, ``"below"`` or ``"both"``', "above")

    def prepare(self) -> None:
        """Refuse the exact stop and unknown sides."""
        if self.e is None:
            raise InputError(
                "a gap spring without e has a corner where it is touched, and motion through "
                "corners cannot be computed yet; give e, the length over which contact is "
                'rounded off, such as e="10um"'
            )
        if not isinstance(self.side, str) or self.side not in _SIDES:
            raise InputError(
                f"side = {brief(self.side)} is not known; {suggest(str(self.side), _SIDES)}give "
                "above, below or both"
            )

    def _coefficients(self, p: Symbols) -> dict[str, Expression]:
        """Half the stiffness, the gap, and the square of the rounding."""
        return {"half": 0.5 * p["k"], "gap": p["gap"], "square": p["e"] * p["e"], "e": p["e"]}

    def _forces(self, local: LocalState) -> Forces:
        (u,), c = local.u, local.c
        half, gap, signs = c["half"], c["gap"], _SIDES[self.side]
        return (total([-sign * half * _pressed(sign * u - gap, c) for sign in signs]),)

    def _potential(self, local: LocalState) -> Expression:
        """Return the work that pressing the stop takes, zero at contact."""
        (u,), c = local.u, local.c
        half, gap, signs = c["half"], c["gap"], _SIDES[self.side]
        return total([0.5 * half * _pressing(sign * u - gap, c) for sign in signs])


MAX_ROWS = 64
"""Most rows of a table: each is a term that every step of the integration evaluates."""


def _checked_table(given: Any, title: str) -> tuple[tuple[float, float], ...]:
    """Return displacement and force of each row, by ascending displacement."""
    rows = as_numbers([*given.items()] if isinstance(given, Mapping) else given)
    if rows.ndim != 2 or rows.shape[1] != 2 or not 2 <= len(rows) <= MAX_ROWS:
        raise InputError(
            f"the table of a {title} is {brief(given)}; give 2 to {MAX_ROWS} rows of displacement "
            "in m and force in N, such as [(-0.001, -20), (0, 0), (0.001, 5)]"
        )
    rows = rows[np.argsort(rows[:, 0], kind="stable")]
    if not np.isfinite(rows).all() or np.any(np.diff(rows[:, 0]) == 0):
        raise InputError(
            f"the table of a {title} has numbers that are not finite, or two forces at one "
            "displacement; give one finite force for each"
        )
    return tuple((float(u), float(force)) for u, force in rows)


@dataclass(frozen=True)
class TabulatedSpring(OneDirection):
    r"""A spring with a measured force, linear between the rows of a table and beyond its ends.

    .. math::

        F = -\mathrm{factor} \Bigl(F_1 + k_1 (u - u_1) + \sum_i (k_{i+1} - k_i)\, s(u -
        u_{i+1})\Bigr)

    with the slopes :math:`k_i` between the rows, and corners rounded off by s as those of a
    `GapSpring`. At a corner the force differs from the table by :math:`\varepsilon/2` times the
    change of the slope; `residual` says how much that is.

    Examples
    --------
    >>> spring = TabulatedSpring("tip", [(-1e-3, -20), (0, 0), (1e-3, 5)], e="1um")
    >>> round(spring.residual, 6)
    0.000375
    """

    title: ClassVar[str] = "tabulated spring"

    table: Any = structural(
        "force in N by displacement in m: rows, shape (n, 2), or a mapping", read=_checked_table
    )
    factor: float = described(Parameter("factor", 1.0, "", "factor of a tabulated spring"))
    e: Any = described(_ROUNDING, None)

    def prepare(self) -> None:
        """Refuse exact corners."""
        if self.e is None:
            raise InputError(
                "a tabulated spring without e has corners at its rows, through which motion cannot "
                "be computed; give e, the length over which they are rounded off"
            )

    @property
    def residual(self) -> float:
        """Largest difference between the table and the spring, over the largest force."""
        rows = np.array(self.table)
        away = rows[:, 0] - rows[1:-1, :1]  # of each corner
        over = np.abs(np.diff(self._slopes)) @ ((np.hypot(away, self.e) - np.abs(away)) / 2)
        return float(over.max() / max(np.abs(rows[:, 1]).max(), np.finfo(float).tiny))

    @property
    def _slopes(self) -> Array:
        u, force = np.array(self.table).T
        return np.diff(force) / np.diff(u)

    def _coefficients(self, p: Symbols) -> dict[str, Expression]:
        """Factor, and the rounding and its square."""
        return {"factor": p["factor"], "square": p["e"] * p["e"], "e": p["e"]}

    def _corners(self, u: Expression) -> Iterator[tuple[float, Expression]]:
        """Yield the change of the slope at each corner and the displacement beyond it."""
        for change, (start, _) in zip(np.diff(self._slopes), self.table[1:-1], strict=True):
            if change:
                yield float(change), u - start

    def _forces(self, local: LocalState) -> Forces:
        (u,), c = local.u, local.c
        start, first = self.table[0]
        parts = [first + float(self._slopes[0]) * (u - start)]
        parts += [0.5 * change * _pressed(depth, c) for change, depth in self._corners(u)]
        return (-c["factor"] * total(parts),)

    def _potential(self, local: LocalState) -> Expression:
        (u,), c = local.u, local.c
        start, first = self.table[0]
        way = u - start
        parts = [first * way + 0.5 * float(self._slopes[0]) * way * way]
        parts += [0.25 * change * _pressing(depth, c) for change, depth in self._corners(u)]
        return c["factor"] * total(parts)


@dataclass(frozen=True)
class GeometricSpring(Component):
    r"""A linear spring between a fixed anchor and a point of the structure, geometrically exact.

    .. math::

        F = -k (l - L)\, r/l, \qquad r = u + s L\, e, \qquad l = |r|

    with the displacement u of the point and the unit vector e from the anchor to the point at rest.

    Examples
    --------
    >>> GeometricSpring(("x", "y"), axis=(0, 2), k=1000, L="5mm").axis
    (0.0, 1.0)
    """

    title: ClassVar[str] = "geometric spring"

    at: Any = structural(
        "one to three directions at right angles, in which the point moves",
        read=partial(as_directions, most=3),
    )
    axis: Any = structural(
        "direction from the anchor to the point at rest, one component a direction; scaled to "
        "length 1. One more component is one across all directions, in which the point cannot "
        "move: ``axis=(0, 1)`` with one direction is a spring across it"
    )
    k: float = described(nonnegative("k", 1.0, "N/m", "stiffness of a spring", "$k$"))
    L: float = described(positive("L", 1.0, "m", "unstretched length of a spring", "$L$"))
    stretch: float = described(positive("stretch", 1.0, "", "length of a spring at rest over L"))

    def prepare(self) -> None:
        """Scale the axis to length 1."""
        at = self.at
        try:
            axis = [float(part) for part in self.axis]
        except (TypeError, ValueError):
            axis = []
        length = math.hypot(*axis)
        if len(axis) not in (len(at), len(at) + 1) or not math.isfinite(length):
            raise InputError(
                f"axis = {brief(self.axis)} does not fit a {self.title} along {len(at)} "
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
    def _directions(self) -> tuple[Direction | None, ...]:
        return tuple(self.at)

    def _coefficients(self, p: Symbols) -> dict[str, Expression]:
        """Force at an extension by one length, the length, its inverse, the stretch."""
        return {
            "force": p["k"] * p["L"],
            "inverse": 1.0 / p["L"],
            "L": p["L"],
            "stretch": p["stretch"],
        }

    def _arrow(self, local: LocalState) -> list[Expression]:
        """Return the vector from the anchor to the point, over L."""
        moved = [u * local.c["inverse"] for u in local.u]
        rest = [weighted_sum([part], [local.c["stretch"]]) for part in self.axis]
        arrow = [u + r[0] if r else u for u, r in zip(moved, rest, strict=False)]
        return arrow + [r[0] for r in rest[len(moved) :] if r]

    def _length(self, local: LocalState, *_: Any) -> Expression:
        return hy.sqrt(total([part * part for part in self._arrow(local)]))

    def _forces(self, local: LocalState) -> Forces:
        arrow = self._arrow(local)
        inverse_length = total([part * part for part in arrow]) ** -0.5
        pull = local.c["force"] * (inverse_length - 1.0)
        return tuple(pull * part for part in arrow[: len(self.at)])

    def _potential(self, local: LocalState) -> Expression:
        change = self._length(local) - 1.0
        return 0.5 * local.c["force"] * local.c["L"] * change * change

    def _measures(self) -> tuple[Output, ...]:
        return (Output("l", self._length, "", "length of a spring over L", "$l/L$"),)

    def limits(self) -> tuple[Limit, ...]:
        """Return the limit at which the spring collapses."""
        return (COLLAPSE_LIMIT,)
