"""Collocation at Radau points: its order, and what it makes of what a mesh does not resolve."""

import numpy as np
import pytest

import slipfold as sf
from slipfold import Settings
from slipfold.bifurcations.branches.start import forced_orbits
from slipfold.bifurcations.loci import start as given_point
from slipfold.collocation_points import radau_points
from slipfold.continuation.newton import correct
from slipfold.orbits import continued
from slipfold.orbits.collocation import Collocation
from slipfold.orbits.discretization import GAUSS, STAGES, Scheme
from slipfold.orbits.kinds import ForcedOrbits
from slipfold.orbits.shooting import Shooting

RADAU = Scheme(radau_points(STAGES))


def forced(text, **values):
    return sf.System(
        name="forced", parameters={"F": 8.0}, states=text, forcing={"period": "2*pi"}, **values
    )


def solved(model, count, scheme):
    """The orbit by collocation on a uniform mesh, from that by shooting, and its multipliers."""
    orbit = sf.periodic_orbit(model)

    def cut(*given):
        return Collocation(*given, scheme=scheme)

    orbits = ForcedOrbits(model, {"F": 1.0}, 1, count, cut)
    row = np.eye(orbits.size + 1)[-1]
    samples = orbit.sample(orbits.segments)[1]
    found = correct(orbits, orbits.join(samples, [model.values["F"]]), row)
    assert found.converged
    return orbits.nodes(found.z), np.linalg.eigvals(found.linearization.product), orbit


def test_errors_at_the_nodes_are_of_order_eleven():
    model = forced({"x": "v", "v": "F*cos(t) - 0.3*v - x - x^3"})
    errors = []
    for count in (16, 32):
        nodes, _, orbit = solved(model, count, RADAU)
        errors.append(np.abs(nodes[:: count // 8] - orbit.nodes).max())
    assert 1e-8 < errors[0] < 1e-2
    assert 500 < errors[0] / errors[1] < 10000  # 2^11 = 2048


def test_a_fast_mode_that_decays_has_a_multiplier_of_nothing():
    """Mode y turns 500 times a period and decays to e^-30; a mesh of 64 does not resolve it."""
    model = forced(
        {"x": "v", "v": "F*cos(t) - 0.3*v - x - x^3", "y": "w", "w": "x - 10*w - 250000*y"}
    )
    by_radau, by_gauss = (np.abs(solved(model, 64, item)[1]) for item in (RADAU, GAUSS))
    slow = np.abs(solved(model, 64, RADAU)[2].multipliers)[:2]
    assert np.sort(by_radau)[-2:] == pytest.approx(np.sort(slow), abs=1e-8)
    assert np.sort(by_radau)[:2].max() < 1e-6
    assert np.sort(by_gauss)[:2].max() > 0.1  # the spurious ones


@pytest.mark.parametrize(("damping", "started"), [(10.0, Collocation), (0.0, Shooting)])
def test_stiff_forced_orbits_begin_by_collocation_where_what_is_fast_decays(damping, started):
    model = forced({"x": "v", "v": "F*cos(t) - v - x", "y": "w", "w": f"x - {damping}*w - 1e6*y"})
    assert type(forced_orbits(model, "F", 1.0, Settings()).by) is started
    chosen = Settings(discretization="shooting")
    assert type(forced_orbits(model, "F", 1.0, chosen).by) is Shooting


def test_the_locus_of_a_stiff_fold_meets_the_equations_where_its_branch_did(monkeypatch):
    schemes = []

    class Watched(Collocation):
        def __init__(self, *given, scheme=GAUSS, **more):
            schemes.append(scheme)
            super().__init__(*given, scheme=scheme, **more)

    monkeypatch.setattr(continued, "Collocation", Watched)
    model = sf.System(
        name="forced",
        parameters={"F": 0.1, "k": 0.3},
        states={"x": "v", "v": "F*cos(t) - 0.1*v - k*x - x^3", "y": "w", "w": "x - 10*w - 1e6*y"},
        forcing={"period": "2*pi"},
    )
    fold = sf.response(model, vary="F", span=(0.05, 0.6)).branches[0].special[0]
    orbits, _ = given_point.as_unknown(fold, model, {"F": 1.0, "k": 1.0}, Settings())
    assert fold.type == "LP"
    assert orbits.by.points.damps
    assert all(item.points.damps for item in schemes)
