"""Labels of regions against the stable orbits of responses through random places."""

import numpy as np
import pytest

from helpers.bifurcation_sets import OFTEN, PLANES, orbits_at, response, whole_set
from slipfold import InputError, SlidingOscillator, periodic_orbit
from slipfold.bifurcations.loci import isolated
from slipfold.bifurcations.loci.region_votes import REGIONS, Raster

ALL = [OFTEN, *(pytest.param(plane, marks=pytest.mark.long) for plane in PLANES if plane != OFTEN)]


def stable_periods(plane, place):
    """Periods of the stable orbits that responses in either direction have at a place."""
    found = set()
    here = dict(zip(plane, map(float, place), strict=True))
    for axis in (0, 1):
        fixed, vary = plane[axis], plane[1 - axis]
        try:
            branches = response(vary, PLANES[plane][1 - axis], ((fixed, here[fixed]),))
        except InputError:
            continue
        for branch in branches:
            for nodes in orbits_at(branch, here[vary]):
                model = SlidingOscillator(**here)
                # Newton's method for an orbit given to rounding; what counts are multipliers.
                orbit = periodic_orbit(model, branch.period, nodes[0])
                if orbit.stable:
                    found.add(branch.period)
    return found


@pytest.mark.parametrize("border", [-1e-20, 1 + 2e-16])
def test_a_line_on_the_border_is_drawn_where_rounding_puts_it_beyond(border):
    drawn = np.zeros((REGIONS.cells, REGIONS.cells), bool)
    Raster(((0, 1), (0, 1))).draw(drawn, np.array([[border, 0.0], [border, 1.0]]))
    assert drawn[:, round(border) * (REGIONS.cells - 1)].all()


def away_from_edges(regions, first, second, reach=4):
    """Whether all cells about a place belong to one region."""
    column = int(np.abs(regions.first - first).argmin())
    row = int(np.abs(regions.second - second).argmin())
    about = regions.labels[
        max(row - reach, 0) : row + reach + 1, max(column - reach, 0) : column + reach + 1
    ]
    return len(np.unique(about)) == 1


def check_labels(plane, count, seed=20260107):
    regions = whole_set(plane, regions=True).regions
    rng = np.random.default_rng(seed)
    places = rng.uniform(*np.transpose(PLANES[plane]), size=(count, 2))
    same = 0
    for place in places:
        if not away_from_edges(regions, *place):
            continue
        region = regions.at(*place)
        found = stable_periods(plane, place)
        # What a response has is there; a stable orbit need not be connected with the response.
        assert found <= set(region.stable), place
        assert region.consistent
        same += found == set(region.stable)
    return same


def test_labels_at_random_places():
    assert check_labels(OFTEN, 3) >= 2


@pytest.mark.long
@pytest.mark.parametrize("plane", PLANES, ids=",".join)
def test_labels_at_many_places(plane):
    assert check_labels(plane, 120) >= 95


@pytest.mark.parametrize("plane", ALL)
def test_simulations_agree_with_the_labels(plane):
    regions = whole_set(plane, regions=True).regions.regions
    for region in regions:
        assert region.consistent
        for check in region.checks:
            assert check.agrees, check.note
            assert check.note
        if region.fraction > 2e-3:
            starts = [check.start for check in region.checks]
            assert starts[0] == "rest"
            assert set(starts[1:]) == {f"period {period}" for period in region.stable}


@pytest.mark.parametrize("plane", ALL)
def test_regions_cover_the_window(plane):
    found = whole_set(plane, regions=True).regions
    assert found.labels.min() >= 1
    assert [region.id for region in found.regions] == list(range(1, len(found.regions) + 1))
    assert sum(region.fraction for region in found.regions) == pytest.approx(1.0, abs=5e-3)
    for region in found.regions:
        assert found.at(*region.place) is region
        area = np.mean(found.labels == region.id)
        assert area == pytest.approx(region.fraction, abs=0.01)


def test_the_plane_of_frequency_and_force_has_every_kind_of_region():
    regions = whole_set(OFTEN, regions=True).regions
    assert {region.stable for region in regions.regions} == {(), (1,), (2,), (1, 2)}
    # Between the doublings and tori of loci.json.
    for f, Nd, stable in (
        (12.55, 0.02, (1,)), (12.55, 0.3, ()), (13.0, 0.1, (1,)), (13.0, 0.22, (2,)),
        (13.0, 0.5, ()), (12.2, 0.03, (1,)), (12.2, 0.1, (1, 2)), (12.2, 0.3, (2,)),
        (13.4, 0.9, (2,)),
    ):  # fmt: skip
        assert regions.at(f, Nd).stable == stable, (f, Nd)


def test_an_orbit_is_known_whatever_segments_it_was_computed_in():
    orbit = periodic_orbit(SlidingOscillator(f=12.5, Nd=0.3), period=2)
    finer = np.repeat(orbit.nodes, 2, axis=0)  # as many nodes as twice the segments have
    later = np.roll(finer, len(finer) // 2, axis=0)  # started in the other forcing period
    for nodes in (finer, later):
        assert isolated.is_among(orbit.model, nodes, 2, [orbit.nodes])
    assert not isolated.is_among(orbit.model, 1.1 * finer, 2, [orbit.nodes])
