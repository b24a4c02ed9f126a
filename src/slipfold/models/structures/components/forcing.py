"""Periodic forces on the structure: harmonic, of several harmonics, and by a moving base."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, Self

from slipfold.errors import InputError
from slipfold.models.friction.quantities import described
from slipfold.models.output import Expression, Symbols
from slipfold.models.parameter import Parameter
from slipfold.models.quantity import parse_quantity
from slipfold.models.structures.components.component import Component, Motion
from slipfold.models.structures.components.direction import Direction, as_direction
from slipfold.models.structures.components.harmonics import checked_harmonic
from slipfold.models.structures.components.one_direction import OneDirection
from slipfold.models.structures.components.sums import total
from slipfold.models.structures.components.trigonometry import cos_sin, wave
from slipfold.models.structures.shown import shown

_PHASE = Parameter("phi", 0.0, "rad", "phase by which a forcing leads", symbol=r"$\varphi$")


@dataclass(frozen=True)
class HarmonicForce(OneDirection):
    r"""A harmonic force :math:`F \cos(2\pi h f t + \varphi)`.

    Parameters
    ----------
    at
        Degree of freedom, or weights by name.
    F
        Amplitude in N.
    phi
        Phase in rad.
    harmonic
        The whole number h: how often the force repeats in a forcing period.
    name
        Tells forces apart; empty if there is one only.

    Examples
    --------
    >>> HarmonicForce("tip", F="20 mN").F
    0.02
    """

    title: ClassVar[str] = "harmonic force"

    F: float = described(Parameter("F", 0.0, "N", "amplitude of a force", symbol="$F$"))
    phi: float = described(_PHASE)
    harmonic: int = 1

    def prepare(self) -> None:
        """Read the direction and the harmonic."""
        super().prepare()
        object.__setattr__(self, "harmonic", checked_harmonic(self.harmonic, self.title))

    @property
    def amplitudes(self) -> tuple[str, ...]:
        """``F``."""
        return ("F",)

    def coefficients(self, p: Symbols) -> dict[str, Expression]:
        """Parts in phase and out of phase."""
        cos, sin = cos_sin(p["phi"])
        return {"cos": p["F"] * cos, "sin": p["F"] * sin}

    def forces(
        self, motion: Motion, c: Symbols, phase: Expression
    ) -> tuple[Expression | None, ...]:
        """``F cos(2 pi h f t + phi)``."""
        return (_harmonic(self.harmonic, c, phase),)


@dataclass(frozen=True)
class MultiHarmonicForce(OneDirection):
    r"""A force of several harmonics: :math:`\sum_h F_h \cos(2\pi h f t + \varphi_h)`.

    Parameters
    ----------
    at
        Degree of freedom, or weights by name.
    harmonics
        Amplitude in N, or amplitude and phase in rad, by harmonic: ``{0: 2.0, 1: 1.0, 3: (0.2,
        0.5)}``. They become the parameters ``F0 F1 phi1 F3 phi3``; the mean ``F0`` has no phase.
    name
        Tells forces apart; empty if there is one only.

    Examples
    --------
    >>> force = MultiHarmonicForce("tip", {0: 2.0, 1: 1.0, 3: (0.2, 0.5)})
    >>> force.own_values
    {'F0': 2.0, 'F1': 1.0, 'phi1': 0.0, 'F3': 0.2, 'phi3': 0.5}
    """

    title: ClassVar[str] = "force of several harmonics"

    harmonics: Any = field()

    def prepare(self) -> None:
        """Read the direction and the harmonics."""
        super().prepare()
        given = self.harmonics
        # A force that is made anew from its own fields has triples already.
        if isinstance(given, tuple) and all(
            isinstance(item, tuple) and len(item) == 3 for item in given
        ):
            given = {h: (size, phi) for h, size, phi in given}
        if not isinstance(given, Mapping) or not any(h != 0 for h in given):
            raise InputError(
                f"harmonics = {shown(self.harmonics)} is no periodic force; give amplitudes by "
                "harmonic, such as {1: 1.0, 3: (0.2, 0.5)}"
            )
        checked = []
        for h, pair in given.items():
            number = checked_harmonic(h, self.title, 0)
            size, phi = pair if isinstance(pair, tuple | list) and len(pair) == 2 else (pair, 0.0)
            amplitude = self._size(number).check(parse_quantity(size, "N", f"F{number}"))
            angle = self._angle(number).check(parse_quantity(phi, "rad", f"phi{number}"))
            checked.append((number, amplitude, angle))
        object.__setattr__(self, "harmonics", tuple(sorted(checked)))

    @staticmethod
    def _size(h: int) -> Parameter:
        what = f"amplitude of harmonic {h} of a force" if h else "mean of a force"
        return Parameter(f"F{h}", 0.0, "N", what, symbol=f"$F_{{{h}}}$")

    @staticmethod
    def _angle(h: int) -> Parameter:
        return Parameter(f"phi{h}", 0.0, "rad", f"phase by which harmonic {h} of a force leads")

    @property
    def own_parameters(self) -> tuple[Parameter, ...]:
        """Amplitude and phase of each harmonic."""
        pairs = [
            (self._size(h), self._angle(h)) if h else (self._size(h),) for h, _, _ in self.harmonics
        ]
        return tuple(item for pair in pairs for item in pair)

    @property
    def own_values(self) -> dict[str, float]:
        """Values of the parameters by name, in SI units."""
        values: dict[str, float] = {}
        for h, size, phi in self.harmonics:
            values |= {f"F{h}": size, f"phi{h}": phi} if h else {"F0": size}
        return values

    @property
    def kind(self) -> Self:
        """The force with all amplitudes zero."""
        return replace(self, harmonics=tuple((h, 0.0, 0.0) for h, _, _ in self.harmonics))

    @property
    def amplitudes(self) -> tuple[str, ...]:
        """All but the mean."""
        return tuple(f"F{h}" for h, _, _ in self.harmonics if h)

    def coefficients(self, p: Symbols) -> dict[str, Expression]:
        """Parts of each harmonic in phase and out of phase."""
        result: dict[str, Expression] = {}
        for h, _, _ in self.harmonics:
            cos, sin = cos_sin(p[f"phi{h}"]) if h else (1.0, 0.0)
            result[f"cos{h}"] = p[f"F{h}"] * cos
            if h:
                result[f"sin{h}"] = p[f"F{h}"] * sin
        return result

    def forces(
        self, motion: Motion, c: Symbols, phase: Expression
    ) -> tuple[Expression | None, ...]:
        """``sum F_h cos(2 pi h f t + phi_h)``."""
        terms = []
        for h, _, _ in self.harmonics:
            if not h:
                terms.append(c["cos0"])
                continue
            cos, sin = wave(h, phase)
            terms += [c[f"cos{h}"] * cos, -c[f"sin{h}"] * sin]
        return (total(terms),)


@dataclass(frozen=True)
class BaseMotion(Component):
    r"""A base that shakes the structure: :math:`u_b = A \cos(2\pi h f t + \varphi)`.

    Displacements are then relative to the base, and the force is :math:`-M r \ddot u_b`.

    Parameters
    ----------
    along
        The influence vector r: how each degree of freedom would move with the base if the
        structure were rigid, as weights by name; None if all move by the same.
    A
        Amplitude of the displacement in m.
    phi
        Phase in rad.
    harmonic
        The whole number h: how often the base moves to and fro in a forcing period.
    name
        Tells base motions apart; empty if there is one only.

    Examples
    --------
    >>> BaseMotion(A="1mm").A
    0.001
    """

    title: ClassVar[str] = "base motion"
    inertial: ClassVar[bool] = True

    along: Any = None
    A: float = described(Parameter("A", 0.0, "m", "amplitude of the base's motion", symbol="$A$"))
    phi: float = described(_PHASE)
    harmonic: int = 1

    def prepare(self) -> None:
        """Read the direction and the harmonic."""
        if self.along is not None:
            object.__setattr__(self, "along", as_direction(self.along, f"a {self.title}"))
        object.__setattr__(self, "harmonic", checked_harmonic(self.harmonic, self.title))

    @property
    def directions(self) -> tuple[Direction | None, ...]:
        """The one direction."""
        return (self.along,)

    @property
    def amplitudes(self) -> tuple[str, ...]:
        """``A``."""
        return ("A",)

    def coefficients(self, p: Symbols) -> dict[str, Expression]:
        """Parts of minus the acceleration in phase and out of phase, in m/s^2."""
        cos, sin = cos_sin(p["phi"])
        rate = 2 * math.pi * self.harmonic * p["f"]
        size = p["A"] * rate * rate
        return {"cos": size * cos, "sin": size * sin}

    def forces(
        self, motion: Motion, c: Symbols, phase: Expression
    ) -> tuple[Expression | None, ...]:
        """``A (2 pi h f)^2 cos(2 pi h f t + phi)``, to be multiplied with the masses."""
        return (_harmonic(self.harmonic, c, phase),)


def _harmonic(harmonic: int, c: Symbols, phase: Expression) -> Expression:
    cos, sin = wave(harmonic, phase)
    return c["cos"] * cos - c["sin"] * sin
