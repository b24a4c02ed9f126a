"""Loci of cycles with multipliers that leave no digits of higher derivatives."""

import slipfold as sf


def test_no_generalized_period_doublings_are_made_of_rounding():
    # Tsodyks and Markram's model of synapses; beside a homoclinic orbit multipliers exceed 1e8.
    model = sf.System(
        {
            "name": "Tsodyks-Markram",
            "parameters": {"E0": -1.5, "J": 3.07},
            "states": {
                "E": {
                    "rate": "(-E + 1.5*log(1 + exp((J*u*x*E + E0)/1.5)))/0.013",
                    "start": 0.238,
                },
                "x": {"rate": "(1 - x)/0.2 - u*x*E", "start": 0.746},
                "u": {"rate": "(0.5 - u)/1.5 + 0.5*(1 - u)*E", "start": 0.646},
            },
        }
    )
    window = {"E0": (-1.85, -1.7), "J": (2.7, 2.78)}
    result = sf.bifurcation_set(
        model, tuple(window), tuple(window.values()), types=["PD"], periods=[1], regions=False
    )
    points = [point.type for locus in result.loci for point in locus.special]
    assert "MAX" in points  # the locus of period doublings is there
    assert "GPD" not in points
