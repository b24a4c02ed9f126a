"""All programs of the benchmarks get the same systems."""

from __future__ import annotations

import importlib
import math
from pathlib import Path

import numpy as np
import pytest

from slipfold import System
from slipfold.models.model import evaluation_of
from slipfold.models.registry import model_named

BENCH = Path(__file__).parents[2] / "bench"


@pytest.fixture
def bench(monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.syspath_prepend(str(BENCH))
    return BENCH


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
