"""Equations of motion in symbols: in scaled states, with derivatives, with perturbations."""

from __future__ import annotations

import hashlib
import pickle
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import heyoka as hy
import numpy as np

from slipfold.arrays import Array, Indices, Mask
from slipfold.models.formulas.values import as_symbol
from slipfold.models.model import Model
from slipfold.models.quantities import Expression, Symbols


@dataclass(frozen=True)
class Equations:
    """Symbolic equations ``dq/dphase = T(p) f(q, phase, c(p))``.

    The coefficients ``c`` depend on parameters alone. They are evaluated once per parameter set and
    enter the flow as constants, so that one compiled flow serves every parameter: a derivative with
    respect to a parameter is one along ``dc/dp``.
    """

    names: tuple[str, ...]  # states, length n
    # Symbols of the states (n), parameters (n_p) and coefficients (n_c; the last one is T)
    states: tuple[Expression, ...]
    parameters: tuple[Expression, ...]
    coefficients: tuple[Expression, ...]
    # Expressions of the coefficients in the parameters, length n_c
    coefficient_values: tuple[Expression, ...]
    phase: Expression  # symbol of the phase: time over the forcing period
    field: tuple[Expression, ...]  # ``f`` in states, coefficients and phase, length n
    # Name and expression of each output; the states come first
    outputs: tuple[tuple[str, Expression], ...]

    @property
    def rates(self) -> tuple[Expression, ...]:
        """``dq/dphase``, length n."""
        return tuple(self.coefficients[-1] * item for item in self.field)

    @cached_property
    def depends_on(self) -> Mask:
        """Of each rate the states that are in it, shape (n, n)."""
        result = [set(hy.get_variables([item])) for item in self.field]
        return np.array([[name in variables for name in self.names] for variables in result])

    @cached_property
    def forced(self) -> bool:
        """Whether any rate changes with the phase."""
        return f"{self.phase}" in hy.get_variables(list(self.field))

    @property
    def dimension(self) -> int:
        """Number of states."""
        return len(self.states)

    def fingerprint(self, more: Iterable[Expression] = ()) -> str:
        """Text that differs whenever these or `more` expressions do: a key of compiled code."""
        parts = [
            self.names,
            self.states,
            self.parameters,
            self.coefficients,
            self.coefficient_values,
            self.phase,
            self.rates,
            self.outputs,
            list(more),
        ]
        # Pickled, because heyoka prints no more than the first 1000 characters of an expression.
        return hashlib.sha256(pickle.dumps(parts)).hexdigest()


@dataclass(frozen=True)
class ModelSymbols:
    """The symbols in which a model's equations are written."""

    states: Symbols  # by name
    parameters: Symbols
    coefficients: Symbols
    values: Symbols  # of the coefficients, in the parameters
    phase: Expression


def model_symbols(model: Model) -> ModelSymbols:
    """Return the symbols in which a model's equations are written."""
    q = {state.name: hy.expression(state.name) for state in model.states}
    p = {item.name: hy.expression(f"p_{item.name}") for item in model.parameters}
    values = {**model.coefficients(p), "T": model.period(p)}
    c = {name: hy.expression(f"c_{name}") for name in values}
    return ModelSymbols(q, p, c, values, hy.expression("phase"))


def build_equations(model: Model, given: Symbols | None = None) -> Equations:
    """Write a model's equations in symbols; forces of contacts may be given as such."""
    symbols = model_symbols(model)
    names, p, c, phase = (
        tuple(symbols.states), symbols.parameters, symbols.coefficients, symbols.phase
    )  # fmt: skip
    q = {**symbols.states, **(given or {})}
    rates = model.rates(q, c, phase)
    outputs = [(name, q[name]) for name in names]
    outputs += [(item.name, item.expression(q, c, phase)) for item in model.outputs()]
    return Equations(
        names=names,
        states=tuple(symbols.states.values()),
        parameters=tuple(p.values()),
        coefficients=tuple(c.values()),
        coefficient_values=tuple(as_symbol(value) for value in symbols.values.values()),
        phase=phase,
        field=tuple(as_symbol(rates[name]) for name in names),
        outputs=tuple(outputs),
    )


@dataclass(frozen=True, eq=False)
class Constants:
    """What a flow needs to know of the parameters, and in which scales it is to be integrated."""

    values: Array  # coefficients, shape (n_c,); or (m, n_c), one row for each of m trajectories
    # Scales of the states, shape (n,) or (m, n). A step may make an error of the tolerance times
    # these. States go in and come out in their own units; powers of two round nothing.
    scales: Array
    differentiate: Callable[[], Array] | None = None  # gives `rates`; None where they are not known

    @cached_property
    def rates(self) -> Array:
        """Derivative of the coefficients with respect to each parameter, (n_c, n_p) or (m, ...).

        Computed where they are requested: most trajectories are integrated without derivatives.
        """
        assert self.differentiate is not None
        return self.differentiate()

    @staticmethod
    def stacked(each: Sequence[Constants]) -> Constants:
        """Return those of several trajectories as rows, without derivatives."""
        if len(each) == 1:
            return each[0]
        return Constants(np.array([c.values for c in each]), np.array([c.scales for c in each]))

    @property
    def period(self) -> float:
        """Forcing period in seconds, where all trajectories have the same."""
        return float(self.values[..., -1])

    @cached_property
    def in_a_second(self) -> Constants:
        """The same with a period of a second: branches in the frequency change nothing else."""
        return replace(self, values=np.append(self.values[:-1], 1.0))

    def rows(self, which: Indices | int) -> Constants:
        """Return the coefficients of some trajectories, by number, without derivatives."""
        if self.values.ndim == 1:
            return self
        scales = self.scales if self.scales.ndim == 1 else self.scales[which]
        return Constants(self.values[which], scales)

    def repeated(self, count: int) -> Constants:
        """Return each trajectory's coefficients several times, without derivatives."""
        if self.values.ndim == 1:
            return self
        return self.rows(np.repeat(np.arange(len(self.values)), count))

    @cached_property
    def known(self) -> Array:
        """What every integrator is given first: coefficients and scales, (n_c + n,) or (m, ...)."""
        values, scales = self.values, self.scales
        if values.ndim != scales.ndim:
            count = max(values.shape[:-1], scales.shape[:-1])
            values = np.broadcast_to(values, (*count, values.shape[-1]))
            scales = np.broadcast_to(scales, (*count, scales.shape[-1]))
        return np.concatenate([values, scales], axis=-1)


FAR = 16.0
"""Length of a direction beyond which its third power hides the first one from the tolerance."""


@dataclass(frozen=True)
class Scaled:
    """A model's equations for ``y = q / s``, the scales s being symbols: one code serves all."""

    scales: tuple[Expression, ...]  # symbols of the scales, length n
    rates: tuple[Expression, ...]  # ``dy/dphase`` in y, under the names of the states q, length n
    _states: dict[str, Expression]

    @classmethod
    def of(cls, equations: Equations) -> Scaled:
        """Write equations in scaled states."""
        scales = tuple(hy.expression(f"scale of {name}") for name in equations.names)
        states = {
            name: scale * state
            for name, scale, state in zip(equations.names, scales, equations.states, strict=True)
        }
        rates = hy.subs(list(equations.rates), states)
        scaled = (rate / scale for rate, scale in zip(rates, scales, strict=True))
        return cls(scales, tuple(scaled), states)

    def express(self, expressions: Sequence[Expression]) -> list[Expression]:
        """Write expressions of the states q in y and the scales."""
        return list(hy.subs(list(expressions), self._states))


def power_of_two(sizes: Array) -> Array:
    """Return the powers of two nearest to sizes: scaling by them rounds nothing."""
    return np.asarray(np.exp2(np.round(np.log2(sizes))))


def normalized_directions(directions: Array) -> tuple[Array, Array]:
    """Return directions over powers of two, so that no jet of theirs hides another, and these."""
    lengths = np.abs(directions).max(axis=1)
    far = (lengths > FAR) | ((lengths > 0) & (lengths < 1 / FAR))
    lengths = power_of_two(np.where(far & np.isfinite(lengths), lengths, 1.0))
    return directions / lengths[:, None], lengths


def with_variations(
    equations: Equations, columns: int, changes: Sequence[Sequence[Expression]] = ()
) -> Equations:
    r"""Add variations of a trajectory: by its start, then one along each change of coefficients.

    A variation v, and one along a change d of the coefficients, satisfy

    .. math:: v' = T \, \partial_q f \, v, \qquad
              v' = T \, (\partial_q f \, v + \partial_c f \, d) + d_T f .

    What a variation differentiates by is in its initial value alone, so that a few serve any
    number, one group after the other. The rows of their matrix follow the states.
    """
    states, coefficients, zero = equations.states, equations.coefficients, hy.expression(0.0)
    slopes = hy.diff_tensors(
        list(equations.field), diff_args=[*states, *coefficients], diff_order=1
    ).jacobian.tolist()
    along = [
        [*(hy.expression(f"{column} of {len(states)}: {state}") for state in states), *change]
        for column, change in enumerate([*([()] * columns), *changes])
    ]
    symbols, field = list(states), list(equations.field)
    for index, (rate, row) in enumerate(zip(equations.field, slopes, strict=True)):
        for column in along:
            terms = [a * b for a, b in zip(row, column, strict=False) if a != zero]
            if len(column) > len(states):
                terms.append(column[-1] * rate / coefficients[-1])
            field.append(hy.sum(terms) if terms else zero)
            symbols.append(column[index])
    names = tuple(str(symbol) for symbol in symbols)
    return replace(equations, names=names, states=tuple(symbols), field=tuple(field))
