"""Orders of convergence, closed forms and fitted meshes of collocation, and what its check sees."""

import math
from dataclasses import replace

import numpy as np
import pytest

import slipfold as sf
from slipfold import periodic_orbit
from slipfold.collocation_points import gauss_points
from slipfold.continuation.newton import correct
from slipfold.models.model import evaluation_of
from slipfold.models.registry import model_named
from slipfold.orbits import check
from slipfold.orbits.check import collocate
from slipfold.orbits.collocation import Collocation
from slipfold.orbits.continued import hold_parameter
from slipfold.orbits.discretization import GAUSS, STAGES, Scheme
from slipfold.orbits.kinds import ForcedOrbits
from slipfold.orbits.multipliers import product_eigenvalues


def duffing():
    return periodic_orbit(model_named("duffing", W=1.0, F=0.5))


def on_uniform_mesh(orbit, count, degree):
    """Orbits by collocation of a degree, with the unknown of this one."""
    edges, free = np.linspace(0.0, orbit.period, count + 1), {"W": 1.0}
    by = Collocation(orbit.model, free, edges=edges, scheme=Scheme(gauss_points(degree)))
    orbits = ForcedOrbits(orbit.model, free, by=lambda *_: by)
    shot = ForcedOrbits(orbit.model, free)
    z = orbits.adopt(shot, shot.unknown(orbit.nodes, orbit.model))
    correction = correct(orbits, z, hold_parameter(len(z) - 1))
    assert correction.converged
    return orbits, correction.z


@pytest.mark.parametrize("degree", [1, 2, 3, 4])
def test_states_at_mesh_points_and_multipliers_converge_at_twice_the_degree(degree):
    orbit = duffing()
    counts = {1: (256, 512), 2: (48, 96), 3: (24, 48), 4: (16, 32)}[degree]
    errors = []
    for count in counts:
        orbits, z = on_uniform_mesh(orbit, count, degree)
        values = product_eigenvalues(orbits.linearize(z).factors)
        multipliers = np.abs(values[:, None] - orbit.multipliers).min(axis=1)
        nodes = orbits.nodes(z)[:: count // 8]
        errors.append([np.abs(nodes - orbit.nodes).max(), multipliers.max()])
    orders = np.log2(np.array(errors[0]) / errors[1])
    assert orders == pytest.approx(2 * degree, abs=0.5)


@pytest.mark.parametrize("degree", [2, 3, 4])
def test_states_inside_intervals_converge_at_one_more_than_the_degree(degree):
    orbit = duffing()
    shot = ForcedOrbits(orbit.model, {"W": 1.0})
    z = shot.unknown(orbit.nodes, orbit.model)
    errors = []
    for count in (32, 64):
        orbits, found = on_uniform_mesh(orbit, count, degree)
        solved = orbits.by.solved(orbits.nodes(found), orbits.constants(found))
        exact = shot.by.states(shot.nodes(z), shot.constants(z), solved.phases[:, 0])
        errors.append(np.abs(solved.stages[:, 0] * orbits.scales - exact).max())
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


def relaxation(mu, samples=64):
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


def test_relaxation_needs_a_fitted_mesh_and_keeps_its_tiny_multiplier():
    guess, duration = relaxation(6.0)
    model = model_named("vanderpol-free", mu=6, duration=duration)
    orbit = collocate(model, guess)
    assert orbit.converged
    lengths = np.diff(orbit.edges)
    assert lengths.max() > 10 * lengths.min()
    # Liouville: the multipliers' product is the exponential of the mean divergence.
    closed = np.concatenate([orbit.states, orbit.states[:1]])
    from scipy.interpolate import CubicHermiteSpline

    rates = evaluation_of(model).linear(model, closed, orbit.edges % 1)[0]
    gauss = gauss_points(8)
    at = orbit.edges[:-1, None] + lengths[:, None] * gauss.points
    x = CubicHermiteSpline(orbit.edges, closed[:, 0], (orbit.duration * rates)[:, 0])(at)
    divergence = orbit.duration * np.sum(6 * (1 - x**2) @ gauss.weights * lengths)
    assert divergence < -40  # beyond the precision of a product of matrices
    assert np.log(orbit.multipliers[1].real) == pytest.approx(divergence, rel=1e-5)


def test_what_does_not_converge_says_so():
    model = model_named("vanderpol-free", mu=1, duration=6.7)
    noise = np.random.default_rng(3).normal(size=(64, 2))
    assert not collocate(model, noise).converged


def broken(points):
    """The same points with a quadrature that is wrong in the seventh digit."""
    return replace(points, weights=points.weights * (1 + 1e-7))


def test_the_check_sees_an_orbit_by_a_broken_discretization():
    orbit = duffing()
    found = []
    for points in (GAUSS.points, broken(GAUSS.points)):
        by = Collocation(
            orbit.model, {"W": 1.0}, edges=np.linspace(0, 1, 33), scheme=Scheme(points)
        )
        orbits = ForcedOrbits(orbit.model, {"W": 1.0}, by=lambda *_, by=by: by)
        z = orbits.unknown(orbit.sample(32)[1], orbit.model)
        z = correct(orbits, z, hold_parameter(len(z) - 1)).z
        nodes, values = orbits.nodes(z)[::4], product_eigenvalues(orbits.linearize(z).factors)
        found.append(replace(orbit, nodes=nodes, multipliers=values).check().passed)
    assert found == [True, False]


def test_a_broken_check_does_not_pass_either(monkeypatch):
    orbit = sf.periodic_orbit(sf.SlidingOscillator(f=12.5, Nd=0.05))
    assert orbit.check().passed

    class Broken(Collocation):
        def __init__(self, *given, scheme, **more):
            own = scheme
            if len(scheme.points.points) > STAGES:
                own = replace(scheme, points=broken(scheme.points))
            super().__init__(*given, scheme=own, **more)

    monkeypatch.setattr("slipfold.orbits.continued.Collocation", Broken)
    monkeypatch.setattr("slipfold.orbits.collocation.Collocation", Broken)
    with pytest.raises(sf.InputError, match="no mesh fits the orbit of"):
        orbit.check()


def test_rates_that_are_not_those_of_the_model_do_not_pass(monkeypatch):
    """What is compiled for the flow is compared with what is compiled apart from it."""
    orbit = duffing()

    class Other:
        def __init__(self, own):
            self._own = own

        def linear(self, *given):
            rates, jacobians = self._own.linear(*given)
            return rates * (1 + 1e-6), jacobians

    monkeypatch.setattr(check, "evaluation_of", lambda model: Other(evaluation_of(model)))
    assert not orbit.check().passed
