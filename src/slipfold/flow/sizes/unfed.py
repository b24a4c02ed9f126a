"""States that nothing feeds: once zero they stay zero, and else they grow from what there is.

Populations, infections, catalysts, modes of a symmetry are such. Between two outbreaks they may
fall far below what a step may leave of an error beside states of order one, and what comes back is
then what the error has become.
"""

from __future__ import annotations

from collections.abc import Callable

import heyoka as hy
import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.flow.equations import Equations
from slipfold.models.evaluation import compiled_function
from slipfold.models.output import Expression

Group = tuple[int, ...]

MEMBERS = 4
"""States of a group at most: a susceptible is exposed, infected, in hospital, dead."""

PLACES = 2
"""Random places at which a rate must vanish to be one that vanishes everywhere."""

FASTER = 1.5
"""Factor by which what is watched changes faster than the state does: it is of order one where
other states may be a thousand scales large, and errors are relative to the largest."""

LEAST = 1e-300
"""Squared size below which a state counts as zero; the least numbers have no digits left."""


def relative_sizes(equations: Equations) -> list[Expression]:
    """Return functions between 0 and 1 that change as unfed states do relative to their size.

    Series of the sine of a logarithm are those of a power of the state: watched by an integrator,
    they have it leave errors that are small beside a state that is itself small.
    """
    arguments = [*equations.states, equations.phase, *equations.coefficients]
    compiled = compiled_function(equations.rates, arguments)
    more = len(arguments) - equations.dimension
    rest = np.random.default_rng(1).uniform(0.5, 1.5, more)

    def rates(states: Array) -> Array:
        inputs = np.column_stack([states, np.tile(rest, (len(states), 1))])
        return np.asarray(compiled(np.ascontiguousarray(inputs.T)).T)

    groups = unfed_groups(rates, equations.dimension)
    return [_relative_size([equations.states[i] for i in group]) for group in groups]


def unfed_groups(rates: Callable[[Array], Array], count: int) -> list[Group]:
    """Return the smallest groups of states that stay zero where all of a group are.

    Shapes: states (m, n) of `rates`, which returns (m, n).

    >>> def epidemic(q):
    ...     s, e, i = q.T
    ...     return np.column_stack([1 - s - s * i, s * i - e, e - i])
    >>> unfed_groups(epidemic, 3)
    [(1, 2)]
    """
    groups = set[Group]()
    level: set[tuple[Group, int]] = {((first,), first) for first in range(count)}
    for size in range(1, MEMBERS + 1):
        tried, level = sorted(level), set()
        if not tried:
            break
        zero = _vanishes(rates, count, [group for group, _ in tried])
        for (group, member), vanishing in zip(tried, zero, strict=True):
            fed = [i for i in group if not vanishing[i]]
            if not fed:
                # All states together at rest are an equilibrium and no group of their own.
                groups.update({group} if size == 1 or size < count else ())
            elif size == 1 or vanishing[member]:
                others = set(range(count)).difference(group)
                level |= {(tuple(sorted((*group, i))), fed[0]) for i in others}
    return sorted(group for group in groups if not any(set(g) < set(group) for g in groups))


def _vanishes(
    rates: Callable[[Array], Array], count: int, groups: list[Group]
) -> NDArray[np.bool_]:
    """Whether each rate vanishes where a group does, shape (number of groups, n)."""
    states = np.random.default_rng(2).uniform(0.5, 1.5, (len(groups), PLACES, count))
    for place, group in enumerate(groups):
        states[place, :, list(group)] = 0.0
    found = rates(states.reshape(-1, count)).reshape(states.shape)
    return np.asarray((found == 0).all(axis=1))


def _relative_size(states: list[Expression]) -> Expression:
    squares = hy.sum([state * state for state in states])
    return 0.5 + 0.4 * hy.sin(FASTER / 2 * hy.log(squares + LEAST))
