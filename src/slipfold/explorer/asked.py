"""The model that a request is about, without values of what it varies."""

from __future__ import annotations

from slipfold.explorer.catalogue import Catalogue
from slipfold.explorer.messages import (
    BasinsRequest,
    MotionRequest,
    PlaneRequest,
    RegimesRequest,
    ViewRequest,
)
from slipfold.models.model import Model


def varied(request: ViewRequest) -> tuple[str, ...]:
    """Return the parameters that a request varies."""
    if isinstance(request, PlaneRequest | RegimesRequest):
        return request.x.name, request.y.name
    return () if isinstance(request, MotionRequest | BasinsRequest) else (request.vary,)


def asked_model(catalogue: Catalogue, request: ViewRequest) -> Model:
    """Return the model that a request is about.

    A page tells the values of all its sliders; that of a parameter which is varied plays no part,
    and must not contradict the others.
    """
    names = varied(request)
    values = {name: value for name, value in request.parameters.items() if name not in names}
    return catalogue.model(request.model, values)
