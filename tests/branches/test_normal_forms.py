"""Coefficients and criticality by means that share no code with the package.

Derivatives of the stroboscopic map by SciPy; the branch that leaves a period doubling; the
parameter along a fold; the slow growth or decay at a torus bifurcation, seen in simulation.
"""

import numpy as np
import pytest

import slipfold as sf
from helpers.by_hand.stroboscopic import StroboscopicByHand, coefficient, critical_vectors
from helpers.reference import CASES, traced
from slipfold import Settings, Steps, periodic_orbit
from slipfold.bifurcations.branches.response import trace_response


def find(case, kind, near=None):
    found = [item for branch in traced(case) for item in branch.special if item.type == kind]
    return found[0] if near is None else min(found, key=lambda item: abs(item.value - near))


def map_of(item, radius=0.02):
    return StroboscopicByHand(item.model.values, item.period, item.state, radius)


ALL = [
    pytest.param(case, branch_period, index, marks=[] if number in (0, 1, 9) else pytest.mark.long)
    for number, case in enumerate(CASES)
    for branch_period, expected in ((1, case.period1), (2, case.period2))
    for index in range(len(expected))
]


@pytest.mark.parametrize(("case", "period", "index"), ALL, ids=str)
def test_coefficient_against_differences_of_the_map(case, period, index):
    (branch,) = (item for item in traced(case) if item.period == period)
    item = branch.special[index]
    growth = np.abs(item.multipliers).max()
    # Within a period a perturbation grows as the multipliers do: stay where the map is smooth.
    map_ = map_of(item, 0.02 if growth < 10 else 1e-4)
    expected = coefficient(map_, item.type, item.critical_multiplier)
    if item.type == "LP":  # its sign is that of the eigenvector
        expected *= np.sign(expected * item.coefficient)
    assert item.coefficient == pytest.approx(expected, rel=1e-5 if growth < 10 else 1e-3)
    if item.type == "PD":
        assert item.criticality == ("supercritical" if expected > 0 else "subcritical")
    if item.type == "NS":
        assert item.criticality == ("supercritical" if expected < 0 else "subcritical")


def limit_at_zero(x, y, degree):
    """Value at zero of the polynomial through points (x, y)."""
    return np.polyfit(x, y, degree)[-1]


@pytest.mark.parametrize("case", [CASES[1], CASES[9]], ids=str)
def test_doubled_branch_leaves_as_the_normal_form_says(case):
    # x -> -(1 + e) x + b x^3 has the orbit x^2 = e/b of period two; e grows with the parameter.
    item = find(case, "PD")
    model, width = item.model, case.span[1] - case.span[0]
    delta = 1e-5 * width
    slopes = [
        min(
            periodic_orbit(model.replace(**{case.vary: item.value + side * delta})).multipliers,
            key=lambda value: abs(value + 1),
        ).real
        for side in (-1, 1)
    ]
    slope = (slopes[1] - slopes[0]) / (2 * delta)
    map_ = map_of(item)
    _, p = critical_vectors(map_, map_.monodromy(), -1.0)
    steps = Settings(steps=Steps(largest=0.004), largest_period=2)
    span = (max(item.value - 0.04 * width, 0.0), item.value + 0.04 * width)
    branches = trace_response(model, case.vary, span, settings=steps)
    child = next(branch for branch in branches if branch.period == 2)
    half = len(child.nodes[0]) // 2
    swings = (child.nodes[1:6, 0] - child.nodes[1:6, half]) / 2 / map_.scales
    amplitude = swings @ np.real(p)
    shift = child.parameter[1:6] - item.value
    measured = limit_at_zero(amplitude**2, shift / amplitude**2, 2)
    assert measured == pytest.approx(item.coefficient / -slope, rel=2e-3)


FOLDS = [(CASES[1], 0.074), (CASES[8], None), (CASES[9], None)]


@pytest.mark.parametrize(("case", "near"), FOLDS, ids=str)
def test_parameter_turns_at_a_fold_as_the_normal_form_says(case, near):
    # x -> x + e + a x^2 has its fixed points where e = -a x^2.
    item = find(case, "LP", near)
    map_ = map_of(item)
    _, p = critical_vectors(map_, map_.monodromy(), 1.0)
    drift = _with_clock(map_, item, case.vary, np.real(p))
    along, _ = critical_vectors(map_, map_.monodromy(), 1.0)
    bend = coefficient(map_, "LP", 1.0)  # of the same eigenvector as the drift
    assert abs(bend) == pytest.approx(abs(item.coefficient), rel=1e-5)
    estimates = []
    for size in (2e-3, 4e-3):
        shift = -bend / drift * size**2
        model = item.model.replace(**{case.vary: item.value + shift})
        both = []
        for side in (-1, 1):
            guess = (map_.center + side * size * np.real(along)) * map_.scales
            orbit = periodic_orbit(model, item.period, guess)
            u = (orbit.state / map_.scales - map_.center) @ np.real(p)
            assert u * side > 0
            both.append(shift / u**2)
        # The curve's third order is odd in u and falls out of the mean.
        estimates.append(np.mean(both))
    curvature = (4 * estimates[0] - estimates[1]) / 3
    assert curvature == pytest.approx(-bend / drift, rel=1e-3)


def _with_clock(map_, item, vary, p):
    """<p, d map/d parameter>; the clock of the map is the phase, so f changes its duration too."""
    if vary != "f":
        return p @ map_.along_parameter(vary)
    ends = []
    for side in (-1, 1):
        values = {**item.model.values, "f": item.value + side * 1e-5}
        other = StroboscopicByHand(values, item.period, item.state, 1.0)
        # Scaled by the same rates as at the fold.
        start = map_.center * map_.scales / other.scales
        ends.append(other.images(start[None])[0] * other.scales / map_.scales)
    return p @ (ends[1] - ends[0]) / 2e-5


TORI = [
    (CASES[0], 0.0567, 0.004),
    pytest.param(CASES[0], 0.1664, 0.01, marks=pytest.mark.long),
    pytest.param(CASES[9], 12.66, 0.001, marks=pytest.mark.long),
]


@pytest.mark.parametrize(("case", "near", "amplitude"), TORI, ids=str)
def test_slow_drift_at_a_torus_bifurcation(case, near, amplitude):
    # On the center manifold |z| -> |z| + d |z|^3, so that 1/|z|^2 changes by -2 d an iteration,
    # besides what oscillates with the rotation. The next order changes the slope by a multiple
    # of |z|^2, which two amplitudes eliminate.
    item = find(case, "NS", near)
    map_ = map_of(item)
    critical = item.critical_multiplier
    q, p = critical_vectors(map_, map_.monodromy(), critical)
    turns = np.exp(2j * np.pi * np.arange(8) / 8)
    start = np.concatenate([amplitude * turns, 2 * amplitude * turns])
    states = map_.center + 2 * np.real(start[:, None] * q)
    inverse = []
    for _ in range(80):
        z = (states - map_.center) @ p.conj()
        inverse.append(np.mean((1 / np.abs(z) ** 2).reshape(2, 8), axis=1))
        states = map_.images(states)
    # The first iterations bring the states to the center manifold.
    count = np.arange(40, 80)
    waves = np.exp(1j * np.angle(critical) * np.outer(count, [1, 2, 3, 4]))
    columns = np.column_stack([count, np.ones(40), waves.real, waves.imag])
    near_slope, far_slope = np.linalg.lstsq(columns, np.array(inverse)[40:])[0][0] / -2
    assert (4 * near_slope - far_slope) / 3 == pytest.approx(item.coefficient, rel=2e-3)
    assert item.criticality == ("subcritical" if item.coefficient > 0 else "supercritical")


KOPER = """
[parameters]
l = -1.1
[states]
x = "10*(-y - x^3 + 3*x - l)"
y = "x - 2*y + z"
z = "y - z"
"""


@pytest.mark.long
def test_a_doubling_beside_a_multiplier_of_1e5_is_soft_or_hard():
    """Koper's model, AUTO's demo kpr: what holds at l holds at -l, by (l, x, y, z) to minus it."""
    special = sf.response(sf.System(KOPER), vary="l", span=(-1.1, 1.1)).special
    found = [item.point for item in special if item.point.type == "PD"]
    assert all(point.criticality is not None for point in found)
    assert max(abs(point.multipliers[0]) for point in found) > 1e4
    above = sorted((p.value, p.criticality) for p in found if p.value > 0)
    below = sorted((-p.value, p.criticality) for p in found if p.value < 0)
    for (value, criticality), (other, same) in zip(above, below, strict=True):
        assert value == pytest.approx(other, abs=1e-8)
        assert criticality == same
