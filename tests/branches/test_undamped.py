"""Without damping all multipliers come in pairs whose product is one: most lie on the circle."""

import pytest

import slipfold as sf


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


@pytest.mark.parametrize("span", [(0.6, 2), (2, 0.6)])
def test_a_linear_oscillator_without_damping_runs_away_at_its_resonance(span):
    # x = sin(W t)/(1 - W^2); beyond an amplitude of 6e5 rounding made a dozen branch points.
    states = {"x": "v", "v": "-x + sin(W*t)"}
    model = sf.System(
        name="linear", parameters={"W": 1.5}, states=states, forcing={"period": "2*pi/W"}
    )
    (branch,) = sf.response(model, vary="W", span=span).branches
    assert not branch.special
    assert branch.stopped.kind == "unresolved"
    assert branch.stopped.reason.startswith("the orbit runs away to ")
    assert branch.stopped.value == pytest.approx(1, abs=1e-5)


def test_motions_without_damping_are_followed_where_rounding_is_multiplied():
    # Henon and Heiles, Astronomical Journal 69 (1964) 73-79: beyond the energy 1/6 perturbations
    # grow by 1000 in a round, and rounding of multipliers that are one made steps ever shorter.
    states = {"x": "u", "y": "v", "u": "-x - 2*x*y - d*u", "v": "-y - x^2 + y^2 - d*v"}
    model = sf.System(name="henon-heiles", parameters={"d": 0.0}, states=states)
    settings = sf.Settings(discretization="shooting")
    given = {"vary": "d", "span": (-0.5, 0.5), "settings": settings}
    _, motions = sf.response(model, **given, events=[sf.Event("x", 3.0, stop=True)]).branches
    assert motions.stopped.kind == "event"
    x, y, u, v = motions.nodes[-1].T
    energy = (x**2 + y**2 + u**2 + v**2) / 2 + x**2 * y - y**3 / 3
    assert energy == pytest.approx(energy[0], rel=1e-9)
    assert energy[0] > 10
