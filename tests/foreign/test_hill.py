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
from slipfold.explorer.views.plane import plane_view
from slipfold.loci import bifurcation_set as search

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
    return bifurcation_set(System.from_toml(HILL), ("a", "q"), WINDOW)


def multipliers(a, q):
    """Floquet multipliers of x = 0."""

    def rates(t, y):
        stiffness = a - 2 * q * (np.cos(2 * t) + np.cos(4 * t) / 2)
        x, v = y.reshape(2, 2)
        return np.concatenate([v, -0.04 * v - stiffness * x])

    end = solve_ivp(rates, (0, np.pi), np.eye(2).ravel(), method="DOP853", rtol=1e-12, atol=1e-13)
    return np.linalg.eigvals(end.y[:, -1].reshape(2, 2))


def settled(a, q, x, v):
    """States that motions have come to, and whether they repeat after a period.

    Shapes: a, q, x, v (n,).
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
    return np.stack([x, v], axis=-1), np.hypot(after[0] - x, after[1] - v) < 1e-5


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


def test_loci_of_branch_points_are_kept_and_shown(found, tmp_path):
    found.save(tmp_path / "set.nc")
    again = load(tmp_path / "set.nc")
    kinds = [locus.type for locus in found.loci]
    assert [locus.type for locus in again.loci] == kinds
    assert found.to_json() == again.to_json()
    assert set(plane_view(found)["regions"]["known"].values()) == {True}


def test_a_region_that_a_pitchfork_divides_is_not_known_without_its_locus(monkeypatch, tmp_path):
    def nothing(points, *others):
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
    assert "not true all over it" in diagram.summary()
    record = diagram.to_json()["regions"][0]
    assert (record["name"], record["known"]) == ("unknown", False)
    shown = plane_view(diagram)["regions"]
    assert (shown["names"], shown["stable"], shown["known"]) == ({"1": "unknown"}, {}, {"1": False})
