"""Tori of autonomous models, born along their cycles."""

import numpy as np
import pytest

import slipfold as sf
from slipfold.bifurcations.tori.circles import turned
from slipfold.flow.flow import flow_of

LANGFORD = """
name = "langford"
parameters = { c = 0.3, a = 0.6, b = 0.7, d = 3.5, e = 0.25, k = 0 }
[states]
x = { rate = "(z - b)*x - d*y", start = 0.695 }
y = "d*x + (z - b)*y"
z = { rate = "c + a*z - z^3/3 - (x^2 + y^2)*(1 + e*z) + k*z*x^3", start = 0.7 }
"""
"""Without k the phase turns evenly, and radius and z move as in the plane below."""

PLANE = """
name = "plane"
parameters = { c = 0.3, a = 0.6, b = 0.7, e = 0.25 }
[states]
r = "(z - b)*r"
z = "c + a*z - z^3/3 - r^2*(1 + e*z)"
"""

BIRTH = (0.6 - 0.7**2) / 0.25 * (1 + 0.25 * 0.7) - 0.6 * 0.7 + 0.7**3 / 3
"""Where the trace of the plane's equilibrium is zero."""


def tori_of(k, last):
    """Return a diagram of the cycle round the axis from where it is stable on, and its tori."""
    model = sf.System.from_toml(LANGFORD).replace(c=BIRTH + 0.05, k=k)
    radius = np.sqrt((BIRTH + 0.05 + 0.6 * 0.7 - 0.7**3 / 3) / (1 + 0.25 * 0.7))  # without k
    cycle = sf.periodic_orbit(model, state=(radius, 0, 0.7), duration=2 * np.pi / 3.5)
    diagram = sf.response(cycle, vary="c", span=(BIRTH + 0.05, last), tori=True)
    (tori,) = diagram.tori
    return diagram, tori


@pytest.fixture(scope="module")
def even():
    return tori_of(0, BIRTH - 0.05)


@pytest.fixture(scope="module")
def uneven():
    return tori_of(0.3, BIRTH - 0.02)


def test_where_the_phase_decouples_they_are_cycles_of_the_plane(even):
    diagram, tori = even
    assert "Tori 2 of cycles (" in diagram.summary()
    assert tori.parameter[0] == pytest.approx(BIRTH, abs=1e-10)
    assert tori.stopped.kind == "span"
    assert tori.durations == pytest.approx(2 * np.pi / 3.5, abs=1e-12)
    for row in (3, -1):
        x, y, z = tori.circle(row)[0]
        plane = sf.System.from_toml(PLANE).replace(c=float(tori.parameter[row]))
        cycle = sf.periodic_orbit(plane, state=(np.hypot(x, y), z))
        assert tori.rotation[row] == pytest.approx(2 * np.pi / 3.5 / cycle.duration, abs=1e-11)
        assert tori.frequency[row] == pytest.approx(1 / cycle.duration, abs=1e-11)
        reached = cycle.extrema.of("r")[1]
        assert tori.extrema.of("x")[1][row] == pytest.approx(reached, abs=1e-9)
        across = np.log(cycle.multipliers[1].real) * tori.rotation[row]
        assert abs(tori.growth[row] - across) <= tori.growth_error[row]
        assert tori.stable[row]


def test_circles_come_round_onto_themselves(uneven):
    _, tori = uneven
    assert tori.truncation.max() <= 1e-8
    # The phase still turns evenly: only z is pushed.
    assert tori.durations == pytest.approx(2 * np.pi / 3.5, abs=1e-12)
    model, circle = tori.model_at(-1), tori.circle(-1)
    motion = sf.simulate(model, 1, circle[4])
    assert motion.states[1] == pytest.approx(turned(circle, tori.rotation[-1])[4], abs=1e-9)


def test_their_envelope_is_that_of_a_motion(uneven):
    _, tori = uneven
    model = tori.model_at(-1)
    passed = sf.simulate(model, 3000, tori.circle(-1)[0]).states
    flow, zero = flow_of(model), np.zeros(len(passed))
    values = flow.sample(passed, zero, zero + 1, 64, flow.constants_of(model))[:, :, 0].ravel()
    top = values[1:-1].argmax() + 1
    left, peak, right = values[top - 1 : top + 2]
    highest = peak - (right - left) ** 2 / (8 * (left - 2 * peak + right))
    assert tori.extrema.of("x")[1][-1] == pytest.approx(highest, abs=1e-5)


def test_those_of_a_circuit_are_born_unstable():
    model = sf.built_in_models()["freire"]()
    diagram = sf.response(model, vary="n", span=(-0.58, -0.5917), tori=True)
    # -0.5916501950321: the source of the model.
    assert [each.parameter[0] for each in diagram.tori] == pytest.approx([-0.59165019503] * 2)
    for tori in diagram.tori:
        assert tori.stopped.kind == "span"
        assert not tori.stable.any()
        assert tori.durations[0] - tori.durations[-1] > 1e-4
        model, circle = tori.model_at(-1), tori.circle(-1)
        came = sf.simulate(model, 1, circle[4]).states[1]
        assert came == pytest.approx(turned(circle, tori.rotation[-1])[4], abs=1e-8)
        assert (tori.growth[1:] > tori.growth_error[1:]).all()
    # One is the mirror image of the other.
    one, other = (tori.extrema.of("x") for tori in diagram.tori)
    assert one[1][-1] == pytest.approx(-other[0][-1], abs=1e-9)


def test_cycles_without_a_second_frequency_have_none():
    free = sf.built_in_models()["stuart-landau"]()
    assert sf.response(free, vary="r", span=(-0.5, 1), tori=True).tori == ()
