"""The computed uncertainty of multipliers covers their true error wherever that is known."""

import numpy as np
import pytest

import slipfold as sf
from helpers.long_tests import long_except
from helpers.reference import CASES, traced
from helpers.toy_models import LinearOscillator
from slipfold.bifurcations.branches.response import trace_response
from slipfold.flow.flow import Flow, flow_of
from slipfold.orbits.uncertainty import multiplier_rounding

SLACK = 30
"""Errors are of either sign and may agree by chance in two computations: a factor is allowed."""

ROUNDING = 1e-13
BY_MESH = sf.Settings(discretization="collocation")


def mean_traces(branch, index):
    """Integral of the Jacobian's trace over the period, by Gauss quadrature between nodes."""
    orbit = branch.orbit(index)
    flow = flow_of(orbit.model)
    constants = flow.constants(orbit.model.vector)
    edges = np.linspace(0, orbit.period, len(orbit.nodes) + 1)
    points, weights = np.polynomial.legendre.leggauss(40)
    total = 0.0
    for node, start, end in zip(orbit.nodes, edges[:-1], edges[1:], strict=True):
        phases = start + (points + 1) / 2 * (end - start)
        path = flow.trajectory(node, constants, np.concatenate([[start], phases]))[1:]
        traces = np.trace(flow.jacobians(path, phases, constants), axis1=1, axis2=2)
        total += traces @ weights / 2 * (end - start)
    return total


@pytest.mark.parametrize("case", [CASES[0], CASES[1], CASES[9]], ids=str)
def test_determinant_is_within_its_uncertainty(case):
    for branch in traced(case):
        for index in range(1, len(branch) - 1, 3):
            multipliers = branch.multipliers[index]
            growth = np.abs(multipliers).max()
            if growth > 50:  # the small multipliers then are known relative to the large one
                continue
            exact = np.exp(mean_traces(branch, index))
            determinant = np.prod(multipliers).real
            relative = (branch.multiplier_uncertainty[index] / np.abs(multipliers)).sum()
            allowed = SLACK * (relative + ROUNDING * growth) * exact + 1e-13
            assert abs(determinant - exact) < allowed, (branch.id, index)


@pytest.mark.parametrize("vary", ["f", "a", "zeta", "f0"])
def test_closed_form_is_within_the_uncertainty(vary):
    span = {"f": (0.5, 1.8), "a": (0.0, 2.0), "zeta": (0.3, 0.02), "f0": (0.7, 1.6)}[vary]
    (branch,) = trace_response(LinearOscillator(), vary, span)
    for index in range(len(branch)):
        model = branch.orbit(index).model
        root = 2 * np.pi * model.f0 * (-model.zeta + 1j * np.sqrt(1 - model.zeta**2))
        expected = np.exp(root / model.f)
        error = min(abs(branch.multipliers[index] - expected))
        assert error < SLACK * branch.multiplier_uncertainty[index].max() + ROUNDING


def test_a_mode_too_fast_for_the_mesh_is_not_integrated_again(monkeypatch):
    """It turns 500 times in a period; Radau points damp it away."""
    model = sf.System(
        name="two modes",
        parameters={"w": 1.0},
        forcing={"period": "2*pi/w"},
        states={"x": "u", "y": "v", "u": "cos(w*t) - x - u/10", "v": "x - 500^2*y - v"},
    )
    (branch,) = trace_response(model, "w", (0.99, 1.01), settings=BY_MESH)
    monkeypatch.setattr(Flow, "linearize", None)
    for row, w in enumerate(branch.parameter):
        roots = np.append(np.roots([1, 0.1, 1]), np.roots([1, 1, 500**2]))
        error = np.abs(branch.multipliers[row][:, None] - np.exp(roots * 2 * np.pi / w)).min(axis=1)
        known = branch.multiplier_uncertainty[row]
        assert np.all(error < SLACK * known + ROUNDING)
        assert np.sort(known)[1] < 1e-10 < 1e-3 < np.sort(known)[2]


@pytest.mark.parametrize("case", long_except(CASES, CASES[::3]), ids=str)
def test_special_values_agree_between_runs_within_their_uncertainty(case):
    first = [item for branch in traced(case) for item in branch.special]
    second = [item for branch in traced(case, largest=0.1) for item in branch.special]
    for one, two in zip(first, second, strict=True):
        allowed = SLACK * (one.uncertainty + two.uncertainty) + 1e-15 * abs(one.value)
        assert abs(one.value - two.value) < allowed


@pytest.mark.parametrize("n", [2, 3])
def test_multipliers_that_meet_without_vectors_of_their_own_part_like_a_root(n):
    monodromy = np.diag(np.ones(n - 1), 1)
    moved = multiplier_rounding(monodromy, np.zeros(n, dtype=complex))
    assert moved == pytest.approx(np.full(n, np.sqrt(n * np.finfo(float).eps)))


def test_what_is_known_of_an_orbit_does_not_depend_on_those_beside_it():
    """At rest friction damps the mode that turns 220 times a period while the contact slips."""
    law = sf.Regularized(sf.Coulomb(mu_s=0.3, mu_k=0.3), e=0.001)
    model = sf.Structure(
        [[1.0, 0.0], [0.0, 0.01]],
        np.eye(2) / 2,
        [[16040.0, -16000.0], [-16000.0, 16000.0]],
        contacts=sf.FrictionContact("q2", law, load=2.0, Vd=0.0),
        forcing=sf.HarmonicForce("q1", F=4.0),
        f=0.9,
    )
    (branch,) = trace_response(model, "F", (0.0, 2.0))
    each = [branch.orbit(index).multiplier_uncertainty for index in range(len(branch))]
    np.testing.assert_array_equal(each, branch.multiplier_uncertainty)
    assert branch.multiplier_uncertainty.max() < 1e-6
