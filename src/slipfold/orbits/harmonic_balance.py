"""An orbit computed again by harmonic balance, and its multipliers by Hill's determinant."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Annotated

import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array, Complex
from slipfold.flow.flow import flow_of
from slipfold.models.model import Model, evaluation_of
from slipfold.orbits.check import is_singular
from slipfold.orbits.multipliers import multiplier_difference
from slipfold.read_only import ReadOnly
from slipfold.text import OneLine, PrintedTable


class BALANCE:
    """How many harmonics, how Newton's method ends, and what counts as zero."""

    fewest: int = 8  # harmonics of a forcing period that are kept in any case
    guess: int = 2048  # samples of a forcing period for the first guess: resolve 1,000 harmonics
    samples: int = 6  # samples a harmonic: products of two series are free of aliasing from 4
    more: float = 1.5  # factor by which harmonics grow; the change by it is their error
    spare: float = 0.1  # part of the tolerance at which that change ends the growth
    steps: int = 12  # of Newton's method: from a guess that is nearly exact, 2 to 4 suffice
    close: float = 1e-11  # step in scaled states at which it ends: rounding is 1e-13 and more
    rank: float = 1e-12  # singular value, over the largest, of forces that do not vary
    many: int = 12  # states from which only multipliers are computed that may become critical:
    decided: float = 0.1  # those of this modulus and more; each takes as long as the series
    sweeps: int = 8  # over the multipliers; from values right to 1e-8 the second changes nothing
    shrinks: float = 0.1  # ratio of steps; with more, another center may be the right one
    certain: float = 1e-4  # step of a multiplier's logarithm at which its harmonics are the right
    together: float = 1e-4  # relative distance of multipliers that count as one: half the digits
    ring: float = 1e-2  # relative radius of a circle about those, and points on it: at one tenth
    points: int = 8  # of it their own distances are seen to 1e-8, at ten times it others not
    regular: float = 1e6  # condition of the eigenvectors beyond which matrices are solved instead


@dataclass(frozen=True, eq=False, repr=False)
class HarmonicBalance(OneLine, ReadOnly):
    r"""A periodic orbit as a Fourier series, and how far another method is from it; frozen.

    Examples
    --------
    >>> import slipfold as sf
    >>> duffing = sf.built_in_models()["duffing"](W=0.5)
    >>> found = sf.periodic_orbit(duffing).harmonic_balance()
    >>> found.passed, len(found.harmonics) - 1
    (True, 13)
    """

    model: Annotated[Model, "The model; of a cycle, its ``duration`` is that of the guess."]
    period: Annotated[int, "Period in forcing periods, or revolutions of a cycle."]
    harmonics: Annotated[
        NDArray[np.complex128],
        r"Complex coefficients :math:`X_h` of the states in their own units, h = 0 ... H, shape "
        r"(H + 1, n_states): :math:`x = X_0 + 2 \mathrm{Re} \sum_h X_h e^{2 \pi i h t / T}` with "
        r"the duration T of the whole orbit.",
    ]
    seconds: Annotated[float, "Duration of the whole orbit in seconds."]
    floquet: Annotated[
        NDArray[np.complex128],
        "Floquet multipliers by Hill's determinant, in the order of the orbit's, shape "
        "(n_states,). Those below a tenth of the tolerance are the orbit's own, of 12 states "
        "and more all below 0.1.",
    ]
    truncation: Annotated[
        float,
        "How much the states at the nodes (scaled) and the multipliers (as below) change from "
        "two thirds of the harmonics to all; a tenth of the tolerance where harmonics suffice. "
        "More if rounding changes multipliers by more, or if harmonics of the Jacobian times the "
        "duration are larger that samples hardly resolve, as where it jumps. Infinite where "
        "Newton's method did not converge.",
    ]
    states: Annotated[
        float, "Largest difference of the states at the orbit's nodes, in scaled states."
    ]
    duration: Annotated[float, "Difference of the durations, as a fraction."]
    multipliers: Annotated[
        float,
        "Largest difference of the multipliers, as a fraction of the largest or of one; those "
        "that coincide are compared by their mean.",
    ]
    tolerance: Annotated[float, "What is allowed of each."]

    @property
    def passed(self) -> bool:
        """Whether truncation and differences are within the tolerance."""
        return self.to <= self.tolerance

    @property
    def to(self) -> float:
        """What both methods agree to: the largest of truncation and differences."""
        differences = [self.truncation, self.states, self.duration, self.multipliers]
        return float(np.max(differences))  # NaN if any is

    def sample(self, count: int = 256) -> NDArray[np.float64]:
        """Sample the states over one period.

        Parameters
        ----------
        count
            How many samples, from the beginning of the period.

        Returns
        -------
        ndarray, shape (count, n_states)
            States at the times ``seconds * j / count``.
        """
        return _at(self.harmonics, np.arange(count) / count)

    def _line(self) -> str:
        return f"HarmonicBalance of {self.model.name}: {self}"

    def _rows(self) -> PrintedTable:
        names = ("truncation", "states", "duration", "multipliers", "tolerance")
        lines = [[name, f"{getattr(self, name):.1e}"] for name in names]
        return PrintedTable(["", "difference"], lines, ("",))

    def __str__(self) -> str:
        """Say it in a sentence."""
        series = f"harmonic balance with {len(self.harmonics) - 1} harmonics"
        if not np.isfinite(self.to):
            return f"{series} did not converge"
        verdict = "within" if self.passed else "not within"
        return (
            f"{series}: states differ by {self.states:.1e}, the duration by {self.duration:.1e}, "
            f"multipliers by {self.multipliers:.1e}, the harmonics left out by "
            f"{self.truncation:.1e}, {verdict} {self.tolerance:.0e}"
        )


def balance(
    model: Model,
    nodes: Array,
    period: int,
    given: Complex,
    samples: Array,
    tolerance: float,
    largest: int,
) -> HarmonicBalance:
    """Find the periodic orbit near another by harmonic balance, and multipliers near given ones.

    Newton's method starts from the orbit's Fourier coefficients. Harmonics are added until half as
    many again change less than a tenth of the tolerance, or the condensed equations are `largest`.

    Shapes: nodes (m, n); given (n,); samples (M, n), over the period.
    """
    scales, duration = model.state_scales(), period * flow_of(model).constants_of(model).period
    guess = np.fft.rfft(samples / scales, axis=0) / len(samples)
    tails = np.cumsum(2 * np.abs(guess).max(axis=1)[::-1])[::-1]  # of a harmonic and all above it
    forces = _Equations(model, period, guess[: 2 * BALANCE.fewest], duration).inputs.shape[1]
    most = min(int((largest / max(forces, 1) - 1) / 2), len(guess) - 1)
    seen = max(BALANCE.spare * tolerance, 2 * tails[len(tails) // 2])  # beyond errors of the guess
    seen = max(int(np.count_nonzero(tails >= seen)), BALANCE.fewest * period)
    # At a fold or branch point, of cycles besides the multiplier of their own direction
    singular = is_singular(given, 0 if model.forced else 1)
    phases: Array = np.arange(len(nodes)) / len(nodes)
    count = min(seen, int(most / BALANCE.more))
    size = max(1.0, float(np.abs(given).max()))
    own = BALANCE.decided if len(scales) >= BALANCE.many else BALANCE.spare * tolerance
    fine = _solve(model, period, guess[: count + 1], duration, singular=singular)
    while True:
        coarse, count = fine, min(int(BALANCE.more * count) + 1, most)
        start = guess[: count + 1].copy()
        if coarse.converged:
            start[: len(coarse.harmonics)], start[len(coarse.harmonics) :] = coarse.harmonics, 0
        fine = _solve(model, period, start, coarse.duration, singular=singular)
        found = _at(fine.harmonics, phases)
        left_out = float(np.abs(_at(coarse.harmonics, phases) - found).max())
        settled = coarse.converged and fine.converged and left_out <= BALANCE.spare * tolerance
        if settled or count == most:
            before, multipliers = (_multipliers(one, given, own) for one in (coarse, fine))
            apart = multiplier_difference(before, multipliers)
            left_out = float(np.max([left_out, apart]))  # NaN if it is not known
            if not left_out > BALANCE.spare * tolerance or count == most:
                break
    left_out = float(np.max([left_out, fine.rounding / size, fine.unresolved]))
    return HarmonicBalance(
        model,
        period,
        fine.harmonics * scales,
        fine.duration,
        multipliers,
        max(left_out, fine.excess) if coarse.converged and fine.converged else np.inf,
        float(np.abs(nodes / scales - found).max()),
        abs(fine.duration / duration - 1),
        multiplier_difference(given, multipliers),
        tolerance,
    )


def _at(harmonics: Complex, phases: Array) -> Array:
    """Evaluate a series at fractions of its period. Shapes: (H + 1, n), (m,) -> (m, n)."""
    turned = np.exp(2j * np.pi * np.outer(phases, np.arange(len(harmonics))))
    turned[:, 1:] *= 2
    return np.asarray((turned @ harmonics).real)


class _Equations:
    r"""The equations of harmonic balance about a series of scaled states.

    With :math:`\tau = t/T` the states satisfy :math:`x' = T f(x, \tau)`. The Jacobian is
    :math:`A + B E(\tau) C` with its mean A and as few columns of B and rows of C as forces and
    motions vary: those at contacts. Linear equations in all harmonics are so condensed to the
    harmonics of these forces, as receptances do.
    """

    def __init__(self, model: Model, period: int, harmonics: Complex, duration: float) -> None:
        self.harmonics, self.duration = harmonics, duration
        self.converged, self.excess = False, 0.0
        self.orders = np.arange(1 - len(harmonics), len(harmonics))  # -H ... H
        count = 1 << int(np.ceil(np.log2(BALANCE.samples * len(harmonics))))
        phases, scales = np.arange(count) / count, model.state_scales()
        states = np.fft.irfft(_padded(harmonics, count), count, axis=0) * count
        rates, jacobians = evaluation_of(model).linear(model, states * scales, phases * period)
        self.rates = np.fft.fft(rates / scales, axis=0)[self.orders] * (duration / count)
        jacobians = jacobians * (duration * scales / scales[:, None])
        self.mean = jacobians.mean(axis=0)
        varying, n = jacobians - self.mean, len(scales)
        small = BALANCE.rank * max(float(np.abs(jacobians).max()), 1e-300)
        self.inputs = _range(varying.transpose(1, 0, 2).reshape(n, -1), small)  # (n, b)
        self.motions = _range(varying.transpose(2, 0, 1).reshape(n, -1), small).T  # (c, n)
        varying = self.inputs.T @ varying @ self.motions.T
        spectrum = np.fft.fft(varying, axis=0) / count
        # The mean has an error of the harmonic `count`: as a power of the order from these to it.
        bands = np.split(np.abs(spectrum[: count // 2]), 8)
        low, high = (bands[i].max(initial=0.0) for i in (3, 7))
        self.unresolved = float(high * (high / max(low, 1e-300)))
        self.spectrum = spectrum[self.orders[:, None] - self.orders]  # (2 H + 1, 2 H + 1, b, c)

    @cached_property
    def _modes(self) -> tuple[Complex, Complex, Complex] | None:
        """Eigenvalues, eigenvectors and their inverse of the mean; None where ill conditioned."""
        values, vectors = np.linalg.eig(self.mean)
        if not np.linalg.cond(vectors) < BALANCE.regular:
            return None
        return values, vectors, np.linalg.inv(vectors)

    @property
    def rounding(self) -> float:
        """What rounding makes of multipliers, by the conditions of the mean's eigenvalues.

        They are those of the balanced matrix, as LAPACK takes it.
        """
        from scipy.linalg import matrix_balance  # slow to import, and for checks alone

        balanced = matrix_balance(self.mean)[0]
        values, vectors = np.linalg.eig(balanced)
        if not np.linalg.cond(vectors) < 1 / np.finfo(float).eps:
            return 0.0  # not known
        left = np.linalg.inv(vectors)
        conditions = np.linalg.norm(left, axis=1) * np.linalg.norm(vectors, axis=0)
        error = np.finfo(float).eps * len(values) * np.linalg.norm(balanced, 2)
        return float((error * conditions * np.exp(values.real)).max())

    @property
    def exponents(self) -> Complex:
        """Eigenvalues of the mean, shape (n,)."""
        return np.linalg.eigvals(self.mean) if self._modes is None else self._modes[0]

    def answered(self, shift: complex, right: Array | Complex) -> Complex:
        """Solve ``(shift + 2 pi i h - A) X_h = R_h``. Shapes: right (1 or 2 H + 1, n, k)."""
        turns = (shift + 2j * np.pi * self.orders)[:, None, None]
        if self._modes is None:
            unit = np.eye(len(self.mean))
            each = np.broadcast_to(right, (len(turns), *right.shape[1:]))
            return np.asarray(np.linalg.solve(turns * unit - self.mean, each))
        values, vectors, inverse = self._modes
        return vectors @ ((inverse @ right) / (turns - values[:, None]))

    def condensed(self, answers: Complex) -> Complex:
        """Return harmonics of the forces that motions with the answers (2 H + 1, n, k) make.

        Shapes: returns ((2 H + 1) b, (2 H + 1) k), by force and by harmonic that was answered.
        """
        forces = np.einsum("hkbc,kcd->hbkd", self.spectrum, self.motions @ answers, optimize=True)
        h, b, k, d = forces.shape
        return forces.reshape(h * b, k * d)

    def solved(
        self, lacking: Complex, rows: list[Complex], columns: list[Complex], ahead: list[float]
    ) -> tuple[Complex, Array]:
        """Return Newton's step of the harmonics and of as many numbers as there are columns.

        A number times its column is added to what is lacking, so that the step has the product
        `ahead` with the row. Shapes: lacking, rows and columns (2 H + 1, n).
        """
        own = self.answered(0.0, np.stack([lacking, *columns], axis=2))
        count, (n, b) = len(self.orders), self.inputs.shape
        inputs = self.answered(0.0, self.inputs[None])
        acting = self.condensed(own).reshape(count * b, count, 1 + len(columns)).sum(axis=1)
        across = np.reshape(rows, (len(rows), count, n)).conj()
        held = np.einsum("rhn,hnb->rhb", across, inputs).reshape(len(rows), count * b)
        ends = np.einsum("rhn,hnk->rk", across, own)
        matrix = np.eye(count * b) - self.condensed(inputs)
        bordered = np.block([[matrix, -acting[:, 1:]], [held, ends[:, 1:]]])
        found = np.linalg.solve(bordered, np.append(acting[:, 0], np.array(ahead) - ends[:, 0]))
        forces, numbers = found[: count * b].reshape(count, b, 1), found[count * b :].real
        return own[..., 0] + own[..., 1:] @ numbers + (inputs @ forces)[..., 0], numbers

    def slope(self, shift: complex) -> np.complex128:
        """Return the logarithmic derivative of Hill's determinant at an exponent."""
        inputs = self.answered(shift, self.inputs[None])
        matrix = np.eye(len(self.orders) * self.inputs.shape[1]) - self.condensed(inputs)
        moved = self.condensed(self.answered(shift, inputs))
        return np.complex128(np.trace(np.linalg.solve(matrix, moved)))


def _padded(harmonics: Complex, count: int) -> Complex:
    padded = np.zeros((count // 2 + 1, harmonics.shape[1]), complex)
    padded[: len(harmonics)] = harmonics
    return padded


def _range(matrix: Array, small: float) -> Array:
    """Return an orthonormal basis of the columns, largest first. Shapes: (n, m) -> (n, rank)."""
    found: list[Array] = []
    while len(found) < len(matrix):
        largest = matrix[:, (matrix * matrix).sum(axis=0).argmax()]
        if not np.linalg.norm(largest) > small:
            break
        for other in found:  # once more: what was subtracted from a small column left rounding
            largest = largest - other * (other @ largest)
        found.append(largest / np.linalg.norm(largest))
        matrix = matrix - np.outer(found[-1], found[-1] @ matrix)
    return np.array(found).reshape(-1, len(matrix)).T


def _solve(
    model: Model, period: int, harmonics: Complex, duration: float, *, singular: bool
) -> _Equations:
    """Solve the equations by Newton's method.

    A cycle has its duration as one more unknown, and keeps its place along itself. At a fold or
    branch point a force that must vanish is added, and the place along the branch is kept.
    """
    first, excess, force = _whole(harmonics), 0.0, np.zeros((0, 0), complex)
    turns = 2j * np.pi * np.arange(1 - len(harmonics), len(harmonics))[:, None]
    rows = [] if model.forced else [turns * first]
    following = _Equations(model, period, harmonics, duration)
    for _ in range(BALANCE.steps):
        equations = following
        columns = [] if model.forced else [equations.rates]
        if singular and not force.size:
            force = _any(*harmonics.shape)
            nothing = [0.0] * len(columns)
            open_, _ = equations.solved(0 * first, [*rows, force], [*columns, force], [*nothing, 1])
            rows.append(open_ / np.linalg.norm(open_))
        whole, lacking = _whole(harmonics), equations.rates - turns * _whole(harmonics)
        if singular:
            columns, lacking = [*columns, force], lacking + excess * force
        ahead = [float((row.conj() * (first - whole)).real.sum()) for row in rows]
        step, numbers = equations.solved(lacking, rows, columns, ahead)
        harmonics = harmonics + step[len(harmonics) - 1 :]
        harmonics[0] = harmonics[0].real
        longer = 0.0 if model.forced else float(numbers[0])
        duration *= 1 + longer
        excess += float(numbers[-1]) if singular else 0.0
        equations.harmonics, equations.duration, equations.excess = harmonics, duration, abs(excess)
        equations.converged = bool(np.abs(step).sum(axis=0).max() + abs(longer) < BALANCE.close)
        if equations.converged:
            break
        following = _Equations(model, period, harmonics, duration)
        if not np.isfinite(following.mean).all():
            break
    return equations


def _any(count: int, n: int) -> Complex:
    """Return harmonics of a force of unit length without a symmetry, shape (2 count - 1, n)."""
    half = np.exp(1j * np.arange(count * n)).reshape(count, n)
    half /= 1 + np.arange(count)[:, None] ** 2
    half[0] = half[0].real
    return np.asarray(_whole(half) / np.linalg.norm(_whole(half)))


def _whole(harmonics: Complex) -> Complex:
    """Return the coefficients from -H to H."""
    return np.concatenate([harmonics[:0:-1].conj(), harmonics])


def _multipliers(equations: _Equations, given: Complex, negligible: float) -> Complex:
    r"""Return the multipliers near given ones, by Newton's method for all at once.

    Hill's determinant D(s) has a pole where s is an exponent :math:`\lambda_j` of the mean
    Jacobian, and a zero at each of the orbit, so that :math:`D \prod_j (\mu - e^{\lambda_j})` with
    :math:`\mu = e^s` is the characteristic polynomial. Dividing by the other roots makes each
    iterate find a root of its own, as in the method of Ehrlich and Aberth.

    Multipliers below `negligible` are taken as given. If the product of all is less than
    Liouville's formula states, one of them is larger, and NaN is returned.

    References
    ----------
    L. Guillot, A. Lazarus, O. Thomas, C. Vergez and B. Cochelin, A purely frequency based
    Floquet-Hill formulation for the efficient stability computation of periodic solutions of
    ordinary differential systems, Journal of Computational Physics 416 (2020) 109477.
    """
    exponents = equations.exponents
    with np.errstate(all="ignore"):
        # No float is smaller than exp(-745).
        sums = [np.log(np.abs(given)), exponents.real]
        product, expected = (np.maximum(logarithms, -745).sum() for logarithms in sums)
        lost = product < expected - np.log(10)
        if lost or not equations.converged:
            return np.full(len(given), np.nan, complex)
        if not equations.inputs.size:
            return np.exp(exponents)
        found = given.astype(complex)
        wanted = np.flatnonzero((np.abs(given) > negligible) & (given.imag >= 0))
        centers, last = np.full(len(given), np.nan), np.full(len(given), np.inf)
        for _ in range(BALANCE.sweeps):
            largest = 0.0
            for i in wanted:
                pair = found == found[i].conj()
                near = np.abs(given - given[i]) < BALANCE.together * abs(given[i])
                if near.sum() > 1:
                    step = _mean_step(equations, exponents, found, near)
                else:
                    known = float(centers[i]), float(last[i])
                    others = found[~near]
                    step, centers[i] = _root_step(equations, exponents, found[i], others, *known)
                last[i] = abs(step)
                found[i] *= np.exp(step)
                if given[i].imag:
                    found[pair] = found[i].conj()
                largest = max(largest, abs(step * found[i]))
            if largest < BALANCE.close:
                break
    return found


def _root_step(
    equations: _Equations,
    exponents: Complex,
    multiplier: complex,
    others: Complex,
    known: float,
    last: float,
) -> tuple[np.complex128, float]:
    """Return the change of a multiplier's logarithm, and where its harmonics are centered.

    The harmonics of a perturbation are centered at an exponent of the mean. Centered elsewhere, the
    determinant does not resolve a fast mode. The known center of the last step comes first, as long
    as steps shrink; then exponents of near multipliers.
    """
    poles = np.exp(exponents)
    apart = _slope_of_product(multiplier, poles) - _slope_of_product(multiplier, others)
    centers = np.round(exponents.imag / (2 * np.pi))
    nearest = centers[np.argsort(np.abs(poles - multiplier), kind="stable")].tolist()
    steps: dict[float, np.complex128] = {}
    enough = max(BALANCE.close, min(BALANCE.certain, BALANCE.shrinks * last))
    for center in dict.fromkeys(nearest if np.isnan(known) else [known, *nearest]):
        slope = apart + equations.slope(np.log(multiplier) + 2j * np.pi * center)
        steps[center] = -1 / slope
        if abs(steps[center]) < enough:
            break
    at = min(steps, key=lambda center: abs(steps[center]))
    beside = [center for center in steps if center != known]
    if at == known and abs(steps[at]) >= enough and beside:  # no progress: another may be right
        other = min(beside, key=lambda center: abs(steps[center]))
        at = other if abs(steps[other]) < BALANCE.certain / BALANCE.shrinks else at
    return steps[at], at


def _mean_step(
    equations: _Equations, exponents: Complex, found: Complex, near: NDArray[np.bool_]
) -> np.complex128:
    """Return the mean change of logarithms of multipliers that coincide; NaN if not all do.

    Each of them alone is known to half the digits, their number and sum from a circle to all.
    """
    center, poles = found[near].mean(), np.exp(exponents)
    shift = np.log(center) + 2j * np.pi * np.round(
        exponents.imag[np.abs(poles - center).argmin()] / (2 * np.pi)
    )
    turned = BALANCE.ring * np.exp(2j * np.pi * np.arange(BALANCE.points) / BALANCE.points)
    slopes = np.array(
        [
            equations.slope(shift + part)
            + _slope_of_product(center * np.exp(part), poles)
            - _slope_of_product(center * np.exp(part), found[~near])
            for part in turned
        ]
    )
    count, moved = (slopes * turned).mean(), (slopes * turned**2).mean()
    right = abs(count - near.sum()) < 0.1
    return np.complex128(moved / near.sum() if right else np.nan)


def _slope_of_product(value: complex, zeros: Complex) -> np.complex128:
    """Return the logarithmic derivative of a polynomial with these zeros by the logarithm."""
    apart = value - zeros
    return np.complex128((value / np.where(apart == 0, 1e-16 * value, apart)).sum())
