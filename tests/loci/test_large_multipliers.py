"""Loci of cycles with multipliers that leave no digits of higher derivatives."""

import numpy as np
import pytest

import slipfold as sf


@pytest.mark.long
def test_no_generalized_period_doublings_are_made_of_rounding():
    # Tsodyks and Markram's model of synapses; beside a homoclinic orbit multipliers exceed 1e8.
    model = sf.System(
        {
            "name": "Tsodyks-Markram",
            "parameters": {"E0": -1.5, "J": 3.07},
            "states": {
                "E": {"rate": "(-E + 1.5*log(1 + exp((J*u*x*E + E0)/1.5)))/0.013", "start": 0.238},
                "x": {"rate": "(1 - x)/0.2 - u*x*E", "start": 0.746},
                "u": {"rate": "(0.5 - u)/1.5 + 0.5*(1 - u)*E", "start": 0.646},
            },
        }
    )
    alone = sf.Settings(largest_period=1)
    response = sf.response(model, "E0", (-1.85, -1.7), J=2.75, settings=alone)
    doubling = next(item.point for item in response.special if item.point.type == "PD")
    (locus,) = sf.locus(doubling, ("E0", "J"), ((-1.85, -1.7), (2.7, 2.78))).loci
    assert np.abs(locus.multipliers).max() > 1e8
    points = [point.type for point in locus.special]
    assert "MAX" in points
    assert "GPD" not in points
