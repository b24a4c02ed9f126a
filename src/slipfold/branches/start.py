"""First points of branches: from the linear response, or from a period doubling."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from slipfold.branches.settings import Settings
from slipfold.continuation.newton import correct
from slipfold.continuation.walk import Failure, walk
from slipfold.errors import InputError
from slipfold.models.equilibrium_search import search_equilibrium
from slipfold.models.evaluation import evaluation_of
from slipfold.models.model import Model
from slipfold.orbits.boundary_value_problem import PeriodicProblem
from slipfold.orbits.cycle_problem import CycleProblem, on_quotient
from slipfold.orbits.equilibrium_problem import EquilibriumProblem, transition, unit_of_time
from slipfold.orbits.find import guess_orbit, hold_parameter
from slipfold.orbits.limits import broken_limit
from slipfold.orbits.orbit_point import OrbitPoint, make_point
from slipfold.orbits.periodic_orbit import PeriodicOrbit

__all__ = ["doubled_start", "equilibrium_start", "hopf_start", "orbit_start", "response_start"]

Array = NDArray[np.float64]

SINGULAR = 1e8
"""Newton's method at a worse condition leaves half of all digits: the value held is that of a fold
or branch point."""

NEAR = 0.3
"""An orbit this far from the linear response, in scaled states, may belong to another branch."""


def response_start(problem: PeriodicProblem, value: float, forward: float) -> OrbitPoint:
    """Return the response of period 1 at a value of the parameter.

    The linear response is corrected by Newton's method. Where that fails or leads far away, the
    response is followed from the model's quiet state, in the parameter that scales the forcing.
    """
    row = hold_parameter(problem.size) * forward
    correction = guess_orbit(problem, value)
    if not correction.converged or correction.distance > NEAR:
        nodes = _nodes_from_quiet(problem, value)
        correction = correct(problem, problem.pack(nodes, value), row)
    else:
        correction = correct(problem, correction.z, row)
    if not correction.converged:
        raise InputError(
            f"no response of period 1 was found at {problem.vary} = {value:g}: "
            f"{correction.failure}; start the span elsewhere"
        )
    broken = broken_limit(problem, correction.z)
    if broken is not None:
        raise InputError(f"the span cannot start at {problem.vary} = {value:g}: {broken}")
    return problem.point(correction, 0.0)


def _nodes_from_quiet(problem: PeriodicProblem, value: float) -> Array:
    """Follow the response from the quiet state at the given value of the other parameter."""
    model = problem.model.replace(**{problem.vary: value})
    quiet = model.quiet
    if quiet is None or not model.values[quiet]:
        raise InputError(
            f"no response of period 1 was found at {problem.vary} = {value:g}: Newton's method "
            "does not converge from the linear response; start the span elsewhere"
        )
    target = model.values[quiet]
    other = PeriodicProblem(model, quiet, 1, abs(target), problem.segments)
    correction = guess_orbit(other, 0.0)
    if not correction.converged:
        raise InputError(
            f"no rest state was found at {problem.vary} = {value:g} with {quiet} = 0: "
            f"{correction.failure}; start the span elsewhere"
        )
    row = hold_parameter(other.size) * np.sign(target)
    start = other.point(correct(other, correction.z, row), 0.0)
    point: OrbitPoint | Failure = start
    for point in walk(other, [start], 0.01, other.bounds((0.0, target)), Settings()):
        if isinstance(point, Failure):
            break
        broken = broken_limit(other, point.z)
        if broken is not None:
            point = Failure("limit", broken)
            break
    if isinstance(point, Failure) or other.value(point.z) != target:
        reason = point.reason if isinstance(point, Failure) else "the response turns back before"
        raise InputError(
            f"no response of period 1 was found at {problem.vary} = {value:g}: followed from "
            f"{quiet} = 0 it does not reach {quiet} = {target:g} ({reason}); start the span "
            f"elsewhere or lower {quiet}"
        )
    return other.nodes(point.z)


def equilibrium_start(
    model: Model, vary: str, first: float, last: float, near: Array | None = None
) -> tuple[EquilibriumProblem, OrbitPoint]:
    """Return the equilibrium of an autonomous model at the first value of a span.

    Shapes: near (n,).
    """
    near = model.start if near is None else near
    state = search_equilibrium(model, near)
    if state is None:
        raise InputError(
            f"no equilibrium of {model.name} was found at {vary} = {first:g}, from the state "
            f"{near.tolist()} or around it; give a start nearer to one, or start the span "
            "elsewhere"
        )
    jacobian = evaluation_of(model).jacobian(model, state)
    paced = model.replace(duration=unit_of_time(model, jacobian))
    problem = EquilibriumProblem(paced, vary, 1, abs(last - first))
    row = hold_parameter(problem.size) * np.sign(last - first)
    correction = correct(problem, problem.pack(state[None], first), row)
    if not correction.converged:
        raise InputError(
            f"no equilibrium of {model.name} was found at {vary} = {first:g}: "
            f"{correction.failure}; start the span elsewhere"
        )
    assert correction.bordered is not None  # it converged
    if np.linalg.cond(correction.bordered.matrix) > SINGULAR:
        raise InputError(
            f"the span cannot start at {vary} = {first:g}: the equilibrium there is at a fold or "
            "branch point; start the span beside it"
        )
    broken = broken_limit(problem, correction.z)
    if broken is not None:
        raise InputError(f"the span cannot start at {vary} = {first:g}: {broken}")
    return problem, problem.point(correction, 0.0)


def orbit_start(
    orbit: PeriodicOrbit, vary: str, first: float, last: float
) -> tuple[PeriodicProblem, OrbitPoint]:
    """Return a given orbit as the first point of a branch."""
    width, segments = abs(last - first), len(orbit.nodes)
    if orbit.model.forced:
        problem = PeriodicProblem(orbit.model, vary, orbit.period, width, segments)
        guess = problem.pack(orbit.nodes, first)
    else:
        problem = CycleProblem(orbit.model, vary, orbit.period, width, segments)
        guess = problem.pack_cycle(orbit.nodes, orbit.model.values["duration"], first)
    row = np.zeros(len(guess))
    row[-1] = np.sign(last - first)
    correction = correct(problem, guess, row)
    if not correction.converged:
        raise InputError(
            f"the orbit given could not be taken up at {vary} = {first:g}: {correction.failure}; "
            "give one that is closed"
        )
    broken = broken_limit(problem, correction.z)
    if broken is not None:
        raise InputError(f"the span cannot start at {vary} = {first:g}: {broken}")
    return problem, problem.point(correction, 0.0)


def doubled_start(
    problem: PeriodicProblem, point: OrbitPoint
) -> tuple[PeriodicProblem, OrbitPoint]:
    """Return the first point of the branch of twice the period that leaves at a period doubling.

    It is the doubled orbit itself; its tangent is the critical direction, which changes sign from
    one period to the next, and the parameter does not change to first order.
    """
    m = problem.segments
    linearisation = problem.linearise(point.z)
    blocks = linearisation.blocks
    values, vectors = np.linalg.eig(linearisation.product)
    direction = vectors[:, np.argmin(np.abs(values + 1))].real
    along = [direction]
    for block in blocks[:-1]:
        along.append(block @ along[-1])
    child = problem.with_period(2 * problem.period)
    # A segment of the child is two of the parent.
    every_second = np.arange(0, 2 * m, 2) % m
    sign = np.where(np.arange(0, 2 * m, 2) < m, 1.0, -1.0)
    moved = (np.array(along)[every_second] * sign[:, None]).ravel()
    tangent = np.concatenate([moved, np.zeros(len(point.z) - problem.size)])
    # The largest component starts positive: of the two copies always the same one.
    tangent *= np.sign(direction[np.abs(direction).argmax()]) / np.linalg.norm(tangent)
    nodes = problem.nodes(point.z)[every_second]
    z = np.concatenate([problem.flat(nodes), point.z[problem.size :]])
    return child, make_point(z, tangent, 0.0, point.monodromy @ point.monodromy, point.residual)


def hopf_start(problem: EquilibriumProblem, point: OrbitPoint) -> tuple[CycleProblem, OrbitPoint]:
    """Return the first point of the branch of cycles that is born at a Hopf point.

    It is the equilibrium itself, taken for a cycle of no amplitude; its tangent is the critical
    eigenvector turning once, and neither parameter nor duration change to first order.
    """
    constants = problem.constants(point.z)
    jacobian = problem.jacobian(point.z, constants)
    values, vectors = np.linalg.eig(jacobian)
    pair = np.where(values.imag > 0, np.abs(values.real), np.inf)
    critical = int(pair.argmin())
    duration = constants.period * 2 * np.pi / float(values[critical].imag)
    model = problem.model.replace(duration=duration)
    child = CycleProblem(model, problem.vary, 1, problem.width)
    m = child.segments
    q = vectors[:, critical]
    angles = 2 * np.pi * np.arange(m) / m
    turning = np.real(q[None] * np.exp(1j * angles)[:, None])
    tangent = np.concatenate([turning.ravel(), np.zeros(2)])
    tangent /= np.linalg.norm(tangent)
    z = child.pack_cycle(np.tile(problem.nodes(point.z), (m, 1)), duration, problem.value(point.z))
    product = transition(jacobian * (duration / constants.period))
    monodromy = on_quotient(product, np.real(1j * q))
    return child, make_point(z, tangent, 0.0, monodromy, point.residual)
