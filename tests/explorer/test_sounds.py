"""Vibrations as sound: the samples are the motion's, faster where it is too low to be heard."""

import base64
import math
from collections import OrderedDict

import numpy as np
import pytest

import slipfold as sf
from helpers.dry_friction import belt
from slipfold.interface.explorer.messages import SoundRequest
from slipfold.interface.explorer.sounds import SOUND, send_sound


def heard(model, output, **options):
    request = SoundRequest(kind="sound", id=1, model=model.name, output=output, **options)
    pieces = []
    send_sound(model, request, pieces.append, lambda: None, OrderedDict())
    answer = pieces[-1]
    return answer, np.frombuffer(base64.b64decode(answer["samples"]), "<i2") / 32767


def oscillator(f):
    """A damped mass that is forced: of its response there is one line."""
    return sf.System(
        name="tone",
        parameters={"f": f, "k": 1e3, "F": 1.0},
        states={"q": "v", "v": "F*cos(2*pi*f*t) - k*q - 20*v"},
        forcing={"period": "1/f", "amplitude": "F"},
    )


@pytest.mark.parametrize(("f", "faster"), [(200.0, 1), (12.5, 8), (0.3, 512)])
def test_a_response_is_repeated_at_its_own_pitch_or_octaves_above(f, faster):
    answer, samples = heard(oscillator(f), "v", periods=600)
    assert (answer["repeats"], answer["faster"], answer["frequency"]) == (True, faster, f)
    assert answer["rate"] == pytest.approx(SOUND.rate, rel=0.01)
    # One period, so that it is repeated without a gap: a sine to sixteen bits.
    pitch = answer["rate"] / len(samples)
    assert pitch == pytest.approx(f * faster)
    size = 2 * math.pi * f / abs(1e3 - (2 * math.pi * f) ** 2 + 20j * 2 * math.pi * f)
    assert answer["size"] == pytest.approx(size, rel=1e-3)
    lines = np.abs(np.fft.rfft(samples)) * 2 / len(samples)
    assert lines[1] == pytest.approx(1, abs=1e-3)
    assert lines[2:].max() < 1e-4


def test_a_torus_is_heard_for_some_seconds():
    model = sf.SlidingOscillator(f=12.5, Nd=0.06)
    answer, samples = heard(model, "vx", periods=600)
    assert not answer["repeats"]
    assert len(samples) / answer["rate"] == pytest.approx(SOUND.seconds, abs=0.01)
    motion = sf.simulate(model, 600)
    vx = motion.output("vx", -300, None, round(answer["rate"] / 100))[1]
    vx -= vx.mean()
    assert samples == pytest.approx(vx / np.abs(vx).max(), abs=2e-5)


def test_a_cycle_is_heard_and_what_stands_still_is_not():
    answer, samples = heard(belt(sf.Coulomb(mu_s=1.0, mu_k=0.5)), "x", periods=600)
    assert answer["repeats"]
    assert answer["rate"] / len(samples) == pytest.approx(answer["frequency"] * answer["faster"])
    resting = belt(sf.Coulomb(mu_s=0.1, mu_k=0.1), speed=0.0)
    request = SoundRequest(kind="sound", id=1, model="belt", output="x", start={"x": 1.0})
    pieces = []
    send_sound(resting, request, pieces.append, lambda: None, OrderedDict())
    assert pieces[-1] == {"silent": True}
