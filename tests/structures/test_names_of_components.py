"""Components without a name are named by where they act, where they would share a parameter."""

import numpy as np

from slipfold import CubicSpring, FrictionContact, HarmonicForce, Stribeck, Structure

M, K = np.eye(2), np.array([[2.0, -1.0], [-1.0, 1.0]])


def test_components_that_would_share_a_parameter_are_named_by_where_they_act():
    belts = [FrictionContact(at, Stribeck(), load=n) for n, at in enumerate(("root", "tip"), 1)]
    springs = [
        CubicSpring("root", k3=1.0),
        CubicSpring({"root": 1, "tip": -1}, k3=2.0),
        CubicSpring("tip", k3=3.0, name="end"),
    ]
    model = Structure(
        M, None, K, names="root tip", elements=springs, contacts=belts, forcing=HarmonicForce("tip")
    )
    values = {name: model.values[name] for name in ("k3_root", "k3_root_tip", "k3_end", "Ns_root")}
    assert values == {"k3_root": 1.0, "k3_root_tip": 2.0, "k3_end": 3.0, "Ns_root": 1.0}
    # What stands alone keeps the name that its formula has.
    assert "F" in [item.name for item in model.parameters]
    assert Structure.from_tables(model.to_tables()) == model
    outputs = {item.name: item for item in model.outputs()}
    assert {"Vrel_root", "Vrel_tip"} <= set(outputs)
