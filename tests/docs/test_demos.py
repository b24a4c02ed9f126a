"""AUTO's points of its demos are found, and AUTO's that are none lie where a reason is known."""

import importlib
from pathlib import Path

import pytest

GALLERY = Path(__file__).parents[2] / "docs" / "gallery"
NAMES = ["ab", "tor", "plp", "chu", "pen", "kpr", "lor", "pp2", "abc", "frc"]
NAMES += ["co", "lorenz84", "steinmetz"]


@pytest.fixture
def demos(monkeypatch):
    monkeypatch.syspath_prepend(str(GALLERY))
    return importlib.import_module("demos")


def test_every_demo_was_measured(demos):
    measured = demos.measured()["systems"]
    assert set(measured) == set(demos.DEMOS) == set(NAMES)
    for name in measured:
        vary, (first, last) = demos.DEMOS[name].vary, demos.DEMOS[name].span
        assert f"--vary {vary}={first:.8g}:{last:.8g}" in demos.command(name)
        assert vary in {parameter.name for parameter in demos.model(name).parameters}


def test_points_match_within_the_accuracy_that_auto_is_asked_for(demos):
    ours = [("LP", 0.5), ("HB", 0.5001), ("LP", 200.0)]
    assert demos.match(ours, "LP", 0.50005) == 0.5
    assert demos.match(ours, "LP", 0.501) is None
    assert demos.match(ours, "LP", 200.01) == 200.0
    assert demos.match(ours, "PD", 0.5) is None


@pytest.mark.long
@pytest.mark.parametrize("name", NAMES)
def test_whole_demos_have_the_points_that_auto_reports(demos, name):
    diagram = demos.response(name)
    ours = demos.own_points(diagram)
    assert all(
        demos.match(ours, *point) is not None
        for point in demos.measured()["systems"][name]["ours"]["points"]
    )
    table = importlib.import_module("comparison").Comparison()
    demos.compare(table, name, diagram)
    assert all(row.agrees for row in table), f"\n{table}"


def test_a_point_that_is_not_found_does_not_agree(demos, monkeypatch):
    table = importlib.import_module("comparison").Comparison()
    measured = {"ours": {"points": [["HB", 0.5]], "ends": [0.9]}}
    measured["theirs"] = {"points": [["HB", 0.50001], ["LP", 0.50002], ["BP", 0.9], ["LP", 0.7]]}
    monkeypatch.setattr(demos, "measured", lambda: {"systems": {"ab": measured}})
    demos.compare(table, "ab")
    assert [row.agrees for row in table] == [True, False]


def test_harmonic_balance_that_diverges_is_no_check(demos):
    assert demos.response("ab").checked.agree  # near the loop nothing else is fast enough


def test_branches_across_a_line_of_equilibria_are_found(demos):
    """AUTO's demo chu starts at alpha = -1; at 0 each state (x, 0, -x) is an equilibrium."""
    import slipfold as sf

    diagram = sf.response(
        demos.model("chu"), vary="alpha", span=(-1, 4), settings=sf.Settings(largest_period=0)
    )
    assert diagram.branches[0].special[0].orbit.extrema.maximum[0] == pytest.approx(0, abs=1e-9)
    crossings = [point for branch in diagram.branches[:2] for point in branch.special]
    assert sorted(point.orbit.extrema.maximum[0, 0] for point in crossings) == pytest.approx(
        [-1.4994, 0, 0, 1.4994], abs=1e-4
    )
    assert len(diagram.branches) == 4
