"""Periodic orbits by Fourier collocation and their multipliers by Hill's method, by hand.

States at N equidistant instants of the period T = k/f, N odd, satisfy D q = T rhs with the
trigonometric differentiation matrix D. The eigenvalues of T J - D are the Floquet exponents times
T, up to multiples of 2 pi i. Nothing of the package is used.
"""

import numpy as np

from helpers.by_hand.sliding import BASE, rhs

TINY = 1e-30


def differentiation_matrix(count):
    """Derivative of the trigonometric interpolant over one unit of time (Trefethen 2000, ch. 3)."""
    j = np.arange(count)
    gap = j[:, None] - j[None, :]
    with np.errstate(divide="ignore"):
        matrix = np.pi * (-1.0) ** gap / np.sin(np.pi * gap / count)
    matrix[j, j] = 0.0
    return matrix


class FourierOrbit:
    """An orbit of period k, found by Newton's method from a sampled guess."""

    def __init__(self, values, period, guess):
        self.p = {**BASE, **values}
        self.count = len(guess)
        assert self.count % 2 == 1
        self.duration = period / self.p["f"]
        self.times = np.arange(self.count) / self.count * self.duration
        self.derivative = differentiation_matrix(self.count)
        self.rate = 2 * np.pi * self.p["f"]
        self.states = np.array(guess)
        self._solve()

    def _rates(self, states):
        return self.duration * rhs(self.times, states.T, self.p).T

    def _jacobians(self):
        columns = [self._rates(self.states + 1j * TINY * unit).imag / TINY for unit in np.eye(4)]
        return np.stack(columns, axis=2)

    def _operator(self):
        matrix = np.zeros((self.count, 4, self.count, 4))
        j = np.arange(self.count)
        matrix[j, :, j, :] = self._jacobians()
        for component in range(4):
            matrix[:, component, :, component] -= self.derivative
        return matrix.reshape(4 * self.count, 4 * self.count)

    def _solve(self):
        for _ in range(12):
            residual = self._rates(self.states) - self.derivative @ self.states
            step = np.linalg.solve(self._operator(), residual.ravel()).reshape(self.count, 4)
            self.states = self.states - step
            if np.abs(step / [1, 1, self.rate, self.rate]).max() < 1e-12:
                return
        raise AssertionError("no convergence")

    @property
    def tail(self):
        """Share of the last harmonics, which tells whether N is enough."""
        spectrum = np.abs(np.fft.rfft(self.states, axis=0))
        return (spectrum[-4:] / spectrum.max(axis=0)).max()

    def exponents(self):
        """Floquet exponents times T, those whose eigenvectors hold low harmonics only."""
        values = np.linalg.eigvals(self._operator())
        return values[np.abs(values.imag) < 6 * np.pi]

    def multipliers(self):
        """Multipliers, each as often as it appears among the exponents."""
        return np.exp(self.exponents())
