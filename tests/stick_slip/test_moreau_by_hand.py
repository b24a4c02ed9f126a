"""Moreau's time-stepping, against which motions that stick are held, meets what is known itself."""

import numpy as np
import pytest

from helpers.by_hand.sliding import BASE
from helpers.by_hand.sticking import constant, den_hartog, masses_on_belt, sliding
from helpers.moreau import Contact, System, march

PHASES = np.linspace(0, 2 * np.pi, 8, endpoint=False)


def from_rest(system, duration, periods, steps, shape):
    """The last period of motions from rest, and what sticks in it."""
    motion = march(
        system, np.zeros(shape), np.zeros(shape), (0, periods * duration), periods * steps
    )
    return motion.q[-steps:], motion.stuck[-steps:]


def assert_halved(errors):
    """Errors at steps that are halved fall as those of a method of order one."""
    ratios = np.array(errors[:-1]) / np.array(errors[1:])
    assert np.all((ratios > 1.4) & (ratios < 2.8)), errors


# shared/reference/textbook.md 7 and beyond.md: slip, static, largest x, stuck time per period
@pytest.mark.parametrize(
    ("slip", "static", "largest", "stuck"),
    [(0.7, 0.7, 1.351930925995, 1.251431715), (0.5, 0.8, 1.5704484209, 1.427132002)],
)
def test_den_hartog_with_stops(slip, static, largest, stuck):
    duration = 2 * np.pi / 0.6
    system = den_hartog(0.6, slip, static, PHASES)
    for steps in (100, 200):
        q, sticks = from_rest(system, duration, 12, steps, (8, 1))
        assert q.max(axis=0).mean() == pytest.approx(largest, abs=0.3 * duration / steps)
        # A stop and a release are each seen a step late at most.
        assert sticks.mean() * duration == pytest.approx(stuck, abs=2.5 * duration / steps)


def test_free_decay_drops_by_the_same_every_half_cycle_and_stops():
    contact = Contact(np.eye(1), np.zeros(1), constant(1.0), constant(0.5), 0.5)
    system = System(np.eye(1), np.zeros((1, 1)), lambda t, q: -q, [contact])
    for steps in (100, 200):
        motion = march(system, [5.3], [0.0], (0, 6 * np.pi), 6 * steps)
        turns = [5.3, -4.3, 3.3, -2.3, 1.3, -0.3, -0.3]
        assert motion.q[::steps, 0] == pytest.approx(turns, abs=0.2 * np.pi / steps)
        assert np.all(motion.v[-steps:] == 0)
        assert np.all(motion.stuck[-steps:])


def hyperbola(static):
    """Leine's friction, textbook.md 10."""
    return lambda speed: static / (1 + 3 * speed)


# textbook.md 9 to 11 and beyond.md: coefficient, static, belt speed, damping, period
@pytest.mark.parametrize(
    ("coefficient", "static", "speed", "damping", "period"),
    [
        (constant(0.5), 1.0, 0.2, 0.0, 8.902605407815),
        (constant(0.5), 1.0, 0.2, 0.1, 8.38379742099),
        (hyperbola(1.0), 1.0, 0.2, 0.0, 12.00103129483),
        (hyperbola(1.0), 1.0, 0.3, 0.0, 9.953457266154),
        (lambda speed: 0.5 + 0.5 * np.exp(-speed / 0.5), 1.0, 1.0, 0.1, 6.4313827982),
    ],
)
def test_belts_to_first_order(coefficient, static, speed, damping, period):
    system = masses_on_belt([coefficient], [static], speed, damping=damping)
    errors = []
    for h in (0.04, 0.02):
        # From 0.9 a step would begin at the limit of stick itself, where rounding decides.
        found = rounds(march(system, [0.9013], [speed], (0, 40), round(40 / h)))
        errors.append(abs(found[1:].mean() - period))
        assert errors[-1] < 2.2 * h
    assert_halved(errors)


def rounds(motion, level=0.3):
    """Times between upward crossings of the first displacement."""
    t, x = motion.times, motion.q[:, 0]
    i = np.flatnonzero((x[:-1] < level) & (x[1:] >= level))
    return np.diff(t[i] + (level - x[i]) / (x[i + 1] - x[i]) * (t[i + 1] - t[i]))


# beyond.md: largest and smallest x/L and y/L, stuck fraction
ROWS = {"Nd": [0.3, 0.3, 0.9], "Vd": [0.05, 0.05, 0.02], "mu_s": [0.5, 0.6, 0.5]}
EXTREMA = [
    [0.1900998927, 0.0672867089, 0.1753534846, -0.0783359137],
    [0.1905840421, 0.0672596774, 0.1760634389, -0.0788106789],
    [0.1268751657, 0.0496066544, 0.0935858688, -0.0443746758],
]
STUCK = [0.053208237, 0.073909323, 0.349134742]


def test_the_sliding_oscillator_in_the_plane_to_first_order():
    system = sliding(**{name: np.array(values) for name, values in ROWS.items()})
    errors = []
    for steps in (40, 80):
        q, stuck = from_rest(system, 1 / BASE["f"], 40, steps, (3, 2))
        found = np.stack([q.max(axis=0), q.min(axis=0)], axis=-1).reshape(3, 4) / BASE["L"]
        errors.append(np.abs(found - EXTREMA)[:, :2])
        assert np.abs(found - EXTREMA).max() < 0.2 / steps
        assert stuck[..., 0].mean(axis=0) == pytest.approx(STUCK, abs=2.5 / steps)
    assert_halved(errors)
