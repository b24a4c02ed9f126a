"""Base classes of friction laws, without and with a memory."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar

import heyoka as hy
import numpy as np
from numpy.typing import ArrayLike

from slipfold.arrays import Array
from slipfold.drawing import Drawn
from slipfold.errors import InputError
from slipfold.models.parametric import Parametric
from slipfold.models.quantities import (
    Expression,
    ParameterSymbols,
    State,
    Symbols,
    nonnegative,
    positive,
)

STATIC = nonnegative("mu_s", 0.5, "", "static friction coefficient, reached at rest", r"$\mu_s$")
KINETIC = nonnegative("mu_k", 0.3, "", "kinetic friction coefficient", r"$\mu_k$")
STRIBECK_SPEED = positive("vs", 0.1, "m/s", "speed over which friction falls", "$v_s$")
VISCOUS = nonnegative(
    "s2", 0.0, "s/m", "viscous friction: coefficient per slip speed", r"$\sigma_2$"
)
REST_SPEED = positive(
    "e", 1e-4, "m/s", "speed below which |v| is rounded off to sqrt(v^2 + e^2)", r"$\varepsilon$"
)


def is_symbolic(*values: Any) -> bool:
    """Whether any of the values is a symbolic expression."""
    return any(isinstance(value, hy.expression) for value in values)


def _function(symbolic: Any, numeric: Any) -> Callable[[Expression], Expression]:
    """Return a function of symbols, numbers and arrays."""

    def function(value: Expression) -> Expression:
        if is_symbolic(value):
            return symbolic(value)
        result = numeric(value)
        return result.item() if np.ndim(result) == 0 else result  # a number that prints as typed

    return function


cos = _function(hy.cos, np.cos)
sin = _function(hy.sin, np.sin)
exp = _function(hy.exp, np.exp)
tanh = _function(hy.tanh, np.tanh)
arctan = _function(hy.atan, np.arctan)
sqrt = _function(hy.sqrt, np.sqrt)


@dataclass(frozen=True)
class ContactState:
    """State of a contact in numbers, arrays or symbols."""

    slip: tuple[Expression, ...]  # velocity of the moving surface relative to the body in m/s
    memory: tuple[Expression, ...] = ()  # states of the law, if it has a memory
    normal: Expression = 1.0  # normal force in N
    normal_rate: Expression = 0.0  # its rate in N/s

    @property
    def square(self) -> Expression:
        """Square of the slip speed."""
        return sum(component * component for component in self.slip)

    @property
    def speed(self) -> Expression:
        """Slip speed in m/s."""
        return sqrt(self.square)


SlipSpeed = Annotated[ArrayLike, "Slip speed in m/s, a number or array, not negative."]
ContactValues = Annotated[ContactState, "Slip, memory and normal force."]


@dataclass(frozen=True)
class FrictionLaw(Parametric, Drawn, ABC):
    r"""Friction between two bodies that slip on each other; immutable, comparable, picklable.

    The force on a body, pressed with the normal force N on a surface that moves relative to it
    with the velocity v, is

    .. math::

        F = N \mu(|v|) v/|v|

    along v, in the plane as on a line. All laws are proportional to the normal force: their
    stiffness and damping, too, are those of the force over N. `plot` draws the friction coefficient
    over the slip speed with its slope, up to the speed ``fastest=`` in m/s.

    A subclass is a frozen dataclass. It states `title`, declares its parameters with `described`
    and implements `formula`; fields that are not parameters (an exponent, a shape) are made by
    `structural`.
    """

    sticks: ClassVar[bool] = True
    """Whether the force at rest may have any value up to a limit, so that the contact can stick."""

    rate_independent: ClassVar[bool] = False
    """Whether the friction force in slip depends on the direction of the slip alone."""

    # -- what a subclass gives -----------------------------------------------------------------

    @abstractmethod
    def formula(self, speed: Expression, p: Symbols) -> Expression:
        """Return the friction coefficient in steady slip.

        Parameters
        ----------
        speed
            Slip speed in m/s, not negative; number, array or symbol.
        p
            The parameters by name, numbers or symbols.
        """

    def check(self, values: Mapping[str, float]) -> None:
        """Refuse a static coefficient below the kinetic or the smallest one."""
        super().check(values)
        if "mu_s" not in values:
            return
        for name in ("mu_k", "mu_m"):
            if name in values and values["mu_s"] < values[name]:
                raise InputError(
                    f"mu_s = {values['mu_s']:g} is below {name} = {values[name]:g}; friction at "
                    f"rest is no less than in motion, give mu_s >= {name}"
                )

    @property
    def label(self) -> str:
        """Name of the law in figures."""
        return self.title

    @property
    def typical_speed(self) -> float:
        """Slip speed over which the coefficient changes, m/s; a figure shows a few of them."""
        return self.values.get("vs", 1.0)

    @property
    def stiction(self) -> float:
        """Friction coefficient up to which a contact sticks; 0 if it never does."""
        return float(self.holding(self.values)) if self.sticks else 0.0

    def holding(self, p: ParameterSymbols) -> Expression:
        """Return the coefficient up to which a contact sticks: ``mu_s``, or that at no speed."""
        return p["mu_s"] if "mu_s" in p else self.formula(0.0, p)

    def forces(self, contact: ContactValues, p: ParameterSymbols) -> tuple[Expression, ...]:
        """Return the friction force in N, as many components as the slip has."""
        if self.rate_independent:
            drag = contact.normal * self.formula(1.0, p) * contact.square**-0.5
        else:
            speed = sqrt(contact.square)
            drag = contact.normal * self.formula(speed, p) / speed
        return tuple(drag * component for component in contact.slip)

    # -- memory: none unless a subclass says so --------------------------------------------------

    def memory(self, dimensions: int) -> tuple[State, ...]:
        """Return the states of the law; none for most.

        Parameters
        ----------
        dimensions
            1 for slip along a line, 2 for slip in a plane.
        """
        return ()

    @property
    def memory_scale(self) -> float:
        """Scale of the memory, in its unit."""
        return 1.0

    def memory_rates(self, contact: ContactValues, p: ParameterSymbols) -> tuple[Expression, ...]:
        """Return the time derivatives of the memory, per second."""
        return ()

    def steady_memory(self, slip: Sequence[float]) -> tuple[float, ...]:
        """Return the memory after a long slip at a constant velocity; zero without slip.

        Parameters
        ----------
        slip
            Velocity of the moving surface relative to the body in m/s, one or two components.
        """
        return ()

    # -- what follows --------------------------------------------------------------------------

    def coefficient(self, speed: SlipSpeed) -> Any:
        """Return the friction coefficient in steady slip, of the shape of `speed`."""
        speeds = np.asarray(speed)
        if np.any(speeds.real < 0):  # a complex step may differentiate
            raise InputError(
                f"a slip speed of {float(speeds.real.min()):g} m/s is negative; give the modulus "
                "of the slip velocity"
            )
        result = np.asarray(self.formula(speeds, self.values) + 0.0 * speeds)
        return result if result.ndim else result.item()

    def slope(self, speed: SlipSpeed) -> Any:
        """Return the derivative of the coefficient by the slip speed in s/m, shaped as `speed`.

        A negative slope feeds vibration along the slip. A complex step takes the derivative, which
        is exact to rounding.
        """
        step = 1e-30
        result = np.imag(self.coefficient(np.asarray(speed) + 1j * step)) / step
        return result if np.ndim(result) else float(result)

    def damping(self, speed: float, normal: float = 1.0, direction: float = 0.0) -> Array:
        r"""Return the damping matrix of small motions about steady slip in N s/m, shape (2, 2).

        .. math::

            N [\mu'(V) e e^T + (\mu(V)/V)(I - e e^T)]

        with the direction e of slip: what dF/dv of a force along the relative velocity gives. On a
        line the damping is :math:`N \mu'(V)`, the first entry for direction 0. With memory it holds
        for motions much slower than the memory.

        Parameters
        ----------
        speed
            Slip speed V > 0 in m/s.
        normal
            Normal force N in N.
        direction
            Direction of slip from the x axis in rad.
        """
        if not speed > 0:
            raise InputError(
                f"speed = {speed:g} m/s: friction is linearized about steady slip; give speed > 0"
            )
        e = np.array([np.cos(direction), np.sin(direction)])
        along = np.outer(e, e)
        across = self.coefficient(speed) / speed
        return np.asarray(normal * (self.slope(speed) * along + across * (np.eye(2) - along)))

    def force(
        self, slip: Sequence[Any], normal: Any = 1.0, memory: Sequence[Any] = ()
    ) -> tuple[Any, ...]:
        """Return the friction force on a body in N, as many components as `slip`.

        Parameters
        ----------
        slip
            Velocity of the moving surface relative to the body in m/s, one or two components:
            numbers, arrays or symbols.
        normal
            Normal force in N.
        memory
            The contact's memory if the law has one.

        Raises
        ------
        InputError
            If there are not one or two components, a law with memory got none, or the slip is zero
            and the law sticks.
        """
        contact = ContactState(tuple(slip), tuple(memory), normal)
        size = len(contact.slip)
        if size not in (1, 2):
            raise InputError(f"the slip has {size} components; give 1 on a line or 2 in the plane")
        needed = len(self.memory(size))
        if len(memory) != needed:
            raise InputError(
                f"{type(self).__name__} needs {needed} components of memory for a slip of "
                f"{size}, and got {len(memory)}"
            )
        square = contact.square
        if self.sticks and not is_symbolic(square) and np.any(np.asarray(square) == 0):
            raise InputError(
                f"at rest the friction force of {type(self).__name__} can have any value up to its "
                "limit; give a slip that is not zero, or a regularized law"
            )
        return self.forces(contact, self.values)


@dataclass(frozen=True)
class MemoryLaw(FrictionLaw):
    """A law with a deflection z as memory, a vector in the plane; it never sticks.

    A subclass gives `memory_rates`, `forces` and `steady_deflection` in addition to `formula`.
    """

    sticks: ClassVar[bool] = False
    unit: ClassVar[str] = "m"
    """Unit of the deflection."""
    meaning: ClassVar[str] = "deflection of the contact"

    @abstractmethod
    def steady_deflection(self, speed: float) -> float:
        """Return the deflection after a long slip at a constant speed.

        Parameters
        ----------
        speed
            Slip speed in m/s.
        """

    def memory(self, dimensions: int) -> tuple[State, ...]:
        """Return the states ``z``, or ``zx`` and ``zy``."""
        if dimensions == 1:
            return (State("z", self.unit, self.meaning, "$z$"),)
        return tuple(
            State(f"z{axis}", self.unit, f"{self.meaning} along {axis}", f"$z_{axis}$")
            for axis in "xy"
        )

    def steady_memory(self, slip: Sequence[float]) -> tuple[float, ...]:
        """Return the deflection after a long slip at a constant velocity; zero without slip."""
        speed = float(np.linalg.norm(slip))
        if not speed:
            return (0.0,) * len(slip)
        return tuple(self.steady_deflection(speed) * float(part) / speed for part in slip)
