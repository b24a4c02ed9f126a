"""Forced models without their forcing: steady sliding as an equilibrium."""

from __future__ import annotations

import math
from collections.abc import Hashable, Iterable, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from inspect import signature
from typing import Annotated, Any, Self

import heyoka as hy
import numpy as np

from slipfold.arrays import Array, Complex
from slipfold.errors import InputError
from slipfold.models.equilibria import find_static_point
from slipfold.models.friction.contact import Contact
from slipfold.models.model import Kind, Model, evaluation_of
from slipfold.models.quantities import DURATION, Expression, Output, Parameter, Symbols
from slipfold.read_only import Documented
from slipfold.text import OneLine, PrintedTable, listed, number_text

_ZERO = hy.expression(0.0)
"""The phase, and the parameter that switches the forcing off."""


class Unforced(Model):
    """An autonomous model: a forced one whose forcing is zero.

    Its equilibria are the static points of the forced model, and can be followed in any parameter
    with their Hopf points and the cycles that emanate from them. Parameters of the forcing alone,
    such as its amplitude and frequency, are left out; ``duration`` takes their place.

    Parameters
    ----------
    model
        The forced model; its values are taken over.
    **values
        Parameter values that differ from those of `model`: numbers in SI units, or text with a
        unit.

    Raises
    ------
    InputError
        If `model` is autonomous already or has no parameter that switches its forcing off, for an
        unknown parameter or a value that cannot be used.

    Examples
    --------
    >>> from slipfold.models.sliding_oscillator import SlidingOscillator
    >>> model = Unforced(SlidingOscillator(mu=0.4))
    >>> model.replace(Vd=0.3)
    SlidingOscillator(mu=0.4, Vd=0.3).steady()
    >>> [item.name for item in model.parameters][-5:]
    ['Ns', 'mu', 'alpha', 'Vd', 'duration']
    """

    _base: Model
    """The forced model with default values."""
    _terms: _Terms

    def __init__(self, model: Model, **values: float | str) -> None:
        self._remove_forcing(model, _checked(model), values)

    def _remove_forcing(
        self,
        model: Model,
        amplitude: str | None,
        values: Mapping[str, float | str],
        name: str = "steady-{}",
        title: str = "{}; without forcing, autonomous",
        *more: Parameter,
    ) -> None:
        """Become a model without forcing, with more parameters."""
        terms = _terms_of(model.kind, amplitude)
        kept = {item.name for item in terms.parameters}
        taken = {name: value for name, value in model.values.items() if name in kept}
        self._take(
            _base=model.kind.make(**({amplitude: 0.0} if amplitude else {})),
            _terms=terms,
            name=name.format(model.name),
            title=title.format(model.title).removeprefix("; "),
            states=model.states,
            parameters=(*terms.parameters, *more),
            limits=model.limits,
        )
        super().__init__(**{**taken, **values})

    @property
    def structure(self) -> Mapping[str, Hashable]:
        """The forced model with default values."""
        return {"model": self._base}

    @property
    def variable_parameters(self) -> tuple[Parameter, ...]:
        """Parameters of the forced model that remain and may be varied."""
        mine = {item.name for item in super().variable_parameters}
        return tuple(item for item in self.forced_model.variable_parameters if item.name in mine)

    @property
    def forced(self) -> bool:
        """Always false: time does not appear."""
        return False

    @property
    def forced_model(self) -> Model:
        """The forced model at the present values; the forcing is zero, its parameters default."""
        names = (item.name for item in self._terms.parameters if item.name != DURATION.name)
        return self._base.replace(**{name: self._values[name] for name in names})

    def replace(self, **changes: Any) -> Self:
        """Return a new model with some parameters changed, or parts of the forced one exchanged.

        Parameters
        ----------
        **changes
            New values by name, numbers in SI units or text with a unit; or what the forced model
            exchanges, such as ``friction=Stribeck()``.
        """
        parts = set(signature(type(self._base)).parameters) & set(changes)
        exchanged = {name: changes.pop(name) for name in parts}
        if not exchanged:
            return super().replace(**changes)
        other = type(self)(self.forced_model.replace(**exchanged), duration=self.duration)
        return other.replace(**changes) if changes else other

    def check(self, values: Mapping[str, float]) -> None:
        """Refuse parameter values that the forced model refuses."""
        self._base.check({**self._base.values, **values})

    def coefficients(self, p: Symbols) -> dict[str, Expression]:
        """Return the coefficients of the forced model that do not belong to the forcing."""
        result = self._base.coefficients({**self._base.values, **p})
        return {name: result[name] for name in self._terms.coefficients}

    def rates(self, q: Symbols, c: Symbols, phase: Expression) -> dict[str, Expression]:
        """Return the time derivatives of the states, per second."""
        return self._base.rates(q, {**self._terms.others, **c}, _ZERO)

    def contacts(self, q: Symbols, c: Symbols, phase: Expression) -> tuple[Contact, ...]:
        """Return the contacts of the forced model."""
        return self._base.contacts(q, {**self._terms.others, **c}, _ZERO)

    def period(self, p: Symbols) -> Expression:
        """Return the ``duration`` in seconds."""
        return p[DURATION.name]

    def outputs(self) -> tuple[Output, ...]:
        """Return the outputs of the forced model."""
        others = self._terms.others  # coefficients that are constants at phase zero

        def unforced(of: Output) -> Output:
            return replace(of, expression=lambda q, c, _: of.expression(q, {**others, **c}, _ZERO))

        return tuple(map(unforced, self._base.outputs()))

    @property
    def shown(self) -> tuple[str, ...]:
        """What tables and figures of the forced model show by default."""
        return self._base.shown

    @property
    def start(self) -> Array:
        """Start of the forced model, shape (n_states,)."""
        return self.forced_model.start

    def declared_scales(self) -> Array:
        """Return the scales of the forced model without forcing."""
        return self.forced_model.unforced_scales()

    def static_point(self) -> Array:
        """Return the equilibrium that is reached from the model's start, shape (n_states,).

        Raises
        ------
        InputError
            If the search fails.
        """
        return find_static_point(self)

    def __repr__(self) -> str:
        """Constructor call of the forced model, and the call that removes its forcing."""
        duration = self._values[DURATION.name]
        given = "" if duration == DURATION.default else f"duration={duration:.12g}"
        return f"{self.forced_model!r}.steady({given})"


@dataclass(frozen=True, eq=False, repr=False)
class Modes(OneLine, Documented):
    """Modes of a linear system; one row a mode, the lowest natural frequency first.

    A pair of complex eigenvalues is one mode; a real eigenvalue (overdamped or divergent) is a mode
    of its own with damping ratio 1 or -1.

    Examples
    --------
    >>> from slipfold.models.sliding_oscillator import SlidingOscillator
    >>> modes = SlidingOscillator(mu=0).modes()
    >>> [round(float(value), 6) for value in modes.frequency]
    [6.59, 12.459652]
    """

    eigenvalues: Annotated[
        Complex, "In 1/s, the one of a pair with positive imaginary part, shape (n_modes,)."
    ]
    shapes: Annotated[
        Complex, "Complex displacements, the largest being 1, shape (n_modes, n_displacements)."
    ]
    names: Annotated[tuple[str, ...], "Names of the displacements."]

    def _line(self) -> str:
        state = "stable" if self.stable else "unstable"
        return f"Modes of {listed(map(number_text, self.frequency))} Hz, {state}"

    def _rows(self) -> PrintedTable:
        numbers = zip(self.frequency, self.damping_ratio, self.shapes, strict=True)
        lines = [
            [number_text(f), number_text(ratio), *(f"{part:.3f}" for part in shape)]
            for f, ratio, shape in numbers
        ]
        return PrintedTable(["f (Hz)", "damping", *self.names], lines)

    @property
    def frequency(self) -> Array:
        """Undamped natural frequencies |lambda|/(2 pi), Hz."""
        return np.abs(self.eigenvalues) / (2 * math.pi)

    @property
    def damped_frequency(self) -> Array:
        """Frequencies of the free decay, Im lambda/(2 pi), Hz."""
        return self.eigenvalues.imag / (2 * math.pi)

    @property
    def damping_ratio(self) -> Array:
        """Ratios of damping to critical damping, -Re lambda/|lambda|; negative if unstable."""
        size = np.abs(self.eigenvalues)
        return np.divide(-self.eigenvalues.real, size, out=np.zeros_like(size), where=size > 0)

    def whirl(self, first: str, second: str) -> Array:
        """Return in which direction each mode whirls in the plane of two displacements.

        Parameters
        ----------
        first, second
            Names of displacements at right angles: positive is from the first to the second.

        Returns
        -------
        Array
            Shape (n_modes,): 1 on a circle forward, -1 on one backward, 0 along a line, between
            them on an ellipse.
        """
        for name in (first, second):
            if name not in self.names:
                raise InputError(
                    f"the modes have no displacement {name!r}; they have {listed(self.names)}"
                )
        a, b = (self.shapes[:, self.names.index(name)] for name in (first, second))
        size = np.abs(a) ** 2 + np.abs(b) ** 2
        turned = 2 * (a * b.conj()).imag
        return np.divide(turned, size, out=np.zeros_like(size), where=size > 0)

    @property
    def stable(self) -> bool:
        """Whether every mode decays."""
        return bool(np.all(self.eigenvalues.real < 0))

    def __str__(self) -> str:
        """Table of the modes."""
        return "\n".join(self._rows().text())


def find_modes(jacobian: Array, names: tuple[str, ...]) -> Modes:
    """Find the modes of a first-order system of displacements and their rates.

    Shapes: jacobian (2 n, 2 n).
    """
    values, vectors = np.linalg.eig(jacobian)
    upper = np.flatnonzero(values.imag >= 0)
    upper = upper[np.argsort(np.abs(values[upper]), kind="stable")]
    shapes = vectors[: len(names), upper].T.astype(complex)
    for shape in shapes:
        shape /= shape[np.abs(shape).argmax()]
    return Modes(values[upper].astype(complex), shapes, names)


def _one_way(speed: Parameter, value: float) -> Parameter:
    """Bound a velocity by zero, on the side of a value."""
    sign, other = (">", speed.upper) if value < 0 else ("<", -speed.lower)
    turned = f"pass zero, or the model a {speed.name} {sign} 0" if other > 0 else "reach zero"
    why = ", since a contact may stick to this surface; give the contact a Regularized law to "
    if value < 0:
        return replace(speed, upper=0.0, upper_open=True, why=why + turned)
    return replace(speed, lower=0.0, lower_open=True, why=why + turned)


class MechanicalModel(Model):
    """A model of displacements ``x`` and their rates ``vx``, with its static point and modes."""

    @property
    def surface_speeds(self) -> Mapping[str, bool]:
        """Names of the speeds of moving surfaces, and whether contacts stick to them at rest."""
        return {}

    @property
    def varied_first(self) -> str | None:
        """The parameter that switches the forcing off, or the speed of a moving surface."""
        return self.forcing_amplitude or next(iter(self.surface_speeds), None)

    @property
    def variable_parameters(self) -> tuple[Parameter, ...]:
        """Parameters that may be varied; surfaces to which a contact sticks do not stop."""
        speeds = self.surface_speeds
        return tuple(
            _one_way(item, self._values[item.name]) if speeds.get(item.name) else item
            for item in super().variable_parameters
        )

    def static_point(self) -> Array:
        """Return the state at rest under steady friction without forcing, shape (n_states,).

        Raises
        ------
        InputError
            If there is none, for example if the drag exceeds what the structure can hold.
        """
        return find_static_point(self)

    def steady(self, **values: float | str) -> Unforced:
        """Return the model without what is periodic in time, as an autonomous model.

        Its equilibrium is steady sliding. It can be followed with its Hopf points and their cycles.

        Parameters
        ----------
        **values
            Parameter values that differ from those of this model. Those of the forcing are gone,
            and there is a ``duration``.

        Raises
        ------
        InputError
            If the model is autonomous.
        """
        return Unforced(self, **values)

    def modes(self) -> Modes:
        """Return the linear modes about the static point, all forces included.

        Returns
        -------
        Modes
            One per pair of eigenvalues, lowest natural frequency first; friction laws with memory
            add modes in which the contact recovers without vibration.

        Examples
        --------
        >>> from slipfold import SlidingOscillator
        >>> [f"{value:.4f}" for value in SlidingOscillator().modes().frequency]
        ['7.1383', '12.4607']
        """
        forcing = self.forcing_amplitude
        unforced = self if forcing is None else self.replace(**{forcing: 0.0})
        names = [item.name for item in self.states]
        displacements = tuple(name for name in names if f"v{name}" in names)
        return find_modes(
            evaluation_of(unforced).jacobian(unforced, self.static_point()), displacements
        )


@dataclass(frozen=True, eq=False)
class _Terms:
    """Parameters and coefficients that remain when the forcing is zero."""

    parameters: tuple[Parameter, ...]  # the parameters in them, and ``duration``
    coefficients: tuple[str, ...]  # names of the coefficients in them
    others: Symbols  # the other coefficients by name: constants, or symbols that do not matter


def _checked(model: Model) -> str:
    """Return the name of the parameter that switches the forcing off."""
    if not isinstance(model, Model):
        raise InputError(f"{model!r} is not a model; give one such as SlidingOscillator()")
    if not model.forced:
        raise InputError(
            f"{model.name} is autonomous already; its steady states are followed as they are"
        )
    return forcing_of(model)


def forcing_of(model: Model) -> str:
    """Return the name of the parameter that switches the forcing of a forced model off."""
    if model.forcing_amplitude is None:
        raise InputError(
            f"{model.name} does not say which parameter switches its forcing off, so it has no "
            "steady state; name it as amplitude in the table [forcing]"
        )
    if any(item.name == DURATION.name for item in model.parameters):
        raise InputError(
            f"{model.name} has a parameter {DURATION.name!r}, the name of the unit of time of "
            "autonomous models; give it another name"
        )
    return model.forcing_amplitude


@lru_cache(maxsize=64)
def _terms_of(kind: Kind, amplitude: str | None) -> _Terms:
    model = kind.make()
    p = {item.name: hy.expression(f"p_{item.name}") for item in model.parameters}
    result = model.coefficients({**p, **({amplitude: _ZERO} if amplitude else {})})
    constants = {
        name: value
        for name, value in result.items()
        if not isinstance(value, hy.expression) or not hy.get_variables(value)
    }
    c = {name: constants.get(name, hy.expression(f"c_{name}")) for name in result}
    q = {state.name: hy.expression(state.name) for state in model.states}
    outputs = [item.expression(q, c, _ZERO) for item in model.outputs()]
    holding = [contact.holding for contact in model.contacts(q, c, _ZERO)]
    used = _variables([*model.rates(q, c, _ZERO).values(), *outputs, *holding])
    coefficients = tuple(name for name in result if f"c_{name}" in used)
    known = _variables(result[name] for name in coefficients)
    named = (item for item in model.parameters if item.name != DURATION.name)
    parameters = tuple(item for item in named if f"p_{item.name}" in known)
    others = {name: value for name, value in c.items() if name not in coefficients}
    return _Terms((*parameters, DURATION), coefficients, others)


def _variables(expressions: Iterable[Expression]) -> set[str]:
    return {
        name
        for item in expressions
        if isinstance(item, hy.expression)
        for name in hy.get_variables(item)
    }
