"""Contacts declared in text equations: the motions are those of structures with such contacts."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm
from scipy.optimize import brentq, fsolve

import slipfold as sf

BELT = """
name = "belt"
[parameters]
Vd = 0.3
mu = 0.4
N = 1.0
[states]
x = "v"
v = "F - x"
[contacts]
F = { slip = "Vd - v", normal = "N", friction = { law = "Coulomb", mu_s = "1.5*mu", mu_k = "mu" } }
"""


def same_motions(text, structure, periods, start):
    """Both follow the same states through the same intervals."""
    one, other = (sf.simulate(model, periods, start) for model in (text, structure))
    assert one.states == pytest.approx(other.states, abs=1e-11)
    ours, theirs = one.sticking.intervals, other.sticking.intervals
    assert [item.state for item in ours] == [item.state for item in theirs]
    for what in ("begin", "end", "work", "heat"):
        found, wanted = ([getattr(item, what) for item in some] for some in (ours, theirs))
        assert found == pytest.approx(wanted, abs=1e-10)
    return {item.state for item in ours}


def test_a_mass_on_a_belt():
    contact = sf.FrictionContact("x", sf.Coulomb(mu_s=0.6, mu_k=0.4), load=1.0, Vd=0.3)
    structure = sf.Structure(np.eye(1), None, np.eye(1), names="x", contacts=contact)
    # The counter-body may be the one that friction drives.
    back = BELT.replace("F - x", "-F - x").replace("Vd - v", "v - Vd")
    texts = BELT, sf.System.from_toml(BELT).to_toml(), back
    for model in map(sf.System.from_toml, texts):
        assert same_motions(model, structure, 40, [1.5, 0.1]) == {"stick", "slip"}


def test_a_plane_with_a_pulsating_force():
    law = sf.Coulomb(mu_s=0.6, mu_k=0.5)
    slip = ["Vd*cos(alpha) - vx", "Vd*sin(alpha) - vy"]
    model = sf.System(
        parameters={"Vd": 0.3, "alpha": 0.7, "Nd": 0.4, "f": 0.15},
        formulas={"N": "1 + Nd*cos(2*pi*f*t)"},
        states={"x": "vx", "y": "vy", "vx": "Fx - 3*x + y", "vy": "(Fy - 2*y + x)/2"},
        contacts={"F": {"slip": slip, "normal": "N", "friction": law}},
        forcing={"period": "1/f"},
    )
    contact = sf.FrictionContact(
        ("x", "y"), law, sf.ModulatedLoad(Ns=1.0, Nd=0.4), Vd=0.3, alpha=0.7
    )
    structure = sf.Structure(
        np.diag([1.0, 2.0]), None, [[3.0, -1.0], [-1.0, 2.0]], names="x y", contacts=contact, f=0.15
    )
    assert same_motions(model, structure, 4, [0.5, 0.3, 0.2, 0.1]) == {"stick", "slip"}


@pytest.mark.parametrize("speed", [0.3, 0.0])  # a belt, a floor
def test_a_contact_that_opens(speed):
    model = sf.System(
        parameters={"f": 0.2},
        states={
            "x": "vx",
            "y": "vy",
            "vx": "F + 0.3*cos(2*pi*f*t) - x - 0.1*vx",
            "vy": "F_normal + 2*cos(2*pi*f*t) - y - 0.1*vy",
        },
        contacts={"F": {"slip": f"{speed} - vx", "normal": "0.5 - 4*y"}},
        forcing={"period": "1/f"},
    )
    load = sf.ContactLoad(normal="y", Ns=0.5, kn=4.0)
    contact = sf.FrictionContact("x", sf.Coulomb(mu_s=0.5, mu_k=0.5), load, Vd=speed)
    forces = [sf.HarmonicForce("y", F=2.0, name="across"), sf.HarmonicForce("x", F=0.3)]
    structure = sf.Structure(
        np.eye(2), 0.1 * np.eye(2), np.eye(2), names="x y", contacts=contact, forcing=forces, f=0.2
    )
    assert same_motions(model, structure, 4, np.zeros(4)) == {"stick", "slip", "free"}


def test_angles_turn_against_friction():
    turned = sf.System(
        parameters={"W": 2.0, "a": 0.5, "R": 0.3},
        states={"phi": {"rate": "w", "angle": True}, "w": "R + 0.2*W - 0.2*w + a*cos(W*t) + F"},
        contacts={"F": {"slip": "-w", "normal": "R", "friction": sf.Coulomb(mu_k=1.0)}},
        forcing={"period": "2*pi/W"},
    )
    motion = sf.simulate(turned, 200, {"w": 2.0})
    assert (motion.settlement.period, motion.settlement.revolutions) == (1, {"phi": 1})
    assert motion.states[-1, 1] == pytest.approx(2.0 + (0.5 / (0.2 + 2.0j)).real, rel=1e-9)


def test_a_clutch_turns_a_pendulum():
    clutch = sf.System(
        parameters={"V": 2.0, "R": 0.9},
        states={"phi": {"rate": "w", "angle": True}, "w": "F - sin(phi)"},
        contacts={"F": {"slip": "V - w", "normal": "R", "friction": sf.Coulomb(mu_k=1.0)}},
    )
    motion = sf.simulate(clutch, state={"w": 2.0})
    assert motion.settlement.revolutions == {"phi": 1}
    begin = math.asin(0.9)  # of slip, until the energy is that of the clutch again, twice a round
    end = brentq(lambda phi: 0.9 * (phi - begin) + math.cos(phi) - math.cos(begin), 2, 3)
    lasted = [stop.end - stop.begin for stop in motion.last_round.sticking]
    assert lasted == pytest.approx([(math.pi + begin - end) / 2.0] * 2, rel=1e-9)


def test_a_chain_on_a_belt_is_an_array():
    chain = sf.System(
        sizes={"n": 2},
        parameters={"Vd": 0.2, "mu": 0.4},
        formulas={"x[0]": "0", "x[n+1]": "0"},
        states={"x[i=1:n]": "v[i]", "v[i=1:n]": "F[i] + x[i-1] - 3*x[i] + x[i+1]"},
        contacts={
            "F[i=1:n]": {
                "slip": "Vd - v[i]",
                "normal": "1",
                "friction": {"law": "Coulomb", "mu_s": "mu*(1 + 0.1*i)", "mu_k": "mu/2"},
            }
        },
    )
    contacts = [
        sf.FrictionContact(
            f"x{i}", sf.Coulomb(mu_s=0.4 * (1 + 0.1 * i), mu_k=0.2), load=1.0, Vd=0.2, name=f"F{i}"
        )
        for i in (1, 2)
    ]
    structure = sf.Structure(
        np.eye(2), None, [[3.0, -1.0], [-1.0, 3.0]], names="x1 x2", contacts=contacts
    )
    assert same_motions(chain, structure, 30, [1.5, 0.0, 0.0, 0.1]) == {"stick", "slip"}


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (('slip = "Vd - v"', 'slip = "Vd - v*x"'), "the slip of F is not linear in the states"),
        (('slip = "Vd - v"', 'slip = "Vd"'), "the slip of F has no state in it; give e.g. Vd - v"),
        (('slip = "Vd - v"', 'slip = "Vd - v + F"'), "the slip of F depends on F, a force"),
        (('slip = "Vd - v"', 'slip = "Vd - w"'), "there is no name 'w'"),
        (('slip = "Vd - v"', 'slip = ["v", "v", "v"]'), "one formula on a line, or two in a plane"),
        (('slip = "Vd - v"', "slip = true"), "slip[0] is true or false; give a text in quotes"),
        (('slip = "Vd - v"', 'slip = "v - Vd"'), "the friction F acts along its slip"),
        (('"F - x"', '"-x"'), "write it into the rates"),
        (('"F - x"', '"F*F - x"'), "the rate of v is not linear in the forces of F"),
        (('normal = "N"', 'normal = "N*F"'), "the normal of F depends on F, a force in a contact"),
        (('normal = "N", ', ""), "contacts.F has no normal; give e.g. F = {"),
        (('"Coulomb"', '"Coulom"'), "did you mean Coulomb?"),
        (('"Coulomb"', '"LuGre"'), "'LuGre', not a law that sticks"),
        (('mu_k = "mu"', 'mu_k = "v"'), "a factor of friction that varies in normal"),
        (('mu_k = "mu"', 'mu_k = "2*mu"'), "friction of F: mu_s = 0.6 is below mu_k = 0.8"),
        (('mu_k = "mu"', 'nu_k = "mu"'), "friction has no entry 'nu_k'; did you mean mu_k?"),
        (('mu_k = "mu"', 'mu_k = "-1"'), "friction of F: mu_k = -1 is outside its bounds"),
        (("F = {", "v = {"), "v is a state and a quantity of the contact v"),
        (("F = {", '"F 1" = {'), "'F 1' cannot be a name in formulas"),
        (("F = {", "F = 1\nG = {"), "contacts.F is a number, not a table; give a table"),
        (('"F - x"', '"G - x"'), "the forces in contacts F, F_normal"),
        (('"F - x"', '"-sign(v) - x"'), "is a force declared in [contacts]"),
    ],
)
def test_bad_input_gets_one_sentence_with_the_place(change, message):
    assert change[0] in BELT
    with pytest.raises(sf.InputError) as error:
        sf.System.from_toml(BELT.replace(*change))
    where, sentence = str(error.value).split("\n")[0].split(": ", 1)
    assert where.startswith("line ")
    assert message in sentence


def test_values_that_a_law_cannot_have_are_refused():
    model = sf.System.from_toml(BELT.replace("1.5*mu", "0.5"))
    with pytest.raises(sf.InputError, match="the normal force of F is -1; it must be > 0"):
        model.replace(N=-1.0)


def pushed():
    """The mass with damping and a force."""
    text = BELT.replace("F - x", "F - x - 0.1*v + P*cos(t)").replace("N = 1.0", "N = 1.0\nP = 0.0")
    return sf.System.from_toml(f'{text}[forcing]\nperiod = "2*pi"\namplitude = "P"\n')


@pytest.mark.parametrize("speed", [0.3, -0.3])
def test_a_slip_that_grazes_zero_is_caught_for_good(speed):
    (branch,) = sf.response(pushed(), "P", (0, 0.1), Vd=speed).branches
    # Friction that does not vary leaves a linear oscillator, which meets the belt's speed.
    (point,) = branch.special
    assert point.type == "GRAZE"
    assert point.value == pytest.approx(0.3 * 0.1, abs=point.uncertainty)
    assert point.uncertainty < 1e-11
    assert branch.stopped.kind == "failed"
    assert branch.stopped.value == point.value
    assert "no orbit was found beyond" in branch.stopped.reason


def test_orbits_are_not_followed_on_a_wall():
    for model in (
        sf.System.from_toml(BELT).replace(Vd=0.0),
        sf.System.from_toml(BELT.replace("Vd - v", "-v")),
    ):
        for start in (None, {"x": 2.0}):  # the way out is named where a motion comes to rest, too
            with pytest.raises(sf.InputError, match="the slip of the contact F is zero or swings"):
                sf.response(model, "mu", (0.1, 0.2), start=start)


RELAY = sf.System(
    parameters={"z": 0.05},
    states={"x": {"rate": "y - 3*x + z*u", "start": 0.1}, "y": "w - 3*x + u", "w": "u - x"},
    contacts={"u": {"slip": "-x", "normal": "1", "friction": {"law": "Coulomb", "mu_k": 1}}},
)
"""Feedback by a relay round a linear system: nothing slides without it."""


def relay_cycle(z):
    """Duration and largest x of the cycle whose halves are mirrored."""
    A, B, one = np.array([[-3, 1, 0], [-3, 0, 1], [-1, 0, 0]]), np.array([z, 1, 1]), np.eye(3)

    def pushed(time):
        return np.linalg.solve(A, (expm(A * time) - one) @ B)

    def start(half):
        return np.linalg.solve(expm(A * half) + one, pushed(half))

    half = brentq(lambda half: start(half)[0], 0.3, 5, xtol=1e-14)

    def after(time):
        return expm(A * time) @ start(half) - pushed(time)

    top = brentq(lambda time: (A @ after(time) - B)[0], 1e-3 * half, 0.9 * half, xtol=1e-14)
    return 2 * half, after(top)[0]


@pytest.mark.parametrize("begin", [{}, {"settled": True}, {"start": {"x": 0.03}}])
def test_cycles_are_followed_where_nothing_slides_all_the_time(begin):
    (branch,) = sf.response(RELAY, "z", (-0.05, -0.5), **begin).branches
    assert branch.stopped.kind == "span"
    for which, z in ((0, -0.05), (-1, -0.5)):
        duration, top = relay_cycle(z)
        assert branch.durations[which] == pytest.approx(duration, rel=1e-9)
        assert branch.extrema.maximum[which, 0] == pytest.approx(top, rel=1e-8)


PUMPED = sf.System(
    parameters={"W": 1.9},
    states={
        "phi": {"rate": "w", "angle": True, "start": 0.5},
        "w": "-(1 + 0.4*cos(W*t))*sin(phi) - 0.02*w + M",
    },
    contacts={"M": {"slip": "-w", "normal": 1, "friction": {"law": "Coulomb", "mu_k": 0.03}}},
    forcing={"period": "2*pi/W"},
)
"""A pendulum with dry friction in its hinge, whose support is shaken."""


@pytest.mark.parametrize("begin", [{"settled": True}, {"start": {"phi": 1.4, "w": -0.2}}])
def test_orbits_of_two_periods_are_followed_where_nothing_slides_all_the_time(begin):
    (branch,) = sf.response(PUMPED, "W", (1.9, 1.8), **begin).branches

    def missed(turn, top):  # half of the orbit, from one turn to the next, is mirrored
        span = (turn, turn + 2 * math.pi / 1.9)

        def rates(t, y):
            return (y[1], 0.03 - 0.02 * y[1] - (1 + 0.4 * np.cos(1.9 * t)) * np.sin(y[0]))

        found = solve_ivp(rates, span, (top, 0), method="DOP853", rtol=1e-12, atol=1e-13)
        return found.y[:, -1] + [top, 0]

    _, top = fsolve(lambda unknown: missed(*unknown), (0.1, 1.43), xtol=1e-12)
    assert branch.period == 2
    assert branch.extrema.maximum[0, 0] == pytest.approx(top, rel=1e-9)


def test_a_motion_that_repeats_later_says_when():
    with pytest.raises(sf.InputError, match="repeats after 2 forcing periods, not after 1; ask"):
        sf.periodic_orbit(PUMPED)


def test_numbers_in_a_law_are_part_of_the_key_of_compiled_code(tmp_path, monkeypatch):
    monkeypatch.setenv("SLIPFOLD_CACHE_DIR", str(tmp_path))
    # It slips for pi + 2 arctan(Vd/rise) and sticks for 2 rise/Vd, with rise = mu_s - mu_k.
    for mu_s in (0.6, 0.5):
        belt = sf.System.from_toml(BELT.replace("1.5*mu", str(mu_s)).replace('"mu"', "0.4"))
        ratio = (mu_s - 0.4) / 0.3
        stuck = 2 * ratio / (2 * ratio + math.pi + 2 * math.atan(1 / ratio))
        assert sf.simulate(belt).stuck_fraction == pytest.approx(stuck, rel=1e-9)
