"""STICK, LIFT and MEET on branches, where closed forms place them, from both sides and passed."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq, fsolve

import slipfold as sf
from helpers.dry_friction import belt, den_hartog, most_load, shaken_across
from slipfold.results.checks.switched import switched_difference

SINGLE = sf.Settings(largest_period=1)
MU = 0.2


def rarely(*values):
    return pytest.param(*values, marks=pytest.mark.long)


def named(model, vary, span):
    """The one point on a branch from an orbit, which is passed."""
    orbit = sf.periodic_orbit(model)
    (branch,) = sf.response(orbit, vary=vary, span=span, settings=SINGLE).branches
    assert branch.stopped.kind == "span"
    (point,) = branch.special
    return point, branch


def shaken(frequency, stiffness=None, damping=None, **loads):
    """Masses on a floor, forced alike: x'' + x = cos(W t) - MU Ns sgn x'."""
    law = sf.Coulomb(mu_s=MU, mu_k=MU)
    contacts = [
        sf.FrictionContact(name, law, load=load, Vd=0.0, name=name) for name, load in loads.items()
    ]
    return sf.Structure(
        np.eye(len(loads)),
        damping,
        np.eye(len(loads)) if stiffness is None else stiffness,
        names=list(loads),
        contacts=contacts,
        forcing=sf.HarmonicForce(dict.fromkeys(loads, 1.0), F=1.0),
        f=frequency / (2 * math.pi),
    )


@pytest.mark.parametrize("frequency", [0.6, rarely(0.8)])
def test_turns_of_den_hartogs_orbit_begin_to_stick(frequency):
    # Its largest friction without stops; the supremum in it is a limit.
    most = most_load(frequency / (2 * math.pi), MU)
    for span in ((1.05 * most, 0.95 * most), (0.95 * most, 1.05 * most)):
        point, branch = named(shaken(frequency, x=span[0]), "Ns_x", span)
        assert point.type == "STICK"
        assert point.value == pytest.approx(most, abs=point.uncertainty)
        assert point.uncertainty < 1e-11
        sticks = branch.stuck_fraction > 1e-9
        assert (sticks == (branch.parameter > most + 1e-9)).all()


def test_a_response_on_a_floor_begins_where_a_motion_settles():
    # A friction damper: what a given orbit leads to, without one, from either end or between.
    model = shaken(0.8, x=3.5)
    (given,) = sf.response(sf.periodic_orbit(model), "Ns_x", (3.5, 4.5), settings=SINGLE).branches
    (found,) = sf.response(model, "Ns_x", (3.5, 4.5), settings=SINGLE).branches
    assert [item.type for item in found.special] == ["STICK"]
    start = {"start": {"Ns_x": 4.0}, "settings": SINGLE}
    (between,) = sf.response(model, "Ns_x", (3.5, 4.5), **start).branches
    for point in (found.special[0], between.special[0]):
        known = point.uncertainty + given.special[0].uncertainty
        assert point.value == pytest.approx(given.special[0].value, abs=known)
        assert known < 1e-8
    for span in ((5.3, 4.8), (4.8, 5.3)):  # more than 1 / MU holds it all the time
        (branch,) = sf.response(model, "Ns_x", span, settings=SINGLE).branches
        (point,) = branch.special
        assert (point.type, branch.stopped.kind) == ("GRAZE", "span")
        assert point.value == pytest.approx(1 / MU, abs=point.uncertainty)
        assert point.uncertainty < 1e-8
        beyond, sticks = branch.parameter - 1 / MU, branch.stuck_fraction > 1 - 1e-6
        assert (sticks == (beyond > 0))[np.abs(beyond) > 1e-4].all()
    seen = sf.measure(model, "f", [0.127, 0.13], ["max x"])
    with pytest.raises(sf.InputError, match=r"span of f begins.*tanh\(v/e\)"):
        sf.fit(model, seen, {"Ns_x": (3.0, 4.0)})


def test_a_mass_that_friction_holds_all_the_time_is_a_fixed_one():
    stiffness = np.array([[1.4, -0.4], [-0.4, 1.4]])
    two, one = shaken(0.8, stiffness, x=2.5, y=12.0), shaken(0.8, stiffness[:1, :1], x=2.5)
    orbit, fixed = sf.periodic_orbit(two), sf.periodic_orbit(one)
    assert orbit.nodes[:, ::2] == pytest.approx(fixed.nodes, abs=1e-9)
    assert orbit.nodes[:, 1::2] == pytest.approx(0, abs=1e-9)
    assert orbit.multipliers[:2] == pytest.approx(fixed.multipliers, abs=1e-9)
    assert orbit.multipliers[2:] == pytest.approx(0, abs=1e-12)
    (branch,) = sf.response(two, "Ns_y", (12.0, 5.0), settings=SINGLE).branches
    pulls = 0.4 * fixed.sample(4096)[1][:, 0] + np.cos(2 * np.pi * np.arange(4096) / 4096)
    assert (branch.special[0].type, branch.stopped.kind) == ("GRAZE", "span")
    assert branch.special[0].value == pytest.approx(np.abs(pulls).max() / MU, abs=1e-5)
    found = sf.attractors(two, starts=8)  # wherever y comes to rest
    assert (len(found.attractors), found.labels.tolist()) == (1, [1] * 8)


@pytest.mark.parametrize(
    ("damping", "rests", "stick", "settled"),
    [
        (0.05, "y", "y sticks", True),
        (-0.05, "y", "y sticks", False),
        (0.05, "yz", "y, z stick", True),
    ],
)
def test_masses_rest_beside_one_that_slides_steadily(damping, rests, stick, settled):
    contacts = [
        sf.FrictionContact(at, sf.Coulomb(mu_k=MU), load=12.0, Vd=0.0, name=at) for at in rests
    ]
    contacts.append(sf.FrictionContact("x", sf.Coulomb(mu_k=MU), load=1.0, Vd=0.3, name="tip"))
    size = len(contacts)
    stiffness, damped = 1.5 * np.eye(size) - 0.1, np.diag([damping, 0.05, 0.05][:size])
    given = {"names": ("x", *rests), "contacts": contacts}
    model = sf.Structure(np.eye(size), damped, stiffness, **given)
    end = sf.simulate(model, state={"x": MU / 1.4}, periods=20).settlement
    assert (end.settled, end.kind == "equilibrium") == (settled, settled)
    assert end.message.endswith(f"equilibrium in which {stick}")


@pytest.mark.parametrize("stiffness", [None, 1.0, 3.7, 1e4])
def test_nothing_or_a_free_body_is_at_rest_beside_a_stuck_contact(stiffness):
    free = {"a": "va", "b": "vb", "va": f"{stiffness}*(b - a)", "vb": f"{stiffness}/3*(a - b)"}
    contacts = {"tip": {"slip": "-v", "normal": "1.0", "friction": sf.Coulomb(mu_k=0.5)}}
    states = {"v": "tip - p*v", **(free if stiffness else {})}
    model = sf.System(parameters={"p": 0.1}, states=states, contacts=contacts)
    end = sf.simulate(model, state=[1.0, *[0.2, 0.2, 0.0, 0.0][: len(states) - 1]], periods=20)
    assert end.settlement.kind == "equilibrium"


@pytest.mark.parametrize(("load", "damping"), [(8.0, 0.05), rarely(6.5, 0.05), rarely(9.0, 0.02)])
def test_a_mass_rests_in_the_middle_wherever_the_phase_begins(load, damping):
    # Only x is forced, so y rests at zero until the spring's pull is all that friction can be.
    contact = sf.FrictionContact("y", sf.Coulomb(mu_k=MU), load=load, Vd=0.0)
    force, stiffness = sf.HarmonicForce("x", F=1.0), np.array([[1.4, -0.4], [-0.4, 1.4]])
    given = {"names": ("x", "y"), "contacts": (contact,), "forcing": force}
    model = sf.Structure(np.eye(2), damping * np.eye(2), stiffness, **given)
    rate = brentq(lambda w: math.hypot(1.4 - w * w, damping * w) - 0.4 / (MU * load), 0.5, 1.15)
    start = model.replace(f=0.05, phi=1.0)
    (branch,) = sf.response(start, "f", (0.05, 0.175), settings=SINGLE).branches
    (point,) = branch.special
    assert (point.type, branch.stopped.kind) == ("GRAZE", "span")
    assert point.value == pytest.approx(rate / (2 * math.pi), abs=1e-11)
    sticks = branch.parameter < point.value
    assert branch.nodes[sticks, 0, 1] == pytest.approx(0, abs=1e-11)
    orbit = sf.periodic_orbit(start)
    assert switched_difference(orbit).excess < 1
    beside = replace(orbit, nodes=orbit.nodes + 1e-7 * np.array([0, 1, 0, 0]))
    assert switched_difference(beside).excess > 1


@pytest.mark.long
def test_turns_on_a_floor_begin_to_stick_along_a_locus():
    # Den Hartog's largest friction without stops, over load and frequency, from the model alone.
    model = shaken(0.8, x=3.5)
    plane, window = ("Ns_x", "f"), ((3.3, 3.9), (0.11, 0.125))
    (locus,) = sf.locus(model, plane, window, type="STICK").loci
    load, frequency = locus.values.T
    assert load == pytest.approx(most_load(frequency, MU), abs=1e-9)
    assert {locus.started.kind, locus.stopped.kind} == {"window"}
    found = sf.bifurcation_set(model, plane, window)
    assert [item.type for item in found.loci] == ["STICK"]
    assert "Vd_x must be > 0" in found.summary()  # there are no regions, and why


@pytest.mark.parametrize(
    "span", [(0.14, 0.05), (0.115, 0.13), rarely((0.05, 0.14)), rarely((0.13, 0.115))]
)
def test_longest_steps_find_where_turns_begin_to_stick_too(span):
    # The closed form above, over the frequency: the load is the largest without stops there.
    load, settings = 4.0, sf.Settings(largest_period=1, steps=sf.Steps(largest=1.0))
    most = brentq(lambda frequency: most_load(frequency, MU) - load, 0.11, 0.14, xtol=1e-15)
    orbit = sf.periodic_orbit(shaken(2 * math.pi * span[0], x=load))
    (branch,) = sf.response(orbit, vary="f", span=span, settings=settings).branches
    (point,) = branch.special
    assert (point.type, branch.stopped.kind) == ("STICK", "span")
    assert point.value == pytest.approx(most, abs=1e-10)


@pytest.mark.parametrize("friction", [rarely(0.1), 0.2])
def test_stops_that_vanish_are_passed_in_both_directions(friction):
    # The first orbit beyond lies on in the frequency, but back in the velocity.
    found = []
    for span in ((0.055, 0.09), (0.09, 0.055)):
        law = sf.Coulomb(mu_s=friction, mu_k=friction)
        model = belt(law, 0.0, 0.1, force=1.0, f=span[0])
        orbit = sf.periodic_orbit(model)
        (branch,) = sf.response(orbit, vary="f", span=span, settings=SINGLE).branches
        assert branch.stopped.kind == "span"
        found.append(branch.special)
    there, back = found[0], found[1][::-1]
    assert [point.type for point in there] == ["MEET", "GRAZE"]
    assert [point.type for point in back] == ["MEET", "GRAZE"]
    for one, other in zip(there, back, strict=True):
        # The wider of the two brackets in which it was found
        assert abs(one.value - other.value) <= one.uncertainty + other.uncertainty


@pytest.mark.long
@pytest.mark.parametrize("span", [(0.055, 0.09), (0.09, 0.055)])
@pytest.mark.parametrize(("friction", "phase"), [(0.2, 0.04), (0.3, 0.01)])
def test_both_halves_of_an_orbit_change_at_one_place(friction, phase, span):
    # Without damping the orbit there is neutral to what parts its halves.
    def missed(unknown):
        """It is released, stops in the mirrored place, and there would be released at once."""
        place, begin, end, rate = unknown
        gain = 1 / (1 - rate**2)
        forced = [friction + gain * math.cos(rate * time) for time in (begin, end)]
        speeds = [-gain * rate * math.sin(rate * time) for time in (begin, end)]
        free = (place - forced[0] - 1j * speeds[0]) * np.exp(1j * (begin - end))
        x, v = free.real + forced[1], free.imag + speeds[1]
        pulls = math.cos(rate * begin) - place, math.cos(rate * end) - x
        return pulls[0] + friction, pulls[1] - friction, x + place, v

    orbit = sf.periodic_orbit(den_hartog(2 * math.pi * span[0], friction))
    (branch,) = sf.response(orbit, vary="f", span=span, settings=SINGLE).branches
    (point,) = [item for item in branch.special if item.type == "MEET"]
    period = 1 / point.value
    guess = (
        math.cos(2 * math.pi * phase) + friction,
        phase * period,
        (0.5 - phase) * period,
        2 * math.pi / period,
    )
    rate = fsolve(missed, guess, xtol=1e-13)[3]
    assert abs(point.value - rate / (2 * math.pi)) <= point.uncertainty < 1e-11


@pytest.mark.parametrize("span", [(0.05, 0.09), rarely((0.09, 0.06))])
def test_orbits_that_static_friction_only_just_holds_end_there(span):
    # More than kinetic, it holds the mass at a stop, or lets it slip back at once, for good.
    model = den_hartog(0.5, 0.3, 0.35).replace(f=span[0])
    orbit = sf.periodic_orbit(model)
    *_, branch = sf.response(orbit, vary="f", span=span, settings=SINGLE).branches
    ends = [end for end in (branch.started, branch.stopped) if end.kind == "failed"]
    assert ends
    points = [item for item in branch.special if item.value in [end.value for end in ends]]
    for point in points:
        assert point.type == "STICK"
        assert point.uncertainty < 1e-12
        settled = sf.simulate(point.model, 2, point.nodes[0])
        places = settled.at(
            np.array([item.end / point.value for item in settled.sticking.intervals])
        )
        phases = np.array([item.end for item in settled.sticking.intervals])
        pulls = np.abs(np.cos(2 * math.pi * phases) - places[:, 0])
        assert np.abs(pulls[np.abs(places[:, 1]) < 1e-9] - 0.35).min() < 1e-8


@pytest.mark.parametrize("span", [(0.14, 0.2), rarely((0.18, 0.14))])
def test_without_damping_the_orbit_runs_away_at_resonance(span):
    # Friction below pi/4 of the force takes less than the force puts in.
    orbit = sf.periodic_orbit(den_hartog(0.5, 0.3, 0.35).replace(f=span[0]))
    (branch,) = sf.response(orbit, vary="f", span=span, settings=SINGLE).branches
    assert branch.stopped.kind == "unresolved"
    assert branch.stopped.value == pytest.approx(0.5 / math.pi, abs=1e-5)
    assert "the orbit runs away" in branch.stopped.reason


def test_a_mass_shaken_across_its_belt_lifts():
    # It slips along the belt; across, a linear oscillator swings about Ns/(k + kn).
    load, stiffness, damping, rate = 0.5, 4.0, 0.1, 0.4 * math.pi
    swing = load / (stiffness * (1 + stiffness))
    force = swing * math.hypot(1 + stiffness - rate**2, damping * rate)
    for span in ((0.8 * force, 1.2 * force), (1.2 * force, 0.8 * force)):
        frequency = rate / (2 * math.pi)
        model = shaken_across(load, stiffness, damping, force=span[0], frequency=frequency)
        point, _ = named(model, "F", span)
        assert point.type == "LIFT"
        assert point.value == pytest.approx(force, abs=point.uncertainty)
        assert point.uncertainty < 1e-11


def test_a_contact_that_was_open_touches_at_a_lift():
    # The mass swings alone, m = 1, c = 0.2, k = 2, until it comes to the surface at 0.5.
    load, law = sf.ContactLoad("q2", Ns=-0.5, kn=1.0), sf.Coulomb(mu_s=0.3, mu_k=0.3)
    contact = sf.FrictionContact("q1", law, load=load, Vd=5.0)
    given = {"contacts": contact, "forcing": sf.HarmonicForce("q2", F=0.2), "f": 0.2}
    model = sf.Structure(np.eye(2), 0.2 * np.eye(2), np.diag([1.0, 2.0]), **given)
    rate = 0.4 * math.pi
    point, _ = named(model, "F", (0.2, 0.3))
    assert point.type == "LIFT"
    assert point.value == pytest.approx(0.5 * abs(2 - rate**2 + 0.2j * rate), rel=1e-9)


def test_a_bit_lifts_wherever_its_response_begins():
    # A limit ends slip at the change itself, to rounding: on which side the last orbit is, is luck.
    model = sf.System(
        parameters={"W": 10.0},
        states={
            "z": "u", "u": "(9e4 - T_normal - 9e5*z - 8e4*u)/4e4",
            "twist": "w", "w": "(0.1*T - 510*twist - 60*w)/420",
        },
        contacts={"T": {
            "slip": "-0.1*(W + w)", "normal": "9e4 + 6e7*(z + 1e-3*cos(3*W*t))",
            "friction": {"law": "Coulomb", "mu_s": 0.36, "mu_k": 0.3},
        }},
        forcing={"period": "2*pi/(3*W)"},
    )  # fmt: skip
    lift = brentq(lambda W: 9e4 - 6e4 * abs(1 - 6e7 / (6.09e7 + 24e4j * W - 36e4 * W**2)), 8, 12)
    for first in (8.0, 9.0, 9.5):
        ((_, point),) = sf.response(model, "W", (first, 10.2), settings=SINGLE).special
        assert point.type == "LIFT"
        assert point.value == pytest.approx(lift, abs=point.uncertainty)


@pytest.mark.parametrize(("damper", "load"), [rarely(0.0, 2.9), (0.05, 2.93)])
def test_two_masses_alike_stop_at_once(damper, load):
    # They change places where their loads are equal; that matters if a damper couples them.
    C = damper * np.array([[1.0, -1.0], [-1.0, 1.0]])
    for span in ((2.8, 3.0), (3.0, 2.8)):
        model = shaken(0.6, damping=C, x=load, y=span[0])
        (branch,) = sf.response(
            sf.periodic_orbit(model), vary="Ns_y", span=span, settings=SINGLE
        ).branches
        assert [point.type for point in branch.special] == (["MEET"] if damper else [])
        for point in branch.special:
            assert point.value == pytest.approx(load, abs=point.uncertainty)
            assert point.uncertainty < 1e-9
        assert branch.stuck_fraction.min() > 0.04
        assert len(branch) <= 10  # a step that is predicted across a MEET is not taken again


@pytest.mark.parametrize(("f", "mu_s"), [(0.06, 0.5), (0.09, 0.5), (0.2, 0.3)])
def test_masses_alike_have_the_multipliers_of_one(f, mu_s):
    # Nothing couples them; opposite forces make them stop, and slip back, at the same instants.
    found = []
    for forces in ([1.0], [1.0, -1.0]):
        law, size = sf.Coulomb(mu_s=mu_s, mu_k=0.3), len(forces)
        model = sf.Structure(
            np.eye(size), 0.1 * np.eye(size), np.eye(size),
            contacts=[sf.FrictionContact(f"q{i + 1}", law, load=1.0, Vd=0.0) for i in range(size)],
            forcing=[sf.HarmonicForce(f"q{i + 1}", F=F) for i, F in enumerate(forces)], f=f,
        )  # fmt: skip
        found.append(np.poly(sf.periodic_orbit(model).multipliers))
    assert found[1] == pytest.approx(np.polymul(found[0], found[0]), abs=1e-11)
