"""Models are values: immutable, comparable, picklable."""

import copy
import pickle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from helpers.toy_models import LinearOscillator
from slipfold import InputError, SlidingOscillator, built_in_models
from slipfold.models.registry import model_named

MODELS = st.builds(
    SlidingOscillator,
    f=st.floats(1, 50),
    Nd=st.floats(0, 0.99),
    mu=st.floats(0, 2),
    alpha=st.floats(-10, 10),
    Vd=st.floats(1e-3, 10),
)


@given(MODELS)
def test_pickle_and_copies_are_equal(model):
    for other in (pickle.loads(pickle.dumps(model)), copy.copy(model), copy.deepcopy(model)):
        assert other == model
        assert hash(other) == hash(model)
        assert np.array_equal(other.vector, model.vector)


@given(MODELS, st.floats(1, 50))
def test_replace_makes_a_new_model(model, f):
    before = dict(model.values)
    other = model.replace(f=f)
    assert dict(model.values) == before
    assert other.f == f
    assert other.replace(f=model.f) == model


def test_nothing_can_be_changed():
    model = SlidingOscillator()
    with pytest.raises(AttributeError, match=r"immutable; model.replace\(Nd=...\)"):
        model.Nd = 0.5
    with pytest.raises(AttributeError):
        model.anything = 0.5
    with pytest.raises(TypeError):
        model.values["Nd"] = 0.5
    with pytest.raises(ValueError, match="read-only"):
        model.vector[0] = 0.5
    assert model == SlidingOscillator()


def test_equality_needs_kind_and_values():
    assert SlidingOscillator(Nd=0.1) == SlidingOscillator(Nd="100 mN")
    assert SlidingOscillator(Nd=0.1) != SlidingOscillator(Nd=0.2)
    assert LinearOscillator() != SlidingOscillator()
    assert SlidingOscillator() != "sliding"
    assert len({SlidingOscillator(Nd=0.1), SlidingOscillator(Nd=0.1), SlidingOscillator()}) == 2


def test_built_in_models_are_found_by_name():
    assert model_named("sliding", Nd=0.1) == SlidingOscillator(Nd=0.1)
    assert built_in_models()["sliding"] is SlidingOscillator
    with pytest.raises(InputError, match=r"no model 'slidng'; did you mean sliding\?"):
        model_named("slidng")
    with pytest.raises(InputError, match="the built-in models are: sliding"):
        model_named("pendulum")
    with pytest.raises(InputError, match="did you mean mu"):
        model_named("sliding", MU=0.3)


def test_evaluate_refuses_what_it_cannot_use():
    model = SlidingOscillator()
    with pytest.raises(InputError, match=r"no output 'vrel'; did you mean Vrel\?"):
        model.evaluate("vrel", np.zeros(4))
    with pytest.raises(InputError, match="last axis must hold the 4 states x, y, vx, vy"):
        model.evaluate("N", np.zeros(3))
    with pytest.raises(InputError, match="last axis must hold the 4 states x, y, vx, vy"):
        model.jacobian(0.0)


def test_a_jacobian_is_that_of_the_rates():
    model = built_in_models()["stuart-landau"](r=-0.5, w=2.0)
    assert model.jacobian([[0, 0]] * 3).tolist() == [[[-0.5, -2.0], [2.0, -0.5]]] * 3
