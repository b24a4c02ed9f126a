"""Shooting over meshes: the orbits of equal segments, on segments of other lengths."""

import numpy as np
import pytest

import slipfold as sf
from slipfold.continuation.newton import correct
from slipfold.models.registry import model_named
from slipfold.orbits.continued import hold_parameter
from slipfold.orbits.kinds import orbits_at
from slipfold.orbits.shooting import SEGMENT_GROWTH, MeshShooting


def over_a_mesh(orbit):
    """Return the orbits over a uniform mesh, and an orbit corrected on it."""
    shot = orbits_at(orbit.model, orbit.period, len(orbit.nodes))
    orbits = shot.described_by(MeshShooting.with_scales_of(shot.by))
    z = orbits.adopt(shot, shot.unknown(orbit.nodes, orbit.model))
    found = correct(orbits, z, hold_parameter(len(z) - 1))
    assert found.converged
    return orbits, found


@pytest.mark.parametrize("name", ["duffing", "lorenz", "vanderpol-free"])
def test_multipliers_are_those_of_equal_segments(name):
    model = model_named(name, rho=350) if name == "lorenz" else model_named(name)
    orbit = sf.periodic_orbit(model)
    orbits, found = over_a_mesh(orbit)
    values = orbits.spectrum.whole(orbits.eigenvalues(found.z, found.linearization))
    assert np.sort_complex(values) == pytest.approx(np.sort_complex(orbit.multipliers), abs=1e-9)


def test_an_orbit_passed_twice_is_one_on_the_mesh_repeated():
    orbits, found = over_a_mesh(sf.periodic_orbit(model_named("duffing")))
    twice = orbits.with_period(2)
    z = twice.adopt(orbits, found.z)
    assert twice.segments == 2 * orbits.segments
    assert np.abs(twice.defect(z)).max() < 1e-10


def test_segments_become_short_where_perturbations_grow():
    orbits, found = over_a_mesh(sf.periodic_orbit(model_named("vanderpol-free", mu=8)))
    by, nodes, constants = orbits.by, orbits.nodes(found.z), orbits.constants(found.z)
    blocks = found.linearization.blocks.copy()
    assert by.better(nodes, constants, blocks) is None
    blocks[5] *= 100 * SEGMENT_GROWTH / np.linalg.norm(blocks[5], 2)
    better = by.better(nodes, constants, blocks)
    own = np.diff(by.edges)[0]
    assert np.diff(better.edges).min() < own / 4
    assert better.edges[-1] == 1.0
    half = better.segments // 2  # the halves of a cycle have the same mesh
    assert better.edges[half:] - 0.5 == pytest.approx(better.edges[: half + 1], abs=1e-15)


@pytest.mark.parametrize("segments", [1, 8])
def test_a_cycle_is_itself_wherever_it_starts(segments):
    # Of one segment it was taken for an equilibrium, which has no phase.
    orbit = sf.periodic_orbit(model_named("stuart-landau"))
    orbits = orbits_at(orbit.model, segments=segments)
    known = orbits_at(orbit.model)
    z = orbits.adopt(known, known.unknown(orbit.nodes, orbit.model))
    later = orbits.by.states(orbits.nodes(z), orbits.constants(z), orbits.by.start + 0.3)
    assert not orbits.stands(z)
    assert orbits.distance(orbits.join(later, orbits.free_values(z)), z) < 1e-8
    assert orbits.stands(orbits.join(np.zeros_like(later), orbits.free_values(z)))
