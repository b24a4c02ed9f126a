"""Loci of cycles against responses in one parameter, other integrators and exact symmetries."""

from functools import lru_cache
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import slipfold as sf
from slipfold.bifurcations.loci.locus_equations import LocusEquations
from slipfold.bifurcations.loci.start import _at_parent
from slipfold.models.registry import model_named
from slipfold.orbits.kinds import orbits_of

QUIET = sf.Settings(largest_period=1)
WINDOW = ((0.4, 0.9), (0.7, 1.4))


@lru_cache
def doubling(**parameters):
    """The first PD of the Lur'e system's cycle."""
    model = model_named("lure").replace(**parameters)
    first = 1.05 / model.b
    diagram = sf.response(model, vary="a", span=(first, 0.3), settings=QUIET)
    return next(item.point for item in diagram.special if item.point.type == "PD")


@lru_cache
def lure_locus(plane=("a", "b")):
    window = WINDOW if plane == ("a", "b") else WINDOW[::-1]
    return sf.locus(doubling(), plane, window)


def test_doublings_of_lure_are_those_of_responses():
    (locus,) = lure_locus().loci
    assert (locus.type, locus.kind, locus.period) == ("PD", "periodic", 1)
    for row in (0, len(locus) // 2, -1):
        a, b = locus.values[row]
        alone = doubling(b=float(b))
        assert alone.value == pytest.approx(a, abs=1e-9)
        assert alone.duration == pytest.approx(locus.durations[row], abs=1e-8)
        assert alone.coefficient == pytest.approx(locus.coefficient[row], rel=1e-5)


def test_cycles_of_a_locus_under_another_integrator():
    # The monodromy matrix by SciPy: multipliers 1, -1, and the third from the mean divergence -a.
    (locus,) = lure_locus().loci
    for row in (0, len(locus) // 2, -1):
        (a, b), duration = locus.values[row], locus.durations[row]

        def rates(time, q, a=a, b=b):
            x, y, z = q[:3]
            jacobian = np.array([[0, 1, 0], [0, 0, 1], [2 * x - 1, -b, -a]])
            matrix = jacobian @ q[3:].reshape(3, 3)
            return [y, z, -a * z - b * y - x + x * x, *matrix.ravel()]

        start = np.concatenate([locus.states[row], np.eye(3).ravel()])
        end = solve_ivp(rates, (0, duration), start, "DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
        assert end[:3] == pytest.approx(locus.states[row], abs=1e-8)
        found = np.sort(np.linalg.eigvals(end[3:].reshape(3, 3)).real)
        assert found == pytest.approx([-1, -np.exp(-a * duration), 1], abs=1e-7)
        assert np.sort(locus.multipliers[row].real) == pytest.approx(found, abs=1e-7)


def test_a_locus_of_cycles_is_known_in_any_phase():
    # Of the same doubling started elsewhere on the cycle there is no second locus.
    point = doubling(b=1.05)
    later = sf.SpecialPoint(
        **{
            **{name: getattr(point, name) for name in point.__dataclass_fields__},
            "nodes": np.roll(point.nodes, -3, axis=0),
        }
    )
    found = sf.locus([doubling(), later], ("a", "b"), WINDOW)
    assert len(found.loci) == 1


def test_folds_and_tori_of_freire():
    # AUTO's demo tor: at r = 0.6 the fold of cycles is at n = -0.584335, period 8.42647.
    model = model_named("freire")
    diagram = sf.response(model, vary="n", span=(-0.55, -0.592), settings=QUIET)
    point = next(item.point for item in diagram.special if item.point.type == "LP")
    found = sf.locus(point, ("n", "r"), ((-0.59, -0.57), (0.58, 0.62)), switch=False)
    (locus,) = found.loci
    assert (locus.type, locus.kind) == ("LP", "periodic")
    row = int(np.abs(locus.values[:, 1] - 0.6).argmin())
    assert locus.values[row] == pytest.approx([point.value, 0.6], abs=1e-9)
    for end in (locus.started, locus.stopped):
        assert end.kind == "window"
    # The mirror image of a cycle of this circuit is a cycle too, at the same parameters.
    mirrored = sf.SpecialPoint(
        **{
            **{name: getattr(point, name) for name in point.__dataclass_fields__},
            "nodes": -point.nodes,
        }
    )
    (other,) = sf.locus(mirrored, ("n", "r"), ((-0.59, -0.57), (0.58, 0.62)), switch=False).loci
    assert np.array(other.started.values) == pytest.approx(locus.started.values, abs=1e-9)


def test_a_model_and_a_type_are_enough(few_lines):
    found = sf.locus(model_named("lure"), ("a", "b"), ((0.95, 1.05), (0.95, 1.05)), type="hb")
    (locus,) = found.loci
    assert locus.values.prod(axis=1) == pytest.approx(1, abs=1e-12)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda m, p: sf.locus(p, ("a", "b"), WINDOW, type="HB"), "goes with a model"),
        (lambda m, p: sf.locus(m, ("a", "b"), WINDOW, type="CH"), "no loci of type 'CH'"),
        (lambda m, p: sf.locus(m, ("a", "b"), WINDOW, switch=False), "a model is given"),
        *(
            (lambda m, p, k=k: sf.bifurcation_set(m, ("a", "b"), WINDOW, **k), "lure is autonomous")
            for k in ({"regions": True}, {"regimes": (3, 3)})
        ),
        (
            lambda m, p: sf.locus(
                sf.SlidingOscillator(), ("f", "Nd"), ((12, 13), (0, 0.5)), type="HB"
            ),
            "no loci of type 'HB' of sliding, which is forced",
        ),
    ],
)
def test_what_cannot_be_done_is_refused(call, words):
    with pytest.raises(sf.InputError, match=words):
        call(model_named("lure"), doubling())


def test_a_tongue_of_entrainment_ends_where_nothing_forces():
    # z' = (1 + i) z - |z|^2 z + F exp(i W t): near F = 0 the cycle |z| = 1 is entrained for
    # |W - 1| < F, and its phase is arbitrary at the tip, where steps failed.
    model = sf.System(
        name="entrained",
        parameters={"W": 1.0, "F": 0.1},
        states={
            "x": {"rate": "x - y - x*(x^2 + y^2) + F*cos(W*t)", "start": 1},
            "y": "x + y - y*(x^2 + y^2) + F*sin(W*t)",
        },
        forcing={"period": "2*pi/W", "amplitude": "F"},
    )
    given = {"vary": "W", "span": (1, 1.2), "start": {"W": 1, "x": 1}, "settled": True}
    fold = sf.response(model, **given).branches[0].special[0]
    window = {"W": (0.7, 1.3), "F": (0, 0.3)}
    (locus,) = sf.locus(fold, ("W", "F"), window, switch=False).loci
    assert [end.kind for end in locus.ends] == ["window", "window"]
    assert "F = 0" in locus.started.reason
    near = locus.values[:, 1] < 1e-3
    assert near.sum() > 3
    assert locus.values[near, 0] - 1 == pytest.approx(locus.values[near, 1], rel=1e-3, abs=1e-12)


@pytest.mark.parametrize(
    ("radius", "turns", "becomes"),
    [(1.0, 2, "become those of half the period"), (1e-3, 1, "shrink to an equilibrium")],
)
def test_what_the_orbits_of_a_locus_become_where_their_halves_are_the_same(radius, turns, becomes):
    # A cycle that settled after it had doubled is one of period 1, and was said to shrink.
    model = sf.System(
        name="hopf",
        parameters={"p": 1.0, "q": 1.0},
        states={"x": "p*x - q*y - x*(x^2 + y^2)", "y": "q*x + p*y - y*(x^2 + y^2)"},
    ).replace(duration=2 * np.pi * turns)
    orbits = orbits_of(model.with_scales(np.ones(2)), {"p": 1.0, "q": 1.0}, 1, 8)
    angles = 2 * np.pi * turns * np.arange(8) / 8
    nodes = radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    last = SimpleNamespace(z=orbits.unknown(nodes, model))
    end = _at_parent(LocusEquations(orbits, "LP"), last, None).end
    assert end.reason == f"the locus ends where its orbits {becomes}"


def test_doubled_cycles_are_known_whichever_period_they_are_counted_with():
    # A trajectory that settles on a doubled cycle does not know that it has doubled.
    model, points = model_named("lure"), []
    for first, largest in ((0.66, 2), (0.58, 1)):
        span, settings = (first, 0.54), sf.Settings(largest_period=largest)
        diagram = sf.response(model, vary="a", span=span, settled=True, settings=settings)
        points += [item.point for item in diagram.special if item.point.value < 0.6][:1]
    assert [(point.type, point.period) for point in points] == [("PD", 2), ("PD", 1)]
    for order, discretization in ((points, "automatic"), (points[::-1], "collocation")):
        found = sf.locus(
            order,
            ("a", "b"),
            ((0.5, 0.65), (0.9, 1.1)),
            switch=False,
            settings=sf.Settings(discretization=discretization),
        )
        assert [(locus.type, locus.period) for locus in found.loci] == [("PD", order[0].period)]
