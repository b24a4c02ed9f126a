"""Contacts that share parameters, belts that run backward, and two contacts in one place."""

import numpy as np
import pytest

import slipfold as sf
from slipfold import (
    Coulomb,
    CubicSpring,
    FrictionContact,
    GapSpring,
    HarmonicForce,
    InputError,
    Regularized,
    Stribeck,
    Structure,
)

M, C = np.eye(2), 0.02 * np.eye(2)
K = np.array([[2.0, -1.0], [-1.0, 2.0]])
LAW = Regularized(Coulomb(mu_k=0.4), e=0.02)


def ring(*contacts, **options):
    return Structure(M, C, K, names="a b", contacts=contacts, forcing=HarmonicForce("a"), **options)


def rates(model):
    """State at 0.3 in every coordinate, at rest, and half way through a period."""
    return sf.simulate(model, 1, np.full(len(model.states), 0.3)).states[-1]


def test_a_group_has_its_parameters_once():
    alone = [FrictionContact(at, LAW, 2.0, Vd=0, name=at) for at in "ab"]
    group = [FrictionContact("a", LAW, 2.0, Vd=0, group="ring", name="left"),
             FrictionContact("b", LAW, Vd=0, group="ring")]  # fmt: skip
    model = ring(*group, F=1.0, f=0.2)
    assert [item.name for item in model.parameters] == [
        "f", "Ns_ring", "Vd_ring", "mu_k_ring", "e_ring", "F", "phi"
    ]  # fmt: skip
    assert model.values["Ns_ring"] == 2.0
    assert {"N_left", "N"} <= {item.name for item in model.outputs()}
    whole = ring(*alone, F=1.0, f=0.2)
    np.testing.assert_allclose(rates(model), rates(whole), rtol=1e-12)
    changed = whole.replace(Ns_a=3, Ns_b=3, mu_k_a=0.2, mu_k_b=0.2)
    np.testing.assert_allclose(
        rates(model.replace(Ns_ring=3, mu_k_ring=0.2)), rates(changed), rtol=1e-12
    )
    assert Structure.from_tables(model.to_tables()) == model


def test_contacts_along_one_direction_add_up():
    two = [FrictionContact("a", LAW, 1.0, Vd=0, name=name) for name in ("left", "right")]
    model = ring(*two, F=1.0, f=0.2)
    assert model.notes == ("contacts along one direction, whose forces add up: left, right",)
    once = ring(FrictionContact("a", LAW, 2.0, Vd=0), F=1.0, f=0.2)
    np.testing.assert_allclose(rates(model), rates(once), rtol=1e-12)


def test_some_parameters_of_a_group():
    group = {"mu_k": "ring", "e": "ring"}
    model = ring(*(FrictionContact(at, LAW, n, group=group) for n, at in enumerate("ab", 2)))
    names = [item.name for item in model.parameters]
    assert names[1:6] == ["Ns_a", "Vd_a", "mu_k_ring", "e_ring", "Ns_b"]
    assert model.values["Ns_a"] == 2.0
    assert model.values["Ns_b"] == 3.0
    assert Structure.from_tables(model.to_tables()) == model


def test_one_coefficient_is_one_parameter_at_rest_and_in_slip():
    stuck = []
    for law in (sf.Coulomb(mu_k=0.1), sf.Coulomb(mu_s=0.8, mu_k=0.8)):
        contact = FrictionContact("a", law, 1.0, Vd=0)
        model = Structure([[1]], [[0.05]], [[1]], names="a", contacts=contact,
                          forcing=HarmonicForce("a", F=1), f=0.1)  # fmt: skip
        orbit = sf.periodic_orbit(model.replace(mu_k=0.8))
        stuck.append((orbit.stuck_fraction, *orbit.state))
    assert 0 < stuck[0][0] < 1
    np.testing.assert_allclose(*stuck, rtol=1e-9)


def test_forces_of_a_group_need_no_level():
    forces = [HarmonicForce(at, F=2.0, group="both") for at in "ab"]
    model = Structure(M, C, K, names="a b", forcing=forces)
    assert model.forcing_amplitude == "F_both"


@pytest.mark.parametrize(("parts", "words"), [
    ([CubicSpring("a", k3=1.0, group="s"), CubicSpring("b", k3=2.0, group="s")],
     "k3_s is 1 in one component of a group and 2 in another"),
    ([sf.LinearSpring("a", group="s"), GapSpring("b", e=1, group="s")],
     "k_s is stiffness of a spring and stiffness of a stop in components of one group"),
])  # fmt: skip
def test_a_group_is_of_one_kind_and_value(parts, words):
    with pytest.raises(InputError, match=words):
        Structure(M, C, K, names="a b", elements=parts)
    with pytest.raises(InputError, match="'1' cannot name a group of a cubic spring; give letters"):
        CubicSpring("a", group="1")


@pytest.mark.parametrize("law", [Coulomb(mu_k=0.3), Stribeck(mu_s=0.4), LAW], ids=["C", "S", "R"])
def test_a_belt_that_runs_backward_is_the_mirror_image(law):
    model = Structure(
        [[1.0]], [[0.05]], [[1.0]], names="x", forcing=HarmonicForce("x", F=0.3), f=0.1,
        contacts=FrictionContact("x", law, 0.5, Vd=0.2),
    )  # fmt: skip
    back = model.replace(Vd=-0.2, F=-0.3)
    forward, mirrored = (sf.simulate(one, periods=5) for one in (model, back))
    np.testing.assert_allclose(mirrored.states[-1], -forward.states[-1], rtol=1e-9)
    ratio = {"Vrel_ratio"} & {item.name for item in model.outputs()}
    for name in ratio:
        assert back.evaluate(name, -model.start) == model.evaluate(name, model.start) > 0


def test_a_surface_does_not_turn_while_a_contact_may_stick_to_it():
    tip = FrictionContact("x", Coulomb(), 0.1, Vd=-2)
    rubbing = Structure([[1.0]], [[0.1]], [[100.0]], names="x", contacts=tip)
    diagram = sf.response(rubbing, vary="Vd", span=(-2, -1))
    assert diagram.branches[0].parameter.min() == pytest.approx(-2)
    words = r"must be < 0 m/s, since a contact may stick .* Regularized .*, or the model a Vd > 0$"
    for span in ((-2, 0), (-2, 1)):
        with pytest.raises(InputError, match=words):
            sf.response(rubbing, vary="Vd", span=span)
    with pytest.raises(InputError, match=r"must be > 0 m/s, .* Regularized law to reach zero$"):
        sf.response(sf.SlidingOscillator(), vary="Vd", span=(1, -1))


def test_contacts_in_one_place_add_unless_they_all_hold():
    def held(law, loads):
        contacts = [FrictionContact("x", law, load, Vd=0, name=f"c{number}")
                    for number, load in enumerate(loads)]  # fmt: skip
        model = Structure([[1.0]], [[0.05]], [[1.0]], names="x", contacts=contacts, f=0.1,
                          forcing=HarmonicForce("x", F=1.0))  # fmt: skip
        return sf.simulate(model, periods=2).states[-1]

    np.testing.assert_allclose(held(LAW, (0.2, 0.3)), held(LAW, (0.5,)), rtol=1e-9)
    words = "too many contacts would stick at once: fewer than these 2 hold all that moves"
    with pytest.raises(InputError, match=words):
        held(Coulomb(), (0.2, 0.3))
