"""Forced orbits, cycles and equilibria: what each is watched for, and what is born at it."""

from functools import lru_cache

import numpy as np
import pytest

import slipfold as sf
from slipfold.models import model_named
from slipfold.orbits.eigenvalues import Cayley
from slipfold.orbits.kinds import Cycles, Equilibria, ForcedOrbits, orbits_of
from slipfold.orbits.orbit_curve import OrbitPoint
from slipfold.orbits.test_functions import floquet_multipliers


@lru_cache
def special(name, vary, span, kind):
    settings = sf.Settings(largest_period=1)
    diagram = sf.response(model_named(name), vary=vary, span=span, settings=settings)
    return next(item.point for item in diagram.special if item.point.type == kind)


HOPF = "lure", "a", (1.2, 0.9), "HB"


def point_of(orbits, z):
    """An equilibrium as a point of which nothing but its multipliers is asked."""
    matrix = orbits.linearise(z).monodromy
    values = floquet_multipliers(matrix)
    return OrbitPoint(z, z, 0.0, {}, 0, 0.0, monodromy=matrix, multipliers=values)


@pytest.mark.parametrize(
    ("name", "resting", "kind", "tests"),
    [
        ("sliding", False, ForcedOrbits, {"PD", "fold", "NS", "LP"}),
        ("lure", False, Cycles, {"PD", "fold", "NS", "LP"}),
        ("lure", True, Equilibria, {"fold", "HB", "LP"}),
    ],
)
def test_a_branch_is_watched_for_what_its_orbits_can_have(name, resting, kind, tests):
    model = model_named(name)
    orbits = orbits_of(model, {"Nd" if model.forced else "a": 1.0}, 1, 8, resting=resting)
    assert type(orbits) is kind
    watched = orbits.tests(np.zeros(1), None, np.array([0.5 + 0j, 0.2]), np.ones(1))
    assert set(watched) == tests


def test_however_eigenvalues_are_seen_they_are_those_of_the_jacobian():
    item = special(*HOPF)
    model = item.model.replace(a=0.93)
    rest = model.start
    a, b = model.a, model.b
    x = rest[0]
    # x''' + a x'' + b x' + x (1 - x) = 0 about x = 0: s^3 + a s^2 + b s + 1 - 2 x.
    values = np.roots([1, a, b, 1 - 2 * x])
    for spectrum in (None, Cayley()):
        orbits = Equilibria(model, {"a": 1.0}, spectrum)
        z = orbits.pack(rest[None], a)
        listed = orbits.multipliers(point_of(orbits, z))
        lasting = orbits.duration(z) or model.values["duration"]
        assert np.sort_complex(listed) == pytest.approx(
            np.sort_complex(np.exp(values * lasting)), rel=1e-9
        )
