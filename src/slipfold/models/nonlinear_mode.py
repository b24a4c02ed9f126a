"""Free vibration kept periodic by negative damping: nonlinear modes."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import lru_cache

import heyoka as hy

from slipfold.errors import InputError
from slipfold.models.model import Kind, Model
from slipfold.models.quantities import DURATION, Expression, Output, Parameter, Symbols
from slipfold.models.unforced import Unforced, forcing_of
from slipfold.text import listed

XI = Parameter("xi", 0.0, "1/s", "negative damping over the mass", symbol=r"$\xi$")
"""Parameter of the damping that makes free vibration periodic."""

OUTPUTS = ("frequency", "damping_ratio")
"""Outputs that a nonlinear mode adds."""


class NonlinearMode(Unforced):
    """A model without forcing, with negative damping ``xi`` in proportion to the mass.

    Its cycles are the nonlinear modes of Krack (extended periodic motions): what vibrates freely
    decays at first as if ``xi`` were added damping, so its damping ratio is ``xi`` over twice the
    angular frequency. The outputs ``frequency`` in Hz and ``damping_ratio`` have both.
    Displacements are the states whose rate is another state, their velocity.

    Parameters
    ----------
    model
        The model, forced or autonomous; its values are taken over.
    **values
        Parameter values that differ from those of `model`: numbers in SI units, or text with a
        unit.

    Raises
    ------
    InputError
        If `model` has no displacements, or no parameter that switches its forcing off, or names of
        its own for what is added.

    References
    ----------
    M. Krack, Nonlinear modal analysis of nonconservative systems, Computers and Structures 154
    (2015) 59-71.

    Examples
    --------
    >>> from slipfold.models.registry import model_named
    >>> mode = NonlinearMode(model_named("duffing"), g=0.2)
    >>> [item.name for item in mode.parameters]
    ['d', 'k', 'g', 'duration', 'xi']
    """

    def __init__(self, model: Model, **values: float | str) -> None:
        if not isinstance(model, Model):
            raise InputError(f"{model!r} is not a model; give one such as SlidingOscillator()")
        parts = model.parameters, model.states, model.outputs()
        taken = {item.name for part in parts for item in part} & {XI.name, *OUTPUTS}
        if taken:
            raise InputError(
                f"{model.name} has {listed(sorted(taken))}, a name that its nonlinear modes need; "
                "give it another name"
            )
        if not velocities_of(model.kind):
            raise InputError(
                f"{model.name} has no state whose rate is another state, as a displacement has its "
                "velocity, so it has no nonlinear modes"
            )
        amplitude = forcing_of(model) if model.forced else None
        title = "{}; nonlinear modes"
        self._remove_forcing(model, amplitude, values, "modes-of-{}", title, XI)

    @property
    def variable_parameters(self) -> tuple[Parameter, ...]:
        """Parameters of the model that remain and may be varied, and ``xi``."""
        return (*super().variable_parameters, XI)

    @property
    def tabulated(self) -> tuple[str, ...]:
        """The first displacement, frequency and damping ratio."""
        return (*self.shown[:1], *OUTPUTS)

    def check(self, values: Mapping[str, float]) -> None:
        """Refuse parameter values that the model refuses."""
        super().check({name: value for name, value in values.items() if name != XI.name})

    def coefficients(self, p: Symbols) -> dict[str, Expression]:
        """Return the coefficients of the model without forcing, and ``xi``."""
        own = {name: value for name, value in p.items() if name != XI.name}
        added = {XI.name: p[XI.name], OUTPUTS[0]: 1.0 / p[DURATION.name]}
        return {**super().coefficients(own), **added}

    def rates(self, q: Symbols, c: Symbols, phase: Expression) -> dict[str, Expression]:
        """Return the time derivatives of the states, per second."""
        rates = super().rates(q, c, phase)
        for name in dict.fromkeys(velocities_of(self._base.kind).values()):  # each once
            rates[name] = rates[name] + c[XI.name] * q[name]
        return rates

    def outputs(self) -> tuple[Output, ...]:
        """Return the outputs of the model, frequency and damping ratio."""
        return (
            *super().outputs(),
            Output(OUTPUTS[0], _frequency, "Hz", "frequency of the free vibration"),
            Output(OUTPUTS[1], _damping_ratio, "", "damping ratio of the free vibration"),
        )

    def __repr__(self) -> str:
        """Constructor call."""
        own = {name: self._values[name] for name in (DURATION.name, XI.name)}
        defaults = {DURATION.name: DURATION.default, XI.name: XI.default}
        given = [f"{name}={value:.12g}" for name, value in own.items() if value != defaults[name]]
        return f"NonlinearMode({', '.join([repr(self.forced_model), *given])})"


def _frequency(q: Symbols, c: Symbols, phase: Expression) -> Expression:
    return c[OUTPUTS[0]]


def _damping_ratio(q: Symbols, c: Symbols, phase: Expression) -> Expression:
    return c[XI.name] / (4 * math.pi * c[OUTPUTS[0]])


@lru_cache(maxsize=64)
def velocities_of(kind: Kind) -> Mapping[str, str]:
    """Return the states that are rates of others, by the names of these."""
    model = kind.make()
    p = {item.name: hy.expression(f"p_{item.name}") for item in model.parameters}
    c = {name: hy.expression(f"c_{name}") for name in model.coefficients(p)}
    q = {state.name: hy.expression(state.name) for state in model.states}
    rates = {name: str(rate) for name, rate in model.rates(q, c, hy.expression("phase")).items()}
    return {name: rate for name, rate in rates.items() if rate in q and rate != name}
