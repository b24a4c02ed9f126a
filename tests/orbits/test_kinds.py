"""Forced orbits, cycles and equilibria: what each is watched for, and what is born at it."""

from functools import lru_cache

import numpy as np
import pytest

import slipfold as sf
from slipfold.models import model_named
from slipfold.orbits.critical import doubled_orbit, hopf_cycle
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
FLIP = "lure", "a", (1.2, 0.62), "PD"
FORCED_FLIP = "sliding", "Nd", (0.0, 0.4), "PD"


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


@pytest.mark.parametrize("where", [FLIP, FORCED_FLIP], ids=["cycle", "forced"])
def test_an_orbit_passed_twice_solves_the_equations_and_its_tangent_is_in_their_kernel(where):
    item = special(*where)
    orbits = orbits_of(item.model, {item.vary: 1.0}, 1, len(item.nodes))
    born = doubled_orbit(orbits, orbits.unknown(item.nodes, item.model))
    assert born.orbits.period == 2
    assert np.abs(born.orbits.defect(born.z)).max() < 1e-9
    part = born.orbits.linearise(born.z)
    assert np.abs(part.jacobian @ born.tangent).max() < 1e-6
    values, expected = (np.linalg.eigvals(each) for each in (born.monodromy, part.monodromy))
    assert np.sort_complex(values) == pytest.approx(np.sort_complex(expected), abs=1e-6)


def test_a_cycle_of_no_amplitude_solves_the_equations_and_its_tangent_is_in_their_kernel():
    item = special(*HOPF)
    orbits = Equilibria(item.model, {"a": 1.0})
    born = hopf_cycle(orbits, orbits.unknown(item.nodes[:1], item.model))
    assert isinstance(born.orbits, Cycles)
    assert born.orbits.duration(born.z) == pytest.approx(2 * np.pi, rel=1e-9)  # b = 1
    assert np.abs(born.orbits.defect(born.z)).max() < 1e-9
    assert np.abs(born.orbits.linearise(born.z).jacobian @ born.tangent).max() < 1e-6
    # The pair is the flow's direction and the one beside it, which neither grows nor shrinks.
    values = np.linalg.eigvals(born.monodromy)
    assert np.abs(values - 1).min() < 1e-6
    assert len(values) == 2
