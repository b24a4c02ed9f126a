"""Planes and windows as people write them."""

import numpy as np
import pytest

from slipfold import InputError, SlidingOscillator
from slipfold.computations.loci import corner_model, parse_plane

MODEL = SlidingOscillator()
DEGREE = np.pi / 180


@pytest.mark.parametrize(
    ("vary", "window", "expected"),
    [
        (("f", "Nd"), ((11.5, 13.5), (0, 0.98)), ((11.5, 13.5), (0, 0.98))),
        (("f", "Nd"), {"Nd": (0, "980mN"), "f": ("11.5", "13.5Hz")}, ((11.5, 13.5), (0, 0.98))),
        (("alpha", "Nd"), (("20deg", "80°"), (0, 0.5)), ((20 * DEGREE, 80 * DEGREE), (0, 0.5))),
        (["Nd", "f"], [[0.5, 0], np.array([14, 11])], ((0, 0.5), (11, 14))),
        (("Ns", "Nd"), ((0.2, 2), (0, 0.98)), ((0.2, 2), (0, 0.98))),
    ],
)
def test_windows(vary, window, expected):
    names, found = parse_plane(MODEL, vary, window)
    assert names == tuple(vary)
    np.testing.assert_allclose(found, expected, rtol=1e-15)


GIVEN = {"vary": ("f", "Nd"), "window": ((11, 14), (0, 0.9))}


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"vary": ("f",)}, "a locus is followed in two parameters, not in"),
        ({"vary": ("f", "Nd", "mu")}, "give two names"),
        ({"vary": "fN"}, "give two names"),
        ({"vary": 3}, "give two names"),
        ({"vary": (1, 2)}, "1 is not the name of a parameter; give two names"),
        ({"vary": ("f", None)}, "None is not the name of a parameter"),
        ({"window": None}, r"no window is given; .* e\.g\. window={'f': \(lower, upper\), 'Nd'"),
        ({"window": ((True, 14), (0, 1))}, "the window of f holds True, which is not a number"),
        ({"window": ((11, np.True_), (0, 1))}, "the window of f holds True"),
        ({"vary": ("f", "f")}, "f is given for both parameters; give two different ones"),
        ({"vary": ("f", "nd")}, "no parameter 'nd'; did you mean Nd"),
        ({"window": 3}, "window = 3 is not a pair of pairs; give two values each for f and Nd"),
        ({"window": ((11, 14),)}, "is not a pair of pairs"),
        ({"window": "ab"}, "is not a pair of pairs"),
        ({"window": (11, 14)}, "the window of f is 11, which is not a pair"),
        ({"window": ((11, 12, 13), (0, 1))}, r"the window of f is \(11, 12, 13\)"),
        ({"window": ("11", (0, 1))}, "the window of f is '11', which is not a pair"),
        ({"window": {"f": (11, 14)}}, "the window is given for f; give two values each for f"),
        ({"window": {}}, "the window is given for nothing"),
        ({"window": {"f": (11, 14), "Nd": (0, 1), "mu": (0, 1)}}, "is given for f, Nd, mu"),
        ({"window": ((11, "14mm"), (0, 1))}, "f = '14mm' has the unit 'mm'"),
        ({"window": ((11, "high"), (0, 1))}, "f = 'high' is not a number"),
        ({"window": ((11, None), (0, 1))}, "f = None is not a number"),
        ({"window": ((11, float("nan")), (0, 1))}, "f = nan is not a finite number"),
        ({"window": ((12, 12), (0, 1))}, "the window of f from 12 to 12 is empty"),
        ({"window": ((0, 12), (0, 1))}, "f = 0 is outside its bounds; f must be > 0 Hz"),
        ({"vary": ("f", "mu"), "window": ((11, 12), (-1, 1))}, "mu = -1 is outside its bounds"),
    ],
)
def test_what_is_no_window(changes, message):
    with pytest.raises(InputError, match=message):
        parse_plane(MODEL, **(GIVEN | changes))


def test_the_model_is_that_of_the_lowest_corner():
    assert corner_model(MODEL, ("f", "Nd"), ((11, 14), (0.1, 0.9)), {"mu": 0.3}) == (
        SlidingOscillator(f=11, Nd=0.1, mu=0.3)
    )


def test_values_that_the_plane_replaces_do_not_matter():
    model = SlidingOscillator(Nd=0.6)
    assert corner_model(model, ("f", "Nd"), ((11, 14), (0, 0.4)), {"Ns": 0.5}).Nd == 0
