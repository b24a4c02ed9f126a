"""The simulated test stand: what it reads is on the branches, and it jumps where they fold."""

import numpy as np
import pytest

import slipfold as sf
from helpers.toy_models import FLOOR

DUFFING = sf.built_in_models()["duffing"]()


def test_measurements_jump_at_the_folds_of_the_response():
    diagram = sf.response(DUFFING, vary="W", span=(0.8, 1.6))
    low, high = sorted(point.value for _, point in diagram.special if point.type == "LP")
    values = np.linspace(low - 0.05, high + 0.05, 9)
    seen = sf.measure(DUFFING, "W", values, ["max q"], sweep="both")
    up, down = seen.measured[:9, 0], seen.measured[9:, 0][::-1]
    inside = (values > low) & (values < high)
    assert (up[inside] > 1.5 * down[inside]).all()
    assert np.allclose(up[~inside], down[~inside], rtol=1e-8)
    # From a branch the measurement at the last value: the same orbit by other means.
    orbit = sf.periodic_orbit(DUFFING.replace(W=float(values[-1])))
    assert up[-1] == pytest.approx(orbit.extrema.of("q")[1][0], rel=1e-8)


def test_noise_has_the_deviation_asked_for_and_a_seed():
    model = sf.SlidingOscillator(Nd=0.02)
    plain = sf.measure(model, "f", [12.0, 12.2], ["max y", "min y"])
    noisy = sf.measure(model, "f", [12.0, 12.2], ["max y", "min y"], errors=[1e-3, 0.0], seed=4)
    again = sf.measure(model, "f", [12.0, 12.2], ["max y", "min y"], errors=[1e-3, 0.0], seed=4)
    assert np.array_equal(noisy.measured, again.measured)
    assert 0 < np.abs(noisy.measured - plain.measured)[:, 0].max() < 5e-3
    assert np.array_equal(noisy.measured[:, 1], plain.measured[:, 1])
    assert np.array_equal(noisy.errors, [[1e-3, np.nan]] * 2, equal_nan=True)


def test_it_reads_through_stick():
    law = sf.Coulomb(mu_s=0.6, mu_k=0.5)
    model = sf.SlidingOscillator(friction=law, f=12.5, Vd=0.05)
    seen = sf.measure(model, "Nd", [0.3], ["max x", "min y"])
    # Stick-slip in the plane at 0.05 m/s, mu_s = 0.6: known by two methods that share no code;
    # between the samples of a motion that sticks the least may be missed by 1e-6.
    assert seen.measured[0] == pytest.approx([0.1905840421, -0.0788106789], abs=2e-6)


def test_interrupted_it_keeps_what_was_read():
    def observe(progress):
        if progress.done == 2:
            raise KeyboardInterrupt

    seen = sf.measure(DUFFING, "W", [0.8, 0.85, 0.9], ["max q"], on_progress=observe)
    assert seen.values.tolist() == [0.8, 0.85]


def test_where_the_motion_ends_it_keeps_what_was_read():
    seen = sf.measure(FLOOR, "F", [1.0, 2.0, 4.0], ["max x"], sweep="both")
    # The closed form: a linear oscillator has its floor at -1, beyond F = 3 or so.
    amplitudes = np.array([1.0, 2.0]) / np.hypot(3.0, 0.2)
    assert seen.measured[:, 0] == pytest.approx(amplitudes, rel=1e-6)
    assert (seen.values.tolist(), seen.sweep) == ([1.0, 2.0], ("up", "up"))
    assert "F=4" in seen.stopped
    assert "room" in seen.stopped
    assert "stopped early" in repr(seen)
    assert sf.measure(FLOOR, "F", [1.0], ["max x"]).stopped is None
    with pytest.raises(sf.InputError, match="nothing was measured, so begin within the limits"):
        sf.measure(FLOOR, "F", [4.0, 5.0], ["max x"])


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"vary": "Q"}, "duffing has no parameter 'Q'"),
        ({"values": []}, "no value of W is given"),
        ({"values": {0.1}}, "is not a list of numbers"),
        ({"values": [-1.0]}, "W = -1"),
        ({"quantities": []}, "no quantity is measured"),
        ({"quantities": ["q"]}, "does not say what is measured"),
        ({"sweep": "left"}, "is not a direction"),
        ({"errors": -1.0}, "are no standard deviations"),
        ({"errors": [0.1, 0.2]}, "do not fit the quantities; give one"),
    ],
)
def test_what_cannot_be_measured(change, words):
    given = {"vary": "W", "values": [0.9], "quantities": ["max q"], **change}
    with pytest.raises(sf.InputError, match=words):
        sf.measure(DUFFING, **given)


def test_a_model_without_forcing_has_no_response():
    with pytest.raises(sf.InputError, match="nothing forces vanderpol-free"):
        sf.measure(sf.built_in_models()["vanderpol-free"](), "mu", [1.0], ["max x"])
