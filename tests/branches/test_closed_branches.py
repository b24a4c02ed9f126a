"""Closed branches are followed once round, whatever their orbits' phase is where they come back."""

import pytest

import slipfold as sf
from slipfold.bifurcations.branches import response
from slipfold.models.registry import model_named

ISOLA = {
    "name": "isola of cycles",
    "parameters": {"p": 0},
    "formulas": {"g": "p^2 + (x^2 + y^2 - 4)^2/16 - 1/4"},
    "states": {"x": {"rate": "-x*g - y", "start": 2.2}, "y": "-y*g + x"},
}
"""Of radius r, turning by one rad in a unit of time: p^2 + (r^2 - 4)^2/16 = 1/4."""

TWO_PERIODS = {
    "name": "isola of orbits of two periods",
    "parameters": {"p": 0},
    "forcing": {"period": "2"},
    "formulas": {
        "a": "p*cos(pi*t) - u*sin(pi*t)",
        "b": "p*sin(pi*t) + u*cos(pi*t)",
        "size": "x^2 + y^2",
    },
    "states": {
        "x": {"rate": "-pi/2*y + a*x + b*y - x*size", "start": 0.5},
        "y": {"rate": "pi/2*x + b*x - a*y - y*size", "start": 0.5},
        "u": {"rate": "1/4 - u^2 - p^2", "start": 0.5},
    },
}
"""With x + i y = A exp(i pi t/2), A^2 = p + i u: once round p^2 + u^2 = 1/4 A becomes -A, which is
the same orbit started a period later."""

DOUBLING = {
    "name": "isola of cycles that double",
    "parameters": {"p": 0},
    "formulas": {"size": "x^2 + y^2", "h": "0.5*(size - 5) - 0.3*sqrt(5) - u^2 - v^2"},
    "states": {
        "x": {"rate": "x*(1/4 - p^2 - (size - 4)^2/16) - y", "start": 2.4},
        "y": "y*(1/4 - p^2 - (size - 4)^2/16) + x",
        "u": {"rate": "h*u - v/2 + 0.3*(x*u + y*v)", "start": 0.1},
        "v": "h*v + u/2 + 0.3*(y*u - x*v)",
    },
}
"""With u + i v = (a + i b) exp(i t/2), a' = (h + 0.3 r) a on the cycle of radius r: it doubles at
r^2 = 5, p^2 = 3/16, and is unstable between."""

SHORT = sf.Settings(steps=sf.Steps(largest=0.05))
COLLOCATION = sf.Settings(discretization="collocation")


@pytest.mark.parametrize(
    ("system", "settings"),
    [
        (ISOLA, COLLOCATION),
        (TWO_PERIODS, sf.Settings()),
        *(pytest.param(each, SHORT, marks=pytest.mark.long) for each in (ISOLA, TWO_PERIODS)),
    ],
)
def test_an_isola_has_two_folds(system, settings):
    given = {"vary": "p", "span": (-1, 1), "start": {"p": 0.3}, "settled": True}
    diagram = sf.response(sf.System(system), **given, settings=settings)
    (branch,) = diagram.branches
    assert sorted(item.value for item in branch.special) == pytest.approx([-0.5, 0.5], abs=1e-10)
    assert {item.type for item in branch.special} == {"LP"}
    assert (branch.stopped.kind, branch.started.kind) == ("closed", "closed")
    assert branch.stopped.value == pytest.approx(0.3, abs=1e-9)
    # Its length is that of one round, and no point of it lies beyond the first.
    assert 1.9 < abs(branch.parameter[:-1] - branch.parameter[1:]).sum() < 2


def test_an_isola_is_found_once_where_the_search_starts_at_its_folds():
    diagram = sf.response(sf.System(ISOLA), vary="p", span=(-2, 2), search=True)
    assert diagram.searched.values[1:3] == (-0.5, 0.5)
    assert [branch.kind for branch in diagram.branches] == ["equilibrium", "periodic"]


def test_cycles_that_a_doubled_branch_closes_on_are_followed(monkeypatch):
    close, where_it_began = response.close_on_parent, list[str]()

    def closed(orbits, children, first, *meeting, several):
        stop = close(orbits, children, first, *meeting)
        (reached,) = [child for child in children if child is not first] or [stop.reached]
        where_it_began.append(close(orbits, [reached], reached, *meeting).end.kind)
        return stop

    monkeypatch.setattr(response, "close_on_parent", closed)
    diagram = sf.response(sf.System(DOUBLING), vary="p", span=(-0.6, 0.6), also=[{"p": 0.0}])
    *_, doubled, isola = diagram.branches
    expected = [("PD", -(0.1875**0.5)), ("PD", 0.1875**0.5), ("LP", 0.5), ("LP", -0.5)]
    assert [(item.type, pytest.approx(item.value)) for item in isola.special] == expected
    assert [item.leads_to for item in isola.special[:2]] == [doubled.id] * 2
    assert {isola.stopped.kind, doubled.stopped.kind} == {"closed"}
    assert sorted(end.value for end in doubled.ends) == pytest.approx([-(0.1875**0.5), 0.1875**0.5])
    assert set(where_it_began) == {"failed"}


def test_a_cycle_that_settled_closes_on_the_doubling_it_does_not_know():
    # Its halves differ by 0.1 and 1e-3 at the last two orbits. The parameter is an even function of
    # that, so what is left out has the size of the product of the squares.
    system, steps = model_named("lure"), sf.Steps(largest=0.1)
    ((_, doubling), *_) = sf.response(system, "a", (0.64, 0.62), settled=True).special
    settings = sf.Settings(largest_period=1, steps=steps)
    (branch,) = sf.response(system, "a", (0.61, 0.7), settled=True, settings=settings).branches
    assert "the period doubling of a cycle of half its duration" in branch.stopped.reason
    assert branch.stopped.value == pytest.approx(doubling.value, abs=2e-8)
    doubled, parent = sf.response(system, "a", (0.61, 0.7), settled=True).branches
    assert [(item.type, item.leads_to) for item in parent.special] == [("PD", doubled.id)]


def test_equilibria_that_cycles_shrink_to_are_followed_and_the_cycles_once():
    isola = {
        "z": {"rate": "1 - p^2 - (z - 2)^2", "start": 3},
        "x": {"rate": "h*x - y", "start": 0.5},
        "y": "h*y + x",
    }
    system = sf.System(parameters={"p": 0}, formulas={"h": "z - 2.5 - x^2 - y^2"}, states=isola)
    diagram = sf.response(system, vary="p", span=(-2, 2), also=[{"p": 0.0}])
    cycles, equilibria = diagram.branches
    leads = [(item.type, item.leads_to) for item in equilibria.special]
    assert leads.count(("HB", cycles.id)) == 2
    assert {equilibria.stopped.kind, cycles.stopped.kind} == {"closed"}
    assert cycles.stopped.value == pytest.approx(-cycles.started.value)


def test_a_pendulum_that_swings_past_the_horizontal_closes_on_no_doubling():
    """Halves of the period then differ by half a turn; AUTO-07p finds the fold at 1.5126263."""
    pendulum = sf.System(
        name="pendulum on a moving support",
        parameters={"W": 2},
        states={"th": {"rate": "v", "angle": True}, "v": "-0.1*v - (1 + 0.1*W^2*cos(W*t))*sin(th)"},
        forcing={"period": "2*pi/W"},
    )
    rest, swinging = sf.response(pendulum, vary="W", span=(1.5, 2.3)).branches
    assert [item.type for item in rest.special] == ["PD", "PD"]
    (fold,) = swinging.special
    assert (fold.type, fold.value) == ("LP", pytest.approx(1.5126263, abs=1e-6))
    ends = swinging.started, swinging.stopped
    assert [end.value for end in ends] == pytest.approx([item.value for item in rest.special])


def test_what_sticking_cycles_close_on_is_compared_where_contacts_do_something_else():
    # The cycle of half the duration is no number in terms of some pieces of the doubled branch.
    laws = [sf.RationalStribeck(mu_s=mu_s, d=3.0) for mu_s in (1.0, 1.3)]
    given = {"load": 1.0, "Vd": 0.2}
    contacts = [
        sf.FrictionContact(name, law, name=f"c{name}", **given)
        for name, law in zip("ab", laws, strict=True)
    ]
    stiffness = [[2.2, -1.2], [-1.2, 2.2]]
    blocks = sf.Structure([[1, 0], [0, 1]], None, stiffness, names=["a", "b"], contacts=contacts)
    start = {"mu_s_cb": 1.3, "a": 0.0}
    diagram = sf.response(blocks, "mu_s_cb", (0.97, 1.31), start=start, settled=True)
    doubled, parent = diagram.branches
    (doubling,) = (item for item in parent.special if item.type == "PD")
    assert doubled.started.kind == "closed"
    assert doubled.started.value == pytest.approx(doubling.value, abs=1e-7)
