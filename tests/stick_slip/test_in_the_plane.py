"""The sliding oscillator under exact planar friction: into stick, out of it, and on a wall."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import slipfold as sf
from helpers.dry_friction import den_hartog, sliding
from slipfold.flow.linearised_motion import linearised_motion
from slipfold.flow.modes import Status, shown
from slipfold.flow.switched_motion import SwitchedMotion, legs

# Found by two methods that share no code.
ROWS = [
    pytest.param(
        (0.3, 0.05, 0.5, 1, 0.053208237, (0.1900998927, 0.0672867089, 0.1753534846, -0.0783359137)),
        marks=pytest.mark.long,
    ),
    (0.3, 0.05, 0.6, 1, 0.073909323, (0.1905840421, 0.0672596774, 0.1760634389, -0.0788106789)),
    (0.9, 0.02, 0.5, 1, 0.349134742, (0.1268751657, 0.0496066544, 0.0935858688, -0.0443746758)),
    (0.6, 0.1, 0.5, 2, 0.0, (0.3882907165, -0.1888683006, 0.2882647529, -0.2272754321)),
]


@pytest.mark.parametrize("row", ROWS, ids=lambda row: f"Nd={row[0]} Vd={row[1]} mu_s={row[2]}")
def test_published_motions(row):
    pulsation, speed, static, period, fraction, extrema = row
    motion = sf.simulate(sliding(pulsation, speed, static), 120)
    assert motion.settlement.period == period
    assert motion.regime == ("stick-slip" if fraction else "slip")
    assert motion.stuck_fraction == pytest.approx(fraction, abs=1e-9)
    assert len(motion.last_round.sticking) == (1 if fraction else 0)
    last = motion.last_round
    found = (last.most[0], last.least[0], last.most[1], last.least[1])
    assert found == pytest.approx(extrema, abs=1e-10)


def test_what_sticks_moves_with_the_plate_and_stays_in_the_cone():
    motion = sf.simulate(sliding(0.9, 0.02), 40)
    fx, fy, normal, speed = (
        motion.output(name, 30, None, 97)[1] for name in ("Fx", "Fy", "N", "Vrel")
    )
    friction, rests = np.hypot(fx, fy), speed == 0
    assert 0.3 < rests.mean() < 0.4
    assert (friction[rests] <= 0.5 * normal[rests] * (1 + 1e-12)).all()
    assert friction[~rests] == pytest.approx(0.5 * normal[~rests], rel=1e-12)
    states = motion.sample(30, None, 97)[1][rests]
    plate = 0.02 / 5e-3 * np.array([math.cos(math.pi / 3), math.sin(math.pi / 3)])
    assert np.abs(states[:, 2:] - plate).max() <= 1e-14 * plate.max()


@pytest.mark.parametrize("static", [0.5, 0.6])
def test_a_period_may_end_while_slip_begins(static):
    motion = SwitchedMotion(sliding(0.9, 0.02, static), np.zeros(4))
    motion.go_on(2)
    begin, mode, scales = motion.strobe[2], motion.modes[2], motion.constants.scales

    def followed(*ends):
        """State, energies and begin of slip, one end after another."""
        state, doing, phase, energies, slips = begin, mode, 0.0, np.zeros(2), None
        for end in ends:
            for leg, after in legs(
                motion.flow, doing, state, end, motion.constants, motion.weights, begin=phase
            ):
                if doing == (Status.STICK,) and shown(after) == (Status.FORTH,):
                    slips = leg.end
                energies, state, doing = energies + leg.energies, leg.state, shown(after)
                assert leg.end <= end
            phase = end
        return state, energies, slips

    state, energies, slips = followed(1.0)
    for later in (1e-13, 1e-10, 1e-8, 1e-6, 1e-5, 2.5e-5, 4.9e-5, 6e-5, 1e-3):
        other, others, _ = followed(slips + later, 1.0)
        assert np.abs((other - state) / scales).max() < 3e-11
        assert np.abs(others - energies).max() < 1e-10 * energies.max()


def test_energy_balance_over_a_period():
    short, long = (sf.simulate(sliding(0.9, 0.02), periods) for periods in (39, 40))
    work, heat = (
        sum(getattr(item, what) for item in long.sticking.intervals)
        - sum(getattr(item, what) for item in short.sticking.intervals)
        for what in ("work", "heat")
    )
    # What friction puts in is stored, or taken out by damping. Slip is singular where it ends.
    nodes, weights = np.polynomial.legendre.leggauss(14)
    inside = [item.end - 39 for item in long.sticking.intervals if 39 < item.end < 40]
    near = [
        event + side * 10.0**-power
        for event in inside for side in (-1, 1) for power in range(2, 7)
    ]  # fmt: skip
    edges = np.unique(np.concatenate([np.linspace(0, 1, 65), inside, near]))
    edges = edges[(edges >= 0) & (edges <= 1)]
    lengths = np.diff(edges)
    points = (edges[:-1, None] + lengths[:, None] * (nodes + 1) / 2).ravel()
    v = long.at((39 + points) * long.forcing_period)[:, 2:]
    model = long.model
    lost = 25e-6 * (model.c2 * v[:, 0] ** 2 + model.c1 * v[:, 1] ** 2)
    damped = float((lost.reshape(-1, 14) * weights).sum(axis=1) @ lengths) / 2 * 0.08
    stored = energy(model, long.strobe[40]) - energy(model, long.strobe[39])
    assert work == pytest.approx(damped + stored, abs=1e-9 * heat)
    assert heat > 1e-5


def energy(model, state):
    x, y, vx, vy = 5e-3 * state
    stretch = math.hypot(x, model.L + y) - model.L
    moving = model.m2 * vx**2 + model.m1 * vy**2
    return (moving + model.k2 * x**2 + model.k1 * y**2 + model.kext * stretch**2) / 2


def test_a_line_in_the_plane_is_a_line():
    # Two directions, one of them at rest: the motion, its turns and stops are those on a line.
    law = sf.Coulomb(mu_s=0.8, mu_k=0.5)
    plane = sf.Structure(
        np.eye(2),
        None,
        np.eye(2),
        names="x y",
        contacts=sf.FrictionContact(("x", "y"), law, load=1.0, Vd=0.0),
        forcing=sf.HarmonicForce("x", F=1.0),
        f=0.6 / (2 * math.pi),
    )
    flat = sf.simulate(plane, 20)
    line = sf.simulate(den_hartog(0.6, 0.5, 0.8), 20)
    assert flat.strobe[:, [0, 2]] == pytest.approx(line.strobe, abs=1e-10)
    assert np.abs(flat.strobe[:, [1, 3]]).max() < 1e-12
    assert [item.state for item in flat.sticking.intervals].count("stick") > 20


@pytest.mark.parametrize("forced", [True, False])
def test_on_a_wall_the_oscillator_comes_to_rest(forced):
    model = sliding(0.4, 0.0, 0.6)
    start = {"x": 3.0, "vy": 20.0}
    motion = sf.simulate(model if forced else model.steady(), 12, start)
    assert motion.stopped is None
    assert motion.sticking.intervals[0].state == "slip"
    assert motion.sticking.intervals[-1].state == "stick"
    assert np.abs(motion.strobe[-1, 2:]).max() == 0
    assert motion.strobe[-1] == pytest.approx(motion.strobe[-2], abs=0)
    # All that was in it was turned into heat by friction and damping, but for what springs hold.
    heat = sum(item.heat for item in motion.sticking.intervals)
    work = sum(item.work for item in motion.sticking.intervals)
    assert work == pytest.approx(-heat, rel=1e-12)
    lost = energy(model, motion.strobe[0]) - energy(model, motion.strobe[-1])
    assert 0.9 * lost < heat < lost


def test_loci_and_maps_are_not_followed_on_a_wall():
    with pytest.raises(
        sf.InputError, match=r"at f = 12 the contact tip of sliding sticks for good"
    ):
        sf.response(sliding(0.1, 0.0), "f", (12, 13))
    for follow in (
        lambda: sf.response(sliding(0.1, 0.6), "Vd", (0.6, 0)),
        lambda: sf.bifurcation_set(sliding(0.1, 0.0), ("f", "Nd"), ((12, 13), (0, 0.1))),
        lambda: sf.threshold_map(
            sliding(0.1, 0.6), "Nd", over={"Vd": [0, 1], "f": [12, 13]}, span=(0, 0.1)
        ),
        lambda: sliding(0.1, 0.0).static_point(),
    ):
        with pytest.raises(sf.InputError, match=r"^Vd = 0 is outside its bounds; Vd must be > 0"):
            follow()


def test_on_a_wall_a_mass_comes_to_rest():
    law = sf.Coulomb(mu_s=0.6, mu_k=0.5)
    load = sf.ModulatedLoad(Ns=1.0, Nd=0.2)
    wall = sf.FrictionContact(("x", "y"), law, load=load, Vd=0.0)
    stiffness = [[30.0, -5.0], [-5.0, 40.0]]
    model = sf.Structure(np.diag([1.0, 2.0]), None, stiffness, names="x y", contacts=wall)
    motion = sf.simulate(model, 60, {"x": 0.3, "y": 0.2})
    assert motion.stopped is None
    assert motion.regime == "stuck"
    assert motion.stuck_fraction == 1
    assert np.abs(motion.strobe[-1, 2:]).max() == 0
    fx, fy, normal = (motion.output(name, 50)[1] for name in ("Fx", "Fy", "N"))
    assert (np.hypot(fx, fy) <= 0.5 * normal * (1 + 1e-12)).all()


def test_slip_begins_as_an_integrator_of_another_kind_has_it():
    motion = SwitchedMotion(sliding(0.9, 0.02), np.zeros(4))
    motion.go_on(2)
    known = motion.flow, motion.modes[2], motion.strobe[2], 1.0, motion.constants, motion.weights
    [begun] = [leg for leg, _ in legs(*known, dense=True) if leg.beginning is not None]
    model, length, period = motion.model, 5e-3, motion.constants.period
    speed = 0.02 * np.array([math.cos(math.pi / 3), math.sin(math.pi / 3)])

    def rates(phase, state):
        """By hand: displacements in m, and slip in m/s."""
        x, y, *slip = state
        vx, vy = speed - slip
        stretched = math.hypot(x, length + y)
        pull = model.kext * (stretched - length) / stretched
        drag = 0.5 * (1 + 0.9 * math.cos(2 * math.pi * phase)) / math.hypot(*slip)
        ax = drag * slip[0] - model.c2 * vx - model.k2 * x - pull * x
        ay = drag * slip[1] - model.c1 * vy - model.k1 * y - pull * (length + y)
        return period * np.array([vx, vy, -ax / model.m2, -ay / model.m1])

    # From a time on at which slip has a direction to some digits: friction finds the others.
    first = begun.begin + 0.03 * (begun.end - begun.begin)
    state = length * begun.polynomials(np.array([first]))[0, :4] * motion.constants.scales
    start = np.concatenate([state[:2], speed - state[2:]])
    start[2:] *= 1 + 1e-6
    span = first, begun.end
    found = solve_ivp(rates, span, start, method="Radau", rtol=1e-9, atol=1e-16).y[:, -1]
    assert length * begun.state[:2] == pytest.approx(found[:2], abs=1e-13)
    assert speed - length * begun.state[2:] == pytest.approx(found[2:], rel=1e-7)


def test_the_linearised_motion_through_a_release_is_what_differences_say():
    motion = SwitchedMotion(sliding(0.9, 0.02), np.zeros(4))
    motion.go_on(2)
    flow, constants, weights = motion.flow, motion.constants, motion.weights
    known, begin, end = (constants, weights), 0.1, 0.35
    *_, (leg, after) = legs(flow, motion.modes[2], motion.strobe[2], begin, *known)
    assert after == (Status.STICK,)
    start, scales = leg.state, constants.scales

    def moved(change):
        state = flow.held(after, start + change * scales, begin, constants)
        *_, (last, _) = legs(flow, after, state, end, *known, begin=begin)
        return last.state / scales

    passed = list(legs(flow, after, start, end, *known, begin=begin))
    assert any(leg.beginning is not None for leg, _ in passed)
    still = np.zeros((len(constants.values), 0))
    found = linearised_motion(flow, start, passed, *known, still).matrix * scales / scales[:, None]
    h = 1e-4
    for column, axis in zip(found.T, np.eye(4), strict=True):
        one, two = (moved(k * h * axis) - moved(-k * h * axis) for k in (1, 2))
        assert np.abs((8 * one - two) / (12 * h) - column).max() < 1e-8
