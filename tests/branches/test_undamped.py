"""Without damping all multipliers come in pairs whose product is one: most lie on the circle."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import slipfold as sf
from helpers.long_tests import long_except
from slipfold.continuation.step_length import drift
from slipfold.orbits.shooting import Shooting
from slipfold.orbits.test_functions import evaluate_tests


def duffing(k3: float, force: float = 0.1) -> sf.System:
    return sf.System(
        parameters={"W": 0.5, "F": force},
        states={"q": "v", "v": f"F*cos(W*t) - q - {k3}*q^3"},
        forcing={"period": "2*pi/W", "amplitude": "F"},
    )


def test_pairs_that_stay_on_the_circle_are_no_torus():
    branch = sf.response(duffing(0.3), "W", (1.6, 1.1)).branches[0]
    assert branch.stopped.kind == "span"
    assert [point.type for point in branch.special] == ["LP"]
    assert branch.special[0].uncertainty < 1e-9


def mode(square: str = "3", damping: float = 0.0, names: str = "ab") -> dict[str, str]:
    x, v = names
    return {x: v, v: f"-({square})*{x} - {damping}*{v}"}


def growing(rate: str, names: str = "xv") -> dict[str, str]:
    """Vibrations of frequency sqrt(2) that begin where the rate of their growth is zero."""
    x, v = names
    return {x: v, v: f"({rate})*{v} - 2*{x} - {x}^2*{v}"}


def flipping(growth: str, cubic: int, names: str) -> dict[str, str]:
    """A direction that turns by half a round in a period and grows; what is across it decays."""
    x, y = names
    mean, half = f"(({growth}) - 0.8)/2", f"(({growth}) + 0.8)/2"
    size = f"{cubic}*({x}^2 + {y}^2)"
    return {
        x: f"({mean} - {size})*{x} + {half}*(cos(W*t)*{x} + sin(W*t)*{y}) - W/2*{y}",
        y: f"({mean} - {size})*{y} + {half}*(sin(W*t)*{x} - cos(W*t)*{y}) + W/2*{x}",
    }


FORCED = {"z": "cos(W*t) - z"}
ROUND = {"p": "m*p - q - p*(p^2 + q^2)", "q": "p + m*q - q*(p^2 + q^2)"}

BESIDE = {
    "a mode": (growing("m"), mode(), "HB", [0]),
    "a mode that is damped by rounding": (growing("m"), mode(damping=1e-9), "HB", [0]),
    "a mode that is hardly damped": (growing("m"), mode(damping=1e-7), "HB", [0]),
    "a mode that is hardly damped, forced": (growing("m") | FORCED, mode(damping=1e-7), "NS", [0]),
    "modes": (growing("m"), mode() | mode("7", names="cd"), "HB", [0]),
    "a mode of the same frequency": (growing("m"), mode("2"), "HB", [0]),
    "a mode whose frequency changes": (growing("m"), mode("3 + m"), "HB", [0]),
    "a mode, round a cycle": (ROUND | growing("m - 0.2"), mode(), "NS", [0.2]),
    "a mode, forced": (growing("m") | FORCED, mode(), "NS", [0]),
    "a nonlinear mode, forced": (growing("m") | FORCED, mode("3 + a^2"), "NS", [0]),
    "what flips, forced": (flipping("m", 1, "pq") | FORCED, flipping("0", 0, "ab"), "PD", [0]),
    "half the forcing": (flipping("m", 1, "pq") | FORCED, mode("W^2/4"), "PD", [0]),
    "a mode, two at once": (growing("m") | growing("0.01 - m", "uw"), mode(), "HB", [0, 0.01]),
}


@pytest.mark.parametrize("case", long_except(BESIDE, list(BESIDE)[1::2]))
def test_what_crosses_the_circle_is_seen_beside_what_stays_on_it(case):
    states, standing, kind, values = BESIDE[case]
    forcing = {"forcing": {"period": "2*pi/W"}} if "z" in states else {}
    found = []
    for beside in ({}, standing):
        system = {"parameters": {"m": -0.5, "W": 1.7}, "states": states | beside}
        settings = sf.Settings(largest_period=int("z" in states or "cycle" in case))
        diagram = sf.response(sf.System(system | forcing), "m", (-0.5, 0.5), settings=settings)
        branch = diagram.branches["cycle" in case]
        found.append((diagram, [point for point in branch.special if point.type == kind]))
    (_, alone), (diagram, points) = found
    assert [point.value for point in points] == pytest.approx(values, abs=1e-12)
    assert ("stay on the unit circle on branch" in diagram.summary()) != ("hardly" in case)
    if "same" in case or kind == "PD":  # a family begins there
        assert all(point.several for point in points)
        if kind != "PD":  # whether the equations are singular there, or beside it, is rounding
            try:
                text = sf.locus(points[0], ("m", "W"), ((-0.5, 0.5), (1.6, 1.8))).summary()
            except sf.InputError as error:
                text = str(error)
            assert "4 multipliers lie on the unit circle there" in text
        return
    for one, other in zip(alone, points, strict=True):
        assert other.uncertainty < 1e-11
        assert other.criticality == one.criticality
        assert other.coefficient == pytest.approx(one.coefficient, rel=1e-8)
        assert other.duration == pytest.approx(one.duration, rel=1e-9)
        if kind == "NS":
            assert other.critical_multiplier == pytest.approx(one.critical_multiplier, abs=1e-9)


def test_a_locus_is_that_of_the_pair_that_moves():
    states = {"x": "v", "v": "(m - k^2)*v - (1 + k)*x - x^2*v", **FORCED}
    standing = mode() | mode("7", names="cd")
    system = {"parameters": {"m": -0.5, "k": 0.3, "W": 1.7}, "states": states | standing}
    model = sf.System(system | {"forcing": {"period": "2*pi/W"}})
    settings = sf.Settings(largest_period=1)
    (point,) = sf.response(model, "m", (-0.5, 0.5), settings=settings).branches[0].special
    gradients = sf.gradients(point)
    assert gradients["k"] == pytest.approx(2 * 0.3, abs=1e-9)
    (locus,) = sf.locus(point, ("m", "k"), ((-0.5, 1), (-0.5, 0.8))).loci
    m, k = locus.values.T
    assert m == pytest.approx(k**2, abs=1e-11)
    assert (k.min(), k.max()) == pytest.approx((-0.5, 0.8), abs=1e-12)
    # The angle over a period of the forcing is 2 pi sqrt(1 + k)/W.
    expected = [(1.7 / 3 * 2) ** 2 - 1, (1.7 / 4 * 3) ** 2 - 1]
    found = [item.values[1] for item in locus.special if item.type in ("R3", "R4", "HH", "NSNS")]
    assert found == pytest.approx(expected, abs=1e-8)


def flutter(damping: float = 0.0) -> sf.System:
    """Two frequencies, which meet where the circulatory force is half the difference in k."""
    first, second = f"-2*x + m*y - {damping}*u", f"-m*x - k*y - {3 * damping}*v"
    states = {"x": "u", "y": "v", "u": first, "v": second}
    return sf.System(parameters={"m": 0.0, "k": 3.0}, states=states)


@pytest.mark.parametrize("whole", [False, pytest.param(True, marks=pytest.mark.long)])
def test_the_locus_of_flutter_without_damping_is_followed(whole):
    responses = [sf.response(flutter(), "m", (0, end)).branches[0] for end in (1, -1)]
    first, second = (point for branch in responses for point in branch.special)
    assert sf.gradients(first)["k"] == pytest.approx(0.5, abs=1e-12)
    plane = ("m", "k"), ((-1, 1), (1, 4))
    alone = [sf.locus(point, *plane).loci[0] for point in (first, second)]
    both = sf.bifurcation_set(flutter(), *plane).loci if whole else alone
    assert [locus.type for locus in both] == ["HB", "HB"]
    for locus in both:  # they cross at m = 0, where both frequencies are the same
        m, k = locus.values.T
        assert np.abs(m) == pytest.approx(np.abs(k - 2) / 2, abs=1e-12)
        assert (k.min(), k.max()) == pytest.approx((1, 4), abs=1e-12)


@pytest.mark.parametrize("beside", long_except([mode("7.1"), mode("7.1", 0.1)], [mode("7.1", 0.1)]))
def test_the_edge_of_a_combination_resonance_is_followed(beside):
    # Their multipliers' polynomial reads the same backward: s^2 + a s + b - 2 in s = l + 1/l.
    states = {"x": "u", "y": "v", "u": "-x - e*cos(W*t)*y", "v": "-4*y - e*cos(W*t)*x"}
    system = {"parameters": {"W": 2.5, "e": 0.4}, "forcing": {"period": "2*pi/W"}}
    model, alone = (sf.System(system | {"states": states | each}) for each in (beside, {}))
    point, _ = sf.response(model, "W", (2.3, 3.6)).branches[0].special
    (locus,) = sf.locus(point, ("W", "e"), ((2.5, 3.5), (0.05, 1))).loci
    assert (locus.values[:, 1].min(), locus.values[:, 1].max()) == pytest.approx((0.05, 1))
    for W, e in locus.values[1::4]:
        _, a, b, _, _ = np.poly(sf.periodic_orbit(alone.replace(W=W, e=e)).multipliers).real
        assert a**2 - 4 * (b - 2) == pytest.approx(0, abs=1e-11)


@pytest.mark.parametrize("damping", [1e-3, 1e-5, 1e-7, 1e-8])
def test_flutter_is_seen_with_hardly_any_damping(damping):
    # Unequal damping lets the slower of the two grow long before they meet.
    settings = sf.Settings(largest_period=0)
    (point,) = sf.response(flutter(damping), "m", (0, 1), settings=settings).branches[0].special
    # By Routh's criterion for l^4 + 4 d l^3 + (5 + 3 d^2) l^2 + 9 d l + 6 + m^2.
    exact = (9 / 4 * (5 + 3 * damping**2) - (9 / 4) ** 2 - 6) ** 0.5
    assert point.type == "HB"
    assert abs(point.value - exact) <= point.uncertainty + 1e-14


def test_a_batch_leaves_what_nothing_damps_to_be_followed_individually():
    states, forcing = growing("m") | FORCED | mode(), {"period": "2*pi/W"}
    system = {"parameters": {"m": -0.5, "W": 1.7}, "states": states, "forcing": forcing}
    for diagram in sf.responses(sf.System(system), "m", (-0.5, 0.5), over={"W": [1.6, 1.7]}):
        (point,) = diagram.branches[0].special
        assert (point.type, point.value) == ("NS", pytest.approx(0, abs=1e-12))


def coupled(stiffness: str, coupling: str) -> dict[str, str]:
    """Two vibrations without damping, by which one pushes the other against what it is pushed."""
    second = f"-({coupling})*x - 3*y"
    return {"x": "v", "v": f"-({stiffness})*x + ({coupling})*y - x^3", "y": "w", "w": second}


@pytest.mark.parametrize(
    ("states", "span", "expected"),
    [
        (coupled("2", "m"), (-1, 1), [-0.5, 0.5]),
        (coupled("2", "m") | mode("7.1"), (1, 0), [0.5]),
        # Both within one step: x and y have frequencies that differ by twice the coupling.
        (coupled("3 + m", "0.005"), (-2, 2.3), [-0.01, 0.01]),
        (coupled("3 + m", "0.00005") | mode("7.1"), (-2, 2.3), [-0.0001, 0.0001]),
    ],
    ids=["coupling", "backward, beside a mode", "stiffness", "weak coupling, beside a mode"],
)
def test_flutter_without_damping_begins_where_two_pairs_meet(states, span, expected):
    model = sf.System({"parameters": {"m": span[0], "k": 0.5}, "states": states})
    (branch,) = (diagram := sf.response(model, "m", span)).branches
    assert [(point.type, point.name) for point in branch.special] == [
        ("HB", "Hamiltonian Hopf") for _ in expected
    ]
    slope = np.ptp(expected) or 1.0  # of the discriminant, a parabola through both
    for point, value in zip(branch.special, expected, strict=True):
        assert abs(point.value - value) <= point.uncertainty < 1e-10 / slope
        assert (point.criticality, point.undecided, point.leads_to) == (None, None, None)
    assert diagram.summary().count("Hamiltonian Hopf") == len(expected)


def test_a_forced_vibration_without_damping_loses_its_stability_by_a_krein_collision():
    """The coupling oscillates with about the sum of both frequencies; Floquet's theory by SciPy."""
    states = {"x": "v", "v": "e*cos(W*t)*y - x", "y": "w", "w": "e*cos(W*t)*x - 2*y"}
    system = {"states": states, "forcing": {"period": "2*pi/W"}}
    model = sf.System(system | {"parameters": {"W": 2.2, "e": 0.1}})

    def discriminant(frequency):
        def rates(t, state):
            x, v, y, w = state.reshape(4, 4)
            pushed = 0.1 * np.cos(frequency * t)
            return np.concatenate([v, pushed * y - x, w, pushed * x - 2 * y])

        options = {"rtol": 1e-12, "atol": 1e-13, "method": "DOP853"}
        solution = solve_ivp(rates, (0, 2 * np.pi / frequency), np.eye(4).ravel(), **options)
        monodromy = solution.y[:, -1].reshape(4, 4)
        # Of s^2 - a s + b - 2 with s = mu + 1/mu, where mu^4 - a mu^3 + b mu^2 - a mu + 1 = 0.
        return 2 * np.trace(monodromy @ monodromy) - np.trace(monodromy) ** 2 + 8

    expected = [brentq(discriminant, *ends, xtol=1e-13) for ends in [(2.3, 2.4), (2.4, 2.5)]]
    for span in ((2.2, 2.7), (2.42, 2.7)):
        branch = sf.response(model, "W", span).branches[0]
        inside = [value for value in expected if span[0] < value]
        assert [point.name for point in branch.special] == ["Krein collision"] * len(inside)
        assert [p.value for p in branch.special] == pytest.approx(inside, abs=1e-11)
        assert np.all(
            branch.stable == ~((expected[0] < branch.parameter) & (branch.parameter < expected[1]))
        )


@pytest.mark.parametrize(("size", "beside"), [(0.05, mode("7.1")), (0.2, {})])
def test_where_nothing_damps_two_multipliers_flip_at_once(size, beside):
    # They meet at -1, where each is known to the root of rounding: some are 1e-6 away.
    states = {"x": "v", "v": f"-(k + {size}*cos(t))*x - x^3", **beside}
    system = {"parameters": {"k": 0.1}, "states": states, "forcing": {"period": "2*pi"}}
    settings = sf.Settings(largest_period=1)
    points = sf.response(sf.System(system), "k", (0.1, 0.4), settings=settings).branches[0].special
    assert [point.type for point in points] == ["PD", "PD"]
    assert all(point.several and point.criticality is None for point in points)


def test_a_harmonic_may_meet_a_resonance_that_nothing_damps():
    orbit = sf.periodic_orbit(duffing(0.3))  # twice the forcing's frequency is the natural one
    assert orbit.state == pytest.approx([0.1 / 0.75, 0], abs=1e-3)
    assert sf.response(duffing(0.3), "F", (0.1, 0.2)).branches[0].stopped.kind == "span"


def test_a_branch_ends_where_rounding_decides_where_its_orbits_are():
    # Beside the superharmonic the spring swings as if nothing forced it: with any phase, nearly.
    main, *others = sf.response(duffing(0.3), "W", (0.5, 1.5)).branches
    assert [point.type for point in main.special] == ["BP", "BP"]
    assert main.stopped.kind == "span"
    for branch in others:
        assert len(branch) < 100
        assert [end.kind for end in branch.ends] == ["unresolved"] * 2
        assert "damping" in branch.stopped.reason
        assert 0.8 < branch.parameter.max() < 1.1


@pytest.mark.parametrize("span", long_except([(0.7, 1.9), (1.9, 0.7)], [(0.7, 1.9)]))
def test_a_linear_oscillator_without_damping_runs_away_at_its_resonance(span):
    # x = sin(W t)/(1 - W^2); beyond an amplitude of 6e5 rounding made a dozen branch points.
    states, forcing = {"x": "v", "v": "-x + sin(W*t)"}, {"period": "2*pi/W"}
    model = sf.System(name="linear", parameters={"W": 1.5}, states=states, forcing=forcing)
    (branch,) = sf.response(model, vary="W", span=span).branches
    assert not branch.special
    assert branch.stopped.kind == "unresolved"
    assert branch.stopped.reason.startswith("the orbit runs away to ")
    assert branch.stopped.value == pytest.approx(1, abs=1e-5)


def test_rounding_of_a_test_function_that_is_zero_shortens_no_step():
    # Cycles of Henon and Heiles at an energy of 1.5 have multipliers 1355, 1/1355, 1, 1. A product
    # of two is one all along the branch, but for rounding that growth multiplies to 1e-9.
    random = np.random.default_rng(1)
    basis, form = random.normal(size=(4, 4)), np.diag([1355, 1 / 1355, 1, 1])
    form[2, 3] = 1
    exact = basis @ form @ np.linalg.inv(basis)
    tests = []
    for _ in range(12):
        values = np.linalg.eigvals(exact * (1 + 2e-16 * random.normal(size=(4, 4))))
        others = np.delete(values, np.abs(values - 1).argmin()).astype(complex)
        tests.append([evaluate_tests(others, ("NS",))["NS"]])
    known = np.array([tests])
    assert np.ptp(known) > 1e-11
    assert drift(np.ptp(known, axis=1), known, known[:, -1], Shooting.noise, 1.0) < 1


@pytest.mark.parametrize("first", [0, -1])
def test_a_line_of_equilibria_also_on_the_end_of_the_span_is_a_family(first, tmp_path):
    states = {"x": "y", "y": "-T*x - (1 + x^2)*y"}
    system = sf.System(parameters={"T": {"value": 0.0, "min": first}}, states=states)
    diagram = sf.response(system, vary="T", span=(first, 2))
    *_, line = diagram.branches
    diagram.save(tmp_path / "line.nc")
    assert min(line.stopped.value, *line.parameter) >= first
    assert [item.type for item in line.special] == ["BP"]
    assert line.stopped.kind == "family"
    assert "equilibria have the same T = 0" in line.stopped.reason
    assert len(line) < 30


def test_free_vibrations_of_the_forcings_period_are_a_family():
    # At W = 1/2 the forcing excites x'' + x = 0 no more than elsewhere, but any motion repeats.
    states = {"x": "v", "v": "-x + 0.1*cos(W*t)"}
    system = sf.System(parameters={"W": 1.0}, states=states, forcing={"period": "2*pi/W"})
    (branch,) = sf.response(system, vary="W", span=(0.8, 0.5)).branches
    assert branch.stopped.value == pytest.approx(0.5, abs=1e-8)
    assert "the orbits are a family, with any amplitude and phase" in branch.stopped.reason


def test_slow_decays_are_no_family():
    # Two multipliers lie within 1e-6 of one where x runs away, and any state decays to one orbit.
    states = {
        "x": "v",
        "v": "cos(t) - v/10 - 3*x + 1/(p - 1)",
        "z": "1e-7*(x^2 - z)",
        "y": "1e-7*(x - y)",
    }
    system = sf.System(parameters={"p": 2.0}, states=states, forcing={"period": "2*pi"})
    (branch,) = sf.response(system, vary="p", span=(2, 0.5)).branches
    assert (np.abs(branch.multipliers[-1] - 1) < 1e-6).sum() == 2
    assert "runs away" in branch.stopped.reason  # where x grows beyond all bounds
    assert branch.stopped.values[0] < 1.01


def test_a_slow_temperature_may_start_anywhere():
    # The damper's heat softens the spring. T, of 20 to 80, changes by less than 0.01 in a period.
    found = []
    for start in (20, 19.999, 0):
        states = {
            "x": "v",
            "v": "-0.1*v - x*(1 - 0.01*(T - 20)) - 0.1*x^3 + 0.3*cos(2*pi*f*t)",
            "T": {"rate": "1e-5*(100*v^2 - (T - 20))", "start": start},
        }
        system = sf.System(parameters={"f": 0.3}, states=states, forcing={"period": "1/f"})
        branch = sf.response(system, vary="f", span=(0.3, 0.1)).branches[0]
        assert branch.stopped.kind == "span"
        found.append([(item.type, item.value) for item in branch.special])
    assert [kind for kind, _ in found[0]] == ["NS"]
    assert found[1:] == [[("NS", pytest.approx(found[0][0][1], abs=1e-8))]] * 2
