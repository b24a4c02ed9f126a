"""A diagram is the same in whatever units lengths and times are given: scales find themselves."""

from __future__ import annotations

import numpy as np
import pytest

import slipfold as sf
from helpers.long_tests import long_except
from slipfold.flow.scales import measured

UNITS = [(1e-9, 1e3), (1e6, 1e-5)]
"""Meters and seconds in a unit of length and of time."""

MORE = [(1e-6, 1.0), (1e-3, 1e-3), (7.0, 1e4)]

SHORT = sf.Settings(largest_period=2)


def duffing(length: float, time: float) -> sf.System:
    """Duffing's oscillator: its resonance hangs over."""
    return sf.System(
        parameters={"W": 1.0 / time, "F": 0.3, "L": length, "T": time},
        states={"q": "v", "v": "(L*F*cos(W*t) - q - q^3/L^2)/T^2 - 0.1*v/T"},
        forcing={"period": "2*pi/W", "amplitude": "F"},
    )


def hill(length: float, time: float) -> sf.System:
    """Parametric resonance: nothing moves the state of rest, whose size is not in any load."""
    return sf.System(
        parameters={"W": 2.0 / time, "e": 0.4, "L": length, "T": time},
        states={"q": "v", "v": "-((1 + e*cos(W*t))*q + q^3/L^2)/T^2 - 0.1*v/T"},
        forcing={"period": "2*pi/W", "amplitude": "e"},
    )


def pendulum(length: float, time: float) -> sf.System:
    """A driven mass whose spring drives another one by parametric resonance: zero by symmetry."""
    return sf.System(
        parameters={"F": 0.0, "L": length, "T": time},
        states={
            "x": "v",
            "v": "(L*F*cos(2*t/T) - 4*x - 0.5*y^2/L)/T^2 - 0.4*v/T",
            "y": "w",
            "w": "-(y + x*y/L + 0.1*y^3/L^2)/T^2 - 0.1*w/T",
        },
        forcing={"period": "pi*T", "amplitude": "F"},
    )


def van_der_pol(length: float, time: float) -> sf.System:
    """A cycle born at rest."""
    return sf.System(
        parameters={"mu": -0.5, "L": length, "T": time},
        states={"q": "v", "v": "(mu - q^2/L^2 - 0.2*q/L)*v/T - (q + 0.3*q^2/L)/T^2"},
    )


STUDIES = {
    "duffing": (duffing, "W", (0.8, 2), -1),
    "hill": (hill, "W", (1.5, 2.6), -1),
    "pendulum": (pendulum, "F", (0, 2.0), 0),
    "cycle": (van_der_pol, "mu", (-0.5, 1.0), 0),
}


def followed(name: str, length: float, time: float) -> list[tuple[object, ...]]:
    """All special points, free of units: type, value, largest displacement, coefficient."""
    make, vary, span, power = STUDIES[name]
    unit = time**power
    diagram = sf.response(
        make(length, time), vary, (span[0] * unit, span[1] * unit), settings=SHORT
    )
    return [
        (
            (branch.id, point.type, point.criticality, point.leads_to),
            point.value / unit,
            point.orbit.extrema.of(point.model.states[0].name)[1][0] / length,
        )
        for branch in diagram.branches
        for point in branch.special
    ]


@pytest.mark.parametrize("name", long_except(STUDIES, ("duffing", "hill")))
def test_units_do_not_matter(name):
    expected = followed(name, 1.0, 1.0)
    assert expected
    for length, time in [*UNITS, *MORE] if name == "duffing" else UNITS:
        found = followed(name, length, time)
        assert [item[0] for item in found] == [item[0] for item in expected], (length, time)
        numbers = np.array([item[1:] for item in found], dtype=float)
        assert numbers == pytest.approx(
            np.array([item[1:] for item in expected], dtype=float), rel=1e-8, abs=1e-8
        )


@pytest.mark.parametrize(("length", "time"), [(1.0, 1.0), *UNITS])
def test_what_saturates_beside_what_stays_linear_has_the_size_at_which_it_does(length, time):
    model = sf.System(
        parameters={"L": length, "T": time},
        states={"q": "v", "v": "(0.3*L*tanh(q/L) - q)/T^2 - 0.1*v/T"},
    )
    q, v = measured(model).state_scales()
    assert 0.5 * length <= q <= 16 * length
    assert 0.5 * length / time <= v <= 16 * length / time


def test_derivatives_that_are_rounding_errors_couple_nothing():
    # The friction does not depend on the slip speed. Its derivative is zero, or 1e-17.
    push = "mu*(N + 100*x)*(V - v)/sqrt((V - v)^2)"
    along, across = f"60*y - 400*x - 0.02*v + {push}", f"60*x - 150*y - 0.02*w + 0.3*{push}"
    states = {"x": "v", "v": along, "y": "w", "w": across}
    model = sf.System(parameters={"mu": 0.3, "N": 7.0, "V": 5.0}, states=states)
    for share in np.arange(20):
        x, v, y, w = measured(model.replace(N=7 * (1 + 0.01 * share))).state_scales()
        assert 1 / 8 < x / y < 8
        assert 1 / 8 < v / w < 8
        assert 4 < v / x < 64
