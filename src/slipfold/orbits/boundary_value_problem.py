"""Periodic orbits in one parameter as a boundary-value problem."""

from __future__ import annotations

from typing import Self

import numpy as np
from numpy.typing import NDArray

from slipfold.models.model import Model
from slipfold.orbits.contraction import growth_bound
from slipfold.orbits.linearisation import NO_CONDITIONS, Linearisation, defect_of
from slipfold.orbits.shooting import SEGMENTS, Shooting
from slipfold.orbits.test_functions import evaluate_tests

__all__ = ["PeriodicProblem"]

Array = NDArray[np.float64]


class PeriodicProblem(Shooting):
    r"""Orbits of period k in one free parameter.

    An unknown ``z`` holds the scaled states at m phases and the scaled parameter,

    .. math:: z = (x_0, ..., x_{m-1}) / (s \sqrt{m}), \quad z_{mn} = p / w

    with the model's state scales s and the width w of the parameter's span, so that its Euclidean
    length does not depend on m. The residual says that segment j ends where segment j + 1 begins.

    Parameters
    ----------
    model
        The model; the value of `vary` is a part of `z` instead.
    vary
        Name of the free parameter.
    period
        Period in forcing periods.
    width
        Scale of the parameter, in its unit.
    segments
        Number of segments m.
    offset
        Phase of the first node, in segments.
    """

    kind = "periodic"

    odd = ("LP",)

    def __init__(
        self,
        model: Model,
        vary: str,
        period: int,
        width: float,
        segments: int = SEGMENTS,
        offset: float = 0.0,
    ) -> None:
        super().__init__(
            model, period, *self._free(model, vary, width), segments=segments, offset=offset
        )
        self.vary = vary
        self.width = width

    @staticmethod
    def _free(model: Model, vary: str, width: float) -> tuple[list[str], list[float]]:
        """Names and scales of the free parameters, `vary` last."""
        return [vary], [width]

    # -- what z means --------------------------------------------------------------------------

    def pack(self, nodes: Array, value: float) -> Array:
        """Scale an orbit and a parameter value into an unknown.

        Shapes: nodes (m, n).
        """
        return self.join(nodes, [value])

    def value(self, z: Array) -> float:
        """Return the parameter value."""
        return float(z[-1] * self.width)

    def value_of(self, model: Model) -> float:
        """Return the value that a model gives the free parameter."""
        return model.values[self.vary]

    def with_period(self, period: int) -> Self:
        """Return the same problem for orbits of another period."""
        return type(self)(self.model, self.vary, period, self.width, self.segments)

    def begun_later(self) -> Self:
        """Return the same problem with its nodes half a segment later."""
        return type(self)(self.model, self.vary, self.period, self.width, self.segments, offset=0.5)

    def adopt(self, other: PeriodicProblem, z: Array) -> Array:
        """Return the unknown of an orbit that another problem describes."""
        return self.pack(other.nodes(z), other.value(z))

    def in_phase(self, z: Array, like: Array) -> Array:
        """Return the same orbit begun where it lies nearest to another.

        An orbit of period k is the same in whichever of its forcing periods it is begun.
        """
        nodes, constants = self.nodes(z), self.constants(z)
        begun = [z]
        for turn in range(1, self.period):
            moved = self.flow.advance(nodes, self._start, self._start + turn, constants)
            begun.append(np.concatenate([self.flat(moved), z[self.size :]]))
        return min(begun, key=lambda copy: float(np.linalg.norm(copy - like)))

    def distance(self, z: Array, like: Array) -> float:
        """Return how far apart two orbits are, wherever they are begun, in scaled variables."""
        return float(np.linalg.norm(self.in_phase(z, like) - like))

    def all_multipliers(self, multipliers: NDArray[np.complex128]) -> NDArray[np.complex128]:
        """Return the multipliers with those that are the same for all orbits, shape (n,)."""
        return multipliers

    # -- residual and derivatives --------------------------------------------------------------

    def defect(self, z: Array) -> Array:
        """Return what Newton's method brings to zero, shape (m n,)."""
        residual = self.mismatch(self.nodes(z), self.constants(z))
        return defect_of(residual, NO_CONDITIONS.values)

    def linearise(self, z: Array) -> Linearisation:
        """Return the mismatch and its derivatives."""
        return Linearisation(*self.transitions(self.nodes(z), self.constants(z)))

    def bounds(self, span: tuple[float, float]) -> list[tuple[int, float, float]]:
        """Return the place of the parameter in the unknown with its scaled bounds."""
        return [(-1, min(span) / self.width, max(span) / self.width)]

    def tests(
        self,
        z: Array,
        linearisation: Linearisation,
        multipliers: NDArray[np.complex128],
        tangent: Array,
    ) -> dict[str, float]:
        """Return the functions that change sign at a bifurcation.

        Shapes: multipliers (n,).
        """
        tests = evaluate_tests(multipliers)
        return {**tests, "LP": float(tangent[-1])}

    def growth(self, linearisation: Linearisation) -> float:
        """Return an upper bound of the logarithms of the multipliers' moduli."""
        # Along a cycle of an autonomous model perturbations neither grow nor shrink.
        return growth_bound(linearisation.blocks) if self.model.forced else np.inf
