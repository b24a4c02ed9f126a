"""Collocation as a discretization of orbits: its order, its derivatives, and the same branches."""

import numpy as np
import pytest

import slipfold as sf
from slipfold.continuation.newton import correct
from slipfold.models.registry import model_named
from slipfold.orbits.collocation import Collocation
from slipfold.orbits.kinds import ForcedOrbits

BY_COLLOCATION = sf.Settings(discretization="collocation", largest_period=2)


@pytest.fixture(scope="module")
def forced():
    return sf.periodic_orbit(sf.SlidingOscillator(f=12.5, Nd=0.05))


def collocated(orbit, intervals):
    """The same orbit on a uniform mesh, and its correction."""
    orbits = ForcedOrbits(orbit.model, {"Nd": 0.98}, 1, intervals, Collocation)
    samples = orbit.sample(orbits.segments)[1]
    row = np.zeros(orbits.size + 1)
    row[-1] = 1.0
    correction = correct(orbits, orbits.join(samples, [orbit.model.values["Nd"]]), row)
    assert correction.converged
    return orbits, correction


def test_second_and_third_derivatives_are_those_of_differences(forced):
    orbits, correction = collocated(forced, 16)
    z, m, n = correction.z, orbits.segments, 4
    nodes, constants = orbits.nodes(z), orbits.constants(z)
    rng = np.random.default_rng(1)
    vector, other = rng.standard_normal((2, m, n))

    def blocks(direction, step):
        moved = z.copy()
        moved[: m * n] += step * direction.ravel() / np.sqrt(m)
        return np.einsum("jab,jb->ja", orbits.linearize(moved).blocks, vector)

    bent, pulled = orbits.by.curvatures(nodes, constants, vector[None])
    step = 1e-5
    differenced = (blocks(other, step) - blocks(other, -step)) / (2 * step)
    assert np.abs(np.einsum("jab,jb->ja", bent[0], other) - differenced).max() < 1e-6
    after, before = z.copy(), z.copy()
    after[-1] += step
    before[-1] -= step
    change = (orbits.linearize(after).blocks - orbits.linearize(before).blocks) / (2 * step)
    assert np.abs(pulled[0][..., 0] - np.einsum("jab,jb->ja", change, vector)).max() < 1e-6
    cubes = orbits.by.cubes(nodes, constants, vector[None])[0]
    step = 1e-3
    twice = (blocks(vector, step) - 2 * blocks(vector, 0) + blocks(vector, -step)) / step**2
    assert np.abs(cubes - twice).max() < 1e-4 * np.abs(cubes).max()


@pytest.mark.parametrize(
    ("name", "vary", "span", "values"),
    [
        ("sliding", "Nd", (0, 0.3), {"f": 12.5}),
        ("lure", "a", (1.2, 0.6), {}),
        ("duffing", "W", (0.6, 2.0), {}),
    ],
)
def test_branches_have_the_same_special_points(name, vary, span, values):
    model = model_named(name, **values)
    settings = sf.Settings(largest_period=2)
    shooting = sf.response(model, vary=vary, span=span, settings=settings)
    other = sf.response(model, vary=vary, span=span, settings=BY_COLLOCATION)
    assert len(shooting.special) > 0
    assert [item.point.type for item in shooting.special] == [
        item.point.type for item in other.special
    ]
    for one, two in zip(shooting.special, other.special, strict=True):
        a, b = one.point, two.point
        allowed = 4 * (a.uncertainty + b.uncertainty) + 1e-13 * abs(a.value)
        assert abs(a.value - b.value) < allowed, (a, b)
        assert a.criticality == b.criticality
    for one, two in zip(shooting.branches, other.branches, strict=True):
        assert (one.period, one.stopped.kind) == (two.period, two.stopped.kind)
