"""Where responses of structures with dry contacts end, and what trajectories do beyond."""

import numpy as np

import slipfold as sf


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
