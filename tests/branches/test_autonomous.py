"""Equilibria and cycles of autonomous systems against closed forms and published values."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

import slipfold as sf
from helpers.by_hand.sliding import end_of
from slipfold.models.registry import model_named
from slipfold.orbits.eigenvalues import unit_of_time


def special(diagram, kind, branch=None):
    return [
        item.point
        for item in diagram.special
        if item.point.type == kind and branch in (None, item.branch.id)
    ]


def test_hopf_of_stuart_landau_and_its_cycles_are_exact():
    # x' = r x - w y - x (x^2 + y^2): radius sqrt(r), multiplier exp(-4 pi r/w).
    model = model_named("stuart-landau")
    diagram = sf.response(model, vary="r", span=(-0.5, 0.5))
    still, cycles = diagram.branches
    (hopf,) = still.special
    assert (still.kind, cycles.kind, hopf.type) == ("equilibrium", "periodic", "HB")
    assert hopf.value == pytest.approx(0, abs=1e-12)
    assert hopf.criticality == "supercritical"
    # With a critical vector of unit length the amplitude is sqrt(2) times that of x and y.
    assert hopf.coefficient == pytest.approx(-2 / model.w, rel=1e-9)
    assert hopf.duration == pytest.approx(2 * math.pi / model.w, rel=1e-12)
    assert hopf.leads_to == cycles.id
    assert "Branch 2 (cycles, " in diagram.summary()
    assert cycles.durations == pytest.approx(2 * math.pi / model.w, rel=1e-11)
    inside = cycles.parameter > 1e-3
    radius = np.hypot(*cycles.states[inside].T)
    assert radius == pytest.approx(np.sqrt(cycles.parameter[inside]), rel=1e-9)
    exact = np.exp(-4 * np.pi * cycles.parameter[inside] / model.w)
    assert np.abs(cycles.multipliers[inside]).min(axis=1) == pytest.approx(exact, rel=1e-8)


def test_lure_hopf_and_doubled_cycle():
    # MatCont manual: Hopf at a = 1, first Lyapunov coefficient -0.3; PD at a = 0.6303020061596.
    settings = sf.Settings(largest_period=1)
    diagram = sf.response(model_named("lure"), vary="a", span=(1.2, 0.62), settings=settings)
    (hopf,), (doubling,) = special(diagram, "HB"), special(diagram, "PD")
    assert hopf.value == pytest.approx(1, abs=1e-12)
    assert hopf.coefficient == pytest.approx(-0.3, abs=1e-9)
    assert doubling.value == pytest.approx(0.6303020061596, abs=1e-12)
    assert doubling.duration == pytest.approx(6.3640713394414, abs=1e-10)
    assert sorted(doubling.multipliers.real) == pytest.approx([-1, -0.01811007, 1], abs=1e-8)


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
def test_the_unit_of_time_does_not_matter(scale):
    # A damped oscillator whose damping changes sign: Hopf at c = 0 at any frequency.
    model = sf.System(
        name="oscillator",
        parameters={"c": 0.5, "w": scale},
        states={"q": "w*v", "v": "-w*q - w*c*v - w*v^3"},
    )
    diagram = sf.response(model, vary="c", span=(0.5, -0.1))
    (hopf,) = special(diagram, "HB")
    assert hopf.value == pytest.approx(0, abs=1e-12)
    # v^3 damps by 3/8 a^2 of the amplitude: with the vector of unit length, twice that.
    assert hopf.coefficient == pytest.approx(-0.75, rel=1e-8)
    assert hopf.duration == pytest.approx(2 * math.pi / scale, rel=1e-10)


@pytest.mark.parametrize(("rate", "span"), [(1e-7, (1, -0.5)), (1e-11, (-300, 1))])
def test_a_flat_fold_beyond_which_nothing_rests_is_one_fold(rate, span):
    states = {"x": f"{rate}*(p - x^2)", "y": "-y + x"}
    (branch,) = sf.response(sf.System(parameters={"p": 1.0}, states=states), "p", span).branches
    (fold,) = branch.special
    assert (fold.type, fold.value) == ("LP", pytest.approx(0, abs=1e-10))


def test_van_der_pol_from_its_rest_over_the_centers_to_the_relaxation_cycle():
    # At mu = 0 every circle is a cycle; that of radius 2 is where the limit cycle crosses.
    diagram = sf.response(model_named("vanderpol-free"), vary="mu", span=(-0.5, 1))
    still, centers, relaxing = diagram.branches
    assert [(item.type, item.leads_to) for item in still.special] == [("HB", centers.id)]
    assert centers.stopped.kind == "family"
    assert centers.durations == pytest.approx(2 * math.pi, rel=1e-9)
    (crossing,) = [item for item in centers.special if item.type == "BP"]
    assert crossing.leads_to == relaxing.id
    assert crossing.orbit.extrema.of("x")[1][0] == pytest.approx(2, abs=1e-8)
    cycle = relaxing.orbit(-1)
    assert cycle.model.mu == 1
    assert cycle.duration == pytest.approx(6.663286859323, abs=1e-11)
    assert cycle.extrema.of("x")[1][0] == pytest.approx(2.008619860875, abs=1e-11)
    # exp of the integral of the divergence along the cycle, by DOP853; a step may err by 1e-13.
    # How well the product keeps its digits depends on where the cycle begins.
    known = 1e-13 + 3 * cycle.multiplier_uncertainty[1]
    assert known < 1e-10
    assert cycle.multipliers[1].real == pytest.approx(8.59695063604e-4, abs=known)


def test_the_edge_without_damping_is_no_locus(few_lines):
    window = ((0.3, 0.8), (0, 0.2))
    squeal = model_named("squeal")
    found = sf.bifurcation_set(squeal, ("mu", "c"), window, types="HB", regions=False)
    (flutter,) = found.loci
    assert flutter.special == ()
    assert (flutter.values[:, 1] > 0).all()


def test_an_undamped_response_is_neutral():
    model = sf.System(
        parameters={"W": 1.2, "F": 0.1},
        states={"q": "v", "v": "F*cos(W*t) - q - q^3"},
        forcing={"period": "2*pi/W", "amplitude": "F"},
    )
    diagram = sf.response(model, vary="W", span=(0.55, 0.8))
    ends = [line.split() for line in diagram.summary().splitlines() if " EP " in line]
    assert [line[-1] for line in ends] == ["neutral", "neutral"]


def test_cycles_of_hindmarsh_and_rose_where_zero_is_not_near_the_rest():
    # Hindmarsh and Rose (1984). At I = 0 Newton's method finds no equilibrium from zero, where
    # the equations are nearly degenerate: scales measured there made the cycles unresolvable.
    model = sf.System(
        parameters={"I": 2.0},
        states={
            "x": "y - x^3 + 3*x^2 - z + I",
            "y": "1 - 5*x^2 - y",
            "z": "0.006*(4*(x + 1.6) - z)",
        },
    )
    diagram = sf.response(model, vary="I", span=(0, 1.5), settings=sf.Settings(largest_period=1))

    def routh_hurwitz(current):
        rest = brentq(lambda x: 1 - x**3 - 2 * x**2 - 4 * (x + 1.6) + current, -1.6, -1)
        slopes = [[6 * rest - 3 * rest**2, 1, -1], [-10 * rest, -1, 0], [0.024, 0, -0.006]]
        _, a, b, c = np.poly(np.array(slopes))
        return a * b - c

    (hopf,) = special(diagram, "HB")
    assert hopf.value == pytest.approx(brentq(routh_hurwitz, 1, 1.5, xtol=1e-13), abs=1e-9)
    cycles = diagram.branches[1]
    assert [point.type for point in cycles.special] == ["LP", "PD", "PD"]
    assert cycles.stopped.kind == "span"
    last = cycles.orbit(-1)

    def rates(t, u):
        v = 1 - 5 * u[0] ** 2 - u[1]
        return [u[1] - u[0] ** 3 + 3 * u[0] ** 2 - u[2] + 1.5, v, 0.006 * (4 * (u[0] + 1.6) - u[2])]

    end = end_of(rates, last.duration, last.state)
    assert end == pytest.approx(last.state, abs=1e-7)


def test_a_family_of_cycles_up_to_a_homoclinic_orbit_has_no_folds():
    # AUTO's demo vhb: at p = 0 there is a first integral, and cycles fill the loop of the saddle.
    model = sf.System(parameters={"p": -1.0, "q": 1.0}, states={"x": "p*x - y", "y": "x*(1 - q*x)"})
    diagram = sf.response(model, vary="p", span=(-1, 1))
    assert [item.point.type for item in diagram.special] == ["HB"]
    # It is both; how near to the loop the 150th cycle lies is rounding.
    assert diagram.branches[1].stopped.kind in ("family", "homoclinic")
    # The loop is y^2/2 + x^2/2 - x^3/3 = 1/6: it crosses the axis at x = 1 and x = -1/2.
    low, _ = diagram.branches[1].extrema_of("x").of("x")
    assert low.min() == pytest.approx(-0.5, abs=1e-3)
    (centers,) = sf.locus(diagram.special[0][1], ("p", "q"), ((-1, 1), (0.3, 3))).loci
    assert (centers.special, set(centers.criticality)) == ((), {None})  # no Bautin points


def test_folds_of_a_canard_explosion_are_located():
    # FitzHugh and Nagumo: between the Hopf points the cycles have a fold beside each, one of them
    # within the canards, where the parameter stands still within rounding.
    model = sf.System(
        parameters={"I": 0.0}, states={"v": "v - v^3/3 - w + I", "w": "0.08*(v + 0.7 - 0.8*w)"}
    )
    diagram = sf.response(model, vary="I", span=(0, 2))
    assert [point.type for point in diagram.branches[1].special] == ["LP", "LP"]
    first, second = (point.value for point in special(diagram, "LP"))
    # (v, w, I) -> (-v, 1.75 - w, 1.75 - I) is a symmetry.
    assert first + second == pytest.approx(1.75, abs=1e-8)
    assert diagram.branches[1].stopped.kind == "closed"


def test_cycles_are_followed_from_where_they_change_the_parameter_by_more_than_rounding():
    # Beside a state of rest of 5,000 scales cycles of a thousandth leave it as a center's do. The
    # unstable pair adds what rounding does to the parameter, about 1e-10.
    model = sf.System(
        parameters={"mu": -0.1},
        states={
            "x": {"rate": "v", "scale": 1.0, "start": 5e3},
            "v": {"rate": "(mu - 1e-6*(x - 5e3)^2)*v - (x - 5e3)", "scale": 1.0},
            "y": {"rate": "w", "scale": 1.0},
            "w": {"rate": "0.2*w - 2*y + x - 5e3", "scale": 1.0},
        },
    )
    cycles = sf.response(model, vary="mu", span=(-0.5, 0.1)).branches[1]
    assert not cycles.special
    assert cycles.stopped.kind == "span"
    assert cycles.parameter[1] > 1e-9
    low, high = cycles.extrema_of("x").of("x")
    # Of van der Pol's oscillator mu = 1e-6 A^2/4, to third order of mu.
    exact = 1e-6 * ((high - low) / 2) ** 2 / 4
    assert cycles.parameter == pytest.approx(exact, rel=1e-2, abs=1e-10)


@pytest.mark.parametrize("span", [(0.01, 1e-9), (1e-8, 1.0)])
def test_a_block_without_damping_on_a_slow_belt_has_no_hopf_point(span):
    # The derivative of v/|v| is a difference of two terms 1/|v|, of which rounding is left.
    belt = sf.FrictionContact("tip", sf.Coulomb(mu_k=0.3), load="5 N", Vd="2 m/s")
    block = sf.Structure([[0.05]], [[0.0]], [[2000.0]], names=("tip",), contacts=belt)
    assert sf.response(block, "Vd", span).branches[0].special == ()


def test_a_hopf_point_beside_a_fast_decay_is_found_within_a_short_span():
    fast = {"x": "v", "v": "mu*v - x - x^2*v + 0.1*(z - x)", "z": "-1e11*(z - x)"}
    system = sf.System(parameters={"mu": 0}, states=fast)
    alone = sf.Settings(largest_period=0)
    (hopf,) = sf.response(system, "mu", (-1e-3, 1e-3), settings=alone).branches[0].special
    assert hopf.type == "HB"
    assert abs(hopf.value) < 1e-4  # rounding of the fast rates is 1e-5 of the slow ones


@pytest.mark.parametrize(
    ("jacobian", "push", "least", "largest"),
    [
        ([[0]], [5], 5e-3, 5e-3),
        ([[-1e8, 0], [0, 0]], [1e9, 5e3], 5, 10),  # decay holds what is pushed far more
        ([[1]], [2000], 1, 2),  # the rate would halve to the eigenvalue itself
        ([[-1, 0], [0, 0]], [1e9, 0], 1e-9, 1e6),  # nothing moves along the line of equilibria
        ([[0]], [np.inf], 0.8, 0.8),
    ],
)
def test_the_unit_of_time_at_a_fold_is_that_of_motion_which_nothing_opposes(
    jacobian, push, least, largest
):
    rate = 0.8 / unit_of_time(np.array(jacobian, float), np.array(push, float))
    assert least * (1 - 1e-12) <= rate <= largest * (1 + 1e-12)


FAULT = """
[parameters]
k = 4e9
V0 = 1e-6
[states]
u = {{ rate = "V0 - v", start = 7e-4{} }}
v = {{ rate = "(k*u - 5e6*(0.6 + 0.01*log(v/V0) + 0.015*log(V0*th/1e-5)))/1e3", start = 1e-6 }}
th = {{ rate = "1 - v*th/1e-5", start = 10{} }}
"""


@pytest.mark.parametrize(
    "scales", [("", ""), pytest.param((", scale = 1e-3", ", scale = 10"), marks=pytest.mark.long)]
)
def test_creep_of_a_fault_with_hardly_any_inertia_has_its_hopf_point(scales):
    # Rate-and-state friction. A rate of 5e7/s beside 0.07/s holds the slip speed, which the change
    # of k would move a thousand times as fast.
    fault = sf.System.from_toml(FAULT.format(*scales))
    alone = sf.Settings(largest_period=0)
    creep = sf.response(fault, "k", (4e9, 1e9), settings=alone).branches[0]
    (hopf,) = creep.special
    decay = 0.01 * 5e6 / (1e3 * 1e-6)
    exact = 1e3 * (7.5e6 - 0.1 * decay) * (1 + 0.1 / decay)  # Routh
    assert hopf.type == "HB"
    assert hopf.value == pytest.approx(exact, rel=1e-6)  # an error of the fast rate is 2e-7
    assert abs(hopf.value - exact) < hopf.uncertainty
    assert "missing" not in creep.stopped.reason
