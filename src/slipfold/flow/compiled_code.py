"""Integrators and functions compiled from equations, kept on disk, a copy for each thread."""

from __future__ import annotations

import copy
import hashlib
import os
import pickle
import platform
import stat
import tempfile
import threading
from collections.abc import Callable, Iterable, Sequence
from functools import cache as memoise
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Any, TypeVar

import heyoka as hy
import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.flow.batches import LANES, OPTIMIZATION
from slipfold.flow.equations import (
    Constants,
    Equations,
    Scaled,
    with_variations,
)
from slipfold.flow.sharp_turns import VERSION, SharpTurns, sharp_turns
from slipfold.models.formulas.functions import compiled_function
from slipfold.models.model import Kind, Model
from slipfold.models.output import Limit


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


@memoise
def _machine() -> str:
    """What compiled code depends on: heyoka, Python, and the processor's instruction set."""
    return "\n".join([hy.__version__, platform.python_version(), platform.platform(), _processor()])


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


JET_ORDER = 3

JET_TOLERANCE = 1e-10
"""Normal form coefficients need eight digits, not thirteen: a third less time."""

SHORT = 250
"""Terms of the rates up to which code is not compact: that of two to four states runs in two thirds
of the time then and is compiled in as much; what is longer takes ever longer to compile."""


class CompiledCode:
    """Everything a flow runs, compiled on first use and kept on disk.

    Integrators work in scaled states, see `Scaled`: their parameters begin with the coefficients
    and the scales. Functions work in the states themselves. Threads share functions, which hold no
    work space, and have integrators of their own.

    `tolerance` is the local error that a step of an integrator may make.
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

    # -- integrators ---------------------------------------------------------------------------

    @property
    def plain(self) -> Any:
        """Batch of the states alone, always optimized: searches for trajectories run long."""

        def build() -> Any:
            system = self._plain_system()
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
                self._plain_system(),
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

    # -- functions -----------------------------------------------------------------------------

    @cached_property
    def coefficients(self) -> Any:
        """Coefficients, of the parameters."""
        values = self._equations.coefficient_values
        return self._kept("coefficient values", lambda: self._of_parameters(values))

    @cached_property
    def coefficient_slopes(self) -> Any:
        """Derivatives of the coefficients with respect to the parameters, row by row."""

        def build() -> Any:
            values, parameters = self._equations.coefficient_values, self._equations.parameters
            slopes = [hy.diff(value, parameter) for value in values for parameter in parameters]
            return self._of_parameters(slopes)

        return self._kept("coefficient slopes", build)

    @cached_property
    def rates(self) -> Any:
        """Rates of the states, of states, phase and coefficients."""
        return self._kept("rates", lambda: self._function(self._equations.rates))

    @cached_property
    def jacobian(self) -> Any:
        """Derivatives of the rates with respect to the states, row by row."""
        return self._kept("jacobian", lambda: self._function(self._slopes()))

    @cached_property
    def changing_slopes(self) -> tuple[Any, NDArray[np.intp]]:
        """Those derivatives that states or phase change, and their places; None if all stay."""

        def build() -> Any:
            moving = {str(symbol) for symbol in (*self._equations.states, self._equations.phase)}
            slopes = self._slopes()
            changing = [not moving.isdisjoint(hy.get_variables(slope)) for slope in slopes]
            places = np.flatnonzero(changing)
            return self._function(slopes[places]) if len(places) else None, places

        result: tuple[Any, NDArray[np.intp]] = self._kept("changing slopes", build)
        return result

    @cached_property
    def curvature(self) -> Any:
        """Derivatives of the rates and of their slope along a vector.

        Arguments are states, phase, coefficients, the vector v and a direction d of the
        coefficients. Values are ``D^2 f [v, .]`` row by row, then the derivative of ``Df v`` along
        d.
        """

        def build() -> Any:
            equations = self._equations
            states, rates = equations.states, equations.rates
            vector, along = (
                self._directions("v", states),
                self._directions("d", equations.coefficients),
            )
            slopes = _slopes(rates, states, vector)
            second = _derivatives(slopes, states).ravel()
            pulls = _slopes(slopes, equations.coefficients, along)
            return self._function([*second, *pulls], [*vector, *along])

        return self._kept("bent", build)

    @cached_property
    def pull(self) -> Any:
        """Derivatives of the rates along a direction d of the coefficients.

        Arguments are states, phase, coefficients and d.
        """

        def build() -> Any:
            rates, coefficients = self._equations.rates, self._equations.coefficients
            along = self._directions("d", coefficients)
            return self._function(_slopes(rates, coefficients, along), along)

        return self._kept("pull", build)

    @cached_property
    def powers(self) -> Any:
        """``D^2 f [v, v]`` and ``D^3 f [v, v, v]``; arguments as for `rates`, then the vector v."""

        def build() -> Any:
            states = self._equations.states
            vector = self._directions("v", states)
            forms, values = list(self._equations.rates), []
            for order in (1, 2, 3):
                forms = _slopes(forms, states, vector)
                values += forms if order > 1 else []
            return self._function(values, vector)

        return self._kept("powers", build)

    @cached_property
    def outputs(self) -> Any:
        """All outputs."""
        expressions = [item for _, item in self._equations.outputs]
        return self._kept("outputs", lambda: self._function(expressions))

    # -- how they are made ---------------------------------------------------------------------

    def _slopes(self) -> NDArray[Any]:
        states, rates = list(self._equations.states), list(self._equations.rates)
        slopes = hy.diff_tensors(rates, diff_args=states, diff_order=1).jacobian
        return np.asarray(slopes).ravel()

    def _own(self, kind: str, build: Callable[[], Any]) -> Any:
        return self._integrators.get(kind, lambda: self._kept(kind, build))

    def _kept(self, kind: str, build: Callable[[], Any]) -> Any:
        options = f"lanes={LANES} tolerance={self._tolerance!r} jets={JET_ORDER, JET_TOLERANCE}"
        made = f"scaled {kind} {options} level={OPTIMIZATION} {VERSION}"
        # heyoka's own disk cache is one for all programs and unchecked: ours takes its place.
        hy.llvm_state.set_diskcache_enabled(False)
        return cached(f"{made}\n{self._equations.fingerprint()}", build)

    def _plain_system(self) -> list[tuple[Any, Any]]:
        return self._system(self._places())

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

    def _directions(self, letter: str, symbols: Iterable[Any]) -> list[Any]:
        return [hy.expression(f"{letter}_{symbol}") for symbol in symbols]

    def _of_parameters(self, expressions: Iterable[Any]) -> Any:
        return compiled_function(expressions, self._equations.parameters)

    def _function(self, expressions: Iterable[Any], more: Sequence[Any] = ()) -> Any:
        equations = self._equations
        arguments = [*equations.states, equations.phase, *equations.coefficients, *more]
        return compiled_function(expressions, arguments)


def _slopes(forms: Sequence[Any], symbols: Sequence[Any], direction: Sequence[Any]) -> list[Any]:
    """Derivatives of expressions along a direction."""
    none = hy.expression(0.0)
    return [
        hy.sum([s * d for s, d in zip(row, direction, strict=True) if s != none])
        for row in _derivatives(forms, symbols)
    ]


MANY = 8
"""Symbols from which derivatives are taken all at once, in a fifth of the time. Of few each is
simplified by itself, and rounded less."""


def _derivatives(forms: Sequence[Any], symbols: Sequence[Any]) -> NDArray[Any]:
    """Derivatives of expressions, a row each."""
    if len(symbols) < MANY:
        result = [hy.diff(form, symbol) for form in forms for symbol in symbols]
        return np.array(result, dtype=object).reshape(len(forms), len(symbols))
    return np.asarray(hy.diff_tensors(list(forms), diff_args=list(symbols), diff_order=1).jacobian)


class Evaluated:
    """What equations say at a state and a phase, nothing integrated."""

    def __init__(self, code: CompiledCode, dimension: int) -> None:
        self._code = code
        self.dimension = dimension

    def rates(self, states: Array, phases: Array, constants: Constants) -> Array:
        """Evaluate dq/dphase. Shapes: states (m, n); phases (m,); returns (m, n)."""
        return self._evaluate(self._code.rates, states, phases, constants)

    def jacobians(self, states: Array, phases: Array, constants: Constants) -> Array:
        """Evaluate the Jacobian of dq/dphase with respect to the states.

        Shapes: states (m, n); phases (m,); returns (m, n, n).
        """
        n = self.dimension
        return self._evaluate(self._code.jacobian, states, phases, constants).reshape(-1, n, n)

    def changing_jacobians(
        self, states: Array, phases: Array, constants: Constants
    ) -> tuple[Array, NDArray[np.intp], Array]:
        """Evaluate the first Jacobian, and of all those columns that states or phase change.

        Shapes: states (m, n); phases (m,); returns (n, n), places (c,), columns (m, n, c).
        """
        first = self.jacobians(states[:1], phases[:1], constants)[0]
        changing, places = self._code.changing_slopes
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
        return self._evaluate(self._code.outputs, states, phases, constants)

    def curvatures(
        self,
        states: Array,
        phases: Array,
        constants: Constants,
        vectors: Array,
        directions: Array,
    ) -> tuple[Array, Array]:
        """Differentiate the slopes of the rates along vectors, each at a state of its own.

        Shapes: states, vectors (m, n); phases (m,); directions (n_c, k); returns second (m, n, n),
        mixed (m, n, k).
        """
        m, n, k = len(states), self.dimension, directions.shape[1]
        more = np.concatenate([np.repeat(vectors, k, axis=0), np.tile(directions.T, (m, 1))], 1)
        rows, at = np.repeat(states, k, axis=0), np.repeat(phases, k)
        result = self._evaluate(self._code.curvature, rows, at, constants, more)
        result = result.reshape(m, k, n * n + n)
        mixed = np.swapaxes(result[:, :, n * n :], 1, 2)
        return result[:, 0, : n * n].reshape(m, n, n), mixed

    def pulls(self, states: Array, phases: Array, constants: Constants, directions: Array) -> Array:
        """Return the derivatives of the rates along changes of the coefficients.

        Shapes: states (m, n); phases (m,); directions (n_c, k); returns (m, n, k).
        """
        m, k = len(states), directions.shape[1]
        rows, at = np.repeat(states, k, axis=0), np.repeat(phases, k)
        along = np.tile(directions.T, (m, 1))
        result = self._evaluate(self._code.pull, rows, at, constants, along)
        return result.reshape(m, k, -1).transpose(0, 2, 1)

    def powers(
        self, states: Array, phases: Array, constants: Constants, vectors: Array
    ) -> tuple[Array, Array]:
        """Return second and third derivatives of the rates along vectors.

        Shapes: states, vectors (m, n); phases (m,); returns second, third (m, n).
        """
        result = self._evaluate(self._code.powers, states, phases, constants, vectors)
        return result[:, : self.dimension], result[:, self.dimension :]

    def _evaluate(
        self, function: Any, states: Array, phases: Array, c: Constants, more: Array | None = None
    ) -> Array:
        one = c.values.ndim == 1
        values = np.repeat(c.values[:, None], len(states), axis=1) if one else c.values.T
        rows = [states.T, phases[None], values, *([] if more is None else [more.T])]
        return function(np.ascontiguousarray(np.concatenate(rows))).T
