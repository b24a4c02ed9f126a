"""Relaxation oscillators: cycles that are slow and fast in turn, and canards among them."""

import numpy as np
import pytest

import slipfold as sf

BY_COLLOCATION = sf.Settings(discretisation="collocation", largest_period=1)


def fitzhugh_nagumo(eps):
    """FitzHugh, Biophysical Journal 1 (1961) 445-466, with his a = 0.7 and b = 0.8."""
    return sf.System(
        name="fitzhugh-nagumo",
        parameters={"I": 0.0, "eps": eps},
        states={
            "v": {"rate": "v - v^3/3 - w + I", "start": -1.2},
            "w": {"rate": "eps*(v + 0.7 - 0.8*w)", "start": -0.6},
        },
    )


def hopf_current(eps):
    """Where the trace 1 - v^2 - 0.8 eps of the Jacobian vanishes."""
    v = -np.sqrt(1 - 0.8 * eps)
    return (v + 0.7) / 0.8 - v + v**3 / 3


def closes_by_radau(orbit):
    """How far a stable orbit fails to close by an implicit Runge-Kutta method of order five."""
    from scipy.integrate import solve_ivp

    model = orbit.model
    current, eps = model.values["I"], model.values["eps"]

    def rates(_, y):
        return [y[0] - y[0] ** 3 / 3 - y[1] + current, eps * (y[0] + 0.7 - 0.8 * y[1])]

    span = (0.0, orbit.duration)
    end = solve_ivp(rates, span, orbit.state, method="Radau", rtol=1e-10, atol=1e-12).y[:, -1]
    return float(np.abs(end - orbit.state).max())


@pytest.fixture(scope="module")
def spiking():
    """From rest to spikes; the branch of cycles goes through its canards and turns at a fold."""
    return sf.response(fitzhugh_nagumo(0.08), vary="I", span=(0.3, 0.4), settings=BY_COLLOCATION)


def test_the_fold_of_cycles_beyond_the_canards_is_found(spiking):
    rest, cycles = spiking.branches
    assert [item.type for item in rest.special] == ["HB"]
    assert rest.special[0].value == pytest.approx(hopf_current(0.08), abs=1e-12)
    assert rest.special[0].criticality == "subcritical"
    assert [item.type for item in cycles.special] == ["LP"]
    # Known before collocation was written; shooting, told where to look, has 0.32417852250371 too.
    assert cycles.special[0].value == pytest.approx(0.324178522504, abs=1e-11)
    assert cycles.stopped.kind == "span"


def test_what_it_leads_to_are_the_spikes_that_a_stiff_integrator_finds(spiking):
    cycles = spiking.branches[1]
    assert cycles.stable[-1]
    assert closes_by_radau(cycles.orbit(len(cycles) - 1)) < 1e-8


@pytest.mark.parametrize("eps", [0.04])
def test_sharp_canards_are_gone_through_at_both_ends_of_the_spikes(eps):
    """Turning v, w and I round (0, 7/8, 7/8) leaves the equations as they are.

    Asked for nothing, a branch changes from shooting to collocation where it has to.
    """
    folds = []
    for span, settings in (((0.305, 0.32), None), ((1.445, 1.43), BY_COLLOCATION)):
        rest, cycles = sf.response(
            fitzhugh_nagumo(eps), vary="I", span=span, settings=settings
        ).branches
        assert [item.type for item in rest.special] == ["HB"]
        assert [item.type for item in cycles.special] == ["LP"]  # a plane has no period doubling
        assert cycles.stopped.kind == "span"
        assert (cycles.multipliers.real > 0).all()
        folds.append(cycles.special[0].value)
    assert sum(folds) == pytest.approx(1.75, abs=1e-10)


def watched(fast):
    """The neuron, and x' = -k (x - v): it decays by exp(-k T) a round and leaves v and w alone."""
    return sf.System(
        name="watched",
        parameters={"I": 0.0},
        states={
            "v": {"rate": "v - v^3/3 - w + I", "start": -1.2},
            "w": {"rate": "0.08*(v + 0.7 - 0.8*w)", "start": -0.6},
            "x": {"rate": f"-{fast}*(x - v)", "start": -1.2},
        },
    )


@pytest.mark.parametrize("fast", [1e3, 1e6])
def test_the_multipliers_of_a_neuron_are_the_same_beside_what_decays_at_once(fast):
    """In the plane they are known from the divergence alone (Liouville)."""
    window = {"vary": "I", "span": (0.328, 0.334), "settings": BY_COLLOCATION}
    alone = sf.response(fitzhugh_nagumo(0.08), **window).branches[1].multipliers[-1]
    beside = sf.response(watched(fast), **window).branches[1].multipliers[-1]
    assert alone[0].real > 1.1
    assert beside.real == pytest.approx([*alone.real, 0.0], abs=1e-7)


@pytest.mark.parametrize("fast", [10.0, pytest.param(1e6, marks=pytest.mark.long)])
def test_what_follows_a_neuron_and_feeds_nothing_changes_nothing(fast):
    rest, cycles = sf.response(watched(fast), vary="I", span=(0.31, 0.34)).branches
    # An eigenvalue of 1e6 rounds the others by 1e-10.
    assert rest.special[0].value == pytest.approx(hopf_current(0.08), abs=1e-10)
    assert [item.type for item in cycles.special] == ["LP"]
    assert cycles.special[0].value == pytest.approx(0.324178522504, abs=1e-10)
    assert cycles.stopped.kind == "span"
