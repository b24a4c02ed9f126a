"""What a check says of a motion as a whole: what has grown from errors, and what is sensitive."""

import heyoka as hy
import numpy as np
import pytest

import slipfold as sf
from slipfold.flow.settlement import Settlement
from slipfold.flow.trajectory import Trajectory
from slipfold.models.registry import model_named
from slipfold.results.checks.checked import Checked
from slipfold.results.checks.trajectories import check_trajectory


def epidemic():
    infections = "400*(1 + 0.25*cos(2*pi*t))*S*I"
    return sf.System(
        name="epidemic",
        parameters={"g": 50.0},
        states={"S": f"0.02 - 0.02*S - {infections}", "I": f"{infections} - (g + 0.02)*I"},
        forcing={"period": "1"},
    )


def test_what_has_grown_from_errors_is_found():
    s, i = hy.make_vars("S", "I")
    infections = 400.0 * (1.0 + 0.25 * hy.cos(2 * np.pi * hy.time)) * s * i
    rates = [(s, 0.02 - 0.02 * s - infections), (i, infections - 50.02 * i)]
    absolute = hy.taylor_adaptive(rates, [0.3, 1e-3], tol=1e-13)
    states = absolute.propagate_grid(np.arange(9.0))[-1]
    settlement = Settlement(False, None, np.nan, None, "not settled")
    wrong = check_trajectory(Trajectory(epidemic(), states, settlement))
    assert not wrong.agree
    assert "where it is smallest" in str(wrong)
    assert "write the equation for its logarithm" in str(wrong)
    right = sf.simulate(epidemic(), 8, [0.3, 1e-3])
    assert np.abs(states[-1, 1] / right.states[-1, 1] - 1) > 0.1
    assert right.checked.agree
    assert right.checked.count == 2


def oscillator(rate, start, **parameters):
    return sf.System(
        name="oscillator",
        parameters={"w": 1.0, **parameters},
        states={"x": {"rate": "v", "start": start}, "v": rate},
        forcing={"period": "2*pi/w"},
    )


CHAOS = oscillator("0.3*cos(w*t) - 0.15*v + x - x^3", 0.0)


@pytest.mark.parametrize("model", [CHAOS, model_named("lorenz")], ids=["duffing", "lorenz"])
def test_chaos_is_sensitive(model):
    checked = sf.simulate(model, 1000).checked
    assert checked.agree
    assert "the trajectory is sensitive: its single points are known for about" in str(checked)
    known = float(checked.remark.split("about ")[1].split()[0])
    # An error of 1e-13 grows by e in one to four periods of either.
    assert 15 < known < 200
    assert Checked.from_json(checked.to_json()) == checked


@pytest.mark.long
def test_a_chaotic_branch_of_two_wells_is_checked():
    # A secant along the branch came to rest, and its slope was divided by zero.
    model = sf.System(
        {
            "name": "two wells",
            "parameters": {"F": 0.1},
            "states": {
                "x": {"rate": "v", "start": 1.0},
                "v": {"rate": "-0.25*v + x - x^3 + F*cos(t)", "start": 0.0},
            },
            "forcing": {"period": "2*pi", "amplitude": "F"},
        }
    )
    diagram = sf.response(model, "F", (0, 0.5))
    assert diagram.checked.checks
