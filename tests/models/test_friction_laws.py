"""Friction laws against their closed forms; laws are values; bad input gets a sentence."""

import copy
import dataclasses
import pickle

import heyoka as hy
import numpy as np
import pytest

import slipfold as sf
from slipfold.models.friction.record import law_from_record, law_record
from slipfold.models.parametric import described

LAWS = [
    sf.Coulomb(mu_s=0.6, mu_k=0.4),
    sf.CoulombViscous(mu_s=0.6, mu_k=0.4, s2=0.2),
    sf.Stribeck(mu_s=0.6, mu_k=0.35, vs=0.3, s2=0.05),
    sf.Stribeck(mu_s=0.6, mu_k=0.35, vs=0.3, s2=0.05, exponent=2),
    sf.RationalStribeck(mu_s=0.6, d=1.7),
    sf.CubicStribeck(mu_s=0.6, mu_m=0.4, vm=0.8),
    sf.Regularized(sf.Coulomb(mu_s=0.6, mu_k=0.4), "tanh", e=0.2),
    sf.Regularized(sf.RationalStribeck(mu_s=0.6, d=1.7), "atan", e=0.2),
    sf.Regularized(sf.Stribeck(mu_s=0.6, mu_k=0.35, vs=0.3), "sqrt", e=0.2),
    sf.Dahl(mu_k=0.4, s0=2e3, e=0.01),
    sf.LuGre(mu_s=0.6, mu_k=0.35, vs=0.3, s0=2e3, s1=0.05, s2=0.05, e=0.01),
    sf.BoucWen(A=1e3, b=3e3, c=1e3),
    sf.BoucWen(A=1e3, b=3e3, c=1e3, exponent=4),
    sf.Jenkins(mu_k=0.4, kt=300.0),
    sf.Iwan((sf.Jenkins(mu_k=0.1, kt=20.0), sf.Jenkins(mu_k=0.3, kt=40.0))),
]
SPEEDS = np.array([0.01, 0.1, 0.5, 1.3])


def by_hand(law, v):
    """Friction coefficient from the formulas of the textbook."""
    if isinstance(law, sf.Regularized):
        s = v / law.e
        rise = {"tanh": np.tanh(s), "atan": 2 / np.pi * np.arctan(s), "sqrt": s / np.hypot(s, 1)}
        return by_hand(law.law, v) * rise[law.shape]
    if isinstance(law, sf.Stribeck):
        return (
            law.mu_k
            + (law.mu_s - law.mu_k) * np.exp(-((v / law.vs) ** law.exponent))
            + (law.s2 * v)
        )
    if isinstance(law, sf.CubicStribeck):
        a = 1.5 * (law.mu_s - law.mu_m) / law.vm
        return law.mu_s - a * v + (law.mu_s - law.mu_m) / (2 * law.vm**3) * v**3
    if isinstance(law, sf.LuGre):
        level = law.mu_k + (law.mu_s - law.mu_k) * np.exp(-((v / law.vs) ** 2))
        return level * v / np.hypot(v, law.e) + law.s2 * v
    if isinstance(law, sf.Dahl):
        return law.mu_k * v / np.hypot(v, law.e)
    if isinstance(law, sf.BoucWen):
        return (law.A / (law.b + law.c)) ** (1 / law.exponent) + 0 * v
    if isinstance(law, sf.Iwan):
        return sum(element.mu_k for element in law.elements) + 0 * v
    if isinstance(law, sf.RationalStribeck):
        return law.mu_s / (1 + law.d * v)
    return law.mu_k + getattr(law, "s2", 0.0) * v


@pytest.mark.parametrize("law", LAWS, ids=repr)
def test_coefficient_is_the_closed_form_in_numbers_and_symbols(law):
    expected = pytest.approx(by_hand(law, SPEEDS), rel=1e-14)
    assert law.coefficient(SPEEDS) == expected
    assert law.coefficient(SPEEDS).shape == SPEEDS.shape
    assert type(law.coefficient(0.1)) is float
    speed = hy.expression("speed")
    p = {item.name: hy.expression(f"p_{item.name}") for item in law.parameters}
    function = hy.cfunc([hy.expression(0.0) + law.formula(speed, p)], vars=[speed, *p.values()])
    assert np.array([function([v, *law.values.values()])[0] for v in SPEEDS]) == expected


@pytest.mark.parametrize("law", LAWS, ids=repr)
def test_slope_is_the_derivative_to_rounding(law):
    v = hy.expression("v")
    mu = hy.expression(0.0) + law.formula(v, law.values)
    expected = hy.cfunc([hy.diff(mu, v)], vars=[v])(SPEEDS[None])[0]
    assert law.slope(SPEEDS) == pytest.approx(expected, rel=1e-12, abs=1e-14)
    assert type(law.slope(0.1)) is float
    assert law.slope(SPEEDS.reshape(2, 2)).shape == (2, 2)


def test_falling_friction_cancels_damping_where_the_textbook_says():
    # System 11: 0.1 + mu'(vd) = 0 at vd = 0.5 ln 10.
    law = sf.Stribeck(mu_s=1.0, mu_k=0.5, vs=0.5)
    assert law.slope(1.151292546497) == pytest.approx(-0.1, abs=1e-12)


@pytest.mark.parametrize("law", LAWS, ids=repr)
def test_laws_are_values(law):
    for other in (pickle.loads(pickle.dumps(law)), copy.deepcopy(law), eval(repr(law), vars(sf))):
        assert other == law
        assert hash(other) == hash(law)
    assert law.kind == law.kind.kind
    assert [item.name for item in law.kind.parameters] == [item.name for item in law.parameters]
    with pytest.raises(dataclasses.FrozenInstanceError):
        law.mu_k = 0.1


@pytest.mark.parametrize("law", LAWS, ids=repr)
def test_parameters_are_described(law):
    assert law.title
    names = [item.name for item in law.parameters]
    assert len(set(names)) == len(names)
    assert list(law.values) == names
    for item in law.parameters:
        assert item.doc
        assert item.check(item.default) == law.kind.values[item.name]
        value = 1.01 * law.values[item.name] + 1e-3
        changed = law.replace(**{item.name: value})
        assert changed.values[item.name] == value
        assert changed != law
        assert changed.kind == law.kind


def test_equality_needs_class_structure_and_values():
    assert sf.Stribeck(vs=0.1) == sf.Stribeck(vs="100 mm/s")
    assert sf.Stribeck(exponent=1) != sf.Stribeck(exponent=2)
    assert sf.Stribeck(exponent=1).kind != sf.Stribeck(exponent=2).kind
    assert sf.Regularized(sf.Coulomb(), "tanh").kind != sf.Regularized(sf.Coulomb(), "sqrt").kind
    assert sf.Regularized(sf.Coulomb(), "tanh").kind != sf.Regularized(sf.Stribeck(), "tanh").kind
    assert sf.Coulomb() != sf.Jenkins()
    assert len({sf.Stribeck(), sf.Stribeck(), sf.Stribeck(vs=0.2)}) == 2


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: sf.Coulomb(mu_s=-1), "mu_s = -1 is outside its bounds"),
        (lambda: sf.Coulomb(mu_s=0.3, mu_k=0.4), "mu_s = 0.3 is below mu_k = 0.4"),
        (lambda: sf.CoulombViscous(mu_s=0.3, mu_k=0.4), "give mu_s >= mu_k"),
        (lambda: sf.Stribeck(mu_s=0.2), "mu_s = 0.2 is below mu_k = 0.3"),
        (lambda: sf.LuGre(mu_s=0.2), "mu_s = 0.2 is below mu_k = 0.3"),
        (lambda: sf.CubicStribeck(mu_s=0.2), "mu_s = 0.2 is below mu_m = 0.3"),
        (lambda: sf.Regularized(sf.Stribeck()).replace(mu_s=0.2), "give mu_s >= mu_k"),
        (lambda: sf.Stribeck(vs=0), "vs = 0 is outside its bounds; vs must be > 0 m/s"),
        (lambda: sf.Stribeck(s2=-1), "s2 must be >= 0 s/m"),
        (lambda: sf.Stribeck(exponent=3), "exponent = 3 is not known; give 1 or 2"),
        (lambda: sf.RationalStribeck(d=-1), "d must be >= 0 s/m"),
        (lambda: sf.CubicStribeck(vm=0), "vm must be > 0 m/s"),
        (
            lambda: sf.Regularized(sf.Coulomb(), e=0),
            "e = 0 is outside its bounds; e must be > 0",
        ),
        (lambda: sf.Regularized(sf.Coulomb(), "tan"), "shape = 'tan' is not known; did you mean"),
        (lambda: sf.Regularized(sf.LuGre()), "LuGre does not jump at zero slip"),
        (lambda: sf.Regularized(0.3), "0.3 is not a friction law"),
        (lambda: sf.Dahl(mu_k=0), "mu_k must be > 0"),
        (lambda: sf.LuGre(e=0), "e must be > 0 m/s"),
        (lambda: sf.LuGre(s0=0), "s0 must be > 0 1/m"),
        (lambda: sf.BoucWen(exponent=3), "exponent = 3 is not an even whole number"),
        (lambda: sf.BoucWen(b=1.0, c=-1.0), "b + c = 0 1/m is not positive"),
        (lambda: sf.BoucWen(b=1.0, c=2.0), "the contact would give energy"),
        (lambda: sf.Jenkins(kt=0), "kt must be > 0 N/m"),
        (lambda: sf.Jenkins().stiffness(0.0), "amplitude = 0 m is not positive"),
        (lambda: sf.Jenkins().energy(0.1, normal=-1.0), "normal = -1 N is not positive"),
        (lambda: sf.Iwan(()), "are not Jenkins elements"),
        (lambda: sf.Iwan((sf.Coulomb(),)), "are not Jenkins elements"),
        (lambda: sf.Coulomb().coefficient(-0.1), "a slip speed of -0.1 m/s is negative"),
        (lambda: sf.Coulomb().slope([0.1, -0.2]), "a slip speed of -0.2 m/s is negative"),
        (lambda: sf.Coulomb().damping(0.0), "give speed > 0"),
        (
            lambda: sf.Coulomb().force((0.0, 0.0)),
            "at rest the friction force of Coulomb can",
        ),
        (lambda: sf.Coulomb().force((1.0, 0.0, 0.0)), "the slip has 3 components"),
        (lambda: sf.Dahl().force((1.0, 0.0)), "Dahl needs 2 components of memory"),
        (lambda: sf.Coulomb().force((1.0,), memory=(0.1,)), "Coulomb needs 0 components of memory"),
        (lambda: sf.Jenkins().force((1.0,)), "Jenkins needs 1 components of memory"),
        (
            lambda: sf.Iwan((sf.Jenkins(),) * 2).force((1.0, 0.0)),
            "Iwan needs 4 components",
        ),
        (lambda: sf.Jenkins(exponent=5), "exponent = 5 is not an even whole number"),
        (lambda: sf.Jenkins(exponent="8"), "exponent = '8' is not an even whole number"),
        (lambda: sf.Iwan().replace(kt2=3.0), "Iwan has no parameter 'kt2'; did you mean kt1?"),
        (lambda: sf.Iwan().replace(kt1=0), "kt must be > 0 N/m"),
        (lambda: law_from_record({"law": "Stribek"}), "friction.law = 'Stribek' is unknown; did"),
        (lambda: law_from_record({"vs": 0.1}), "friction has no law; give one of"),
        (lambda: law_from_record({"law": "Dahl", "vs": 0.1}), "friction has no entry 'vs'"),
        (lambda: law_from_record({"law": "Regularized"}), "friction has no of; give it"),
        (lambda: sf.Stribeck().replace(v_s=0.1), "no parameter 'v_s'; did you mean vs?"),
    ],
)
def test_bad_input_gets_one_sentence(make, message):
    with pytest.raises(sf.InputError) as error:
        make()
    assert message in str(error.value)
    assert "\n" not in str(error.value)


def test_a_law_of_ones_own_is_a_few_lines():
    from slipfold.models.friction.law import STATIC

    @dataclasses.dataclass(frozen=True)
    class Root(sf.FrictionLaw):
        title = "root"
        mu_s: float = described(STATIC)

        def formula(self, speed, p):
            return p["mu_s"] * (1.0 + speed) ** -0.5

    law = Root(mu_s=0.4)
    with pytest.raises(sf.InputError, match="Root is not among the friction laws of the package"):
        law_record(law)
    assert law.slope(3.0) == pytest.approx(-0.4 / 16, rel=1e-14)
    assert law.force((3.0,), 2.0) == pytest.approx((0.4,))


@pytest.mark.parametrize("law", [sf.Coulomb, sf.CoulombViscous])
def test_one_coefficient_serves_for_rest_and_slip(law):
    for given, expected in (
        ({}, (0.5, 0.5)),
        ({"mu_k": 0.3}, (0.3, 0.3)),
        ({"mu_s": "0.7"}, (0.7, 0.7)),
        ({"mu_k": 0.3, "mu_s": 0.4}, (0.4, 0.3)),
    ):
        made = law(**given)
        assert (made.stiction, made.coefficient(0)) == expected
        names = ["mu_k"] if len(given) == 1 else ["mu_s", "mu_k"]
        assert [name for name in made.values if name != "s2"] == names


@dataclasses.dataclass(frozen=True)
class Slack(sf.Jenkins):
    slack: float = described(sf.Parameter("slack", 1.0, symbol=r"$\delta_\mathrm{s}$"))


def test_the_numbers_of_parts_stand_in_their_symbols():
    symbols = {item.name: item.symbol for item in sf.Iwan((Slack(), Slack(kt=2.0))).parameters}
    assert symbols["slack2"] == r"$\delta_{\mathrm{s}2}$"
    assert symbols["kt2"] == "$k_{t2}$"
