"""Branches moved to other parameter values, against branches that are followed there."""

import numpy as np
import pytest

import slipfold as sf
from slipfold.bifurcations.branches import moved as moving
from slipfold.bifurcations.branches.moved import moved_branches
from slipfold.lines import branch_segments
from slipfold.orbits.kinds import ForcedOrbits

SPAN = (0, 0.9)
CHANGES = [{"f": 12.51}, {"Ns": 0.95}]
LONG = pytest.mark.long


@pytest.fixture(scope="module")
def known():
    return sf.response(sf.SlidingOscillator(), "Nd", SPAN, f=12.5)


@pytest.fixture(scope="module", params=CHANGES, ids=str)
def both(request, known):
    """What is moved, and what is followed."""
    moved = moved_branches(known.branches, known.model.replace(**request.param), SPAN)
    return moved, sf.response(known.model, "Nd", SPAN, **request.param).branches


def test_special_points_are_those_that_are_followed(both):
    for ours, theirs in zip(*both, strict=True):
        assert [p.type for p in ours.special] == [p.type for p in theirs.special]
        assert [p.leads_to for p in ours.special] == [p.leads_to for p in theirs.special]
        assert [p.criticality for p in ours.special] == [p.criticality for p in theirs.special]
        for mine, right in zip(ours.special, theirs.special, strict=True):
            assert mine.value == pytest.approx(right.value, rel=1e-11)
            assert mine.coefficient == pytest.approx(right.coefficient, rel=1e-5)
        # Near the limit it is not sure to be moved.
        limited = theirs.stopped.kind == "limit"
        assert ours.stopped.kind == ("unfinished" if limited else "span")
        assert ours.stopped.value == pytest.approx(theirs.stopped.value, rel=0.15 * limited + 1e-12)


def polyline(branch):
    return np.concatenate([line.points for line in branch_segments(branch, "x")])


def distances(points, line):
    """Distance of each point from a polyline."""
    start, along = line[:-1], np.diff(line, axis=0)
    square = np.maximum((along**2).sum(axis=1), 1e-300)
    share = ((points[:, None] - start) * along).sum(axis=2) / square
    nearest = start + np.clip(share, 0, 1)[:, :, None] * along
    return np.linalg.norm(points[:, None] - nearest, axis=2).min(axis=1)


def test_lines_lie_on_those_that_are_followed(both):
    for ours, theirs in zip(*both, strict=True):
        line = polyline(theirs)
        size = np.ptp(line, axis=0)
        # As far as lines through few points lie off the curve (tests/lines/test_of_branches.py).
        assert distances(polyline(ours) / size, line / size).max() < 1e-3


def test_every_point_is_an_orbit_with_its_multipliers(both):
    for branch in both[0]:
        problem = ForcedOrbits(branch.model, {"Nd": 1.0}, branch.period)
        assert branch.residual.max() < 1e-10
        for i, (nodes, value) in enumerate(zip(branch.nodes, branch.parameter, strict=True)):
            z = problem.join(nodes, value)
            assert np.abs(problem.defect(z)).max() < 1e-9
            if branch.started.kind == "bifurcation" and i == 0:
                continue  # the parent's orbit passed twice
            expected = np.linalg.eigvals(problem.linearize(z).monodromy)
            np.testing.assert_allclose(
                np.sort(np.abs(branch.multipliers[i])), np.sort(np.abs(expected)), rtol=1e-7
            )


def test_nothing_is_moved_where_bifurcations_vanish(known):
    # At 12.4 Hz the period doubling is subcritical: folds take the place of the tori.
    assert moved_branches(known.branches, known.model.replace(f=12.4), SPAN) is None


@pytest.mark.parametrize(
    ("base", "values", "count"), [({}, {"f": 12.45}, 0), ({"f": 12.45}, {}, 2)]
)
def test_branches_are_moved_where_tori_vanish_or_appear(base, values, count):
    known = sf.response(sf.SlidingOscillator(**base), "Nd", SPAN).branches
    assert len(known[1].special) == 2 - count
    moved = moved_branches(known, sf.SlidingOscillator(**values), SPAN)
    assert [item.type for item in moved[1].special] == ["NS"] * count


@pytest.mark.parametrize("left", [1e-5, 0.1])
def test_no_branch_is_moved_beyond_a_limit(left):
    states = {"x": "v", "v": "F*cos(W*t) - x - 0.2*v - 0.01*x^3"}
    model = sf.System(
        parameters={"W": 0.5, "F": 1.0, "lowest": -9.0},
        forcing={"period": "2*pi/W"},
        states=states,
        outputs={"room": "x - lowest"},
        limits={"floor": {"output": "room", "bound": 0.0}},
    )
    (known,) = sf.response(model, "W", (0.5, 1.6)).branches
    lowest = known.extrema.of("x")[0].min() + left
    assert known.stopped.kind == "span"
    assert moved_branches([known], model.replace(lowest=lowest), (0.5, 1.6)) is None


def test_what_is_moved_is_no_start_and_lacks_few_orbits(monkeypatch):
    # At 12.0 Hz the response has no limit: how far it is moved must not depend on the way there.
    slider, span = sf.SlidingOscillator(f=12.3), (0, 0.9)
    known = sf.response(slider, "Nd", span).branches
    moved = moved_branches(known, slider.replace(f=12.28), span)
    assert moved_branches(moved, slider.replace(f=12.26), span) is None
    far = moved_branches(known, slider.replace(f=12.0), span)
    assert len(far[0]) < len(moved[0])
    assert far[0].stopped.reason.endswith("the rest follows")
    monkeypatch.setattr(moving.MOVED, "dropped", 0.0)
    assert moved_branches(known, slider.replace(f=12.0), span) is None
    # Of fewer than four orbits before the limit nothing is interpolated.
    monkeypatch.setattr(moving.MOVED, "dropped", 1.0)
    monkeypatch.setattr(moving._Line, "_until_limit", lambda line, z: 3)
    assert moved_branches(known, slider.replace(f=12.28), span) is None


def structure(branches):
    return [[(point.type, point.criticality) for point in branch.special] for branch in branches]


@pytest.mark.parametrize(
    ("model", "vary", "span", "steps"),
    [
        # The period doubling turns subcritical, and the doubled branch has a fold, from 12.436 Hz.
        ("sliding", "Nd", (0, 0.98), [{"f": f} for f in (12.47, 12.44, 12.41)]),
        # The fold of the first branch lies beside the limit, where nothing is moved.
        pytest.param("sliding", "Nd", (0, 0.98), [{"f": 12.35}, {"f": 12.345}], marks=LONG),
        # The first orbits of the doubled branch are nearer to the period doubling than it moves.
        pytest.param("sliding", "Nd", (0, 0.98), [{"f": 12.46}, {"f": 12.4867}], marks=LONG),
        # Both tori vanish with the point that joins them, or lie where rough zeros are inexact.
        ("sliding", "Nd", (0, 0.98), [{}, {"f": 12.45}, {"Ns": 1.1}, {"Ns": 0.94666666666666667}]),
        # Two period doublings appear between two orbits of seven.
        ("mathieu", "w", (1.6, 2.4), [{"h": 0.02}, {"h": 0.041}, {"h": 0.025}]),
        # Two folds too near to each other for any point to lie between them.
        ("vanderpol", "w", (0.5, 1.5), [{"a": a, "e": 0.2303} for a in (0.27, 0.2587, 0.2493)]),
    ],
    ids=["sliding", "limit", "beginning", "tori", "mathieu", "vanderpol"],
)
def test_a_slider_moves_branches_as_far_as_their_structure_is_known(model, vary, span, steps):
    start, *others = [sf.built_in_models()[model](**values) for values in steps]
    known = sf.response(start, vary, span).branches
    for step in others:
        moved = moved_branches(known, step, span)
        followed = sf.response(step, vary, span).branches
        if moved is None:
            assert structure(known) != structure(followed)
            continue
        for branch, other, ours, theirs in zip(
            moved, followed, structure(moved), structure(followed), strict=True
        ):
            assert ours == theirs[: len(ours)]
            assert len(ours) == len(theirs) or branch.stopped.kind == "unfinished"
            values = [point.value for point in other.special][: len(ours)]
            assert [point.value for point in branch.special] == pytest.approx(values, rel=1e-11)
