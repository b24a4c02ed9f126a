"""Compiled flows of a model: states, their derivatives and their Taylor jets, in SIMD batches."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import cache, cached_property
from typing import Any

import heyoka as hy
import numpy as np

from slipfold.arrays import Array
from slipfold.errors import index_of
from slipfold.flow.batches import (
    LANES,
    STEP_LIMIT,
    TOLERANCE,
    arrive,
    chunks,
    forget,
    joined,
    pass_through,
    propagated,
    sampled,
    set_out,
)
from slipfold.flow.compiled_code import CURVE_POWERS, Evaluated, OwnCopies, cached, shared_by_kind
from slipfold.flow.equations import (
    Constants,
    Equations,
    Scaled,
    build_equations,
    normalized_directions,
    power_of_two,
    with_variations,
)
from slipfold.flow.implicit_steps import StiffFallback
from slipfold.flow.polynomials import DenseTrajectory
from slipfold.flow.sharp_turns import VERSION, SharpTurns, sharp_turns
from slipfold.models.formulas.functions import OPTIMIZATION
from slipfold.models.model import Model
from slipfold.models.quantities import Limit


class VARIATIONS:
    """How the derivatives of trajectories are compiled and integrated."""

    # Maximum number of states whose variational equations are integrated all at once. On chains of
    # masses this takes 0.5 to 0.9 of the time of a few columns at a time with up to 16 states, as
    # long with 20 to 30, and 1.6 times as long with 60
    together: int = 24
    # Columns that are integrated at a time beyond it: with two, the trajectory itself is half of
    # the work; eight gain nothing
    columns: int = 4
    jet_order: int = 3  # that of the normal forms of bifurcations of codimension one
    # Normal form coefficients need eight digits, not thirteen: a third less time
    jet_tolerance: float = 1e3 * TOLERANCE
    # Terms of the rates up to which code is not compact: it runs in two thirds of the time, but
    # more take ever longer to compile
    short_rates: int = 250


class Integrators:
    """The integrators of a flow, compiled on first use and kept on disk, a copy for each thread.

    They work in scaled states, see `Scaled`: their parameters begin with the coefficients and the
    scales. `tolerance` is the local error that a step may make.
    """

    def __init__(self, equations: Equations, tolerance: float) -> None:
        self._equations = equations
        self._tolerance = tolerance
        self._count = len(equations.coefficients)
        self._known = self._count + equations.dimension
        self._integrators = OwnCopies()

    @cached_property
    def _scaled(self) -> Scaled:
        return Scaled.of(self._equations)

    @property
    def plain(self) -> Any:
        """Batch of the states alone."""

        def build() -> Any:
            system = self._system(self._places())
            short = sum(len(rate) for _, rate in system) <= VARIATIONS.short_rates
            return self._batch(system, self._known, self._places(), compact=not short)

        return self._own("states", build)

    def single(self, limits: Sequence[Limit] = ()) -> Any:
        """One trajectory of the states alone, which ends where a limit is met.

        Parameters are the coefficients, the scales, and one over the scale of each limit's output.
        """

        def build() -> Any:
            known, outputs = self._places(), dict(self._equations.outputs)
            watched = [outputs[limit.output] for limit in limits]
            margins = [
                hy.par[self._known + i] * (output - limit.bound)
                for i, (output, limit) in enumerate(zip(watched, limits, strict=True))
            ]
            ends = [
                hy.t_event(item, direction=hy.event_direction.negative)
                for item in hy.subs(self._scaled.express(margins), known)
            ]
            turns = sharp_turns(self._equations, tuple(watched)).scaled(self._scaled)
            return hy.taylor_adaptive(
                self._system(self._places()),
                state=[0.0] * self._equations.dimension,
                pars=[0.0] * (self._known + len(limits)),
                tol=self._tolerance,
                opt_level=OPTIMIZATION,
                t_events=[*ends, *turns.events(known, batch=False)],
                nt_events=turns.passed(known, batch=False),
            )

        bounds = [(limit.output, limit.bound) for limit in limits]
        return self._own(f"single, weighted limits={bounds!r}", build)

    def variations(self, columns: int, directions: int = 0, *, tangent: bool = False) -> Any:
        """Batch of the states and variations of them: see `with_variations`.

        Parameters are the coefficients c, the scales, and the changes of c, one after the other.
        With a tangent, one perturbation of the states is propagated as well, and there are
        variations of both: second derivatives with the perturbation as one direction.
        """

        def build() -> Any:
            base = with_variations(self._equations, 1) if tangent else self._equations
            changes = [
                [hy.expression(f"change {k} of {symbol}") for symbol in base.coefficients]
                for k in range(directions)
            ]
            whole = with_variations(base, columns, changes)
            scaled, known = Scaled.of(whole), self._places()
            rows = np.arange(base.dimension) % self._equations.dimension
            places = self._count + np.concatenate([rows, np.repeat(rows, columns + directions)])
            symbols = [symbol for change in changes for symbol in change]
            known |= {str(s): hy.par[i] for s, i in zip(scaled.scales, places, strict=True)}
            known |= {str(symbol): hy.par[self._known + i] for i, symbol in enumerate(symbols)}
            rates = hy.subs(list(scaled.rates), known)
            system = list(zip(whole.states, rates, strict=True))
            size = len(places) // self._equations.dimension
            return self._batch(system, self._known + len(symbols), known, size=size)

        return self._own(f"{columns} variations, {directions} along, tangent={tangent}", build)

    def _places(self) -> dict[str, Any]:
        """Parameters of an integrator that stand for coefficients, scales and the phase."""
        known = [*self._equations.coefficients, *self._scaled.scales]
        places: dict[str, Any] = {str(symbol): hy.par[i] for i, symbol in enumerate(known)}
        return {**places, str(self._equations.phase): hy.time}

    def jet(self, powers: int, order: int) -> Any:
        """Batch of the states and their Taylor jets along a curve of starts.

        The variable is ``z = x - s v_1 - s^2 v_2 - ...``, which starts at x(0) for every s;
        parameters are the coefficients, the scales, the vectors v_i and s = 0.
        """

        def build() -> Any:
            first, n = self._known, self._equations.dimension
            s = hy.par[first + powers * n]
            moved = self._places()
            for i, symbol in enumerate(self._equations.states):
                terms = [s ** float(k + 1) * hy.par[first + k * n + i] for k in range(powers)]
                moved[str(symbol)] = symbol + hy.sum(terms)
            variations = hy.var_ode_sys(self._system(moved), [s], order=order)
            return self._batch(
                variations, first + powers * n + 1, moved, tolerance=VARIATIONS.jet_tolerance
            )

        return self._own(f"jet of order {order} along {powers}", build)

    def _own(self, kind: str, build: Callable[[], Any]) -> Any:
        def stored() -> Any:
            options = f"lanes={LANES} tolerance={self._tolerance!r} jets={VARIATIONS.jet_tolerance}"
            made = f"scaled {kind} {options} {VERSION}"
            return cached(f"{made}\n{self._equations.fingerprint()}", build)

        return self._integrators.get(kind, stored)

    def _system(self, moved: dict[str, Any]) -> list[tuple[Any, Any]]:
        rates = hy.subs(list(self._scaled.rates), moved)
        return list(zip(self._equations.states, rates, strict=True))

    @cached_property
    def _turns(self) -> SharpTurns:
        return sharp_turns(self._equations).scaled(self._scaled)

    def _batch(
        self,
        system: Any,
        parameters: int,
        places: dict[str, Any],
        *,
        tolerance: float | None = None,
        size: int = 1,
        compact: bool = True,
    ) -> Any:
        # Compact mode: compiled in a fifth of the time, and eight lanes hide most of its cost.
        return hy.taylor_adaptive_batch(
            system,
            state=np.zeros((size * self._equations.dimension, LANES)),
            pars=np.zeros((parameters, LANES)),
            tol=tolerance or self._tolerance,
            compact_mode=compact,
            opt_level=OPTIMIZATION,
            t_events=self._turns.events(places, batch=True),
            nt_events=self._turns.passed(places, batch=True),
        )


class Flow(Evaluated):
    """The flow of a model over phase (time in forcing periods).

    Trajectories that meet a singularity come back as NaN.

    `tolerance` is the local error that a step may make.
    """

    def __init__(self, equations: Equations, tolerance: float = TOLERANCE) -> None:
        super().__init__(equations)
        self._code = Integrators(equations, tolerance)
        self.tolerance = tolerance
        self.output_names = tuple(name for name, _ in equations.outputs)

    def output_index(self, name: str) -> int:
        """Return the column of an output."""
        return index_of(name, self.output_names, "output")

    def margins(
        self, limits: Sequence[Limit], states: Array, phases: Array, constants: Constants
    ) -> Array:
        """Return how far outputs are above the bounds of limits, shape (m, n_limits).

        Shapes: states (m, n); phases (m,).
        """
        watched = [self.output_index(limit.output) for limit in limits]
        bounds = np.array([limit.bound for limit in limits])
        return np.asarray(self.outputs(states, phases, constants)[:, watched] - bounds)

    def constants_of(self, model: Model) -> Constants:
        """Evaluate the coefficients of a model, to be integrated in its scales."""
        return self.constants(model.vector, power_of_two(model.state_scales()))

    def constants(self, parameters: Array, scales: Array | None = None) -> Constants:
        """Evaluate the coefficients.

        Shapes: parameters (n_p,); scales (n,) or (m, n).
        """
        return Constants(
            self.coefficients(parameters),
            np.ones(self.dimension) if scales is None else scales,
            lambda: self.coefficient_slopes(parameters),
        )

    # -- trajectories --------------------------------------------------------------------------

    def advance(self, states: Array, start: Array, end: Array, constants: Constants) -> Array:
        """Propagate states from one phase to another.

        Shapes: states (m, n); start, end (m,); returns (m, n).
        """
        code, scaled = self._code.plain, states / constants.scales
        batches = [
            propagated(self._prepare(code, scaled, start, constants, rows), end[rows])
            for rows in chunks(len(states))
        ]
        return joined(batches, len(states)) * constants.scales

    def sample(
        self, states: Array, start: Array, end: Array, count: int, constants: Constants
    ) -> Array:
        """Propagate states from one phase to another and keep equidistant samples.

        Shapes: states (m, n); start, end (m,); returns (m, count, n).
        """
        fractions = np.arange(count) / count
        phases = start[:, None] + (end - start)[:, None] * fractions
        samples = self.along(states, phases, constants)
        lost = ~np.isfinite(samples).all(axis=(1, 2)) & np.isfinite(states).all(axis=1)
        for row in np.flatnonzero(lost):  # too many steps for a batch
            own = constants.rows(int(row))
            samples[row] = self.trajectory(states[row], own, phases[row])
        return samples

    def along(self, states: Array, phases: Array, constants: Constants) -> Array:
        """Propagate states along phases of their own.

        Shapes: states (m, n); phases (m, p); returns (m, p, n).
        """
        result = np.empty((*phases.shape, self.dimension))
        code, scaled, start = self._code.plain, states / constants.scales, phases[:, 0]
        for rows in chunks(len(states)):
            batch = self._prepare(code, scaled, start, constants, rows)
            result[rows] = sampled(batch, phases[rows].T.copy()).transpose(2, 0, 1)
        return result * constants.scales[..., None, :]

    def linearize(
        self, states: Array, start: Array, end: Array, constants: Constants, directions: Array
    ) -> tuple[Array, Array, Array]:
        """Propagate states and their derivatives from one phase to another.

        Or through phases of their own, (m, p), the first of which is the start.

        Shapes: states (m, n); start, end (m,); directions (n_c, k), or (m, n_c, k); returns ends
        (m, n), matrices (m, n, n), vectors (m, n, k), or (m, p, ...) each.
        """
        n = self.dimension
        ends, derivatives = self._vary(states, start, end, constants, directions)
        return ends, derivatives[..., :n], derivatives[..., n:]

    def _vary(
        self, states: Array, start: Array, end: Array, constants: Constants, directions: Array
    ) -> tuple[Array, Array]:
        """Propagate states, or states and a perturbation of them, with the derivatives of both.

        Shapes: states (m, N); returns ends (m, N), derivatives (m, N, n + k).
        """
        (m, size), n, (count, k) = states.shape, self.dimension, directions.shape[-2:]
        scales = constants.scales
        if size > n:
            scales = np.concatenate([scales, scales], axis=-1)
        changes = directions.swapaxes(-1, -2)
        # Columns by the start, columns along changes, and in how many groups they are integrated.
        few, groups = VARIATIONS.columns, [(n, k, 1)]
        if n > VARIATIONS.together:
            groups = [(few, 0, -(-n // few)), (0, 1, k)]
        ends, parts = states, list[Array]()
        for columns, along, repeats in groups:
            started = _started(size, n if columns else 0, columns + along, repeats)
            state = np.empty((m, repeats, size + started.shape[-1]))
            state[..., :size] = (states / scales)[:, None]
            state[..., size:] = started
            pars = np.empty((m, repeats, count + n + (k * count // repeats if along else 0)))
            pars[..., : count + n] = constants.known[..., None, :]
            if along:
                pars[..., count + n :] = changes.reshape(*changes.shape[:-2], repeats, -1)
            finished = self._propagated(
                self._code.variations(columns, along, tangent=size > n),
                state.reshape(m * repeats, -1),
                start if repeats == 1 else np.repeat(start, repeats),
                end if repeats == 1 else np.repeat(end, repeats, axis=0),
                pars.reshape(m * repeats, -1),
            )
            if columns:
                ends = finished[::repeats, ..., :size] * scales
            part = finished[..., size:].reshape(m, repeats, *end.shape[1:], size, columns + along)
            part = part if repeats == 1 else np.moveaxis(part, 1, -2)
            parts.append(part.reshape(*end.shape, size, -1))
        if len(parts) > 1:
            parts[0] = parts[0][..., :n]
        whole = np.concatenate(parts, axis=-1) * scales[..., None]
        whole[..., :n] /= constants.scales[..., None, :]
        return ends, whole

    def _propagated(self, code: Any, state: Array, start: Array, end: Array, pars: Array) -> Array:
        """Propagate complete states of compiled code."""
        finished = []
        for rows in chunks(len(state)):
            set_out(code, start[rows])
            code.state[:] = state[rows].T
            code.pars[:] = pars[rows].T
            if end.ndim == 1:
                finished.append(propagated(code, end[rows]))
            else:
                finished.append(sampled(code, end[rows].T.copy()).transpose(2, 0, 1))
        return joined(finished, len(state)) if finished else state

    def curve(
        self,
        states: Array,
        start: Array,
        end: Array,
        constants: Constants,
        directions: Array,
        vectors: Array,
    ) -> tuple[Array, Array]:
        """Return second derivatives of the flow with a given vector as one of their directions.

        Shapes: states (m, n); start, end (m,); directions (n_c, k) or (m, n_c, k); vectors (m, n);
        returns matrices (m, n, n), by_parameters (m, n, k).
        """
        n = self.dimension
        both = np.concatenate([states, vectors], axis=1)
        second = self._vary(both, start, end, constants, directions)[1][:, n:]
        return second[:, :, :n], second[:, :, n:]

    def jet(
        self,
        states: Array,
        start: Array | float,
        end: Array | float,
        constants: Constants,
        directions: Array,
        beyond: Array | None = None,
    ) -> Array:
        """Differentiate the flow three times along a direction of the start state.

        Shapes: states (m, n), or (n,); start, end (m,); directions (m, n); beyond (k, n) or
        (m, k, n); returns (m, 3, n).
        """
        curves = directions[:, None]
        result = self._jets(states, start, end, constants, curves, beyond, 1, VARIATIONS.jet_order)
        return np.ascontiguousarray(result[:, 1:, 0])

    def jet_along_curve(
        self, nodes: Array, start: float, end: float, constants: Constants, curve: Array
    ) -> Array:
        """Differentiate the flow along the curve x + s v_1 + s^2 v_2 + ... of its start state.

        Shapes: nodes (k, n); curve (p, n), the v_i up to the fourth; returns (5, n).
        """
        curves = np.zeros((1, CURVE_POWERS, self.dimension))
        curves[0, : len(curve)] = curve
        given = nodes[0], start, end, constants, curves, nodes[1:], 1, CURVE_POWERS + 1
        return self._jets(*given)[0, 1:, 0]

    def jet_in_time(
        self, nodes: Array, start: float, end: float, constants: Constants, directions: Array
    ) -> Array:
        """Differentiate the flow along directions of the start state and in the end's phase.

        Shapes: nodes (k, n); directions (m, n); returns (m, 4, 4, n).
        """
        given = nodes[0], start, end, constants, directions[:, None], nodes[1:]
        return self._jets(*given, VARIATIONS.jet_order + 1, VARIATIONS.jet_order)

    def _jets(
        self,
        states: Array,
        start: Array | float,
        end: Array | float,
        constants: Constants,
        curves: Array,
        beyond: Array | None,
        in_time: int,
        order: int,
    ) -> Array:
        """Differentiate along curves of starts, and in time as often as is requested.

        Shapes: curves (m, p, n); returns (m, order + 1, in_time, n).
        """
        (total, powers, n), orders = curves.shape, order + 1
        result = np.empty((total, orders, in_time, n))
        starts = np.broadcast_to(states / constants.scales, (total, n))
        first, last = np.broadcast_to(start, total), np.broadcast_to(end, total)
        lengths = normalized_directions(curves[:, 0] / constants.scales)[1]
        scaled = curves / constants.scales[..., None, :]
        scaled /= lengths[:, None, None] ** np.arange(1, powers + 1)[:, None]
        nodes = np.empty((0, total, n))
        if beyond is not None:
            shape = total, *beyond.shape[-2:]
            nodes = np.broadcast_to(beyond / constants.scales[..., None, :], shape).swapaxes(0, 1)
        for rows in chunks(total):
            batch = self._prepare(self._code.jet(powers, order), starts, first, constants, rows)
            batch.pars[-powers * n - 1 : -1] = scaled[rows].reshape(-1, powers * n).T
            batch.pars[-1] = 0.0
            batch.state[n:] = 0.0
            for number, state in enumerate(nodes, 1):
                fraction = number / (len(nodes) + 1)
                if not arrive(batch, (first + fraction * (last - first))[rows]).all():
                    batch.state[:] = np.nan
                batch.state[:n] = state[rows].T
            ends = propagated(batch, last[rows])
            if in_time > 1:  # for the Taylor coefficients in time
                batch.step(np.full(LANES, 1e-300), write_tc=True)
            for k in range(in_time):
                slopes = ends
                if k:
                    taylor = batch.tc[:, k].T * math.factorial(k)
                    slopes = np.where(np.isfinite(ends), taylor, np.nan)
                result[rows, :, k] = slopes.reshape(-1, orders, n)
        result *= lengths[:, None, None, None] ** np.arange(orders)[:, None, None]
        result *= constants.scales[..., None, None, :]
        for k in range(powers):  # the jet is that of the flow less the curve of starts
            result[:, k + 1, 0] += math.factorial(k + 1) * curves[:, k]
        return result

    def trajectory(
        self, state: Array, constants: Constants, grid: Array, *, patient: bool = True
    ) -> Array:
        """Propagate one state along a grid of phases, one step after the other.

        Shapes: state (n,); grid (m,); returns (m, n).
        """
        single = self._set_out(state, constants, grid[0])
        fallback = StiffFallback(self, constants)
        return pass_through(single, grid, fallback, patient=patient) * constants.scales

    def is_stiff(self, state: Array, constants: Constants) -> bool:
        """Whether a trajectory over the first period had better continue in implicit steps.

        Shapes: state (n,).
        """
        single = self._set_out(state, constants, 0.0)
        outcome = int(single.propagate_until(1.0, max_steps=8_000)[0])  # enough if not stiff
        return outcome == STEP_LIMIT and StiffFallback(self, constants).is_due(single)

    def dense(
        self, state: Array, constants: Constants, end: float, steps: int, stiff: float | None = None
    ) -> DenseTrajectory | None:
        """Propagate a state of an autonomous model over some steps, and keep all that lies between.

        Implicit steps end at `stiff` if it is given. None where not even one step can be taken.

        Shapes: state (n,).
        """
        single = self._set_out(state, constants, 0.0)
        outcome, *_, output = single.propagate_until(end, max_steps=steps, c_output=True)[:5]
        fallback = StiffFallback(self, constants)
        if int(outcome) == STEP_LIMIT and fallback.is_due(single):
            single.time, single.state[:] = 0.0, state / constants.scales
            implicit = fallback.motion(single, stiff or end, most=steps).polynomials
            if implicit is None:
                return None
            return DenseTrajectory(implicit.times, implicit, constants.scales, implicit=True)
        return output and DenseTrajectory(np.array(output.times), output, constants.scales)

    def integrator(self, limits: Sequence[Limit]) -> Any:
        """Return this thread's integrator of one trajectory, which ends where a limit is met."""
        return self._code.single(limits)

    def _set_out(self, state: Array, constants: Constants, phase: float) -> Any:
        """Return the integrator of one trajectory at its beginning."""
        single = self._code.single()
        single.time = phase
        forget(single)
        single.state[:] = state / constants.scales
        single.pars[:] = constants.known
        return single

    def _prepare(
        self, batch: Any, states: Array, start: Array, constants: Constants, rows: Any
    ) -> Any:
        """Give an integrator the beginnings of some trajectories, in scaled states."""
        set_out(batch, start[rows])
        batch.state[: self.dimension] = states[rows].T
        known = constants.known
        batch.pars[: known.shape[-1]] = known[:, None] if known.ndim == 1 else known[rows].T
        return batch


@shared_by_kind
def flow_of(model: Model) -> Flow:
    """Return the flow of a model; models with the same equations share one.

    >>> from slipfold.models.sliding_oscillator import SlidingOscillator
    >>> flow_of(SlidingOscillator()).dimension
    4
    """
    return Flow(build_equations(model))


@cache
def _started(size: int, n: int, columns: int, repeats: int) -> Array:
    """Return the derivatives at the start, a row for each group of columns."""
    rows = np.zeros((repeats, size, columns))
    for column in range(n):
        rows[column // columns, column, column % columns] = 1.0
    return rows.reshape(repeats, -1)
