"""The equations of a locus: their derivatives against differences, and what their zero means."""

from functools import lru_cache

import numpy as np
import pytest

import slipfold as sf
from helpers.bifurcation_sets import bifurcations, response
from helpers.by_hand.sliding import BASE, integrate
from helpers.textbook_models import VanDerPol
from slipfold.bifurcations.branches.response import trace_response
from slipfold.bifurcations.loci.follow import follow_loci
from slipfold.models.registry import model_named
from slipfold.orbits.critical import Critical
from slipfold.orbits.eigenvalues import Cayley
from slipfold.orbits.kinds import Cycles, Equilibria, ForcedOrbits
from slipfold.orbits.switched_shooting import SwitchedShooting

RNG = np.random.default_rng(20260106)
SPAN = (0.0, 0.98)
WIDTHS = {"f": 2.0, "Nd": 0.98, "Vd": 0.9, "alpha": 3.0, "mu": 0.8, "Ns": 1.5, "w": 0.2, "a": 0.3}

POINTS = [
    ("PD", 1, 12.5, ("f", "Nd")),
    ("PD", 1, 12.2, ("Vd", "alpha")),
    ("PD", 1, 12.5, ("mu", "Ns")),
    ("LP", 2, 12.2, ("f", "Nd")),
    ("LP", 2, 12.2, ("alpha", "f")),
    ("NS", 2, 12.5, ("f", "Nd")),
    ("NS", 2, 12.5, ("Ns", "Vd")),
    # Near the collapse of the spring, with multipliers of 2e4.
    ("LP", 1, 12.2, ("f", "Nd")),
]


def special(kind, period, f):
    branches = response("Nd", SPAN, (("f", f),))
    return next(p for p in bifurcations(branches, kind) if p.period == period)


def problem_of(item, plane):
    vary = {name: WIDTHS[name] for name in plane}
    orbits = ForcedOrbits(item.model, vary, item.period, len(item.nodes))
    return Critical(orbits, item.type), orbits.unknown(item.nodes, item.model)


def difference(function, z, direction, h):
    """Derivative along a direction by four values, to fourth order."""
    values = [function(z + step * h * direction) for step in (2, 1, -1, -2)]
    return (-values[0] + 8 * values[1] - 8 * values[2] + values[3]) / (12 * h)


def check_jacobian(problem, z, h=1e-4, rel=1e-6):
    linearization = problem.linearize(z)
    assert np.abs(linearization.defect).max() < 1e-8
    matrix = linearization.bordered(np.zeros(len(z))).matrix[:-1]
    orbits = problem.orbits
    assert matrix.shape == (len(z) - 1, len(z))
    # The condition on the phase is met by every unknown; it only says which way steps go.
    kept = np.ones(len(z) - 1, dtype=bool)
    kept[orbits.size : -1] = False
    random = RNG.normal(size=(3, len(z)))
    along = np.eye(len(z))[[*range(-len(orbits.units), 0), 0, orbits.size // 2]]
    for direction in [*random / np.linalg.norm(random, axis=1)[:, None], *along]:
        expected = difference(problem.defect, z, direction, h)[kept]
        found = (matrix @ direction)[kept]
        assert found == pytest.approx(expected, abs=rel * (1 + np.abs(expected).max()))


@pytest.mark.parametrize(("kind", "period", "f", "plane"), POINTS)
def test_jacobian_against_differences(kind, period, f, plane):
    item = special(kind, period, f)
    growth = np.abs(item.multipliers).max()
    problem, z = problem_of(item, plane)
    check_jacobian(problem, z, h=1e-4 if growth < 10 else 1e-7)


@lru_cache(maxsize=1)
def resonant():
    """The NS locus of the forced van der Pol oscillator, between two 1:1 resonances."""
    branches = trace_response(VanDerPol(), "w", (1.0, 1.2))
    window = ((0.85, 1.15), (0.15, 0.35))
    (found,) = follow_loci(bifurcations(branches), ("w", "a"), window, switch=False)
    return found


@pytest.mark.parametrize("kind", ["LP", "NS"])
def test_jacobian_at_a_strong_resonance(kind):
    # Both multipliers are one: the two conditions are different ones, and both are met.
    resonances = [p for p in resonant().special if p.type == "R1"]
    assert resonances
    for item in resonances:
        assert np.abs(item.multipliers - 1).max() < 1e-4  # a double one: the root of 1e-9
        orbits = ForcedOrbits(item.model, {"w": 0.2, "a": 0.3}, 1, len(item.nodes))
        check_jacobian(Critical(orbits, kind), orbits.join(item.nodes, np.array(item.values)))


@pytest.mark.parametrize(("kind", "period", "f", "plane"), [POINTS[0], POINTS[3], POINTS[5]])
def test_its_orbits_have_the_critical_multiplier_by_hand(kind, period, f, plane):
    item = special(kind, period, f)
    problem, z = problem_of(item, plane)
    assert np.abs(problem.defect(z)).max() < 1e-9
    p = {**BASE, **item.model.values}
    state, scales = problem.orbits.nodes(z)[0], item.model.state_scales()
    assert integrate(state, p, period) / scales == pytest.approx(state / scales, abs=1e-9)
    matrix = np.transpose(
        [integrate(state + 1e-30j * unit, p, period).imag / 1e-30 for unit in np.eye(4)]
    )
    values = np.linalg.eigvals(matrix)
    if kind == "NS":
        assert np.abs(np.abs(values[values.imag > 0]) - 1).min() < 1e-8
    else:
        assert np.abs(values - {"LP": 1, "PD": -1}[kind]).min() < 1e-7


# -- cycles and equilibria ----------------------------------------------------------------------


def autonomous(name, vary, span, kind, branch=None, **settings):
    diagram = sf.response(
        model_named(name), vary=vary, span=span, settings=sf.Settings(largest_period=1, **settings)
    )
    return next(
        item.point
        for item in diagram.special
        if item.point.type == kind and branch in (None, item.branch.id)
    )


CYCLES = [
    ("lure", "a", (1.2, 0.62), "PD", ("a", "b")),
    ("roessler", "a", (-0.3, 0.2), "PD", ("c", "a")),
    ("freire", "n", (-0.55, -0.6), "LP", ("n", "r")),
]


@pytest.mark.parametrize(("name", "vary", "span", "kind", "plane"), CYCLES)
@pytest.mark.parametrize("offset", [0.0, 0.5])
def test_jacobian_of_cycles_against_differences(name, vary, span, kind, plane, offset):
    item = autonomous(name, vary, span, kind, 2)
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
    item = autonomous(name, vary, span, "HB", 1)
    orbits = Equilibria(item.model, dict(zip(plane, (0.5, 0.7), strict=True)), Cayley())
    problem, z = Critical(orbits, "HB"), orbits.unknown(item.nodes[:1], item.model)
    if offset:
        problem, z, _ = problem.shifted(z, np.ones(len(z)))
    check_jacobian(problem, z, 1e-3, 1e-7)
    by, at, along = orbits.by, orbits.constants(z), np.full((1, 1, len(orbits.scales)), 0.5)
    sides = [orbits.nodes(z) + step * along[0] * orbits.scales for step in (1e-3, -1e-3)]
    bent = [by.curvatures(side, at, along)[0][0, 0] @ along[0, 0] for side in sides]
    third = by.cubes(orbits.nodes(z), at, along)[0, 0]
    assert third == pytest.approx((bent[0] - bent[1]) / 2e-3, rel=1e-4, abs=1e-6)


# -- through stick and slip ----------------------------------------------------------------------


def test_jacobian_through_stick_against_differences():
    law, load = (
        sf.Stribeck(mu_s=0.5, mu_k=0.3, vs=0.2, exponent=1),
        sf.ModulatedLoad(Ns=1.0, Nd=0.6),
    )
    contact = sf.FrictionContact("x", law, load=load, Vd=0.4)
    more = {"contacts": contact, "forcing": sf.HarmonicForce("x", F=0.5), "f": 0.09}
    model = sf.Structure([[1.0]], [[0.15]], [[1.0]], names="x", **more)
    settings = sf.Settings(largest_period=1)
    (branch,) = sf.response(model, "f", (0.09, 0.086), settings=settings).branches
    point = next(item for item in branch.special if item.type == "PD")
    assert point.stuck_fraction > 0.1
    orbits = ForcedOrbits(point.model, {"f": 0.1, "F": 0.5}, 1, 1, SwitchedShooting)
    problem, z = Critical(orbits, "PD"), orbits.unknown(point.nodes[:1], point.model)
    check_jacobian(problem, z, rel=1e-4)
