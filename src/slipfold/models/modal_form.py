"""Equations of motion as modes, and forces that depend on a few motions."""

from __future__ import annotations

from dataclasses import dataclass

from slipfold.arrays import Array
from slipfold.models.quantities import Expression


@dataclass(frozen=True, eq=False)
class ModalForm:
    r"""Modes that forces excite, where the forces depend on motions at a few places.

    .. math::

        \ddot m_i + d_i \dot m_i + \omega_i^2 m_i = \sum_k B_{ik} f_k(y, t), \qquad
        y = C \begin{pmatrix} m \\ \dot m \end{pmatrix}

    The states of the model are r displacements, ``shapes @ m``, and their rates.
    """

    squares: Array  # squares of circular frequencies in 1/s^2, shape (r,)
    # Parts of d in 1/s, shape (r,), each with the name of its factor among the coefficients
    dampings: tuple[tuple[str | None, Array], ...]
    # Displacements of modes, and the inverse, shape (r, r)
    shapes: Array
    into: Array
    motions: tuple[Expression, ...]  # symbols of y, length n_y
    rows: Array  # C, shape (n_y, 2 r)
    forces: tuple[Expression, ...]  # f in motions, coefficients and phase, length n_f
    inputs: Array  # B, shape (r, n_f)
    # Spatio-temporal symmetry x(t + 1/m) = R x(t) of modes, t in forcing periods: m and R, (r, r)
    symmetry: tuple[int, Array] | None = None
