"""Simulation: stroboscopic states, dense output, limits, and what cannot be used."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

import slipfold as sf
from helpers.by_hand.sliding import BASE, integrate, rhs
from helpers.toy_models import Falling, LinearOscillator, Runaway
from slipfold import InputError, SlidingOscillator
from slipfold.flow.simulate import simulate
from slipfold.flow.trajectory import reached
from slipfold.models.registry import model_named

SCALE = np.array([1.0, 1.0, 80.0, 80.0])
SLIDING = SlidingOscillator(f=12.2, Nd=0.15)


@pytest.fixture(scope="module")
def linear():
    return simulate(LinearOscillator(), 300, {"x": 0.3, "v": -2.0})


@pytest.fixture(scope="module")
def sliding():
    return simulate(SLIDING, 1000)


def test_stroboscopic_states_of_a_linear_oscillator_are_exact(linear):
    exact = linear.model.exact(linear.time, [0.3, -2.0])
    assert linear.states == pytest.approx(exact, abs=1e-12)
    assert linear.settlement.settled
    assert linear.settlement.period == 1


@settings(max_examples=50)
@given(st.lists(st.floats(0, 300), min_size=1, max_size=20))
def test_dense_output_is_exact_anywhere(linear, cycles):
    times = np.array(cycles) * linear.forcing_period
    assert linear.at(times) == pytest.approx(linear.model.exact(times, [0.3, -2.0]), abs=1e-11)


def test_extrema_are_those_of_the_exact_response(linear):
    late = (300 + np.linspace(0, 1, 20_001)) * linear.forcing_period
    exact = linear.model.exact(late, [0.3, -2.0])[:, 0]
    assert linear.extrema("x") == pytest.approx([exact.max()], rel=1e-6)
    assert linear.extrema("x", "min") == pytest.approx([exact.min()], rel=1e-6)
    assert linear.extrema("x", "peak_to_peak") == pytest.approx([np.ptp(exact)], rel=1e-6)
    with pytest.raises(InputError, match="an output has no 'mean'; did you mean min"):
        linear.extrema("x", "mean")
    for periods in (0, -5):
        with pytest.raises(InputError, match=f"periods = {periods} is less than 1"):
            linear.extrema("x", periods=periods)


@pytest.mark.parametrize(("name", "fewest"), [("duffing", 2), ("lorenz", 5)])
def test_runs_too_short_for_extrema_are_refused(name, fewest):
    model = model_named(name)
    with pytest.raises(InputError, match=f"whole .*, fewer than {fewest}; simulate longer"):
        simulate(model, fewest - 1).extrema(model.shown[0])
    assert len(simulate(model, fewest).extrema(model.shown[0], periods=1)) == 1


def test_a_value_on_the_border_of_a_window_is_no_extremum():
    cycle = sf.simulate(model_named("vanderpol-free"), 60, duration=1)  # a round is 6.66 s
    assert not cycle.settlement.settled
    assert cycle.extrema("x") == pytest.approx([2.00861986], rel=1e-5)
    growth = sf.System(states={"x": "0.01*x"})  # it never turns
    for measure, value in {"max": np.exp(0.2), "min": np.exp(0.03)}.items():
        found = sf.simulate(growth, 20, {"x": 1}, duration=1).extrema("x", measure)
        assert found == pytest.approx([value], rel=1e-3)
    # One window has its largest value inside and none its smallest: both are those of all values.
    climb = sf.System(states={"x": "0.7 + u", "u": "v", "v": "-u"})
    run = sf.simulate(climb, 60, {"x": 0, "u": 1, "v": 0}, duration=1.7)
    (high,), (low,), (both,) = (run.extrema("x", it) for it in ("max", "min", "peak_to_peak"))
    assert both == high - low


def test_an_extremum_of_few_samples_is_the_vertex_of_a_parabola():
    turns, step = 2 * np.pi * 8 * np.arange(48) / 48, np.pi / 3
    midway = np.cos(step / 2) + (np.cos(step / 2) - np.cos(1.5 * step)) / 8  # where it errs most
    for phase in np.linspace(0, step, 9):
        (found,) = reached(np.cos(turns + phase), 48, "max", True, True)
        assert midway - 1e-12 <= found <= 1 + 1e-12


def test_extrema_of_outputs_that_jump_are_their_samples():
    jumps = sf.System(
        parameters={"W": 1}, forcing={"period": "2*pi/W"}, states={"q": "-q"},
        outputs={"sign": "tanh(1e6*cos(W*t - 0.1))"},
    )  # fmt: skip
    for measure, value in {"max": 1, "min": -1, "peak_to_peak": 2, "modulus": 1}.items():
        assert simulate(jumps, 40).extrema("sign", measure).tolist() == [value]


def test_rest_has_one_extremum():
    assert len(simulate(model_named("squeal"), 1000).extrema("x")) == 1


def test_samples_agree_with_the_dense_output(sliding):
    times, states = sliding.sample(3, 7, 10)
    assert states.shape == (40, 4)
    assert times == pytest.approx((3 + np.arange(40) / 10) / 12.2)
    assert states / SCALE == pytest.approx(sliding.at(times) / SCALE, abs=1e-12)
    times, force = sliding.output("Fx", 3, 7, 10)
    assert force == pytest.approx(SLIDING.evaluate("Fx", states, times), abs=1e-12)


def test_settled_state_of_the_reference(sliding):
    expected = [0.34186773524, -0.17677244957, 0.051411204625, 12.166386307]
    assert (sliding.settlement.settled, sliding.settlement.period) == (True, 2)
    near = min(sliding.states[-2:], key=lambda state: np.abs(state - expected).max())
    assert near == pytest.approx(expected, rel=1e-8)
    assert integrate(near, {**BASE, **SLIDING.values}, 2) / SCALE == pytest.approx(
        near / SCALE, abs=1e-10
    )


def test_promised_number_of_periods_settles_a_slow_transient():
    model = SlidingOscillator(f=12.5, Nd=0.041)
    first = simulate(model, 300)
    more = int(first.settlement.message.split("about ")[1].split()[0])
    assert 10 < more < 5000
    assert simulate(model, 300 + more + 20).settlement.settled


def test_unstable_orbit_is_not_called_settled():
    state = [0.098213199247, -0.035076538475, 1.722533093226, 16.172916936663]
    run = simulate(SlidingOscillator(f=12.5, Nd=0.05), 100, state)
    assert "leaving an unstable response" in run.settlement.message


# -- limits -----------------------------------------------------------------------------------


def test_stick_ends_the_run_where_scipy_finds_it():
    model = SlidingOscillator(f=12.2, Nd=0.9, Vd=0.1)
    run = simulate(model, 100, through_stick=False)
    assert run.stopped.kind == "stick"
    assert "fell to 0.01 of Vd" in run.stopped.reason
    assert len(run.states) == 3
    assert not run.settlement.settled
    assert run.stopped.reason in run.settlement.message

    def slip(time, state):
        return model.evaluate("Vrel_ratio", state, time) - 0.01

    slip.terminal = True
    p = {**BASE, **model.values}
    found = solve_ivp(
        lambda t, q: rhs(t, q, p),
        (0, 1),
        np.zeros(4),
        "DOP853",
        events=slip,
        rtol=1e-11,
        atol=1e-12,
    )
    assert run.stopped.time == pytest.approx(found.t_events[0][0], rel=1e-9)
    assert run.duration == run.stopped.time
    assert run.at(run.stopped.time) / SCALE == pytest.approx(found.y_events[0][0] / SCALE, abs=1e-7)
    with pytest.raises(InputError, match=r"is outside the run; give 0 to 0\.1\d+ s"):
        run.at(0.2)


def test_limit_is_met_at_the_right_instant():
    run = simulate(Falling(f=4.0), 100, [0.5, 0.0])
    assert run.stopped.kind == "ground"
    assert run.stopped.time == pytest.approx(1.0, rel=1e-14)
    assert run.stopped.reason.startswith("hit the ground at x = ")
    assert run.at(0.9) == pytest.approx([0.5 - 0.405, -0.9], abs=1e-13)


def test_start_beyond_a_limit_ends_at_once():
    run = simulate(Falling(), 10, [-1.0, 0.0])
    assert (run.stopped.kind, run.stopped.time) == ("ground", 0.0)
    assert "x = -1" in run.stopped.reason
    assert run.states.tolist() == [[-1.0, 0.0]]
    assert run.at(0.0).tolist() == [-1.0, 0.0]
    with pytest.raises(InputError, match="none of the 0 simulated"):
        run.sample()
    with pytest.raises(InputError, match="simulate longer"):
        run.steady()


def test_an_overflow_says_when_it_was_at_the_earliest():
    # cosh(1/w) is beyond what there is.
    steep = sf.System(
        parameters={"w": 1e-4},
        states={"x": "v", "v": "cos(t) - x - 0.1*v - 0.5/cosh(v/w)^3"},
        forcing={"period": "2*pi"},
    )
    run = simulate(steep, 5, [0.1, 0.05])
    assert "more than 0 s after the start, in forcing period 1" in run.stopped.reason
    assert run.stopped.time == 0


def test_starts_at_which_rates_are_infinite_end_at_once():
    plates = sf.System(states={"x": "v", "v": "1/(1 - x)^2 - x - 0.1*v"})
    rub = {"slip": "-v", "normal": "1", "friction": {"law": "Coulomb", "mu_k": 0.3}}
    rubbing = sf.System(states={"x": "v", "v": "R - x^3"}, contacts={"R": rub})
    for model, start in ((plates, [1.0, 0.0]), (rubbing, [1e200, 0.0])):
        stopped = simulate(model, 5, start).stopped
        assert (stopped.kind, stopped.time) == ("singular", 0)
    tank = sf.System(parameters={"W": 1}, forcing={"period": "2*pi/W"}, states={"h": "1 - sqrt(h)"})
    assert simulate(tank, 5).stopped.reason.endswith("in forcing period 1; start elsewhere")
    stopped = simulate(tank, 5, [-1.0]).stopped
    assert (
        stopped.reason == "the rate of h has no value where the trajectory starts; start elsewhere"
    )


def test_singularity_without_a_limit_ends_the_run():
    run = simulate(Runaway(f=2.0), 1000, [1 / 9.7])
    assert run.stopped.kind == "singular"
    assert "became singular 9.7 s after the start, in forcing period 20" in run.stopped.reason
    assert run.states[:, 0] == pytest.approx(1 / (9.7 - np.arange(20) / 2), rel=1e-9)
    assert run.stopped.time == pytest.approx(9.7, rel=1e-6)
    assert run.at([1.0, 9.6])[:, 0] == pytest.approx([1 / 8.7, 10], rel=1e-8)


# -- bad input --------------------------------------------------------------------------------


@pytest.mark.parametrize("periods", [0, -5, 2.5, True, "10"])
def test_periods_must_be_a_whole_number(periods):
    with pytest.raises(InputError, match="not a whole number of at least 1"):
        sf.simulate(SLIDING, periods)


@pytest.mark.parametrize(
    ("state", "message"),
    [
        ([0, 0, 0], "not a list of 4 numbers; give x, y, vx, vy"),
        ([[0, 0, 0, 0]], "not a list of 4 numbers"),
        ([0, 0, np.nan, 0], "the state vx = nan is not a finite number"),
        ([0, 0, 0, np.inf], "the state vy = inf"),
        ([1, None, 0, 0], "the state y = None is not a finite number"),
        ("rest", "not a list of 4 numbers"),
        ({"VX": 1.0}, "no state 'VX'; did you mean vx?"),
        ({"x": "left"}, "is not a number"),
    ],
)
def test_bad_state_gets_one_sentence(state, message):
    with pytest.raises(InputError, match=message):
        simulate(SLIDING, 10, state)


@pytest.mark.parametrize("tolerance", [0.0, -1e-9, np.nan, np.inf])
def test_bad_tolerance_is_refused(tolerance):
    with pytest.raises(InputError, match="not a positive number"):
        sf.simulate(SLIDING, 10, tolerance=tolerance)


def test_bad_questions_to_a_run_get_one_sentence(sliding):
    with pytest.raises(InputError, match=r"time = -0\.1 s is outside the run"):
        sliding.at([0.1, -0.1])
    with pytest.raises(InputError, match="time = nan s is outside"):
        sliding.at(np.nan)
    with pytest.raises(InputError, match="2 dimensions"):
        sliding.at([[0.0]])
    with pytest.raises(InputError, match="the periods 5 to 5 are none"):
        sliding.sample(5, 5)
    with pytest.raises(InputError, match="per_period = 0"):
        sliding.sample(per_period=0)
    with pytest.raises(InputError, match="no output 'z'"):
        sliding.output("z")
    with pytest.raises(InputError, match="periods = 0"):
        sliding.steady(0)


@pytest.mark.parametrize("unit", [1e-9, 1e9])
def test_motion_does_not_depend_on_the_unit_of_what_a_limit_watches(unit):
    model = sf.System(
        name="loaded",
        parameters={"W": 1.2, "K": {"value": 1.0, "min": 0}},
        states={"x": "v", "v": "cos(W*t) - 0.1*v - x - x^3"},
        forcing={"period": "2*pi/W"},
        outputs={"load": "K*(x + 3)"},
        limits={"lift off": {"output": "load", "bound": 0}},
    )
    expected = simulate(model, 8, [0.3, 0.4]).states
    found = simulate(model.replace(K=unit), 8, [0.3, 0.4]).states
    # Rounding of the weight in each of some hundred steps.
    assert found == pytest.approx(expected, abs=1e-12)


# -- watched ---------------------------------------------------------------------------------------


class Impatient:
    """Watches a motion, and interrupts it."""

    def __init__(self, periods=None, stage="motion"):
        self.periods, self.stage, self.seen = periods, stage, []

    def __call__(self, progress):
        self.seen.append(progress)
        reached = self.periods is not None and progress.done >= self.periods
        if progress.stage == self.stage and reached:
            raise KeyboardInterrupt


MOTIONS = {
    "forced": {"model": sf.SlidingOscillator(f=12.5, Nd=0.1)},
    "free": {"model": sf.built_in_models()["vanderpol-free"](), "duration": 1.0},
    "through stick": {"model": sf.SlidingOscillator(f=12.2, Nd=0.9, Vd=0.1)},
}


@pytest.mark.parametrize("which", MOTIONS)
def test_who_watches_a_motion_changes_nothing_and_may_end_it(which):
    case = MOTIONS[which]
    watcher = Impatient()
    whole = sf.simulate(**case, periods=200, on_progress=watcher)
    assert not whole.interrupted
    assert (whole.states == sf.simulate(**case, periods=200).states).all()
    motions = [item for item in watcher.seen if item.stage == "motion"]
    done = [item.done for item in motions]
    if which == "through stick":  # it begins again where slip alone has ended
        done = done[done.index(1) :]
    assert done == sorted(done)
    assert (done[-1], {item.total for item in motions}) == (200, {200})
    assert motions[-1].text == f"{whole.duration:.6g} s"
    part = sf.simulate(**case, periods=200, on_progress=Impatient(50))
    assert 50 <= part.periods < 70
    assert part.stopped.kind == "interrupted"
    assert part.stopped.time == pytest.approx(part.periods * part.forcing_period, rel=0.05)
    assert (part.states == whole.states[: part.periods + 1]).all()
    assert part.interrupted
    assert not part.settlement.settled
    assert "it was interrupted" in part.summary()


def test_checks_of_a_motion_may_be_interrupted():
    case = MOTIONS["forced"]
    motion = sf.simulate(**case, periods=50, on_progress=Impatient(0, "checks"))
    assert motion.stopped is None
    assert (motion.interrupted, motion.checked.interrupted) == (True, True)
