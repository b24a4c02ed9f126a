"""Every value of loci.json and, on loci, of sliding.json; both by methods that share no code.

The first is by Fourier collocation (bench/by_hand/loci.py), the second was handed over.
"""

import json
import math
from functools import lru_cache
from pathlib import Path

import numpy as np
import pytest

from helpers.bifurcation_sets import PLANES, bifurcations, crossings, response, whole_set
from helpers.reference import PRINTED, model_values
from slipfold import SlidingOscillator
from slipfold.bifurcations.loci.follow import follow_loci

LOCI = json.loads((Path(__file__).parents[1] / "reference" / "loci.json").read_text())
FORCE = ("f", "Nd")
WIDE = ((10.2, 14.5), (0.0, 0.98))
CLOSE = 1e-9


@lru_cache(maxsize=8)
def followed(plane, window, kind, period, values=(("f", 12.5),)):
    """Loci from the special points of responses in Nd."""
    base = SlidingOscillator(**dict(values))
    span = (0.0, 0.98 * base.Ns)
    points = [p for p in bifurcations(response("Nd", span, values), kind) if p.period == period]
    return follow_loci(points, plane, window, switch=False)


def locus(kind, period):
    f = 12.2 if kind == "LP" else 12.5
    (found,) = followed(FORCE, WIDE, kind, period, (("f", f),))
    return found


def state_gap(crossing, item):
    """Distance of states, scaled, at any phase that an orbit may begin in."""
    scales = crossing.locus.model.replace(**plane_values(crossing)).state_scales()
    each = len(crossing.nodes) // crossing.locus.period
    return np.abs((crossing.nodes[::each] - item["state"]) / scales).max(axis=1).min()


def plane_values(crossing):
    return dict(zip(crossing.locus.vary, map(float, crossing.values), strict=True))


def check_points(loci, items):
    """Each point given lies on one of the loci, with its state and its angle."""
    for item in items:
        names = loci[0].vary
        expected = [item[name] for name in names]
        # A point given by its force is held there: the locus may be steep in either direction.
        near = min(
            (c for axis in (0, 1) for c in crossings(loci, axis, expected[axis])),
            key=lambda c: np.abs(c.values - expected).max(),
        )
        assert near.values == pytest.approx(expected, abs=CLOSE)
        assert state_gap(near, item) < CLOSE
        if "b" in item:
            assert near.coefficient == pytest.approx(item["b"], rel=1e-7)
            assert near.criticality == ("supercritical" if item["b"] > 0 else "subcritical")
        if "theta" in item:
            angles = np.angle(near.multipliers[near.multipliers.imag > 0])
            assert np.abs(angles - item["theta"]).min() < 1e-8


def check_special(loci, kind, items, name=None):
    """The loci have exactly these special points of a type."""
    found = [
        p for item in loci for p in item.special
        if p.type == kind and (name is None or p.name.endswith(f" {name}"))
    ]  # fmt: skip
    assert len(found) == len(items)
    for item in items:
        expected = [item[parameter] for parameter in loci[0].vary]
        near = min(found, key=lambda p: np.abs(np.subtract(p.values, expected)).max())
        assert near.values == pytest.approx(expected, abs=CLOSE)
        each = len(near.nodes) // near.period
        gaps = np.abs((near.nodes[::each] - item["state"]) / near.model.state_scales())
        assert gaps.max(axis=1).min() < 1e-8
        assert max(near.uncertainty) < 1e-9


# -- loci.json ---------------------------------------------------------------------------------

DOUBLING, FOLD, TORUS = LOCI["PD_period_1"], LOCI["LP_period_2"], LOCI["NS_period_2"]


def test_doubling():
    found = locus("PD", 1)
    check_points([found], DOUBLING["points"])
    check_special([found], "MIN", DOUBLING["least_Nd"], "Nd")
    check_special([found], "GPD", LOCI["GPD"][0]["points"])


def test_criticality_changes_at_generalized_period_doublings_alone():
    found = locus("PD", 1)
    places = [p.arclength for p in found.special if p.type == "GPD"]
    inside = np.searchsorted(places, found.arclength) == 1
    assert np.array_equal(found.supercritical, inside)
    assert np.array_equal(found.subcritical, ~inside)


@pytest.mark.parametrize("given", LOCI["GPD"][1:], ids=lambda item: f"{item['plane']},{item['f']}")
def test_generalized_period_doublings_in_other_planes(given):
    plane, (_, low, high) = tuple(given["plane"]), given["searched"]
    window = ((low, high), (0.0, 0.98))
    found = followed(plane, window, "PD", 1, (("f", given["f"]),))
    check_special(found, "GPD", given["points"])


def test_fold_of_period_two():
    found = locus("LP", 2)
    check_points([found], FOLD["points"])
    # At a cusp both parameters are extreme; it counts once, as a cusp.
    check_special([found], "CPC", FOLD["CPC"])


def check_torus(loci, given, first):
    check_points(loci, given["points"] + given["extreme_theta"])
    for kind in ("R3", "R4", "CH"):
        check_special(loci, kind, given[kind])
    for name in (first, "Nd"):
        items = given[f"extreme_{name}"]
        turns = [p for item in loci for p in item.special if p.name.endswith(f"t {name}")]
        assert len(turns) == len(items)
        for kind in ("MIN", "MAX"):
            some = [p for p in turns if p.type == kind]
            near = [
                item for item in items
                if any(abs(p.values[0] - item[first]) < 1e-6 for p in some)
            ]  # fmt: skip
            check_special(loci, kind, near, name)


def test_torus_of_period_two():
    check_torus([locus("NS", 2)], TORUS["f_Nd"], "f")


@pytest.mark.long
def test_torus_of_period_two_in_speed_and_force():
    loci = followed(("Vd", "Nd"), ((0.3, 1.2), (0.0, 0.98)), "NS", 2)
    check_torus(loci, TORUS["Vd_Nd_at_f_12.5"], "Vd")


@pytest.mark.long
@pytest.mark.parametrize("item", DOUBLING["scaling_at_f_12.5"], ids=lambda item: next(iter(item)))
def test_doubling_in_planes_of_friction_and_load(item):
    name = next(iter(item))
    loci = whole_set((name, "Nd")).loci
    check_points([one for one in loci if one.type == "PD"], [item])


# -- sliding.json ------------------------------------------------------------------------------


def within(value):
    """Compare to all digits given."""
    return pytest.approx(float(value), rel=0, abs=value.unit)


@pytest.mark.parametrize(("f", "Nd"), PRINTED["pd_locus_f_Nd"])
def test_doublings_handed_over(f, Nd):
    (crossing,) = crossings([locus("PD", 1)], 0, float(f))
    assert crossing.values[1] == within(Nd)
    assert abs(crossing.values[1] - float(Nd)) < 1e-8


def check_line(found, item, index):
    """A line through a set of loci meets all that is given and nothing else."""
    for period in (1, 2):
        here = sorted((c for c in found if c.locus.period == period), key=lambda c: c.values[index])
        expected = sorted(item[f"period{period}"], key=lambda entry: entry[1])
        assert [c.locus.type for c in here] == [entry[0] for entry in expected]
        for crossing, (_, value, *rest) in zip(here, expected, strict=True):
            assert crossing.values[index] == within(value)
            assert [crossing.criticality] == rest or not rest


def planes_of(item):
    """Planes whose window holds what a force response was computed at."""
    usual = {"f": 12.5, "Vd": 0.6, "Ns": 1.0, "mu": 0.5, "alpha": math.pi / 3}
    base = usual | model_values(item["set"])
    for plane, (span, (_, highest)) in PLANES.items():
        name = plane[0]
        same = all(base[key] == usual[key] for key in usual if key != name)
        inside = span[0] <= base[name] <= span[1]
        reached = all(entry[1] <= highest for k in (1, 2) for entry in item[f"period{k}"])
        if same and inside and reached:
            yield plane, base[name]


LONG = [pytest.mark.long]
FORCED = [
    pytest.param(p, value, item, id=f"{p[0]}={value:.4g}", marks=LONG * (p[0] != "f"))
    for item in PRINTED["force_response"]
    for p, value in planes_of(item)
]


@pytest.mark.parametrize(("plane", "value", "item"), FORCED)
def test_special_points_of_force_responses(plane, value, item):
    check_line(crossings(whole_set(plane).loci, 0, value), item, 1)


@pytest.mark.parametrize(
    "item", PRINTED["frequency_response"], ids=lambda item: f"Nd={item['set']['Nd']}"
)
def test_special_points_of_frequency_responses(item):
    loci = whole_set(FORCE).loci
    check_line(crossings(loci, 1, float(item["set"]["Nd"])), item, 0)
