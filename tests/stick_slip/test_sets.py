"""Sets of bifurcations of models whose contacts stick: the curve on which they begin to."""

import numpy as np
import pytest

import slipfold as sf

WINDOW = {"Vd": (0.5, 1.5), "f": (0.05, 0.35)}


def shaken(load, law=None):
    """A mass on a belt that a force shakes: k = m = F = 1, c = 0.1."""
    law = law or sf.Coulomb(mu_s=1.0, mu_k=1.0)
    contact = sf.FrictionContact("x", law, load=load, Vd=1.0)
    force = sf.HarmonicForce("x", F=1.0)
    return sf.Structure(
        [[1.0]], [[0.1]], [[1.0]], names="x", contacts=contact, forcing=force, f=0.25
    )


def fastest(frequency):
    """The amplitude of the mass' velocity as long as it slips: that of a linear oscillator.

    Constant friction moves the mass aside and does nothing else, however large it is.
    """
    w = 2 * np.pi * frequency
    return w / np.hypot(1 - w**2, 0.1 * w)


@pytest.fixture(scope="module")
def loci():
    """All of the set but regions."""
    return sf.bifurcation_set(shaken(0.7), ("Vd", "f"), WINDOW, regions=False).loci


def test_the_mass_begins_to_stick_where_it_is_as_fast_as_the_belt(loci):
    assert [(locus.type, locus.period) for locus in loci] == [("GRAZE", 1)] * 2
    for locus in loci:
        speed, frequency = locus.values.T
        assert speed == pytest.approx(fastest(frequency), rel=1e-9)


def test_the_curve_reaches_from_edge_to_edge(loci):
    ends = [end for locus in loci for end in (locus.begun, locus.stopped)]
    assert {end.kind for end in ends} == {"window"}
    found = np.array(sorted(end.values for end in ends))
    for speed, frequency in found:
        assert speed == pytest.approx(fastest(frequency), rel=1e-6)
    slowest, *fastest_belts = found[[0, 2, 3], 0]
    assert slowest == pytest.approx(0.5, abs=1e-9)
    assert fastest_belts == pytest.approx([1.5, 1.5], abs=1e-9)
    assert found[1, 1] == pytest.approx(0.35, abs=1e-9)


def test_a_law_without_stick_has_no_such_loci():
    smooth = sf.Regularised(sf.Coulomb(mu_s=1.0, mu_k=1.0), "sqrt", e=0.01)
    with pytest.raises(sf.InputError, match="none of whose contacts sticks"):
        sf.bifurcation_set(shaken(0.4, smooth), ("Vd", "f"), WINDOW, types="GRAZE", regions=False)
