"""An orbit computed again by collocation, on a mesh and with points of its own."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np

from slipfold.arrays import Array, Complex
from slipfold.continuation.newton import correct
from slipfold.flow.flow import flow_of
from slipfold.models.angles import wrap_angles
from slipfold.models.model import Model, evaluation_of
from slipfold.newton import Rule, find_root
from slipfold.orbits.collocation import MESH, Collocation
from slipfold.orbits.continued import fitted, hold_parameter, on_mesh
from slipfold.orbits.discretization import STAGES, Discretization
from slipfold.orbits.kinds import orbits_at
from slipfold.orbits.linearization import Linearization
from slipfold.orbits.multipliers import (
    cycle_multipliers,
    multiplier_difference,
    product_eigenvalues,
)
from slipfold.orbits.orbit_curve import OrbitCurve, Orbits
from slipfold.orbits.test_functions import match_multipliers
from slipfold.read_only import Documented, ReadOnly
from slipfold.text import OneLine, PrintedTable, multipliers_text, number_text

SINGULAR = 1e-4
"""With a multiplier this near to one, orbits a residual of 1e-12 apart differ by 1e-8 and more:
then the equations are made regular as at a fold."""


AT_REST = Rule(close=1e-9, iterations=20)


@dataclass(frozen=True, eq=False, repr=False)
class CollocatedOrbit(OneLine, ReadOnly):
    """A periodic orbit by piecewise polynomials; frozen."""

    model: Annotated[Model, "The model; of a cycle, its ``duration`` is that of the guess."]
    period: Annotated[int, "Period in forcing periods, or revolutions of a cycle."]
    edges: Annotated[Array, "Phases of the ends of the N intervals, shape (N + 1,)."]
    states: Annotated[Array, "States at the beginning of each interval, shape (N, n_states)."]
    anchors: Annotated[Array, "States at `period` * j / M, shape (M, n_states)."]
    duration: Annotated[float, "Duration of the whole orbit in seconds."]
    multipliers: Annotated[
        Complex,
        "Floquet multipliers, largest modulus first, shape (n_states,); the one of a cycle's "
        "own direction stands where the modulus falls below one.",
    ]
    mismatch: Annotated[float, "Largest violation of a collocation equation, in scaled states."]
    error: Annotated[
        float,
        "How much states at the edges (in scaled states), duration and multipliers (relative to "
        "the larger of one and the largest) differ from those on a mesh of half as many "
        "intervals. Their own error is smaller. Infinite where Newton's method did not "
        "converge.",
    ]
    converged: Annotated[bool, "Whether that is within the tolerance."]

    def _line(self) -> str:
        converged = "" if self.converged else "not "
        return (
            f"CollocatedOrbit of {self.model.name}: period {self.period}, "
            f"{len(self.edges) - 1} intervals, {converged}converged, "
            f"{multipliers_text(self.multipliers, cycle=not self.model.forced)}"
        )

    def _rows(self) -> PrintedTable:
        facts = {"duration (s)": self.duration, "mismatch": self.mismatch, "error": self.error}
        return PrintedTable(["", ""], [[name, number_text(v)] for name, v in facts.items()])


@dataclass(frozen=True, eq=False, repr=False)
class OrbitCheck(OneLine, Documented):
    """How far an orbit is from the same one by collocation; frozen."""

    collocated: Annotated[
        CollocatedOrbit, "The orbit by collocation, with its mesh and multipliers."
    ]
    states: Annotated[
        float, "Largest difference of the states at the orbit's nodes, in scaled states."
    ]
    duration: Annotated[float, "Difference of the durations, as a fraction."]
    multipliers: Annotated[
        float,
        "Largest difference of the multipliers, as a fraction of the largest or of one; those "
        "that coincide are compared by their mean.",
    ]
    tolerance: Annotated[float, "What is allowed of each."]

    @property
    def passed(self) -> bool:
        """Whether collocation converged and every difference is within the tolerance."""
        return self._converged and self._largest <= self.tolerance

    @property
    def _converged(self) -> bool:
        """Whether halving the intervals changes less than is allowed; collocation aims at less."""
        return self.collocated.error <= self.tolerance

    @property
    def _largest(self) -> float:
        differences = [self.states, self.duration, self.multipliers, self.collocated.mismatch]
        return float(np.max(differences))  # NaN if any is

    def _line(self) -> str:
        verdict = "within" if self.passed else "not within"
        return (
            f"OrbitCheck: states {self.states:.1e}, duration {self.duration:.1e}, multipliers "
            f"{self.multipliers:.1e}, {verdict} {self.tolerance:.0e}"
        )

    def _rows(self) -> PrintedTable:
        names = ("states", "duration", "multipliers", "tolerance")
        lines = [[name, f"{getattr(self, name):.1e}"] for name in names]
        return PrintedTable(["", "difference"], lines, ("",))

    def __str__(self) -> str:
        """Say it in a sentence."""
        found = self.collocated
        differences = (
            f"states differ by {self.states:.1e}, the duration by {self.duration:.1e}, "
            f"multipliers by {self.multipliers:.1e}"
        )
        intervals = f"{len(found.edges) - 1} intervals"
        if not self._converged:
            return (
                f"collocation did not settle on {intervals}, where halving them still changes "
                f"{found.error:.1e}; {differences}"
            )
        verdict = "within" if self.passed else "not within"
        return f"collocation on {intervals}: {differences}, {verdict} {self.tolerance:.0e}"


def orbit_by_collocation(
    model: Model, nodes: Array, period: int, multipliers: Complex
) -> CollocatedOrbit:
    """Return the orbit with these nodes and multipliers. Shapes: nodes (m, n); multipliers (n,)."""
    if rests(model, nodes):
        return _equilibrium(model, nodes, period, is_singular(multipliers, 0))
    singular = is_singular(multipliers, 0 if model.forced else 1)
    return collocate(model, nodes, period, singular=singular)


def collocate(
    model: Model, nodes: Array, period: int = 1, *, singular: bool = False
) -> CollocatedOrbit:
    """Find the periodic orbit near the states at equidistant phases, and its multipliers.

    Intervals have one point more than those of orbits by collocation, so that their errors differ.
    The mesh fits the orbit, and is halved until that no longer changes the result. The result is
    compared with the equations as they are compiled for nothing else.

    Shapes: nodes (M, n_states).
    """
    shot = orbits_at(model, period, len(nodes))
    guess = shot.unknown(nodes, model)
    orbits, z = on_mesh(shot, guess, STAGES + 1)
    coarse, best = _Solution.near(orbits, z, singular=singular), np.inf
    while True:
        finer = coarse.orbits.described_by(_halved(coarse.orbits.by))
        fine = _Solution.near(finer, finer.adopt(coarse.orbits, coarse.z), singular=singular)
        error = coarse.difference(fine)
        # The error on the finer mesh is a 2^14th of the change.
        converged, stalled = error < 1e-10, best / 2 < error < np.inf
        if converged or stalled or fine.orbits.segments > MESH.max_intervals * period:
            break
        coarse, best = fine, error
    orbits, constants = fine.orbits, fine.orbits.constants(fine.z)
    anchors: Array = np.linspace(0.0, period, len(nodes), endpoint=False, dtype=float)
    states = orbits.nodes(fine.z)
    assert isinstance(orbits.by, Collocation)
    if fine.gauge is not None:  # a cycle has moved along itself while it was corrected
        rates = orbits.by.rates(states, constants)
        gap = (orbits.nodes(orbits.adopt(shot, guess)) - states) / orbits.scales
        anchors += float((rates * gap).sum() / (rates * rates).sum())
    return CollocatedOrbit(
        model,
        period,
        orbits.by.edges,
        states,
        orbits.by.states(states, constants, anchors),
        constants.period * period,
        fine.multipliers,
        fine.mismatch(),
        error,
        converged,
    )


def mesh_errors(
    model: Model, nodes: Array, period: int, multipliers: Complex
) -> tuple[float, Array]:
    """Return the errors of states (scaled) and multipliers on a mesh such as branches have.

    That with which branches begin, if it serves: a finer one has smaller errors than theirs. It
    serves no orbit that lingers nearly all the time, which its intervals step over. The errors are
    the changes when the intervals are halved. The equations are made regular: where they leave the
    place along the branch open, as near a homoclinic orbit, a change of place is no error. Infinite
    where Newton's method does not converge. The arguments are those of `orbit_by_collocation`;
    returns a number and (n,).
    """
    shot = orbits_at(model, period, len(nodes))
    guess = shot.unknown(nodes, model)
    scheme = shot.by.scheme(nodes, shot.constants(guess))
    first = shot.described_by(Collocation(model, shot.by.free, period, scheme=scheme))
    coarse = _Solution.near(*fitted(first, first.adopt(shot, guess)), singular=True)
    if not coarse.converged:
        coarse = _Solution.near(*on_mesh(shot, guess), singular=True)
    halved = coarse.orbits.described_by(_halved(coarse.orbits.by))
    fine = _Solution.near(halved, halved.adopt(coarse.orbits, coarse.z), singular=True)
    if not (coarse.converged and fine.converged):
        return np.inf, np.full(len(multipliers), np.inf)
    one, other = (match_multipliers(multipliers, on.multipliers) for on in (coarse, fine))
    return coarse.states_apart(fine), np.abs(one - other)


@dataclass(frozen=True, eq=False)
class _Solution:
    """An orbit on one mesh."""

    orbits: Orbits  # by collocation
    z: Array  # its unknown
    multipliers: Complex  # shape (n,), largest modulus first
    excess: float  # what the equations lack at a fold or branch point, in scaled states
    gauge: Array | None  # along which beginning later moves a cycle; None of a forced orbit
    converged: bool

    @staticmethod
    def near(orbits: Orbits, z: Array, *, singular: bool) -> _Solution:
        """Solve the equations by Newton's method."""
        unfolded = _Unfolded(orbits, z) if singular else None
        if unfolded is None:
            found = correct(orbits, z, hold_parameter(len(z) - 1))
        else:
            found = correct(unfolded, np.append(z[:-1], 0.0), unfolded.row)
        solution = np.append(found.z[:-1], z[-1])
        excess = 0.0 if unfolded is None else unfolded.excess(found.z)
        part = orbits.linearize(solution)
        gauge = None if part.conditions.gradients is None else part.conditions.gradients[0]
        if gauge is None:
            multipliers = product_eigenvalues(part.factors)
        else:
            rates = orbits.nodes(gauge) / orbits.scales
            trivial, others = cycle_multipliers(part.factors, rates)
            multipliers = np.insert(others, int(np.count_nonzero(np.abs(others) > 1)), trivial)
        return _Solution(orbits, solution, multipliers, excess, gauge, found.converged)

    def difference(self, finer: _Solution) -> float:
        """Return how far the result on twice as many intervals is from this one."""
        if not (self.converged and finer.converged):
            return np.inf
        periods = [item.orbits.constants(item.z).period for item in (self, finer)]
        return max(
            self.states_apart(finer),
            abs(periods[0] / periods[1] - 1),
            multiplier_difference(finer.multipliers, self.multipliers),
        )

    def states_apart(self, finer: _Solution) -> float:
        """Return how far its states are from those on twice as many intervals, in scaled states."""
        apart = self.orbits.flat(finer.orbits.nodes(finer.z)[::2]) - self.z[: self.orbits.size]
        gauge = self.gauge
        if gauge is not None:  # wherever cycles are started
            apart = apart - (gauge[: len(apart)] @ apart) * gauge[: len(apart)]
        return float(np.abs(apart).max()) * float(np.sqrt(self.orbits.segments))

    def mismatch(self) -> float:
        """Return the largest violation of an equation, in scaled states.

        Rates and Jacobians are those of the model's `evaluation`, not of the flow.
        """
        orbits, by, scales = self.orbits, self.orbits.by, self.orbits.scales
        assert isinstance(by, Collocation)
        nodes, constants = orbits.nodes(self.z), orbits.constants(self.z)
        solved, steps = by.solved(nodes, constants), by.lengths[:, None, None]
        assert solved.jacobians is not None
        model, phases = orbits.model_at(self.z), solved.phases - np.floor(solved.phases)
        rates, jacobians = evaluation_of(model).linear(model, solved.stages * scales, phases)
        rates, jacobians = rates * constants.period / scales, jacobians * constants.period
        inside = solved.stages - solved.nodes[:, None] - steps * (by.points.inner @ rates)
        ends = solved.nodes + steps[:, 0] * np.einsum("k,jka->ja", by.points.weights, rates)
        ends = wrap_angles(ends - np.roll(solved.nodes, -1, axis=0), by.angle_periods)
        slopes = steps[..., None] * (jacobians * by.ratios - solved.jacobians.whole)
        slopes /= max(1.0, float(np.abs(steps[..., None] * solved.jacobians.whole).max()))
        return float(
            np.max([np.abs(item).max() for item in (inside, ends, slopes)] + [self.excess])
        )


def _halved(by: Discretization) -> Collocation:
    """Return the same on a mesh whose intervals are half as long."""
    assert isinstance(by, Collocation)
    middles = (by.edges[:-1] + by.edges[1:]) / 2
    return by.on(np.sort(np.concatenate([by.edges, middles])))


class _Unfolded(OrbitCurve):
    r"""The equations of an orbit at a fold or branch point, made regular.

    The equations F(u) = 0 become :math:`F(u) + \beta \psi = 0` and
    :math:`\phi^T (u - u_0) = 0` with :math:`\beta` in the place of the parameter and the vectors
    that the matrix sends to nearly nothing from either side.
    """

    def __init__(self, orbits: Orbits, z: Array) -> None:
        self.orbits, self._value = orbits, z[-1]
        part = orbits.linearize(z)
        self._column = np.cos(np.arange(orbits.size))  # any vector, but not one with a symmetry
        self.row = np.append(np.cos(np.arange(len(z) - 1)), 0.0)
        unit = hold_parameter(len(z) - 1)
        # Each time the error is that of the matrix being regular, 1e-4 and less, times the last.
        for _ in range(3):
            bordered = self._with_column(part).bordered(self.row)
            left, right = bordered.solve_transposed(unit), bordered.solve(unit)
            self._column = left[: orbits.size] / np.linalg.norm(left[: orbits.size])
            self.row = np.append(right[:-1], 0.0) / np.linalg.norm(right[:-1])

    def _with_column(self, part: Linearization) -> Linearization:
        along = part.along.copy()
        along[..., -1] = self._column.reshape(along.shape[:2])
        return replace(part, along=along)

    def defect(self, z: Array) -> Array:
        """Return what Newton's method brings to zero."""
        defect = self.orbits.defect(np.append(z[:-1], self._value))
        defect[: len(self._column)] += z[-1] * self._column
        return defect

    def linearize(self, z: Array) -> Linearization:
        """Return the same with its derivatives."""
        part = self._with_column(self.orbits.linearize(np.append(z[:-1], self._value)))
        added = z[-1] * np.sqrt(len(part.residual)) * self._column
        return replace(part, residual=part.residual + added.reshape(part.residual.shape))

    def excess(self, z: Array) -> float:
        """Return the largest change of an equation, in scaled states."""
        return float(np.abs(z[-1] * self._column).max() * np.sqrt(self.orbits.segments))


def _equilibrium(model: Model, nodes: Array, period: int, singular: bool) -> CollocatedOrbit:
    r"""Find the equilibrium near the first node from the equations alone.

    Its multipliers over the time :math:`\tau` are :math:`e^{\lambda \tau}` with the eigenvalues
    of the Jacobian. At a fold the direction that the Jacobian can hardly see is left as it is.
    """
    functions, scales = evaluation_of(model), model.state_scales()
    time = functions.period(model)

    def linear(state: Array) -> tuple[Array, Array]:
        rates, jacobian = functions.linear(model, state * scales, np.zeros(()))
        return rates / scales * time, jacobian * (scales / scales[:, None]) * time

    def step(state: Array) -> Array:
        rates, jacobian = linear(state)
        seen = SINGULAR / min(max(float(np.linalg.norm(jacobian)), SINGULAR), 1.0)
        inverse = np.linalg.pinv(jacobian, rcond=seen if singular else 1e-15)
        return np.asarray(-inverse @ rates)

    found = find_root(step, nodes[0] / scales, AT_REST)
    state = nodes[0] / scales if found is None else found
    rates, jacobian = linear(state)
    values = np.exp(np.linalg.eigvals(jacobian).astype(complex) * period)
    states = np.tile(state * scales, (len(nodes), 1))
    return CollocatedOrbit(
        model,
        period,
        np.linspace(0.0, period, len(nodes) + 1),
        states,
        states.copy(),
        period * time,
        values[np.argsort(-np.abs(values), kind="stable")],
        float(np.abs(rates).max() * period),
        np.inf if found is None else float(np.abs(step(state)).max()),
        found is not None,
    )


def is_singular(multipliers: Complex, always: int) -> bool:
    """Whether one multiplier more than always is so near to one that equations are made regular."""
    distance = np.sort(np.abs(multipliers - 1))
    return len(distance) > always and bool(distance[always] < SINGULAR)


def rests(model: Model, states: Array) -> bool:
    """Whether an orbit is an equilibrium. Shapes: states (m, n)."""
    if model.forced:
        return False
    flow = flow_of(model)
    rates = flow.rates(states, np.zeros(len(states)), flow.constants_of(model))
    return bool(np.abs(rates / model.state_scales()).max() < 1e-8)
