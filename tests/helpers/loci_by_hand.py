"""Loci of LP, PD and NS in two parameters by Fourier collocation, by hand; makes loci.json.

States at N equidistant instants of the period k/f, N odd, are scaled: displacements over L, rates
over 2 pi f L. An orbit satisfies R(u) = T rhs(u) - D u = 0. A multiplier exp(i theta) is a null
vector of the linearization T J - D - i theta; for -1, D is that of antiperiodic functions and all
is real. The locus adds g = 0 of [[H, b], [c*, 0]] (v, g) = (0, 1) to R = 0. The unknowns are
z = (u, two parameters, for NS theta), and rows fix coordinates. The folds of period 1, where the
spring nearly collapses, are found by multiple shooting. Nothing of the package is used.
"""

import json
from contextlib import suppress
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import root_scalar

from helpers.fourier_collocation import differentiation_matrix
from helpers.sliding_by_hand import BASE, rhs

FILE = Path(__file__).parents[1] / "reference" / "loci.json"

TINY = 1e-30
NUDGE = 1e-5
CIRCLE = np.exp(2j * np.pi * np.arange(32) / 32)
SEGMENTS = 8


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


def shot(z, f):
    """Gaps between the segments of an orbit of period 1 and their derivative; z ends with Nd."""
    p = {**BASE, "f": f, "Nd": z[-1] + 1j * TINY * np.eye(5)[4]}
    scales = np.array([1, 1, 2 * np.pi * f, 2 * np.pi * f])[:, None]

    def motion(phase, flat):
        return (rhs(phase / f, flat.reshape(4, 5) * scales, p) / scales / f).ravel()

    states = z[:-1].reshape(SEGMENTS, 4)
    gaps = -np.roll(states, -1, axis=0)
    matrix = np.hstack([-np.eye(4 * SEGMENTS, k=4), np.zeros((4 * SEGMENTS, 1))])
    matrix[-4:, :4] = -np.eye(4)
    for i, state in enumerate(states):
        span = i / SEGMENTS, (i + 1) / SEGMENTS
        start = (state[:, None] + 1j * TINY * np.eye(4, 5)).ravel()
        found = solve_ivp(motion, span, start, method="DOP853", rtol=1e-13, atol=1e-15)
        final = found.y[:, -1].reshape(4, 5)
        gaps[i] += final[:, 0].real
        matrix[4 * i : 4 * i + 4, [*range(4 * i, 4 * i + 4), -1]] += final.imag / TINY
    return gaps.ravel(), matrix


def shooting_fold(z, f):
    """Fold in Nd: where the tangent has no part along Nd, by secants over the arclength."""
    held, row = [z], np.linalg.svd(shot(z, f)[1])[2][-1]

    def value(position):
        z = held[0]
        for _ in range(12):
            gaps, matrix = shot(z, f)
            square = np.vstack([matrix, row])
            step = np.linalg.solve(square, np.append(gaps, row @ z - position))
            z = z - step
            if np.abs(step).max() < 1e-9:
                held[0] = z
                return np.linalg.solve(square, np.append(0 * gaps, 1.0))[-1]
        raise AssertionError("no convergence")

    start = row @ z
    value(root_scalar(value, x0=start, x1=start + 1e-4, xtol=1e-8).root)
    return held[0]


def entries(points, locus):
    """Points as they are written: the plane, the angle of an NS, the state at phase zero."""
    listed = []
    for z in points:
        u, pair, theta = split(z, locus)
        point = dict(zip(locus.plane, map(float, pair), strict=True))
        if locus.kind == "NS":
            point["theta"] = float(theta)
        rate = 2 * np.pi * locus.parameters(pair)["f"]
        listed.append(point | {"state": (u[0] * [1, 1, rate, rate]).tolist()})
    return listed


def at(points, locus, index, *values):
    """Points of the locus where a coordinate has one of the values, from those of a walk."""
    found = []
    for value in values:
        gaps = [(z, z[index] - value) for z in points]
        near = [z for (z, a), (_, b) in pairwise(gaps) if a * b < 0 or a == 0]
        found += [solve(z, locus, coordinate(z, index), value) for z in near]
    return found


def zeros(test, points, locus, index):
    """Points where a test changes its sign along a walk."""
    values = [(z, test(z, locus)) for z in points]
    found = [z for (z, a), (_, b) in pairwise(values) if a * b < 0]
    return [locate(test, z, locus, index) for z in found]


def extremes(points, locus, index):
    """Points where a coordinate is extreme, found over the state that changes most."""
    found = []
    for before, z, after in zip(points, points[1:], points[2:], strict=False):
        if (z[index] - before[index]) * (after[index] - z[index]) < 0:
            over = int(np.argmax(np.abs(tangent(z, locus)[: split(z, locus)[0].size])))
            found.append(locate(partial(slope, index=index, over=over), z, locus, over))
    return found


def both_ways(z, locus, index, **keys):
    """Walk in both directions of a coordinate, as one list."""
    there, back = (walk(z, locus, s * coordinate(z, index), **keys) for s in (-1, 1))
    return there[::-1] + back[1:]


def moved(z, old, new, value):
    """The same point in another plane, its first parameter there given."""
    z, index = z.copy(), -3 if old.kind == "NS" else -2
    z[index] = value
    return solve(z, new, coordinate(z, index), value)


def from_rest(f, count, rest=(0.117402977126, 0.061106649797, 0, 0)):
    """Orbits of period 1 from Nd = 0 on."""
    locus = Locus("orbit", 1)
    z = join(np.tile(rest, (count, 1)), [f, 0.0])
    return walk(z, locus, coordinate(z, -1), rows=coordinate(z, -2), count=60)


def pd_period_1():
    """PD of period 1: the walk; points with b, the least Nd, and mu Ns = 0.3 N in two ways."""
    locus = Locus("PD", 1)
    z = min(from_rest(12.5, 61), key=lambda z: abs(z[-1] - 0.04))
    start = solve(z, locus, coordinate(z, -2), 12.5)
    walked = both_ways(start, locus, -2)
    values = 11.8, 12.1, 12.35, 12.4, 12.45, 12.5, 12.55, 12.7, 13.0, 13.3, 14.0, 14.3
    points = at(walked, locus, -2, *values)
    pairs = zip(entries(points, locus), points, strict=True)
    listed = [item | {"b": float(doubling_coefficient(z, locus))} for item, z in pairs]
    scaled = []
    for name, value in (("mu", 0.3), ("Ns", 0.6)):
        plane = locus._replace(plane=(name, "Nd"), values=(("f", 12.5),))
        scaled += entries([moved(start, locus, plane, value)], plane)
    least = entries(extremes(walked, locus, -1), locus)
    return walked, {"points": listed, "least_Nd": least, "scaling_at_f_12.5": scaled}


def gpd(walked):
    """GPD in (f, Nd) and in planes through f = 12.4 and 12.5."""
    locus = Locus("PD", 1)
    found = zeros(doubling_coefficient, walked, locus, -2)
    listed = [{"plane": ["f", "Nd"], "points": entries(found, locus)}]
    cases = ("Vd", 12.5, (0.1, 3)), ("Vd", 12.4, (0.1, 3)), ("alpha", 12.5, (0, np.pi))
    for name, f, span in cases:
        plane = Locus("PD", 1, (name, "Nd"), (("f", f),))
        z = moved(at(walked, locus, -2, f)[0], locus, plane, BASE[name])
        points = both_ways(z, plane, -2, box=(span, (0, 0.999)))
        found = entries(zeros(doubling_coefficient, points, plane, -2), plane)
        listed.append({"plane": [name, "Nd"], "f": f, "searched": [name, *span], "points": found})
    return listed


def lp_period_2(walked):
    """LP of period 2 in (f, Nd), and the cusp."""
    locus, parent = Locus("LP", 2), Locus("PD", 1)
    z = doubled(at(walked, parent, -2, 12.3)[0], parent, 101)
    keys = {"rows": coordinate(z, -2), "count": 40, "steps": (0.01, 0.04)}
    orbits = walk(z, locus._replace(kind="orbit"), -coordinate(z, -1), **keys)
    z = solve(min(orbits, key=lambda z: z[-1]), locus, coordinate(z, -2), 12.3)
    folds = both_ways(z, locus, -2, steps=(0.01, 0.05), count=80)
    folds = folds[: 1 + max(range(len(folds)), key=lambda i: folds[i][-2])]
    points = at(folds, locus, -2, 11.0, 11.8, 12.1, 12.2, 12.3, 12.4, 12.43)
    points += at(folds, locus, -1, 0.5)
    cusps = extremes(folds, locus, -2)
    return {"points": entries(points, locus), "CPC": entries(cusps, locus)}


def ns_period_2(walked):
    """NS of period 2 in (f, Nd) and, at f = 12.5, in (Vd, Nd)."""
    locus, parent = Locus("NS", 2), Locus("PD", 1)
    z = doubled(at(walked, parent, -2, 12.5)[0], parent, 81)
    orbits = walk(z, locus._replace(kind="orbit"), coordinate(z, -1), rows=coordinate(z, -2))
    z = join(min(orbits, key=lambda z: abs(z[-1] - 0.165)), [0.7])
    start = solve(z, locus, coordinate(z, -3), 12.5)
    points = both_ways(start, locus, -3, steps=(0.01, 0.05))
    plane = Locus("NS", 2, ("Vd", "Nd"), (("f", 12.5),))
    speeds = both_ways(moved(start, locus, plane, 0.6), plane, -3, box=((0, 1.2), (0, 0.999)))
    result = {}
    for name, where, walked_, chosen in (
        ("f_Nd", locus, points, (12.4975, 12.5, 12.51, 12.54, 12.55, 12.6, 13.0, 13.28)),
        ("Vd_Nd_at_f_12.5", plane, speeds, (0.6, 0.7, 0.8, 1.0)),
    ):
        found = {
            "points": at(walked_, where, -3, *chosen),
            f"extreme_{where.plane[0]}": extremes(walked_, where, -3),
            "extreme_Nd": extremes(walked_, where, -2),
            "extreme_theta": extremes(walked_, where, -1),
            "R3": at(walked_, where, -1, 2 * np.pi / 3),
            "R4": at(walked_, where, -1, np.pi / 2),
            "CH": zeros(torus_coefficient, walked_, where, -1),
        }
        result[name] = {key: entries(item, where) for key, item in found.items()}
    return result


def lp_period_1():
    """LP of period 1 next to the collapse of the spring."""
    listed = []
    for f, count in ((12.1, 81), (12.2, 81), (12.3, 81), (12.35, 121), (12.38, 121)):
        orbits = from_rest(f, count)
        last = max(range(len(orbits)), key=lambda i: orbits[i][-1])
        for z in orbits[last : last - 3 : -1]:
            states = resample(z[:-2].reshape(-1, 4), np.arange(SEGMENTS) / SEGMENTS)
            with suppress(AssertionError):
                z = shooting_fold(np.append(states, z[-1]), f)
                state = (z[:4] * [1, 1, 2 * np.pi * f, 2 * np.pi * f]).tolist()
                listed.append({"f": f, "Nd": float(z[-1]), "state": state})
                break
    return listed


def main():
    """Recompute tests/reference/loci.json; what it says about itself stays."""
    data = json.loads(FILE.read_text())
    walked, data["PD_period_1"] = pd_period_1()
    data["GPD"] = gpd(walked)
    data["LP_period_2"] = lp_period_2(walked)
    data["NS_period_2"] = ns_period_2(walked)
    data["LP_period_1"] = lp_period_1()
    FILE.write_text(json.dumps(data, indent=1) + "\n")


if __name__ == "__main__":
    main()
