"""A bound of all Floquet multipliers that no turning of their phases can hide."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def growth_bound(blocks: NDArray[np.float64]) -> float:
    r"""Return an upper bound of :math:`\log |\mu|` over all multipliers :math:`\mu`.

    The monodromy matrix is the product of the segments' transition matrices, so its spectral radius
    is at most the product of their norms, in any norm. That of the eigenvectors of their mean is
    taken: where the coefficients of the linearised equations do not change along the orbit, all
    segments have the same eigenvectors and the bound is exact; where they change, it exceeds the
    truth by about what their change can do at most, which is what parametric resonances live on.

    If the bound is negative, perturbations of the orbit shrink in that norm from one segment to the
    next but for little, and no multiplier can be on the unit circle, whatever its phase.

    Shapes: blocks (m, n, n).

    >>> turn = np.array([[0.0, -0.9], [0.9, 0.0]])
    >>> float(round(growth_bound(np.array([turn, turn])) / np.log(0.81), 12))
    1.0
    """
    if not np.isfinite(blocks).all():
        return np.inf
    try:
        basis = np.linalg.eig(blocks.mean(axis=0))[1]
        inside = np.linalg.inv(basis) @ (blocks @ basis)
        norms = np.linalg.svd(inside, compute_uv=False)[:, 0]
    except np.linalg.LinAlgError:
        return np.inf
    with np.errstate(divide="ignore"):
        bound = float(np.log(norms).sum())
    return bound if not np.isnan(bound) else np.inf
