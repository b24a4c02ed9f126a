"""Cycles on their way to a homoclinic orbit: through growing durations, and a clear end."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, root

import slipfold as sf

UNDOUBLED, DOUBLED = sf.Settings(largest_period=1), sf.Settings(largest_period=2)

SLOPE = -0.1
"""The normal form of Bogdanov and Takens at b = SLOPE has a Hopf point at p = 0."""


def bogdanov_takens(sign):
    return sf.System(
        name="bogdanov-takens",
        parameters={"p": 0.0, "b": SLOPE, "s": float(sign)},
        states={
            "x": {"rate": "y", "scale": 0.1, "start": 0.002},
            "y": {"rate": "p + b*x + x^2 + s*x*y", "scale": 0.03, "start": 0.0},
        },
    )


def homoclinic_value(sign):
    """Where the saddle's unstable manifold returns as its stable one, by SciPy."""

    def gap(p):
        saddle = (-SLOPE + np.sqrt(SLOPE**2 - 4 * p)) / 2

        def rates(_, q):
            return [q[1], p + SLOPE * q[0] + q[0] ** 2 + sign * q[0] * q[1]]

        def crossing(_, q):
            return q[1]

        crossing.terminal = True
        matrix = [[0.0, 1.0], [SLOPE + 2 * saddle, sign * saddle]]
        values, vectors = np.linalg.eig(matrix)
        ends = []
        for order, end in ((values.argmax(), 1000.0), (values.argmin(), -1000.0)):
            start = [saddle, 0.0] - 1e-6 * vectors[:, order] * np.sign(vectors[0, order])
            run = solve_ivp(
                rates, (0, end), start, "DOP853", rtol=1e-12, atol=1e-14, events=crossing
            )
            ends.append(run.y[0, -1])
        return ends[0] - ends[1]

    return brentq(gap, -0.0030, -0.0015, xtol=1e-14)


@pytest.mark.parametrize("sign", [1, -1])
def test_cycles_arrive_at_the_homoclinic_orbit(sign):
    model = bogdanov_takens(sign)
    cycles = sf.response(model, vary="p", span=(0.0005, -0.003), settings=UNDOUBLED).branches[1]
    assert cycles.stopped.kind == "homoclinic"
    assert "homoclinic" in cycles.stopped.reason
    assert cycles.special == ()
    assert len(cycles) < 60
    assert cycles.stopped.value == pytest.approx(homoclinic_value(sign), abs=1e-9)
    # Far enough from the end the parameter falls with the saddle's rate as the duration grows:
    # the distance goes like exp(-rate T), with the eigenvalue nearer zero.
    saddle = (-SLOPE + np.sqrt(SLOPE**2 - 4 * cycles.stopped.value)) / 2
    trace, square = sign * saddle, SLOPE + 2 * saddle
    rate = min(abs(trace / 2 + np.sqrt(trace**2 / 4 + square) * np.array([1, -1])))
    late = (cycles.durations > 60) & (cycles.durations < 75)
    slope = np.polyfit(
        cycles.durations[late], np.log(cycles.parameter[late] - cycles.stopped.value), 1
    )[0]
    assert slope == pytest.approx(-rate, rel=0.02)


@pytest.mark.long
@pytest.mark.parametrize(("longest", "count"), [(2.8, 2), (100.0, 6)])
def test_shooting_and_collocation_agree_within_their_uncertainties(longest, count):
    folds = {}
    for method in ("automatic", "collocation"):
        settings = sf.Settings(largest_period=1, largest_duration=longest, discretization=method)
        diagram = sf.response(sf.System(CHUA), vary="alpha", span=(6.5, 12), settings=settings)
        found = [item for item in diagram.branches[1].special if item.type == "LP"]
        folds[method] = found[:count]
        assert len(folds[method]) == count
    for shot, other in zip(*folds.values(), strict=True):
        assert abs(shot.value - other.value) <= shot.uncertainty + other.uncertainty
        # Errors of the mesh, which large multipliers magnify, are said.
        apart = np.abs(other.multipliers[:, None] - shot.multipliers).min(axis=1)
        assert (apart <= other.multiplier_uncertainty + shot.multiplier_uncertainty.max()).all()
        assert shot.uncertainty < 1e-12 < other.uncertainty < 1e-4


def test_lorenz_cycles_end_where_they_are_homoclinic():
    # rho = 13.926557 (Sparrow 1982): the cycles that emanate at the Hopf point 24.74.
    given = {"vary": "rho", "start": {"x": 7, "y": 7, "z": 19}, "settings": UNDOUBLED}
    lorenz = sf.built_in_models()["lorenz"]()
    cycles = sf.response(lorenz, span=(20, 26), **given).branches[1]
    assert cycles.stopped.kind == "span"
    cycles = sf.response(lorenz, span=(10, 26), **given).branches[1]
    assert "nears a homoclinic orbit" in cycles.stopped.reason
    assert cycles.stopped.value == pytest.approx(13.926557, abs=1e-3)
    assert cycles.special == ()
    assert len(cycles) < 80


def test_a_loop_through_two_saddles_is_no_homoclinic_orbit():
    # Allee: (n, p) = (0.1, 0) and (1, 0) are saddles where 0.1 < m < 1.
    states = {"n": "n*(n - 0.1)*(1 - n) - n*p", "p": "p*(n - m)"}
    predators = sf.System(parameters={"m": 0.6}, states=states)
    _, cycles = sf.response(predators, "m", (0.6, 0.4), start={"n": 0.6, "p": 0.1}).branches
    assert cycles.stopped.kind == "heteroclinic"
    assert "nears a heteroclinic loop: orbits that connect 2 saddles" in cycles.stopped.reason
    assert cycles.orbit(-1).extrema.of("n")[0] == pytest.approx(0.1, abs=1e-6)


@pytest.mark.long
def test_a_doubled_cycle_nears_three_saddles_as_its_parent_does():
    # Halvorsen's system: perturbations grow by 1e5 in an eighth of the doubled cycle.
    rate = "-a*{0} - 4*{1} - 4*{2} - {1}^2".format
    states = {"x": rate(*"xyz"), "y": rate(*"yzx"), "z": rate(*"zxy")}
    halvorsen = sf.System(parameters={"a": 2.1}, states=states)
    given = {"start": {"x": -2.1, "y": -1.5, "z": 0}, "settled": True}
    diagram = sf.response(halvorsen, "a", (2.1, 2.12), **given, settings=DOUBLED)
    assert [own.period for own in diagram.branches if "3 saddles" in own.stopped.reason] == [1, 2]


def test_one_saddle_a_turn_apart_is_one():
    rates = {"x": {"rate": "v", "angle": True}, "v": "-sin(x) - 0.2*v*(v^2/2 - cos(x) - c)"}
    pendulum = sf.System(parameters={"c": 0.5}, states=rates)
    (cycles,) = sf.response(pendulum, "c", (0, 1.3), start={"x": 1, "v": 1}, settled=True).branches
    assert cycles.stopped.value == pytest.approx(1, abs=1e-3)
    assert "nears a homoclinic orbit" in cycles.stopped.reason


CHUA = {
    "name": "Chua",
    "parameters": {"alpha": 6.5, "beta": 14.3, "K": 10, "a0": -1 / 7, "a1": 2 / 7},
    "formulas": {
        "up": "2*(x + 1)*atan(K*(x + 1))/pi",
        "down": "2*(x - 1)*atan(K*(x - 1))/pi",
        "h": "a1*x + (a0 - a1)*(up - down)/2",
    },
    "states": {
        "x": {"rate": "alpha*(y - h)", "start": 1.5},
        "y": "x - y + z",
        "z": {"rate": "-beta*y", "start": -1.5},
    },
}
"""Chua's circuit as in AUTO-07p's demo chu."""


def assert_each_turn_is_a_fold(branch):
    values = branch.parameter
    steps = np.diff(values)
    turns = np.flatnonzero(steps[:-1] * steps[1:] < 0) + 1
    folds = [item.value for item in branch.special if item.type == "LP"]
    for i in turns:  # of the same side of the swing, and no farther out than the fold
        assert any(
            min(abs(values[i] - fold), 1e-9) <= 1e-9 + abs(values[i + 1] - values[i - 1])
            and (fold - values[i]) * (values[i] - values[i - 1]) >= 0
            for fold in folds
        )
    assert len(folds) >= len(turns)


def test_every_turn_of_a_branch_that_snakes_is_a_fold():
    diagram = sf.response(sf.System(CHUA), vary="alpha", span=(6.5, 16), settings=UNDOUBLED)
    cycles = diagram.branches[1]
    assert_each_turn_is_a_fold(cycles)
    turns = [item for item in cycles.special if item.type == "LP"]
    folds = [item.value for item in turns]
    assert len(folds) >= 6
    # One multiplier besides that of the flow is one at each, to within its uncertainty.
    for count, fold in enumerate(turns, 1):
        critical = np.argsort(np.abs(fold.multipliers - 1))[1]
        uncertainty = fold.multiplier_uncertainty[critical]
        assert np.abs(fold.multipliers[critical] - 1) <= uncertainty
        assert uncertainty < 1e-2 or count > 5
    # Each turn is shorter by the same factor (Kuznetsov, section 6.4), as far as digits reach.
    apart = np.abs(np.diff(folds[:6]))
    assert apart[2:] / apart[1:-1] == pytest.approx(apart[2] / apart[1], abs=0.05)
    assert cycles.stopped.kind == "homoclinic"
    assert "is not followed" in cycles.stopped.reason
    assert len(cycles) < 200


@pytest.mark.long
def test_the_symmetric_branch_of_a_circuit_turns_nine_times():
    # AUTO-07p on its demo tor: LP at nu = -0.796906, where a branch point lies 5e-4 away.
    circuit = sf.built_in_models()["freire"]()
    diagram = sf.response(circuit, vary="n", span=(-0.9, -0.55), settings=UNDOUBLED)
    cycles = diagram.branches[1]
    assert_each_turn_is_a_fold(cycles)
    folds = [item.value for item in cycles.special if item.type == "LP"]
    assert len(folds) >= 9  # the next is 3e-6 away, where digits decide
    assert folds[4] == pytest.approx(-0.796906, abs=5e-6)
    crossings = [item.value for item in cycles.special if item.type == "BP"]
    assert crossings[1:] == pytest.approx(folds[1:], abs=1e-4)
    assert not diagram.failed


def bursts(r):
    """Hindmarsh and Rose, Proceedings of the Royal Society B 221 (1984) 87-102."""
    states = {
        "x": {"rate": "y - x^3 + 3*x^2 - z + I", "start": -1.3},
        "y": {"rate": "1 - 5*x^2 - y", "start": -7.0},
        "z": {"rate": f"{r}*(4*(x + 1.6) - z)", "start": 1.0},
    }
    return sf.System(name="bursts", parameters={"I": 0.0}, states=states)


@pytest.mark.long
def test_a_slow_homoclinic_orbit_ends_a_branch_whose_steps_become_short():
    # Multipliers reach 1e61, and two thousand points passed while I changed by 1e-9.
    cycles = sf.response(bursts(0.006), vary="I", span=(0, 5), settings=UNDOUBLED).branches[1]
    assert cycles.stopped.kind == "homoclinic"
    assert cycles.stopped.value == pytest.approx(2.5892034, abs=1e-7)
    assert len(cycles) < 1500


@pytest.mark.long
def test_a_branch_that_snakes_between_two_values_ends():
    # Three thousand points of it turn ever nearer to 5.258626162 and 5.285898737.
    cycles = sf.response(bursts(0.01), vary="I", span=(5.2, 6), settings=UNDOUBLED).branches[1]
    assert_each_turn_is_a_fold(cycles)
    assert cycles.stopped.kind == "homoclinic"
    folds = [item for item in cycles.special if item.type == "LP"][-6:]
    for turns, limit in ((folds[::2], 5.285898737), (folds[1::2], 5.258626162)):
        last, (one, other) = turns[-1].value, np.diff([item.value for item in turns])
        assert last + other**2 / (one - other) == pytest.approx(limit, abs=1e-8)  # Aitken
        # Each turn goes once more round a saddle cycle.
        added = np.diff([item.duration for item in turns])
        assert added[1] == pytest.approx(duration_of_saddle_cycle(limit), abs=np.ptp(added))
        assert f"{last:.7g}, " in cycles.stopped.reason
        assert f"by about {added[1]:.4g} s, " in cycles.stopped.reason


def duration_of_saddle_cycle(value):
    """Return that of a cycle of `bursts(0.01)`, by SciPy."""

    def rates(_, q):
        x, y, z = q
        return [y - x**3 + 3 * x**2 - z + value, 1 - 5 * x**2 - y, 0.01 * (4 * (x + 1.6) - z)]

    def missed(unknown):
        start, time = [*unknown[:2], 6.12], unknown[2]
        run = solve_ivp(rates, (0, time), start, "DOP853", rtol=1e-11, atol=1e-12)
        return run.y[:, -1] - start

    found = root(missed, [-0.285, 0.595, 14.7], tol=1e-10)
    assert found.success
    return found.x[2]
