"""The damped Hill equation with a cubic spring: what loci of branch points bound.

x'' + 0.04 x' + (a - 2 q (cos 2t + cos(4t)/2)) x + x^3 = 0: Magnus and Winkler, Hill's Equation,
Wiley 1966, for x = 0 without damping. About a = 4 the rest position loses its stability with a
multiplier of one, about a = 1 with one of minus one. Other methods: Floquet multipliers of the
linear equation by SciPy's DOP853, and motions from many starts by a Runge-Kutta method of its own.
"""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from slipfold import System, bifurcation_set, load
from slipfold.bifurcations.loci import bifurcation_set as search
from slipfold.interface.explorer.curves import plane_view

HILL = """
name = "hill"
title = "damped Hill equation with a cubic spring"
[parameters]
a = { value = 4.2, doc = "mean stiffness" }
q = { value = 0.66, doc = "amplitude of the stiffness" }
[states]
x = { rate = "v", doc = "displacement" }
v = { rate = "-0.04*v - (a - 2*q*(cos(2*t) + cos(4*t)/2))*x - x^3", doc = "velocity" }
[forcing]
period = "pi"
"""
WINDOW = ((3.0, 6.0), (0.0, 1.0))
STEPS = 64
"""Runge-Kutta steps a period of pi."""
PERIODS = 300
"""Perturbations decay by exp(-0.02 pi) in each, but for those near a boundary."""
STARTS = 24


@pytest.fixture(scope="module")
def found():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("slipfold.bifurcations.loci.bifurcation_set.LINES", (1, 1))
        return bifurcation_set(System.from_toml(HILL), ("a", "q"), WINDOW)


def multipliers(a, q):
    """Floquet multipliers of x = 0."""

    def rates(t, y):
        stiffness = a - 2 * q * (np.cos(2 * t) + np.cos(4 * t) / 2)
        x, v = y.reshape(2, 2)
        return np.concatenate([v, -0.04 * v - stiffness * x])

    end = solve_ivp(rates, (0, np.pi), np.eye(2).ravel(), method="DOP853", rtol=1e-12, atol=1e-13)
    return np.linalg.eigvals(end.y[:, -1].reshape(2, 2))


def orbits_come_to(a, q, x, v):
    """States that motions have come to, and those one and two periods later.

    Shapes: a, q, x, v (n,); returns (n, 2).
    """
    h = np.pi / STEPS
    stiffness = [
        a - 2 * q * (np.cos(2 * t) + np.cos(4 * t) / 2) for t in np.arange(2 * STEPS + 1) * h / 2
    ]

    def period(x, v):
        for i in range(0, 2 * STEPS, 2):
            k = [(v, -0.04 * v - (stiffness[i] + x * x) * x)]
            for j, share in ((i + 1, 0.5), (i + 1, 0.5), (i + 2, 1.0)):
                moved, speed = x + share * h * k[-1][0], v + share * h * k[-1][1]
                k.append((speed, -0.04 * speed - (stiffness[j] + moved * moved) * moved))
            x = x + h / 6 * (k[0][0] + 2 * k[1][0] + 2 * k[2][0] + k[3][0])
            v = v + h / 6 * (k[0][1] + 2 * k[1][1] + 2 * k[2][1] + k[3][1])
        return x, v

    for _ in range(PERIODS):
        x, v = period(x, v)
    after = period(x, v)
    twice = period(*after)
    return [np.stack(end, axis=-1) for end in ((x, v), after, twice)]


def settled(a, q, x, v):
    """States that motions have come to, and whether they repeat after a period.

    Shapes: a, q, x, v (n,).
    """
    ends, after, _ = orbits_come_to(a, q, x, v)
    return ends, np.hypot(*(after - ends).T) < 1e-5


def distinct(states):
    """How many of the states are farther than rounding and slow decay from all before."""
    found = []
    for state in states:
        if all(np.abs(state - other).max() > 0.02 for other in found):
            found.append(state)
    return len(found)


def near_a_boundary(regions, a, q, reach=3):
    """Whether another label, or none, lies within some cells."""
    column = int(np.abs(regions.first - a).argmin())
    row = int(np.abs(regions.second - q).argmin())
    rows, columns = (slice(max(0, place - reach), place + reach + 1) for place in (row, column))
    return len(np.unique(regions.labels[rows, columns])) > 1


def test_branch_points_lie_where_the_rest_position_changes_its_stability(found):
    (crossing,) = (locus for locus in found.loci if locus.type == "BP")
    for a, q in crossing.values:
        assert np.abs(multipliers(a, q) - 1).min() < 1e-10
    assert np.abs(crossing.nodes).max() < 1e-12
    assert [point.type for point in crossing.special if point.type != "MIN"] == ["DP"]


def test_folds_begin_where_the_pitchfork_turns_hard(found):
    turns = {
        locus.type: point.values
        for locus in found.loci for point in locus.special if point.type == "DP"
    }  # fmt: skip
    assert set(turns) == {"LP", "BP"}
    assert turns["LP"] == pytest.approx(turns["BP"], abs=1e-6)


def test_fifty_random_places_have_the_motions_that_their_region_says(found):
    rng = np.random.default_rng(5)
    places = rng.uniform(*np.transpose(WINDOW), size=(50, 2))
    a, q = np.repeat(places, STARTS, axis=0).T
    x, v = rng.uniform([-2, -4], [2, 4], (50 * STARTS, 2)).T
    x[::STARTS], v[::STARTS] = 1e-3, 0.0
    states, repeats = settled(a, q, x, v)
    seen = set()
    for place, ends, still in zip(
        places, states.reshape(50, STARTS, 2), repeats.reshape(50, STARTS), strict=True
    ):
        region = found.regions.at(*place)
        assert region is not None
        rest = bool(np.abs(multipliers(*place)).max() < 1)
        assert still.all()
        motions = np.unique(np.round(ends, 2) + 0.0, axis=0)
        assert region.stable == (1,) * len(motions)
        assert rest == (not np.abs(motions).any(axis=1).all())
        seen.add(region.stable)
    assert seen == {(1,), (1, 1), (1, 1, 1)}


def test_all_regions_are_known_and_checked(found):
    assert all(region.known for region in found.regions.regions)
    assert "unknown" not in found.summary()
    assert found.checked.disagreeing == ()


ISOLATED = ((5.0, 6.0), (1.0, 1.5))
"""There a response of period 2 exists that a fold bears and nothing leads to."""


def test_a_branch_that_nothing_leads_to_is_found_by_motions_and_bounded_by_its_folds(few_lines):
    found = bifurcation_set(System.from_toml(HILL), ("a", "q"), ISOLATED)
    assert ("LP", 2) in {(locus.type, locus.period) for locus in found.loci}
    places = np.array([[5.67, 1.356], [5.2, 1.34], [5.97, 1.19], [5.1, 1.005]])
    a, q = np.repeat(places, 8 * STARTS, axis=0).T
    x, v = np.random.default_rng(2).uniform([-3, -6], [3, 6], (len(a), 2)).T
    states, repeats = settled(a, q, x, v)
    for place, ends, still in zip(
        places, states.reshape(4, -1, 2), repeats.reshape(4, -1), strict=True
    ):
        once = np.unique(np.round(ends[still], 2) + 0.0, axis=0)
        twice = np.unique(np.round(ends[~still], 2) + 0.0, axis=0)
        periods = (1,) * len(once) + (2,) * (len(twice) // 2)
        assert found.regions.at(*place).stable == periods


@pytest.mark.long
def test_a_wide_window_knows_every_motion_at_a_hundred_and_twenty_random_places():
    window = ((0.0, 6.0), (0.0, 1.5))
    regions = bifurcation_set(System.from_toml(HILL), ("a", "q"), window).regions
    places = np.random.default_rng(7).uniform(*np.transpose(window), size=(120, 2))
    starts = 8 * STARTS
    a, q = np.repeat(places, starts, axis=0).T
    x, v = np.random.default_rng(3).uniform([-4, -8], [4, 8], (len(a), 2)).T
    states, after, twice = orbits_come_to(a, q, x, v)
    moved = [np.hypot(*(end - states).T) for end in (after, twice)]
    sizes = moved[0] < 1e-4, (moved[1] < 1e-4) & (moved[0] > 1e-2)
    compared = same = 0
    for i, place in enumerate(places):
        if near_a_boundary(regions, *place):
            continue
        some = slice(i * starts, (i + 1) * starts)
        once, both = sizes[0][some], sizes[1][some]
        seen = (1,) * distinct(states[some][once]) + (2,) * (distinct(states[some][both]) // 2)
        said = regions.at(*place).stable
        # The label may know of a motion that none of so few starts comes to.
        assert all(seen.count(period) <= said.count(period) for period in (1, 2)), place
        compared, same = compared + 1, same + (seen == said)
    assert compared > 90
    assert same > 0.9 * compared


def test_a_region_that_a_pitchfork_divides_is_not_known_without_its_locus(
    monkeypatch, few_lines, tmp_path
):
    def nothing(points, *others, **options):
        list(points)
        return ()

    monkeypatch.setattr(search, "follow_found", nothing)
    window = ((3.9, 6.0), (0.55, 0.75))
    diagram = bifurcation_set(System.from_toml(HILL), ("a", "q"), window)
    (region,) = diagram.regions.regions
    assert (region.known, region.name) == (False, "unknown")
    diagram.save(tmp_path / "set.nc")
    assert diagram.regions.at(5.5, 0.66) is load(tmp_path / "set.nc").regions.at(5.5, 0.66) is None
    row = next(line for line in diagram.summary().splitlines() if "100.00%" in line)
    assert row.split()[1] == "unknown"
    assert "contradict the label" in diagram.summary()
    record = diagram.to_json()["regions"][0]
    assert (record["name"], record["known"]) == ("unknown", False)
    shown = plane_view(diagram)["regions"]
    assert (shown["names"], shown["stable"], shown["known"]) == ({"1": "unknown"}, {}, {"1": False})
