"""No step leads past the turn of a steep function, however steep it is and wherever it turns."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import erf, ive

import slipfold as sf
from helpers.long_tests import long_except
from slipfold import Coulomb, InputError, Regularized
from slipfold.flow.flow import flow_of
from slipfold.flow.simulate import simulate
from slipfold.models.quantities import Limit, Output

UNIT, UP = np.eye(3)[:1], np.eye(2)
STEEPNESS = 10.0 ** np.random.default_rng(4).uniform(-6, 0, 9)


def turning(formula):
    """A state that goes round a circle, and a narrow function of it that is summed up."""
    return sf.System(
        name="turning",
        parameters={"w": {"value": 1.0, "min": 0}, "T": {"value": 1.0, "min": 0}},
        states={"x": "-2*pi*y", "y": "2*pi*x", "z": formula},
        forcing={"period": "T"},
    )


def bell_sum(r):
    """Integral of exp(-(r cos)^2) over a turn of size one; of long series the first terms."""
    return np.where(r > 1e3, (1 + 0.25 / r**2) / (math.sqrt(math.pi) * r), ive(0, r * r / 2))


def hill_sum(r):
    """Integral of 1/(1 + (r cos)^2)."""
    return 1 / np.sqrt(1 + r * r)


def whole_turn(formula):
    model = turning(formula)
    flow = flow_of(model)
    constants = flow.constants(np.array([model.replace(w=w).vector for w in STEEPNESS]))
    start = np.tile([1.0, 0.0, 0.0], (len(STEEPNESS), 1))
    return flow, start, np.zeros(len(start)), np.ones(len(start)), constants


@pytest.mark.parametrize(
    ("formula", "exact"), [("exp(-(x/w)^2)", bell_sum), ("1/(1 + (x/w)^2)", hill_sum)]
)
def test_narrow_functions_of_a_state_are_summed_exactly(formula, exact):
    flow, *path = whole_turn(formula)
    # A hundred steps or less, of which each may be wrong by 1e-13.
    assert flow.advance(*path)[:, 2] == pytest.approx(exact(1 / STEEPNESS), rel=1e-12, abs=1e-11)


def test_their_derivatives_are_exact():
    formula = "1/(1 + (x/w)^2)"
    flow, *path = whole_turn(formula)
    along = path[-1].rates[:, :, :1]
    r = 1 / STEEPNESS
    first = -(r**2) / (1 + r**2) ** 1.5
    second = r**2 * (2 * r**2 - 1) / (1 + r**2) ** 2.5
    third = r**4 * (9 - 6 * r**2) / (1 + r**2) ** 3.5
    _, matrices, vectors = flow.linearize(*path, along)
    assert matrices[:, 2, 0] == pytest.approx(first, rel=1e-11)
    assert vectors[:, 2, 0] == pytest.approx(-first * r, rel=1e-11)
    bent, _ = flow.curve(*path, along, np.tile([1.0, 0.0, 0.0], (len(r), 1)))
    assert bent[:, 2, 0] == pytest.approx(second, rel=1e-10)
    for w, *slopes in zip(STEEPNESS, first, second, third, strict=True):
        constants = flow.constants(turning(formula).replace(w=w).vector)
        jet = flow.jet(path[0][0], 0.0, 1.0, constants, UNIT)
        # The steps of jets may be wrong by 1e-10.
        assert jet[0, :, 2] == pytest.approx(slopes, abs=1e-8)


def switching(law):
    return sf.System(
        name="switching",
        parameters={"W": 0.8, "F": 2.0, "d": 0.02, "e": {"value": 1e-3, "min": 0}},
        states={"x": "v", "v": f"F*cos(W*t) - x - d*v - 0.5*({law})"},
        forcing={"period": "2*pi/W"},
    )


LAWS = {
    "tanh(v/e)": lambda x, v, t, e: np.tanh(v / e),
    "erf(v/e)": lambda x, v, t, e: erf(v / e),
    "2*sigmoid(v/e) - 1": lambda x, v, t, e: np.tanh(v / e / 2),
    "2/(exp(-v/e) + 1) - 1": lambda x, v, t, e: np.tanh(v / e / 2),
    "v/sqrt(v^2 + e^2)": lambda x, v, t, e: v / math.hypot(v, e),
    "atan2(v, e)": lambda x, v, t, e: math.atan2(v, e),
    "(x/0.7)^41/(1 + (x/0.7)^40)": lambda x, v, t, e: x / 0.7 - (x / 0.7) / (1 + (x / 0.7) ** 40),
    "tanh(20*tanh(v/e) - x)": lambda x, v, t, e: math.tanh(20 * math.tanh(v / e) - x),
    "tanh((v - 0.3*sin(W*t) - 0.1*x)/e)": lambda x, v, t, e: math.tanh(
        (v - 0.3 * math.sin(0.8 * t) - 0.1 * x) / e
    ),
}


@pytest.mark.parametrize("law", long_except(LAWS, [*LAWS][1::2]))
def test_switching_laws_agree_with_an_implicit_method(law):
    steepness = STEEPNESS[[*LAWS].index(law)]
    model = switching(law).replace(e=steepness)

    def rates(time, state):
        x, v = state
        force = LAWS[law](x, v, time, steepness)
        return [v, 2 * math.cos(0.8 * time) - x - 0.02 * v - 0.5 * force]

    start, end = [0.3, 0.4], 2 * math.pi / 0.8
    # With a tolerance of 1e-9 Radau's own steps may lead past half of a turn.
    reference = solve_ivp(rates, (0, end), start, "Radau", rtol=1e-11, atol=1e-13)
    result = simulate(model, 1, start).states[-1]
    assert result == pytest.approx(reference.y[:, -1], abs=1e-10)


def test_trajectories_that_turn_at_other_times_are_followed_at_once():
    """They take more steps than one call of the integrator, which each ends in other places."""
    model, count = switching("tanh(v/e)").replace(e=1e-3), 40
    starts = np.column_stack([np.linspace(-1, 1, 9), np.linspace(2, 0, 9)])
    flow, ends = flow_of(model), np.full(len(starts), float(count))
    found = flow.advance(starts, 0 * ends, ends, flow.constants_of(model))
    one_by_one = [simulate(model, count, start).states[-1] for start in starts]
    assert found == pytest.approx(np.array(one_by_one), abs=1e-10)


@pytest.mark.parametrize("shape", ["tanh", "atan", "sqrt"])
def test_regularized_contact_whose_slip_reverses(shape):
    """A mass that is dragged to and fro: Coulomb's law to within the width of its rise."""
    law = Regularized(Coulomb(mu_s=0.5, mu_k=0.5), shape, e=1e-6)
    model = sf.Structure(
        np.eye(1),
        0.05 * np.eye(1),
        np.eye(1),
        contacts=sf.FrictionContact("q1", law, load=1.0, Vd=0.02),
        forcing=sf.HarmonicForce("q1", F=2.0),
    ).replace(f=0.13)

    def rates(time, state):
        x, v = state
        force = 2 * math.cos(2 * math.pi * 0.13 * time) + 0.5 * np.sign(0.02 - v)
        return [v, force - 0.05 * v - x]

    start, end = [0.3, 0.4], 1 / 0.13
    found = solve_ivp(rates, (0, end), start, "Radau", rtol=1e-8, atol=1e-10)
    assert simulate(model, 1, start).states[-1] == pytest.approx(found.y[:, -1], abs=2e-5)


@pytest.mark.parametrize("corner", ["select", "relu"])
def test_corners_are_refused_not_stepped_over(corner):
    """Half a turn of |x| would be what a step makes of the side it begins on."""
    import heyoka as hy

    from helpers.toy_models import LinearOscillator

    fold = hy.relu if corner == "relu" else lambda x: hy.select(hy.gte(x, 0.0), x, -x)

    class Folded(LinearOscillator):
        name = f"folded by {corner}"

        def rates(self, q, c, phase):
            force = hy.cos(2 * math.pi * phase) - fold(q["x"])
            return {"x": q["v"], "v": force - 0.1 * q["v"]}

    class Watched(LinearOscillator):
        name, limits = f"watched by {corner}", (Limit("low", "size", -1.0, "it is low"),)

        def outputs(self):
            return (Output("size", lambda q, c, phase: fold(q["x"]), "m"),)

    for compute in (
        lambda: sf.response(Folded(), vary="f", span=(0.2, 0.4)),
        lambda: simulate(Folded(), 3, [1.0, 0.0]),
        lambda: simulate(Watched(), 3, [1.0, 0.0]),
    ):
        with pytest.raises(InputError, match="corner or a jump"):
            compute()
