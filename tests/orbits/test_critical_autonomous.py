"""Loci of equilibria and cycles: their derivatives against differences."""

import numpy as np
import pytest

import slipfold as sf
from slipfold.models.registry import model_named
from slipfold.orbits.critical import Critical
from slipfold.orbits.eigenvalues import Cayley
from slipfold.orbits.kinds import Cycles, Equilibria

RNG = np.random.default_rng(20260107)


def special(name, vary, span, kind, branch=None, **settings):
    diagram = sf.response(
        model_named(name), vary=vary, span=span, settings=sf.Settings(largest_period=1, **settings)
    )
    return next(
        item.point
        for item in diagram.special
        if item.point.type == kind and branch in (None, item.branch.id)
    )


def difference(function, z, direction, h):
    """Derivative along a direction by four values, to fourth order."""
    values = [function(z + step * h * direction) for step in (2, 1, -1, -2)]
    return (-values[0] + 8 * values[1] - 8 * values[2] + values[3]) / (12 * h)


def check_jacobian(problem, z, h, rel):
    linearization = problem.linearize(z)
    assert np.abs(linearization.defect).max() < 1e-8
    matrix = linearization.bordered(np.zeros(len(z))).matrix[:-1]
    assert matrix.shape == (len(z) - 1, len(z))
    # The condition on the phase is met by every unknown; it only says which way steps go.
    kept = np.ones(len(z) - 1, dtype=bool)
    kept[problem.orbits.size : -1] = False
    random = RNG.normal(size=(3, len(z)))
    along = np.eye(len(z))[[*range(-len(problem.orbits.units), 0), 0, problem.orbits.size // 2]]
    for direction in [*random / np.linalg.norm(random, axis=1)[:, None], *along]:
        expected = difference(problem.defect, z, direction, h)[kept]
        found = (matrix @ direction)[kept]
        assert found == pytest.approx(expected, abs=rel * (1 + np.abs(expected).max()))


CYCLES = [
    ("lure", "a", (1.2, 0.62), "PD", ("a", "b")),
    ("roessler", "a", (-0.3, 0.2), "PD", ("c", "a")),
    ("freire", "n", (-0.55, -0.6), "LP", ("n", "r")),
]


@pytest.mark.parametrize(("name", "vary", "span", "kind", "plane"), CYCLES)
@pytest.mark.parametrize("offset", [0.0, 0.5])
def test_jacobian_of_cycles_against_differences(name, vary, span, kind, plane, offset):
    item = special(name, vary, span, kind, 2)
    orbits = Cycles(item.model, dict(zip(plane, (0.5, 0.7), strict=True)), 1, len(item.nodes))
    problem, z = Critical(orbits, kind), orbits.unknown(item.nodes, item.model)
    if offset:
        problem, z, _ = problem.shifted(z, np.ones(len(z)))
    check_jacobian(problem, z, 1e-4, 1e-6)


EQUILIBRIA = [
    ("lure", "a", (1.2, 0.9), ("a", "b")),
    ("freire", "n", (-0.55, -0.6), ("r", "n")),
    ("stribeck", "vd", (2, 0.9), ("vd", "md")),
]


@pytest.mark.parametrize(("name", "vary", "span", "plane"), EQUILIBRIA)
@pytest.mark.parametrize("offset", [0.0, 0.5])
def test_jacobian_of_equilibria_against_differences(name, vary, span, plane, offset):
    item = special(name, vary, span, "HB", 1)
    orbits = Equilibria(item.model, dict(zip(plane, (0.5, 0.7), strict=True)), Cayley())
    problem, z = Critical(orbits, "HB"), orbits.unknown(item.nodes[:1], item.model)
    if offset:
        problem, z, _ = problem.shifted(z, np.ones(len(z)))
    check_jacobian(problem, z, 1e-3, 1e-7)
