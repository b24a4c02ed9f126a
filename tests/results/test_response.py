"""Responses computed, not made by hand: the whole way from a model to a loaded result."""

import numpy as np
import pytest

from slipfold import Event, InputError, Settings, SlidingOscillator, System, load, response
from slipfold.models.registry import model_named


@pytest.fixture(scope="module")
def diagram():
    return response(SlidingOscillator(), "Nd", (0, 0.98), f=12.5)


def test_loaded_diagram_can_be_computed_with(diagram, tmp_path):
    diagram.save(tmp_path / "x.nc")
    copy = load(tmp_path / "x.nc")
    orbit = copy.branches[0].orbit(3)
    np.testing.assert_array_equal(orbit.nodes, diagram.branches[0].orbit(3).nodes)
    np.testing.assert_array_equal(orbit.extrema.maximum[0], diagram.branches[0].extrema.maximum[3])


def test_states_along_meshes_are_found_one_orbit_after_the_other_until_interrupted():
    """Of thousands that takes a minute; what is found by then is kept."""
    told, stages = [], []

    def observer(progress):
        stages.append(progress.stage)
        if progress.stage == "orbits":
            told.append((progress.values["branch"], progress.done, progress.total))
            if told[-1][:2] == (1, 5):
                raise KeyboardInterrupt

    settings = Settings(discretization="collocation")
    span = (0.03, 0.05)  # whose period doubling leads to another branch
    diagram = response(SlidingOscillator(), "Nd", span, settings=settings, on_progress=observer)
    (branch,) = diagram.branches
    total = told[0][2]
    assert told == [(1, done, total) for done in range(1, 6)]
    assert len(branch) == 5 < total
    assert diagram.interrupted
    assert stages[-1] == "orbits"  # nothing is checked
    assert branch.stopped.kind == "interrupted"
    assert branch.stopped.value == branch.parameter[-1]
    assert all(point.arclength <= branch.arclength[-1] for point in branch.special)
    assert all(point.leads_to is None for point in branch.special)
    assert np.isfinite(branch.nodes).all()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"vary": "nd"}, "no parameter 'nd'; did you mean Nd"),
        ({"Nd": 0.1}, "Nd is varied, so it cannot be set to 0.1 as well"),
        ({"mu": -1}, "mu must be >= 0"),
        ({"mass": 1}, "no parameter 'mass'"),
        ({"span": 3}, "the span of Nd is 3, which is not a pair of numbers"),
        ({"span": (0, 1, 2)}, "is not a pair of numbers"),
        ({"span": (0, "x")}, "Nd = 'x' is not a number"),
        ({"span": (0, float("nan"))}, "Nd = nan is not a finite number"),
        ({"span": (0.1, 0.1)}, "empty"),
        ({"span": (-0.1, 0.1)}, "Nd must be >= 0 N"),
        ({"span": (1.5, 0.1)}, "Nd = 1.5 N is not below Ns = 1 N"),
        ({"model": "sliding"}, "is not a model"),
        ({"settings": 3}, "settings = 3 are not options of continuation"),
        ({"events": [Event("speed", 1)]}, "speed"),
    ],
)
def test_bad_input(arguments, message):
    given = {"model": SlidingOscillator(), "vary": "Nd", "span": (0, 0.98)} | arguments
    with pytest.raises(InputError, match=message):
        response(**given)


def test_the_table_shows_rounding_as_zero():
    diagram = response(model_named("stuart-landau"), vary="r", span=(-0.5, 0.5))
    cells = [line.split() for line in diagram.summary().splitlines()]
    first, hopf, last = [line for line in cells if line and line[0] == "1"]
    assert [first[6:10], last[6:10]] == [["0"] * 4] * 2
    assert hopf[5:10] == ["0"] * 5


def test_tables_say_how_equilibria_vibrate():
    """The eigenvalues are r + i w; cycles have multipliers."""
    diagram = response(model_named("stuart-landau", w=2.0), vary="r", span=(-0.5, 0.5))
    frame = diagram.to_dataframe()
    rest, moving = (frame[frame["branch"] == number] for number in (1, 2))
    r = rest["r"].to_numpy()
    np.testing.assert_allclose(rest["growth rate 1"], r, atol=1e-12)
    np.testing.assert_allclose(rest["frequency 1"], 1 / np.pi, rtol=1e-12)
    np.testing.assert_allclose(rest["damping ratio 1"], -r / np.hypot(r, 2), atol=1e-12)
    assert frame.attrs["units"]["frequency 1"] == "Hz"
    assert rest["multiplier 1 real"].isna().all()
    assert moving["multiplier 1 real"].notna().all()
    assert moving["frequency 1"].isna().all()
    alone = response(diagram.model, vary="r", span=(-0.5, -0.1)).to_dataframe()
    assert not [name for name in alone if name.startswith("multiplier")]


def test_a_part_of_the_span_without_a_branch_is_reported():
    # The response of the pendulum turns back at a fold; responses beyond it are not connected.
    pendulum = System(
        parameters={"A": 0.9},
        states={"th": "om", "om": "-0.2*om - sin(th) + A*cos(0.66*t)"},
        forcing={"period": "2*pi/0.66"},
    )
    text = response(pendulum, vary="A", span=(0.5, 1.2)).summary()
    assert "No branch was found for A from 0.5144 to 1.2; search=True (--search)" in text
    text = response(pendulum, vary="A", span=(0.1, 0.4)).summary()
    assert "No branch was found" not in text


PLANAR = """
[parameters]
f = { value = 2.0, unit = "Hz", above = 0 }
[states]
x = "vx"
y = "vy"
vx = "Rx - 200*x - 0.8*vx + 2*cos(2*pi*f*t)"
vy = "Ry - 330*y - 0.8*vy + cos(2*pi*f*t)"
[contacts.R]
slip = ["0.3 - vx", "-vy"]
normal = "5"
friction = { law = "Coulomb", mu_s = "0.5", mu_k = "0.4" }
[forcing]
period = "1/f"
"""


@pytest.mark.long
def test_extrema_of_a_planar_graze_continue_those_of_its_neighbors(tmp_path):
    # Slip has no direction there, so nothing integrates the orbit itself.
    diagram = response(System(PLANAR), "f", (2.3, 2.6))
    (branch,) = diagram.branches
    (graze,) = (point for point in branch.special if point.type == "GRAZE")
    nearest = np.abs(branch.parameter - graze.value).argmin()
    reached, beside = graze.orbit.extrema.maximum[0], branch.orbit(nearest).extrema.maximum[0]
    assert reached[:4] == pytest.approx(beside[:4], rel=1e-2)
    assert "nan" not in diagram.summary()
    diagram.save(tmp_path / "x.nc")
    assert load(tmp_path / "x.nc").summary() == diagram.summary()
