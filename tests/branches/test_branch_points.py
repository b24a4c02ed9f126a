"""Branch points: the other branch is followed, in both directions and once."""

from types import SimpleNamespace

import numpy as np
import pytest

import slipfold as sf
from slipfold.bifurcations.branches import switching
from slipfold.bifurcations.branches.branch_point import find_crossing
from slipfold.continuation.locate import LostCurveError
from slipfold.models.registry import model_named
from slipfold.orbits.kinds import Equilibria

ALONE = sf.Settings(largest_period=1)
"""Period doublings are not followed."""


def kinds(branch):
    return [item.type for item in branch.special]


def system(name, **states):
    return sf.System(name=name, parameters={"r": -0.5}, states=states)


def test_transcritical_point_of_equilibria():
    # x (r - x) = 0 with a slave y: the other branch is x = r, on both sides of r = 0.
    model = system("transcritical", x="r*x - x^2", y="-y + x")
    rest, other = sf.response(model, vary="r", span=(-0.5, 0.5)).branches
    assert (kinds(rest), kinds(other)) == (["BP"], ["BP"])
    assert rest.special[0].value == pytest.approx(0, abs=1e-12)
    assert (rest.special[0].leads_to, other.special[0].leads_to) == (2, 1)
    assert (other.parent, other.kind) == (1, "equilibrium")
    assert sorted(other.parameter[[0, -1]]) == [-0.5, 0.5]
    assert other.states == pytest.approx(np.column_stack([other.parameter] * 2), abs=1e-10)
    assert rest.special[0].name == "transcritical branch point"
    assert rest.special[0].criticality is None
    away = np.abs(other.parameter) > 1e-6
    assert np.array_equal(other.stable[away], other.parameter[away] > 0)
    assert np.all(np.diff(other.arclength) > 0)


@pytest.mark.parametrize("sign", [1, -1])
def test_pitchfork_of_equilibria(sign):
    # x (r - sign x^2) = 0: both halves of the other branch, one the mirror image of the other.
    model = system("pitchfork", x=f"r*x - {sign}*x^3", y="-y + x^2")
    rest, other = sf.response(model, vary="r", span=(-0.5, 0.5)).branches
    assert (kinds(rest), kinds(other)) == (["BP"], ["BP"])
    assert other.parameter[[0, -1]] == pytest.approx([sign * 0.5] * 2, abs=1e-15)
    assert other.states[0, 0] == pytest.approx(-other.states[-1, 0], abs=1e-10)
    assert sign * other.parameter == pytest.approx(other.states[:, 0] ** 2, abs=1e-10)
    away = np.abs(other.arclength) > 1e-6
    assert np.all(other.stable[away] == (sign > 0))
    (point,) = rest.special
    assert point.name == "pitchfork"
    assert point.coefficient == pytest.approx(-sign, rel=1e-8)
    assert point.criticality == ("supercritical" if sign > 0 else "subcritical")


def test_of_images_under_a_symmetry_one_is_followed_in_any_scales():
    # z' = r z + conj(z)^2 - |z|^2 z with u = |z|^2: six branches, r = u -+ sqrt(u), three each.
    states = {"x": "r*x + x^2 - y^2 - (x^2 + y^2)*x", "y": "r*y - 2*x*y - (x^2 + y^2)*y"}
    three = system("three", **states, u="x^2 + y^2 - u")
    rest, *others = sf.response(three, vary="r", span=(-0.5, 0.5)).branches
    assert rest.special[0].images == 4
    assert "not followed: 4 branches that are images" in rest.special[0].undecided
    sizes = np.sqrt([branch.states[-1, 2] for branch in others])
    assert np.sort(sizes) == pytest.approx(0.75**0.5 + np.array([-0.5, 0.5]))


@pytest.mark.parametrize(
    ("rates", "count", "forced"),
    [
        (("r*{} - {}^3", "2*r*{} - {}^3"), 3, False),  # two pitchforks at once, and both together
        (("r*{} - {}^3", "(r + r^2/10)*{} - {}^3"), 3, True),  # spectra hardly differ nearby
        (("r*{} - {}^3", "r*{} - {}^3 - {}^5/10"), 3, False),
        (("r*{} - {}^2", "2*r*{} - {}^2"), 6, True),  # on both sides
        pytest.param([f"{i}*r*{{}} - {{}}^3" for i in (1, 2, 3)], 7, True, marks=pytest.mark.long),
        pytest.param(
            [f"{i}*r*{{}} - {{}}^2" for i in range(1, 5)], 30, False, marks=pytest.mark.long
        ),
    ],
)
def test_all_branches_begin_where_several_multipliers_are_one(rates, count, forced):
    # Each state is zero or the root of its own equation: of images, one is followed.
    states = {name: rate.format(*[name] * 3) for name, rate in zip("xyzw", rates, strict=False)}
    more = {"u": "v", "v": "cos(t) - 2*u - v"} if forced else {}
    settings = {"forcing": {"period": "2*pi"}} if forced else {}
    model = sf.System(parameters={"r": -0.1}, states={**states, **more}, **settings)
    rest, *others = sf.response(model, "r", (-0.1, 0.1)).branches
    (point,) = rest.special
    assert (point.type, point.several) == ("BP", True)
    assert point.value == pytest.approx(0, abs=max(1e-9, point.uncertainty))
    assert list(rest.stable[[0, -1]]) == [True, False]
    ends = {(branch.parameter[-1] > 0, *np.abs(branch.states[-1, : len(rates)]).round(6))
            for branch in others}  # fmt: skip
    assert len(others) == len(ends) == count
    assert ("not followed" in point.undecided) == (point.images > 0) == ("^3" in rates[0])
    assert point.rare == 0


def test_branches_may_be_missing_where_few_directions_lead_to_some(monkeypatch):
    rates = {name: f"{i}*r*{name} - {name}^2" for i, name in enumerate("xyz", 1)}
    model = system("three", **rates)  # 14 leave it: each is zero, or moves either way
    monkeypatch.setattr(switching.BIFURCATION, "times", 20)
    monkeypatch.setattr(switching.BIFURCATION, "most", 1)
    (point,) = sf.response(model, "r", (-0.1, 0.1)).branches[0].special
    assert f"few directions led to {point.rare} of those found" in point.undecided


def test_a_branch_between_two_branch_points_is_followed_once():
    # x^2 = r (1 - r): a closed curve through both points, where it turns without a fold.
    model = system("bubble", x="r*(1 - r)*x - x^3 + 0.2*y", y="-y")
    rest, other = sf.response(model, vary="r", span=(-0.5, 1.5)).branches
    assert [(item.type, item.leads_to) for item in rest.special] == [("BP", 2), ("BP", 2)]
    assert kinds(other) == ["BP", "BP"]
    assert [item.value for item in other.special] == pytest.approx([0, 1], abs=1e-12)
    assert (other.stopped.kind, other.started.kind) == ("closed", "closed")
    assert other.stopped.value == pytest.approx(0, abs=1e-12)
    x, r = other.states[:, 0], other.parameter
    assert x**2 == pytest.approx(r * (1 - r), abs=1e-10)
    assert x.max() == pytest.approx(-x.min(), rel=0.02)


def test_a_crossing_far_from_where_it_was_located_asks_for_a_shorter_step():
    # Within a long step Newton's method may lead onto the other branch, r = x^2.
    orbits = Equilibria(system("pitchfork", x="r*x - x^3"), {"r": 1.0})
    far = SimpleNamespace(z=orbits.join(np.array([[0.2]]), [0.04]), arclength=0.0)
    assert find_crossing(orbits, far, np.array([0.0, 1.0]), length=0.01) is None
    with pytest.raises(LostCurveError, match="onto another branch"):
        find_crossing(orbits, far, np.array([0.0, 1.0]), length=1.0)


@pytest.mark.parametrize("slope", [pytest.param(0.7, marks=pytest.mark.long), 0.9])
def test_no_step_leads_across_a_branch_point_onto_the_other_branch(slope):
    # One branch crosses the other at an angle of 0.05 to 0.2, and a step ends beside both.
    for r in (-1.05, -1.0, -0.95, -0.9):
        model = sf.System(
            parameters={"r": r, "b": slope},
            states={"x": {"rate": "(x - r - 4*r^3)*(x - b*r)", "start": r + 4 * r**3}},
        )
        steps = sf.Settings(steps=sf.Steps(largest=0.3))
        curved, straight = sf.response(model, "r", (r, 1.3), settings=steps).branches
        assert (kinds(curved), kinds(straight)) == (["BP"], ["BP"])
        assert straight.states[:, 0] == pytest.approx(slope * straight.parameter, abs=1e-9)


@pytest.mark.parametrize(
    ("power", "apart"), [pytest.param(2, 1e-4, marks=pytest.mark.long), (3, 3e-5)]
)
def test_branch_points_close_together_are_distinguished(power, apart):
    states = {
        name: {"rate": f"(r + {shift}*e)*{name} - {name}^{power}", "start": 0.0}
        for name, shift in (("x", 1), ("y", 0), ("z", -1))
    }
    model = sf.System(parameters={"r": -1.0, "e": apart}, states=states)
    rest, *others = sf.response(model, "r", (-1.0, 1.3)).branches
    values = [point.value for point in rest.special]
    assert values == pytest.approx([-apart, 0.0, apart], abs=1e-9)
    assert {point.leads_to for point in rest.special} == {2, 3, 4}
    if power == 2:  # each branch has r - e, r, r + e, or zero for a state, and crosses three
        assert [len(branch.special) for branch in others] == 7 * [3]
    else:
        first = next(branch for branch in others if branch.states[:, 0].any())
        assert len(first.special) == 5  # those of y and z on both its halves


@pytest.mark.parametrize("growth", ["r*z - z^2", "r*z - z^3"])
def test_cycles_meet_cycles(growth):
    # A cycle of radius one in the plane z = 0; off the plane another with z = r or z^2 = r.
    states = {"x": "x*(1 - x^2 - y^2) - y", "y": "y*(1 - x^2 - y^2) + x", "z": growth}
    model = sf.System(parameters={"r": -0.4}, states=states)
    cycle = sf.periodic_orbit(model, state=[1, 0, 0], duration=6)
    flat, other = sf.response(cycle, vary="r", span=(-0.4, 0.4), settings=ALONE).branches
    assert (kinds(flat), kinds(other)) == (["BP"], ["BP"])
    assert flat.special[0].value == pytest.approx(0, abs=1e-12)
    assert flat.special[0].duration == pytest.approx(2 * np.pi, rel=1e-11)
    height, r = other.states[:, 2], other.parameter
    assert (height if "z^2" in growth else height**2) == pytest.approx(r, abs=1e-9)
    assert np.abs(height[[0, -1]]) == pytest.approx(np.abs(height[0]), rel=1e-9)


def test_lorenz_convection_and_its_hopf_points():
    # Lorenz (1963): pitchfork at rho = 1; Hopf at sigma (sigma + beta + 3)/(sigma - beta - 1).
    model = model_named("lorenz")
    settings = sf.Settings(largest_period=1, steps=sf.Steps(points=20))
    diagram = sf.response(model, vary="rho", span=(0.5, 28), settings=settings)
    rest, still, *cycles = diagram.branches
    assert (kinds(rest), kinds(still)) == (["BP"], ["HB", "BP", "HB"])
    s, b = model.sigma, model.beta
    for item, cycle in zip(still.special[::2], cycles, strict=True):
        assert item.value == pytest.approx(s * (s + b + 3) / (s - b - 1), abs=1e-10)
        assert item.criticality == "subcritical"
        # The pair is +-i sqrt(beta (sigma + rho)).
        assert item.duration == pytest.approx(2 * np.pi / np.sqrt(b * (s + item.value)), rel=1e-9)
        assert item.leads_to == cycle.id
    rho = still.parameter
    assert still.states[:, 0] ** 2 == pytest.approx(b * (rho - 1), abs=1e-8)


HARDENING = sf.System(
    parameters={"F": 1.0},
    states={"q": "v", "v": "F*cos(t) - 0.2*v - q - q^3"},
    forcing={"period": "2*pi"},
)


def test_symmetry_breaking_of_the_forced_duffing_oscillator():
    # The symmetric orbit, q(t + T/2) = -q(t), loses its symmetry and regains it; the branch of
    # those without it is closed, and its halves are images under that symmetry.
    main, other = sf.response(HARDENING, vary="F", span=(0, 12), settings=ALONE).branches
    assert [(item.type, item.leads_to) for item in main.special] == [("BP", 2), ("BP", 2)]
    assert (kinds(other), other.stopped.kind) == (["BP", "BP"], "closed")
    half = main.nodes.shape[1] // 2
    assert np.roll(main.nodes, half, axis=1) == pytest.approx(-main.nodes, abs=1e-9)
    # Some point of the second half has an image on the first.
    low, high = other.extrema.of("q")
    assert high.max() == pytest.approx(-low.min(), rel=1e-3)
    for item, again in zip(other.special, main.special, strict=True):
        assert abs(item.value - again.value) <= item.uncertainty + again.uncertainty
        assert item.uncertainty < 1e-12


def test_multipliers_at_a_branch_point_are_as_uncertain_as_its_place_makes_them():
    # Two computations may agree by chance; what rounding can do to the place remains.
    main, _ = sf.response(HARDENING, vary="F", span=(0, 12), settings=ALONE).branches
    for point in main.special:
        after = int(np.searchsorted(main.parameter, point.value))
        ends = slice(after - 1, after + 1)
        slopes = np.abs(np.diff(main.multipliers[ends], axis=0)[0] / np.diff(main.parameter[ends]))
        assert np.all(point.multiplier_uncertainty > 0.4 * slopes * point.uncertainty)


def test_freire_circuit_beyond_its_branch_point():
    # AUTO's demo tor, and textbook values by two methods: the branch that leaves the symmetric
    # cycles has a torus and a period doubling, once on each half.
    diagram = sf.response(model_named("freire"), vary="n", span=(-0.55, -0.64), settings=ALONE)
    _, symmetric, other = diagram.branches
    assert (kinds(symmetric), kinds(other)) == (["LP", "BP"], ["PD", "NS", "BP", "NS", "PD"])
    assert other.special[2].value == pytest.approx(-0.587029, abs=1e-6)
    assert other.special[2].duration == pytest.approx(8.68967, abs=1e-5)
    for item in (other.special[1], other.special[3]):
        assert item.value == pytest.approx(-0.5916501950321, abs=1e-12)
        assert item.duration == pytest.approx(8.794151746402, abs=1e-10)
        assert item.critical_multiplier == pytest.approx(0.82017809 + 0.5721083j, abs=1e-7)
    for item in (other.special[0], other.special[4]):
        assert item.value == pytest.approx(-0.6149552211380, abs=1e-12)
        assert item.duration == pytest.approx(9.266303320566, abs=1e-10)


@pytest.mark.parametrize("e", [1e-6, 2e-10, 2e-11])
def test_a_pitchfork_that_misses_itself_is_a_fold(e):
    # r x - x^3 + e: the middle state, x = -e/r at first, turns at r = 3 (e/2)^(2/3).
    model = system("imperfect", x={"rate": f"r*x - x^3 + {e}", "start": 0})
    branch, *others = sf.response(model, vary="r", span=(1, -1)).branches
    assert kinds(branch) == ["LP"]
    assert branch.special[0].value == pytest.approx(3 * (e / 2) ** (2 / 3), rel=1e-5, abs=0)
    assert (branch.parameter[-1], others) == (1, [])


def test_cycles_that_miss_a_pitchfork_have_a_fold():
    # The same with e = 1e-7, beside a circle that is followed round.
    turning = {"u": "u*(1 - u^2 - v^2) - v", "v": "v*(1 - u^2 - v^2) + u"}
    model = sf.System(parameters={"r": 1.0}, states={"x": "r*x - x^3 + 1e-7", **turning})
    cycle = sf.periodic_orbit(model.with_scales(np.ones(3)), state={"x": -1e-7, "u": 1, "v": 0})
    (branch,) = sf.response(cycle, vary="r", span=(1, -1)).branches
    assert kinds(branch) == ["LP"]
    assert branch.special[0].value == pytest.approx(3 * 5e-8 ** (2 / 3), rel=1e-5, abs=0)


def test_branches_that_only_begin_alike_are_all_followed():
    # No symmetry exchanges x and y: their pitchforks differ in the terms of fifth order.
    rates = {"x": "r*x - x^3 + 10*x^5", "y": "r*y - y^3 - 10*y^5"}
    model = sf.System(parameters={"r": 0.0}, states=rates)
    assert len(sf.response(model, vary="r", span=(-0.1, 0.01)).branches) == 4
