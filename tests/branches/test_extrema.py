"""Extrema of what is measured of an output along a branch."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import minimize_scalar
from tests.helpers.dry_friction import rubbing

import slipfold as sf
from slipfold.models.registry import model_named
from slipfold.plots.response import marks_of

DAMPING = 0.1

LINEAR = sf.System(
    name="linear oscillator",
    parameters={"W": 0.6, "F": 2.0, "D": DAMPING},
    states={"x": "v", "v": "F*cos(W*t) - 2*D*v - x"},
    forcing={"period": "2*pi/W", "amplitude": "F"},
    outputs={"a": "F*cos(W*t) - 2*D*v - x"},
)

DRY = rubbing(W=0.7)


def extrema(model, vary, span, *events, **options):
    diagram = sf.response(model, vary, span, events=events, **options)
    return [point for _, point in diagram.special if point.type in ("MAX", "MIN")]


@pytest.mark.parametrize("discretization", ["automatic", "collocation"])
@pytest.mark.parametrize(
    ("event", "type_", "frequency", "amplitude"),
    [
        (sf.Event("x"), "MAX", np.sqrt(1 - 2 * DAMPING**2), 1 / np.sqrt(1 - DAMPING**2)),
        (sf.Event("v", measure="min"), "MIN", 1.0, 1.0),
        # The acceleration has its peak beyond the resonance; it depends on the forcing's phase.
        (
            sf.Event("a", measure="peak_to_peak"),
            "MAX",
            1 / np.sqrt(1 - 2 * DAMPING**2),
            1 / np.sqrt(1 - DAMPING**2),
        ),
    ],
)
def test_peaks_of_a_linear_oscillator(discretization, event, type_, frequency, amplitude):
    settings = sf.Settings(discretization=discretization)
    (peak,) = extrema(LINEAR, "W", (0.6, 1.6), event, settings=settings)
    assert peak.type == type_
    assert peak.name == f"{'largest' if type_ == 'MAX' else 'smallest'} {event}"
    assert abs(peak.value - frequency) < max(10 * peak.uncertainty, 1e-12)
    assert peak.uncertainty < 1e-10
    found = peak.orbit.extrema.modulus(event.name)
    assert found == pytest.approx(amplitude * 2.0 / (2 * DAMPING), rel=1e-9)


@pytest.mark.parametrize("unit", [1.0, 1e-6])
def test_a_value_just_below_a_peak_is_passed_twice(unit):
    """By the closed form. Outputs have any unit, and more digits than multipliers."""
    below, first = 1e-8, 1 - 2 * DAMPING**2
    level = sf.Event("x", unit / DAMPING / np.sqrt(1 - DAMPING**2) * (1 - below))
    away = 2 * DAMPING * np.sqrt((1 - DAMPING**2) * ((1 - below) ** -2 - 1))
    model, settings = LINEAR.replace(F=2 * unit), sf.Settings(steps=sf.Steps(largest=1.0))
    diagram = sf.response(model, "W", (0.545, 1.5), events=[level], settings=settings)
    found = [point for _, point in diagram.special]
    assert [point.type for point in found] == ["EVENT", "EVENT"]
    for point, expected in zip(found, np.sqrt([first - away, first + away]), strict=True):
        # As far as 1e-13 of the amplitude moves them.
        assert abs(point.value - expected) < away / (4 * below) * 1e-13
        assert abs(point.value - expected) < point.uncertainty < 1e-9


def test_peak_of_a_bent_resonance_is_that_of_a_fine_scan():
    diagram = sf.response(model_named("duffing"), "W", (0.9, 1.27), events=[sf.Event("q")])
    (peak,) = (point for _, point in diagram.special if point.type == "MAX")
    drawn = [("q", "max"), ("q", "min"), ("v", "max")]  # in figures of what has the extremum
    marked = ["MAX" in {mark.type for mark in marks_of(diagram.branches[0], *of)} for of in drawn]
    assert marked == [True, False, False]
    fine = sf.Settings(steps=sf.Steps(largest=0.05))
    branch = sf.response(model_named("duffing"), "W", (0.9, 1.27), settings=fine).branches[0]
    highest = int(branch.extrema_of("q").maximum.argmax())
    near = slice(highest - 3, highest + 4)
    height = np.polynomial.Polynomial.fit(
        branch.arclength[near], branch.extrema_of("q").maximum[near, 0], 6
    )
    value = np.polynomial.Polynomial.fit(branch.arclength[near], branch.parameter[near], 6)
    ends = branch.arclength[highest - 1], branch.arclength[highest + 1]
    at = minimize_scalar(
        lambda s: -height(s), bounds=ends, method="bounded", options={"xatol": 1e-9}
    )
    assert value(at.x) == pytest.approx(peak.value, abs=1e-8)
    assert height(at.x) == pytest.approx(peak.orbit.extrema.of("q")[1][0], abs=1e-9)


def amplitude_of_van_der_pol(mu):
    def rates(t, y):
        return [y[1], mu * (1 - y[0] ** 2) * y[1] - y[0]]

    def turns(t, y):
        return y[1]

    exact = {"rtol": 1e-12, "atol": 1e-13, "method": "DOP853"}
    settled = solve_ivp(rates, (0, 40), [2.02, 0], **exact).y[:, -1]
    return np.abs(solve_ivp(rates, (0, 12), settled, events=turns, **exact).y_events[0][:, 0]).max()


def test_largest_amplitude_of_the_van_der_pol_cycle():
    model = model_named("vanderpol-free")
    cycle = sf.periodic_orbit(model.replace(mu=2.5))
    (peak,) = extrema(cycle, "mu", (2.5, 4), sf.Event("x"))
    assert peak.type == "MAX"
    at, beside = amplitude_of_van_der_pol(peak.value), 0.3
    assert peak.orbit.extrema.of("x")[1] == pytest.approx(at, abs=1e-10)
    low, high = (amplitude_of_van_der_pol(peak.value + gap) for gap in (-beside, beside))
    assert max(low, high) < at
    # By a parabola through amplitudes on both sides; the third derivative enters with the square.
    vertex = 0.5 * beside * (low - high) / (low - 2 * at + high)
    assert abs(vertex) < 0.05


def test_largest_equilibrium():
    model = sf.System(name="hump", parameters={"p": 0.2}, states={"x": "p/(1 + p^2) - x"})
    (peak,) = extrema(model, "p", (0.2, 3), sf.Event("x"))
    assert (peak.type, peak.value) == ("MAX", pytest.approx(1, abs=1e-11))


@pytest.mark.parametrize("output", ["x", pytest.param("v", marks=pytest.mark.long)])
def test_peak_of_an_orbit_that_sticks(output):
    (peak,) = extrema(DRY, "W", (0.9, 1.1), sf.Event(output), settled=True)
    assert peak.type == "MAX"

    def amplitude(gap):
        orbit = sf.periodic_orbit(DRY.replace(W=peak.value + gap), state=peak.state)
        return orbit.extrema.of(output)[1][0]

    step = 1e-3
    low, at, high = map(amplitude, (-step, 0.0, step))
    assert max(low, high) < at
    assert abs(0.5 * step * (low - high) / (low - 2 * at + high)) < 1e-5


def test_an_extremum_ends_the_branch_where_requested():
    diagram = sf.response(LINEAR, "W", (0.6, 1.6), events=[sf.Event("x", stop=True)])
    (branch,) = diagram.branches
    assert branch.stopped.kind == "event"
    assert branch.stopped.reason == "stopped as requested: max of x is at an extremum"
    assert branch.parameter[-1] == pytest.approx(np.sqrt(1 - 2 * DAMPING**2), abs=1e-12)


def test_extrema_are_saved(tmp_path):
    diagram = sf.response(LINEAR, "W", (0.6, 1.6), events=[sf.Event("x")])
    diagram.save(tmp_path / "peak.nc")
    loaded = sf.load(tmp_path / "peak.nc")
    assert loaded.events == diagram.events
    assert loaded.special[0].point.name == "largest max x"
    assert loaded.summary() == diagram.summary()


def test_a_parameter_without_a_value_is_refused():
    with pytest.raises(sf.InputError, match="event on parameter 'W' has no value; give one"):
        sf.Event("W", measure="parameter")


def test_where_a_motion_with_stick_has_a_mean_is_as_certain_as_said():
    size = sf.periodic_orbit(rubbing(W=0.89)).rms("x")
    diagram = sf.response(DRY, "W", (0.885, 0.895), events=sf.Event("x", size, "rms"))
    (found,) = diagram.branches[0].special
    assert found.value == pytest.approx(0.89, rel=1e-11)
