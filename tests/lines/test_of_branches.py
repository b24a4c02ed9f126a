import numpy as np
import pytest

import slipfold as sf
from helpers.hand_drawn import (
    FLIPPED,
    FOLDED,
    INSIDE,
    drawn_branch,
    drawn_point,
)
from slipfold import Settings, Steps
from slipfold.lines import branch_segments


def kinds(branch):
    return [line.kind for line in branch_segments(branch, "x")]


def test_lines_change_exactly_at_the_located_point():
    s = np.linspace(0, 1, 6)
    point = drawn_point("PD", 0.33, 0.33, {"x": 0.33**2})
    branch = drawn_branch(s, {"x": s**2}, [INSIDE] * 2 + [FLIPPED] * 4, [point])
    stable, doubled = branch_segments(branch, "x")
    assert (stable.kind, doubled.kind) == ("stable", "period doubling")
    for line, end in ((stable, -1), (doubled, 0)):
        assert (line.parameter[end], line.value[end]) == (point.value, 0.33**2)


def test_stability_between_two_points_of_one_step_follows_from_their_types():
    s = np.array([0.0, 0.5, 1.0])
    special = [drawn_point("PD", v, v, {"x": v}) for v in (0.6, 0.61)]
    branch = drawn_branch(s, {"x": s}, [INSIDE] * 3, special)
    assert kinds(branch) == ["stable", "period doubling", "stable"]
    special = [drawn_point("NS", v, v, {"x": v}) for v in (0.6, 0.61)]
    assert kinds(drawn_branch(s, {"x": s}, [INSIDE] * 3, special)) == [
        "stable",
        "fold or torus",
        "stable",
    ]


def test_noise_on_the_parent_is_not_a_stretch():
    s = np.linspace(0, 1, 5)
    noise = np.array([1 + 1e-12, 0.5, 0.3, 0.2], dtype=complex)
    multipliers = [noise, INSIDE, INSIDE, INSIDE, noise]
    ends = {"started": "bifurcation", "stopped": "closed"}
    branch = drawn_branch(s, {"x": s}, multipliers, period=2, **ends)
    assert kinds(branch) == ["stable"]


def test_a_fold_turns_back_at_its_value():
    s = np.linspace(-1, 1, 9)
    s = s[s != 0]
    point = drawn_point("LP", 0.2, 0.0, {"x": 0.0})
    multipliers = [FOLDED if value < 0 else INSIDE for value in s]
    branch = drawn_branch(0.2 + s**2, {"x": s}, multipliers, [point], arclength=s)
    lines = branch_segments(branch, "x")
    assert [line.kind for line in lines] == ["fold or torus", "stable"]
    assert min(line.parameter.min() for line in lines) == pytest.approx(0.2, abs=1e-9)


@pytest.mark.parametrize(
    ("vary", "span", "fixed"),
    [
        pytest.param("f", (11, 14), {"Nd": 0.15}, marks=pytest.mark.long),
        ("Nd", (0, 0.98), {"f": 12.2}),
    ],
)
def test_lines_through_few_points_are_those_through_many(vary, span, fixed):
    coarse = sf.response(sf.SlidingOscillator(), vary, span, **fixed)
    steps = Settings(steps=Steps(largest=0.01))
    fine = sf.response(sf.SlidingOscillator(), vary, span, settings=steps, **fixed)
    for branch, reference in zip(coarse.branches, fine.branches, strict=True):
        for output in ("x", "y"):
            values = reference.extrema.of(output)[1]
            size = np.array([span[1] - span[0], np.ptp(values)])
            exact = np.column_stack([reference.parameter, values]) / size
            drawn = np.concatenate(
                [np.column_stack([t.parameter, t.value]) for t in branch_segments(branch, output)]
            )
            assert distance(drawn / size, exact).max() < 1e-3


def distance(points, line):
    """Distance of points to a line through many points."""
    start, step = line[:-1], np.diff(line, axis=0)
    away = points[:, None] - start
    share = np.clip((away * step).sum(2) / np.maximum((step**2).sum(1), 1e-30), 0, 1)
    return np.sqrt(((away - share[..., None] * step) ** 2).sum(2)).min(1)


def test_several_pairs_may_cross_between_two_points():
    # Two Hopf points of a chain one after the other, and no point of the branch between them.
    s = np.array([0.0, 0.5, 1.0])
    pair = np.array([0.9 * np.exp(1j), 0.9 * np.exp(-1j)])
    grown = 1.05 / 0.9 * pair
    other = np.array([0.8 * np.exp(2j), 0.8 * np.exp(-2j)])
    multipliers = [[*pair, *other], [*pair, *other], [*grown, *(1.1 / 0.8 * other)]]
    first = drawn_point("NS", 0.6, 0.6, {"x": 0.6}, multipliers=[*(pair / 0.9), *other])
    second = drawn_point("NS", 0.7, 0.7, {"x": 0.7}, multipliers=[*grown, *(other / 0.8)])
    branch = drawn_branch(s, {"x": s}, np.array(multipliers), [first, second])
    assert kinds(branch) == ["stable", "fold or torus"]
