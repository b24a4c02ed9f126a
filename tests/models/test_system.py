"""Systems of equations are models like any other."""

import copy
import inspect
import pickle
import tomllib

import numpy as np
import pytest

import slipfold as sf
import slipfold.bifurcations.branches.settings
from helpers.duffing_text import TEXT
from helpers.textbook_models import Duffing
from slipfold.models.definitions.system_file import _TAKEN
from slipfold.models.model import evaluation_of


@pytest.fixture(scope="module")
def model():
    return sf.System.from_toml(TEXT)


# -- a model like any other --------------------------------------------------------------------


def test_it_is_what_the_text_says(model):
    assert (model.name, model.title, model.forcing_amplitude) == ("Duffing", "a cubic spring", "F")
    assert [state.name for state in model.states] == ["q", "v"]
    assert model.parameter("W").bounds == "> 0 rad/s"
    assert model.parameter("g").bounds == "<= 10"
    assert [item.name for item in model.outputs()] == ["energy", "force"]
    assert (model.outputs()[1].unit, model.outputs()[1].label) == ("N", "$F$")
    assert model.limits == (sf.Limit("too far", "energy", -1.0, "energy fell to {value:.3g}"),)
    assert model.start.tolist() == [0.5, 0.0]
    assert model.forced
    (event,) = model.events
    assert (event.name, event.output, event.value, event.measure, event.stop) == (
        "large", "q", 2.0, "max", True,
    )  # fmt: skip


def test_rates_jacobian_and_period_are_those_written_by_hand(model):
    mine, other = model.replace(W=1.3, F=0.4, g=0.2), Duffing(w=1.3, a=0.4, g=0.2)
    state = np.array([0.7, -0.4])
    for phase in (0.0, 0.3, 2.8):
        for name in ("rates", "jacobian"):
            found, expected = (
                getattr(evaluation_of(item), name)(item, state, phase) for item in (mine, other)
            )
            assert found == pytest.approx(expected, abs=1e-14)
    assert evaluation_of(mine).period(mine) == pytest.approx(2 * np.pi / 1.3, rel=1e-15)
    time = 1.7
    assert mine.evaluate("force", state, time) == pytest.approx(0.4 * np.cos(1.3 * time))
    assert mine.evaluate("energy", state) == pytest.approx(0.08 + 0.245 + 0.05 * 0.7**4)


def test_copies_pickles_and_replacements(model):
    for other in (pickle.loads(pickle.dumps(model)), copy.deepcopy(model), model.replace()):
        assert other == model
        assert hash(other) == hash(model)
    changed = model.replace(W="1.2 rad/s")
    assert changed != model
    assert changed.W == 1.2
    assert changed.replace(W=0.9) == model
    assert repr(changed) == "System('Duffing', W=1.2)"
    with pytest.raises(AttributeError, match=r"model.replace\(W=...\)"):
        model.W = 1.0


def test_equal_definitions_are_equal_however_they_are_written(model):
    assert sf.System.from_toml(model.to_toml()) == model
    assert sf.System(model.to_toml()).to_toml() == model.to_toml()
    assert sf.System(**tomllib.loads(TEXT)) == model
    other = TEXT.replace("# name = its rate", "").replace("F = 0.18", "F = {value = 18e-2}")
    assert sf.System.from_toml(other) == model
    assert sf.System.from_toml(TEXT.replace("0.05", "0.06")) != model


def test_no_parameter_hides_an_attribute_or_argument():
    names = {name for name in dir(sf.System) if not name.startswith("_")}
    for function in (sf.response, sf.simulate, sf.bifurcation_set, sf.System.__init__):
        arguments = inspect.signature(function).parameters.values()
        names |= {item.name for item in arguments if item.kind is not item.VAR_KEYWORD}
    assert names <= _TAKEN


def test_large_systems_load_in_no_time():
    count = 200
    states = {f"q{i}": f"q{(i + 1) % count} - 2*k*q{i} + F*cos(W*t)" for i in range(count)}
    formulas = {f"f{i}": f"f{i + 1}*f{i + 1}" for i in range(40)} | {"f40": "q0"}
    system = sf.System(
        parameters={"k": 1.0, "F": 1.0, "W": 1.0},
        formulas=formulas,
        states={**states, "q0": "-f0"},
        forcing={"period": "2*pi/W"},
    )
    assert len(system.states) == count
