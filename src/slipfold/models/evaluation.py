"""Rates, Jacobian and outputs of a model at given states, compiled from its symbols."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING, Any

import heyoka as hy
import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.models.formulas.values import as_symbol
from slipfold.models.output import Expression

if TYPE_CHECKING:
    from slipfold.models.model import Kind, Model


def compiled_function(expressions: Iterable[Expression], symbols: Sequence[Expression]) -> Any:
    """Compile functions of symbols, for one place or, shape (n, m), for many at once.

    Little is optimised: that takes longer than what it would save in most programs, only
    integrators run long enough. One place at a time, so that what is found at it does not depend
    on how many others there are.
    """
    # heyoka's own disk cache is unchecked and shared by all programs: keep out of it.
    hy.llvm_state.set_diskcache_enabled(False)
    # At level 0, and without compact mode, sums and powers are rounded in another order.
    return hy.cfunc(
        list(expressions), vars=list(symbols), compact_mode=True, opt_level=1, batch_size=1
    )


WHOLE = 24
"""Up to this many states all derivatives ride along with one motion, beyond it a few at a time.

Measured on chains of 2 to 30 masses with a cubic spring and a friction contact, their matrices
tridiagonal or full, both ways in turn. All at once takes half to nine tenths of the time at up to
16 states; at 20 to 30 both take as long; at 40 a few at a time are faster by 1.2 to 1.5, at 60 by
1.6. The equations of all at once grow with the square of the states, and their compile time with
them; a few at a time take little longer to compile at 80 states than at 10."""

COLUMNS = 4
"""Derivatives that ride along at a time: with two, the motion itself is half of the work; eight
gain nothing."""


def carried_whole(states: int) -> bool:
    """Return whether all derivatives of a motion ride along with it at once."""
    return states <= WHOLE


class Evaluation:
    """Compiled functions of states, parameters and phase; one for all models of a kind."""

    def __init__(self, model: Model) -> None:
        self._q = {state.name: hy.expression(state.name) for state in model.states}
        self._p = {item.name: hy.expression(f"p_{item.name}") for item in model.parameters}
        self._phase = hy.expression("phase")
        coefficients = model.coefficients(self._p)
        rates = model.rates(self._q, coefficients, self._phase)
        self._rate_expressions = [rates[name] for name in self._q]
        self._period_expression = model.period(self._p)
        self._output_expressions = {
            **self._q,
            **{
                item.name: item.expression(self._q, coefficients, self._phase)
                for item in model.outputs()
            },
        }
        self.names = tuple(self._output_expressions)

    def period(self, model: Model) -> float:
        """Return the forcing period in seconds."""
        state = np.zeros(len(self._q))
        return float(self._call(self._period, model, state, np.zeros(()))[0])

    def outputs(self, model: Model, states: Array, phases: Array) -> Array:
        """Evaluate all outputs, the states first.

        Shapes: states (..., n); phases (...); returns (n_outputs, ...).
        """
        return self._call(self._outputs, model, states, phases)

    def rates(self, model: Model, state: Array, phase: float = 0.0) -> Array:
        """Evaluate the time derivatives of the states, per second, shape (n,).

        Shapes: state (n,).
        """
        return self._call(self._rates, model, state, np.asarray(phase))

    def jacobian(self, model: Model, state: Array, phase: float = 0.0) -> Array:
        """Evaluate the derivative of `rates` with respect to the states, shape (n, n).

        Shapes: state (n,).
        """
        return self.linear(model, state, np.asarray(phase))[1]

    def linear(self, model: Model, states: Array, phases: Array) -> tuple[Array, Array]:
        """Evaluate the rates and their derivatives at many states, in one call.

        Shapes: states (..., n); phases (...); returns rates (..., n), jacobians (..., n, n).
        """
        n = len(self._q)
        entries, function = self._linear
        values = self._call(function, model, states, phases)
        jacobians = np.zeros((*values.shape[1:], n * n))
        jacobians[..., entries] = np.moveaxis(values[n:], 0, -1)
        rates = np.moveaxis(values[:n], 0, -1)
        return rates, jacobians.reshape(*values.shape[1:], n, n)

    def linear_of(self, model: Model) -> Callable[[Array], tuple[Array, Array]]:
        """Return `linear` of a model at phase zero."""
        return lambda states: self.linear(model, states, np.zeros(len(states)))

    # -- compiled functions, made when first needed ---------------------------------------------

    @cached_property
    def _period(self) -> Any:
        return self._compile([self._period_expression])

    @cached_property
    def _outputs(self) -> Any:
        return self._compile(list(self._output_expressions.values()))

    @cached_property
    def _rates(self) -> Any:
        return self._compile(self._rate_expressions)

    @cached_property
    def _linear(self) -> tuple[NDArray[np.intp], Any]:
        """Places of the Jacobian that are not always zero; rates and these entries, compiled."""
        rates = [as_symbol(rate) for rate in self._rate_expressions]
        states = list(self._q.values())
        slopes = hy.diff_tensors(rates, diff_args=states, diff_order=1).jacobian.ravel()
        zero = hy.expression(0.0)
        entries = np.array([i for i, slope in enumerate(slopes) if slope != zero], dtype=np.intp)
        return entries, self._compile([*rates, *slopes[entries]])

    def _compile(self, expressions: Sequence[Expression]) -> Any:
        arguments = [*self._q.values(), self._phase, *self._p.values()]
        return compiled_function(map(as_symbol, expressions), arguments)

    def _call(self, function: Any, model: Model, states: Array, phases: Array) -> Array:
        shape = np.broadcast_shapes(states.shape[:-1], phases.shape)
        n = states.shape[-1]
        rows = np.broadcast_to(states, (*shape, n)).reshape(-1, n)
        at = np.broadcast_to(phases, shape).reshape(-1)
        values = np.repeat(model.vector[:, None], len(rows), axis=1)
        result = function(np.ascontiguousarray(np.concatenate([rows.T, at[None], values])))
        return result.reshape(len(result), *shape)


def evaluation_of(model: Model) -> Evaluation:
    """Return the compiled functions of a model; models of one kind share them.

    >>> from slipfold.models import SlidingOscillator
    >>> evaluation_of(SlidingOscillator()).period(SlidingOscillator(f=10))
    0.1
    """
    return _shared_evaluation(model.kind)


@lru_cache(maxsize=64)
def _shared_evaluation(kind: Kind) -> Evaluation:
    return Evaluation(kind.make())
