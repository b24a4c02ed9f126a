"""Results are checked by themselves, for a tenth of their work, say so, and keep what they said."""

import dataclasses
import math
from pathlib import Path
from unittest.mock import Mock

import numpy as np
import pytest

import slipfold as sf
from helpers.dry_friction import FORCED_SLIDER
from slipfold.computations.thresholds import check_thresholds
from slipfold.models.registry import model_named
from slipfold.results.checks import curves as choice
from slipfold.results.checks.checked import CHECKS, Check, Checked
from slipfold.results.checks.curves import Candidate, check_some, check_together

GOOD = Check("PD of branch 1 at Nd = 0.0436 N", "collocation", 2e-14, 1e-8)
FAIR = Check("end of branch 1 at Nd = 0.376 N", "collocation", 3.1e-10, 1e-8)
BAD = Check("NS of branch 2 at Nd = 0.0567 N", "collocation", 0.031, 1e-8)
LOST = Check("end of branch 2 at Nd = 0.98 N", "quadrature", math.inf, 1e-8)


@pytest.fixture(scope="module")
def diagram():
    return sf.response(sf.SlidingOscillator(), vary="Nd", span=(0, 0.98), f=12.5)


@pytest.fixture(scope="module")
def motion():
    return sf.simulate(sf.SlidingOscillator(), 700, f=12.2, Nd=0.15)


@pytest.fixture(scope="module")
def thresholds():
    over = {"Vd": np.linspace(0.5, 0.8, 12), "alpha": np.linspace(0.9, 1.1, 12)}
    return sf.threshold_map(sf.SlidingOscillator(), "Nd", over=over, span=(0, 0.9))


def test_sentence():
    assert str(Checked(())) == "checked: nothing"
    assert str(Checked((GOOD, GOOD))) == "checked: 2 of 2 agree to 1e-12"
    assert str(Checked((GOOD, FAIR))) == "checked: 2 of 2 agree to 1e-09"
    assert str(Checked((GOOD, BAD, LOST))) == (
        "checked: 1 of 3 agree to 1e-12; NS of branch 2 at Nd = 0.0567 N does not agree: "
        "states differ by 3e-02, where 1e-08 is allowed, by collocation; end of branch 2 at "
        "Nd = 0.98 N does not agree: it cannot be computed again by quadrature"
    )
    many = Checked((GOOD, *[BAD] * 5))
    assert str(many).endswith("; 2 more do not agree")


def test_what_agrees_to_no_digit_does_not_agree():
    vague = Checked((GOOD, Check("PD of branch 1", "collocation", 0.4, 3.0, "multipliers")))
    assert str(vague) == (
        "checked: 1 of 2 agree to 1e-12; PD of branch 1 does not agree: multipliers differ by "
        "4e-01, where 1e-03 is allowed, by collocation"
    )


def test_a_response_checks_special_points_and_ends(diagram):
    names = [check.name.split(" at ")[0] for check in diagram.checked.checks]
    assert names == [
        *("PD of branch 1", "NS of branch 2", "NS of branch 2"),
        *("end of branch 1", "beginning of branch 1", "end of branch 2"),
    ]
    assert diagram.checked.agree
    assert diagram.summary().splitlines()[-1] == str(diagram.checked)
    assert str(diagram.checked) in diagram._repr_html_()


def test_a_simulation_checks_parts_of_the_motion(motion):
    assert [check.name for check in motion.checked.checks] == [
        *(f"the trajectory from {time:.6g} s on" for time in (699 / 12.2, 0)),
        "repetition of 48 of 700 forcing periods",
    ]
    assert motion.checked.agree
    assert motion.summary().splitlines()[-1] == "checked: 3 of 3 agree to 1e-12"


def test_a_map_checks_some_thresholds(thresholds):
    checks = thresholds.checked.checks
    highest, lowest = np.nanmax(thresholds.values), np.nanmin(thresholds.values)
    assert checks[0].name.startswith(f"PD at Nd = {highest:.6g} N, Vd = ")
    assert checks[1].name.startswith(f"PD at Nd = {lowest:.6g} N, Vd = ")
    assert all(check.method == "collocation" for check in checks)
    assert thresholds.checked.agree
    assert thresholds.summary().splitlines()[-1] == str(thresholds.checked)
    assert str(thresholds.checked) in thresholds._repr_html_()


@pytest.mark.parametrize("moved", [1e-6, -1e-3])
def test_the_right_orbit_at_a_wrong_threshold_does_not_agree(moved):
    over = {"Vd": [0.6, 0.7], "alpha": [1.0]}
    found = sf.threshold_map(sf.SlidingOscillator(), "Nd", over=over, span=(0, 0.9))
    wrong = dataclasses.replace(found, values=found.values * (1 + moved))
    orbits = [sf.periodic_orbit(wrong.model_at(*at)) for at in np.ndindex(found.values.shape)]
    states = np.reshape([orbit.state for orbit in orbits], found.states.shape)
    (one,) = check_thresholds(dataclasses.replace(wrong, states=states)).checks
    assert (one.method, one.agrees) == ("collocation", False)
    assert one.difference < 1e-2


def test_what_is_checked_takes_a_tenth_of_the_work_and_is_never_nothing(monkeypatch):
    orbit = sf.periodic_orbit(model_named("duffing", W=0.5))
    candidates = [Candidate(f"orbit {i}", orbit, resting=False) for i in range(50)]
    pieces = choice.pieces_of(orbit)
    cost = CHECKS.base + CHECKS.piece * pieces * (1 + 2 / 20)
    for points in (10, 50, 200):
        found = check_some(candidates, points)
        assert found.count == max(1, math.floor(CHECKS.fraction * points / cost + 1e-9))
        assert found.agree
    (first,) = check_some(candidates, 1).checks
    assert (first.method, first.agrees) == ("quadrature", True)


@pytest.mark.parametrize(
    ("name", "vary", "span"),
    [
        ("duffing", "W", (0.5, 1.5)),
        ("mathieu", "h", (0, 1.5)),
        ("lorenz", "rho", (0.5, 30)),
        ("squeal", "mu", (0.1, 1.5)),
        ("vanderpol", "a", (0, 3)),
        ("lure", "a", (0.5, 2)),
    ],
)
def test_what_is_right_agrees(name, vary, span):
    settings = sf.Settings(largest_period=2)
    diagram = sf.response(model_named(name), vary=vary, span=span, settings=settings)
    # Folds, branch points, Hopf points, cycles and the ends beside homoclinic orbits among them.
    assert diagram.checked.agree, str(diagram.checked)
    assert diagram.checked.count > 2


def test_fast_modes_are_no_disagreement():
    # One mode turns 40 times while the forcing does once, another decays by exp(-600).
    model = sf.System(
        name="fast",
        parameters={"W": {"value": 0.8, "above": 0}, "a": 0.3},
        states={
            "x": "v",
            "v": "a*cos(W*t) - 0.1*v - x - x^3",
            "y": "u",
            "u": "-1600*y - 0.1*u + x",
            "s": "-100*(s - x)",
        },
        forcing={"period": "2*pi/W", "amplitude": "a"},
    )
    diagram = sf.response(model, vary="a", span=(0.1, 0.6))
    assert diagram.checked.agree, str(diagram.checked)
    assert np.max([check.difference for check in diagram.checked.checks]) < 1e-8


def test_modes_too_fast_for_collocation_are_checked_by_harmonic_balance():
    # One state decays by exp(-300,000) in a period.
    model = sf.System(
        name="very fast",
        parameters={"W": {"value": 0.8, "above": 0}, "a": 0.3},
        states={"x": "v", "v": "a*cos(W*t) - 0.1*v - x - x^3", "s": "-4e4*(s - x)"},
        forcing={"period": "2*pi/W", "amplitude": "a"},
    )
    orbit = sf.periodic_orbit(model)
    assert choice.pieces_of(orbit) == 0
    (right,) = check_some([Candidate("orbit", orbit, resting=False)], 10).checks
    assert (right.method, right.agrees) == ("harmonic balance", True), right
    multipliers = orbit.multipliers * (1 + 1e-5)
    wrong = dataclasses.replace(orbit, multipliers=multipliers)
    (one,) = check_some([Candidate("orbit", wrong, resting=False)], 10).checks
    assert (one.what, one.agrees) == ("multipliers", False)


def test_an_orbit_in_thousands_of_nodes_needs_no_matrix_of_all_of_them():
    orbit = sf.periodic_orbit(model_named("duffing", W=0.5))
    finer = dataclasses.replace(orbit, nodes=orbit.sample(4096)[1])
    assert finer.nodes.shape == (4096, 2)
    (found,) = check_some([Candidate("orbit", finer, resting=False)], 10_000).checks
    assert found.method != "collocation"
    assert found.agrees


def test_whoever_interrupts_a_check_has_what_is_done(monkeypatch):
    orbit = sf.periodic_orbit(model_named("duffing", W=0.5))

    def candidates():
        yield Candidate("orbit", orbit, resting=False)
        raise KeyboardInterrupt

    assert check_some(candidates(), 1000).count == 1
    counted = []
    compare = Mock(side_effect=[KeyboardInterrupt, [choice.Difference(0.0)] * 3])
    monkeypatch.setattr(choice, "orbit_differences", compare)
    monkeypatch.setattr(CHECKS, "together", 60)
    found = check_some([Candidate("orbit", orbit, resting=False)] * 3, 1000, counted.append)
    assert (found.count, found.interrupted, counted) == (3, True, [0, 0, 0])


def test_cases_that_are_checked_together_keep_their_own_checks(diagram):
    first, *others = diagram.branches
    doubling = first.special[0]
    moved = dataclasses.replace(doubling, nodes=doubling.nodes * (1 + 1e-5))
    wrong = dataclasses.replace(first, special=(moved, *first.special[1:]))
    right, off = check_together([diagram.branches, (wrong, *others)])
    assert [check.name for check in right.checks] == [check.name for check in off.checks]
    assert [check.agrees for check in right.checks] == [True, True]
    assert [check.agrees for check in off.checks] == [False, True]


def test_an_interrupted_response_is_not_checked():
    def stop(progress):
        raise KeyboardInterrupt

    diagram = sf.response(
        sf.SlidingOscillator(), vary="Nd", span=(0, 0.98), f=12.5, on_progress=stop
    )
    assert diagram.interrupted
    assert diagram.checked.count == 0


def test_what_is_no_orbit_at_all_does_not_agree_and_raises_nothing():
    orbit = sf.periodic_orbit(model_named("duffing", W=0.5))
    for nodes in (orbit.nodes * np.nan, orbit.nodes + 1e200, orbit.nodes * 0 + 30):
        wrong = dataclasses.replace(orbit, nodes=nodes)
        for points in (1, 1000):
            (check,) = check_some([Candidate("orbit", wrong, resting=False)], points).checks
            assert not check.agrees


def test_an_equilibrium_that_does_not_rest_does_not_agree_and_raises_nothing():
    model = sf.System(name="decay", parameters={"r": 1}, states={"x": "r*x - x^3", "y": "x - y"})
    branch, *_ = sf.response(model, vary="r", span=(1, 0.5), start={"x": 1, "y": 1}).branches
    wrong = dataclasses.replace(branch.orbit(0), nodes=branch.orbit(0).nodes + 1e-6)
    (check,) = check_some([Candidate("equilibrium", wrong, resting=True)], 1000).checks
    assert not check.agrees


def test_static_friction_is_compared_where_a_contact_is_closed():
    # It is open at phase zero, where a tension would turn the comparison around.
    text = FORCED_SLIDER.replace('"1.0"', '"1 - 1.4*cos(W*t)"').replace('"0.6"', '"most"')
    model = sf.System.from_toml(text.replace("F = 0.6", "F = 0.6, most = 0.6"))
    assert choice._holds_more(sf.periodic_orbit(model))
    assert not choice._holds_more(sf.periodic_orbit(model.replace(most=0.3)))


def test_periods_that_end_off_an_equilibrium_are_passed_over_by_others():
    text = Path(__file__).parents[1] / "explorer/models/two-on-a-belt.toml"
    state = [
        0.014283886273153992,
        0.01654568826623924,
        8.731644384016945e-07,
        2.9603743387015494e-07,
    ]
    options = {"Vd_front": 2.9496050420168065, "duration": 0.1}
    motion = sf.simulate(sf.Structure.from_toml(text), 128, state, **options)
    assert motion.checked.checks
    assert motion.checked.agree
