"""The symbolic form of a model, and the fingerprint that its compiled code is kept by."""

import heyoka as hy

from helpers.toy_models import LinearOscillator
from slipfold import Model, Parameter, SlidingOscillator, State
from slipfold.flow.equations import build_equations
from slipfold.flow.flow import flow_of


class Long(Model):
    """An equation that takes far more than 1000 characters; its last number makes the kinds."""

    name = "long"
    states = (State("x"),)
    parameters = (Parameter("f", 1.0, "Hz", "forcing frequency"),)
    last = 1.0

    def coefficients(self, p):
        return {}

    def rates(self, q, c, phase):
        terms = [hy.sin(float(i) * q["x"]) for i in range(1, 200)]
        return {"x": hy.sum([*terms, self.last * hy.cos(q["x"])])}

    def period(self, p):
        return 1.0 / p["f"]


class LongToo(Long):
    last = 2.0


class Swapped(LinearOscillator):
    """The same expressions under exchanged names of coefficients."""

    def coefficients(self, p):
        own = super().coefficients(p)
        return {"damping": own["stiffness"], "stiffness": own["damping"], "a": own["a"]}


def fingerprint(model):
    return build_equations(model).fingerprint()


def test_different_equations_have_different_fingerprints():
    models = [SlidingOscillator(), LinearOscillator(), Swapped(), Long(), LongToo()]
    assert len({fingerprint(model) for model in models}) == len(models)


def test_models_with_the_same_equations_share_a_flow():
    assert flow_of(SlidingOscillator(Nd=0.2)) is flow_of(SlidingOscillator())
    assert flow_of(LinearOscillator()) is not flow_of(SlidingOscillator())
