"""Compiled code, kept on disk, and functions compiled from equations."""

from __future__ import annotations

import copy
import hashlib
import math
import os
import pickle
import platform
import stat
import tempfile
import threading
from collections.abc import Callable, Iterable, Sequence
from functools import cache as memoise
from functools import cached_property, lru_cache
from inspect import get_annotations
from pathlib import Path
from typing import Any, TypeVar

import heyoka as hy
import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array, Indices
from slipfold.flow.equations import Constants, Equations
from slipfold.models.formulas.functions import OPTIMIZATION, compiled_function
from slipfold.models.model import Kind, Model
from slipfold.models.quantities import Expression


class OwnCopies:
    """Integrators by name, one of each a thread.

    They release Python's lock while they run, so threads run at the same time; a copy takes a
    millisecond. The originals are never run: what runs cannot be copied.
    """

    def __init__(self) -> None:
        self._originals: dict[str, Any] = {}
        self._building = threading.Lock()
        self._own = threading.local()

    def get(self, name: str, build: Callable[[], Any]) -> Any:
        """Return this thread's copy."""
        own = self._own.__dict__
        if name not in own:
            with self._building:
                if name not in self._originals:
                    self._originals[name] = build()
            own[name] = copy.copy(self._originals[name])
        return own[name]


T = TypeVar("T")


def shared_by_kind(make: Callable[[Model], T]) -> Callable[[Model], T]:
    """Return a function that makes one object for all models with the same equations.

    Threads that ask at the same time get the same one, compiled once.
    """
    building = threading.RLock()

    @lru_cache(maxsize=64)
    def of_kind(kind: Kind) -> T:
        return make(kind.make())

    def of_model(model: Model) -> T:
        with building:
            return of_kind(model.kind)

    return of_model


_MAGIC = b"slipfold-flow-1\n"
_DIGEST_SIZE = hashlib.sha256().digest_size


def cache_directory() -> Path:
    """Return where compiled flows are kept.

    ``$SLIPFOLD_CACHE_DIR`` if set, else ``$XDG_CACHE_HOME/slipfold`` or ``~/.cache/slipfold``.
    """
    chosen = os.environ.get("SLIPFOLD_CACHE_DIR")
    if chosen:
        return Path(chosen)
    base = os.environ.get("XDG_CACHE_HOME")
    return (Path(base) if base else Path.home() / ".cache") / "slipfold"


def cached(key: str, build: Callable[[], Any]) -> Any:
    """Return what `build` makes, from disk if it was made before on this machine.

    An entry is a pickle, so it is opened only if the directory and the file belong to this user
    and nobody else may write to them, and if its digest fits its content and its key. Anything
    else is rebuilt and overwritten. Where the directory cannot be made safe, nothing is stored.
    """
    # heyoka's own disk cache is one for all programs and unchecked: this one takes its place.
    hy.llvm_state.set_diskcache_enabled(False)
    digest = hashlib.sha256(f"{key}\n{_machine()}".encode()).hexdigest()
    directory = _safe_directory()
    if directory is None:
        return build()
    path = directory / f"{digest}.flow"
    result = _read(path, digest)
    if result is not None:
        return result
    made = build()
    _write(path, digest, made)
    return made


def numbers_of(rules: type) -> str:
    """Return constants as a text, for the keys of what is compiled with them."""
    return str({name: getattr(rules, name) for name in get_annotations(rules)})


@memoise
def _machine() -> str:
    """What compiled code depends on: heyoka, Python, the processor, and how it is optimized."""
    versions = hy.__version__, platform.python_version(), platform.platform()
    return "\n".join([*versions, _processor(), f"level {OPTIMIZATION}"])


def _processor() -> str:
    """Return the model and instruction sets of the processor."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:  # not Linux
        return f"{platform.machine()} {platform.processor()}"
    return "\n".join(sorted({line for line in lines if line.startswith(("model name", "flags"))}))


def _safe_directory() -> Path | None:
    try:
        directory = cache_directory()
        directory.mkdir(mode=0o700, parents=True, exist_ok=True)
        status = directory.lstat()
    except (OSError, RuntimeError):  # RuntimeError: the user has no home directory
        return None
    if not stat.S_ISDIR(status.st_mode) or not _is_private(status):
        return None
    return directory


def _is_private(status: os.stat_result) -> bool:
    if not hasattr(os, "getuid"):  # Windows keeps the profile directory private itself
        return True
    return status.st_uid == os.getuid() and not status.st_mode & 0o022


def _read(path: Path, digest: str) -> Any:
    try:
        descriptor = os.open(path, os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0))
        with open(descriptor, "rb") as file:
            status = os.fstat(file.fileno())
            if not stat.S_ISREG(status.st_mode) or not _is_private(status):
                return None
            content = file.read()
    except OSError:
        return None
    header = _MAGIC + digest.encode()
    payload = content[len(header) + _DIGEST_SIZE :]
    seal = content[len(header) : len(header) + _DIGEST_SIZE]
    if not content.startswith(header) or hashlib.sha256(header + payload).digest() != seal:
        return None
    try:
        return pickle.loads(payload)
    except Exception:  # a stale pickle may fail in any way; it is rebuilt
        return None


def _write(path: Path, digest: str, made: Any) -> None:
    header = _MAGIC + digest.encode()
    payload = pickle.dumps(made, protocol=pickle.HIGHEST_PROTOCOL)
    content = header + hashlib.sha256(header + payload).digest() + payload
    temporary = None
    try:
        descriptor, temporary = tempfile.mkstemp(dir=path.parent, prefix=".flow-")
        with open(descriptor, "wb") as file:
            file.write(content)
        os.replace(temporary, path)
    except OSError:  # a full or read-only disk costs time, never a result
        if temporary is not None:
            Path(temporary).unlink(missing_ok=True)


def _directions(letter: str, symbols: Iterable[Any]) -> list[Any]:
    return [hy.expression(f"{letter}_{symbol}") for symbol in symbols]


def _slopes(forms: Sequence[Any], symbols: Sequence[Any], direction: Sequence[Any]) -> list[Any]:
    """Derivatives of expressions along a direction."""
    none = hy.expression(0.0)
    return [
        hy.sum([s * d for s, d in zip(row, direction, strict=True) if s != none])
        for row in _derivatives(forms, symbols)
    ]


CURVE_POWERS = 4
"""Powers of curves of states along which flow and rates are differentiated: coefficients of normal
forms are of order 5 at most."""

MANY = 8
"""Symbols from which derivatives are taken all at once, in a fifth of the time. Of few each is
simplified by itself, and rounded less."""


def _derivatives(forms: Sequence[Any], symbols: Sequence[Any]) -> NDArray[Any]:
    """Derivatives of expressions, a row each."""
    if len(symbols) < MANY:
        result = [hy.diff(form, symbol) for form in forms for symbol in symbols]
        return np.array(result, dtype=object).reshape(len(forms), len(symbols))
    return np.asarray(hy.diff_tensors(list(forms), diff_args=list(symbols), diff_order=1).jacobian)


class StateFunction:
    """Functions of state, phase and coefficients, compiled and kept on disk.

    The states may be followed by further symbols. Arguments of single states stand in one array
    for each thread, of which most calls change few.
    """

    def __init__(
        self,
        key: str,
        expressions: Sequence[Any],
        equations: Equations,
        more: Sequence[Any] = (),
        derived: Callable[[], Iterable[Any]] | None = None,  # what is compiled in their place
    ) -> None:
        inputs = [*equations.states, *more, equations.phase, *equations.coefficients]
        # Compiled when it is first evaluated: a third of them never is.
        self._function = memoise(
            lambda: cached(
                f"{key}\n{equations.fingerprint(expressions)}",
                lambda: compiled_function(derived() if derived else expressions, inputs),
            )
        )
        self._own = threading.local()

    def at(self, state: Array, phase: float, constants: Constants) -> Array:
        """Evaluate at a state. Shapes: state (n,); returns (q,)."""
        own = self._own.__dict__
        if own.get("constants") is not constants:
            own["constants"] = constants
            own["inputs"] = np.concatenate([state, (phase,), constants.values])
        inputs, count = own["inputs"], len(state)
        inputs[:count] = state
        inputs[count] = phase
        return np.asarray(self._function()(inputs))

    def along(self, states: Array, phases: Array, constants: Constants) -> Array:
        """Evaluate at many states. Shapes: states (p, n); phases (p,); returns (p, q)."""
        known = np.repeat(constants.values[:, None], len(states), axis=1)
        # Without coefficients the array would not be contiguous.
        inputs = np.ascontiguousarray(np.concatenate([states.T, phases[None], known]))
        return np.asarray(self._function()(inputs).T)


class Slopes:
    """Some functions of state, phase and coefficients with their first derivatives, compiled."""

    def __init__(self, functions: Sequence[Expression], equations: Equations) -> None:
        inputs = [*equations.states, equations.phase, *equations.coefficients]
        self._shape, self._states = (len(functions), len(inputs)), equations.dimension
        self._values = StateFunction("values", functions, equations)

        def slopes() -> Iterable[Expression]:
            return hy.diff_tensors(list(functions), diff_args=inputs, diff_order=1).jacobian.ravel()

        self._slopes = StateFunction("slopes", functions, equations, derived=slopes)

    def values(self, states: Array, phases: Array, constants: Constants) -> Array:
        """Return the functions themselves. Shapes: states (p, n); phases (p,); returns (p, q)."""
        return np.ascontiguousarray(self._values.along(states, phases, constants))

    def at(
        self, state: Array, phase: float, constants: Constants, directions: Array
    ) -> tuple[Array, Array, Array]:
        """Return derivatives by state and phase, and along changes of the coefficients.

        Shapes: state (n,); directions (n_c, k); returns (q, n), (q,), (q, k).
        """
        result, n = self._slopes.at(state, phase, constants).reshape(self._shape), self._states
        return result[:, :n], result[:, n], result[:, n + 1 :] @ directions


class Evaluated:
    """What equations say at a state and a phase, nothing integrated.

    Functions are compiled on first use and kept on disk. Threads share them: they hold no work
    space.
    """

    def __init__(self, equations: Equations) -> None:
        self.equations = equations
        self.dimension = equations.dimension
        self._functions: dict[str, Any] = {}
        self._outputs: dict[str, Slopes] = {}

    def coefficients(self, parameters: Array) -> Array:
        """Evaluate the coefficients. Shapes: parameters (..., n_p); returns (..., n_c)."""
        return np.asarray(self._coefficients(np.ascontiguousarray(parameters.T)).T)

    @cached_property
    def _coefficients(self) -> Any:
        given = self.equations.coefficient_values, self.equations.parameters
        return self._compiled("coefficients", lambda: compiled_function(*given))

    def coefficient_slopes(self, parameters: Array) -> Array:
        """Differentiate them. Shapes: parameters (..., n_p); returns (..., n_c, n_p)."""
        values, symbols = self.equations.coefficient_values, self.equations.parameters

        def build() -> Any:
            slopes = [hy.diff(value, symbol) for value in values for symbol in symbols]
            return compiled_function(slopes, symbols)

        function = self._compiled("coefficient slopes", build)
        slopes = function(np.ascontiguousarray(parameters.T)).T
        return np.asarray(slopes.reshape(*parameters.shape[:-1], len(values), len(symbols)))

    def rates(self, states: Array, phases: Array, constants: Constants) -> Array:
        """Evaluate dq/dphase. Shapes: states (m, n); phases (m,); returns (m, n)."""
        function = self._compiled("rates", lambda: self._function(self.equations.rates))
        return self._evaluate(function, states, phases, constants)

    def jacobians(self, states: Array, phases: Array, constants: Constants) -> Array:
        """Evaluate the Jacobian of dq/dphase with respect to the states.

        Shapes: states (m, n); phases (m,); returns (m, n, n).
        """
        function = self._compiled("jacobian", lambda: self._function(self._slopes()))
        result = self._evaluate(function, states, phases, constants)
        return result.reshape(-1, len(self.equations.field), self.dimension)

    def changing_jacobians(
        self, states: Array, phases: Array, constants: Constants
    ) -> tuple[Array, Indices, Array]:
        """Evaluate the first Jacobian, and of all those columns that states or phase change.

        Shapes: states (m, n); phases (m,); returns (n, n), places (c,), columns (m, n, c).
        """

        def build() -> Any:
            moving = {str(symbol) for symbol in (*self.equations.states, self.equations.phase)}
            slopes = self._slopes()
            changing = [not moving.isdisjoint(hy.get_variables(slope)) for slope in slopes]
            places = np.flatnonzero(changing)
            return self._function(slopes[places]) if len(places) else None, places

        first = self.jacobians(states[:1], phases[:1], constants)[0]
        changing, places = self._compiled("changing slopes", build)
        rows, where = np.divmod(places, self.dimension)
        columns, own = np.unique(where, return_inverse=True)
        result = np.empty((len(states), self.dimension, len(columns)))
        result[:] = first[:, columns]
        if changing is not None:
            result[:, rows, own] = self._evaluate(changing, states, phases, constants)
        return first, columns, result

    def outputs(self, states: Array, phases: Array, constants: Constants) -> Array:
        """Evaluate all outputs, the states first.

        Shapes: states (m, n); phases (m,); returns (m, n_outputs).
        """
        expressions = [item for _, item in self.equations.outputs]
        function = self._compiled("outputs", lambda: self._function(expressions))
        return self._evaluate(function, states, phases, constants)

    def output_slopes(self, name: str) -> Slopes:
        """Return an output with its derivatives."""
        if name not in self._outputs:
            self._outputs[name] = Slopes([dict(self.equations.outputs)[name]], self.equations)
        return self._outputs[name]

    def curvatures(
        self, states: Array, phases: Array, constants: Constants, vectors: Array, directions: Array
    ) -> tuple[Array, Array]:
        """Differentiate the slopes of the rates along vectors, each at a state of its own.

        Shapes: states, vectors (m, n); phases (m,); directions (n_c, k); returns second (m, n, n),
        mixed (m, n, k).
        """

        def build() -> Any:
            symbols, coefficients = self.equations.states, self.equations.coefficients
            vector, along = _directions("v", symbols), _directions("d", coefficients)
            slopes = _slopes(self.equations.rates, symbols, vector)
            second = _derivatives(slopes, symbols).ravel()
            mixed = _slopes(slopes, coefficients, along)
            return self._function([*second, *mixed], [*vector, *along])

        m, n, k = len(states), self.dimension, directions.shape[1]
        more = np.concatenate([np.repeat(vectors, k, axis=0), np.tile(directions.T, (m, 1))], 1)
        rows, at = np.repeat(states, k, axis=0), np.repeat(phases, k)
        result = self._evaluate(self._compiled("bent", build), rows, at, constants, more)
        result = result.reshape(m, k, n * n + n)
        mixed = np.swapaxes(result[:, :, n * n :], 1, 2)
        return result[:, 0, : n * n].reshape(m, n, n), mixed

    def parameter_slopes(
        self, states: Array, phases: Array, constants: Constants, directions: Array
    ) -> Array:
        """Return the derivatives of the rates along changes of the coefficients.

        Shapes: states (m, n); phases (m,); directions (n_c, k); returns (m, n, k).
        """

        def build() -> Any:
            coefficients = self.equations.coefficients
            change = _directions("d", coefficients)
            return self._function(_slopes(self.equations.rates, coefficients, change), change)

        m, k = len(states), directions.shape[1]
        rows, at = np.repeat(states, k, axis=0), np.repeat(phases, k)
        along = np.tile(directions.T, (m, 1))
        result = self._evaluate(self._compiled("pull", build), rows, at, constants, along)
        return result.reshape(m, k, len(self.equations.field)).transpose(0, 2, 1)

    def powers(
        self, states: Array, phases: Array, constants: Constants, vectors: Array
    ) -> tuple[Array, Array]:
        """Return second and third derivatives of the rates along vectors.

        Shapes: states, vectors (m, n); phases (m,); returns second, third (m, n).
        """

        def build() -> Any:
            vector = _directions("v", self.equations.states)
            forms, values = list(self.equations.rates), []
            for order in (1, 2, 3):
                forms = _slopes(forms, self.equations.states, vector)
                values += forms if order > 1 else []
            return self._function(values, vector)

        function = self._compiled("powers", build)
        result = self._evaluate(function, states, phases, constants, vectors)
        return result[:, : self.dimension], result[:, self.dimension :]

    def along_curves(
        self, states: Array, phases: Array, constants: Constants, curves: Array
    ) -> Array:
        """Return Taylor coefficients of order 2 to 5 of the rates along x + s v_1 + s^2 v_2 + ...

        Shapes: states (m, n); phases (m,); curves (m, p, n), the v_i up to the fourth; returns
        (m, 4, n).
        """
        symbols = self.equations.states
        orders = range(2, CURVE_POWERS + 2)

        def build() -> Any:
            s, vectors = hy.expression("s"), []
            moved = dict(zip(map(str, symbols), symbols, strict=True))
            for k in range(1, CURVE_POWERS + 1):
                vectors += _directions(f"v{k}", symbols)
                own = zip(moved.items(), vectors[-len(symbols) :], strict=True)
                moved = {name: item + s ** float(k) * v for (name, item), v in own}
            rates = hy.subs(list(self.equations.rates), moved)
            tensors = hy.diff_tensors(rates, diff_args=[s], diff_order=orders[-1])
            forms = [
                item / math.factorial(order)
                for order in orders
                for _, item in tensors.get_derivatives(order)
            ]
            return self._function(hy.subs(forms, {"s": hy.expression(0.0)}), vectors)

        count, powers, n = curves.shape
        vectors = np.zeros((count, CURVE_POWERS, n))
        vectors[:, :powers] = curves
        function = self._compiled("along curves", build)
        result = self._evaluate(function, states, phases, constants, vectors.reshape(count, -1))
        return result.reshape(count, len(orders), n)

    def _compiled(self, kind: str, build: Callable[[], Any]) -> Any:
        if kind not in self._functions:
            key = f"function {kind}\n{self.equations.fingerprint()}"
            self._functions[kind] = cached(key, build)
        return self._functions[kind]

    def _function(self, expressions: Iterable[Any], more: Sequence[Any] = ()) -> Any:
        equations = self.equations
        arguments = [*equations.states, equations.phase, *equations.coefficients, *more]
        return compiled_function(expressions, arguments)

    def _slopes(self) -> NDArray[Any]:
        states, rates = list(self.equations.states), list(self.equations.rates)
        slopes = hy.diff_tensors(rates, diff_args=states, diff_order=1).jacobian
        return np.asarray(slopes).ravel()

    def _evaluate(
        self, function: Any, states: Array, phases: Array, c: Constants, more: Array | None = None
    ) -> Array:
        """Evaluate a function of many states; constants in rows serve as many states each."""
        (m, n), count = states.shape, c.values.shape[-1]
        # Rows are written in place: with many states, copies would take most of the time.
        inputs = np.empty((n + 1 + count + (0 if more is None else more.shape[1]), m))
        inputs[:n] = states.T
        inputs[n] = phases
        known = inputs[n + 1 : n + 1 + count]
        if c.values.ndim == 1:
            known[:] = c.values[:, None]
        else:
            known.reshape(count, len(c.values), -1)[:] = c.values.T[:, :, None]
        if more is not None:
            inputs[n + 1 + count :] = more.T
        return function(inputs).T
