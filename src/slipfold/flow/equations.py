"""A model's equations as the integrators take them: phase as time, coefficients as constants."""

from __future__ import annotations

import hashlib
import pickle
from dataclasses import dataclass

import heyoka as hy

from slipfold.models.model import Model
from slipfold.models.output import Expression

__all__ = ["Equations", "build_equations"]


@dataclass(frozen=True)
class Equations:
    """Symbolic equations ``dq/dphase = T(p) f(q, phase, c(p))``.

    The coefficients ``c`` depend on parameters alone. They are evaluated once per parameter set and
    enter the flow as constants, so that one compiled flow serves every parameter: a derivative with
    respect to a parameter is one along ``dc/dp``.

    Parameters
    ----------
    names
        States, length n.
    states, parameters, coefficients
        Symbols of the states (n), parameters (n_p) and coefficients (n_c; the last one is T).
    coefficient_values
        Expressions of the coefficients in the parameters, length n_c.
    phase
        Symbol of the phase: time over the forcing period.
    rates
        ``dq/dphase`` in states, coefficients and phase, length n.
    outputs
        Name and expression of each output; the states come first.
    """

    names: tuple[str, ...]
    states: tuple[Expression, ...]
    parameters: tuple[Expression, ...]
    coefficients: tuple[Expression, ...]
    coefficient_values: tuple[Expression, ...]
    phase: Expression
    rates: tuple[Expression, ...]
    outputs: tuple[tuple[str, Expression], ...]

    @property
    def dimension(self) -> int:
        """Number of states."""
        return len(self.states)

    def fingerprint(self) -> str:
        """Text that differs whenever the equations differ; the compiled flow is cached by it."""
        parts = [
            self.names,
            self.states,
            self.parameters,
            self.coefficients,
            self.coefficient_values,
            self.phase,
            self.rates,
            self.outputs,
        ]
        # Pickled, because heyoka prints no more than the first 1000 characters of an expression.
        return hashlib.sha256(pickle.dumps(parts)).hexdigest()


def build_equations(model: Model) -> Equations:
    """Write a model's equations in symbols."""
    names = tuple(state.name for state in model.states)
    q = {name: hy.expression(name) for name in names}
    p = {item.name: hy.expression(f"p_{item.name}") for item in model.parameters}
    values = {**model.coefficients(p), "T": model.period(p)}
    c = {name: hy.expression(f"c_{name}") for name in values}
    phase = hy.expression("phase")
    rates = model.rates(q, c, phase)
    outputs = [(name, q[name]) for name in names]
    outputs += [(item.name, item.expression(q, c, phase)) for item in model.outputs()]
    return Equations(
        names=names,
        states=tuple(q.values()),
        parameters=tuple(p.values()),
        coefficients=tuple(c.values()),
        coefficient_values=tuple(_as_expression(value) for value in values.values()),
        phase=phase,
        rates=tuple(c["T"] * rates[name] for name in names),
        outputs=tuple(outputs),
    )


def _as_expression(value: Expression) -> Expression:
    return value if isinstance(value, hy.expression) else hy.expression(float(value))
