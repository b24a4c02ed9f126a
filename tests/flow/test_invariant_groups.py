"""States that nothing feeds keep their digits, however small, held against their logarithms."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import slipfold as sf

SIR = """
name = "seasonal epidemic"
[parameters]
b = { value = 1800, unit = "1/yr", doc = "contacts" }
g = { value = 100, unit = "1/yr", doc = "recovery" }
m = { value = 0.02, unit = "1/yr", doc = "births and deaths" }
[formulas]
infections = "b*(1 + 0.28*cos(2*pi*t))*S*I"
[states]
S = { rate = "m - m*S - infections", start = 0.06, doc = "susceptible" }
I = { rate = "infections - (g + m)*I", start = 0.001, doc = "infected" }
[forcing]
period = "1"
"""


@pytest.mark.parametrize(
    ("start", "years", "least"), [((0.06, 1e-3), 20, 1e-33), ((0.999, 1e-6), 30, 1e-55)]
)
def test_an_epidemic_comes_back_from_what_was_left_of_it(start, years, least):
    model = sf.System.from_toml(SIR)

    def rates(t, q):
        contacts = 1800 * (1 + 0.28 * np.cos(2 * np.pi * t)) * q[0]
        return [0.02 - 0.02 * q[0] - contacts * np.exp(q[1]), contacts - 100.02]

    right = solve_ivp(
        rates, (0, years), [start[0], np.log(start[1])], "Radau", range(years + 1), rtol=1e-9,
        atol=1e-11,
    ).y  # fmt: skip
    motion = sf.simulate(model, years, start)
    assert motion.states[:, 1].min() < least
    assert np.log(motion.states[:, 1]) == pytest.approx(right[1], abs=1e-5)
    assert motion.states[:, 0] == pytest.approx(right[0], rel=1e-5)


def test_populations_far_below_one_turn_at_the_right_time():
    # Between its outbreaks the predator of this cycle falls to 1e-25 of its largest number.
    eaten = {"x": {"rate": "x*(1 - y)", "start": 60.0}, "y": {"rate": "y*(x - 1)", "start": 1e-3}}
    model = sf.System(name="cycle", parameters={"T": 1.0}, states=eaten, forcing={"period": "T"})
    states = sf.simulate(model, 200).states
    assert states.min() < 1e-25
    kept = states.sum(axis=1) - np.log(states).sum(axis=1)
    assert kept == pytest.approx(kept[0], rel=1e-10)


def test_what_has_almost_died_out_is_not_pushed_as_if_it_had():
    eaten = {"x": {"rate": "x*(1 - y)", "start": 60.0}, "y": {"rate": "y*(x - 1)", "start": 1e-3}}
    motion = sf.simulate(sf.System(name="cycle", parameters={}, states=eaten))
    assert motion.states.min() < 1e-25
    kept = motion.states.sum(axis=1) - np.log(motion.states).sum(axis=1)
    assert kept == pytest.approx(kept[0], rel=1e-8)
    assert "pushed" not in motion.settlement.message
