"""Two contacts in the plane, of which one lets go while the other one slips slowly."""

from itertools import pairwise

import numpy as np

import slipfold as sf
from slipfold.checks.switched import hold_legs
from slipfold.flow.modes import Status
from slipfold.flow.switched_motion import SwitchedMotion, legs


def two_masses():
    stiffness = np.array([[3, 0, -1, 0], [0, 2.5, 0, -0.7], [-1, 0, 4, 0], [0, -0.7, 0, 3.3]])
    contacts = [
        sf.FrictionContact(
            (f"x{name}", f"y{name}"),
            sf.Coulomb(mu, mu),
            load=load,
            Vd=Vd,
            alpha=alpha,
            name=f"c{name}",
        )
        for name, mu, load, Vd, alpha in (
            ("1", 0.357, sf.ModulatedLoad(Ns=1.0, Nd=0.269), 0.248, 0.551),
            ("2", 0.56, 1.0, 0.224, 1.127),
        )
    ]
    pushes = [sf.HarmonicForce("x1", F=0.083, name="x"), sf.HarmonicForce("y2", F=0.412, name="y")]
    return sf.Structure(
        np.eye(4),
        0.05 * stiffness,
        stiffness,
        names=("x1", "y1", "x2", "y2"),
        contacts=contacts,
        forcing=pushes,
        f=0.195,
    )


def test_slip_goes_on_where_another_contact_lets_go():
    motion = SwitchedMotion(two_masses(), np.zeros(8))
    flow, known = motion.flow, (motion.constants, motion.weights)
    start, mode = motion.strobe[0], motion.modes[0]
    passed = [leg for leg, _ in legs(flow, mode, start, 1.0, *known, dense=True)]
    assert hold_legs(flow, passed, start, *known).drift < 1e-10
    [(before, release)] = [
        pair for pair in pairwise(passed)
        if pair[1].released and pair[1].mode == (Status.FORTH, Status.SLOW)
    ]  # fmt: skip
    assert before.mode == (Status.SLOW, Status.STICK)
    slips = [
        np.array(flow.quantities.at(state, phase, motion.constants).slip[:2])
        for state, phase in (
            (before.state, before.end),
            (release.beginning.at(release.begin), release.begin),
            (release.state, release.end),
        )
    ]
    assert 0 < np.linalg.norm(slips[0]) < 0.05 / motion.weights[0]
    assert np.abs(slips[1] - slips[0]).max() < 1e-13
    assert np.abs(slips[2] - slips[0]).max() < 0.5 * np.linalg.norm(slips[0])
