"""Points of the foreign systems that are known in closed form."""

import json
from math import cos, log, pi, sin, sqrt

import pytest

from helpers.foreign_systems import POINTS, Case

KNOWN = json.loads(POINTS.read_text())


def hopf_of_glycolysis():
    """b^4 + (2 a - 1) b^2 + a + a^2 = 0 (Strogatz, Nonlinear Dynamics and Chaos, section 7.3)."""
    a = 0.08
    for sign in (-1, 1):
        yield sqrt((1 - 2 * a + sign * sqrt(1 - 8 * a)) / 2)


def hopf_of_autocatalysis():
    """With b = mu and a = mu/(mu^2 + k), the trace 2 a b - 1 - b^2 - k vanishes."""
    k = 0.02
    for sign in (-1, 1):
        yield sqrt((1 - 2 * k + sign * sqrt(1 - 8 * k)) / 2)


def torus_of_langford():
    """Round the axis r' = (z - b) r, z' = c + a z - z^3/3 - r^2 (1 + e z): its trace at z = b."""
    a, b, e = 0.6, 0.7, 0.25
    yield (a - b**2) / e * (1 + e * b) - a * b + b**3 / 3


def folds_of_langford():
    """c + a z - z^3/3 turns where z^2 = a."""
    for sign in (-1, 1):
        yield sign * 2 / 3 * 0.6**1.5


def hopf_of_mode_coupling():
    """Stiffness has eigenvalues a +- i b; x'' + c x' is on the axis where b^2 = c^2 a."""
    k1, k2, k3, c = 11, 20, 11, 0.05
    k11, k12, k22 = (k1 + k2) * 3 / 4, (k2 - k1) * sqrt(3) / 4, (k1 + k2) / 4 + k3
    a = (k11 + k22) / 2
    yield (a**2 + c**2 * a - k11 * k22 + k12**2) / (k12 * k3)


def waves_of_lorenz():
    """With wave j round the ring: exp(-i t) turns x[i-1] (x[i+1] - x[i-2]) into F (e^it - e^-2it).

    Of 50 sites those that come first have j = 10 and 11.
    """
    for wave in (10, 11):
        turn = 2 * pi * wave / 50
        yield 1 / (cos(turn) - cos(2 * turn))


EXACT = {
    ("brusselator-0", "HB"): [1 + 1**2],
    ("brusselator-1", "HB"): [sqrt(3 - 1)],
    ("glycolysis-0", "HB"): hopf_of_glycolysis(),
    ("cubic_autocatalysis-0", "HB"): hopf_of_autocatalysis(),
    # Nonrotating damping over rotating damping: Genta's threshold, with a stiffness of 1.
    ("rotor-0", "HB"): [1 + 0.1 / 0.1],
    # The predator has n = m/(1 - m) where the prey's isocline has its top at n = (K - h)/2.
    ("predator_prey-0", "HB"): [1 + 2 * 0.3 / (1 - 0.3)],
    ("predator_prey-1", "HB"): [1 + 2 * 0.3 / (1 - 0.3)],
    # The predator enters where K/(h + K) = m.
    ("predator_prey-1", "BP"): [0.3 / (1 - 0.3)] * 2,
    ("langford-0", "NS"): torus_of_langford(),
    ("langford-0", "LP"): folds_of_langford(),
    # Loop gain 1 (Maggio, De Feo and Kennedy 1999).
    ("colpitts-0", "HB"): [1.0],
    # Sotomayor, Mello and Braga 2007: e = 2 a b^(3/2).
    ("governor-0", "HB"): [2 * 0.5 * 0.7**1.5],
    # The damping 2 z v of the first order is that of the wind, n U A1 v.
    ("galloping-0", "HB"): [2 * 0.00107 / (0.00043 * 2.69)],
    # Friction falls as fast as it is damped: d/s exp(-V/s) = c.
    ("belt-0", "HB"): [0.5 * log(0.2 / (0.5 * 0.05))],
    # The same of the lowest mode of 25 blocks, that the springs between them damp as well.
    ("friction_chain-0", "HB"): [0.5 * log(0.4 / (0.02 + 0.08 * sin(pi / 52) ** 2))],
    ("mode_coupling-0", "HB"): hopf_of_mode_coupling(),
    ("lorenz_96-0", "HB"): waves_of_lorenz(),
}


@pytest.mark.parametrize(("case", "kind"), EXACT)
def test_scipy_finds_what_is_known_in_closed_form(case, kind):
    values = [value for type_, _, value, _ in KNOWN[case]["points"] if type_ == kind]
    assert values == pytest.approx(sorted(EXACT[case, kind]), rel=1e-11)


def test_every_system_names_its_source():
    for case in KNOWN:
        assert len(Case(case.rpartition("-")[0], 0).file["source"]) > 20
