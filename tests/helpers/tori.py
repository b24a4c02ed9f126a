"""Responses with tori that several tests look at; each is computed once a process."""

from functools import cache

import slipfold as sf


@cache
def of_van_der_pol():
    """The forced van der Pol oscillator from its Neimark-Sacker point on."""
    model = sf.built_in_models()["vanderpol"](a=0.3, e=0.2)
    return sf.response(model, vary="w", span=(1.0, 1.1), tori=True)


@cache
def of_the_sliding_oscillator():
    """The paper's oscillator at 12.5 Hz: tori between the two NS of its doubled branch."""
    return sf.response(sf.SlidingOscillator(), vary="Nd", span=(0, 0.2), f=12.5, tori=True)
