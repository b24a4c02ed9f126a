"""Relaxation oscillators: cycles that are slow and fast in turn, and canards among them."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import slipfold as sf
from helpers.foreign_systems import fitzhugh_nagumo
from slipfold.continuation import search
from slipfold.flow.scales import measured

BY_COLLOCATION = sf.Settings(discretization="collocation", largest_period=1)


def hopf_current(eps):
    """Where the trace 1 - v^2 - 0.8 eps of the Jacobian vanishes."""
    v = -np.sqrt(1 - 0.8 * eps)
    return (v + 0.7) / 0.8 - v + v**3 / 3


def closes_by_radau(orbit):
    """How far a stable orbit fails to close by an implicit Runge-Kutta method of order five."""
    model = orbit.model
    current, eps = model.values["I"], model.values["eps"]

    def rates(_, y):
        return [y[0] - y[0] ** 3 / 3 - y[1] + current, eps * (y[0] + 0.7 - 0.8 * y[1])]

    span = (0.0, orbit.duration)
    end = solve_ivp(rates, span, orbit.state, method="Radau", rtol=1e-10, atol=1e-12).y[:, -1]
    return float(np.abs(end - orbit.state).max())


@pytest.fixture(scope="module")
def spiking():
    """From rest to spikes; the branch of cycles goes through its canards and turns at a fold."""
    return sf.response(fitzhugh_nagumo(0.08), vary="I", span=(0.3, 0.4), settings=BY_COLLOCATION)


def test_the_fold_of_cycles_beyond_the_canards_is_found(spiking):
    rest, cycles = spiking.branches
    assert [item.type for item in rest.special] == ["HB"]
    assert rest.special[0].value == pytest.approx(hopf_current(0.08), abs=1e-12)
    assert rest.special[0].criticality == "subcritical"
    assert [item.type for item in cycles.special] == ["LP"]
    # Known before collocation was written; shooting, told where to look, has 0.32417852250371 too.
    assert cycles.special[0].value == pytest.approx(0.324178522504, abs=1e-11)
    assert cycles.stopped.kind == "span"


def test_a_fold_whose_multiplier_is_known_to_two_digits_is_no_disagreement():
    # Rounding of 1e-13 moves it by 1e-2, found from one side by shooting.
    settings = sf.Settings(largest_period=1, largest_duration=1e3)
    diagram = sf.response(fitzhugh_nagumo(0.08), vary="I", span=(0.3, 0.4), settings=settings)
    assert [point.type for point in diagram.branches[1].special] == ["LP"]
    assert diagram.checked.agree


@pytest.mark.parametrize("eps", [0.04])
def test_sharp_canards_are_gone_through_at_both_ends_of_the_spikes(eps, monkeypatch):
    """Turning v, w and I round (0, 7/8, 7/8) leaves the equations as they are.

    Asked for nothing, a branch changes from shooting to collocation where it has to. That the sign
    of a level tangent is rounding is no reason to look between its points.
    """
    folds, looked, sound = [], [], search.point_at
    monkeypatch.setattr(search, "point_at", lambda *args: looked.append(args) or sound(*args))
    for span, settings in (((0.305, 0.32), None), ((1.445, 1.43), BY_COLLOCATION)):
        diagram = sf.response(fitzhugh_nagumo(eps), vary="I", span=span, settings=settings)
        rest, cycles = diagram.branches
        assert [item.type for item in rest.special] == ["HB"]
        assert [item.type for item in cycles.special] == ["LP"]  # a plane has no period doubling
        assert (cycles.stopped.kind, diagram.checked.agree) == ("span", True)
        assert cycles.special[0].coefficient is None  # what grows by 1e30 leaves it no digits
        # The uncertainty is one sample of the errors, so that a larger one is no surprise.
        known = 10 * cycles.multiplier_uncertainty < abs(cycles.multipliers)
        assert (cycles.multipliers.real > 0)[known].all()
        assert known[np.abs(cycles.multipliers) > 0.9].mean() > 0.4  # none is through the canard
        folds.append(cycles.special[0].value)
        assert len(looked) < len(cycles) / 10
        looked.clear()
    assert sum(folds) == pytest.approx(1.75, abs=1e-10)


def canard_current(eps, near):
    """Where the slow motion on the attracting branch goes on along the repelling one, by Radau.

    Both are followed to the fold of v - v^3/3 at v = -1, the repelling one against time.
    """
    from scipy.integrate import solve_ivp
    from scipy.optimize import brentq

    def reached(current, v, way):
        def rates(_, y):
            return [
                way * (y[0] - y[0] ** 3 / 3 - y[1] + current),
                way * eps * (y[0] + 0.7 - 0.8 * y[1]),
            ]

        def fold(_, y):
            return y[0] + 1

        fold.terminal = True
        start = [v, v - v**3 / 3 + current]
        options = {"method": "Radau", "rtol": 1e-12, "atol": 1e-13, "events": fold}
        return solve_ivp(rates, (0, 100 / eps), start, **options).y[1, -1]

    def gap(current):
        return reached(current, -1.9, 1.0) - reached(current, 0.3, -1.0)

    return brentq(gap, near - 1e-4, near + 1e-4, xtol=1e-15)


@pytest.mark.long
@pytest.mark.parametrize("eps", [0.2, 0.01, 0.001])
def test_canards_are_gone_through_whatever_the_ratio_of_times(eps):
    """The fold of cycles lies where the canards are, but for what is exponentially small."""
    hopf = hopf_current(eps)
    diagram = sf.response(fitzhugh_nagumo(eps), vary="I", span=(hopf - 0.01, hopf + 0.05))
    rest, cycles = diagram.branches
    assert rest.special[0].value == pytest.approx(hopf, abs=1e-11)
    assert (cycles.stopped.kind, diagram.checked.agree) == ("span", True)
    assert [item.type for item in cycles.special] == ([] if eps == 0.2 else ["LP"])
    assert closes_by_radau(cycles.orbit(len(cycles) - 1)) < 1e-7
    if eps < 0.02:
        found = cycles.special[0]
        assert found.value == pytest.approx(canard_current(eps, found.value), abs=2e-12)


def watched(fast):
    """The neuron, and x' = -k (x - v): it decays by exp(-k T) a round and leaves v and w alone."""
    return sf.System(
        name="watched",
        parameters={"I": 0.0},
        states={
            "v": {"rate": "v - v^3/3 - w + I", "start": -1.2},
            "w": {"rate": "0.08*(v + 0.7 - 0.8*w)", "start": -0.6},
            "x": {"rate": f"-{fast}*(x - v)", "start": -1.2},
        },
    )


@pytest.mark.parametrize("fast", [30.0, 1e3])
def test_the_multipliers_of_a_neuron_are_the_same_beside_what_decays_at_once(fast):
    """In the plane they are known from the divergence alone (Liouville)."""
    window = {"vary": "I", "span": (0.328, 0.334), "settings": BY_COLLOCATION}
    alone = sf.response(fitzhugh_nagumo(0.08), **window).branches[1].multipliers[-1]
    beside = sf.response(watched(fast), **window).branches[1].multipliers[-1]
    assert alone[0].real > 1.1
    assert beside.real == pytest.approx([*alone.real, 0.0], abs=1e-7)


@pytest.mark.parametrize("fast", [1.0, 10.0, 1e3, 1e5])
def test_what_follows_a_neuron_and_feeds_nothing_has_no_say_in_how_large_it_becomes(fast):
    alone = measured(fitzhugh_nagumo(0.08).replace(I=0.31)).state_scales()
    beside = measured(watched(fast).replace(I=0.31)).state_scales()
    assert beside.tolist() == [*alone, alone[0]]  # slowly or at once, x follows v and no farther


@pytest.mark.long
def test_van_der_pol_from_a_center_to_a_thousand():
    """The duration by Radau's method, from a state of the cycle to its next maximum.

    Asymptotically (3 - 2 log 2) mu + 7.014 mu^(-1/3) (Dorodnitsyn 1947).
    """
    model = sf.System(
        name="van-der-pol",
        parameters={"mu": 0.0},
        states={"x": {"rate": "v", "start": 0.1}, "v": "mu*(1 - x^2)*v - x"},
    )
    settings = sf.Settings(largest_duration=1e4)
    diagram = sf.response(model, vary="mu", span=(-0.1, 1000), settings=settings)
    (cycles,) = (item for item in diagram.branches[1:] if item.stopped.kind == "span")
    assert cycles.stable[-1]
    mu, duration = float(cycles.parameter[-1]), float(cycles.durations[-1])
    assert duration == pytest.approx((3 - 2 * np.log(2)) * mu + 7.014 * mu ** (-1 / 3), rel=1e-5)

    def crosses(_, y):
        return y[0]

    crosses.direction = 1.0
    found = solve_ivp(
        lambda _, y: [y[1], mu * (1 - y[0] ** 2) * y[1] - y[0]],
        (0, 3 * duration),
        [2.0, 0.0],
        method="Radau",
        rtol=1e-10,
        atol=1e-12,
        events=crosses,
    )
    assert np.diff(found.t_events[0])[-1] == pytest.approx(duration, rel=1e-7)


@pytest.mark.long
def test_hodgkin_and_huxley_from_rest_to_block():
    """Hopf points and folds as published: Rinzel and Miller, Mathematical Biosciences 49 (1980)
    27-59; Guckenheimer and Oliva, SIAM J. Appl. Dyn. Syst. 1 (2002) 105-114: three folds, and two
    period doublings between the first two of them."""
    model = sf.System(
        name="hodgkin-huxley",
        parameters={"I": 0.0},
        states={
            "V": {
                "rate": "I - 120*m^3*h*(V - 50) - 36*n^4*(V + 77) - 0.3*(V + 54.387)",
                "start": -65,
            },
            "m": {
                "rate": "1/exprel(-(V + 40)/10)*(1 - m) - 4*exp(-(V + 65)/18)*m",
                "start": 0.05,
            },
            "h": {
                "rate": "0.07*exp(-(V + 65)/20)*(1 - h) - h/(1 + exp(-(V + 35)/10))",
                "start": 0.6,
            },
            "n": {
                "rate": "0.1/exprel(-(V + 55)/10)*(1 - n) - 0.125*exp(-(V + 65)/80)*n",
                "start": 0.3,
            },
        },
    )
    found = []
    for how in ("automatic", "collocation"):
        settings = sf.Settings(discretization=how, largest_period=1)
        diagram = sf.response(model, vary="I", span=(0, 200), settings=settings)
        rest, cycles = diagram.branches
        assert [item.type for item in rest.special] == ["HB", "HB"]
        assert [item.type for item in cycles.special] == ["LP", "PD", "PD", "LP", "LP"]
        assert (cycles.stopped.kind, diagram.checked.agree) == ("closed", True)
        found.append([item.value for item in (*rest.special, *cycles.special)])
    assert found[0] == pytest.approx(found[1], rel=1e-9)
    published = [9.78, 154.5, 7.84, 7.85, 7.92, 7.92, 6.26]
    assert found[0] == pytest.approx(published, abs=0.03)


@pytest.mark.long
def test_carbon_monoxide_on_platinum_from_one_hopf_point_through_canards_to_the_other():
    """Bykov, Yablonskii and Kim, Doklady AN SSSR 242 (1978) 637-639.

    Folds and Hopf points as in MatCont's manual, where it is the catalytic oscillator.
    """
    model = sf.System(
        name="carbon-monoxide",
        parameters={"q2": 0.6},
        formulas={"z": "1 - x - y - s"},
        states={
            "x": {"rate": "5*z^2 - 2*x^2 - 10*x*y", "start": 0.07},
            "y": {"rate": "q2*z - 0.1*y - 10*x*y", "start": 0.2},
            "s": {"rate": "0.0675*(z - 0.4*s)", "start": 0.5},
        },
    )
    diagram = sf.response(model, vary="q2", span=(0.6, 1.9))
    rest, cycles = diagram.branches
    assert [item.type for item in rest.special] == ["HB", "LP", "LP", "HB"]
    published = [1.040991, 1.052200, 1.042049, 1.051558]
    assert [item.value for item in rest.special] == pytest.approx(published, abs=1e-6)
    assert [item.type for item in cycles.special] == ["LP", "LP"]
    assert (cycles.stopped.kind, diagram.checked.agree) == ("closed", True)


def test_a_focus_that_a_canard_passes_is_no_saddle_of_a_loop():
    # Peng, Scott and Showalter, J. Phys. Chem. 94 (1990) 5243: one equilibrium, whose focus is
    # left at a rate of half a duration.
    rates = {"a": "m*(10 + c) - a*b^2 - a", "b": "(a*b^2 + a - b)/0.005", "c": "(b - c)/0.02"}
    model = sf.System(parameters={"m": 0.05}, states={name: rates[name] for name in "abc"})
    settings = sf.Settings(largest_period=1)
    _, cycles = sf.response(model, "m", (0.05, 0.3), settings=settings).branches
    assert cycles.stopped.kind == "span"

    def rates(_, q):
        a, b, c = q
        return [3 + 0.3 * c - a * b**2 - a, (a * b**2 + a - b) / 0.005, (b - c) / 0.02]

    span, start = (0, cycles.durations[-1]), cycles.nodes[-1, 0]
    end = solve_ivp(rates, span, start, "Radau", rtol=1e-9, atol=1e-10).y[:, -1]
    assert end == pytest.approx(start, abs=1e-5)
