"""Models: names, units and equations as symbols, and their compiled functions."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Self

import heyoka as hy
import numpy as np
from numpy.typing import ArrayLike, NDArray

from slipfold.arrays import Array
from slipfold.errors import InputError, unknown
from slipfold.models.angles import REVOLUTION
from slipfold.models.formulas.functions import compiled_function
from slipfold.models.formulas.values import as_symbol
from slipfold.models.quantities import (
    DURATION,
    CoefficientSymbols,
    Expression,
    Limit,
    Output,
    OutputName,
    Parameter,
    ParameterName,
    ParameterSymbols,
    Phase,
    State,
    StateSymbols,
)
from slipfold.models.units import parse_quantity
from slipfold.read_only import Documented

if TYPE_CHECKING:
    from slipfold.models.friction.contact import Contact
    from slipfold.models.modal_form import ModalForm


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
        """Evaluate the time derivatives of the states, per second. Shapes: state (n,) -> (n,)."""
        return self._call(self._rates, model, state, np.asarray(phase))

    def jacobian(self, model: Model, state: Array, phase: float = 0.0) -> Array:
        """Evaluate the derivative of `rates` by the states. Shapes: state (n,) -> (n, n)."""
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

    def linear_of(self, model: Model) -> Callable[[Array, Any], tuple[Array, Array]]:
        """Return `linear` of a model at phase zero, whatever the states are numbered."""
        return lambda states, _: self.linear(model, states, np.zeros(len(states)))

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
        """Positions in the Jacobian that are not always zero; rates and these entries, compiled."""
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
    """Return the compiled functions of a model; models of one kind share them."""
    return _shared_evaluation(model.kind)


@lru_cache(maxsize=64)
def _shared_evaluation(kind: Kind) -> Evaluation:
    return Evaluation(kind.make())


class Model(Documented, ABC):
    """A periodically forced mechanical system, written in symbols; immutable.

    A subclass states `name`, `states`, `parameters` and implements `coefficients`, `rates` and
    `period`; `outputs`, `limits`, `forcing_amplitude` and `declared_scales` have defaults.
    Derivatives, flows, orbits and branches follow from that alone. Where the equations depend on
    more than the class, `structure` says on what.

    Parameters
    ----------
    **values
        Parameter values that differ from the defaults: numbers in SI units, or text with a unit
        such as ``alpha="60deg"``.
    """

    name: str
    title: str = ""
    states: tuple[State, ...]
    parameters: tuple[Parameter, ...]
    limits: tuple[Limit, ...] = ()
    forcing_amplitude: str | None = None
    """Name of the parameter that switches the forcing off where it is zero."""
    notes: tuple[str, ...] = ()
    """What was done to the input to make it a model, one sentence each."""
    _values: Mapping[str, float]
    _estimated_scales: Array | None = None
    """Estimated scales of the states; models that differ in them alone are equal."""

    def __init__(self, **values: float | str) -> None:
        known = {parameter.name: parameter for parameter in self.parameters}
        checked = {name: parameter.default for name, parameter in known.items()}
        key = ""
        try:
            for key, value in values.items():
                parameter = known.get(key) or self.parameter(key)
                checked[key] = parameter.check(parse_quantity(value, parameter.unit, key))
            self._take(_values=MappingProxyType(checked))
            key = ""
            self.check(checked)
        except InputError as error:
            error.entry = ("parameters", key) if key else ("parameters",)
            raise

    # -- what a subclass gives -----------------------------------------------------------------

    @abstractmethod
    def coefficients(self, p: ParameterSymbols) -> dict[str, Expression]:
        """Combinations of parameters that the equations use.

        They are evaluated once an orbit instead of once a time step. Must work for symbols and
        for floats alike.
        """

    @abstractmethod
    def rates(self, q: StateSymbols, c: CoefficientSymbols, phase: Phase) -> dict[str, Expression]:
        """Time derivatives of the states, per second."""

    @abstractmethod
    def period(self, p: ParameterSymbols) -> Expression:
        """Return the forcing period in seconds."""

    @property
    def advice(self) -> str:
        """Why a motion may not be found, and the way out, as a clause; empty if not known.

        Jacobians near to the start and far from it show whether states can be displaced together
        without effect, or a sum of states never changes. Then no equilibrium or orbit is isolated.
        """
        scales, phases = self.state_scales(), np.linspace(0, 1, 32)
        random, sizes = np.random.default_rng(0), 10.0 ** (10 * phases - 7)  # forces may saturate
        sizes *= random.choice([-1, 1], 32)
        away = sizes[:, None] * random.uniform(0.5, 1.5, (32, len(scales)))
        jacobians = evaluation_of(self).linear(self, self.start + scales * away, phases)[1]
        known = np.isfinite(jacobians).all(axis=(1, 2))
        if not known.any():
            return ""
        jacobians = jacobians[known] * (scales / scales[:, None])
        free = self._named_null_vector(np.concatenate(jacobians), scales)
        if free:
            return (
                f"no rate depends on {free}, so that nothing determines it; leave it out, or let "
                "a restoring force or rate depend on it"
            )
        kept = self._named_null_vector(np.concatenate(jacobians.swapaxes(1, 2)), 1 / scales)
        if kept:
            return (
                f"{kept} never changes, so that no equilibrium or orbit is isolated; eliminate one "
                "of these states, and make the value of this sum a parameter"
            )
        return ""

    def _named_null_vector(self, rows: Array, units: Array) -> str:
        """Return the only combination of states to which all rows are orthogonal; empty if none.

        Slow rates count as much as fast ones. Shapes: rows (r, n); units (n,).
        """
        largest = np.abs(rows).max(axis=1, keepdims=True)
        rows = rows / np.where(largest > 0, largest, 1.0)
        _, sizes, vectors = np.linalg.svd(rows, full_matrices=False)
        if sizes[-1] > 1e-12 * sizes[0] or (len(sizes) > 1 and sizes[-2] <= 1e-12 * sizes[0]):
            return ""
        vector = np.where(np.abs(vectors[-1]) > 1e-9, vectors[-1], 0.0)
        if (np.abs(rows @ vector) > 1e-12 * (np.abs(rows) @ np.abs(vector))).any():
            return ""
        vector *= units
        weights = vector / vector[np.abs(vector).argmax()]
        terms = [
            state.name if abs(weight - 1) < 1e-9 else f"{weight:.6g}*{state.name}"
            for state, weight in zip(self.states, weights, strict=True)
            if weight != 0
        ]
        return " + ".join(terms).replace("+ -1*", "- ").replace("+ -", "- ")

    @property
    def varied_first(self) -> str | None:
        """Name of the parameter to vary first; None if none stands out."""
        return self.forcing_amplitude

    @property
    def shown(self) -> tuple[str, ...]:
        """Names of the states or outputs that tables and figures show by default."""
        return tuple(state.name for state in self.states)

    @property
    def tabulated(self) -> tuple[str, ...]:
        """Names of those of which the table of a diagram has a column by default."""
        return self.shown[:2]

    def outputs(self) -> tuple[Output, ...]:
        """Quantities of interest in addition to the states."""
        return ()

    def contacts(self, q: StateSymbols, c: CoefficientSymbols, phase: Phase) -> tuple[Contact, ...]:
        """Contacts in which trajectories may stick; none unless a model says so."""
        return ()

    def modal_form(self, c: CoefficientSymbols, phase: Phase) -> ModalForm | None:
        """Equations as modes that forces excite at a few places; None if they have no such form."""
        return None

    @property
    def resting(self) -> tuple[str, ...]:
        """Names of the contacts whose moving surfaces are at rest or swing."""
        return ()

    def declared_scales(self) -> Array:
        """Scales of the states, shape (n_states,); NaN where they are to be estimated."""
        return np.full(len(self.states), np.nan)

    def unforced_scales(self) -> Array:
        """Return `declared_scales` of the model without forcing."""
        return self.declared_scales()

    def check(self, values: Mapping[str, float]) -> None:
        """Raise `InputError` if the parameter values contradict each other.

        Parameters
        ----------
        values
            All parameter values by name.
        """

    @property
    def forced(self) -> bool:
        """Whether time appears in the equations; a model that is not forced is autonomous.

        An autonomous model has a parameter ``duration`` in seconds that its `period` returns. Of a
        cycle it is the period; elsewhere it is only a unit of time.
        """
        return True

    @property
    def start(self) -> Array:
        """State from which trajectories and searches start, shape (n_states,)."""
        return np.zeros(len(self.states))

    @cached_property
    def angle_periods(self) -> Array:
        """A revolution for each angle, zero for other states, shape (n_states,)."""
        return np.array([REVOLUTION if state.angle else 0.0 for state in self.states])

    @property
    def structure(self) -> Mapping[str, Hashable]:
        """Arguments of the constructor that the equations depend on, besides parameter values."""
        return {}

    # -- what follows --------------------------------------------------------------------------

    def state_scales(self) -> Array:
        """Scales of the states, shape (n_states,), in which residuals are measured.

        The declared scales; where there is none, those of `with_scales`; else 1.
        """
        return self._scales_in_row(0)

    def step_scales(self) -> Array:
        """Scales in which lengths of steps along curves are measured, shape (n_states,).

        The declared scales; where there is none, those of `with_scales` in its second row. States
        have them if they contribute equally, as modes of equal energy do.
        """
        return self._scales_in_row(-1)

    def _scales_in_row(self, row: int) -> Array:
        declared = self.declared_scales()
        estimated = 1.0 if self._estimated_scales is None else self._estimated_scales[row]
        return np.asarray(np.where(np.isnan(declared), estimated, declared))

    def unit_scales(self) -> Array:
        """Scales in which coefficients are given, shape (n_states,): those declared, else 1."""
        return np.nan_to_num(self.declared_scales(), nan=1.0)

    def with_scales(self, scales: Array | None) -> Self:
        """Return the same model with scales of its states, for those where it declares none.

        Parameters
        ----------
        scales
            Shape (n_states,), positive, or two rows of them, `state_scales` and `step_scales`; None
            for none.
        """
        same = object.__new__(type(self))
        known = None if scales is None else np.atleast_2d(scales)
        same.__dict__.update(self.__dict__, _estimated_scales=known)
        return same

    @property
    def estimated_scales(self) -> Array | None:
        """The scales of `with_scales` as one or two rows; None if there are none."""
        return self._estimated_scales

    @property
    def kind(self) -> Kind:
        """What all models with the same equations share."""
        return Kind(type(self), tuple(self.structure.items()))

    @property
    def values(self) -> Mapping[str, float]:
        """All parameter values by name, in SI units; read-only."""
        return self._values

    @cached_property
    def vector(self) -> Array:
        """Parameter values in the order of `parameters`, shape (n_parameters,)."""
        vector = np.array([self._values[parameter.name] for parameter in self.parameters])
        vector.setflags(write=False)
        return vector

    def parameter(self, name: ParameterName) -> Parameter:
        """Return the description of one parameter."""
        names = [parameter.name for parameter in self.parameters]
        if name in names:
            return self.parameters[names.index(name)]
        raise unknown(f"{self.name} has no parameter", name, names)

    @property
    def variable_parameters(self) -> tuple[Parameter, ...]:
        """Parameters that may be varied: not the duration of cycles, which is a result."""
        own = () if self.forced else (DURATION.name,)
        return tuple(item for item in self.parameters if item.name not in own)

    def variable_parameter(self, name: ParameterName) -> Parameter:
        """Return the description of a parameter that is to be varied."""
        self.parameter(name)  # refuses unknown names
        named = {item.name: item for item in self.variable_parameters}  # with bounds of their own
        if name in named:
            return named[name]
        names = list(named)
        others = f"vary one of {', '.join(names)}" if names else "it has nothing that may be varied"
        raise InputError(
            f"the {name} of {self.name} is a result of the computation, so it cannot be varied; "
            f"{others}"
        )

    def parameter_index(self, name: ParameterName) -> int:
        """Return the position of a parameter in `vector`."""
        return self.parameters.index(self.parameter(name))

    def replace(self, **changes: float | str) -> Self:
        """Return a new model with some parameters changed.

        Parameters
        ----------
        **changes
            New values by name, numbers in SI units or text with a unit.
        """
        arguments: dict[str, Any] = {**self.structure, **self._values, **changes}
        return type(self)(**arguments).with_scales(self._estimated_scales)

    def evaluate(self, name: OutputName, state: ArrayLike, time: ArrayLike = 0.0) -> Array | float:
        """Evaluate a state or output at given states and times.

        Parameters
        ----------
        state
            States, shape (n_states,) or (..., n_states).
        time
            Seconds since an instant of phase zero, a number or shape (...).

        Returns
        -------
        float or ndarray, shape (...)
            In the unit of the output.
        """
        functions = evaluation_of(self)
        if name not in functions.names:
            raise unknown(f"{self.name} has no output", name, functions.names)
        values = functions.outputs(self, *self._at(state, time))
        result = values[functions.names.index(name)]
        return result if result.ndim else float(result)

    def jacobian(self, state: ArrayLike, time: ArrayLike = 0.0) -> Array:
        """Evaluate the derivatives of the rates by the states.

        At an equilibrium its eigenvalues are the growth rates and angular frequencies of modes.

        Parameters
        ----------
        state
            States, shape (n_states,) or (..., n_states).
        time
            Seconds since an instant of phase zero, a number or shape (...).

        Returns
        -------
        ndarray, shape (..., n_states, n_states)
            A row for each rate, per second and in the units of the states.
        """
        return evaluation_of(self).linear(self, *self._at(state, time))[1]

    def _at(self, state: ArrayLike, time: ArrayLike) -> tuple[Array, Array]:
        """Return states and phases. Shapes: state (..., n); time (...)."""
        states = np.asarray(state, dtype=float)
        if not states.ndim or states.shape[-1] != len(self.states):
            raise InputError(
                f"the state has the shape {states.shape}; its last axis must hold the "
                f"{len(self.states)} states {', '.join(item.name for item in self.states)}"
            )
        cycles = np.asarray(time, dtype=float) / evaluation_of(self).period(self)
        return states, cycles - np.floor(cycles)

    def _take(self, **attributes: Any) -> None:
        """Set attributes while the model is made; a finished one is immutable."""
        for name, value in attributes.items():
            object.__setattr__(self, name, value)

    def __setattr__(self, name: str, value: object) -> None:
        """Refuse: a model is immutable."""
        raise AttributeError(
            f"{type(self).__name__} is immutable; model.replace({name}=...) makes a changed one"
        )

    def __getattr__(self, name: str) -> float:
        """Give parameter values as attributes, e.g. ``model.Nd``."""
        if not name.startswith("_") and name in self._values:
            return self._values[name]
        raise AttributeError(f"{type(self).__name__} has no attribute {name!r}")

    def __eq__(self, other: object) -> bool:
        """Two models are equal if they are of one kind and their parameters agree."""
        if not isinstance(other, Model):
            return NotImplemented
        return self.kind == other.kind and dict(self._values) == dict(other._values)

    def __hash__(self) -> int:
        """Hash of kind and parameter values."""
        return hash((self.kind, tuple(self._values.items())))

    def __repr__(self) -> str:
        """Constructor call with the parameters that differ from the defaults."""
        given = [f"{name}={value!r}" for name, value in self.structure.items()]
        return self._call(*given)

    def _call(self, *given: str) -> str:
        """Return a constructor call with arguments and the values that are not defaults."""
        changed = [
            f"{item.name}={self._values[item.name]:.12g}"
            for item in self.parameters
            if self._values[item.name] != item.default
        ]
        return f"{type(self).__name__}({', '.join([*given, *changed])})"

    def __reduce__(self) -> tuple[object, ...]:
        """Pickle as kind and values."""
        return _restore, (self.kind, dict(self._values), self._estimated_scales)


@dataclass(frozen=True)
class Kind:
    """What models with the same equations share: their compiled functions belong to it."""

    model: type[Model]  # the class
    # Names and values of the constructor's arguments that the equations depend on
    structure: tuple[tuple[str, Hashable], ...] = ()

    def make(self, **values: Any) -> Model:
        """Make a model of this kind."""
        arguments: dict[str, Any] = {**dict(self.structure), **values}
        return self.model(**arguments)


def _restore(kind: Kind, values: dict[str, float], scales: Array | None = None) -> Model:
    return kind.make(**values).with_scales(scales)
