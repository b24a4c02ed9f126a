"""Basins of attraction on a plane of initial states."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import slipfold as sf
from helpers.dry_friction import den_hartog
from slipfold.flow.ensembles import released
from slipfold.flow.flow import flow_of

# The hard onset of tests of attractors: rest wins inside the circle of radius 1, else the cycle.
HARD = """
name = "hard onset"
parameters = { w = 1.0 }
[states]
x = { rate = "(x^2 + y^2 - 1)*(2 - x^2 - y^2)*x - w*y", label = "$x$" }
y = "(x^2 + y^2 - 1)*(2 - x^2 - y^2)*y + w*x"
"""


@pytest.fixture(scope="module")
def circle():
    return sf.basins(sf.System.from_toml(HARD), {"x": (-2, 2), "y": (-1, 1)}, points=(40, 20))


def test_the_boundary_is_the_unstable_cycle(circle):
    x, y = np.meshgrid(circle.first, circle.second)
    (rest,) = (item for item in circle if item.kind == "equilibrium")
    assert np.array_equal(circle.labels == rest.id, np.hypot(x, y) < 1)
    assert circle.fraction(rest).value == np.mean(np.hypot(x, y) < 1)
    assert set(np.unique(circle.labels)) == {item.id for item in circle}


def test_cells_that_the_boundary_crosses_are_uncertain(circle):
    # It is the circle of radius 1: a cell is crossed if it lies between its corners and its center.
    corners = [
        np.concatenate([axis[:1], 0.5 * (axis[1:] + axis[:-1]), axis[-1:]])
        for axis in (circle.first, circle.second)
    ]
    inside = np.hypot(*np.meshgrid(*corners)) < 1
    at_corners = inside[1:, 1:] + 0 + inside[1:, :-1] + inside[:-1, 1:] + inside[:-1, :-1]
    center = np.hypot(*np.meshgrid(circle.first, circle.second)) < 1
    crossed = (at_corners + center > 0) & (at_corners + center < 5)
    assert np.array_equal(circle.uncertain == 1, crossed)
    assert not (circle.uncertain == 2).any()
    assert circle.uncertain_fraction() == crossed.mean()
    assert f"the label changes within {100 * crossed.mean():.3g} % of the cells" in circle.summary()
    cell = circle.to_xarray().sel(x=1, y=0, method="nearest")
    assert int(cell.reached) == circle.labels[10, 29]


def test_starts_that_were_not_finished_may_belong_to_any_attractor(circle):
    labels = circle.labels.copy()
    labels[::2] = -2
    part = replace(circle, labels=labels, interrupted=True)
    whole, some = circle.fraction(circle[0]), part.fraction(part[0])
    assert some.value < whole.value
    assert some.low < whole.value < some.high
    assert some.high > 0.5


def test_a_label_within_the_error_of_the_integration_is_uncertain():
    # The boundary between x = -1 and 1 is x = 0, half an error beside the starts in the middle.
    well = sf.System(
        name="well",
        parameters={"T": 1.0},
        states={"x": "x - x^3", "y": "-y + 0*cos(2*pi*t/T)"},
        forcing={"period": "T"},
    )
    found = sf.basins(well, {"x": (-1, 1 + 1e-8), "y": (-1, 1)}, points=(3, 3))
    assert found.uncertain.tolist() == [[0, 2, 0]] * 3
    assert "changes within the error of the integration" in found.summary()


def test_fractal_basins_of_a_pendulum_are_said_to_be():
    # The pendulum of Grebogi, Ott and Yorke, Science 238 (1987) 632, whose boundaries are fractal.
    pendulum = sf.System(
        name="pendulum",
        parameters={"A": 1.66, "b": 0.2},
        states={"a": {"rate": "v", "angle": True}, "v": "-b*v - sin(a) + A*cos(t)"},
        forcing={"period": "2*pi"},
    )
    found = sf.basins(pendulum, {"a": (-3.1, 3.1), "v": (-4, 4)}, points=20)
    assert sorted(item.period for item in found) == [1, 2, 2]
    assert (found.labels > 0).all()
    assert found.uncertain_fraction() > 0.5

    def rates(t, y):
        return [y[1], -0.2 * y[1] - np.sin(y[0]) + 1.66 * np.cos(t)]

    for row, column in ((10, 17), (2, 14), (13, 5), (17, 3)):
        if found.uncertain[row, column]:
            continue
        start = [found.first[column], found.second[row]]
        times = 2 * np.pi * np.array([119, 120])
        motion = solve_ivp(rates, (0, times[-1]), start, t_eval=times, rtol=1e-9, atol=1e-9)
        away = motion.y.T - found[found.labels[row, column] - 1].state
        assert np.hypot(2 * np.sin(away[:, 0] / 2), away[:, 1]).min() < 1e-5


@pytest.mark.long
def test_a_hundred_starts_at_random_are_where_long_motions_end():
    plane, model = {"x": (-0.5, 0.5), "y": (-0.5, 0.5)}, sf.SlidingOscillator(f=12.2, Nd=0.1)
    found = sf.basins(model, plane, points=40)
    for row, column in np.random.default_rng(0).integers(40, size=(100, 2)):
        start = {"x": found.first[column], "y": found.second[row]}
        motion = sf.simulate(model, 600, start)  # by Taylor's method, to 1e-13
        assert motion.settlement.period == found[found.labels[row, column] - 1].period


def test_the_picture_has_a_color_for_each_and_its_share(circle):
    from matplotlib.figure import Figure

    ax = circle.plot(ax=Figure().add_subplot())
    image, marks = ax.images
    colors = image.cmap(image.norm(image.get_array()))
    assert len(np.unique(colors.reshape(-1, 4), axis=0)) == 2
    assert np.array_equal(marks.get_array()[..., 3] > 0, circle.uncertain > 0)
    assert ax.get_xlabel() == "$x$"
    texts = sorted(text.get_text() for text in ax.get_legend().get_texts())
    (rest,) = (item for item in circle if item.kind == "equilibrium")
    assert texts[0] == f"changes within the cell: {100 * circle.uncertain_fraction():.3g} %"
    assert texts[2] == f"equilibrium: {100 * circle.fraction(rest).value:.3g} %"
    left, right, bottom, top = image.get_extent()
    assert (left, right) == pytest.approx((-2 - 2 / 39, 2 + 2 / 39))
    assert (bottom, top) == pytest.approx((-1 - 1 / 19, 1 + 1 / 19))


SHIFTED = """
name = "shifted"
parameters = { W = 1.2, F = 0.2, s = 0 }
forcing = { period = "2*pi/W" }
[states]
x = "v"
v = "F*cos(W*t + s) - 0.1*v - x - 0.25*x^3"
"""
"""Duffing's oscillator in its fold; s is the phase at which its motions begin."""


def test_a_start_released_later_comes_to_what_it_does_under_a_shifted_forcing():
    model = sf.System.from_toml(SHIFTED)
    found = sf.basins(model, {"phase": (0, 1), "x": (-3, 3)}, {"v": 0.5}, points=(5, 6))
    assert len(found) == 2
    assert {*np.unique(found.labels)} == {1, 2}
    # A whole period later all is as before.
    assert found.labels[:, 0].tolist() == found.labels[:, -1].tolist()
    sizes = [item.maximum[0] for item in found]
    for column, phase in enumerate(found.first[:-1]):
        at = model.replace(s=2 * np.pi * phase)
        own = sf.basins(at, {"x": (-3, 3), "v": (0.5, 1.0)}, points=(6, 2))
        shown = [own[label - 1].maximum[0] for label in own.labels[0]]
        assert [sizes[label - 1] for label in found.labels[:, column]] == pytest.approx(shown)


def test_motions_released_in_slip_and_in_stick_are_those_that_come_by():
    model = sf.SlidingOscillator(f=12.5, Nd=0.02)
    flow, start = flow_of(model), np.array([[0.1, 0.05, 0.0, 1.0]])
    constants, none = flow.constants_of(model), np.zeros(1)
    passing, end = (flow.advance(start, none, none + to, constants) for to in (0.4, 1.0))
    found, stops = released(model, np.concatenate([passing, start]), np.array([0.4, 0.0]))
    assert stops == {}
    assert found[0] == pytest.approx(end[0], rel=1e-9, abs=1e-9)
    assert found[1].tolist() == start[0].tolist()
    # Dry friction that holds: nothing moves, whenever it begins.
    found, stops = released(den_hartog(0.5, 10.0), np.array([[2.0, 0.0]]), np.array([0.3]))
    assert stops == {}
    assert found[0] == pytest.approx([2.0, 0.0], abs=1e-12)
