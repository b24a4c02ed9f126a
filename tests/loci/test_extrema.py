"""Loci of extrema in two parameters: peaks of resonances at several levels, best dampers."""

import numpy as np
import pytest
from tests.helpers.dry_friction import rubbing

import slipfold as sf
from slipfold.models.registry import model_named

LINEAR = sf.System(
    name="linear oscillator",
    parameters={"W": 0.6, "F": 1.0, "D": 0.1},
    states={"x": "v", "v": "F*cos(W*t) - 2*D*v - x"},
    forcing={"period": "2*pi/W", "amplitude": "F"},
)

DAMPER = sf.System(
    name="damper on a spring",
    parameters={"W": 0.8, "c": 0.2, "k": 0.5},
    states={"x": "v", "v": "cos(W*t) - x - k*(x - y)", "y": "k*(x - y)/c"},
    forcing={"period": "2*pi/W"},
)


def peaks(model, vary, span, output="x", measure="max", **options):
    diagram = sf.response(model, vary, span, events=[sf.Event(output, None, measure)], **options)
    return [point for _, point in diagram.special if point.type == "MAX"]


def ridge(model, vary, span, plane, window, output="x", measure="max"):
    (point,) = peaks(model, vary, span, output, measure)
    diagram = sf.locus(point, plane, window)
    (locus,) = diagram.loci
    assert (locus.type, locus.quantity) == ("MAX", f"{measure} {output}")
    assert diagram.checked.agree
    return diagram


@pytest.mark.parametrize(
    ("measure", "output", "peak", "height"),
    [
        ("max", "x", np.sqrt(0.98), 5 / np.sqrt(0.99)),
        pytest.param("rms", "v", 1.0, 5 / np.sqrt(2), marks=pytest.mark.long),
        pytest.param("harmonic", "v", 1.0, 5.0, marks=pytest.mark.long),
    ],
)
def test_peaks_of_a_linear_oscillator_lie_on_a_straight_line(measure, output, peak, height):
    plane = (0.6, 1.4), ("W", "F"), ((0.6, 1.4), (0.2, 3))
    (locus,) = ridge(LINEAR, "W", *plane, output, measure).loci
    frequency, force = locus.values.T
    assert frequency == pytest.approx(peak, abs=1e-12)
    assert locus.measured == pytest.approx(force * height, rel=1e-11)
    assert {end.kind for end in locus.ends} == {"window"}


def test_the_peak_goes_to_zero_frequency_as_damping_grows():
    (locus,) = ridge(LINEAR, "W", (0.6, 1.4), ("D", "W"), ((0.05, 0.9), (0.2, 1.4))).loci
    damping, frequency = locus.values.T
    assert frequency == pytest.approx(np.sqrt(1 - 2 * damping**2), abs=1e-11)
    assert locus.measured == pytest.approx(0.5 / damping / np.sqrt(1 - damping**2), rel=1e-10)


def test_ridge_of_a_bent_resonance_has_the_peaks_of_responses():
    window = ((0.5, 1.6), (0.02, 0.3))
    (locus,) = ridge(model_named("duffing"), "W", (0.6, 1.3), ("W", "F"), window, "q").loci
    for index in (2, len(locus) - 2):
        orbit = locus.orbit(index)
        (again,) = peaks(orbit, "W", (0.5, 1.6), "q")
        assert again.value == pytest.approx(locus.values[index, 0], abs=1e-11)
    # Of little damping the peaks lie on the backbone, W = 1 + 3/8 g a^2 to first order.
    small = locus.measured.argmin()
    amplitude, frequency = locus.measured[small], locus.values[small, 0]
    damped = np.sqrt(1 - 0.05**2 / 2)
    assert frequency - damped == pytest.approx(3 / 8 * 0.1 * amplitude**2, rel=0.02)


def test_best_damper_on_a_spring():
    # All responses pass W^2 = 1 + k/2 with the amplitude 2/k: the least peak lies there.
    window = ((0.7, 1.5), (0.15, 6))
    (point,) = peaks(DAMPER, "W", (0.7, 1.5))
    diagram = sf.locus(point, ("W", "c"), window)
    (best,) = (point for _, point in diagram.special if point.name == "smallest max x")
    assert best.type == "MIN"
    assert best.values[0] == pytest.approx(np.sqrt(1.25), abs=max(1e-10, 10 * best.uncertainty[0]))
    assert best.orbit.extrema.of("x")[1] == pytest.approx(4, rel=1e-11)
    assert max(best.uncertainty) < 1e-8
    # |x|^2 has an extremum along W there: a quadratic equation for c.
    assert slope_of_receptance(*best.values) == pytest.approx(0, abs=1e-7)


def slope_of_receptance(frequency, damping, k=0.5, step=1e-5):
    def size(w):
        link = 1j * w * damping * k / (k + 1j * w * damping)
        return abs(1 / (1 - w * w + link))

    return (size(frequency + step) - size(frequency - step)) / (2 * step)


def test_ridge_of_cycles():
    # With b x^2 for x^2 all amplitudes are divided by the root of b.
    model = sf.System(
        name="scaled",
        parameters={"mu": 2.5, "b": 1.0},
        states={"x": "v", "v": "mu*(1 - b*x^2)*v - x"},
    )
    (point,) = peaks(sf.periodic_orbit(model), "mu", (2.5, 4))
    (locus,) = sf.locus(point, ("mu", "b"), ((2.5, 4), (0.5, 2))).loci
    assert locus.values[:, 0] == pytest.approx(point.value, abs=1e-8)
    height = locus.measured * np.sqrt(locus.values[:, 1])
    assert height == pytest.approx(point.orbit.extrema.of("x")[1][0], rel=1e-10)


def test_ridge_of_equilibria():
    model = sf.System(name="hump", parameters={"p": 0.2, "q": 1.0}, states={"x": "p/(q + p^2) - x"})
    window = ((0.1, 3), (0.1, 4))
    (locus,) = ridge(model, "p", (0.2, 3), ("p", "q"), window).loci
    assert locus.values[:, 0] == pytest.approx(np.sqrt(locus.values[:, 1]), abs=1e-10)
    assert locus.measured == pytest.approx(0.5 / locus.values[:, 0], abs=1e-10)
    assert not peaks(model, "p", (0.2, 3), "x", "harmonic")  # of rest it is zero


def test_ridge_of_orbits_that_stick():
    (point,) = peaks(rubbing(W=0.9), "W", (0.9, 1.1), settled=True)
    (locus,) = sf.locus(point, ("W", "mu"), ((0.8, 1.1), (0.45, 0.6))).loci
    assert len(locus) > 2
    assert np.ptp(locus.values[:, 1]) == pytest.approx(0.15, rel=1e-9)
    (again,) = peaks(locus.orbit(len(locus) - 1), "W", (0.9, 1.1))
    assert again.value == pytest.approx(locus.values[-1, 0], abs=1e-7)


def test_a_ridge_is_saved_and_drawn(tmp_path):
    diagram = ridge(LINEAR, "W", (0.6, 1.4), ("W", "F"), ((0.6, 1.4), (0.2, 3)))
    diagram.save(tmp_path / "ridge.nc")
    loaded = sf.load(tmp_path / "ridge.nc")
    assert loaded.loci[0].quantity == "max x"
    np.testing.assert_array_equal(loaded.loci[0].measured, diagram.loci[0].measured)
    assert loaded.summary() == diagram.summary()
    assert "largest max x of period 1" in diagram.summary()
    assert list(diagram.to_dataframe()["measured"]) == list(diagram.loci[0].measured)
    assert diagram.plot().get_lines()


def test_a_plane_without_the_parameter_of_the_branch_is_refused():
    (point,) = peaks(LINEAR, "W", (0.6, 1.4))
    with pytest.raises(sf.InputError, match="the MAX is an extremum along W, which the plane of F"):
        sf.locus(point, ("F", "D"), ((0.5, 2), (0.05, 0.2)))


JOINT = sf.System(
    name="joint",
    parameters={"W": 0.9, "F": 0.02},
    states={"x": "v", "v": "F*cos(W*t) - x - 0.06*v + 0.0356*v^3 - 0.0064*v^5"},
    forcing={"period": "2*pi/W", "amplitude": "F"},
)


def test_isolas_lie_on_the_ridge():
    (point,) = peaks(JOINT, "W", (0.9, 1.1))
    level = sf.Event("F", 0.032, "parameter")
    window = ((0.9, 1.1), (0.005, 0.06))
    diagram = sf.locus(point, ("W", "F"), window, events=[level])
    turns = {point.name: point for _, point in diagram.special if "F" in point.name}
    # One harmonic: F = c1 a - 3/4 c3 a^3 + 5/8 c5 a^5 is extremal at two amplitudes.
    c1, c3, c5 = 0.06, 0.0356, 0.0064
    squares = np.sort(np.roots([25 / 8 * c5, -9 / 4 * c3, c1]))
    for name, square in zip(("largest F", "smallest F"), squares, strict=True):
        force = (c1 - 3 / 4 * c3 * square + 5 / 8 * c5 * square**2) * np.sqrt(square)
        assert turns[name].values[1] == pytest.approx(force, rel=2e-3)
        assert max(turns[name].uncertainty) < 1e-10
    # Where the force turns the peak does not count as one.
    assert "max x" not in {point.name.split(maxsplit=1)[-1] for _, point in diagram.special}
    assert "direction of a parameter changes" not in diagram.summary()
    highest = diagram.loci[0].special[-1]
    assert highest.measured == pytest.approx(highest.orbit.extrema.of("x")[1][0], rel=1e-12)
    assert diagram.summary().splitlines()[2].split()[-2:] == ["max", "x"]
    orbits = [point.orbit for _, point in diagram.special if point.type == "EVENT"]
    assert [orbit.model.values["F"] for orbit in orbits] == [0.032] * 3
    whole = sf.response(JOINT, "W", (0.9, 1.1), F=0.032, also=orbits)
    response, isola = whole.branches
    assert (response.stopped.kind, isola.stopped.kind) == ("span", "closed")
    assert [point.type for point in isola.special] == ["LP", "LP"]
    top, bottom = (float(orbits[i].extrema.of("x")[1][0]) for i in (2, 1))
    height = isola.extrema_of("x").of("x")[1]
    assert bottom - 1e-9 <= height.min() < height.max() <= top + 1e-9


def test_a_peak_has_gradients():
    (point,) = peaks(LINEAR, "W", (0.6, 1.4))
    found = sf.gradients(point)
    assert found["D"] == pytest.approx(-2 * 0.1 / np.sqrt(0.98), rel=1e-6)
    assert found["F"] == pytest.approx(0, abs=1e-10)


def test_events_on_a_locus_of_folds():
    folds = sf.response(model_named("duffing"), "W", (0.5, 1.8)).special
    level, height = sf.Event("F", 0.2, "parameter"), sf.Event("q", 3.0)
    window = ((0.5, 1.8), (0.1, 0.25))
    diagram = sf.locus(folds[0], ("W", "F"), window, events=[level, height], switch=False)
    (at,) = (point for _, point in diagram.special if point.name == "parameter F = 0.2")
    again = sf.response(model_named("duffing"), "W", (0.5, 1.8), F=0.2).special[0].point
    assert at.values[0] == pytest.approx(again.value, abs=1e-11)
    (high,) = (point for _, point in diagram.special if point.name == "max q = 3")
    assert high.orbit.extrema.of("q")[1] == pytest.approx(3, abs=1e-9)


def test_events_on_loci_are_checked():
    (point,) = peaks(LINEAR, "W", (0.6, 1.4))
    window = ((0.6, 1.4), (0.2, 3))
    with pytest.raises(sf.InputError, match="event on parameter 'D' cannot occur"):
        sf.locus(point, ("W", "F"), window, events=[sf.Event("D", 0.1, "parameter")])
    with pytest.raises(sf.InputError, match="events are located on loci from special points"):
        sf.locus(LINEAR, ("W", "F"), window, events=[sf.Event("x")])
