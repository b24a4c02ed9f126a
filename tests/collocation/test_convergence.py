"""Orders of convergence, closed forms and adapted meshes of collocation."""

import math
from dataclasses import replace

import numpy as np
import pytest

from slipfold.collocation import collocate
from slipfold.collocation.collocate import Guess, on_mesh
from slipfold.collocation.condensation import Iterate
from slipfold.collocation.mesh import equidistribute, halve, uniform
from slipfold.collocation.reference import reference_of
from slipfold.collocation.vector_field import VectorField
from slipfold.collocation_points import gauss_points
from slipfold.models import model_named
from slipfold.orbits import periodic_orbit


def duffing():
    return periodic_orbit(model_named("duffing", W=1.0, F=0.5))


def on_uniform_mesh(orbit, count, degree):
    field = VectorField(orbit.model)
    guess = Guess(orbit.period, orbit.sample(256)[1] / field.scales, field.period)
    reference = reference_of(field, guess.samples[::32], False)
    return on_mesh(field, guess.on(uniform(orbit.period, count, 8), degree), reference)


@pytest.mark.parametrize("degree", [1, 2, 3, 4, 7])
def test_gauss_points_integrate_polynomials_exactly(degree):
    gauss = gauss_points(degree)
    ends = np.linspace(0, 1, 5)
    for power in range(degree):
        integrals = gauss.integrals(ends) @ gauss.points**power
        assert integrals == pytest.approx(ends ** (power + 1) / (power + 1), abs=1e-14)
    top = gauss.points ** (degree - 1)
    assert gauss.highest @ top == pytest.approx(math.factorial(degree - 1), rel=1e-9)
    for power in range(2 * degree):  # the quadrature knows twice as many
        assert gauss.weights @ gauss.points**power == pytest.approx(1 / (power + 1), abs=1e-14)


@pytest.mark.parametrize("degree", [1, 2, 3, 4])
def test_states_at_mesh_points_and_multipliers_converge_at_twice_the_degree(degree):
    orbit = duffing()
    counts = {1: (256, 512), 2: (48, 96), 3: (24, 48), 4: (16, 32)}[degree]
    errors = []
    for count in counts:
        result = on_uniform_mesh(orbit, count, degree)
        nodes = result.solution.iterate.nodes[:: count // 8] * orbit.model.state_scales()
        multipliers = np.abs(result.multipliers[:, None] - orbit.multipliers).min(axis=1)
        errors.append([np.abs(nodes - orbit.nodes).max(), multipliers.max()])
    orders = np.log2(np.array(errors[0]) / errors[1])
    assert orders == pytest.approx(2 * degree, abs=0.5)


@pytest.mark.parametrize("degree", [2, 3, 4])
def test_states_inside_intervals_converge_at_one_more_than_the_degree(degree):
    orbit = duffing()
    errors = []
    for count in (32, 64):
        iterate = on_uniform_mesh(orbit, count, degree).solution.iterate
        # The stages of a method of higher order on a mesh that has them as edges are exact.
        fine = on_uniform_mesh(orbit, count, 8).solution.iterate
        place = gauss_points(degree).points[0]
        inside = fine.nodes + np.einsum(
            "k,ikn->in",
            gauss_points(8).integrals(np.array([place]))[0],
            VectorField(orbit.model).linear(fine.stages, fine.phases)[0],
        ) * (fine.time * fine.lengths[:, None])
        errors.append(np.abs(iterate.stages[:, 0] - inside).max())
    assert np.log2(errors[0] / errors[1]) == pytest.approx(degree + 1, abs=0.4)


@pytest.mark.parametrize(("r", "w"), [(0.5, 1.0), (0.1, 3.0), (2.0, 0.7)])
def test_stuart_landau_has_its_closed_form(r, w):
    model = model_named("stuart-landau", r=r, w=w, duration=6.0 / w)
    angles = 2 * np.pi * np.arange(32)[:, None] / 32
    guess = 1.1 * math.sqrt(r) * np.hstack([np.cos(angles), np.sin(angles)])
    orbit = collocate(model, guess)
    assert orbit.converged
    assert orbit.duration == pytest.approx(2 * math.pi / w, rel=1e-12)
    assert np.hypot(*orbit.states.T) == pytest.approx(math.sqrt(r), rel=1e-12)
    exact = [1.0, math.exp(-4 * math.pi * r / w)]
    assert orbit.multipliers == pytest.approx(exact, rel=1e-9, abs=0)


def relaxation(mu, samples=512):
    """A guess of van der Pol's cycle, by nothing but small explicit steps."""
    state, step = np.array([2.0, 0.0]), 1e-3 / max(1.0, mu)

    def rates(q):
        return np.array([q[1], mu * (1 - q[0] ** 2) * q[1] - q[0]])

    path, crossings = [], []
    for index in range(400_000):
        middle = state + step / 2 * rates(state)
        after = state + step * rates(middle)
        if state[1] > 0 >= after[1]:
            crossings.append(index)
            if len(crossings) == 3:
                break
        state = after
        path.append(state)
    first, last = crossings[1], crossings[2]
    places = first + (last - first) * np.arange(samples) // samples
    return np.array(path)[places], (last - first) * step


def test_van_der_pol_has_its_published_period_and_multiplier():
    guess, duration = relaxation(1.0)
    orbit = collocate(model_named("vanderpol-free", mu=1, duration=duration), guess)
    assert orbit.converged
    assert orbit.duration == pytest.approx(6.663286859323, abs=2e-12)
    assert orbit.multipliers[1].real == pytest.approx(8.596950640e-4, rel=1e-9)


def test_relaxation_needs_an_adapted_mesh_and_keeps_its_tiny_multiplier():
    guess, duration = relaxation(6.0)
    model = model_named("vanderpol-free", mu=6, duration=duration)
    orbit = collocate(model, guess)
    assert orbit.converged
    lengths = np.diff(orbit.edges)
    assert lengths.max() > 10 * lengths.min()
    # Liouville: the multipliers' product is the exponential of the mean divergence.
    field = VectorField(model)
    guess = Guess(1, orbit.anchors, 1.0)
    closed = np.concatenate([orbit.states, orbit.states[:1]])
    from scipy.interpolate import CubicHermiteSpline

    slopes = orbit.duration * field.linear(closed, orbit.edges)[0]
    gauss = gauss_points(8)
    at = orbit.edges[:-1, None] + lengths[:, None] * gauss.points
    x = CubicHermiteSpline(orbit.edges, closed[:, 0], slopes[:, 0])(at)
    divergence = orbit.duration * np.sum(6 * (1 - x**2) @ gauss.weights * lengths)
    assert divergence < -40  # beyond the precision of a product of matrices
    assert np.log(orbit.multipliers[1].real) == pytest.approx(divergence, rel=1e-5)


def test_a_double_multiplier_is_compared_by_its_mean():
    # Rounding splits it by its square root, on each mesh and each processor in another way.
    count = 16
    coarse, fine = (on_uniform_mesh(duffing(), n, 4) for n in (count, 2 * count))
    split = np.array([1e-8, -1e-8])
    coarse = replace(coarse, multipliers=np.array([0.5, 0.5]) + 0j)
    double = replace(fine, multipliers=0.5 + 3 * split + 0j)
    assert coarse.difference(double) == pytest.approx(
        np.abs(coarse.solution.iterate.nodes - fine.solution.iterate.nodes[::2]).max(), rel=1e-6
    )
    moved = replace(fine, multipliers=0.5 + 1e-3 + split + 0j)
    assert coarse.difference(moved) == pytest.approx(1e-3)


def test_a_mesh_is_equidistributed_and_keeps_its_anchors():
    edges = uniform(1, 64, 8)
    gauss = gauss_points(4)
    at = edges[:-1, None] + np.diff(edges)[:, None] * gauss.points
    sharp = 1 / (1.1 + np.cos(2 * np.pi * at))[..., None]
    moved = equidistribute(edges, sharp, gauss, 64, 8)
    assert np.isin(np.arange(9) / 8, moved).all()
    assert (np.diff(moved) > 0).all()
    assert abs(len(moved) - 65) < 10
    lengths = np.diff(moved)
    assert lengths[len(lengths) // 2] < 0.3 * lengths.max()  # the peak is in the middle
    same = equidistribute(edges, np.zeros_like(sharp), gauss, 64, 8)
    assert same == pytest.approx(edges)
    assert np.isin(moved, halve(moved)).all()


def test_what_does_not_converge_says_so():
    model = model_named("vanderpol-free", mu=1, duration=6.7)
    noise = np.random.default_rng(3).normal(size=(64, 2))
    assert not collocate(model, noise).converged


def test_an_iterate_knows_its_phases():
    edges = np.array([0.0, 0.5, 2.0])
    iterate = Iterate(edges, np.zeros((2, 1)), np.zeros((2, 1, 1)), 1.0)
    assert iterate.phases == pytest.approx(np.array([[0.25], [1.25]]))
