"""Branches through stick and slip: where contacts begin or cease to stick, located and passed."""

import math

import numpy as np
import pytest

import slipfold as sf
from helpers.dry_friction import belt, den_hartog


def seams(diagram):
    """Special points that are no bifurcations, in their order."""
    return [point for _, point in diagram.special if point.type in ("GRAZE", "STICK", "LIFT")]


def test_turns_begin_to_stick_where_den_hartog_says():
    # The orbit without stops exists up to S* = |V| / sqrt(U^2 + W^-4), S = 0.2 Ns.
    W, friction = 0.6, 0.2
    V, U = 1 / (1 - W * W), math.sin(math.pi / W) / (W * (1 + math.cos(math.pi / W)))
    limit = abs(V) / math.sqrt(U**2 + W**-4) / friction
    found = []
    for span in ((1.0, 3.5), (3.5, 1.0)):
        orbit = sf.periodic_orbit(den_hartog(W, friction).replace(Ns=span[0]))
        diagram = sf.response(orbit, vary="Ns", span=span)
        (branch,) = diagram.branches
        (point,) = seams(diagram)
        assert point.type == "STICK"
        assert branch.stopped.kind == "span"
        found.append(point.value)
        few = branch.parameter < limit
        assert (branch.stuck_fraction[few] == 0).all()
        # Two stops a period from there on: 1.251431715 of 2 pi / W where S = 0.7.
        end = int(np.argmax(branch.parameter))
        assert branch.stuck_fraction[end] == pytest.approx(
            1.251431715 * W / (2 * math.pi), abs=1e-9
        )
        assert branch.multipliers[end, 1] == pytest.approx(0.0, abs=1e-15)
    assert found == pytest.approx([limit, limit], abs=1e-8)
    assert found[0] == pytest.approx(found[1], abs=1e-8)


@pytest.mark.parametrize("largest", [0.05, 0.2])
def test_a_stick_slip_cycle_ends_where_it_meets_one_that_slips(largest):
    # bSTAB: it touches Vrel = 0 there; the branch turns back as the unstable cycle in pure slip.
    law = sf.Stribeck(mu_s=1.0, mu_k=0.5, vs=0.5)
    cycle = sf.periodic_orbit(belt(law, 1.5, damping=0.1), state={"x": 2.0})
    settings = sf.Settings(steps=sf.Steps(largest=largest))
    (branch,) = sf.response(cycle, vary="Vd", span=(1.5, 1.9), settings=settings).branches
    (point,) = branch.special
    assert point.type == "GRAZE"
    assert point.value == pytest.approx(1.836600972208, abs=1e-8)
    assert branch.parameter[-1] == 1.5
    sticks = branch.stuck_fraction > 0
    assert sticks[0]
    assert not sticks[-1]
    assert branch.stable[sticks].all()
    assert not branch.stable[-1]
    assert np.abs(branch.multipliers[sticks, 1]).max() < 1e-12
