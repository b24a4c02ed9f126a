"""Orbits of no amplitude with which others begin: doubled ones, and cycles round an equilibrium."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from slipfold.arrays import Array
from slipfold.orbits.cycles import Cycles
from slipfold.orbits.discretisations.segments import Cut, Segments
from slipfold.orbits.discretisations.shooting import Shooting
from slipfold.orbits.equilibria import Equilibria
from slipfold.orbits.orbit_curve import Orbits
from slipfold.orbits.spectrum.eigenvalues import transition
from slipfold.orbits.spectrum.multipliers import on_quotient


@dataclass(frozen=True, eq=False)
class Newborn:
    """The first of the orbits that are born at another."""

    orbits: Orbits  # what they are
    z: Array  # the first of them as an unknown
    tangent: Array  # unit vector in which they leave: to first order no parameter changes
    monodromy: Array  # matrix whose eigenvalues are watched, in scaled states


def passed_twice(orbits: Orbits, z: Array) -> Newborn:
    """Return an orbit at a period doubling, passed twice, with the direction of doubled ones.

    That is the critical direction, which changes sign from one period to the next.
    """
    part = orbits.linearise(z)
    values, vectors = np.linalg.eig(part.product)
    direction = vectors[:, np.argmin(np.abs(values + 1))].real
    along = [direction]
    for block in part.blocks[:-1]:
        along.append(block @ along[-1])
    child = orbits.with_period(2 * orbits.period)
    assert isinstance(orbits.by, Segments)
    assert isinstance(child.by, Segments)
    # A segment of the child is two of the parent, or one of either round.
    own, turns = np.divmod(child.by.start, orbits.period)[::-1]
    same = np.abs(orbits.by.start[None, :] - own[:, None]).argmin(axis=1)
    moved = (np.array(along)[same] * np.where(turns == 0, 1.0, -1.0)[:, None]).ravel()
    tangent = np.concatenate([moved, np.zeros(len(orbits.units))])
    # The largest component starts positive: of the two copies always the same one.
    tangent *= np.sign(direction[np.abs(direction).argmax()]) / np.linalg.norm(tangent)
    doubled = child.join(orbits.nodes(z)[same], orbits.free_values(z))
    return Newborn(child, doubled, tangent, part.monodromy @ part.monodromy)


def cycle_of_no_amplitude(
    orbits: Equilibria,
    z: Array,
    method: Callable[[Array], Cut] = lambda jacobian: Shooting,
    *,
    pair: int = 0,
) -> Newborn:
    """Return an equilibrium at a Hopf point as a cycle, with the direction of those born there.

    That is the critical eigenvector turning once. `method` says how the cycle is cut, from the
    derivatives of the rates a round. Pairs are numbered by their distance from the imaginary axis.
    """
    unit, jacobian = orbits.unit(z), orbits.jacobian(z)
    values, vectors = np.linalg.eig(jacobian)
    critical = int(np.where(values.imag > 0, np.abs(values.real), np.inf).argsort()[pair])
    turn = 2 * np.pi / float(values[critical].imag)
    paced = orbits.model.replace(duration=unit * turn)
    child = Cycles(paced, orbits.varied, by=method(jacobian * turn))
    q, m = vectors[:, critical], child.segments
    turns = np.exp(2j * np.pi * np.arange(m) / m)  # both discretisations begin with equal segments
    turning = np.real(q * turns[:, None]).ravel()
    tangent = np.concatenate([turning, np.zeros(len(child.units))])
    nodes = np.tile(orbits.nodes(z), (m, 1))
    return Newborn(
        child,
        child.join(nodes, [unit * turn, *orbits.values(z)]),
        tangent / np.linalg.norm(tangent),
        on_quotient(transition(jacobian * turn), np.real(1j * q)),
    )
