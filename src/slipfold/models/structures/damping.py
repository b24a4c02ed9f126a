"""Rules that make a damping matrix of mass and stiffness."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Self

import numpy as np

from slipfold.arrays import Array
from slipfold.errors import InputError
from slipfold.models.parametric import Parametric, described, structural
from slipfold.models.quantities import Parameter, nonnegative
from slipfold.models.structures.matrices import is_diagonal, lowest_modes
from slipfold.models.units import parse_quantity


@dataclass(frozen=True)
class Damping(Parametric, ABC):
    """A rule that makes a damping matrix of mass and stiffness."""

    title: ClassVar[str] = "damping"

    @abstractmethod
    def _terms(self, mass: Array, stiffness: Array) -> tuple[tuple[str | None, Array], ...]:
        """Return the parts of the damping matrix with the parameter that multiplies each."""


@dataclass(frozen=True)
class ProportionalDamping(Damping):
    r"""Rayleigh damping: :math:`C = \alpha_M M + \beta_K K`.

    A mode of the frequency :math:`\omega` has the damping ratio :math:`\tfrac12 (\alpha_M/\omega +
    \beta_K \omega)`.

    Examples
    --------
    >>> ProportionalDamping(beta_K=1e-4).values
    {'alpha_M': 0.0, 'beta_K': 0.0001}
    """

    title: ClassVar[str] = "proportional damping"

    alpha_M: float = described(
        nonnegative("alpha_M", 0.0, "1/s", "damping over mass", r"$\alpha_M$")
    )
    beta_K: float = described(
        nonnegative("beta_K", 0.0, "s", "damping over stiffness", r"$\beta_K$")
    )

    def _terms(self, mass: Array, stiffness: Array) -> tuple[tuple[str | None, Array], ...]:
        """Mass and stiffness."""
        return (("alpha_M", mass), ("beta_K", stiffness))


_RATIO = nonnegative("zeta", 0.01, "", "damping ratio of all modes", r"$\zeta$")


def _checked_ratios(ratios: Any, title: str) -> float | tuple[float, ...]:
    several = isinstance(ratios, list | tuple | np.ndarray)
    checked = tuple(
        _RATIO.check(parse_quantity(item, "", f"damping ratio {position}"))
        for position, item in enumerate(ratios if several else [ratios], 1)
    )
    return checked if several else checked[0]


@dataclass(frozen=True)
class ModalDamping(Damping):
    r"""Damping by the ratios of the modes, with modes of unit modal mass.

    .. math::

        C = M \Bigl(\sum_i 2 \zeta_i \omega_i \phi_i \phi_i^T\Bigr) M

    Examples
    --------
    >>> ModalDamping(0.01).values
    {'zeta': 0.01}
    """

    title: ClassVar[str] = "modal damping"

    ratios: Any = structural(
        "one damping ratio for all modes, which becomes the parameter ``zeta``; or one a mode, "
        "lowest first, shape (n,)",
        read=_checked_ratios,
    )

    def _pairs(self) -> Iterator[tuple[Parameter, float]]:
        if not isinstance(self.ratios, tuple):
            yield _RATIO, self.ratios

    @property
    def kind(self) -> Self:
        """The damping with the default ratio if it is one for all modes."""
        return self if isinstance(self.ratios, tuple) else replace(self, ratios=0.01)

    def _terms(self, mass: Array, stiffness: Array) -> tuple[tuple[str | None, Array], ...]:
        """Return the damping matrix, for a ratio of 1 if it is one for all modes."""
        size = len(mass)
        single = not isinstance(self.ratios, tuple)
        if not single and len(self.ratios) != size:
            raise InputError(
                f"{len(self.ratios)} damping ratios are given for {size} modes; give one a mode, "
                "or one for all"
            )
        if is_diagonal(mass) and is_diagonal(stiffness):
            # Each coordinate is a mode; the matrix stays diagonal to the last digit.
            squares = np.diag(stiffness) / np.diag(mass)
            ratios = np.ones(size) if single else np.empty(size)
            if not single:
                ratios[np.argsort(squares, kind="stable")] = self.ratios
            matrix = np.diag(2 * ratios * np.sqrt(np.maximum(squares, 0)) * np.diag(mass))
            return (("zeta" if single else None, matrix),)
        squares, shapes = lowest_modes(stiffness, mass)
        moved = mass @ shapes
        modal = np.sum(shapes * moved, axis=0)
        ratios = np.ones(size) if single else np.array(self.ratios)
        weights = 2 * ratios * np.sqrt(np.maximum(squares, 0)) / modal
        return (("zeta" if single else None, (moved * weights) @ moved.T),)
