"""Attractors of systems with known coexistence: all are found, none is invented."""

import numpy as np
import pytest

import slipfold as sf
from slipfold.flow.equilibrium import with_duration
from slipfold.long_term.attractor import preserves_volume
from slipfold.long_term.search import checked_box
from slipfold.long_term.verified import AttractorSet

MODELS = sf.built_in_models()

WHOLE_BOX = {"x": (-0.5, 0.5), "y": (-0.5, 0.5), "vx": (-20, 20), "vy": (-20, 20)}


def kinds(found):
    """Return what was found, in an order that does not hang on starts."""
    return sorted((item.kind, item.period or 0) for item in found)


def system(text):
    return sf.System.from_toml(text)


FORCED_WELL = """
name = "forced double well"
parameters = { W = 1.0, F = 0.05 }
forcing = { period = "2*pi/W", amplitude = "F" }
[states]
x = "v"
v = "x - x^3 - 0.2*v + F*cos(W*t)"
"""

PENDULUM = """
name = "pendulum"
parameters = { W = 0.67, F = 1.3 }
forcing = { period = "2*pi/W" }
[states]
a = { rate = "v", angle = true }
v = "-sin(a) - 0.5*v + F*cos(W*t)"
"""

# Stuart and Landau's amplitude with r' = r (r^2 - 1) (2 - r^2) - rest and a cycle of radius
# sqrt(2) attract, one of radius 1 does not.
HARD = """
name = "hard onset"
parameters = { w = 1.0 }
[states]
x = "(x^2 + y^2 - 1)*(2 - x^2 - y^2)*x - w*y"
y = "(x^2 + y^2 - 1)*(2 - x^2 - y^2)*y + w*x"
"""


def test_motions_that_are_much_faster_where_they_start_arrive():
    (cycle,) = sf.attractors(system(HARD), {"x": (20, 30)}, starts=1)
    assert (cycle.kind, cycle.duration) == ("cycle", pytest.approx(2 * np.pi))


# -- those of the sliding oscillator -------------------------------------------------------------


def test_both_responses_at_12_2_hz_with_their_shares():
    found = sf.attractors(sf.SlidingOscillator(f=12.2, Nd=0.1), WHOLE_BOX, starts=96)
    assert kinds(found) == [("periodic", 1), ("periodic", 2)]
    (double,) = (item for item in found if item.period == 2)
    fraction = found.fraction(double)
    # shared/reference/beyond.md: 0.712 +- 0.010 of starts uniform in this box.
    assert fraction.low <= 0.712 <= fraction.high
    assert fraction.value == pytest.approx(0.712, abs=0.07)
    orbit = sf.periodic_orbit(found.model, 2, double.state)
    assert double.multipliers == pytest.approx(orbit.multipliers, abs=1e-8)
    assert found.fraction(0).value == 0


@pytest.mark.long
def test_every_start_is_where_a_long_motion_ends():
    found = sf.attractors(sf.SlidingOscillator(f=12.2, Nd=0.1), WHOLE_BOX, starts=4096)
    assert kinds(found) == [("periodic", 1), ("periodic", 2)]
    (double,) = (item for item in found if item.period == 2)
    # shared/reference/beyond.md, 0.712 with a standard error of 0.010: within three of them.
    assert found.fraction(double).value == pytest.approx(0.712, abs=0.03)
    for state, label in zip(found.starts[:200], found.labels[:200], strict=True):
        motion = sf.simulate(found.model, 600, state)  # by Taylor's method, to 1e-13
        assert motion.settlement.period == found[label - 1].period


def test_a_torus_is_identified_by_its_exponents_once():
    found = sf.attractors(sf.SlidingOscillator(f=12.5, Nd=0.06), WHOLE_BOX, starts=2, periods=128)
    assert kinds(found) == [("torus", 0)]
    # shared/reference/beyond.md, over 2000 periods here.
    assert found[0].exponents == pytest.approx([0, -0.0050116, -0.1170780, -0.2697660], abs=2e-4)
    assert found.fraction(1).value == 1


def test_motions_that_stick_come_to_the_orbit_that_sticks():
    found = sf.attractors(sf.SlidingOscillator(f=12.5, Nd=0.3, Vd=0.05), {"y": (0, 0.2)}, starts=4)
    assert kinds(found) == [("periodic", 1)]
    # shared/reference/beyond.md.
    assert found[0].maximum[0] == pytest.approx(0.1900998927, abs=1e-8)
    assert found.fraction(1).value == 1


# -- those of textbooks --------------------------------------------------------------------------


def test_both_responses_of_duffing_between_its_folds():
    box = {"q": (-4, 4), "v": (-4, 4)}
    found = sf.attractors(MODELS["duffing"](W=1.2), box, starts=32)
    diagram = sf.response(MODELS["duffing"](), vary="W", span=(1.0, 1.2))
    resonant = diagram.branches[0]
    assert kinds(found) == [("periodic", 1)] * 2
    largest = max(found, key=lambda item: item.maximum[0])
    assert largest.maximum[0] == pytest.approx(resonant.extrema.maximum[-1, 0], rel=1e-8)
    assert [item.id for item in sf.attractors(MODELS["duffing"](W=1.4), box, starts=16)] == [1]


def test_a_forced_double_well_has_a_response_in_each():
    found = sf.attractors(system(FORCED_WELL), {"x": (-2, 2), "v": (-2, 2)}, starts=32)
    left, right = sorted(found, key=lambda item: item.state[0])
    # By x -> -x half a period later.
    assert left.minimum[0] == pytest.approx(-right.maximum[0], abs=1e-9)
    assert kinds(found) == [("periodic", 1)] * 2


def test_a_forced_pendulum_turns_round_either_way():
    found = sf.attractors(system(PENDULUM), {"a": (-3, 3), "v": (-3, 3)}, starts=32)
    assert kinds(found) == [("periodic", 1)] * 2
    orbits = [sf.periodic_orbit(found.model, state=item.state) for item in found]
    assert sorted(orbit.revolutions["a"] for orbit in orbits) == [-1, 1]
    # By a -> -a half a period later.
    assert found[0].multipliers == pytest.approx(found[1].multipliers, abs=1e-8)
    assert np.all(found.labels > 0)


def test_a_cycle_that_motions_come_to_in_a_spiral():
    found = sf.attractors(MODELS["squeal"](), starts=4)
    assert kinds(found) == [("cycle", 0)]
    assert found.fraction(1).value == 1


def test_motions_that_end_are_counted_and_no_attractor():
    found = sf.attractors(MODELS["stribeck"](), {"x": (-3, 3), "v": (-3, 1)}, starts=16)
    assert kinds(found) == [("equilibrium", 0)]
    assert found.ends == {"stick": int((found.labels == -1).sum())}
    assert 0 < found.fraction(-1).value < 1
    assert "ended: stick" in found.summary()
    held = sf.attractors(sf.SlidingOscillator(Vd=0), starts=4)  # it may rest anywhere in a range
    assert (len(held), held.ends) == (0, {"held by friction": 4})


@pytest.mark.long
def test_chaos_and_both_states_of_rest_of_lorenz():
    # They coexist for 24.06 < rho < 24.74: Sparrow, The Lorenz Equations (1982).
    found = sf.attractors(MODELS["lorenz"](rho=24.3), starts=32)
    assert kinds(found) == [("chaos", 0), ("equilibrium", 0), ("equilibrium", 0)]
    assert np.all(found.labels > 0)


@pytest.mark.parametrize("force", [0.0, 0.3])
def test_where_volumes_are_preserved_nothing_attracts_and_it_is_said(force):
    model = sf.built_in_models()["duffing"](d=0, F=force)
    found = sf.attractors(model, {"q": (-1, 1), "v": (-1, 1)}, starts=4, periods=64)
    assert (len(found), found.labels.tolist()) == (0, [0] * 4)
    assert "4 undecided; the model preserves volumes of states, so nothing attracts" in str(
        found.summary()
    )


def test_damping_that_acts_only_elsewhere_is_seen():
    away = "c*v*(1/(1 + exp(50*(3 - x))) + 1/(1 + exp(50*(3 + x))))"
    text = FORCED_WELL.replace("F = 0.05", "F = 0.3, c = 2").replace("0.2*v", away)
    model = system(text)
    assert not preserves_volume(model)
    assert preserves_volume(model.replace(c=0))


def test_chaos_that_preserves_volumes_attracts_nothing_though_formulas_hide_it():
    # The terms x*v and v^2/2 of a Hamiltonian cancel in the divergence.
    text = FORCED_WELL.replace("0.05", "0.1").replace('"v"', '"v + 0.1*x*v"')
    model = system(text.replace("0.2*v", "0.05*v^2"))
    assert AttractorSet(model).classified(np.array([0.3, 0.2]), False) is None


def test_intervals_suit_states_that_stick():
    # Stribeck's law has no slope where the slip is zero, so that a second was taken.
    law = {"law": "Stribeck", "mu_s": 0.6, "mu_k": 0.3, "vs": 0.1}
    contact = {"slip": "V - v", "normal": "N", "friction": law}
    states, values = {"x": "v", "v": "F - k*x"}, {"V": 0.1, "k": 1e6, "N": 100.0}
    model = sf.System(parameters=values, states=states, contacts={"F": contact})
    sticks, slips = (with_duration(model, np.array([0.0, v]), None)[0] for v in (0.1, 0.09))
    assert sticks.values["duration"] == slips.values["duration"] < 0.01


def test_rest_and_a_cycle_that_coexist():
    found = sf.attractors(system(HARD), {"x": (-2, 2), "y": (-2, 2)}, starts=48)
    assert kinds(found) == [("cycle", 0), ("equilibrium", 0)]
    cycle, rest = sorted(found, key=lambda item: item.kind)
    assert cycle.maximum[:2] == pytest.approx([np.sqrt(2)] * 2, abs=1e-9)
    assert cycle.duration == pytest.approx(2 * np.pi, abs=1e-9)
    # Those inside the unstable cycle, of radius 1, come to rest.
    inside = np.linalg.norm(found.starts, axis=1) < 1
    assert np.array_equal(found.labels == rest.id, inside)
    assert np.array_equal(found.labels == cycle.id, ~inside)


# -- starts, bad input, files --------------------------------------------------------------------


def test_starts_are_the_same_every_time_and_spread_evenly():
    model = sf.SlidingOscillator()
    box = checked_box(model, {"x": (-1, 1), "vy": ("-20", "20")})
    starts = box.starts(64, 3)
    assert np.array_equal(starts, box.starts(64, 3))
    assert not np.array_equal(starts, box.starts(64, 4))
    assert np.all(starts[:, 1:3] == 0)
    for column, width in ((0, 2), (3, 40)):
        counts = np.histogram(starts[:, column], 8, (-width / 2, width / 2))[0]
        assert counts.tolist() == [8] * 8


def test_an_interrupt_keeps_what_was_found():
    def stop(progress):
        if progress.values["found"]:
            raise KeyboardInterrupt

    box = {"q": (-4, 4), "v": (-4, 4)}
    found = sf.attractors(MODELS["duffing"](W=1.2), box, starts=8, on_progress=stop)
    assert found.interrupted
    assert len(found) == 1
    assert (found.labels == -2).any()
    assert "interrupted" in found.summary()


@pytest.mark.parametrize("coupling", [pytest.param(0.0, marks=pytest.mark.long), 0.2])
def test_a_cycle_beside_a_contact_that_rests_anywhere_is_one(coupling):
    tip = {"slip": "-v", "normal": "0.6", "friction": sf.Coulomb(mu_k=1.0)}
    rates = {"y": "x", "x": "d*x*(1 - y^2) - y + c*q", "q": "v", "v": "c*y - q + tip"}
    given = {"parameters": {"c": coupling, "d": 1.0}, "contacts": {"tip": tip}}
    model = sf.System(states=rates, **given)
    (cycle,) = found = sf.attractors(model, starts=8)
    assert (found.labels == 1).all()
    motion = sf.simulate(model, 200, {"y": 1.0}).settlement
    # q rests at zero, in the middle, in both: this is the cycle without what rests
    assert [cycle.duration, motion.duration] == pytest.approx([6.663286859323] * 2, rel=1e-8)
    center = sf.simulate(model, 200, {"y": 1.0}, d=0.0).settlement
    assert center.neutral_round == pytest.approx(2 * np.pi, rel=1e-8)


def test_orbits_need_a_parameter_and_equilibria_none():
    tip = {"tip": {"slip": "-x", "normal": "0.3", "friction": sf.Coulomb(mu_k=1.0)}}
    for rate, contacts in (("cos(t) - x", None), ("cos(t) - x + tip", tip)):
        given = {"contacts": contacts, "forcing": {"period": "2*pi"}}
        with pytest.raises(sf.InputError, match="has no parameter; give it one"):
            sf.attractors(sf.System(states={"x": rate}, **given), starts=4)
    slow = sf.System(states={"x": "v", "v": "x - x^3 - 0.01*v"})
    assert len(sf.attractors(slow, starts=16).attractors) == 2
    free = sf.System(states={"y": "x", "x": "(1 - y^2)*x - y"})
    assert "2 undecided; system has no parameter; give" in sf.attractors(free, starts=2).summary()
