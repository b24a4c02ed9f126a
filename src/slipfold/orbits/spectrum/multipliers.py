"""Which eigenvalues say whether perturbations of an orbit grow, and what changes sign with them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array
from slipfold.orbits.linearisation import MANY, Linearisation
from slipfold.orbits.spectrum.contraction import growth_bound
from slipfold.orbits.spectrum.degeneracy import Degeneracy
from slipfold.orbits.spectrum.floquet import floquet_multipliers
from slipfold.orbits.spectrum.product import (
    motion_bases,
    product,
    product_eigenvalues,
    without_motion,
)

Values = NDArray[np.complex128]


LARGE = 1e4
"""Multipliers beside which others lose digits in the product."""


class Multipliers:
    """The Floquet multipliers of a forced orbit: the eigenvalues of its monodromy matrix."""

    tests: tuple[str, ...] = ("PD", "fold", "NS")
    """Test functions along a branch, as `slipfold.orbits.spectrum.test_functions` names them."""

    def matrix(self, part: Linearisation) -> Array:
        """Return the matrix whose eigenvalues are watched, in scaled states."""
        return part.product

    def factors(self, part: Linearisation) -> Array:
        """Return matrices whose product that matrix is, shape (m, n, n), in scaled states."""
        return part.factors

    def values(self, part: Linearisation) -> Values:
        """Return the eigenvalues of the matrix that is watched, largest modulus first.

        Beside a large one the product keeps no digits of the others.
        """
        values = floquet_multipliers(part.monodromy)
        if len(values) > 1 and not abs(values[0]) < LARGE:
            return product_eigenvalues(self.factors(part))
        return values

    def growth(self, part: Linearisation) -> float:
        """Return an upper bound of the logarithms of the multipliers' moduli."""
        return growth_bound(part.few)

    def whole(self, multipliers: Values) -> Values:
        """Return the multipliers with those that are the same for all orbits, shape (n,)."""
        return multipliers


class CycleMultipliers(Multipliers):
    """The multipliers of a cycle besides that of the flow's own direction, which is one.

    They are those of the monodromy matrix on the quotient of the space by that direction.
    """

    def matrix(self, part: Linearisation) -> Array:
        """Return the monodromy matrix on the quotient, shape (n - 1, n - 1).

        With many nodes it is the product of what happens beside the motion from one to the next:
        in the whole matrix growth on the way, and decay later, may have taken all digits.
        """
        if len(part.blocks) > MANY:
            return product(self.factors(part))
        return on_quotient(part.product, _direction(part))

    def factors(self, part: Linearisation) -> Array:
        """Return matrices whose product that matrix is, shape (m, n - 1, n - 1)."""
        m, n = part.blocks.shape[:2]
        return without_motion(part.factors, _gauge(part)[: m * n].reshape(m, n))[1]

    def growth(self, part: Linearisation) -> float:
        """Return infinity: along a cycle perturbations neither grow nor shrink."""
        return np.inf

    def whole(self, multipliers: Values) -> Values:
        """Return the multipliers with that of the flow's own direction, shape (n,)."""
        return np.insert(multipliers, int(np.count_nonzero(np.abs(multipliers) > 1)), 1.0)

    def lifted(self, found: Degeneracy, part: Linearisation) -> tuple[Degeneracy, Array]:
        r"""Return a function of the quotient's matrix as one of M, and what else changes it.

        The basis B of what is orthogonal to the flow's direction f turns with it: where
        :math:`M f = f`, the derivative of :math:`p^T B^T M B q` is
        :math:`(B p)^T dM (B q) - (B p)^T df \; (f^T M B q)`. Returned are the first term, and the
        factor of :math:`-df` in the second, shape (1, n).
        """
        direction = _direction(part)
        direction = direction / np.linalg.norm(direction)
        basis = motion_bases(direction[None])[0][:, 1:]
        lifted = Degeneracy(found.value, found.left @ basis.T, found.right @ basis.T)
        return lifted, ((direction @ part.product @ lifted.right.T) @ lifted.left)[None]

    def carried(self, found: Degeneracy, part: Linearisation) -> tuple[Array, Array, Array]:
        r"""Carry vectors of the quotient from node to node: growth on the way spoils none.

        With bases :math:`B_j` of what is orthogonal to the flow's directions :math:`f_j` the matrix
        is the product of :math:`D_j = B_{j+1}^T A_j B_j`, and the derivative of
        :math:`p_j^T D_j q_j`, since :math:`B_{j+1}^T A_j f_j = 0`, is

        .. math:: (B_{j+1} p_j)^T dA_j (B_j q_j)
                  - (B_{j+1} p_j)^T df_{j+1} \; (f_{j+1}^T A_j B_j q_j) .

        Returned are :math:`B_j q_j` and :math:`B_{j+1} p_j`, shape (r, m, n), and for unit vectors
        f the factors of :math:`-df_j`, shape (m, n).
        """
        m, n = part.blocks.shape[:2]
        rates = _gauge(part)[: m * n].reshape(m, n)
        units = rates / np.linalg.norm(rates, axis=1)[:, None]
        beside = motion_bases(rates)[:, :, 1:]
        forward, backward = found.carried(self.factors(part))
        before = np.einsum("jab,rjb->rja", beside, forward)
        behind = np.einsum("jab,rjb->rja", np.roll(beside, -1, axis=0), backward)
        late = np.einsum("ja,jab,rjb->rj", np.roll(units, -1, axis=0), part.factors, before)
        return before, behind, np.roll(np.einsum("rj,rja->ja", late, behind), 1, axis=0)


def _gauge(part: Linearisation) -> Array:
    """Direction of the flow at all nodes, then zeros, shape (m n + k,)."""
    assert part.conditions.gradients is not None
    return part.conditions.gradients[0]


def _direction(part: Linearisation) -> Array:
    """Direction of the flow at the first node, shape (n,)."""
    return _gauge(part)[: part.blocks.shape[1]]


def on_quotient(matrix: Array, direction: Array) -> Array:
    """Return a matrix on the quotient of the space by one of its eigenvectors.

    Shapes: matrix (n, n); direction (n,); returns (n - 1, n - 1).
    """
    basis = motion_bases(direction[None])[0][:, 1:]
    return np.asarray(basis.T @ matrix @ basis)
