"""Integrators of a flow, compiled from its equations: of single trajectories and of batches."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any

import heyoka as hy
import numpy as np

from slipfold.flow.batches import LANES, OPTIMIZATION
from slipfold.flow.compiled_code import OwnCopies, cached
from slipfold.flow.equations import Equations, Scaled, with_variations
from slipfold.flow.sharp_turns import VERSION, SharpTurns, sharp_turns
from slipfold.models.quantities import Limit

JET_ORDER = 3

JET_TOLERANCE = 1e-10
"""Normal form coefficients need eight digits, not thirteen: a third less time."""

SHORT = 250
"""Terms of the rates up to which code is not compact: that of two to four states runs in two thirds
of the time then and is compiled in as much; what is longer takes ever longer to compile."""


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
        """Batch of the states alone, always optimized: searches for trajectories run long."""

        def build() -> Any:
            system = self._system(self._places())
            short = sum(len(rate) for _, rate in system) <= SHORT
            return self._batch(system, self._known, self._places(), level=3, compact=not short)

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
            turns = sharp_turns(self._equations, watched).scaled(self._scaled)
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

    @property
    def jet(self) -> Any:
        """Batch of the states and their Taylor jets along a direction of the start.

        The variable is ``z = x - s v``, which starts at x(0) for every s; parameters are the
        coefficients, the scales, the direction v and s = 0.
        """

        def build() -> Any:
            first, n = self._known, self._equations.dimension
            along = hy.par[first + n]
            moved = self._places()
            for i, symbol in enumerate(self._equations.states):
                moved[str(symbol)] = symbol + along * hy.par[first + i]
            variations = hy.var_ode_sys(self._system(moved), [along], order=JET_ORDER)
            return self._batch(variations, first + n + 1, moved, tolerance=JET_TOLERANCE)

        return self._own("jet", build)

    def _own(self, kind: str, build: Callable[[], Any]) -> Any:
        def stored() -> Any:
            options = f"lanes={LANES} tolerance={self._tolerance!r} jets={JET_ORDER, JET_TOLERANCE}"
            made = f"scaled {kind} {options} level={OPTIMIZATION} {VERSION}"
            # heyoka's own disk cache is one for all programs and unchecked: ours takes its place.
            hy.llvm_state.set_diskcache_enabled(False)
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
        level: int = OPTIMIZATION,
        compact: bool = True,
    ) -> Any:
        # Compact mode: compiled in a fifth of the time, and eight lanes hide most of its cost.
        return hy.taylor_adaptive_batch(
            system,
            state=np.zeros((size * self._equations.dimension, LANES)),
            pars=np.zeros((parameters, LANES)),
            tol=tolerance or self._tolerance,
            compact_mode=compact,
            opt_level=level,
            t_events=self._turns.events(places, batch=True),
            nt_events=self._turns.passed(places, batch=True),
        )
