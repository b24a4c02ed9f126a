"""Branches through stick and slip: where contacts begin or cease to stick, located and passed."""

from contextlib import nullcontext

import numpy as np
import pytest

import slipfold as sf
from helpers.dry_friction import belt, sliding
from portable.perturbed_kernels import perturbed
from slipfold.lines import branch_segments
from slipfold.plots.response import marks_of


@pytest.mark.parametrize("largest", [pytest.param(0.05, marks=pytest.mark.long), 0.2])
def test_a_stick_slip_cycle_ends_where_it_meets_one_that_slips(largest):
    # bSTAB: it touches Vrel = 0 there; the branch turns back as the unstable cycle in pure slip.
    law = sf.Stribeck(mu_s=1.0, mu_k=0.5, vs=0.5)
    cycle = sf.periodic_orbit(belt(law, 1.5, damping=0.1), state={"x": 2.0})
    settings = sf.Settings(steps=sf.Steps(largest=largest))
    (branch,) = sf.response(cycle, vary="Vd", span=(1.5, 1.9), settings=settings).branches
    (point,) = branch.special
    assert point.type == "GRAZE"
    # Where an orbit that touches zero slip closes, by Taylor series in 25 digits; bSTAB: ...2208.
    assert point.value == pytest.approx(1.836600972207926, abs=point.uncertainty)
    assert point.uncertainty < 1e-10
    assert branch.parameter[-1] == 1.5
    sticks = branch.stuck_fraction > 0
    assert sticks[0]
    assert not sticks[-1]
    assert branch.stable[sticks].all()
    assert not branch.stable[-1]
    assert np.abs(branch.multipliers[sticks, 1]).max() < 1e-12
    assert_drawn(branch)


def assert_drawn(branch):
    """A figure of the stuck fraction falls to zero at GRAZE and stays there."""
    (point,) = branch.special
    first, *others = branch_segments(branch, "x", "stuck_fraction")
    assert first.kind == "stable"
    assert first.value[0] == branch.stuck_fraction[0]
    assert first.value[-1] == point.stuck_fraction
    assert (np.diff(first.value) <= 0).all()
    assert all(line.value.max() <= point.stuck_fraction for line in others)
    assert others[-1].value[-1] == 0
    assert_marked(branch, point)


def assert_marked(branch, point):
    (mark,) = (item for item in marks_of(branch, "x", "stuck_fraction") if item.type == "GRAZE")
    assert (mark.parameter, mark.value) == (point.value, point.stuck_fraction)


ALONE = sf.Settings(largest_period=1)


@pytest.mark.long
def test_slip_in_the_plane_touches_zero_at_one_place_from_both_sides():
    found = []
    for span in ((0.0556, 0.055), (0.055, 0.0556)):
        orbit = sf.periodic_orbit(sf.SlidingOscillator(f=12.5, Nd=0.3, Vd=span[0]))
        (branch,) = sf.response(orbit, vary="Vd", span=span, settings=ALONE).branches
        assert branch.stopped.kind == "span"
        (point,) = branch.special
        assert point.type == "GRAZE"
        assert point.stuck_fraction == pytest.approx(0.0, abs=1e-7)
        found.append(point)
        # In slip one perturbation of the velocity is left, in stick none.
        gone = np.abs(branch.multipliers) < 1e-12
        ends = sorted((gone[0].sum(), gone[-1].sum()))
        assert ends[1] == 2
        assert ends[0] < 2
    there, back = found
    assert there.value == pytest.approx(back.value, abs=1e-9)
    assert abs(there.value - back.value) <= there.uncertainty + back.uncertainty
    assert there.nodes == pytest.approx(back.nodes, abs=1e-6)


def test_a_response_goes_on_through_stick_by_itself():
    model = sf.SlidingOscillator(f=12.5, Nd=0.3)
    diagram = sf.response(model, vary="Vd", span=(0.06, 0.05), settings=ALONE)
    (branch,) = diagram.branches
    assert diagram.checked.checks[0].name.startswith("orbit near GRAZE")
    assert all(check.agrees for check in diagram.checked.checks)
    assert branch.stopped.kind == "span"
    (point,) = branch.special
    assert point.type == "GRAZE"
    assert point.value == pytest.approx(0.0552587111, abs=1e-10)
    # What a simulated motion settles on.
    assert branch.stuck_fraction[-1] == pytest.approx(0.053208237, abs=1e-9)
    assert not branch.stuck_fraction[0] > 0


@pytest.mark.long
@pytest.mark.parametrize("first", [0.04, 1.0])
def test_where_a_response_begins_to_stick_does_not_depend_on_the_span(first):
    # The unknown at which slip vanishes is over the width of the span.
    model = sf.SlidingOscillator(f=9.0, Nd=0.5)
    (branch,) = sf.response(model, vary="Vd", span=(first, 0.026), settings=ALONE).branches
    (point,) = branch.special
    assert point.type == "GRAZE"
    assert point.value == pytest.approx(0.02622476638, abs=1e-10)
    assert branch.stuck_fraction[-1] > 0


def grazings(span):
    """Where the response over the frequency begins and ceases to stick."""
    model = sliding(0.3, 0.06).replace(f=span[0])
    (branch,) = sf.response(model, vary="f", span=span, settings=ALONE).branches
    assert branch.stopped.kind == "span"
    return sorted((item for item in branch.special), key=lambda item: item.value)


def assert_same_grazings(span):
    """All that lie in a span are found, where they lie for any other."""
    low, high = sorted(span)
    wanted = [value for value in (11.743901747332, 12.201193845106) if low < value < high]
    found = grazings(span)
    assert [item.value for item in found] == pytest.approx(wanted, abs=2e-11)
    assert all(item.type == "GRAZE" and item.uncertainty < 5e-9 for item in found)


@pytest.mark.long
@pytest.mark.parametrize("seed", range(8))
def test_grazings_do_not_depend_on_the_span(seed):
    rng = np.random.default_rng(seed)
    # From stick, where its last stop vanishes, it lay 8e-7 off, or ended there.
    low, high = rng.uniform(9, 11.7), rng.uniform(11.8, 13)
    assert_same_grazings(tuple(rng.permutation([low, high])))


@pytest.mark.parametrize("seed", [None, 25, pytest.param(33, marks=pytest.mark.long)])
def test_a_response_on_a_belt_goes_through_stick_from_the_hopf_point_on(seed):
    # Last digits decide where its last points lie: once 4e-10 beyond the grazing, once 1e-9 before.
    law = sf.Stribeck(mu_s=1.0, mu_k=0.5, vs=0.5)
    model = belt(law, 1.5, damping=0.1)
    with nullcontext() if seed is None else perturbed(seed):
        still, cycles = sf.response(model, vary="Vd", span=(1.9, 1.0)).branches
    (hopf,) = still.special
    assert hopf.value == pytest.approx(0.5 * np.log(10), abs=1e-9)
    (point,) = cycles.special
    assert (point.type, cycles.stopped.kind) == ("GRAZE", "span")
    # As in the test above, from the other side.
    assert point.value == pytest.approx(1.836600972207926, abs=point.uncertainty)
    assert point.uncertainty < 1e-11


def test_an_orbit_that_sticks_is_not_taken_for_one_of_twice_its_period():
    with pytest.raises(sf.InputError, match="the orbit found for period 2 has period 1"):
        sf.periodic_orbit(sf.SlidingOscillator(f=12.5, Nd=0.9, Vd=0.02), period=2)


def test_a_doubled_branch_that_sticks_ends_at_its_parents_other_doubling():
    """Halves of its orbits are compared, though they have one node only: it went round forever."""
    law = sf.Stribeck(mu_s=0.55, mu_k=0.35, vs=0.08)
    pad = sf.Structure(
        np.diag([0.4, 1.6]),
        sf.ProportionalDamping(alpha_M=4.0, beta_K=1e-5),
        [[4e5, -4e5], [-4e5, 1.2e6]],
        names="pad caliper",
        contacts=sf.FrictionContact("pad", law, load=250.0, Vd=0.3),
    )
    found = sf.response(pad, vary="Vd", span=(0.3, 0.56), settled=True)
    single, double = found.branches
    doublings = [point for point in single.special if point.type == "PD"]
    assert [point.leads_to for point in doublings] == [double.id, double.id]
    assert double.stopped.kind == "closed"
    assert double.parameter[[0, -1]] == pytest.approx([p.value for p in doublings], abs=1e-9)
    assert [point.type for point in double.special] == ["GRAZE", "LP", "GRAZE"]


def test_cycles_that_stick_double() -> None:
    # Two blocks on a belt, coupled, one with more friction: a stable cycle, and one of two rounds.
    laws = (sf.RationalStribeck(mu_s=1.0, d=3.0), sf.RationalStribeck(mu_s=1.3, d=3.0))
    contacts = [
        sf.FrictionContact(name, law, load=1.0, Vd=0.2, name=name)
        for name, law in zip("ab", laws, strict=True)
    ]
    stiffness = [[2.2, -1.2], [-1.2, 2.2]]
    blocks = sf.Structure(np.eye(2), None, stiffness, names=["a", "b"], contacts=contacts)
    start = {"mu_s_b": 1.3, "a": 0.0}
    cycles, doubled = sf.response(blocks, "mu_s_b", (1.3, 1.56), start=start, settled=True).branches
    assert [point.leads_to for point in cycles.special] == [2]
    assert doubled.stopped.kind == "span"
    orbit = doubled.orbit(-1)
    assert orbit.stable
    beside = orbit.state + np.array([1e-3, 0.0, 0.0, 0.0])
    motion = sf.simulate(blocks.replace(mu_s_b=1.56), state=beside)
    assert motion.settlement.duration == pytest.approx(orbit.duration, rel=1e-8)
    largest = orbit.extrema.maximum[0, :2]
    assert np.array(motion.last_round.maximum)[:2] == pytest.approx(largest, rel=1e-8)
