"""Sets whose responses are followed through stick: bifurcations of what sticks divide regions."""

import numpy as np
import pytest

import slipfold as sf
from helpers.by_hand.sticking import duffing_on_belt
from helpers.dry_friction import DUFFING_ON_BELT, shaken_across
from helpers.moreau import march

PLANE, WINDOW = ("W", "A"), ((1.2, 1.5), (0.55, 0.9))


@pytest.fixture(scope="module")
def model():
    """The mass on the belt, pulled by a hardening spring."""
    return sf.System.from_toml(DUFFING_ON_BELT)


def ends_by_hand(frequency, forces, starts, rounds=60, steps=240):
    """Stroboscopic states to which trajectories converge, shape (forces, starts)."""
    forces, starts = np.repeat(forces, len(starts)), np.tile(starts, len(forces))
    begin = np.zeros((len(forces), 1)), starts[:, None]
    span = (0.0, rounds * 2 * np.pi / frequency)
    motion = march(duffing_on_belt(frequency, forces), *begin, span, rounds * steps)
    return motion.q[-1, :, 0]


@pytest.mark.long
def test_regions_between_folds_of_what_sticks_are_as_motions_by_hand(model):
    found = sf.bifurcation_set(model, PLANE, dict(zip(PLANE, WINDOW, strict=True)))
    (fold,) = [locus for locus in found.loci if locus.type == "LP"]
    assert [point.type for point in fold.special] == ["CPC"]
    assert {fold.started.kind, fold.stopped.kind} == {"window"}
    assert all(region.known for region in found.regions.regions)
    cusp = int(fold.values[:, 1].argmin())
    arms = [
        np.array(sorted(part, key=lambda place: place[1])) for part in np.split(fold.values, [cusp])
    ]
    for force in (0.74, 0.8):
        first, second = sorted(float(np.interp(force, arm[:, 1], arm[:, 0])) for arm in arms)
        for frequency, count in ((first - 0.03, 1), ((first + second) / 2, 2), (second + 0.03, 1)):
            ends = ends_by_hand(frequency, np.array([force]), np.linspace(-3.0, 3.0, 6))
            assert 1 + bool(np.ptp(ends) > 0.1) == count
            assert len(found.regions.at(frequency, force).stable) == count


@pytest.mark.long
def test_a_mass_shaken_across_its_belt_lifts_on_its_curve():
    # It slips along the belt; across, a linear oscillator swings about Ns/(k + kn).
    load, stiffness, damping = 0.5, 4.0, 0.1
    model = shaken_across(load, stiffness, damping, force=0.05, frequency=0.2)
    window = {"f": (0.17, 0.2), "F": (0.08, 0.1)}
    found = sf.bifurcation_set(model, ("f", "F"), window, types="LIFT", periods=1, regions=False)
    first = found.loci[0]
    assert (first.type, first.started.kind, first.stopped.kind) == ("LIFT", "window", "window")
    rate, force = 2 * np.pi * first.values[:, 0], first.values[:, 1]
    swing = load / (stiffness * (1 + stiffness))
    exact = swing * np.hypot(1 + stiffness - rate**2, damping * rate)
    assert force == pytest.approx(exact, rel=1e-10)


@pytest.mark.long
def test_the_tip_that_sticks_doubles_its_period_on_a_curve_of_a_set():
    # Nothing slips all the time in the lower half of the window.
    window = {"Vd": (0.068, 0.078), "Nd": (0.88, 0.92)}
    found = sf.bifurcation_set(sf.SlidingOscillator(f=12.5, Nd=0.9), ("Vd", "Nd"), window)
    (doubling,) = [locus for locus in found.loci if (locus.type, locus.period) == ("PD", 1)]
    assert {doubling.started.kind, doubling.stopped.kind} == {"window"}
    assert (doubling.stuck_fraction > 0.05).all()
    for speed, pulsation in doubling.values[[0, -1]]:
        for share, period in ((0.98, 1), (1.02, 2)):
            case = {"f": 12.5, "Nd": pulsation, "Vd": share * speed}
            motion = sf.simulate(sf.SlidingOscillator(), 1000, tolerance=1e-6, **case)
            assert motion.settlement.period == period
    below = found.regions.at(0.069, 0.89)
    assert below.name == "period 1, sticks"
