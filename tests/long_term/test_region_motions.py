"""What motions do in regions of a bifurcation set that have no stable response of theirs."""

from types import SimpleNamespace

import numpy as np
import pytest

import slipfold as sf
from slipfold import Region, RegionMap, RegionMotion
from slipfold.computations import loci
from slipfold.long_term.regimes import resolve_regions

PLANE, WINDOW = ("f", "Nd"), ((12.499, 12.501), (0.03, 0.15))
MODEL = sf.SlidingOscillator(f=12.5, Nd=0.1)


def regions(*found, split=None):
    """Regions of the window: all of it, or those below and above a value of Nd."""
    first, second = (np.linspace(low, high, 81)[1::2] for low, high in WINDOW)
    above = np.zeros(40, bool) if split is None else second > split
    labels = np.where(above[:, None], 2, np.ones((1, 40))).astype(np.int64)
    return RegionMap(first, second, labels, found)


def test_a_region_without_stable_responses_is_torus_and_chaos():
    # As Lyapunov exponents tell at 0.06 and 0.12 N, in docs/how-to/tori-and-chaos.md.
    told = []
    found, interrupted = resolve_regions(
        MODEL, PLANE, WINDOW, regions(Region(1, (), 1.0, (12.5, 0.09))), (1, 2), told.append
    )
    (region,) = found.regions
    assert not interrupted
    assert region.regimes == {"torus": 0.5, "chaos": 0.5}
    assert [motion.values for motion in region.motions] == [
        pytest.approx((12.5, 0.06)), pytest.approx((12.5, 0.12)),
    ]  # fmt: skip
    assert region.name == "none"
    assert "torus 50%, chaos 50%" in repr(region)
    assert {progress.stage for progress in told} == {"regimes"}
    assert told[-1].done == told[-1].total


def test_only_regions_that_are_not_known_to_have_stable_responses_are_asked():
    stable = Region(1, (1,), 0.25, (12.5, 0.04))
    doubtful = Region(2, (2,), 0.75, (12.5, 0.1), consistent=False)
    found, _ = resolve_regions(MODEL, PLANE, WINDOW, regions(stable, doubtful, split=0.06), (1, 4))
    assert found.regions[0] is not doubtful
    assert not found.regions[0].motions
    assert [m.values[1] for m in found.regions[1].motions] == pytest.approx([0.075, 0.105, 0.135])
    assert found.regions[1].name == "unknown"
    untouched = regions(stable)
    assert resolve_regions(MODEL, PLANE, WINDOW, untouched, (1, 4))[0] is untouched


def test_a_region_whose_motions_contradict_its_label_is_not_known():
    # A damped linear oscillator has one response, of period 1, and it is stable.
    linear = sf.System(
        name="linear",
        parameters={"F": 0.3, "W": 1.5, "d": 1.0},
        states={"x": "v", "v": "F*cos(W*t) - d*v - x"},
        forcing={"period": "2*pi/W"},
    )
    axes = np.linspace(1.1, 1.9, 5), np.linspace(0.1, 0.5, 5)
    labels = np.ones((5, 5), np.int64)
    window = ((1.0, 2.0), (0.05, 0.55))
    none, right = Region(1, (), 1.0, (1.5, 0.3)), Region(1, (1,), 1.0, (1.5, 0.3), False)
    told, kept = (
        resolve_regions(linear, ("W", "F"), window, RegionMap(*axes, labels, (one,)), (2, 2))[0]
        for one in (none, right)
    )
    assert none.known
    assert told.regions[0].name == "unknown"
    assert told.at(1.5, 0.3) is None
    (check,) = told.regions[0].checks
    assert (check.values, check.settled, check.agrees) == ((1.25, 0.175), 1, False)
    assert "none across the region has, seen at 4 of 4 places" in check.note
    assert kept.regions[0].checks == ()


def test_an_interrupt_keeps_the_regions():
    def stop(progress):
        raise KeyboardInterrupt

    found, interrupted = resolve_regions(
        MODEL, PLANE, WINDOW, regions(Region(1, (), 1.0, (12.5, 0.09))), (1, 2), stop
    )
    assert interrupted
    assert found.regions[0].motions == ()


def motions():
    return (RegionMotion((12.5, 0.06), "torus", 0, 1e-9), RegionMotion((12.5, 0.12), "periodic", 8))


def asked(monkeypatch, interrupted=False, **keys):
    found = None if interrupted else regions(Region(1, (), 1.0, (12.5, 0.09)))
    answer = SimpleNamespace(loci=(), regions=found, interrupted=interrupted, missing=())
    monkeypatch.setattr(loci, "find_bifurcation_set", lambda *args, **keys: answer)
    return sf.bifurcation_set(sf.SlidingOscillator(), PLANE, WINDOW, **keys)


def test_a_set_has_them_on_request(monkeypatch, tmp_path):
    assert asked(monkeypatch).regions.regions[0].motions == ()
    found = asked(monkeypatch, regimes=(1, 2))
    record = found.to_json()["regions"][0]
    assert record["regimes"] == {"torus": 0.5, "chaos": 0.5}
    assert [item["kind"] for item in record["motions"]] == ["torus", "chaos"]
    assert "torus 50%, chaos 50%" in found.summary()
    found.save(tmp_path / "set.nc")
    again = sf.load(tmp_path / "set.nc")
    assert again.to_json() == found.to_json()
    assert again.regions.regions[0].motions == found.regions.regions[0].motions
    assert asked(monkeypatch, interrupted=True, regimes=(1, 2)).regions is None


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ({"regimes": (60, 50), "regions": False}, "needs regions"),
        ({"regimes": (60, 0)}, "regimes = 0 is not a whole number of at least 1"),
    ],
)
def test_what_cannot_be_used_is_refused(monkeypatch, keys, words):
    with pytest.raises(sf.InputError, match=words):
        asked(monkeypatch, **keys)
