"""Systems of equations are models like any other."""

import copy
import inspect
import pickle
import tomllib

import heyoka as hy
import numpy as np
import pytest

import slipfold as sf
import slipfold.branches.event
from helpers.duffing_text import TEXT
from helpers.textbook_models import Duffing
from slipfold.errors import InputError
from slipfold.flow import flow_of
from slipfold.models.definitions.definition import _TAKEN, MEASURES
from slipfold.models.evaluation import evaluation_of
from slipfold.models.formulas.grammar import format_tree


@pytest.fixture(scope="module")
def model():
    return sf.System.from_toml(TEXT)


# -- a model like any other --------------------------------------------------------------------


def test_it_is_what_the_text_says(model):
    assert (model.name, model.title, model.quiet) == ("Duffing", "a cubic spring", "F")
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


def test_one_compiled_flow_serves_all_parameters(model):
    again = sf.System(tomllib.loads(TEXT))
    assert again == model
    assert flow_of(model.replace(W=1.1)) is flow_of(again)


def test_equal_definitions_are_equal_however_they_are_written(model):
    assert sf.System.from_toml(model.to_toml()) == model
    assert sf.System(model.to_toml()).to_toml() == model.to_toml()
    assert sf.System(**tomllib.loads(TEXT)) == model
    other = TEXT.replace("# name = its rate", "").replace("F = 0.18", "F = {value = 18e-2}")
    assert sf.System.from_toml(other) == model
    assert sf.System.from_toml(TEXT.replace("0.05", "0.06")) != model


def test_values_may_be_given_at_once(model):
    assert sf.System(TEXT, W=1.2, F="0.3") == model.replace(W=1.2, F=0.3)
    with pytest.raises(InputError, match=r"no parameter 'w'; did you mean W\?"):
        sf.System(TEXT, w=1.2)
    with pytest.raises(InputError, match="both a definition and states are given"):
        sf.System(TEXT, states={"q": "1"})
    with pytest.raises(InputError, match="the definition is a int"):
        sf.System(3)


def test_a_file_names_itself(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text('[states]\r\nq = "-q"\r\n')
    assert sf.System.from_toml(path).name == "mine"
    assert sf.System.from_toml(str(path)).name == "mine"
    path.write_text('[states]\r\nq = "-q +"\r\n')
    with pytest.raises(InputError, match=r"mine.toml, line 2, column 10: the formula ends"):
        sf.System.from_toml(path)
    with pytest.raises(InputError, match=r"no.toml cannot be read \(no such file"):
        sf.System.from_toml("no.toml")
    path.write_bytes(b"\xff\xfe")
    with pytest.raises(InputError, match="cannot be read"):
        sf.System.from_toml(path)


def test_coefficients_are_the_largest_parts_without_states(model):
    equations = model._built.equations
    terms = {key: format_tree(tree) for key, tree in equations.terms.items()}
    assert terms == {"k1": "stiff", "k2": "g", "k3": "W*(2*pi/W)", "k4": "F", "k5": "g/4"}
    assert format_tree(equations.named["force"]) == "@k4*cos(@k3*@phase)"
    system = sf.System(
        parameters={"m": 2.0, "k": 3.0, "c": 0.1},
        states={"x": "v", "v": "-(2*c*v/m + k*x/m) + (k/m + 1)*2*x^2*3*(2*x*m)^2 + sqrt(k/m)*1"},
    )
    terms = {key: format_tree(tree) for key, tree in system._built.equations.terms.items()}
    assert sorted(terms.values()) == [
        "(k/m + 1)*2*3*(2*m)^2",
        "2*c/m",
        "k/m",
        "sqrt(k/m)*1",
    ]
    p = {name: hy.expression(name) for name in system.values}
    assert all(isinstance(value, hy.expression) for value in system.coefficients(p).values())
    assert system.coefficients(system.values)["k2"] == 1.5


def test_orbits_of_several_periods_keep_the_time_running():
    # Subharmonic of order 1/2 of a linear oscillator: q = cos(W t/2) exactly.
    system = sf.System(
        parameters={"W": 2.0},
        states={"q": "v", "v": "-q + 0.1*(cos(W*t) - (2*q^2 - 1))"},
        forcing={"period": "2*pi/W"},
    )
    orbit = sf.periodic_orbit(system, period=2, state=[1.0, 0.0])
    assert orbit.state == pytest.approx([1.0, 0.0], abs=1e-9)
    _, values = orbit.output("q", 64)
    assert values == pytest.approx(np.cos(2 * np.pi * np.arange(64) / 64), abs=1e-9)


def test_an_autonomous_system_is_simulated_in_seconds():
    decay = sf.System(parameters={"k": 0.5}, states={"q": "-k*q", "s": "1"})
    assert not decay.forced
    motion = sf.simulate(decay, 4, {"q": 1.0})
    assert motion.strobe[:, 0] == pytest.approx(np.exp(-0.5 * np.arange(5)), abs=1e-13)
    assert motion.strobe[:, 1] == pytest.approx(np.arange(5))
    assert decay.duration == 1
    longer = sf.simulate(decay, 4, {"q": 1.0}, duration=2.5)
    assert longer.strobe[:, 0] == pytest.approx(np.exp(-1.25 * np.arange(5)), abs=1e-13)
    assert "duration" not in decay.to_toml()
    assert pickle.loads(pickle.dumps(decay.replace(duration=3))).duration == 3


def test_a_limit_ends_a_motion():
    falling = sf.System(
        parameters={"g": 9.81},
        states={"h": {"rate": "v", "start": 10}, "v": "-g"},
        limits={"ground": {"output": "h", "bound": 0}},
    )
    motion = sf.simulate(falling, 10, falling.start)
    assert motion.stopped.kind == "ground"
    assert motion.stopped.time == pytest.approx(np.sqrt(20 / 9.81), rel=1e-9)
    assert motion.stopped.reason.startswith("ground: h fell to")


def test_no_parameter_hides_an_attribute_or_argument():
    names = {name for name in dir(sf.System) if not name.startswith("_")}
    for function in (sf.response, sf.simulate, sf.bifurcation_set, sf.System.__init__):
        arguments = inspect.signature(function).parameters.values()
        names |= {item.name for item in arguments if item.kind is not item.VAR_KEYWORD}
    assert names <= _TAKEN


def test_events_have_the_measures_of_branches():
    assert MEASURES == slipfold.branches.event.MEASURES


def test_a_byte_order_mark_is_no_trouble(model):
    assert sf.System.from_toml("\ufeff" + TEXT) == model


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
