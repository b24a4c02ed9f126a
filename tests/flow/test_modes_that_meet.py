"""Typical sizes of modes that only their nonlinear parts couple, as those of rotors and beams."""

import numpy as np
import pytest

import slipfold as sf
from slipfold.flow.scales import measured_within


def rotor():
    """Unbalance response of a hardening shaft: its amplitude r meets a cubic equation."""
    return sf.System(
        parameters={"W": 0.8, "c": 0.1, "e": 0.05},
        formulas={"k": "1 + x^2 + y^2"},
        states={
            "x": "u",
            "y": "v",
            "u": "-c*u - k*x + e*W^2*cos(W*t)",
            "v": "-c*v - k*y + e*W^2*sin(W*t)",
        },
        forcing={"period": "2*pi/W"},
    )


def test_the_folds_of_a_whirling_shaft_are_those_of_its_cubic():
    (branch,) = sf.response(rotor(), vary="W", span=(0.4, 2)).branches
    assert [item.type for item in branch.special] == ["LP", "LP"]
    for item in branch.special:
        r = np.hypot(*item.orbit.state[:2])
        stiff, damp, push = 1 + r**2 - item.value**2, 0.1 * item.value, 0.05 * item.value**2
        assert np.hypot(stiff, damp) * r == pytest.approx(push, abs=1e-9)
        # Where the curve of r over W turns, its derivative along r vanishes.
        assert stiff * (stiff + 2 * r**2) + damp**2 == pytest.approx(0, abs=1e-8)


def test_a_mode_that_hardly_moves_yet_is_measured_by_where_it_bends():
    model = sf.System(
        parameters={"W": 0.6, "F": 0.1},
        states={
            "a": "va",
            "b": "vb",
            "va": "-0.02*va - a - a^3 - 3*a*b^2 + F*cos(W*t)",
            "vb": "-0.02*vb - 9.6*b + 0.27*a^3 - 3*a^2*b - 4*b^3",
        },
        forcing={"period": "2*pi/W"},
    )
    sizes = measured_within(model, [{"W": 0.6}, {"W": 1.3}, {"W": 2.0}]).state_scales()
    assert sizes[1] > sizes[0] / 32  # it moves by 1/300 of a at first, and by as much later
