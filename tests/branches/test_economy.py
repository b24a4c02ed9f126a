"""Few points where nothing happens, and nothing missed for it."""

import numpy as np
import pytest

import slipfold as sf
from slipfold import HarmonicForce, ProportionalDamping, Structure

TONGUES = sf.System(
    name="tongues",
    parameters={"w": 1.0, "z": 0.02, "h": 0.2, "g": 0.1, "F": 0.2},
    states={"q": "v", "v": "F*cos(w*t) - 2*z*v - (1 + h*cos(w*t))*q - g*q^3"},
    forcing={"period": "2*pi/w"},
)
"""A parametric oscillator under a force: multipliers turn many times with the frequency, and
every half turn they may leave the circle for a short while."""

LONG = pytest.mark.long

CASES = [
    # Narrow tongues at the second, third and fourth half turn, on branches that fold as well.
    pytest.param({"z": 0.01134, "h": 0.5361, "g": 0.005694, "F": 0.7773}, (0.25, 2.6), marks=LONG),
    pytest.param({"z": 0.01416, "h": 0.1291, "g": 0.03966, "F": 0.4075}, (2.6, 0.25), marks=LONG),
    pytest.param({"z": 0.00617, "h": 0.4534, "g": 0.008122, "F": 0.2050}, (0.25, 2.6), marks=LONG),
    ({"z": 0.08219, "h": 0.3582, "g": 0.19690, "F": 0.2395}, (2.6, 0.25)),
]


def specials(given, span, largest):
    steps = sf.Steps(largest=largest, points=20000)
    settings = sf.Settings(largest_period=1, steps=steps)
    model = TONGUES.replace(**given)
    (branch,) = sf.response(model, vary="w", span=span, settings=settings).branches
    return [(item.type, item.value) for item in branch.special]


@pytest.mark.parametrize(("given", "span"), CASES)
def test_no_tongue_is_missed_by_long_steps(given, span):
    found = specials(given, span, 0.5)
    expected = specials(given, span, 0.1)
    assert "PD" in [kind for kind, _ in expected]
    assert [kind for kind, _ in found] == [kind for kind, _ in expected]
    assert [value for _, value in found] == pytest.approx([value for _, value in expected])


@pytest.mark.parametrize("size", [1, 4])
@pytest.mark.parametrize("damping", [0.02, 0.3])
def test_a_linear_structure_needs_few_points_however_its_multipliers_turn(size, damping):
    # Between 0.1 and 0.6 Hz the phase of the multipliers makes up to 30 turns; nothing happens.
    stiffness = 100.0 * (2 * np.eye(size) - np.eye(size, k=1) - np.eye(size, k=-1))
    structure = Structure(
        np.eye(size),
        ProportionalDamping(damping, 0.0),
        stiffness,
        forcing=HarmonicForce("q1", F=2.0),
        f=0.1,
    )
    (branch,) = sf.response(structure, vary="f", span=(0.1, 0.6)).branches
    assert branch.special == ()
    assert branch.stopped.kind == "span"
    assert len(branch) < 60
    exact = np.exp(-damping / 2 / branch.parameter)
    assert np.abs(branch.multipliers).max(axis=1) == pytest.approx(exact, rel=1e-8)
    for value, state in zip(branch.parameter, branch.states, strict=True):
        w = 2 * np.pi * value
        matrix = stiffness + (1j * w * damping - w**2) * np.eye(size)
        response = np.linalg.solve(matrix, 2.0 * np.eye(size)[0])
        both = np.concatenate([response, 1j * w * response])
        assert state == pytest.approx(both.real, abs=1e-9)
