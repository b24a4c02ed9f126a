"""Orbits with a critical multiplier by Fourier collocation, by hand, and curves of them.

States at N equidistant instants of the period k/f, N odd, are scaled: displacements over L, rates
over 2 pi f L. An orbit satisfies R(u) = T rhs(u) - D u = 0. A multiplier exp(i theta) is a null
vector of the linearization T J - D - i theta; for -1, D is that of antiperiodic functions and all
is real. The locus adds g = 0 of [[H, b], [c*, 0]] (v, g) = (0, 1) to R = 0. The unknowns are
z = (u, two parameters, for NS theta), and rows fix coordinates. Nothing of the package is used.
"""

from typing import NamedTuple

import numpy as np
from scipy.optimize import root_scalar

from helpers.by_hand.sliding import BASE, rhs
from helpers.fourier_collocation import differentiation_matrix

TINY = 1e-30
NUDGE = 1e-5
CIRCLE = np.exp(2j * np.pi * np.arange(32) / 32)


class Locus(NamedTuple):
    """What is followed: "LP", "PD", "NS", or "orbit" for the orbits alone."""

    kind: str
    period: int
    plane: tuple[str, str] = ("f", "Nd")
    values: tuple = ()

    def parameters(self, pair):
        """All values of the equations, two of them from the plane."""
        return {**BASE, **dict(self.values), **dict(zip(self.plane, pair, strict=True))}


def antiperiodic_matrix(count):
    """Derivative of the interpolant that changes sign after one unit of time."""
    j = np.arange(count)
    return differentiation_matrix(count) * np.cos(np.pi * (j[:, None] - j[None, :]) / count)


def rates(u, locus, pair):
    """T rhs in scaled states, shape (N, 4)."""
    p = locus.parameters(pair)
    duration, rate = locus.period / p["f"], 2 * np.pi * p["f"]
    scales = np.array([1, 1, rate, rate])
    times = np.arange(len(u)) / len(u) * duration
    return duration * rhs(times, (u * scales).T, p).T / scales


def jacobians(u, locus, pair):
    """Derivatives of the rates at each instant, shape (N, 4, 4), by complex steps."""
    columns = [rates(u + 1j * TINY * unit, locus, pair).imag / TINY for unit in np.eye(4)]
    return np.stack(columns, axis=2)


def split(z, locus):
    """States, parameters and the angle that unknowns stand for."""
    end = len(z) - 2 - (locus.kind == "NS")
    return z[:end].reshape(-1, 4), z[end : end + 2], z[-1] if locus.kind == "NS" else 0.0


def join(u, pair, *theta):
    """Unknowns from states, parameters and, for NS, the angle."""
    return np.concatenate([np.ravel(u), pair, theta])


def linearization(z, locus, derivative, theta=0.0):
    """Matrix T J - D - i theta, shape (4 N, 4 N), real without theta."""
    u, pair, _ = split(z, locus)
    j = np.arange(len(u))
    matrix = np.zeros((len(u), 4, len(u), 4), dtype=complex if theta else float)
    matrix[j, :, j, :] = jacobians(u, locus, pair) - (1j * theta if theta else 0.0) * np.eye(4)
    for component in range(4):
        matrix[:, component, :, component] -= derivative
    return matrix.reshape(u.size, u.size)


def critical_matrix(z, locus):
    """Matrix that is singular on the locus."""
    u, _, theta = split(z, locus)
    make = antiperiodic_matrix if locus.kind == "PD" else differentiation_matrix
    return linearization(z, locus, make(len(u)), theta)


def borders(z, locus):
    """Singular vectors (left, right) of the smallest singular value."""
    left, _, right = np.linalg.svd(critical_matrix(z, locus))
    return left[:, -1], right[-1].conj()


def null_vectors(z, locus, edge):
    """Right and left solutions v, w of the bordered systems, and g."""
    matrix = critical_matrix(z, locus)
    b, c = edge
    bordered = np.block([[matrix, b[:, None]], [c.conj()[None], np.zeros((1, 1))]])
    unit = np.zeros(len(bordered))
    unit[-1] = 1.0
    right = np.linalg.solve(bordered, unit)
    left = np.linalg.solve(bordered.conj().T, unit)
    return right[:-1], left[:-1], right[-1]


def gradient(z, locus, v, w):
    """Derivative of g = -w* H' v by central differences of Jacobians; complex for NS."""
    u, pair, _ = split(z, locus)
    v, w = v.reshape(-1, 4), w.conj().reshape(-1, 4)

    def bent(direction):
        step = NUDGE / np.abs(direction).max()
        ahead = jacobians(u + step * direction, locus, pair)
        behind = jacobians(u - step * direction, locus, pair)
        return np.einsum("ti,tij->tj", w, (ahead - behind) / (2 * step))

    states = bent(v.real) + (1j * bent(v.imag) if np.iscomplexobj(v) else 0.0)
    steps = NUDGE * np.eye(2)
    change = [np.subtract(*(jacobians(u, locus, pair + s) for s in (d, -d))) for d in steps]
    along = np.einsum("ti,stij,tj->s", w, change, v) / (2 * NUDGE)
    angle = [-1j * np.sum(w * v)] if locus.kind == "NS" else []
    return -join(states, along, *angle)


def equations(z, locus, edge):
    """Residual and its derivative, without the rows that fix coordinates."""
    u, pair, _ = split(z, locus)
    derivative = differentiation_matrix(len(u))
    residual = (rates(u, locus, pair) - derivative @ u).ravel()
    matrix = np.zeros((len(residual), len(z)))
    matrix[:, : u.size] = linearization(z, locus, derivative)
    steps = 1j * TINY * np.eye(2)
    along = [rates(u, locus, pair + step).imag.ravel() / TINY for step in steps]
    matrix[:, u.size : u.size + 2] = np.transpose(along)
    if locus.kind == "orbit":
        return residual, matrix
    v, w, g = null_vectors(z, locus, edge)
    row = gradient(z, locus, v, w)
    parts = (np.real, np.imag) if locus.kind == "NS" else (np.real,)
    residual = np.append(residual, [part(g) for part in parts])
    return residual, np.vstack([matrix, *(part(row) for part in parts)])


def solve(z, locus, rows, targets, tolerance=3e-12):
    """Newton's method for the equations with rows @ z = targets; the steps reach rounding."""
    edge = None if locus.kind == "orbit" else borders(z, locus)
    rows, last = np.atleast_2d(rows), np.inf
    for _ in range(15):
        residual, matrix = equations(z, locus, edge)
        full = np.concatenate([residual, rows @ z - targets])
        step = np.linalg.solve(np.vstack([matrix, rows]), full)
        z = z - step
        size = np.abs(step).max()
        if size < tolerance or (last < 1e-8 and size > 0.1 * last):
            return z
        last = size
    raise AssertionError(f"no convergence, last step {last:.1e}")


def coordinate(z, index):
    """Row that picks one unknown: -2 and -1 the plane (-3, -2, -1 the plane and theta for NS)."""
    row = np.zeros(len(z))
    row[index] = 1.0
    return row


def tangent(z, locus, rows=None):
    """Direction of the locus, in the norm of `weights`."""
    _, matrix = equations(z, locus, None if locus.kind == "orbit" else borders(z, locus))
    if rows is not None:
        matrix = np.vstack([matrix, rows])
    direction = np.linalg.svd(matrix)[2][-1]
    return direction / np.sqrt(np.sum(weights(z, locus) * direction**2))


def weights(z, locus):
    """Metric of the arclength: the mean square of the states, and the plane."""
    size = split(z, locus)[0].size
    return np.concatenate([np.full(size, 4 / size), np.ones(len(z) - size)])


def walk(z, locus, towards, steps=(0.02, 0.05), count=200, box=((0, 20), (0, 0.999)), rows=None):
    """Points of the locus by arclength, from z in the direction where towards @ z grows."""
    points, step, metric = [z], steps[0], weights(z, locus)
    direction = tangent(z, locus, rows)
    direction *= np.sign(towards @ direction)
    fixed = np.empty((0, len(z))) if rows is None else np.atleast_2d(rows)
    while len(points) < count:
        row = metric * direction
        guess = z + step * direction
        try:
            found = solve(guess, locus, [*fixed, row], [*(fixed @ z), row @ guess], 1e-9)
            turned = tangent(found, locus, rows)
            cosine = np.sum(metric * turned * direction)
            assert abs(cosine) > 0.9, "turns too fast"
        except (AssertionError, np.linalg.LinAlgError):
            step /= 2
            if step < 1e-4:
                break
            continue
        z, direction = found, turned * np.sign(cosine)
        points.append(z)
        step = min(1.4 * step, steps[1])
        limits = zip(split(z, locus)[1], box, strict=True)
        if not all(low < value < high for value, (low, high) in limits):
            break
    return points


def powers(z, locus, direction, radius=0.1):
    """B(v, v) and C(v, v, v) of the rates at each instant, v complex, by Cauchy's formula."""
    u, pair, _ = split(z, locus)
    r = radius / np.abs(direction).max()
    values = np.array([rates(u + r * turn * direction, locus, pair) for turn in CIRCLE])
    second, third = (np.tensordot(CIRCLE**-m, values, 1) / len(CIRCLE) for m in (2, 3))
    return 2 * second / r**2, 6 * third / r**3


def bilinear(z, locus, first, second):
    """B(u, v) by polarization, the vectors made equally long."""
    size = np.abs(first).max() / np.abs(second).max()
    plus, minus = (powers(z, locus, first + s * size * second)[0] for s in (1, -1))
    return (plus - minus) / (4 * size)


def critical_vectors(z, locus):
    """Null vectors v, w; v has unit length at phase zero, as the map's, and w* v = 1."""
    w, v = (vector.reshape(-1, 4) for vector in borders(z, locus))
    v = v / np.linalg.norm(v[0])
    return v, w / np.vdot(v, w)


def response_to(z, locus, forces, theta=0.0):
    """Bounded solution h of (T J - D - i theta) h + forces = 0."""
    matrix = linearization(z, locus, differentiation_matrix(len(forces)), theta)
    return -np.linalg.solve(matrix, forces.ravel()).reshape(-1, 4)


def doubling_coefficient(z, locus):
    """Coefficient b of the map's normal form at a PD: -c of a' = c a^3 per period."""
    v, w = critical_vectors(z, locus)
    second, third = powers(z, locus, v)
    bent = response_to(z, locus, second.real / 2)
    return -np.sum(w * (third / 6 + bilinear(z, locus, v, bent)).real)


def torus_coefficient(z, locus):
    """First Lyapunov coefficient of the map at an NS: growth of the amplitude a by l a^3."""
    v, w = critical_vectors(z, locus)
    still = response_to(z, locus, bilinear(z, locus, v, v.conj()))
    turning = response_to(z, locus, powers(z, locus, v)[0], 2 * z[-1])
    turns = np.array([1, 1j, -1, -1j])
    thirds = np.array([powers(z, locus, v + turn * v.conj())[1] for turn in turns])
    cubic = np.tensordot(1 / turns, thirds, 1) / 12
    bent = 2 * bilinear(z, locus, v, still) + bilinear(z, locus, v.conj(), turning)
    return 0.5 * np.real(np.vdot(w, cubic + bent))


def slope(z, locus, index, over):
    """Slope of one coordinate over another along the locus."""
    return np.divide(*tangent(z, locus)[[index, over]])


def locate(test, z, locus, index):
    """Point of the locus where test(z, locus) = 0, by secants over one coordinate."""
    held, row = [z], coordinate(z, index)

    def value(target):
        held[0] = solve(held[0], locus, row, target)
        return test(held[0], locus)

    value(root_scalar(value, x0=z[index], x1=z[index] + 1e-3, xtol=1e-11).root)
    return held[0]


def resample(u, times):
    """Trigonometric interpolant of N values over one unit of time at other times."""
    count = len(u)
    waves = np.fft.fftfreq(count, 1 / count)
    return (np.exp(2j * np.pi * np.outer(times, waves)) @ np.fft.fft(u, axis=0)).real / count


def doubled(z, locus, count, amplitude=0.02):
    """Orbit of twice the period near a PD, on the branch that is born there; first fixed."""
    u, pair, _ = split(z, locus)
    v, _ = critical_vectors(z, locus)
    twice = resample(np.vstack([v, -v]), np.arange(count) / count)
    twice *= amplitude / np.abs(twice).max()
    start = join(resample(u, 2 * np.arange(count) / count % 1), pair)
    row = join(twice, [0, 0])
    child = locus._replace(kind="orbit", period=2 * locus.period)
    guess = start + row
    return solve(guess, child, [row, coordinate(guess, -2)], [row @ guess, pair[0]])
