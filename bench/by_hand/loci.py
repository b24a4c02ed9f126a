"""Loci of LP, PD and NS in two parameters, by hand; makes loci.json.

They are curves of critical orbits by Fourier collocation. The folds of period 1, where the
spring nearly collapses, are found by multiple shooting. Nothing of the package is used.
"""

import json
import sys
from contextlib import suppress
from functools import partial
from itertools import pairwise
from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import root_scalar

sys.path.insert(0, str(Path(__file__).parents[2] / "tests"))

from critical_orbits import (
    Locus,
    coordinate,
    doubled,
    doubling_coefficient,
    join,
    locate,
    resample,
    slope,
    solve,
    split,
    tangent,
    torus_coefficient,
    walk,
)

from helpers.by_hand.sliding import BASE, rhs

FILE = Path(__file__).parents[2] / "tests" / "reference" / "loci.json"

TINY = 1e-30
SEGMENTS = 8


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
