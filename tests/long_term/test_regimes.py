"""A map of regimes says what single motions, exponents and branches say."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import slipfold as sf
from helpers.toy_models import FLOOR
from slipfold import InputError
from slipfold.flow.ensembles import models_with
from slipfold.long_term.classification import classify_open
from slipfold.plots.regions import COLORS

OSCILLATOR = sf.SlidingOscillator()

WEAK = sf.System(
    name="weak",
    parameters={"w": 2.3, "c": 0.002, "T": {"value": 1.0, "min": 0}},
    states={"x": "v", "v": "cos(2*pi*t/T) - w^2*x - c*v"},
    forcing={"period": "T"},
)


@pytest.fixture(scope="module")
def plane():
    return sf.regimes(OSCILLATOR, {"f": (12.2, 12.5), "Nd": (0.06, 0.12)}, points=(2, 2))


@pytest.fixture(scope="module")
def folds():
    return sf.regimes(OSCILLATOR, {"f": (12.2, 12.21), "Nd": (0.06, 0.16)}, points=(2, 6))


def test_tori_and_chaos_are_those_of_the_exponents(plane):
    assert plane.names("up").tolist() == [["period 1", "period 1"], ["torus", "chaos"]]
    assert abs(plane.exponents[1, 1, 0]) < 3e-4
    # 0.0295 +- 0.0003, by the exact variational flow over long.
    assert plane.exponents[1, 1, 1] == pytest.approx(0.0295, abs=0.006)
    assert np.isnan(plane.exponents[1, 0]).all()


def test_responses_coexist_between_the_folds(folds):
    # By continuation both are stable from 0.0741 to 0.1398 N.
    assert folds.names("down")[0].tolist() == ["period 1", *["period 2"] * 5]
    assert folds.names("up")[0].tolist() == [*["period 1"] * 4, "period 2", "period 2"]
    assert folds.coexist[0].tolist() == [False, True, True, True, False, False]
    assert folds.at(f=12.2, Nd=0.1) == {"rest": "period 2", "up": "period 1", "down": "period 2"}


def test_responses_of_one_period_are_distinguished():
    # Duffing's fold: at W = 1.2 two responses of period 1 are stable.
    duffing = sf.built_in_models()["duffing"]()
    found = sf.regimes(duffing, {"F": (0.1, 0.2), "W": (1.0, 1.4)}, points=(2, 5))
    column = found.coexist[1]
    assert set(found.names("up").ravel()) == {"period 1"}
    assert not column[0]
    assert column.any()
    texts = [text.get_text() for text in found.plot().get_legend().get_texts()]
    assert texts == ["period 1", "coexisting, of the same kind"]


def test_motions_of_one_cell_are_continued_to_all_beside_it():
    # The response of period 2 begins at an LP, by continuation at 0.1440 N at 11.55 Hz. Sweeps at
    # 11.55 Hz stay on period 1, but motions from rest settle on period 2 at the upper end.
    span = {"f": (11.55, 11.56), "Nd": (0.11, 0.47)}
    found = sf.regimes(OSCILLATOR, span, points=(2, 10), transient=300)
    assert set(found.names("up").ravel()) == set(found.names("down").ravel()) == {"period 1"}
    assert found.runs == ("rest", "up", "down", "continued 1")
    both = found.over["Nd"] > 0.144
    assert found.coexist.tolist() == [both.tolist()] * 2
    told = found.at(f=11.55, Nd=0.15)
    assert told == {"rest": "period 1", "up": "period 1", "down": "period 1",
                    "continued 1": "period 2"}  # fmt: skip
    cell = found.to_xarray().sel(f=11.55, Nd=0.15)
    assert cell.kind.values.tolist() == ["periodic"] * 4
    assert bool(cell.coexist)


def test_responses_that_only_neighbors_lead_to_repeat_under_another_integrator():
    # Ueda's oscillator: from rest each cell of this plane has one motion.
    ueda = sf.System(
        name="ueda",
        parameters={"B": 9.0, "k": 0.1},
        states={"x": "v", "v": "B*cos(t) - k*v - x^3"},
        forcing={"period": "2*pi"},
    )
    found = sf.regimes(ueda, {"B": (8.5, 9.5), "k": (0.06, 0.12)}, points=(3, 2), transient=200)
    further = np.argwhere(found.kinds[3:] == "periodic")
    assert len(further)
    for further_run, first, second in further:
        place = further_run + 3, first, second
        B, k = found.over["B"][first], found.over["k"][second]
        motion = solve_ivp(
            lambda t, y, B=B, k=k: [y[1], B * np.cos(t) - k * y[1] - y[0] ** 3],
            (0, 2 * np.pi * found.periods[place]),
            found.states[place], method="DOP853", rtol=1e-10, atol=1e-10,
        )  # fmt: skip
        assert motion.y[:, -1] == pytest.approx(found.states[place], abs=1e-5)
        others = found.states[:3, first, second]
        assert np.abs(others - found.states[place]).max(axis=1).min() > 1e-2


def test_the_mean_of_angles_on_both_sides_of_a_half_turn_lies_between_them():
    # Doubled by its forcing, a pendulum about a = pi goes as far to either side, by less than half
    # a turn in all: else the shorter way from one state to the other would be round the back.
    pendulum = sf.System(
        name="pendulum",
        parameters={"F": 0.6, "W": 2.0},
        states={"a": {"rate": "v", "angle": True, "start": 3},
                "v": "sin(a)*(1 + F*cos(W*t)) - 0.1*v"},
        forcing={"period": "2*pi/W"},
    )  # fmt: skip
    found = sf.regimes(pendulum, {"F": (0.25, 0.3), "W": (1.98, 2.0)}, points=(2, 2))
    assert set(found.periods.ravel().tolist()) == {2}
    sideways = np.pi - np.abs(found.states[..., 0])
    assert sideways.min() > 0.1
    assert sideways.max() < 1.4
    assert np.abs(found.means[..., 0] % (2 * np.pi) - np.pi).max() < 1e-3


def test_an_angle_and_the_same_a_whole_turn_on_do_not_coexist():
    # The pendulum stands on its head: motions settle about pi or -pi, as they happen to come there.
    head = sf.System(
        name="head",
        parameters={"F": 0.1, "W": 1.3},
        states={"a": {"rate": "v", "angle": True, "start": 3}, "v": "sin(a) - 0.5*v + F*cos(W*t)"},
        forcing={"period": "2*pi/W"},
    )
    found = sf.regimes(head, {"F": (0.1, 0.2), "W": (1.3, 1.4)}, points=(2, 2), transient=100)
    assert (found.names("up") == "period 1").all()
    assert not found.coexist.any()
    turn = np.zeros_like(found.means)
    turn[1, :, :, 0] = 2 * np.pi
    assert not replace(found, means=found.means - turn).coexist.any()
    assert replace(found, means=found.means - turn / 2).coexist.all()


def test_wells_of_a_pendulum_that_is_no_declared_angle_are_no_new_responses():
    pendulum = sf.System(
        parameters={"g": 1.2, "W": 2 / 3},
        states={"a": "v", "v": "-sin(a) - 0.5*v + g*cos(W*t)"},
        forcing={"period": "2*pi/W"},
    )

    def end(progress):
        if progress.done > 60_000:  # each well led to the next, without end
            raise KeyboardInterrupt

    vary = {"g": (1.0, 1.12), "W": (0.64, 2 / 3)}
    found = sf.regimes(pendulum, vary, points=(2, 4), on_progress=end)
    assert not found.interrupted
    # Those of period 1 coexist unless they are whole turns apart.
    angles = found.states[:3, 0, :, 0] / (2 * np.pi)
    apart = np.abs(angles - np.roll(angles, 1, axis=0))
    assert (found.names("rest")[0] == "period 1").all()
    assert (found.coexist[0] == (np.abs(apart - np.round(apart)) > 1e-2).any(axis=0)).all()


def test_motions_that_stick_or_stop_say_so():
    found = sf.regimes(
        sf.SlidingOscillator(f=12.5), {"Vd": (0.05, 0.6), "Nd": (0.0, 0.3)}, points=(2, 2),
        transient=64,
    )  # fmt: skip
    assert found.names("rest")[0].tolist() == ["period 1", "sticks"]
    assert "sticks" in found.summary()
    # It was followed no further, so that nothing is known of its period.
    assert found.periods[0, 0].tolist() == [1, 0]
    found = sf.regimes(FLOOR, {"W": (2.0, 2.5), "F": (1.0, 4.0)}, points=(2, 2), transient=100)
    assert found.names("up").tolist() == [["period 1", "stopped"]] * 2
    assert np.isnan(found.states[1, :, 1]).all()


def test_a_slow_way_to_a_response_is_no_torus():
    # A weakly damped oscillator winds in for thousands of periods, and 5 and 7 turns do not close.
    dampings = np.array([2e-3, 4e-4, 1e-4, 1e-5, 0.0])
    models = models_with(WEAK, 5, {"c": dampings})
    told, _ = classify_open(models, np.tile([1.0, 0.0], (5, 1)))
    # The fourth would need some ten thousand periods to be seen to come nearer; none is damped less
    # than the last.
    assert told.kinds.tolist() == [*["periodic"] * 3, "undecided", "torus"]
    assert told.periods.tolist() == [1, 1, 1, 0, 0]
    assert told.exponents == pytest.approx(-dampings / 2, abs=1e-7)


def test_an_interrupt_keeps_open_motions_that_are_judged():
    # One of two comes to its response within the first thousand periods, the other one not.
    judged = []

    def stop(progress):
        # Total periods of all motions grow once for the open ones, then for those still open.
        if progress.total not in judged:
            judged.append(progress.total)
        if len(judged) == 3:
            raise KeyboardInterrupt

    found = sf.regimes(
        WEAK, {"w": (2.3, 2.31), "c": (1e-5, 2e-3)}, points=(2, 2), state={"x": 1.0},
        transient=50, on_progress=stop,
    )  # fmt: skip
    assert found.interrupted
    assert found.names("rest").tolist() == [["not done", "period 1"]] * 2
    assert np.isnan(found.exponents[0, :, 0]).all()
    assert found.exponents[0, :, 1] == pytest.approx(-1e-3, abs=1e-7)


def test_motions_beside_a_period_doubling_have_its_periods():
    # One line is just below the PD, whose multiplier is -0.9974, the other just above it: a
    # doubled response fades there for thousands of periods, and a single one is left as slowly.
    found = sf.regimes(
        OSCILLATOR, {"f": (13.125, 13.15), "Nd": (0.2333333, 0.24166665)}, points=(2, 2)
    )
    for start in found.runs[:3]:
        assert found.names(start).tolist() == [["period 1", "period 2"]] * 2
    assert not found.coexist.any()


def test_a_map_is_drawn_with_its_hatches(folds):
    from matplotlib.colors import to_hex
    from matplotlib.figure import Figure

    ax = folds.plot(run="up", ax=Figure().subplots())
    hatches = [patch for patch in ax.patches if patch.get_hatch()]
    assert [to_hex(patch.get_edgecolor()) for patch in hatches] == [COLORS["period 2"]]
    texts = [text.get_text() for text in ax.get_legend().get_texts()]
    assert texts == ["period 1", "period 2", "coexisting, in the other's color"]


def test_an_interrupt_keeps_what_is_known():
    def stop(progress):
        if progress.done >= 4 * 360:
            raise KeyboardInterrupt

    found = sf.regimes(
        OSCILLATOR, {"f": (12.2, 12.3), "Nd": (0.0, 0.02)}, points=(2, 2), transient=300,
        on_progress=stop,
    )  # fmt: skip
    assert found.interrupted
    assert (found.names("rest") == "period 1").all()
    assert (found.names("down") == "not done").all()


@pytest.mark.parametrize(
    ("vary", "options", "message"),
    [
        ({"f": (12, 13)}, {}, "does not name two parameters"),
        (["f", "Nd"], {}, r"\['f', 'Nd'\] does not name two parameters with their spans; give"),
        ({"f": (12, 12), "Nd": (0, 0.1)}, {}, "span of f from 12 to 12 is empty; give two"),
        ({"f": (12, 13), "Nd": (0, 0.1)}, {"points": (1, 5)}, "points = 1 is not a whole"),
        ({"f": (12, 13), "Nd": (0, 0.1)}, {"Nd": 0.1}, "Nd is varied"),
        ({"f": (12, 13), "Nd": (0, 2)}, {}, "give Nd < Ns"),
    ],
)
def test_wrong_input_is_one_sentence(vary, options, message):
    with pytest.raises(InputError, match=message):
        sf.regimes(OSCILLATOR, vary, **options)
