"""The stroboscopic map of the sliding oscillator and its derivatives, by SciPy and by hand.

States are scaled: displacements over L, rates over 2 pi f L. Derivatives along lines come from
Chebyshev interpolation of the map itself; nothing of the package is used.
"""

import numpy as np
from scipy.integrate import solve_ivp

from helpers.by_hand.dense import scales
from helpers.by_hand.sliding import BASE, integrate, rhs

NODES = np.cos(np.pi * np.arange(13) / 12)
TINY = 1e-30


class StroboscopicByHand:
    """The map over k forcing periods about one point."""

    def __init__(self, values, period, state, radius):
        self.p = {**BASE, **values}
        self.period = period
        self.scales = scales(values)
        self.center = np.asarray(state) / self.scales
        self.radius = radius

    def images(self, starts):
        """Map scaled states, shape (m, 4), all in one integration."""
        f, size = self.p["f"], self.scales[:, None]
        shape = (4, len(starts))

        def rates(phase, flat):
            states = flat.reshape(shape) * size
            return (rhs(phase / f, states, self.p) / size / f).ravel()

        solution = solve_ivp(
            rates, (0, self.period), np.asarray(starts).T.ravel(), "DOP853", rtol=1e-12, atol=1e-14
        )
        return solution.y[:, -1].reshape(shape).T

    def monodromy(self):
        """First derivative by complex steps, shape (4, 4)."""
        columns = [
            integrate((self.center + 1j * TINY * unit) * self.scales, self.p, self.period).imag
            / TINY
            / self.scales
            for unit in np.eye(4)
        ]
        return np.transpose(columns)

    def along_parameter(self, name):
        """Derivative with respect to a parameter at fixed time of the clock, by a complex step."""
        p = {**self.p, name: self.p[name] + 1j * TINY}
        return integrate(self.center * self.scales, p, self.period).imag / TINY / self.scales

    def powers(self, directions):
        """B(v, v) and C(v, v, v) for real directions, shape (m, 4) each."""
        lengths = np.linalg.norm(directions, axis=1)
        steps = self.radius / np.where(lengths > 0, lengths, 1.0)
        starts = self.center + (steps[:, None] * NODES)[:, :, None] * directions[:, None]
        ends = self.images(starts.reshape(-1, 4)).reshape(len(directions), len(NODES), 4)
        second, third = np.empty_like(directions), np.empty_like(directions)
        for row, (line, step) in enumerate(zip(ends, steps, strict=True)):
            for column in range(4):
                fit = np.polynomial.Chebyshev.fit(NODES, line[:, column], 12)
                second[row, column] = fit.deriv(2)(0.0) / step**2
                third[row, column] = fit.deriv(3)(0.0) / step**3
        return second, third

    def length(self, vector):
        """Root mean square of a vector at the points of the orbit, one a forcing period."""
        squares = [np.linalg.norm(vector) ** 2]
        for count in range(1, self.period):
            for part in (np.real(vector), np.imag(vector)):
                start = (self.center + 1j * TINY * part) * self.scales
                moved = integrate(start, self.p, count).imag / TINY / self.scales
                squares.append(moved @ moved)
        return np.sqrt(sum(squares) / self.period)

    def bilinear(self, u, v):
        """B(u, v) for complex vectors."""

        def real(a, b):
            a, b = np.real(a), np.real(b)
            if not a.any() or not b.any():
                return np.zeros(4)
            size = np.linalg.norm(b) / np.linalg.norm(a)
            plus, minus = self.powers(np.array([a * size + b, a * size - b]))[0]
            return (plus - minus) / (4 * size)

        ur, ui, vr, vi = np.real(u), np.imag(u), np.real(v), np.imag(v)
        return real(ur, vr) - real(ui, vi) + 1j * (real(ur, vi) + real(ui, vr))


def critical_vectors(map_, matrix, target):
    """Right vector of unit mean length and left one with <p, q> = 1 for the multiplier."""
    values, vectors = np.linalg.eig(matrix)
    q = vectors[:, np.abs(values - target).argmin()]
    others, left = np.linalg.eig(matrix.T)
    p = left[:, np.abs(others - target).argmin()].conj()
    q = q / map_.length(q)
    return q, p / np.vdot(q, p).conj() if np.isrealobj(p) else p / np.vdot(p, q).conj()


def coefficient(map_, kind, multiplier):
    """Coefficient of the normal form after Kuznetsov, Elements..., section 5.4.2."""
    matrix = map_.monodromy()
    identity = np.eye(4)
    q, p = critical_vectors(map_, matrix, multiplier)
    if kind == "LP":
        return 0.5 * np.real(p) @ map_.powers(np.real(q)[None])[0][0]
    if kind == "PD":
        q, p = np.real(q), np.real(p)
        second, third = map_.powers(q[None])
        bent = np.linalg.solve(identity - matrix, second[0])
        return p @ (third[0] + 3 * np.real(map_.bilinear(q, bent))) / 6
    a, b = np.real(q), np.imag(q)
    _, third = map_.powers(np.array([a, b, a + b, a - b]))
    aab = (third[2] - third[3]) / 6 - third[1] / 3
    abb = (third[2] + third[3]) / 6 - third[0] / 3
    cubic = third[0] + abb + 1j * (aab + third[1])
    still = np.linalg.solve(identity - matrix, map_.bilinear(q, q.conj()))
    turning = np.linalg.solve(multiplier**2 * identity - matrix, map_.bilinear(q, q))
    inner = cubic + 2 * map_.bilinear(q, still) + map_.bilinear(q.conj(), turning)
    return 0.5 * np.real(np.conj(multiplier) * np.vdot(p, inner))
