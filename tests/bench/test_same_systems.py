"""All programs of the benchmarks get the same systems."""

from __future__ import annotations

import importlib
import math
from pathlib import Path

import numpy as np
import pytest

import slipfold as sf
from slipfold import System
from slipfold.models.model import evaluation_of
from slipfold.models.registry import model_named

BENCH = Path(__file__).parents[2] / "bench"


@pytest.fixture
def bench(monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.syspath_prepend(str(BENCH))
    return BENCH


def test_the_closed_form_of_stick_and_slip_is_what_is_simulated(bench: Path) -> None:
    stick = importlib.import_module("peers.stick")
    W, S = stick.FREQUENCY, stick.FRICTION
    contact = sf.FrictionContact("x", sf.Coulomb(mu_s=S, mu_k=S), load=1.0, Vd=0.0)
    push = sf.HarmonicForce("x", F=1.0)
    model = sf.Structure(
        [[1.0]], None, [[1.0]], names="x", contacts=contact, forcing=push, f=W / (2 * math.pi)
    )
    motion = sf.simulate(model, 5)
    for period in range(6):
        wanted = stick.state_after(period)
        assert motion.strobe[period] == pytest.approx(wanted, abs=1e-12)


@pytest.mark.parametrize("name", ["canards", "relaxation"])
def test_all_programs_get_the_same_oscillators(name: str, bench: Path) -> None:
    oscillator = importlib.import_module("cycles").OSCILLATORS[name]
    first = oscillator.span[0]
    states = {key: {"rate": text} for key, text in oscillator.formulas.items()}
    model = System(name=name, parameters={oscillator.parameter: first}, states=states)
    state = np.array([0.7, -0.4])
    rates = evaluation_of(model).rates(model, state, 0.0)
    assert oscillator.rates(list(state), first) == pytest.approx(rates, rel=1e-13)


@pytest.mark.parametrize("name", ["duffing", "vanderpol", "chain"])
def test_all_programs_get_the_systems_of_slipfold(name: str, bench: Path) -> None:
    system = importlib.import_module("systems").SYSTEMS[name]
    model = model_named(system.model, **{system.parameter: system.span[0]})
    state = np.linspace(-0.4, 0.5, len(system.states))
    rates = system.rates(list(state), math.cos(2 * math.pi * 0.3), system.span[0], math.exp)
    assert rates == pytest.approx(evaluation_of(model).rates(model, state, 0.3), rel=1e-13)
    assert system.period(system.span[0]) == pytest.approx(model.period(model.values))


def test_the_loop_of_thresholds_gets_the_oscillator_at_points_of_the_map(
    bench: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(str(bench / "peers"))
    grid, script = map(importlib.import_module, ("grid", "auto07p_thresholds"))
    speeds, directions = grid.places(grid.SIZE)
    i, j = grid.picked(3)[2]
    model = sf.SlidingOscillator(f=12.5, Vd=speeds[i], alpha=directions[j], Nd=0.0)
    x, y = script.rest((speeds[i] * math.cos(directions[j]), speeds[i] * math.sin(directions[j])))
    rates = evaluation_of(model).rates(model, np.array([x, y, 0.0, 0.0]), 0.0)
    assert rates == pytest.approx(np.zeros(4), abs=1e-8 * 2 * math.pi * 12.5)
