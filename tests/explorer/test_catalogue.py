"""What is offered: every built-in model, with sliders that its parameters may take."""

import json
import math
import re
from unittest.mock import Mock

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import slipfold as sf
from helpers.dry_friction import FORCED_SLIDER
from helpers.explorer_models import RAYLEIGH
from slipfold import InputError
from slipfold.interface.explorer import first_views
from slipfold.interface.explorer.catalogue import Catalogue
from slipfold.interface.explorer.first_views import send_screen
from slipfold.interface.explorer.messages import ScreenRequest, parse_request
from slipfold.interface.explorer.plain import plain_text

DESCRIBED = {item["name"]: item for item in Catalogue().describe()}


def test_every_built_in_model_is_offered():
    assert list(DESCRIBED) == list(sf.built_in_models())
    json.dumps(DESCRIBED, allow_nan=False)


@pytest.mark.parametrize("name", DESCRIBED)
def test_sliders_go_where_the_model_allows(name):
    model = sf.built_in_models()[name]()
    for slider in DESCRIBED[name]["parameters"]:
        parameter = model.parameter(slider["name"])
        assert slider["low"] <= slider["value"] <= slider["high"]
        assert slider["low"] < slider["high"]
        parameter.check(slider["low"])
        parameter.check(slider["high"])


@pytest.mark.parametrize("name", DESCRIBED)
def test_the_first_view_names_what_there_is(name):
    view = DESCRIBED[name]["default"]
    model = sf.built_in_models()[name](**view["parameters"])
    parameter = model.parameter(view["vary"])
    assert view["vary"] in DESCRIBED[name]["vary"]
    assert [parameter.check(value) for value in view["span"]] == view["span"]
    assert view["show"] in {item["name"] for item in DESCRIBED[name]["states"]}


def test_the_first_view_of_the_first_model_is_the_papers_figure():
    view = DESCRIBED["sliding"]["default"]
    assert (view["vary"], view["span"], view["show"]) == ("Nd", [0.0, 0.98], "x")


def test_a_belt_in_text_is_first_shown_where_it_moves():
    belt = sf.System(
        name="belt",
        parameters={"Vd": 0.3},
        states={"x": "v", "v": "F - x"},
        contacts={"F": {"slip": "Vd - v", "normal": "1.0", "friction": "Coulomb"}},
    )
    view = Catalogue(belt).describe()[0]["default"]
    assert view["vary"] == "Vd"
    assert view["span"] == pytest.approx([0.0003, 0.6])
    diagram = sf.response(belt, "Vd", view["span"])
    assert diagram.branches[0].stopped.kind == "span"


def test_a_dry_contact_on_a_surface_at_rest_is_first_shown_where_its_force_moves_it():
    contact = sf.FrictionContact("b", sf.Coulomb(0.3, 0.3), load=2.0, Vd=0.0)
    K = [[200.0, -100.0], [-100.0, 100.0]]
    force = sf.HarmonicForce("a", F=4.0)
    rod = sf.Structure(np.eye(2), 0.4 * np.eye(2), K, names="a b", contacts=contact, forcing=force)
    view = Catalogue(rod).describe()[0]["default"]
    assert (view["vary"], view["span"]) == ("F", [2.0, 8.0])
    assert sf.response(rod, "F", view["span"]).branches[0].stopped.kind == "span"


def test_a_model_that_vibrates_by_itself_is_first_shown_where_it_begins_to():
    view = Catalogue(sf.System.from_toml(RAYLEIGH)).describe()[0]["default"]
    assert (view["vary"], view["span"]) == ("eps", [-0.5, 1.0])
    # Three masses: the load makes steady sliding unstable far below its own value.
    K = [[200.0, -100, 0], [-100, 200, -100], [0, -100, 100]]
    law = sf.Stribeck(mu_s=0.6, mu_k=0.3, vs=0.4)
    contact = sf.FrictionContact("c", law, load=10.0, Vd=0.5)
    chain = sf.Structure(np.eye(3), 2e-4 * np.array(K), K, names="a b c", contacts=contact)
    view = Catalogue(chain).describe()[0]["default"]
    assert (view["vary"], view["span"][1]) == ("Ns", 20)
    points = sf.response(chain, view["vary"], (1.5, view["span"][0])).special
    assert "HB" in {item.point.type for item in points}


def screened(model, vary):
    answers = []
    request = ScreenRequest(kind="screen", id=1, model=model.name, vary=vary)
    send_screen(model, request, answers.append, lambda: None)
    return answers


def test_a_forced_model_is_looked_through_for_a_parameter_with_a_bifurcation():
    duffing = sf.built_in_models()["duffing"]().replace(W=1.2)
    (found,) = screened(duffing, "d")
    assert found["vary"] != "d"
    points = sf.response(duffing, found["vary"], found["span"]).branches[0].special
    assert (found["type"], found["value"]) == (points[0].type, pytest.approx(points[0].value))
    linear = sf.System(
        name="linear",
        parameters={"F": 1, "W": {"value": 1.3, "above": 0}},
        states={"q": "v", "v": "F*cos(W*t) - 0.3*v - q"},
        forcing={"period": "2*pi/W"},
    )
    (found,) = screened(linear, "F")
    assert (found["vary"], found["type"]) == ("W", None)


def test_a_contact_that_sticks_for_good_is_shown_over_a_parameter_that_lets_it_slip():
    contact = sf.FrictionContact("b", sf.Coulomb(mu_k=0.3), load=2.0, Vd=0.0)
    K, force = 0.05 * np.array([[2, -1], [-1, 1]]), sf.HarmonicForce("a", F=0.2)
    chain = sf.Structure(np.eye(2), K, K, names="a b", f=0.05, contacts=contact, forcing=force)
    vary, _ = first_views.chosen_span(chain)
    (found,) = screened(chain, vary)
    assert sf.periodic_orbit(chain.replace(**{found["vary"]: found["value"]})).period == 1


def test_a_parameter_over_which_nothing_can_be_computed_does_not_end_the_search(monkeypatch):
    monkeypatch.setattr(first_views, "response", Mock(side_effect=ZeroDivisionError))
    assert screened(sf.built_in_models()["duffing"](), "d") == [{"vary": None, "done": True}]


def test_a_mathieu_equation_is_first_shown_over_the_threshold_of_its_tongue():
    default = DESCRIBED["mathieu"]["default"]
    model = sf.built_in_models()["mathieu"]()
    (point,) = sf.response(model, default["vary"], default["span"]).special
    assert point.point.type == "PD"
    assert point.point.value == pytest.approx(0.04, rel=1e-3)  # 4 zeta at resonance


def test_no_slider_goes_where_a_law_does_not():
    belt = sf.System.from_toml(
        FORCED_SLIDER.replace('"0.6"', '"mu"').replace("F = 0.6", "F = 0.6, mu = 0.5")
    )
    sliders = {item["name"]: item["low"] for item in Catalogue(belt).describe()[0]["parameters"]}
    assert sliders["mu"] == pytest.approx(0.3, abs=1e-3)
    belt.replace(mu=sliders["mu"])


def test_a_model_called_as_a_built_in_one_is_described_by_its_own_parameters():
    """The name alone says nothing: what is known of W is for the W of the package."""
    own = sf.System(
        name="duffing",
        parameters={"g": 1, "W": {"value": 40, "above": 30}, "turn": {"value": 1, "unit": "rad"}},
        states={"z": "g + W*sin(turn) - z"},
    )
    (described, *_) = Catalogue(own).describe()
    view = described["default"]
    assert (view["vary"], view["show"], view["span"]) == ("g", "z", [0.0, 2.0])
    sliders = {item["name"]: (item["low"], item["high"]) for item in described["parameters"]}
    assert sliders == {"g": (0, 2), "W": (30.04, 80), "turn": (-math.pi, math.pi)}


def test_whatever_a_model_is_called_it_can_be_asked_for():
    names = [f"p{i}" for i in range(70)]
    own = sf.System(
        name="../pad\\Bremse Ä: 2" + "x" * 300,
        parameters=dict.fromkeys(names, 1.0),
        states={"q": f"{'+'.join(names)}-q"},
    )
    catalogue = Catalogue(own)
    described = catalogue.describe()[0]
    values = {item["name"]: item["value"] for item in described["parameters"]}
    request = parse_request(
        json.dumps(
            {"kind": "simulation", "id": 1, "model": described["name"], "parameters": values}
        )
    )
    assert catalogue.of(request) == own


def test_a_model_with_nothing_to_vary_is_refused():
    with pytest.raises(InputError, match="no parameter that may be varied"):
        Catalogue(sf.System(states={"q": "-q"}))


def test_an_unknown_model_is_refused_with_a_suggestion():
    with pytest.raises(InputError, match=r"there is no model 'dufing'.*duffing"):
        Catalogue().model("dufing", {})


@pytest.mark.parametrize(
    ("values", "refused"),
    [
        ({"Nd": 0.5, "Ns": 1.0}, {}),
        ({"Vd": -1.0, "mu": -2.0, "f": 12.0}, {"Vd": "Vd = -1 is", "mu": "mu = -2 is"}),
        ({"Nd": 5.0, "Ns": 1.0, "f": 12.0}, {"Nd": "Nd = 5 N is not below Ns = 1 N"}),
        ({"Nd": 0.5, "Ns": 0.4}, {"Nd": "Nd = 0.5 N is not", "Ns": "Nd = 0.5 N is not"}),
    ],
)
def test_each_value_that_cannot_be_had_is_named(values, refused):
    found = Catalogue().refusals("sliding", values)
    assert found.keys() == refused.keys()
    assert all(found[name].startswith(refused[name]) for name in refused)


@pytest.mark.parametrize(
    ("formula", "text"),
    [
        (r"$k_{ext}$", "kext"),
        (r"$\zeta_1$", "ζ₁"),
        (r"$V_{rel}/V_d$", "Vrel/Vd"),
        (r"$\arg F$ (rad)", "arg F (rad)"),
        (r"$\varepsilon$", "ε"),
        (r"$\dot\vartheta_{\mathrm{ext}}$ (rad/s)", "ϑ̇ext (rad/s)"),
        (r"$\Upsilon\,\iota$", "Υ ι"),
        ("x", "x"),
    ],
)
def test_formulas_become_plain_text(formula, text):
    assert plain_text(formula) == text


def test_no_two_quantities_of_a_list_look_alike_and_no_letter_is_a_word():
    for described in DESCRIBED.values():
        for shown in (described["parameters"], [*described["states"], *described["outputs"]]):
            labels = [item["label"] for item in shown]
            assert len(set(labels)) == len(labels)
            assert not any(re.search("epsilon|theta|phi|sigma|rho", label) for label in labels)


@given(st.text(max_size=30))
def test_any_text_becomes_plain(text):
    assert "$" not in plain_text(text)
