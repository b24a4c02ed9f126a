"""Where a smooth piece of a branch ends, and what goes on there."""

from dataclasses import replace

import numpy as np
import pytest

import slipfold as sf
from helpers.dry_friction import belt, den_hartog
from slipfold.bifurcations.branches import switching_boundaries
from slipfold.continuation import pieces
from slipfold.continuation.curve import AlgebraicCurve
from slipfold.orbits.kinds import ForcedOrbits
from slipfold.orbits.switched_shooting import SwitchedShooting


def test_derivatives_are_those_of_the_piece_of_a_point() -> None:
    """A last correction of 1e-10 may lead to the next piece, where multipliers are others."""
    model, found = den_hartog(0.6, 0.5), []
    orbits = ForcedOrbits(model, {"f": 0.1}, 1, 1, SwitchedShooting)
    for f in (0.08, 0.12):
        orbit = sf.periodic_orbit(model.replace(f=f))
        z = orbits.unknown(orbit.nodes[:1], orbit.model)
        found.append(pieces.correct(orbits, z, np.eye(len(z))[-1]))
    stuck, slips = found
    crossed = replace(slips, linearization=stuck.linearization, bordered=stuck.bordered)
    own, point = (orbits.point(item, 0.0) for item in (slips, crossed))
    assert point.multipliers == pytest.approx(own.multipliers, rel=1e-9)
    assert point.tangent == pytest.approx(own.tangent, rel=1e-9)


class Parted(AlgebraicCurve):
    """The line x = 0, from 1e-9 on at another x; rounding decides the piece between, and slopes."""

    def __init__(self, apart: float) -> None:
        self.apart = apart

    def defect(self, z):
        return np.array([z[0] - self.apart * (z[1] >= 1e-9)])

    def jacobian(self, z):
        return np.array([[1.0, 2.5 if 0 <= z[1] < 1e-9 else 0.0]])

    def point(self, correction, arclength):
        piece = int(np.searchsorted([0.0, 1e-9], correction.z[1], side="right"))
        return replace(super().point(correction, arclength), piece=piece)


@pytest.mark.parametrize(("apart", "found"), [(0.0, [2]), (5e-7, [])])
def test_a_piece_that_rounding_makes_is_passed_straight_ahead(apart: float, found: list) -> None:
    curve, row = Parted(apart), np.eye(2)[1]
    before, after = curve.begin((0, -1e-11), row), curve.begin((0, 1e-11), -row)
    points = pieces.ahead_of(curve, before, after)
    assert [point.piece for point in points] == found
    assert all(point.tangent @ before.tangent > 0.99 for point in points)


@pytest.mark.parametrize("span", [(0.9, 2.5), pytest.param((3.0, 0.9), marks=pytest.mark.long)])
def test_a_branch_that_turns_back_where_it_touches_is_followed(span: tuple[float, float]) -> None:
    # To which side an orbit next to the graze belongs is rounding: they meet at 5 to 8 degrees.
    law = sf.Stribeck(mu_s=0.55, mu_k=0.3, vs=0.3)
    pad = sf.FrictionContact({"x": 1.0, "theta": 0.02}, law, load=150.0, Vd=1.5)
    damping, stiffness = [[6, 0.02], [0.02, 0.01]], [[320000, -3200], [-3200, 900]]
    model = sf.Structure(np.diag([0.8, 0.002]), damping, stiffness, names="x theta", contacts=pad)
    _, cycles = sf.response(model, "Vd", span).branches
    assert [point.type for point in cycles.special] == ["GRAZE"]
    assert cycles.special[0].value == pytest.approx(2.0595302885, rel=1e-9)
    assert (cycles.stopped.kind, cycles.parameter[-1]) == ("span", 0.9)
    assert cycles.orbit(len(cycles) - 1).stuck_fraction > 0


@pytest.mark.parametrize("first", [0.3, 0.45])
def test_the_branch_of_a_damped_belt_ends_where_slip_only_just_stops(first: float) -> None:
    model = belt(sf.Coulomb(mu_s=0.5, mu_k=0.3), first, 0.02)
    diagram = sf.response(sf.periodic_orbit(model, state={"x": 2.0}), "Vd", (first, 1.0))
    (point,) = diagram.branches[0].special
    # v'' + c v' + v = 0 from v = V, v' = mu_k - mu_s: the next maximum of v in closed form is V.
    assert point.type == "GRAZE"
    assert abs(point.value - 0.5478480833575481) < point.uncertainty < 1e-9
    assert diagram.checked.agree
    with pytest.raises(sf.InputError, match="no locus in Vd and mu_s: slip only just stops there"):
        sf.locus(point, ("Vd", "mu_s"), ((0.1, 1.0), (0.4, 0.8)))


def test_a_branch_goes_on_where_its_last_orbit_passed_the_graze(monkeypatch) -> None:
    """The residual of the last orbit may put it beyond: bisection then meets no neighbor."""
    model = belt(sf.Coulomb(mu_k=0.3), 0.4, 0.1, load=1.0, force=0.3)
    locate = switching_boundaries.locate_boundary

    def parted(curve, history, a, b, estimate):
        return replace(locate(curve, history, a, b, estimate), after=b)

    values = []
    for located in (locate, parted):
        monkeypatch.setattr(switching_boundaries, "locate_boundary", located)
        (branch,) = sf.response(model, "f", (0.1, 0.25)).branches
        assert branch.stopped.kind == "span"
        values.append([point.value for point in branch.special if point.type == "GRAZE"])
    assert len(values[0]) == 2
    assert values[1] == pytest.approx(values[0], rel=1e-9)


def test_a_branch_does_not_leap_to_one_that_ends_beside_it() -> None:
    """From 0.636556 to 0.636712 Hz events by SciPy show no motion of period one."""
    law = sf.Coulomb(mu_s=0.39, mu_k=0.3)
    mass = sf.System(
        parameters={"f": 2.0},
        states={"x": "v", "v": "-40*x - 60*x^3 - 0.4*v - 2.943 + 2*cos(w*t) + cos(2*w*t) + F"},
        formulas={"w": "2*pi*f"},
        contacts={"F": {"slip": "-v", "normal": "3.0", "friction": law}},
        forcing={"period": "1/f"},
    )
    start = {"f": 1.0, "x": -0.07}
    (branch,) = sf.response(mass, "f", (0.5, 4), start=start, settled=True).branches
    assert [end.kind for end in branch.ends] == ["failed", "span"]
    assert branch.parameter[0] == pytest.approx(0.63671175, rel=1e-8)


@pytest.mark.long
def test_the_node_of_a_doubled_orbit_is_not_where_another_period_changes() -> None:
    # The middle of its longest stop is a whole forcing period after a stop of the other period.
    wedge = sf.System(
        parameters={"W": 3.0},
        states={"s": {"rate": "v", "start": 0.1}, "v": "20 + 15*cos(W*t) - 100*s - 0.5*v + T"},
        contacts={"T": {"slip": "-v", "normal": "-640.5*s", "friction": sf.Coulomb(mu_k=0.4)}},
        forcing={"period": "2*pi/W"},
    )
    diagram = sf.response(wedge, "W", (3, 6.2), settings=sf.Settings(largest_period=2))
    assert [branch.period for branch in diagram.branches] == [1, 2, 2]
    assert {branch.stopped.kind for branch in diagram.branches} == {"span", "closed"}


def test_a_closed_branch_is_followed_once_where_a_step_would_leave_it() -> None:
    model = belt(sf.RationalStribeck(mu_s=0.4, d=0.3), 1.0, 0.1, load=4.0, force=0.5)
    start = {"f": 1.3125 / (2 * np.pi), "x": 0.0}
    (branch,) = sf.response(model, "f", (0.1, 0.4), start=start, settled=True).branches
    assert [branch.period, *(end.kind for end in branch.ends)] == [4, "closed", "closed"]
    least, *others = sorted(branch.special, key=lambda point: point.value)
    assert [point.type for point in (least, *others)] == ["GRAZE", "GRAZE", "LP"]
    assert 2 * np.pi * least.value == pytest.approx(1.26955856813, rel=1e-10)  # by SciPy's events


SLOWEST = (1.5 / 1.35) ** 0.5

FALLS_AND_RISES = belt(sf.CubicStribeck(mu_s=1.5, mu_m=1.5 - SLOWEST, vm=SLOWEST), 1.0, force=0.1)
"""M. di Bernardo, P. Kowalczyk and A. Nordmark, International Journal of Bifurcation and Chaos 13
(2003) 2935-2948: friction 1.5 - 1.5 v + 0.45 v^3, force 0.1 cos(W t). The orbit of period 4 begins
to stick at W = 1.7077997, and chaos sets in at once."""


def doubled_from(first: float) -> sf.Diagram:
    """What doubles on its branch of period 2, from a frequency W on."""
    span, start = (first / (2 * np.pi), 1.73 / (2 * np.pi)), {"f": 1.72 / (2 * np.pi), "x": 0.0}
    return sf.response(FALLS_AND_RISES, "f", span, start=start, settled=True)


def test_doubled_orbits_begin_where_a_branch_grazes() -> None:
    diagram = doubled_from(1.66)
    first, second, third = diagram.branches
    assert [branch.period for branch in diagram.branches] == [2, 4, 8]
    assert diagram.checked.agree
    (early,) = (point for point in first.special if point.type == "GRAZE")
    (late,) = second.special
    assert (late.type, late.leads_to) == ("GRAZE", 3)
    assert abs(2 * np.pi * late.value - 1.7077997) < 1e-7  # all published digits
    # Multipliers jump there across -1 on one side only: doubled orbits begin, none of them stable.
    assert (early.leads_to, first.special[-1].type, first.special[-1].leads_to) == (2, "PD", 2)
    for child, point in ((second, early), (third, late)):
        assert child.started.reason.startswith("emanates at")
        assert child.parameter[0] == pytest.approx(point.value, rel=1e-9)
        assert np.abs(child.multipliers[:3]).max(axis=1).min() > 1
    # The branch of period 8 closes on the other end of that of period 4.
    assert third.stopped.kind == "closed"
    assert third.stopped.value == pytest.approx(early.value, rel=1e-9)


def test_doubled_orbits_that_begin_beside_the_end_of_the_span_end_there() -> None:
    # A first step of 3e-3 of the span leads beyond its end, which is 2e-4 from the grazing.
    diagram = doubled_from(1.707795)
    assert [branch.period for branch in diagram.branches] == [2, 4, 8]
    assert [point.type for point in diagram.branches[1].special] == ["GRAZE"]
    assert [end.kind for end in diagram.branches[2].ends] == ["bifurcation", "span"]


def test_a_doubled_branch_turns_back_where_it_grazes() -> None:
    # Orbits on both sides of the grazing exist at lower frequencies only, so that the tangent of
    # one piece says nothing of where the other lies.
    given = {"start": {"f": 0.103}, "settled": True, "F": 0.3}
    settings = sf.Settings(largest_period=2)
    diagram = sf.response(FALLS_AND_RISES, "f", (0.0997, 0.104), settings=settings, **given)
    first, second = diagram.branches
    (turn,) = second.special
    (doubling,) = (point for point in first.special if point.type == "PD")
    assert (turn.type, second.stopped.kind) == ("GRAZE", "closed")
    assert second.stopped.values[0] == pytest.approx(doubling.value, rel=1e-9)
    assert second.parameter.max() <= turn.value + turn.uncertainty


def test_a_grazing_is_found_within_many_periods_of_slip() -> None:
    # 64 samples of two rounds of four periods showed another minimum of the relative speed.
    start, settings = {"f": 0.0888, "x": 2.1583, "vx": -0.5678}, sf.Settings(largest_period=4)
    given = {"start": start, "settled": True, "settings": settings, "F": 0.4}
    (branch,) = sf.response(FALLS_AND_RISES, "f", (0.0882, 0.0888), **given).branches
    assert [point.type for point in branch.special] == ["PD", "GRAZE", "LP", "PD"]
    assert branch.stopped.kind == "span"


@pytest.mark.long
@pytest.mark.parametrize("force", [0.2, 0.4, 1.0])
def test_every_doubled_branch_ends_on_another(force) -> None:
    diagram = sf.response(FALLS_AND_RISES, "f", (0.0477465, 0.477465), F=force)
    first, *doubled = diagram.branches
    assert first.stopped.kind == "span"
    assert doubled
    assert {branch.stopped.kind for branch in doubled} <= {"span", "closed"}
    places = np.array([point.value for branch in diagram.branches for point in branch.special])
    ends = [end.values[0] for branch in doubled for end in (branch.started, branch.stopped)]
    ends = [end for end in ends if 0.048 < end < 0.477]
    assert max(np.abs(places - end).min() for end in ends) < 1e-6
