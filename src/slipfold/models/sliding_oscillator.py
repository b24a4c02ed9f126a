"""The source paper's structure: two degrees of freedom, sliding on a moving plate."""

from __future__ import annotations

import math
from collections.abc import Mapping

import heyoka as hy
import numpy as np
from numpy.typing import NDArray

from slipfold.errors import InputError
from slipfold.models.evaluation import evaluation_of
from slipfold.models.linear_modes import Modes, find_modes
from slipfold.models.model import Model
from slipfold.models.output import Expression, Limit, Output, Symbols
from slipfold.models.parameter import Parameter, State
from slipfold.models.sliding_outputs import SLIDING_OUTPUTS, spring_length_squared
from slipfold.models.static_point import find_static_point

__all__ = ["SlidingOscillator"]


class SlidingOscillator(Model):
    r"""Two-degree-of-freedom oscillator pressed on a moving plate by a pulsing normal force.

    .. math::

        m_1 \ddot y + c_1 \dot y + k_1 y + k_{ext}(l-L)(L+y)/l
            &= \mu N(t) (V_d \sin\alpha - \dot y)/V_{rel} \\
        m_2 \ddot x + c_2 \dot x + k_2 x + k_{ext}(l-L) x/l
            &= \mu N(t) (V_d \cos\alpha - \dot x)/V_{rel}

    with :math:`N = N_s + N_d \cos 2\pi f t`, equations (1)-(7) of the source paper. The states are
    ``x y vx vy``: x/L, y/L and their rates in 1/s. The phase is zero where N is largest.

    Parameters
    ----------
    **values
        ``k1 zeta1 f1 k2 zeta2 f2 kext L f Nd Ns mu alpha Vd`` where they differ from the paper's
        base case; SI units (``alpha`` in rad), or text with a unit (``alpha="60deg"``).

    Raises
    ------
    InputError
        For an unknown parameter, a wrong unit, a value outside its bounds or ``Nd >= Ns``.

    Examples
    --------
    >>> model = SlidingOscillator(Nd=0.1, alpha="60deg")
    >>> model.replace(f=12.2)
    SlidingOscillator(f=12.2, Nd=0.1)
    """

    name = "sliding"
    title = "structure sliding on a moving plate, 2:1 internal resonance"
    quiet = "Nd"
    states = (
        State("x", "", "horizontal displacement over L", "$x/L$"),
        State("y", "", "vertical displacement over L", "$y/L$"),
        State("vx", "1/s", "rate of x/L", r"$\dot x/L$ (1/s)"),
        State("vy", "1/s", "rate of y/L", r"$\dot y/L$ (1/s)"),
    )
    parameters = (
        Parameter("k1", 317.98, "N/m", "vertical stiffness", 0, lower_open=True, symbol="$k_1$"),
        Parameter("zeta1", 0.006, "", "vertical damping ratio", 0, symbol=r"$\zeta_1$"),
        Parameter(
            "f1",
            6.12,
            "Hz",
            "vertical natural frequency without the spring",
            0,
            lower_open=True,
            symbol="$f_1$",
        ),
        Parameter("k2", 362.58, "N/m", "horizontal stiffness", 0, lower_open=True, symbol="$k_2$"),
        Parameter("zeta2", 0.0057, "", "horizontal damping ratio", 0, symbol=r"$\zeta_2$"),
        Parameter(
            "f2",
            6.59,
            "Hz",
            "horizontal natural frequency without the spring",
            0,
            lower_open=True,
            symbol="$f_2$",
        ),
        Parameter("kext", 1000.0, "N/m", "stiffness of the coupling spring", 0, symbol="$k_{ext}$"),
        Parameter(
            "L", 5e-3, "m", "length of the unstretched spring", 0, lower_open=True, symbol="$L$"
        ),
        Parameter(
            "f", 12.5, "Hz", "frequency of the normal force", 0, lower_open=True, symbol="$f$"
        ),
        Parameter("Nd", 0.0, "N", "amplitude of the normal force's pulsation", 0, symbol="$N_d$"),
        Parameter("Ns", 1.0, "N", "static normal force", 0, lower_open=True, symbol="$N_s$"),
        Parameter("mu", 0.5, "", "friction coefficient", 0, symbol=r"$\mu$"),
        Parameter(
            "alpha",
            math.pi / 3,
            "rad",
            "direction of the plate's motion from the x axis",
            symbol=r"$\alpha$",
        ),
        Parameter("Vd", 0.6, "m/s", "speed of the plate", 0, lower_open=True, symbol="$V_d$"),
    )
    limits = (
        Limit(
            "stick",
            "Vrel_ratio",
            0.01,
            "stick: the relative speed fell to {value:.3g} of Vd; the sliding model ends here, "
            "raise Vd or stay below this value",
        ),
        Limit(
            "lost contact",
            "N",
            1e-9,
            "lost contact: the normal force fell to {value:.3g} N; keep Nd < Ns",
        ),
        Limit(
            "spring collapse",
            "l",
            1e-4,
            "spring collapsed: l/L fell to {value:.3g}; the model ends here, stay below this value",
        ),
    )

    def check(self, values: Mapping[str, float]) -> None:
        """Refuse a pulsation that would lift the tip off the plate.

        Parameters
        ----------
        values
            All parameter values by name.
        """
        if values["Nd"] >= values["Ns"]:
            raise InputError(
                f"Nd = {values['Nd']:g} N is not below Ns = {values['Ns']:g} N, so the tip would "
                "lift off the plate; give Nd < Ns"
            )

    def coefficients(self, p: Symbols) -> dict[str, Expression]:
        """Mass-normalised stiffness, damping, friction and plate velocity.

        Parameters
        ----------
        p
            The parameters by name, symbols or floats.
        """
        w1, w2 = 2 * math.pi * p["f1"], 2 * math.pi * p["f2"]
        m1, m2 = p["k1"] / (w1 * w1), p["k2"] / (w2 * w2)
        cos, sin = _trigonometry(p["alpha"])
        return {
            "L": p["L"],
            "m1": m1,
            "m2": m2,
            "damping1": 2 * p["zeta1"] * w1,
            "damping2": 2 * p["zeta2"] * w2,
            "stiffness1": w1 * w1,
            "stiffness2": w2 * w2,
            "spring1": p["kext"] / m1,
            "spring2": p["kext"] / m2,
            "mass_ratio": m2 / m1,
            "friction_static": p["mu"] * p["Ns"] / (m2 * p["L"]),
            "friction_pulsing": p["mu"] * p["Nd"] / (m2 * p["L"]),
            "plate_x": p["Vd"] * cos / p["L"],
            "plate_y": p["Vd"] * sin / p["L"],
            "Vd": p["Vd"],
            "Ns": p["Ns"],
            "Nd": p["Nd"],
            "mu": p["mu"],
        }

    def rates(self, q: Symbols, c: Symbols, phase: Expression) -> dict[str, Expression]:
        """Equations of motion (1)-(2) of the source paper, divided by mass and L.

        Parameters
        ----------
        q
            The states by name.
        c
            The coefficients by name.
        phase
            Time divided by the forcing period.
        """
        height = 1.0 + q["y"]
        stretch = 1.0 - spring_length_squared(q) ** -0.5
        slip_x, slip_y = c["plate_x"] - q["vx"], c["plate_y"] - q["vy"]
        friction = c["friction_static"] + c["friction_pulsing"] * hy.cos(2 * math.pi * phase)
        drag = friction * (slip_x * slip_x + slip_y * slip_y) ** -0.5
        return {
            "x": q["vx"],
            "y": q["vy"],
            "vx": drag * slip_x
            - c["damping2"] * q["vx"]
            - (c["stiffness2"] + c["spring2"] * stretch) * q["x"],
            "vy": c["mass_ratio"] * drag * slip_y
            - c["damping1"] * q["vy"]
            - c["stiffness1"] * q["y"]
            - c["spring1"] * stretch * height,
        }

    def period(self, p: Symbols) -> Expression:
        """Return the forcing period 1/f in seconds.

        Parameters
        ----------
        p
            The parameters by name.
        """
        return 1.0 / p["f"]

    def state_scales(self) -> NDArray[np.float64]:
        """Displacements of order L, rates of order 2 pi f."""
        rate = 2 * math.pi * self._values["f"]
        return np.array([1.0, 1.0, rate, rate])

    def outputs(self) -> tuple[Output, ...]:
        """Normal force, friction, relative speed, spring length and powers."""
        return SLIDING_OUTPUTS

    # -- quantities that do not depend on the state ----------------------------------------------

    @property
    def m1(self) -> float:
        """Vertical modal mass in kg: k1/(2 pi f1)^2."""
        return self._values["k1"] / (2 * math.pi * self._values["f1"]) ** 2

    @property
    def m2(self) -> float:
        """Horizontal modal mass in kg: k2/(2 pi f2)^2."""
        return self._values["k2"] / (2 * math.pi * self._values["f2"]) ** 2

    @property
    def c1(self) -> float:
        """Vertical damping in N s/m: 4 pi zeta1 m1 f1."""
        return 4 * math.pi * self._values["zeta1"] * self.m1 * self._values["f1"]

    @property
    def c2(self) -> float:
        """Horizontal damping in N s/m: 4 pi zeta2 m2 f2."""
        return 4 * math.pi * self._values["zeta2"] * self.m2 * self._values["f2"]

    def static_point(self) -> NDArray[np.float64]:
        """Return the state in which the tip rests under the steady drag (Nd = 0).

        Returns
        -------
        ndarray, shape (4,)
            ``x y vx vy``, the rates being zero.

        Raises
        ------
        InputError
            If the drag is more than the structure can hold.
        """
        return find_static_point(self)

    def modes(self, friction: bool = True) -> Modes:
        """Return the linear modes about the loaded static point.

        Parameters
        ----------
        friction
            Whether friction follows the motion, which adds the damping
            ``(mu Ns / Vd)(I - e e^T)``. If not, it acts as a constant load: same point, same
            stiffness. The modes of the structure without any load are those of
            ``model.replace(mu=0)``.

        Returns
        -------
        Modes
            Two modes unless one is overdamped.

        Examples
        --------
        >>> modes = SlidingOscillator().modes()
        >>> [f"{value:.4f}" for value in modes.frequency]
        ['7.1383', '12.4607']
        """
        point = self.static_point()
        changes = {"Nd": 0.0} if friction else {"Nd": 0.0, "mu": 0.0}
        model = self.replace(**changes)
        return find_modes(evaluation_of(model).jacobian(model, point), ("x", "y"))


def _trigonometry(angle: Expression) -> tuple[Expression, Expression]:
    if isinstance(angle, hy.expression):
        return hy.cos(angle), hy.sin(angle)
    return math.cos(angle), math.sin(angle)
