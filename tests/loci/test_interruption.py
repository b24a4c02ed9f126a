"""An observer that raises KeyboardInterrupt stops the computation; what is done is kept."""

import numpy as np
import pytest

from helpers.bifurcation_sets import bifurcations, response
from slipfold import System
from slipfold.bifurcations.loci import bifurcation_set, follow
from slipfold.bifurcations.loci.bifurcation_set import find_bifurcation_set
from slipfold.bifurcations.loci.fan import follow_fan
from slipfold.bifurcations.loci.follow import follow_loci

STAGES = ("loci", "normal forms")
FORCE, WINDOW = ("f", "Nd"), ((12.45, 12.55), (0.0, 0.06))


@pytest.fixture(scope="module")
def points():
    found = bifurcations(response("Nd", (0.0, 0.98), (("f", 12.5),)))
    return [point for point in found if point.value < WINDOW[1][1]]


@pytest.fixture(scope="module")
def whole(points):
    seen = []
    return follow_loci(points, FORCE, WINDOW, observer=seen.append), seen


def interrupted(points, count):
    seen = []

    def observer(progress):
        seen.append(progress)
        if len(seen) == count:
            raise KeyboardInterrupt

    return follow_loci(points, FORCE, WINDOW, observer=observer), seen


def test_observer_hears_of_every_point(whole):
    loci, seen = whole
    assert [item.stage for item in seen] == sorted(item.stage for item in seen)
    stages = {stage: [item for item in seen if item.stage == stage] for stage in STAGES}
    assert sum(map(len, stages.values())) == len(seen)
    for told in stages.values():
        assert [item.done for item in told] == sorted(item.done for item in told)
    # One at each point of each locus, and at each of its special points.
    forms = stages["normal forms"]
    assert {item.total for item in forms} == {len(forms)}
    assert len(forms) == sum(len(item) + len(item.special) for item in loci)
    assert all(
        low - 0.1 <= value <= high + 0.1
        for item in seen
        for value, (low, high) in zip(item.values["place"], WINDOW, strict=True)
    )
    assert seen[0].text.startswith("PD of period 1, 2 points")
    assert len(stages["loci"]) >= sum(len(item) for item in loci) - 2 * len(loci)


@pytest.mark.parametrize("share", [0.0, 0.4, pytest.param(0.9, marks=pytest.mark.long)])
def test_what_is_done_is_kept(points, whole, share):
    loci, told = whole
    count = 1 + int(share * (len(told) - 1))
    found, seen = interrupted(points, count)
    assert len(seen) == count  # it stops at once
    assert 1 <= len(found) <= len(loci)
    assert found[-1].interrupted
    ends = (found[-1].started, found[-1].stopped)
    assert "interrupted" in [end.kind for end in ends]
    for one, other in zip(found[:-1], loci, strict=False):
        assert (one.type, one.period) == (other.type, other.period)
        assert one.values == pytest.approx(other.values, abs=1e-12)
        assert [p.type for p in one.special] == [p.type for p in other.special]
    # The locus at work is a part of what it would have become.
    last, full = found[-1], loci[len(found) - 1]
    assert len(last) >= 2
    assert np.isfinite(last.nodes).all()
    gaps = np.abs(last.values[:, None] - full.values[None]).max(axis=2).min(axis=1)
    assert np.sort(gaps)[: len(last) - 1].max() < 1e-9
    assert [p.type for p in last.special] == [
        p.type for p in full.special
        if any(p.values == pytest.approx(q.values, abs=1e-9) for q in last.special)
    ]  # fmt: skip


def test_what_is_done_is_kept_where_an_interruption_comes_between_two_loci(
    points, whole, monkeypatch
):
    def passing(curves, *given):
        if curves:
            raise KeyboardInterrupt

    monkeypatch.setattr(follow, "passing", passing)
    (found,) = follow_loci(points, FORCE, WINDOW)
    assert found.interrupted
    assert len(found) == len(whole[0][0])


def test_loci_of_equilibria_come_before_any_cycle(monkeypatch):
    # Cycles near a homoclinic orbit may take minutes: who stops there has the Hopf locus.
    def fan(plane, counts):
        if plane.settings.largest_period > 0:
            raise KeyboardInterrupt
        return follow_fan(plane, counts)

    monkeypatch.setattr(bifurcation_set, "follow_fan", fan)
    model = System(
        parameters={"r": 0.1, "s": 0.2},
        states={"x": "(r - s)*x - y - x*(x^2 + y^2)", "y": "x + (r - s)*y - y*(x^2 + y^2)"},
    )
    found = find_bifurcation_set(model, ("r", "s"), ((0, 1), (0, 1)), regions=False)
    assert found.interrupted
    (locus,) = found.loci
    assert locus.type == "HB"
    assert locus.values[:, 0] == pytest.approx(locus.values[:, 1], abs=1e-12)
