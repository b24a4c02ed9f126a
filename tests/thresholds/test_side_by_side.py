"""Thresholds found side by side are those that each response has by itself."""

import numpy as np
from scipy.stats import qmc

import slipfold as sf
from slipfold.thresholds.batch import DOUBLING, first_doublings

SPAN = (0.0, 0.9)


def scattered(count):
    """So many oscillators over speed, friction coefficient and direction."""
    places = qmc.LatinHypercube(3, seed=3).random(count)
    return [
        sf.SlidingOscillator(
            f=12.5, Vd=0.4 + 0.8 * speed, mu=0.2 + 0.4 * mu, alpha=np.radians(25 + 45 * turn)
        )
        for speed, mu, turn in places
    ]


def test_doublings_are_those_of_each_response_alone():
    models = scattered(12)
    found = first_doublings(models, "Nd", SPAN)
    alone = sf.Settings(largest_period=1)
    for model, value in zip(models[:4], found, strict=False):
        point = sf.response(model, "Nd", SPAN, settings=alone).branches[0].special[0]
        assert point.type == "PD"
        close = DOUBLING.remaining * (SPAN[1] - SPAN[0])  # to which doublings are corrected
        assert abs(value - point.value) <= close + point.uncertainty
    assert np.isfinite(found).all()  # none had to be followed alone


def test_what_is_found_does_not_depend_on_what_is_beside_it():
    models = scattered(11)
    together = first_doublings(models, "Nd", SPAN)
    assert first_doublings(models[:1], "Nd", SPAN).tolist() == together[:1].tolist()
    assert first_doublings(models[4:9], "Nd", SPAN).tolist() == together[4:9].tolist()


def test_other_losses_of_stability_are_left_alone():
    built_in = sf.built_in_models()
    folds, tori = built_in["duffing"](), built_in["vanderpol"]()
    assert np.isnan(first_doublings([folds] * 2, "W", (0.5, 2.0))).all()
    assert np.isnan(first_doublings([tori] * 2, "w", (1.0, 1.5))).all()
    # One that is stable to the end, and one that doubles beside it.
    quiet = sf.SlidingOscillator(f=12.5, alpha=0.01)
    found = first_doublings([quiet, sf.SlidingOscillator(f=12.5)], "Nd", (0.0, 0.1))
    assert np.isnan(found).tolist() == [True, False]
