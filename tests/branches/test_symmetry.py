"""Branch points at which a symmetry makes two multipliers one: rings of equal cells."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import fsolve

import slipfold as sf


def ring(name, count, parameters, states, couplings):
    """A ring of equal cells: rates of one cell's states, and how neighbors couple each."""
    table = {}
    for i in range(count):
        left, right = (i - 1) % count, (i + 1) % count
        for state, (rate, start) in states.items():
            own = {each: f"{each}{i}" for each in states}
            coupled = f"({state}{left} + {state}{right} - 2*{state}{i})"
            text = f"{rate.format(**own)} + {couplings[state]}*{coupled}"
            table[f"{state}{i}"] = {"rate": text, "start": start}
    return sf.System({"name": name, "parameters": parameters, "states": table})


@pytest.fixture(scope="module")
def three():
    """u' = m u + u^2 - u^3 with coupling k: the modes that are not uniform grow from m = 3 k on."""
    model = ring(
        "three cells", 3, {"m": -0.5, "k": 0.3}, {"u": ("m*{u} + {u}^2 - {u}^3", 0.0)}, {"u": "k"}
    )
    return sf.response(model, "m", (-0.5, 1.5))


@pytest.fixture(scope="module")
def four():
    """Four Brusselators: the determinant of the first modes, 2.2 - B, is zero twice at B = 2.2."""
    states = {"a": ("1 - (B + 1)*{a} + {a}^2*{b}", 1.0), "b": ("B*{a} - {a}^2*{b}", 1.5)}
    model = ring("four cells", 4, {"B": 1.2, "k": 0.05}, states, {"a": "k", "b": "10*k"})
    return sf.response(model, "B", (1.2, 2.6), settings=sf.Settings(largest_period=0))


@pytest.mark.parametrize(("rings", "value"), [("three", 0.9), ("four", 2.2)])
def test_a_double_multiplier_one_is_a_branch_point(rings, value, request):
    trivial = request.getfixturevalue(rings).branches[0]
    (point,) = (point for point in trivial.special if point.type == "BP" and point.several)
    assert point.value == pytest.approx(value, abs=1e-12)
    assert abs(point.value - value) <= point.uncertainty < 1e-10
    assert "several multipliers" in point.outcome
    assert trivial.stopped.kind == "span"


def born(diagram):
    """Branches that leave the first one in one direction."""
    children = (item for item in diagram.branches if item.parent == 1)
    return [item for item in children if item.started.kind == "bifurcation"]


def test_both_branches_of_three_cells_leave_it(three):
    own = born(three)
    assert len(own) == 2
    for branch in own:  # two cells are equal, the third is not
        states = np.sort(branch.states[-1])
        assert np.diff(states).min() < 1e-9 < np.diff(states).max()
    folds = [point.value for branch in own for point in branch.special if point.type == "LP"]
    assert folds == pytest.approx([fold_of_three()], abs=1e-11)


def fold_of_three(k=0.3):
    """Solve for the fold of a = b, c by the determinant of the two equations."""

    def equations(unknown):
        a, c, m = unknown
        slopes = [m + 2 * u - 3 * u**2 for u in (a, c)]
        return [
            m * a + a**2 - a**3 + k * (c - a),
            m * c + c**2 - c**3 + 2 * k * (a - c),
            (slopes[0] - k) * (slopes[1] - 2 * k) - 2 * k**2,
        ]

    return fsolve(equations, [-0.083, 0.166, 0.865], xtol=1e-14)[2]


def test_two_kinds_of_branches_leave_four_cells(four):
    own = born(four)
    kinds = set()
    for branch in own:
        cells = branch.states[len(branch) // 2, ::2]
        equal = sum(abs(cells[i] - cells[j]) < 1e-7 for i in range(4) for j in range(i))
        kinds.add(equal)
    assert len(own) == 2
    assert kinds == {1, 2}  # opposite cells are equal, or neighbors are, pair by pair


@pytest.mark.parametrize("frequency", [1.7, 2.0])
def test_cycles_of_both_pairs_begin_where_two_cross_at_once(frequency):
    # Two oscillators, not coupled: radius sqrt(mu) in either, the other at rest.
    w = frequency
    pair = sf.System(
        name="pair",
        parameters={"mu": -0.5},
        states={
            "x": "mu*x - y - x*(x^2 + y^2)",
            "y": "x + mu*y - y*(x^2 + y^2)",
            "u": f"mu*u - {w}*v - u*(u^2 + v^2)",
            "v": f"{w}*u + mu*v - v*(u^2 + v^2)",
        },
    )
    rest, *cycles = sf.response(pair, "mu", (-0.5, 0.5)).branches
    (hopf,) = rest.special
    assert (hopf.type, hopf.several, hopf.criticality) == ("HB", True, None)
    assert [each.durations[-1] for each in cycles] == pytest.approx([2 * np.pi / w, 2 * np.pi])
    sizes = [np.linalg.norm(each.nodes[-1, 0].reshape(2, 2), axis=1) for each in cycles]
    assert sizes[0] == pytest.approx([0, np.sqrt(0.5)], abs=1e-9)
    assert sizes[1] == pytest.approx([np.sqrt(0.5), 0], abs=1e-9)


def three_cells(m, c):
    """x'' = (m - x^2) x' - x + c (y + z - 2 x), and so in turn."""
    force = "(m - {0}^2)*{0}v - {0} + c*({1} + {2} - 2*{0})"
    states = {f"{cell}v": force.format(cell, *sorted(set("xyz") - {cell})) for cell in "xyz"}
    return sf.System(parameters={"m": m, "c": c}, states={**{c: f"{c}v" for c in "xyz"}, **states})


def parting(last):
    """Cells that swing alike, and how they part where two multipliers are one."""
    alike, settings = {"x": 2.0, "y": 2.0, "z": 2.0}, sf.Settings(largest_period=1)
    return sf.response(three_cells(1, 0.5), "c", (0.5, last), start=alike, settings=settings)


def test_of_ways_that_alike_cells_part_images_are_not_followed():
    first, *others = parting(0.12).branches
    (point,) = first.special
    assert (point.type, point.images, len(others)) == ("BP", 4, 2)
    for branch in others:  # one cell differs from two
        cells = branch.states[-1, :3]
        assert sum(abs(cells - np.roll(cells, 1)) < 1e-7) == 1


@pytest.mark.long
def test_ways_that_alike_cells_part_are_followed_until_they_meet_again():
    first, *others = parting(-0.25).branches
    value = first.special[0].value
    assert {branch.stopped.kind for branch in (first, *others)} == {"span", "closed"}
    ways = [branch for branch in others if abs(branch.parameter[0] - value) < 1e-12]
    assert len(ways) == 2
    for branch in ways:  # one curve, either way round
        assert branch.parameter[-1] == pytest.approx(value, abs=1e-12)
        assert [item.type for item in branch.special if item.type == "LP"] == ["LP", "LP"]
    # What crosses it leads to two cells that swing against each other while one is at rest
    (against,) = (
        branch
        for branch in others
        if min(branch.parameter[[0, -1]]) == -0.25 and np.abs(branch.states[-1, :3]).min() < 1e-9
    )
    end = int(against.parameter.argmax())
    assert against.parameter[end] == 0.5
    assert against.durations[end] == pytest.approx(van_der_pol(2.5), rel=1e-9)


def van_der_pol(stiffness):
    """Duration of the cycle of x'' = (1 - x^2) x' - stiffness x, by SciPy."""

    def turns(t, y):
        return y[1]

    turns.direction = -1
    rates = lambda t, y: (y[1], (1 - y[0] ** 2) * y[1] - stiffness * y[0])  # noqa: E731
    found = solve_ivp(rates, (0, 100), (2, 0), "DOP853", events=turns, rtol=1e-12, atol=1e-13)
    return np.diff(found.t_events[0])[-1]


def test_cells_that_swing_alike_are_followed_where_all_pairs_cross_at_once():
    # x'' = (m - x^2) x' - x + 0.2 (y + z - 2 x): all damping vanishes at m = 0, where the pair of
    # alike cells has the frequency 1 and two more have 1.6^(1/2).
    diagram = sf.response(three_cells(-0.5, 0.2), vary="m", span=(-0.5, 0.2))
    (onset,) = diagram.branches[0].special
    assert (onset.type, onset.value) == ("HB", pytest.approx(0, abs=1e-12))
    assert "of pairs that have one frequency, cycles are followed" in onset.undecided
    wave, alike = diagram.branches[1], diagram.branches[-1]
    assert wave.stopped.kind == alike.stopped.kind == "span"
    assert np.ptp(alike.states[-1, :3]) < 1e-9
    # The other pairs begin a wave round the cells, a third of its duration from one to the next

    def rates(t, s):
        return [*s[3:], *((0.2 - s[:3] ** 2) * s[3:] - s[:3] + 0.2 * (s[:3].sum() - 3 * s[:3]))]

    start = wave.states[-1]
    third = (0, wave.durations[-1] / 3)
    end = solve_ivp(rates, third, start, "DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
    turned = [np.roll(start.reshape(2, 3), way, axis=1).ravel() for way in (1, -1)]
    assert min(np.abs(end - one).max() for one in turned) < 1e-9
    assert bool(wave.stable[-1])
