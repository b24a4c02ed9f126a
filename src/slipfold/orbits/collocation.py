"""Second and third derivatives of the ends of intervals, through the system that solves them."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from slipfold.arrays import Array, Indices
from slipfold.flow.equations import Constants
from slipfold.flow.intervals import MANY, Field, Intervals, LinearPart, Stages, solve_intervals
from slipfold.models.model import Model
from slipfold.orbits.discretization import GAUSS, Scheme
from slipfold.orbits.meshes import (
    FLOOR,
    INTERVALS,
    MeshDiscretization,
    even_mesh,
    graded,
    repeated,
    spread,
    steepness,
)


class MESH:
    """What meshes of collocation are made for."""

    error: float = 1e-6  # inside an interval, in scaled states; less at nodes in smooth motion
    slack: float = 5.0  # errors up to which a mesh serves
    spare: float = 1.15  # intervals over those that the error needs
    wasteful: float = 2.5  # the same, from which a mesh is made coarser
    max_intervals: int = 1500  # beyond, errors are what they are
    finer: float = 1.3  # intervals of a second mesh over those of the first: errors are a 23rd
    gone: float = 100.0  # exponent of decay over an interval of which exp(-84 / 100) is left
    growth: float = 4.0  # exponent of growth over an interval, which is solved from its first state
    reach: float = 0.2  # change of scaled states over which polynomials are extrapolated


class Collocation(MeshDiscretization):
    """Polynomials that meet the equations at some points of the m intervals of a mesh.

    An interval is solved from its first state alone, so that the unknowns are those of shooting:
    the states at the mesh points. With Gauss points, implicit and symmetric, it takes fast decay
    and fast growth alike; with Radau points fast vibrations decay.

    `edges`, shape (m + 1,), are a mesh over the whole period; without them it is uniform, of at
    least as many `segments`.
    """

    growing = True

    def __init__(
        self,
        model: Model,
        free: Mapping[str, float],
        period: int = 1,
        segments: int = 0,
        *,
        edges: Array | None = None,
        scheme: Scheme = GAUSS,
    ) -> None:
        if edges is None:
            least = int(np.ceil(scheme.density * period))
            edges = even_mesh(model, period, max(segments, least))
        super().__init__(model, free, period, edges)
        self._scheme, self.points = scheme, scheme.points
        if self.points.damps:
            self.noise = self.remainder = MESH.error  # near stiff modes
        self.lengths = np.diff(edges)
        self._linear = LinearPart()
        # Coefficients and polynomials that were solved last; their changes with free parameters
        self._latest: tuple[Array, Stages] | None = None

    def _free(self, free: Mapping[str, float]) -> None:
        super()._free(free)
        self._slopes: tuple[Stages, Array] | None = None  # those of other parameters do not serve

    def on(self, edges: Array, scheme: Scheme | None = None) -> Collocation:
        """Return the same on another mesh over the whole period. Shapes: edges (m + 1,)."""
        period = round(edges[-1] - edges[0])
        given = self.model, self.free, period
        other = Collocation(*given, edges=edges, scheme=scheme or self._scheme)
        other.measure_in(self.scales)
        return other

    # -- equations -----------------------------------------------------------------------------

    def mismatch(self, nodes: Array, constants: Constants) -> Array:
        """Return by how much intervals end beside the next node, in scaled states, shape (m, n)."""
        scaled = nodes / self.scales
        ends = self._solved(scaled, constants, derived=False).ends
        return self.apart(ends, scaled[self._following])

    def transitions(self, nodes: Array, constants: Constants) -> tuple[Array, Array, Array]:
        """Return the mismatch and the derivatives of the intervals' ends, all in scaled states."""
        scaled, field = nodes / self.scales, self._field(constants)
        solved = self._solved(scaled, constants)
        by_parameters, along = solved.answered(field.parameter_slopes(solved.stages, solved.phases))
        self._slopes = solved, by_parameters
        mismatch = self.apart(solved.ends, scaled[self._following])
        return mismatch, solved.matrices, along * (self.units / np.sqrt(self.segments))

    def settled(self, blocks: Array, nodes: Array, constants: Constants) -> Array | None:
        """Return blocks without what decays within an interval, None where they are as good.

        The method multiplies it by nearly one instead. It lies in eigenvectors of the Jacobian, but
        for the square of how far these turn while it decays.
        """
        if self.points.damps:
            return None
        slopes = self._field(constants).jacobians(nodes / self.scales, self.start)
        slopes *= self.lengths[:, None, None]
        stiff = np.flatnonzero(np.abs(slopes).sum(axis=2).max(axis=1) > MESH.gone)
        if not len(stiff) or not np.isfinite(slopes).all():
            return None
        values, vectors = np.linalg.eig(slopes[stiff])
        stays = np.where(values.real > -MESH.gone, 1.0, 0.0)
        try:
            projectors = ((vectors * stays[:, None]) @ np.linalg.inv(vectors)).real
        except np.linalg.LinAlgError:  # eigenvectors coincide: which of them decay is not known
            return None
        settled = blocks.copy()
        settled[stiff] = settled[stiff] @ projectors
        return settled

    def rates(self, nodes: Array, constants: Constants) -> Array:
        """Return the rates at the nodes a forcing period, in scaled states, shape (m, n).

        Of stiff modes they are nothing but rounding, which slopes of polynomials are free of.
        """
        if not self.points.damps:
            return super().rates(nodes, constants)
        solved = self._solved(nodes / self.scales, constants, derived=False)
        found = np.roll(solved.slopes[:, -1], 1, axis=0)
        # Rounding that fast modes magnify decays in a few intervals.
        for _ in range(3 if solved.is_derived else 0):
            found = np.roll(np.einsum("jab,jb->ja", solved.matrices, found), 1, axis=0)
        return found

    def divergence(self, nodes: Array, constants: Constants) -> float:
        """Return the integral of the rates' divergence over the orbit."""
        solved = self._solved(nodes / self.scales, constants)
        assert solved.jacobians is not None
        traces = np.einsum("jkaa->jk", solved.jacobians.whole)
        return float(self.lengths @ (traces @ self.points.weights))

    def divergence_slope(self, nodes: Array, constants: Constants) -> tuple[Array, Array]:
        """Return the derivatives of that integral by the scaled nodes and the free parameters."""
        field, solved = self._field(constants), self._solved(nodes / self.scales, constants)
        stages, phases = solved.stages, solved.phases
        directions = [np.tile(unit, (*stages.shape[:2], 1)) for unit in np.eye(len(self.scales))]
        turned = [field.curvatures(stages, phases, along) for along in directions]
        weights = (self.lengths[:, None] * self.points.weights)[..., None]
        by_states = weights * sum(bent[..., i, :] for i, (bent, _) in enumerate(turned))
        by_free = weights * sum(mixed[..., i, :] for i, (_, mixed) in enumerate(turned))
        by_parameters = solved.answered(field.parameter_slopes(stages, phases))[0]
        by_nodes = np.einsum("jka,jkab->jb", by_states, solved.equations.moved)
        free = by_free.sum(axis=(0, 1)) + np.einsum("jka,jkaf->f", by_states, by_parameters)
        return by_nodes, free * self.units

    def solved(self, nodes: Array, constants: Constants) -> Stages:
        """Return the polynomials with their derivatives. Shapes: nodes (m, n)."""
        return self._solved(nodes / self.scales, constants)

    def _field(self, constants: Constants) -> Field:
        return Field(self.flow, constants, self.scales, self.indices, self._linear)

    def _solved(self, scaled: Array, constants: Constants, *, derived: bool = True) -> Stages:
        """Return the polynomials from scaled nodes, from those that were found last if these serve.

        Where their derivatives are not wanted, those of other nodes may stand in their place.
        """
        field = self._field(constants)
        if self._latest is not None:
            values, latest = self._latest
            known = latest.is_derived or not derived
            known = known and np.array_equal(values, constants.values)
            if known and np.array_equal(latest.nodes, scaled):
                return latest
        equations = None if self._slopes is None else self._slopes[0].equations
        for guessed in (self._extrapolated, self._interpolated):
            guess = guessed(scaled, constants)
            if guess is None:
                continue
            given = Intervals(self.points, scaled, self.start, self.lengths)
            solved = solve_intervals(field, given, guess, equations, derived=derived)
            if np.isfinite(solved.rates[0, 0, 0]):
                self._latest = constants.values, solved
                break
        return solved

    def _extrapolated(self, scaled: Array, constants: Constants) -> Array | None:
        """Return stages from those that were found last, None if these are far away."""
        if self._latest is None or self._slopes is None:
            return None
        (values, latest), (solved, by_parameters) = self._latest, self._slopes
        change = scaled - latest.nodes
        if not np.abs(change).max() < MESH.reach:
            return None
        along = constants.rates[:, self.indices]
        moved = np.linalg.lstsq(along, constants.values - values, rcond=None)[0]
        return np.asarray(latest.stages + solved.equations.along(change) + by_parameters @ moved)

    def _interpolated(self, scaled: Array, constants: Constants) -> Array:
        """Return stages on the cubics through the nodes with the rates there."""
        field = self._field(constants)
        t = self.points.points[:, None]
        rates = field.rates(scaled, self.start) * self.lengths[:, None]
        after = field.rates(scaled[self._following], self.end) * self.lengths[:, None]
        a = scaled[:, None]
        b = a + self.apart(scaled[self._following], scaled)[:, None]
        rise = 3 * t**2 - 2 * t**3
        return np.asarray(
            a
            + (b - a) * rise
            + rates[:, None] * (t - 2 * t**2 + t**3)
            + after[:, None] * (t**3 - t**2)
        )

    def curvatures(self, nodes: Array, constants: Constants, vectors: Array) -> tuple[Array, Array]:
        """Return the derivatives of ``blocks @ vectors``, all in scaled states."""
        field = self._field(constants)
        solved = self._solved(nodes / self.scales, constants)
        by_parameters = solved.answered(field.parameter_slopes(solved.stages, solved.phases))[0]
        n, bent, mixed = nodes.shape[1], list[Array](), list[Array]()
        for vector in vectors:
            along = solved.equations.along(vector)
            second, by_free = field.curvatures(solved.stages, solved.phases, along)
            pushes = np.concatenate(
                [second @ solved.equations.moved, second @ by_parameters + by_free], axis=3
            )
            ends = solved.answered(pushes)[1]
            bent.append(ends[:, :, :n])
            mixed.append(ends[:, :, n:])
        return np.array(bent), np.array(mixed) * self.units

    def cubes(self, nodes: Array, constants: Constants, vectors: Array) -> Array:
        """Return the third derivatives of the intervals' ends along vectors, in scaled states."""
        field = self._field(constants)
        solved = self._solved(nodes / self.scales, constants)
        found = list[Array]()
        for vector in vectors:
            first = solved.equations.along(vector)
            bent = field.curvatures(solved.stages, solved.phases, first)[0]
            second = solved.answered(bent @ first[..., None])[0]
            cubes = field.cubes(solved.stages, solved.phases, first)[..., None]
            found.append(solved.answered(cubes + 3 * bent @ second)[1][..., 0])
        return np.array(found)

    # -- states elsewhere ----------------------------------------------------------------------

    def _ended(
        self, nodes: Array, constants: Constants, phases: Array, *, derived: bool = True
    ) -> tuple[Stages, Indices]:
        """Intervals that end at any phases, solved from the nodes before them."""
        scaled, (which, within) = nodes / self.scales, self.before(phases)
        solved = self._solved(scaled, constants, derived=derived)
        beyond = within - self.start[which]
        places = (beyond / self.lengths[which])[:, None] * self.points.points
        guess, field = solved.at(places, which), self._field(constants)
        given = Intervals(self.points, scaled[which], self.start[which], beyond)
        return solve_intervals(field, given, guess, derived=derived), which

    def propagate_to(
        self, nodes: Array, constants: Constants, phases: Array
    ) -> tuple[Indices, Array, Array, Array]:
        """Return the states at any phases, from which node each is reached, and derivatives."""
        part, which = self._ended(nodes, constants, phases)
        by_parameters = part.answered(
            self._field(constants).parameter_slopes(part.stages, part.phases)
        )[1]
        return (
            which,
            part.ends * self.scales,
            part.matrices / self.ratios,
            by_parameters * self.scales[:, None],
        )

    def states(self, nodes: Array, constants: Constants, phases: Array) -> Array:
        """Return the states at any phases, shape (q, n)."""
        return self._ended(nodes, constants, phases, derived=False)[0].ends * self.scales

    def stage_states(self, nodes: Array, constants: Constants) -> tuple[Array, Array]:
        """Return the states at all points of all intervals, and their phases."""
        solved = self._solved(nodes / self.scales, constants, derived=False)
        return solved.stages.reshape(-1, nodes.shape[1]) * self.scales, solved.phases.ravel()

    def with_other_errors(self, nodes: Array, constants: Constants) -> Collocation:
        """Return the same on another, finer mesh."""
        count = round(MESH.finer * self.segments / self.copies) * self.copies
        places = np.linspace(0.0, self.segments, count + 1)
        return self.on(np.interp(places, np.arange(self.segments + 1), self.edges))

    # -- the mesh ------------------------------------------------------------------------------

    def better(
        self, nodes: Array, constants: Constants, blocks: Array | None = None
    ) -> Collocation | None:
        """Return the same on a mesh that fits an orbit better, None if its own serves."""
        solved = self._solved(nodes / self.scales, constants, derived=False)
        if not np.isfinite(solved.slopes).all():
            return None
        order = len(self.points.points) + 1
        own = solved.slopes * (self.scales / self.sizes)
        density = steepness(self.edges, own, self.points)
        density *= (self.points.error / MESH.error) ** (1 / order)
        density = np.maximum(density, self._growth(nodes, constants) / MESH.growth)
        errors = (density * self.lengths) ** order
        scheme = self.scheme(nodes, constants, order - 1)
        pattern, density = self.pattern(density)
        density = np.maximum(density, scheme.density)
        lengths = np.diff(pattern)
        wanted = MESH.spare * (1 + FLOOR) * float(density @ lengths)
        wanted = int(np.ceil(min(max(INTERVALS, wanted), MESH.max_intervals // self.copies)))
        fits = scheme.points is self.points and scheme.density * lengths.max() <= MESH.finer
        better = graded(spread(pattern, density, wanted))
        if fits and errors.max() <= MESH.slack and len(pattern) <= MESH.wasteful * len(better):
            return None
        return self.on(repeated(better, self.copies), scheme)

    def spread_over(self, changes: Array) -> Collocation:
        """Return the same where all intervals have equal changes of the states, shape (m,)."""
        density = (changes / self.lengths).reshape(self.copies, -1).max(axis=0)
        pattern = graded(spread(self.mesh[: len(density) + 1], density, 4 * INTERVALS))
        return self.on(repeated(pattern, self.copies))

    def _growth(self, nodes: Array, constants: Constants) -> Array:
        """Return the largest rate at which perturbations grow on each interval, shape (m,)."""
        each = 1 if nodes.shape[1] < MANY else MANY // 2  # else it would take longest
        scaled, phases = nodes[::each] / self.scales, self.start[::each]
        slopes = self._field(constants).jacobians(scaled, phases)
        rates = np.repeat(np.linalg.eigvals(slopes).real.max(axis=1), each)[: len(nodes)]
        return np.maximum(rates, np.roll(rates, -each))
