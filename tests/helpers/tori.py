"""Responses with tori that several tests look at; each is computed once a process."""

from functools import cache

import slipfold as sf


@cache
def of_van_der_pol():
    """The forced van der Pol oscillator from its Neimark-Sacker point on."""
    model = sf.built_in_models()["vanderpol"](a=0.3, e=0.2)
    return sf.response(model, vary="w", span=(1.0, 1.1), tori=True)


@cache
def of_the_sliding_oscillator(span=(0.15, 0.17), start=0.155):
    """The paper's oscillator at 12.5 Hz: tori, from one that a motion settles on, both ways."""
    model = sf.SlidingOscillator(f=12.5)
    return sf.response(model, "Nd", span, start={"Nd": start}, settled=True, tori=True)
