"""Points of codimension two of textbook oscillators, by SciPy and by hand.

The map over one period 2 pi/w of q'' = force(t, q, v, w, a) is differentiated by its variational
equations; derivatives of those are complex steps. Nothing of the package is used.
"""

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import root

TINY = 1e-30


def duffing(t, q, v, w, a):
    """Force and its derivatives with respect to q and v."""
    return a * np.cos(w * t) - 0.05 * v - q - 0.1 * q**3, -1 - 0.3 * q**2, -0.05


def van_der_pol(t, q, v, w, a, e=0.2):
    """The same with e the strength of the damping."""
    return (
        a * np.cos(w * t) + e * (1 - q**2) * v - q,
        -2 * e * q * v - 1,
        e * (1 - q**2),
    )


def stroboscopic(force, state, w, a):
    """Image after one period and its matrix; everything may be complex."""
    duration = 2 * np.pi / w

    def rates(s, y):
        q, v, b, d = y[0], y[1], y[2:4], y[4:6]
        acceleration, by_q, by_v = force(s * duration, q, v, w, a)
        return duration * np.concatenate([[v, acceleration], d, by_q * b + by_v * d])

    start = np.concatenate([state, [1.0, 0.0, 0.0, 1.0]]).astype(complex)
    found = solve_ivp(rates, (0, 1), start, "DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
    return found[:2], found[2:].reshape(2, 2)


def cusp_equations(force, unknown):
    """Fixed point, fold, and the fold's condition not growing along the critical direction."""
    state, w, a = unknown[:2], *unknown[2:]
    image, matrix = stroboscopic(force, state, w, a)
    fold = matrix.real - np.eye(2)
    direction = np.linalg.svd(fold)[2][-1]
    # Towards one side always: the equations must be continuous.
    direction = direction * np.sign(direction[np.abs(direction).argmax()])
    _, bent = stroboscopic(force, state + 1j * TINY * direction, w, a)
    det = np.linalg.det(bent - np.eye(2))
    return [*(image.real - state), np.linalg.det(fold), det.imag / TINY]


def resonance_equations(force, unknown):
    """Fixed point with a double multiplier at one."""
    image, matrix = stroboscopic(force, unknown[:2], *unknown[2:])
    return [
        *(image.real - unknown[:2]),
        np.trace(matrix).real - 2,
        np.linalg.det(matrix).real - 1,
    ]


def solve(equations, force, guess):
    """State, w and a at which the equations hold."""
    found = root(lambda unknown: equations(force, unknown), guess, tol=1e-12)
    assert np.abs(found.fun).max() < 1e-10, found.message
    return found.x
