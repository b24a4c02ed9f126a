"""Friction laws of contacts: drawn over the slip speed, and exchanged in the text of the model."""

import math
from pathlib import Path

import pytest

import slipfold as sf
from helpers.explorer_models import BRAKE
from slipfold.interface.explorer.catalogue import Catalogue
from slipfold.interface.explorer.friction import laws_of, send_friction, with_law
from slipfold.interface.explorer.messages import FrictionRequest, LawRequest
from slipfold.interface.explorer.texts import answered, text_of
from slipfold.models.registry import model_named, model_of_text

BELT = (Path(__file__).parent / "models/two-on-a-belt.toml").read_text()
DRY = """
[parameters]
k = 4.0
mu = 0.3
V = 0.2
[states]
a = "va"
va = "-k*a + pad"
[contacts]
pad = { slip = "V - va", normal = "3", friction = { law = "Coulomb", mu_s = "2*mu", mu_k = "mu" } }
"""


def view_of(model):
    views = []
    request = FrictionRequest(kind="friction", id=1, model="own")
    send_friction(model, request, views.append, lambda: None)
    return views[0]


def test_the_curve_is_that_of_the_law_with_the_values_of_the_sliders():
    view = view_of(model_of_text(BELT).replace(vs_rear=0.2, mu_k_rear=0.1))
    front, rear = view["contacts"]
    assert [item["name"] for item in (front, rear)] == ["front", "rear"]
    assert rear["plate"] == 1.5
    assert rear["holding"] == 0.5
    for speed, coefficient in zip(rear["speed"], rear["coefficient"], strict=True):
        assert coefficient == pytest.approx(0.1 + 0.4 * math.exp(-speed / 0.2), abs=1e-6)


def test_parameters_of_formulas_are_those_of_the_law():
    (pad,) = view_of(model_of_text(DRY).replace(mu=0.25))["contacts"]
    assert pad["holding"] == 0.5
    assert pad["coefficient"][-1] == 0.25


CASES = {
    "case": text_of(model_named("sliding")),
    "case with values": 'model = "sliding"\n\n[parameters]\nmu = 0.4\nNd = 0.1\n',
    "steady": 'model = "steady-sliding"\nfriction = { law = "LuGre", mu_s = 0.4 } # bristles\n',
    "structure": BRAKE,
    "two contacts": BELT,
    "equations": DRY,
    "headed table": DRY.replace("pad = { ", "[contacts.pad]\n").replace(
        ', normal = "3", friction = { law = "Coulomb", mu_s = "2*mu", mu_k = "mu" } }',
        '\nnormal = "3"',
    ),
}


@pytest.mark.parametrize("name", CASES)
def test_another_law_takes_the_place_of_one_and_nothing_else_changes(name):
    model = model_of_text(CASES[name])
    for place, before in enumerate(laws_of(model)):
        changed = with_law(model, CASES[name], place, "CubicStribeck", None)
        after = laws_of(model_of_text(changed))
        assert type(after[place].law) is sf.CubicStribeck
        if "mu_s" in before.law.values and name != "case with values":
            assert after[place].law.values["mu_s"] == before.law.values["mu_s"]
        others = [item.law for number, item in enumerate(after) if number != place]
        assert others == [item.law for number, item in enumerate(laws_of(model)) if number != place]
        kept = [line for line in CASES[name].splitlines() if "friction" not in line]
        lost = [line for line in kept if line not in changed.splitlines()]
        assert lost in ([], ["mu = 0.4"])
    assert place >= 0


@pytest.mark.parametrize(
    ("text", "contact", "law", "words"),
    [
        (BELT, 5, "LuGre", "has 2 contacts whose law can be chosen here, not 6"),
        (BELT, 0, "Magic", "there is no law 'Magic'; there are Coulomb"),
        (DRY, 0, "LuGre", "not a law that sticks"),
    ],
)
def test_what_cannot_be_exchanged_is_said(text, contact, law, words):
    request = LawRequest(model="own", text=text, contact=contact, law=law)
    with pytest.raises(sf.InputError, match=words):
        answered(Catalogue(), request)


def test_a_model_without_contacts_has_no_law():
    assert view_of(model_named("duffing"))["contacts"] == []
