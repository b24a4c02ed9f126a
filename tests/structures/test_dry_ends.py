"""Where responses of structures with dry contacts end, and what trajectories do beyond."""

import importlib
from pathlib import Path
from unittest.mock import Mock

import numpy as np
import pytest

import slipfold as sf
from slipfold.bifurcations.branches import switching_boundaries


def test_response_ends_where_static_friction_lets_go_twice_in_a_period():
    """Both stops of a symmetric orbit are only just long enough; beyond, other motions follow."""
    model = sf.Structure(
        np.diag([0.05, 1.0]), [[0.04, -0.02], [-0.02, 0.04]], [[8.0, -3.0], [-3.0, 4.0]],
        names="a b", forcing=sf.HarmonicForce("b", F=1.0), f=0.3,
        contacts=sf.FrictionContact("a", sf.Coulomb(mu_s=1.0, mu_k=0.5), load=1.2, Vd=0),
    )  # fmt: skip
    diagram = sf.response(model, "f", (0.3, 0.29))
    (branch,) = diagram.branches
    (point,) = branch.special
    assert (point.type, branch.stopped.kind) == ("GRAZE", "failed")
    assert "static friction is more than kinetic" in branch.stopped.reason
    assert point.uncertainty < 1e-7
    assert diagram.checked.agree

    start = branch.orbit(-1).state
    ends = [sf.simulate(model.replace(f=point.value + df), 1, start).states[-1] - start
            for df in (1e-6, -1e-6)]  # fmt: skip
    before, beyond = (float(np.abs(end).max()) for end in ends)
    assert before < 1e-4
    assert beyond > 100 * before


def test_static_friction_is_asked_of_the_contact_that_grazes(monkeypatch):
    monkeypatch.setattr(switching_boundaries, "End", Mock(wraps=switching_boundaries.End))
    contacts = [sf.FrictionContact(name, sf.Coulomb(mu_s=mu_s, mu_k=0.5), load=0.1, Vd=Vd)
                for name, mu_s, Vd in (("b", 1.0, 50.0), ("a", 0.5, 0.3))]  # fmt: skip
    model = sf.Structure(np.eye(2), 0.1 * np.eye(2), [[4, -1], [-1, 3]], names="a b", f=0.17,
                         contacts=contacts, forcing=sf.HarmonicForce("a", F=1.0))  # fmt: skip
    assert sf.response(model, "F", (0.5, 0.7)).branches[0].special[0].type == "GRAZE"
    assert "static friction" not in switching_boundaries.End.call_args.args[1]


STRUCTURES = {
    "wall": sf.Structure(
        np.diag([1.0, 0.5]), sf.ProportionalDamping(alpha_M=0.02, beta_K=0.02),
        [[3.0, -1.0], [-1.0, 2.0]], names="a b", forcing=sf.HarmonicForce("a", F=1.0),
        contacts=sf.FrictionContact("b", sf.Coulomb(mu_s=0.4, mu_k=0.4), load=0.8, Vd=0), f=0.17,
    ),
    "belt in the plane": sf.Structure(
        np.eye(2), 0.1 * np.eye(2), [[4.0, -1.0], [-1.0, 3.0]], names="a b",
        contacts=sf.FrictionContact(("a", "b"), sf.Coulomb(mu_s=0.3, mu_k=0.3), load=0.8, Vd=0.3),
        forcing=sf.HarmonicForce("a", F=1.0), f=0.17,
    ),
}  # fmt: skip


@pytest.mark.parametrize(
    "name", ["wall", pytest.param("belt in the plane", marks=pytest.mark.long)]
)
def test_response_passes_the_first_resonance(name):
    """From one end of the span to the other; trajectories from rest converge to it."""
    model = STRUCTURES[name]
    diagram = sf.response(model, "f", (0.17, 0.3))
    (branch,) = diagram.branches
    assert branch.stopped.kind == "span"
    assert diagram.checked.agree
    index = int(branch.extrema.of("a")[1].argmax())
    assert 0 < index < len(branch) - 1
    settled = sf.simulate(model.replace(f=branch.parameter[index]), 120, np.zeros(4)).states[-1]
    assert np.abs(settled - branch.orbit(index).state).max() < 1e-6


def test_friction_that_depends_steeply_on_slip_is_judged_at_rest(monkeypatch):
    """A stop is found to 1e-14 of slip, by which friction of a strip's tip changes by 1e-10.

    Next to where it ceases to hold the tip, the tip seemed held, and then nothing released it.
    """
    monkeypatch.syspath_prepend(str(Path(__file__).parents[2] / "bench"))
    model, lowest = importlib.import_module("ours_structures").structure(20, "dry")
    at = 0.9365278968653 * lowest
    state = sf.periodic_orbit(model.replace(f=at)).state
    for beyond in np.linspace(1e-8, 1e-6, 12):
        end = sf.simulate(model.replace(f=at + beyond), 1, state).states[-1]
        assert np.abs(end - state).max() < 1e-6 * np.abs(state).max()


def test_stiff_link_to_a_dry_contact_is_solved_in_closed_form():
    """A contact of little mass, whose own motion decays 100,000 times in a second.

    No explicit integrator follows it over a period. The link gives by 5e-6, which the structure
    takes 5 ms to do when it turns: so long friction takes to turn over, without the link at once.
    """

    def shaken(M, C, K, names):
        contact = sf.FrictionContact("a", sf.Coulomb(mu_k=1.0), load=0.25, Vd=0)
        force = sf.HarmonicForce("a", F=0.5)
        model = sf.Structure(M, C, K, names=names, contacts=contact, forcing=force, f=0.13)
        return sf.periodic_orbit(model)

    link = np.array([[1.0, -1.0], [-1.0, 1.0]])
    stiff = shaken(np.diag([1e-5, 1.0]), 100 * link + np.diag([0.0, 0.05]),
                   1e5 * link + np.diag([0.0, 1.0]), "a b")  # fmt: skip
    rigid = shaken([[1.00001]], [[0.05]], [[1.0]], "a")
    assert stiff.stuck_fraction == pytest.approx(0.005 * 0.13, rel=0.1)
    assert stiff.state[[0, 2]] == pytest.approx(rigid.state, abs=2e-3)
    _, moved = stiff.output("a", 40)
    assert np.roll(moved, 20) == pytest.approx(-moved, abs=1e-9)


def test_beside_a_change_that_rounding_decides_a_neighbor_is_checked():
    """Stops that static friction only just holds last, or do not: the same state leads to both."""
    law = sf.Coulomb(mu_s=0.4, mu_k=0.3)
    model = sf.Structure(
        np.diag([1.0, 0.2, 1.0]), sf.ProportionalDamping(alpha_M=0.05, beta_K=0.005),
        [[40.0, -20.0, 0.0], [-20.0, 50.0, -30.0], [0.0, -30.0, 60.0]], names="x y z",
        contacts=sf.FrictionContact("y", law, load=1.0, Vd=0.05),
        forcing=sf.HarmonicForce("x", F=1.0), f=0.912,
    )  # fmt: skip
    diagram = sf.response(model, "f", (0.92, 0.91), settled=True)
    assert "STICK" in [point.type for point in diagram.branches[0].special]
    assert diagram.checked.agree


def test_rounding_of_a_stiff_link_is_no_disagreement():
    """Its rates turn 1e-15 of a displacement into 1e-6 of a speed, which decays at once."""
    link = np.array([[1.0, -1.0], [-1.0, 1.0]])
    model = sf.Structure(
        np.diag([1e-4, 1.0]), 10 * link + np.diag([0, 0.05]), 1e4 * link + np.diag([0.0, 1.0]),
        contacts=sf.FrictionContact("a", sf.Coulomb(mu_k=1.0), load=0.25, Vd=0), names="a b",
        forcing=sf.HarmonicForce("a", F=0.5), f=0.13,
    )  # fmt: skip
    assert sf.simulate(model, 2).checked.agree
