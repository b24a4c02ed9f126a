"""Normal forms of cycles of unknown duration, from their return maps."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import slipfold as sf
from slipfold.models.registry import model_named
from slipfold.orbits.periodic_orbit import StickSlipOrbit

ALONE = sf.Settings(largest_period=1)
ROUND = {"x": "x*(1 - x^2 - y^2) - y", "y": "y*(1 - x^2 - y^2) + x"}
"""A cycle of radius one and duration 2 pi."""


def special(diagram, kind, branch):
    return [item for item in diagram.branches[branch - 1].special if item.type == kind]


def beside(first, last, **states):
    """What becomes of the round cycle as r goes from first to last, with more states beside it."""
    model = sf.System(name="beside", parameters={"r": first}, states={**ROUND, **states})
    start = [1.0, 0.0] + [0.0] * len(states)
    cycle = sf.periodic_orbit(model, state=start, duration=6)
    return sf.response(cycle, vary="r", span=(first, last), settings=ALONE)


def test_doubling_of_the_lure_cycle():
    # xi becomes mu xi + b xi^3 with mu near -1: on the doubled branch xi^2 = -(1 + mu)/b. The
    # halves of its orbits differ by 2 xi times a vector whose mean square is one.
    born = 0.6303020061596
    events = [sf.Event("a", born - gap, "parameter") for gap in (1e-4, 2e-4)]
    options = {"settings": sf.Settings(largest_period=2), "events": events}
    diagram = sf.response(model_named("lure"), vary="a", span=(1.2, 0.62), **options)
    (doubling,) = special(diagram, "PD", 2)
    estimates = []
    for once, twice in zip(special(diagram, "EVENT", 2), special(diagram, "EVENT", 3), strict=True):
        halves = np.split(twice.orbit.sample(128)[1], 2)
        square = np.mean(np.sum((halves[0] - halves[1]) ** 2, axis=1)) / 4
        estimates.append(-(1 + once.multipliers.real.min()) / square)
    near, far = estimates
    assert doubling.coefficient == pytest.approx(2 * near - far, rel=1e-4)
    assert doubling.criticality == "supercritical"


TANK = {"x": "D*(1 - x)*exp(y) - x", "y": "14*D*(1 - x)*exp(y) - 4*y"}
"""A stirred tank after Uppal, Ray and Poore (1974): its cycles jump."""

ROESSLER = {"x": "-y - z", "y": "x + 0.2*y", "z": "0.2 + z*(x - c)"}
RUBBED = {**ROESSLER, "y": "x + 0.2*y + F"}
ALWAYS_SLIPS = {"slip": "30 - y", "normal": "0.1", "friction": sf.Coulomb(mu_s=0.4, mu_k=0.4)}


@pytest.mark.parametrize(
    ("kind", "states", "vary", "span", "start", "duration"),
    [
        ("LP", TANK, "D", (0.17, 0.155), [0.60, 0.997], 5.0),
        ("PD", ROESSLER, "c", (2.6, 2.9), [-3.6, 0.0, 0.03], 5.8),
        ("PD", RUBBED, "c", (2.6, 2.9), [-3.6, 0.0, 0.03], 5.8),
    ],
)
def test_a_coefficient_is_the_same_all_round(kind, states, vary, span, start, duration):
    contacts = {"F": ALWAYS_SLIPS} if states is RUBBED else None
    model = sf.System(name=kind, parameters={vary: span[0]}, states=states, contacts=contacts)
    settled = sf.simulate(model, 60, start).states[-1]
    cycle = sf.periodic_orbit(model, state=settled, duration=duration)
    found = []
    for state in cycle.sample(64)[1][::22]:
        again = sf.periodic_orbit(model, state=state, duration=cycle.model.duration)
        if contacts:  # it is followed through all modes
            again = StickSlipOrbit(again.model, 1, again.nodes, again.multipliers, again.residual)
        (point,) = special(sf.response(again, vary, span, settings=ALONE), kind, 1)
        found.append(np.array([point.value, point.coefficient], dtype=float))
    assert np.array(found) == pytest.approx(np.array(found[:1] * len(found)), rel=1e-8)


@pytest.mark.parametrize("state", [[1.0, 0.0], [0.6, -0.8]])
def test_fold_of_cycles_is_exact(state):
    # r' = r (m + 2 r^2 - r^4): at m = -1, r = 1 the radial map has the second derivative -8 T;
    # two cycles exist above, so a < 0.
    square = "(x^2 + y^2)"
    growth = f"(m + 2*{square} - {square}^2)"
    states = {"x": f"x*{growth} - y", "y": f"y*{growth} + x"}
    model = sf.System(name="Bautin", parameters={"m": -0.5}, states=states)
    radius = np.sqrt(1 + np.sqrt(0.5))
    cycle = sf.periodic_orbit(model, state=radius * np.array(state), duration=6)
    diagram = sf.response(cycle, vary="m", span=(-0.5, -1.2), settings=ALONE)
    (fold,) = special(diagram, "LP", 1)
    assert fold.value == pytest.approx(-1, abs=1e-11)
    assert fold.coefficient == pytest.approx(-4 * 2 * np.pi, rel=1e-7)
    assert fold.criticality is None


@pytest.mark.parametrize("n", [1, -0.5])
def test_torus_of_cycles_is_exact(n):
    # w' = (r + 0.3 i) w - n w |w|^2: |w| becomes |w| (1 - n T |w|^2); a unit vector has
    # |w|^2 = 2 |zeta|^2.
    square = f"{n}*(u^2 + v^2)"
    diagram = beside(-0.3, 0.3, u=f"r*u - 0.3*v - u*{square}", v=f"0.3*u + r*v - v*{square}")
    (torus,) = special(diagram, "NS", 1)
    assert torus.value == pytest.approx(0, abs=1e-11)
    assert torus.critical_multiplier == pytest.approx(np.exp(0.6j * np.pi), abs=1e-9)
    assert torus.coefficient == pytest.approx(-2 * n * 2 * np.pi, rel=1e-7)
    assert torus.criticality == ("supercritical" if n > 0 else "subcritical")


def test_a_forced_doubling_is_that_of_the_cycle_with_its_forcing():
    # The force comes from an oscillator of its own: the same map, beside a fast decay.
    rate = "-0.02*v - (1 + h*{wave})*q - q^3"
    forced = sf.System(
        name="forced",
        parameters={"h": 0.0},
        states={"q": "v", "v": rate.format(wave="cos(2*t)")},
        forcing={"period": "pi"},
    )
    turns = {"x": "x*(1 - x^2 - y^2) - 2*y", "y": "y*(1 - x^2 - y^2) + 2*x"}
    states = {**turns, "q": "v", "v": rate.format(wave="x")}
    own = sf.System(name="own", parameters={"h": 0.02}, states=states)
    (published,) = special(sf.response(forced, "h", (0, 0.06), settings=ALONE), "PD", 1)
    cycle = sf.periodic_orbit(own, state=[1, 0, 0, 0], duration=np.pi)
    (doubling,) = special(sf.response(cycle, "h", (0.02, 0.06), settings=ALONE), "PD", 1)
    assert doubling.value == pytest.approx(published.value, abs=1e-10)
    assert doubling.criticality == published.criticality
    # The forced one has a unit vector at phase zero, the other one in the mean over the period.
    mean = mean_square(published.value)
    assert doubling.coefficient == pytest.approx(published.coefficient / mean, rel=1e-6)


def mean_square(h):
    """Of the critical vector of q'' + 0.02 q' + (1 + h cos 2t) q = 0 over a period, by SciPy."""

    def rates(time, vectors):
        matrix = np.array([[0, 1], [-(1 + h * np.cos(2 * time)), -0.02]])
        return (matrix @ vectors.reshape(2, 2)).ravel()

    grid = np.linspace(0, np.pi, 65)
    run = solve_ivp(
        rates, (0, np.pi), np.eye(2).ravel(), "DOP853", rtol=1e-12, atol=1e-13, t_eval=grid
    )
    matrices = run.y.T.reshape(-1, 2, 2)
    values, vectors = np.linalg.eig(matrices[-1])
    critical = vectors[:, np.abs(values + 1).argmin()].real
    return np.mean(np.sum((matrices[:-1] @ critical) ** 2, axis=1))
