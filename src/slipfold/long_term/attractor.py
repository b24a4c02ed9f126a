"""Attractors as data: an orbit, a cycle, an equilibrium, a torus or chaos."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

import heyoka as hy
import numpy as np

from slipfold.arrays import Array, Complex
from slipfold.flow.equations import build_equations
from slipfold.flow.flow import flow_of
from slipfold.flow.modes import contacts_of
from slipfold.flow.simulate import simulate
from slipfold.long_term.exponents import Exponents
from slipfold.models.model import Model, evaluation_of
from slipfold.orbits.periodic_orbit import PeriodicOrbit
from slipfold.read_only import Documented

SHOWN, PER_PERIOD = 400, 64
"""Periods of a torus or of chaos that are sampled for extremes, and samples per period."""


@dataclass(frozen=True, eq=False)
class Attractor(Documented):
    """An attractor; frozen."""

    id: Annotated[int, "Its number, from 1 in the order of detection."]
    kind: Annotated[
        str,
        '``"periodic"``, ``"torus"``, ``"chaos"``, or of an autonomous model ``"cycle"`` and '
        '``"equilibrium"``.',
    ]
    state: Annotated[Array, "A state on it, at phase zero, shape (n_states,)."]
    minimum: Annotated[
        Array, "Least and largest value of every output, the states first, shape (n_outputs,)."
    ]
    maximum: Annotated[Array, ""]
    period: Annotated[
        int | None, "Period in forcing periods; None if it does not repeat with the forcing."
    ]
    duration: Annotated[float | None, "Seconds that a cycle takes; None for others."]
    multipliers: Annotated[
        Complex,
        "Floquet multipliers, the largest first, complex, shape (n_states,); of an equilibrium its "
        "eigenvalues in 1/s; NaN for a torus or chaos.",
    ]
    exponents: Annotated[
        Array,
        "Lyapunov exponents, the largest first, shape (n_states,), per forcing period, or in 1/s "
        "of an autonomous model; NaN if it repeats.",
    ]


def preserves_volume(model: Model) -> bool:
    """Whether formulas show that volumes of states are preserved, so that nothing attracts.

    By Liouville that is where the divergence of the flow is zero. Terms that cancel only where they
    are expanded do not show it; exponents along a trajectory do, whose sum is then zero.
    """
    if contacts_of(model):  # stick contracts
        return False
    equations = build_equations(model)
    constants = flow_of(model).constants_of(model).values
    known = {
        str(name): hy.expression(value)
        for name, value in zip(equations.coefficients, constants, strict=True)
    }
    rates = hy.subs(list(equations.field), known)
    slopes = [hy.diff(rate, state) for rate, state in zip(rates, equations.states, strict=True)]
    return bool(hy.sum(slopes) == hy.expression(0.0))


def of_orbit(orbit: PeriodicOrbit, number: int) -> Attractor:
    """Return a stable orbit or cycle as an attractor."""
    extrema, forced = orbit.extrema, orbit.model.forced
    return Attractor(
        number,
        "periodic" if forced else "cycle",
        orbit.state,
        extrema.minimum[0],
        extrema.maximum[0],
        orbit.period if forced else None,
        None if forced else orbit.duration,
        orbit.multipliers,
        np.full(len(orbit.state), np.nan),
    )


def at_rest(model: Model, state: Array, number: int) -> Attractor:
    """Return a stable equilibrium as an attractor."""
    functions = evaluation_of(model)
    values = functions.outputs(model, state, np.zeros(()))
    eigenvalues = np.linalg.eigvals(functions.jacobian(model, state)).astype(complex)
    order = np.argsort(-eigenvalues.real, kind="stable")
    nothing = np.full(len(state), np.nan)
    return Attractor(
        number, "equilibrium", state, values, values, None, None, eigenvalues[order], nothing
    )


def of_exponents(result: Exponents, number: int) -> Attractor:
    """Return a torus or chaos as an attractor."""
    model, state = result.model, result.state
    trajectory = simulate(model, SHOWN, state)
    states = trajectory.sample(per_period=PER_PERIOD)[1]
    flow, phases = flow_of(trajectory.model), np.arange(len(states)) % PER_PERIOD / PER_PERIOD
    values = flow.outputs(states, phases, flow.constants_of(trajectory.model))
    unit = 1.0 if model.forced else model.values["duration"]
    return Attractor(
        number,
        result.classification.kind,
        state,
        np.nanmin(values, axis=0),
        np.nanmax(values, axis=0),
        None,
        None,
        np.full(len(state), complex(np.nan, np.nan)),
        result.estimates[-1].exponents / unit,
    )


def stroboscopic_states(orbit: PeriodicOrbit) -> Array:
    """Return the states of an orbit at the start of its forcing periods, shape (period, n)."""
    each = len(orbit.nodes)
    return orbit.sample(each * orbit.period)[1][::each]
