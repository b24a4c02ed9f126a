"""Derivatives of second and third order: of fields, stroboscopic maps and return maps."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.errors import BREAKDOWNS
from slipfold.flow.equations import Constants
from slipfold.orbits.linearization import Linearization
from slipfold.orbits.multipliers import motion_bases
from slipfold.orbits.orbit_curve import Orbits

Vector = NDArray[Any]


class FORMS:
    """What is rounding in normal forms, and how finely cycles are sampled."""

    spanned: float = 1e-7  # part of a direction outside the span of others that is none
    samples: int = 32  # samples of a segment, at least, over which a squared length is averaged
    denser: int = 4  # times as many where these are too few: it costs as much again
    changed: float = 1e-10  # relative change of that mean, by every other sample, that is none
    most: int = 1 << 15  # samples of a cycle: a jump of a thousandth of it has a hundred
    # Distance from one at which a multiplier has an eigenvector besides the flow
    off_one: float = 1e-3
    # Unknowns of equations around a cycle that are solved densely, in two seconds
    largest: int = 1500
    singular: float = 1e-3  # smallest singular value of equations that have the critical vector
    lost: float = 1e-3  # error of the critical multiplier beyond which growth has taken all digits
    # Quadratic coefficients, in scaled states, that are rounding: of a pitchfork
    symmetric: float = 1e-7
    # Coefficients, in scaled states, that are rounding: neither soft nor hard
    degenerate: float = 1e-12
    times: int = 12  # times of a cycle: the fifth power of its amplitude has five harmonics


class MapDerivatives(ABC):
    """Second and third derivatives B and C of a map; scales are those of the unknown if None."""

    def __init__(self, orbits: Orbits, z: Array, scales: Array | None = None) -> None:
        self._constants = orbits.constants(z)
        self._scales = orbits.scales if scales is None else scales
        self.rescaling = orbits.scales / self._scales

    def rescaled(self, monodromy: Array) -> Array:
        """Return a matrix in these scales. Shapes: monodromy (n, n)."""
        return monodromy * self.rescaling[:, None] / self.rescaling

    def mapped(self, vector: Array) -> Array:
        """Return a displacement of the flow's end in the map's scales. Shapes: vector (n,)."""
        return vector * self.rescaling

    @abstractmethod
    def powers(self, directions: Array) -> tuple[Array, Array]:
        """Return B(v, v) and C(v, v, v) for real directions, each of shape (r, n)."""

    def second(self, pairs: list[tuple[Vector, Vector]]) -> list[Vector]:
        """Return B(u, v) for complex vectors, by polarization. Shapes: pairs (n,)."""
        return polarized(lambda directions: self.powers(directions)[0], pairs)


class FieldMap(MapDerivatives):
    """Jacobian A and multilinear forms B and C of a vector field, per second."""

    def __init__(self, orbits: Orbits, z: Array, scales: Array | None = None) -> None:
        super().__init__(orbits, z, scales)
        self._flow = orbits.flow
        self._state = orbits.nodes(z)[0]
        self._time = self._constants.period
        self._along = self._constants.rates[:, orbits.indices[-1:]]

    @property
    def jacobian(self) -> Array:
        """Derivative of the rates, shape (n, n)."""
        found = self._flow.jacobians(self._state[None], np.zeros(1), self._constants)[0]
        return found * self._scales / self._scales[:, None] / self._time

    def along_curves(self, curves: Array) -> Array:
        """Return the Taylor coefficient of order p + 1 of the rates along curves of states.

        Shapes: curves (m, p, n); returns (m, n).
        """
        states, phases = np.tile(self._state, (len(curves), 1)), np.zeros(len(curves))
        found = self._flow.along_curves(states, phases, self._constants, curves * self._scales)
        return found[:, curves.shape[1] - 1] / (self._scales * self._time)

    @property
    def pull(self) -> Array:
        """Derivative of the rates with respect to the last free parameter, shape (n,)."""
        states = self._state[None]
        found = self._flow.parameter_slopes(states, np.zeros(1), self._constants, self._along)[
            0, :, 0
        ]
        return np.asarray(found / self._scales / self._time)

    def powers(self, directions: Array) -> tuple[Array, Array]:
        """Return B(v, v) and C(v, v, v) for real directions, each of shape (r, n)."""
        units = self._scales * self._time
        states, phases = np.tile(self._state, (len(directions), 1)), np.zeros(len(directions))
        along = directions * self._scales
        found = self._flow.powers(states, phases, self._constants, along)
        return found[0] / units, found[1] / units

    def second(self, pairs: list[tuple[Vector, Vector]]) -> list[Vector]:
        """Return B(u, v) for complex vectors. Shapes: pairs (n,)."""
        parts = np.array([part for u, _ in pairs for part in (u.real, u.imag)])
        none = np.zeros((len(self._constants.values), 1))
        states, phases = np.tile(self._state, (len(parts), 1)), np.zeros(len(parts))
        along = parts * self._scales
        bent = self._flow.curvatures(states, phases, self._constants, along, none)[0]
        bent = bent * self._scales / self._scales[:, None] / self._time
        return [
            (bent[2 * i] + 1j * bent[2 * i + 1]) @ v.astype(complex)
            for i, (_, v) in enumerate(pairs)
        ]


class SegmentMap(MapDerivatives):
    r"""Second and third derivatives of the map over one period of an orbit, in scaled states.

    They are put together from those of the segments, integrated side by side: with
    :math:`b_j = B_j(v, v)` and :math:`c_j = C_j(v, v, v)` of the map up to the end of segment j,

    .. math:: b_j = D^2\phi_j[v_j, v_j] + A_j b_{j-1}, \quad
              c_j = D^3\phi_j[v_j, v_j, v_j] + 3 D^2\phi_j[v_j, b_{j-1}] + A_j c_{j-1}

    where v_j is v propagated to segment j.
    """

    def __init__(
        self, orbits: Orbits, z: Array, linearization: Linearization, scales: Array | None = None
    ) -> None:
        super().__init__(orbits, z, scales)
        self._by = orbits.by
        self._nodes = orbits.nodes(z)
        self._blocks = linearization.blocks
        known, bent = linearization.conditions.propagated, linearization.conditions.bent
        self._propagated = np.empty((0, *self._nodes.shape)) if known is None else known
        self._bent = np.empty((0, *self._blocks.shape)) if bent is None else bent

    def powers(self, directions: Array) -> tuple[Array, Array]:
        """Return B(v, v) and C(v, v, v) for real directions, each of shape (r, n)."""
        along = directions / self.rescaling
        forward, bent = self._curvatures(along)
        cubes = self._by.cubes(self._nodes, self._constants, forward)
        second = self._summed(np.einsum("rmab,rmb->rma", bent, forward))
        mixed = np.einsum("rmab,rmb->rma", bent, second[:, :-1])
        third = self._summed(cubes + 3 * mixed)
        return second[:, -1] * self.rescaling, third[:, -1] * self.rescaling

    def _summed(self, terms: Vector) -> Vector:
        """Return what the segments' terms come to at each node, propagated from node to node.

        Shapes: terms (r, m, n); returns (r, m + 1, n).
        """
        count, m, n = terms.shape
        sums = np.zeros((count, m + 1, n), dtype=terms.dtype)
        for j, block in enumerate(self._blocks):
            np.matmul(sums[:, j], block.T, out=sums[:, j + 1])
            sums[:, j + 1] += terms[:, j]
        return sums

    def second(self, pairs: list[tuple[Vector, Vector]]) -> list[Vector]:
        """Return B(u, v) for complex vectors. Shapes: pairs (n,)."""
        return [self._bilinear(u.real, v) + 1j * self._bilinear(u.imag, v) for u, v in pairs]

    def _bilinear(self, u: Array, v: Vector) -> Vector:
        """B(u, v) for a real u."""
        if not u.any():
            return np.zeros(len(v), dtype=complex)
        bent = self._curvatures((u / self.rescaling)[None])[1][0]
        propagated = [v / self.rescaling]
        for block in self._blocks[:-1]:
            propagated.append(block @ propagated[-1])
        terms = np.einsum("mab,mb->ma", bent, np.array(propagated))
        return np.asarray(self._summed(terms[None])[0, -1] * self.rescaling)

    def _curvatures(self, along: Array) -> tuple[Array, Array]:
        """Directions propagated along the orbit, (r, m, n), and D^2 phi_j along each, (r, m, n, n).

        Both are linear in the direction: no more than n of them are ever integrated.
        """
        for direction in along:
            rest = direction - self._coordinates(direction[None])[0] @ self._propagated[:, 0]
            if np.linalg.norm(rest) > FORMS.spanned * np.linalg.norm(direction):
                self._integrate(rest / np.linalg.norm(rest))
        coordinates = self._coordinates(along)
        return (
            np.einsum("rk,kmn->rmn", coordinates, self._propagated),
            np.einsum("rk,kmab->rmab", coordinates, self._bent),
        )

    def _coordinates(self, along: Array) -> Array:
        """Return directions as sums of those that are known, nearly. Shapes: (r, n) to (r, k)."""
        known = self._propagated[:, 0]
        if len(known) == 1:  # as for most; a fifth of the time
            return np.asarray(along @ known.T / (known @ known.T))
        return np.asarray(np.linalg.lstsq(known.T, along.T, rcond=None)[0].T)

    def _integrate(self, direction: Array) -> None:
        """Add a direction to those along which second derivatives are known."""
        forward = [direction]
        for block in self._blocks[:-1]:
            forward.append(block @ forward[-1])
        propagated = np.array(forward)[None]
        bent, _ = self._by.curvatures(self._nodes, self._constants, propagated)
        self._propagated = np.concatenate([self._propagated, propagated])
        self._bent = np.concatenate([self._bent, bent])


class JetMap(MapDerivatives):
    """Derivatives of the stroboscopic map from Taylor jets over the whole period, in scaled states.

    Jets along directions need no more than a plain flow to be compiled: for the few special points
    of a branch that is what costs most.
    """

    def __init__(self, orbits: Orbits, z: Array, scales: Array | None = None) -> None:
        super().__init__(orbits, z, scales)
        self._flow = orbits.flow
        self._nodes = orbits.evenly(z)
        self._start = orbits.phase
        self._end = orbits.phase + orbits.period

    def powers(self, directions: Array) -> tuple[Array, Array]:
        """Return B(v, v) and C(v, v, v) for real directions, each of shape (r, n)."""
        return JetMap.powers_of([self], [directions])[0]

    @staticmethod
    def powers_of(maps: Sequence[JetMap], each: Sequence[Array]) -> list[tuple[Array, Array]]:
        """Return those of several maps of one flow, integrated together.

        Shapes: directions (r, n) of each map.
        """
        counts = [len(directions) for directions in each]
        which = np.repeat(np.arange(len(maps)), counts)
        start, end = np.array([(item._start, item._end) for item in maps])[which].T
        nodes = np.array([item._nodes for item in maps])[which]
        scales = np.array([item._scales for item in maps])[which]
        constants = Constants.stacked([item._constants for item in maps]).rows(which)
        along = np.concatenate(each) * scales
        jets = maps[0]._flow.jet(nodes[:, 0], start, end, constants, along, nodes[:, 1:])
        if len(maps) > 1 and not np.isfinite(jets).all():  # one of them stops all
            return [item.powers(own) for item, own in zip(maps, each, strict=True)]
        parts = np.split(jets / scales[:, None], np.cumsum(counts)[:-1])
        return [(part[:, 1], part[:, 2]) for part in parts]

    def along_curve(self, curve: Array) -> Array:
        """Return the Taylor coefficient of order p + 1 of the map along a curve of states.

        Shapes: curve (p, n); returns (n,).
        """
        given = self._nodes, self._start, self._end, self._constants, curve * self._scales
        derivative = self._flow.jet_along_curve(*given)[len(curve)]
        return derivative / self._scales / math.factorial(len(curve) + 1)


Request = tuple[Any, str, Any]
"""A map, what is requested of it, `powers` or `second`, and of what."""


def answers_of(requests: Mapping[int, Request]) -> dict[int, Any]:
    """Answer requests by number, or with errors: those of stroboscopic maps of a flow together."""
    answers, alike = dict[int, Any](), defaultdict[Any, list[int]](list)
    for number, (map_, name, given) in requests.items():
        if isinstance(map_, JetMap):
            alike[map_._flow, map_._nodes.shape].append(number)
            continue
        try:
            answers[number] = getattr(map_, name)(given)
        except BREAKDOWNS as error:
            answers[number] = error
    for numbers in alike.values():
        maps, names, given = zip(*(requests[number] for number in numbers), strict=True)
        parts = [
            polarization(one) if name == "second" else (one, None)
            for name, one in zip(names, given, strict=True)
        ]
        try:
            found = JetMap.powers_of(maps, [directions for directions, _ in parts])
        except BREAKDOWNS as error:
            alone = len(numbers) == 1  # else the others may be answered
            for number in numbers:
                answers |= {number: error} if alone else answers_of({number: requests[number]})
            continue
        for number, (_, combined), both in zip(numbers, parts, found, strict=True):
            answers[number] = both if combined is None else combined(both[0])
    return answers


def polarized(
    squares: Callable[[Array], Array], pairs: list[tuple[Vector, Vector]]
) -> list[Vector]:
    """Return B(u, v) for complex vectors from the squares B(w, w) of real ones.

    Shapes: squares (r, n); pairs (n,).
    """
    sums, combined = polarization(pairs)
    return combined(squares(sums) if len(sums) else sums)


def polarization(
    pairs: list[tuple[Vector, Vector]],
) -> tuple[Array, Callable[[Array], list[Vector]]]:
    """Return vectors whose squares are needed, (r, n), and what makes B(u, v) of these."""
    parts = [
        (place, factor, left, right)
        for place, (u, v) in enumerate(pairs)
        for factor, left, right in (
            (1, u.real, v.real),
            (-1, u.imag, v.imag),
            (1j, u.real, v.imag),
            (1j, u.imag, v.real),
        )
        if np.linalg.norm(left) > 0 and np.linalg.norm(right) > 0  # squares may underflow
    ]
    sizes = [(np.linalg.norm(left), np.linalg.norm(right)) for _, _, left, right in parts]
    sums = [
        left / a + sign * right / b
        for (_, _, left, right), (a, b) in zip(parts, sizes, strict=True)
        for sign in (1, -1)
    ]

    def combined(values: Array) -> list[Vector]:
        result: list[Vector] = [np.zeros(len(u), dtype=complex) for u, _ in pairs]
        for i, ((place, factor, _, _), (a, b)) in enumerate(zip(parts, sizes, strict=True)):
            result[place] += factor * a * b / 4 * (values[2 * i] - values[2 * i + 1])
        return result

    # A symmetric orbit has no quadratic terms.
    return np.reshape(sums, (len(sums), len(pairs[0][0]))), combined


def pair_terms(second: Array, third: Array) -> tuple[Array, Vector, Vector]:
    """Return B(q, conj q), B(q, q) and C(q, q, conj q) of q = a + ib.

    They are made of the powers along a, b, a + b and a - b. Shapes: (4, ...).
    """
    aa, bb, ab = second[0], second[1], (second[2] - second[3]) / 4
    aaa, bbb = third[0], third[1]
    aab = (third[2] - third[3]) / 6 - bbb / 3
    abb = (third[2] + third[3]) / 6 - aaa / 3
    return aa + bb, aa - bb + 2j * ab, aaa + abb + 1j * (aab + bbb)


class ReturnMap(MapDerivatives):
    r"""Where motions near a cycle cross a section the next time, in scaled states.

    The section is the plane through the first node orthogonal to the flow there. The flow over the
    cycle's duration leads beside it; the time that is missing follows order by order from

    .. math:: f^T (\phi(x_0 + s v, T + \tau(s)) - x_0) = 0

    with the derivatives of the flow along v and in time. Vectors are coordinates in the section.
    """

    def __init__(self, orbits: Orbits, z: Array, scales: Array) -> None:
        super().__init__(orbits, z, scales)
        self._orbits, self._z = orbits, z
        self._nodes = orbits.evenly(z)
        rates = orbits.flow.rates(self._nodes[:1], np.array([orbits.phase]), self._constants)[0]
        self._flow = rates / scales
        self._basis = motion_bases(self._flow[None])[0][:, 1:]

    def rescaled(self, monodromy: Array) -> Array:
        """Return the map's matrix, shape (n - 1, n - 1). Shapes: monodromy (n, n)."""
        return np.asarray(self._basis.T @ super().rescaled(monodromy) @ self._basis)

    def mapped(self, vector: Array) -> Array:
        """Return a displacement of the flow's end as one of the map, (n,) to (n - 1,)."""
        return np.asarray(self._basis.T @ (vector * self.rescaling))

    def powers(self, directions: Array) -> tuple[Array, Array]:
        """Return B(v, v) and C(v, v, v) for real directions.

        Shapes: directions (r, n - 1); returns second, third (r, n - 1).
        """
        orbits = self._orbits
        jets = orbits.flow.jet_in_time(
            self._nodes,
            orbits.phase,
            orbits.phase + orbits.period,
            self._constants,
            directions @ self._basis.T * self._scales,
        )
        return self.across(jets, self._flow, self._basis)

    def across(self, jets: Array, flow: Array, basis: Array) -> tuple[Array, Array]:
        """Return B(v, v) and C(v, v, v) in the section across the flow where jets end.

        Shapes: jets (r, 4, 4, n); flow (n,); basis (n, n - 1).
        """
        y = np.moveaxis(jets / self._scales, 0, 2)  # order in s, order in time, direction, state
        across = flow / (flow @ flow)

        def late(displacement: Array) -> Array:
            """Time that brings a displacement back into the section."""
            return -(displacement @ across)[:, None]

        a = late(y[1, 0])
        second = y[2, 0] + 2 * a * y[1, 1] + a**2 * y[0, 2]
        b = late(second)
        third = y[3, 0] + 3 * a * y[2, 1] + 3 * a**2 * y[1, 2] + a**3 * y[0, 3]
        third = third + 3 * b * y[1, 1] + 3 * a * b * y[0, 2]
        return second @ basis, third @ basis

    def length(self, q: Vector, multiplier: complex, monodromy: Array, ratios: Array) -> float:
        """Return the root mean square, round the cycle, of an eigenvector of the map.

        It does not depend on where the cycle starts, nor do coefficients by it. The vector is
        the flow's eigenvector that belongs to it; at a fold, where there is none, the part across
        the flow.

        Shapes: q (n - 1,); monodromy (n, n); ratios (n,).
        """
        f = self._flow
        vector = self._basis @ q
        if abs(multiplier - 1) > FORMS.off_one:
            along = f @ (super().rescaled(monodromy) @ vector) / (f @ f)
            vector = vector + f * along / (multiplier - 1)
        starts = [vector]
        for block in self._blocks(self._nodes, *self._edges())[1][:-1]:
            starts.append(block @ starts[-1])
        return self.mean_length(
            np.array(starts), ratios, at_one=abs(multiplier - 1) <= FORMS.off_one
        )

    def mean_length(self, starts: Vector, ratios: Array, *, at_one: bool = False) -> float:
        """Return the root mean square, round the cycle, of a vector that is known at its nodes.

        Samples are taken more densely until every other one has the same mean: over a period it
        converges exponentially.

        Shapes: starts (m, n); ratios (n,).
        """
        (begin, end), count = self._edges(), FORMS.samples
        while True:
            phases = np.linspace(begin, end, count, endpoint=False, axis=1)
            states, matrices = self._blocks(self._nodes, begin, phases)
            vectors = np.einsum("jpab,jb->jpa", matrices, starts)
            squares = self._squares(phases, states, vectors, ratios, at_one)
            mean, before = float(squares.mean()), float(squares[:, ::2].mean())
            count *= FORMS.denser
            if abs(mean - before) < FORMS.changed * mean or count * len(begin) > FORMS.most:
                return math.sqrt(mean)

    def _squares(
        self, phases: Array, states: Array, vectors: Vector, ratios: Array, at_one: bool
    ) -> Array:
        """Return the squared lengths of vectors, at one of their parts across the flow.

        Shapes: phases (m, p); states, vectors (m, p, n); ratios (n,); returns (m, p).
        """
        vectors, shape = vectors * ratios, states.shape
        if at_one:
            given = states.reshape(-1, shape[-1]), phases.ravel(), self._constants
            rates = self._orbits.flow.rates(*given).reshape(shape) / self._scales * ratios
            share = np.sum(vectors * rates, axis=-1) / np.sum(rates**2, axis=-1)
            vectors = vectors - share[..., None] * rates
        return np.asarray(np.sum(np.abs(vectors) ** 2, axis=-1))

    def _edges(self) -> tuple[Array, Array]:
        """Phases at which the segments begin and end."""
        orbits = self._orbits
        edges = np.linspace(orbits.phase, orbits.phase + orbits.period, len(self._nodes) + 1)
        return edges[:-1], edges[1:]

    def _blocks(self, states: Array, start: Array, end: Array) -> tuple[Array, Array]:
        """Return where states are later, (m,) or (m, p) times, and their transition matrices."""
        orbits = self._orbits
        along = self._constants.rates[:, orbits.indices]  # as compiled for the branch
        ends, matrices, _ = orbits.flow.linearize(states, start, end, self._constants, along)
        return ends, matrices * self._scales[None, :] / self._scales[:, None]


class ReturnChain(ReturnMap):
    r"""The return map as a chain of maps from one section across the flow to the next.

    A product of the maps' matrices loses a critical multiplier beside one of :math:`10^5`. The
    vectors that the normal form needs are found for all sections at once instead, from
    :math:`A_j q_j = q_{j+1}` with :math:`q_m = -q_0`, and so are the adjoint ones and those of
    second order: nothing is multiplied up. With :math:`w_j` the left null vector,

    .. math:: c = \frac{1}{6} \sum_j w_j^* \bigl(C_j(q_j, q_j, q_j) + 3 B_j(q_j, h_j)\bigr), \quad
              h_{j+1} - A_j h_j = B_j(q_j, q_j)

    for a period doubling.
    """

    def __init__(self, orbits: Orbits, z: Array, scales: Array) -> None:
        super().__init__(orbits, z, scales)
        count, n = self._nodes.shape
        if count * (n - 1) > FORMS.largest:
            raise np.linalg.LinAlgError("the cycle has too many sections")
        begin, end = self._edges()
        flows = orbits.flow.rates(self._nodes, begin, self._constants) / self._scales
        self._flows = np.concatenate([flows, flows[:1]])
        bases = np.linalg.qr(flows[:, :, None], mode="complete")[0][:, :, 1:]
        self._bases = np.concatenate([bases, bases[:1]])
        self._whole = self._blocks(self._nodes, begin, end)[1]
        self._matrices = np.swapaxes(self._bases[1:], 1, 2) @ self._whole @ self._bases[:-1]

    def doubling(self, ratios: Array) -> tuple[float, float]:
        """Return the coefficient and the mean length of the critical vector round the cycle.

        Shapes: ratios (n,).
        """
        left, values, right = np.linalg.svd(self._around(-1.0))
        if not values[-1] < FORMS.singular:
            raise np.linalg.LinAlgError("the chain has lost the multiplier of its PD")
        q, w = (vector.reshape(len(self._matrices), -1) for vector in (right[-1], left[:, -1]))
        w = w / (w[-1] @ q[0])
        known = [self._powers_of(j, each[None]) for j, each in enumerate(q)]
        squares, cubes = (np.concatenate(each) for each in zip(*known, strict=True))
        bent = np.linalg.solve(self._around(1.0), -squares.ravel()).reshape(q.shape)
        pairs = enumerate(zip(q.astype(complex), bent.astype(complex), strict=True))
        mixed = [polarized(partial(self._squares_of, j), [pair])[0].real for j, pair in pairs]
        return float(np.vdot(w, cubes + 3 * np.array(mixed)) / 6), self._mean(q, ratios)

    def _around(self, factor: float) -> Array:
        """Return the matrix of ``A_j q_j - q_(j+1)``, the last ``q_m`` the first times a factor."""
        count, n, _ = self._matrices.shape
        matrix = np.zeros((count, n, count, n))
        for j, block in enumerate(self._matrices):
            matrix[j, :, j] += block
            matrix[j, :, (j + 1) % count] -= np.eye(n) * (factor if j == count - 1 else 1.0)
        return matrix.reshape(count * n, count * n)

    def _squares_of(self, j: int, directions: Array) -> Array:
        return self._powers_of(j, directions)[0]

    def _powers_of(self, j: int, directions: Array) -> tuple[Array, Array]:
        """Return B(v, v) and C(v, v, v) of one map. Shapes: directions (r, n - 1)."""
        begin, end = (float(edges[j]) for edges in self._edges())
        jets = self._orbits.flow.jet_in_time(
            self._nodes[j : j + 1],
            begin,
            end,
            self._constants,
            directions @ self._bases[j].T * self._scales,
        )
        return self.across(jets, self._flows[j + 1], self._bases[j + 1])

    def _mean(self, q: Array, ratios: Array) -> float:
        """Return the root mean square of the flow's own vector that lies over q."""
        starts = np.einsum("jab,jb->ja", self._bases[:-1], q)
        ends = np.einsum("jab,jb->ja", self._whole, starts)
        flows = self._flows[1:]
        gained = np.sum(ends * flows, axis=1) / np.sum(flows**2, axis=1)
        before = np.concatenate([[0.0], np.cumsum(gained)])
        along = before[:-1] - before[-1] / 2  # the vector turns round: -1 - 1
        return self.mean_length(starts + along[:, None] * self._flows[:-1], ratios)
