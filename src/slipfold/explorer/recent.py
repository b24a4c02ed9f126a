"""The diagrams computed last, so that a click on one does not compute it anew."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Hashable

from slipfold.explorer.catalogue import Catalogue
from slipfold.explorer.messages import DiagramRequest, OrbitRequest
from slipfold.results.diagram import Diagram
from slipfold.results.response import response

__all__ = ["RecentDiagrams"]

KEPT = 16
"""Diagrams kept, each below a megabyte."""


class RecentDiagrams:
    """Diagrams by what was asked for; the oldest is forgotten.

    Parameters
    ----------
    catalogue
        The models.
    """

    def __init__(self, catalogue: Catalogue) -> None:
        self._catalogue = catalogue
        self._kept: OrderedDict[Hashable, Diagram] = OrderedDict()

    def of(self, request: DiagramRequest | OrbitRequest) -> Diagram:
        """Return the diagram that a request is about, computed if it is not known.

        Parameters
        ----------
        request
            Names the model, its parameters, and what is varied.

        Raises
        ------
        InputError
            If it cannot be computed as asked.
        """
        model = self._catalogue.model(request.model, request.parameters)
        key = (model, request.vary, request.span)
        if key not in self._kept:
            self._kept[key] = response(model, request.vary, request.span)
        self._kept.move_to_end(key)
        while len(self._kept) > KEPT:
            self._kept.popitem(last=False)
        return self._kept[key]
