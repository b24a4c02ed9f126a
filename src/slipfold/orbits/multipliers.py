"""Floquet multipliers: those of a product of matrices, of orbits and of cycles, and bounds."""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce
from itertools import pairwise

import numpy as np

from slipfold.arrays import Array, Complex, Indices
from slipfold.orbits.linearization import MANY, Linearization
from slipfold.orbits.test_functions import ORBIT_TESTS, Degeneracy, floquet_multipliers


def growth_bound(blocks: Array) -> float:
    r"""Return an upper bound of :math:`\log |\mu|` over all multipliers :math:`\mu`.

    The spectral radius of the product of the segments' transition matrices is at most the product
    of their norms, here in the norm of the eigenvectors of their mean. The bound is exact where the
    coefficients of the linearized equations are constant along the orbit, and exceeds the truth by
    about what their change can do at most. If it is negative, no multiplier can be on the unit
    circle, whatever its phase.

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


class QR:
    """Tolerances of eigenvalues of products."""

    blocks: int = 16  # factors kept apart: the ratio of multipliers is spread over as many
    sweeps: int = 60  # maximum; what they leave together has moduli within a factor of two
    gap: float = 100.0  # ratio of moduli that are separated: others lose two digits at most
    separate: float = 1e-13  # turn of the basis below which subspaces are invariant
    double: float = 1e-5  # distance of two multipliers that may be one: their mean is known better
    singular: float = 700.0  # logarithm of a ratio of singular values that is infinite
    large: float = 1e4  # multiplier beside which others lose digits in the product
    # Norm of a cycle's matrix from its first node over the least from any node, above which it
    # begins at another node: three digits are lost
    larger: float = 1e3


def product_eigenvalues(matrices: Array) -> Complex:
    """Return the eigenvalues of a product of matrices, largest modulus first.

    The product itself would bury the small ones under the rounding of the large ones. Simultaneous
    iteration with a QR decomposition after every factor brings the product to block triangular
    form, with a factor of each diagonal block from each matrix (periodic Schur form: Bojanczyk,
    Golub and Van Dooren, SPIE 1770 (1992) 31-42).

    Shapes: matrices (N, n, n); returns (n,).
    """
    # There is none across the flow of a single angle.
    if not (matrices.size and np.isfinite(matrices).all()):
        return np.full(matrices.shape[1], np.nan + 0j)
    factors = [product(part) for part in np.split(matrices, _kept_apart(matrices))]
    basis = _dominant_first(product(np.array(factors)))
    groups, below = [slice(None)], np.full(len(basis) - 1, np.inf)
    for _ in range(QR.sweeps):
        start, triangles = basis, []
        for factor in factors:
            basis, triangle = np.linalg.qr(factor @ basis)
            triangles.append(triangle)
        turn = start.T @ basis
        growth = _logarithms(np.diagonal(triangles, axis1=1, axis2=2)).sum(axis=0)
        groups, below = _groups(turn, below, growth)
        if all(np.ptp(growth[group]) < np.log(QR.gap) for group in groups):
            break
    rows = np.array(triangles)
    values = [
        np.linalg.eigvals(turn[group, group] @ product(rows[:, group, group])) for group in groups
    ]
    found = np.concatenate(values).astype(complex)
    return found[np.lexsort((-found.imag, -np.round(_logarithms(found), 10)))]


def cycle_multipliers(matrices: Array, rates: Array) -> tuple[complex, Complex]:
    """Return the multiplier of a cycle's own direction and the others.

    The direction of the flow is propagated around the cycle. In bases that begin with it the
    matrices are block triangular, and the other multipliers are eigenvalues of the remaining block.
    So a fold, where another multiplier meets this one, does not cost half of the digits.

    Shapes: matrices (N, n, n); rates (N, n); returns others (n - 1,).
    """
    along, across = without_motion(matrices, rates)
    return complex(np.prod(along)), product_eigenvalues(across)


def without_motion(matrices: Array, rates: Array) -> tuple[Array, Array]:
    """Return what each matrix does along the flow, (N,), and across it, (N, n - 1, n - 1).

    Each matrix maps the direction of the flow onto that at the next node, except for errors. These
    are eliminated: where all else decays by orders of magnitude, they would dominate. The arguments
    are those of `cycle_multipliers`.
    """
    bases = motion_bases(rates)
    turned = np.roll(bases, -1, axis=0).transpose(0, 2, 1) @ matrices @ bases
    along, left = turned[:, 0, 0], turned[:, 1:, :1] * turned[:, :1, 1:]
    return along, turned[:, 1:, 1:] - left / along[:, None, None]


def motion_bases(rates: Array) -> Array:
    """Return orthonormal bases that begin with the direction of the flow, (N, n, n).

    The other vectors are Householder's reflections of the axes: smooth functions of the rates, as
    what a QR factorization returns need not be.
    """
    eye = np.eye(rates.shape[1])
    lengths = np.linalg.norm(rates, axis=1)[:, None]
    units = np.where(lengths > 0, rates / np.where(lengths > 0, lengths, 1.0), eye[0])
    signs = np.copysign(1.0, units[:, :1])
    across = units + signs * eye[0]
    bases = eye - across[:, :, None] * (across / (1.0 + np.abs(units[:, :1])))[:, None, :]
    bases[:, :, 0] = units
    return np.asarray(bases)


def product(matrices: Sequence[Array] | Array) -> Array:
    """Return the product of matrices of which the first acts first."""
    with np.errstate(over="ignore", invalid="ignore"):  # where all numbers are left, no digit is
        return reduce(lambda result, matrix: matrix @ result, matrices)


def multiplier_difference(values: Complex, others: Complex, near: float = QR.double) -> float:
    """Return the largest distance from counterparts, over the largest multiplier or one."""
    size = max(1.0, float(np.abs(values).max()))
    return float(multiplier_differences(values, others, near).max()) / size


def multiplier_differences(values: Complex, others: Complex, near: float = QR.double) -> Array:
    """Return the distance of each multiplier from its counterpart, shape (n,).

    Of some that are near each other the mean may be known better than each, and counts then.
    """
    if not (np.isfinite(values).all() and np.isfinite(others).all()):
        return np.full(len(values), np.nan)
    distances, left = list[float](), np.zeros(len(others))
    means, of_others = _means_near(values, near), _means_near(others, near)
    for value, mean in zip(values, means, strict=True):
        nearest = int(np.argmin(np.abs(others - value) + left))
        distances.append(min(abs(others[nearest] - value), abs(of_others[nearest] - mean)))
        left[nearest] = np.inf
    return np.array(distances)


def _kept_apart(matrices: Array) -> Indices:
    """Return where products of neighbors begin that lose two digits, or more if there are many.

    The root mean square of singular values over their mean says how far they are apart.
    """
    n, sizes = matrices.shape[1], np.linalg.norm(matrices, axis=(1, 2))
    with np.errstate(all="ignore"):
        apart = n * np.log(sizes / np.sqrt(n)) - np.linalg.slogdet(matrices)[1]
        total = np.cumsum(np.minimum(apart, QR.singular))
        parts = total // max(np.log(QR.gap), total[-1] / QR.blocks)
    return 1 + np.flatnonzero(np.diff(parts))


def _logarithms(values: Array | Complex) -> Array:
    return np.asarray(np.log(np.abs(values) + np.finfo(float).tiny))


def _dominant_first(product: Array) -> Array:
    """Return an orthonormal basis whose first vectors span the dominant eigenspaces."""
    values, vectors = np.linalg.eig(product)
    order = np.lexsort((values.imag < 0, -np.round(_logarithms(values), 10)))
    values, vectors = values[order], vectors[:, order]
    real = np.where(values.imag < 0, vectors.imag, vectors.real)
    # What depends on the others, in a defective matrix, is replaced by something that does not.
    return np.linalg.qr(real + 1e-14 * np.eye(len(values)))[0]


def _groups(turn: Array, before: Array, growth: Array) -> tuple[list[slice], Array]:
    """Return the parts of the basis that span invariant subspaces, and how far each part turns.

    Between moduli in the ratio `QR.gap` a sweep divides that by it: a small turn that no longer
    falls is rounding. Nearer moduli are not separated by that. Shapes: before (n - 1,), of the
    sweep before; growth (n,), logarithms of moduli.
    """
    n = len(turn)
    below = np.array([np.abs(turn[i:, :i]).max() for i in range(1, n)])
    apart = growth[:-1] - growth[1:] > np.log(QR.gap)
    rounded = apart & (below < np.sqrt(QR.separate)) & (below > 0.5 * before)
    inner = 1 + np.flatnonzero((below < QR.separate) | rounded)
    return [slice(first, last) for first, last in pairwise([0, *inner.tolist(), n])], below


def _means_near(values: Complex, near: float) -> Complex:
    beside = np.abs(values[:, None] - values) < near
    return np.asarray((beside @ values) / beside.sum(axis=1))


class Multipliers:
    """The Floquet multipliers of a forced orbit: the eigenvalues of its monodromy matrix."""

    tests: tuple[str, ...] = ORBIT_TESTS
    """Test functions along a branch, as `slipfold.orbits.test_functions` names them."""

    of_product = True
    """Whether the matrix whose eigenvalues are watched is the product of the transitions."""

    def matrix(self, part: Linearization) -> Array:
        """Return the matrix whose eigenvalues are watched, in scaled states."""
        return part.product

    def factors(self, part: Linearization) -> Array:
        """Return matrices whose product that matrix is, shape (m, n, n), in scaled states."""
        return part.factors

    def values(self, part: Linearization) -> Complex:
        """Return the eigenvalues of the matrix that is watched, largest modulus first.

        Beside a large one the product keeps no digits of the others.
        """
        values = floquet_multipliers(part.monodromy)
        if len(values) > 1 and not abs(values[0]) < QR.large:
            return product_eigenvalues(self.factors(part))
        return values

    def better(self, part: Linearization | None) -> Multipliers | None:
        """Return the same from a matrix with more digits, None if its own has enough."""
        return None

    def growth(self, part: Linearization) -> float:
        """Return an upper bound of the logarithms of the multipliers' moduli."""
        return growth_bound(part.few)

    def whole(self, multipliers: Complex) -> Complex:
        """Return the multipliers with those that are the same for all orbits, shape (n,)."""
        return multipliers


class CycleMultipliers(Multipliers):
    """The multipliers of a cycle besides that of the flow's own direction, which is one.

    They are those of the monodromy matrix on the quotient of the space by that direction. With many
    nodes the round begins at that of number `begin`.
    """

    of_product = False

    def __init__(self, begin: int = 0) -> None:
        self._begin = begin

    def better(self, part: Linearization | None) -> CycleMultipliers | None:
        """Return the same from another node, if its own matrix is much larger than the least.

        The matrices from all nodes have the same eigenvalues. Rounding moves these in proportion to
        the norm, which may differ by orders of magnitude. Of the nodes with enough digits
        that with the largest matrix is taken: there the singular values that Newton's method brings
        to zero are nearest to determinants, and change the least from one orbit to another.
        """
        if part is None or len(part.blocks) <= MANY:
            return None
        across = self._across(part)
        begins = np.linspace(0, len(across), QR.blocks, endpoint=False).astype(int)
        parts = [product(each) for each in np.split(across, begins[1:])]
        turns = [product([*parts[i:], *parts[:i]]) for i in range(len(parts))]
        with np.errstate(over="ignore", invalid="ignore"):  # such a product has no digits
            norms = np.nan_to_num(np.linalg.norm(turns, axis=(1, 2)), nan=np.inf)
            if not np.linalg.norm(self.matrix(part)) > QR.larger * norms.min():
                return None
        enough = norms <= QR.gap * norms.min()
        return CycleMultipliers(int(begins[np.where(enough, norms, 0.0).argmax()]))

    def matrix(self, part: Linearization) -> Array:
        """Return the monodromy matrix on the quotient, shape (n - 1, n - 1).

        With many nodes it is the product of the changes across the flow from one to the next:
        in the whole matrix growth on the way, and decay later, may have taken all digits.
        """
        if len(part.blocks) > MANY:
            return product(self.factors(part))
        return on_quotient(part.product, _direction(part))

    def factors(self, part: Linearization) -> Array:
        """Return matrices whose product that matrix is, shape (m, n - 1, n - 1)."""
        return np.roll(self._across(part), -self._begin, axis=0)

    def _across(self, part: Linearization) -> Array:
        """Return the same from the first node."""
        m, n = part.blocks.shape[:2]
        return without_motion(part.factors, _gauge(part)[: m * n].reshape(m, n))[1]

    def growth(self, part: Linearization) -> float:
        """Return infinity: along a cycle perturbations neither grow nor shrink."""
        return np.inf

    def whole(self, multipliers: Complex) -> Complex:
        """Return the multipliers with that of the flow's own direction, shape (n,)."""
        return np.insert(multipliers, int(np.count_nonzero(np.abs(multipliers) > 1)), 1.0)

    def lifted(self, found: Degeneracy, part: Linearization) -> tuple[Degeneracy, Array]:
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

    def propagated(self, found: Degeneracy, part: Linearization) -> tuple[Array, Array, Array]:
        r"""Propagate vectors of the quotient from node to node: growth on the way spoils none.

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
        forward, backward = (
            np.roll(vectors, self._begin, axis=1)
            for vectors in found.propagated(self.factors(part))
        )
        before = np.einsum("jab,rjb->rja", beside, forward)
        behind = np.einsum("jab,rjb->rja", np.roll(beside, -1, axis=0), backward)
        late = np.einsum("ja,jab,rjb->rj", np.roll(units, -1, axis=0), part.factors, before)
        return before, behind, np.roll(np.einsum("rj,rja->ja", late, behind), 1, axis=0)


def _gauge(part: Linearization) -> Array:
    """Direction of the flow at all nodes, then zeros, shape (m n + k,)."""
    assert part.conditions.gradients is not None
    return part.conditions.gradients[0]


def _direction(part: Linearization) -> Array:
    """Direction of the flow at the first node, shape (n,)."""
    return _gauge(part)[: part.blocks.shape[1]]


def on_quotient(matrix: Array, direction: Array) -> Array:
    """Return a matrix on the quotient of the space by one of its eigenvectors.

    Shapes: matrix (n, n); direction (n,); returns (n - 1, n - 1).
    """
    basis = motion_bases(direction[None])[0][:, 1:]
    return np.asarray(basis.T @ matrix @ basis)
