"""Sets of models whose contacts stick: where they begin to, and what lies beyond."""

import numpy as np
import pytest
from scipy.optimize import brentq

import slipfold as sf
from helpers.dry_friction import DUFFING_ON_BELT, belt, highest_after_a_touch, sliding

WINDOW = {"Vd": (0.5, 1.5), "f": (0.16, 0.35)}


def shaken(load, law=None):
    """A mass on a belt that a force shakes: k = m = F = 1, c = 0.1."""
    law = law or sf.Coulomb(mu_s=1.0, mu_k=1.0)
    return belt(law, 1.0, 0.1, load=load, force=1.0, f=0.25)


def fastest(frequency):
    """The amplitude of the mass' velocity as long as it slips: that of a linear oscillator.

    Constant friction moves the mass aside and does nothing else, however large it is.
    """
    w = 2 * np.pi * frequency
    return w / np.hypot(1 - w**2, 0.1 * w)


@pytest.fixture(scope="module", params=[0.16, pytest.param(0.05, marks=pytest.mark.long)])
def found(request):
    """The set from a frequency on, found from few lines: one side of the resonance, or both."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("slipfold.bifurcations.loci.bifurcation_set.LINES", (1, 1))
        return sf.bifurcation_set(shaken(0.7), ("Vd", "f"), WINDOW | {"f": (request.param, 0.35)})


def grazes(found):
    """Where the mass only just comes to rest on the belt."""
    return [locus for locus in found.loci if locus.type == "GRAZE"]


def test_the_mass_begins_to_stick_where_it_is_as_fast_as_the_belt(found):
    sides = 2 if found.window[1][0] < 0.1 else 1
    assert [(locus.type, locus.period) for locus in grazes(found)] == [("GRAZE", 1)] * sides
    assert {locus.type for locus in found.loci} == {"GRAZE", "STICK"}
    for locus in grazes(found):
        speed, frequency = locus.values.T
        assert speed == pytest.approx(fastest(frequency), rel=1e-9)


def test_the_curve_reaches_from_edge_to_edge(found):
    ends = [end for locus in grazes(found) for end in (locus.started, locus.stopped)]
    assert {end.kind for end in ends} == {"window"}
    edges = [(0.5, 0.06598248), (0.5723278, 0.35), (1.5, 0.11512378), (1.5, 0.2200266)]
    places = np.array(sorted(end.values for end in ends))
    assert places == pytest.approx(np.array(edges if len(ends) > 2 else edges[1::2]), rel=1e-6)
    off = np.abs(places[:, :1] - WINDOW["Vd"]).min(axis=1), np.abs(places[:, 1] - 0.35)
    assert np.minimum(*off).max() < 1e-9


def test_a_region_says_whether_the_mass_stops(found):
    lowest, _ = found.window[1]
    for frequency in [f for f in (0.07, 0.14, 0.17, 0.22, 0.32) if f > lowest]:
        for speed in (0.6, 1.0, 1.4):
            region = found.regions.at(speed, frequency)
            assert region.stable == (1,)
            assert bool(region.sticking) == (speed < fastest(frequency))


def test_motions_at_random_places_are_as_regions_say(found):
    random, (lowest, _) = np.random.default_rng(20261123), found.window[1]
    for speed, frequency in random.uniform((0.5, lowest), (1.5, 0.35), (6, 2)):
        if abs(speed - fastest(frequency)) < 0.02:
            continue
        region = found.regions.at(speed, frequency)
        motion = sf.simulate(shaken(0.7), 200, Vd=speed, f=frequency)
        stops = motion.sticking is not None and len(motion.sticking.intervals) > 20
        assert stops == bool(region.sticking)
        assert motion.settlement.period in region.stable


def test_a_law_without_stick_has_no_such_loci():
    smooth = sf.Regularized(sf.Coulomb(mu_s=1.0, mu_k=1.0), "sqrt", e=0.01)
    with pytest.raises(sf.InputError, match="none of whose contacts sticks"):
        sf.bifurcation_set(shaken(0.4, smooth), ("Vd", "f"), WINDOW, types="GRAZE", regions=False)


@pytest.mark.long
def test_cycles_on_a_belt_begin_to_stick_on_one_curve():
    law = sf.Stribeck(mu_s=1.0, mu_k=0.5, vs=0.5)
    window = {"Vd": (1.0, 2.5), "mu_k": (0.2, 0.9)}
    model, plane = belt(law, 1.8, damping=0.1), ("Vd", "mu_k")
    (locus,) = sf.bifurcation_set(model, plane, window, types="GRAZE", regions=False).loci
    assert (locus.id, locus.type) == (1, "GRAZE")
    for speed, kinetic in locus.values[::4]:
        near = 0.999 * speed, 1.001 * speed
        found = brentq(highest_after_a_touch, *near, args=(kinetic,), xtol=1e-12)
        assert found == pytest.approx(speed, abs=1e-9)


@pytest.mark.long
def test_in_the_plane_regions_say_where_the_tip_sticks():
    window = {"Vd": (0.045, 0.07), "Nd": (0.25, 0.35)}
    found = sf.bifurcation_set(sliding(0.3, 0.058), ("Vd", "Nd"), window)
    (locus,) = found.loci
    assert (locus.type, locus.started.kind, locus.stopped.kind) == ("GRAZE", "window", "window")
    assert {region.name for region in found.regions.regions} == {"period 1", "period 1, sticks"}
    for share in (-0.02, 0.02):
        for speed, pulsation in locus.values[2:-2:2]:
            beside = (1 + share) * speed
            motion = sf.simulate(sliding(pulsation, beside), 300)
            assert bool(motion.stuck_fraction) == (share < 0)
            assert bool(found.regions.at(beside, pulsation).sticking) == (share < 0)


WALL = '[outputs]\nroom = "x"\n[limits]\nwall = { output = "room", bound = -100.0 }\n'
BELT = DUFFING_ON_BELT.replace('"1.0"', '"1.0 + 0.5*x"').replace("0.3*x^3", "0.0*x^3") + WALL


def test_it_hides_none_from_branches_either():
    # Friction of that load only softens the spring, to 0.8.
    model = sf.System.from_toml(BELT).replace(A=0.3, W=1.2)
    (branch,) = sf.response(model, vary="W", span=(0.7, 0.775)).branches
    (point,) = branch.special
    assert point.type == "GRAZE"
    assert 0.3 * point.value == pytest.approx(np.hypot(0.8 - point.value**2, 0.1 * point.value))
    assert branch.stuck_fraction[-1] > 0


def test_a_second_stop_is_followed_if_its_type_is_given(few_lines):
    # A wedge: pressed harder on one side, the mass stops there, and from some place on twice.
    contact = {"slip": "-v", "normal": "1 + k*x", "friction": {"law": "Coulomb", "mu_k": 0.4}}
    model = sf.System(
        parameters={"W": 0.65, "k": 0.5},
        states={"x": "v", "v": "R - 0.04*v - x + 0.5*cos(W*t)"},
        contacts={"R": contact},
        forcing={"period": "2*pi/W"},
    )
    given = (("W", "k"), ((0.64, 0.69), (0.48, 0.52)))
    (locus,) = sf.bifurcation_set(model, *given, types="STICK", periods=1, regions=False).loci
    for frequency, slope in locus.values[1:-1:3]:
        near = frequency - 0.01, frequency + 0.01
        ((_, point),) = sf.response(model, "W", near, k=slope).special
        assert (point.type, point.value) == ("STICK", pytest.approx(frequency, abs=1e-9))
    found = sf.bifurcation_set(model, *given, periods=1, regions=False)
    assert found.loci == ()
    assert "only if their types are given" in found.summary()
