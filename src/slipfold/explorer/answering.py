"""From a request to its answers: the one place where kinds of requests meet what computes them."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from time import perf_counter
from typing import Any

from slipfold.errors import InputError
from slipfold.explorer.asked import asked_model
from slipfold.explorer.catalogue import Catalogue
from slipfold.explorer.computing import Check, Computing
from slipfold.explorer.export.files import export_view
from slipfold.explorer.messages import (
    BasinsRequest,
    DiagramRequest,
    ExponentsRequest,
    ExportRequest,
    OrbitRequest,
    PlaneRequest,
    RegimesRequest,
    ViewRequest,
)
from slipfold.explorer.views.basins import tell_basins
from slipfold.explorer.views.diagram import diagram_view
from slipfold.explorer.views.diagram_progress import DiagramProgress
from slipfold.explorer.views.exponents import tell_exponents
from slipfold.explorer.views.labels import axis_of
from slipfold.explorer.views.orbit import orbit_view
from slipfold.explorer.views.plane import plane_view
from slipfold.explorer.views.plane_progress import PlaneProgress
from slipfold.explorer.views.regimes import tell_regimes
from slipfold.explorer.views.simulation import stream_simulation

Emit = Callable[[dict[str, Any]], None]


WARMING = 5.0
"""Seconds after which the first diagram is not waited for."""


class _Warm(Exception):
    """What takes longer is not needed yet."""


class Answering:
    """Answers requests, one after the other."""

    def __init__(self, catalogue: Catalogue) -> None:
        self._catalogue = catalogue
        self._computing = Computing(catalogue)

    def warm_up(self) -> None:
        """Compile or load the flows of the first model, so that the first request does not wait.

        A diagram that takes long is left as it is: by then its flows are compiled.
        """
        started = perf_counter()

        def check() -> None:
            if perf_counter() - started > WARMING:
                raise _Warm

        described = self._catalogue.describe()[0]
        default = described["default"]
        request = {
            "kind": "diagram",
            "id": 0,
            "model": described["name"],
            **{name: default[name] for name in ("parameters", "vary", "span", "show")},
        }
        with suppress(_Warm):
            self.answer(DiagramRequest.model_validate(request), lambda view: None, check)

    def answer(self, request: ViewRequest, emit: Emit, check: Check) -> None:
        """Compute what a request asks for."""
        started = perf_counter()
        head = {"kind": request.kind, "id": request.id, "slot": request.slot}

        def tell(view: dict[str, Any]) -> None:
            check()
            elapsed = round(1e3 * (perf_counter() - started), 1)
            # No view may rename the request that it answers: the page would not take it.
            emit({"done": True, **view, **head, "elapsed_ms": elapsed})

        try:
            self._answer(request, tell, check)
        except InputError as error:
            tell({"error": str(error)})

    def export(self, request: ExportRequest, check: Check) -> bytes:
        """Make a file of a view, or the text that makes it."""
        return export_view(self._catalogue, self._computing, request, check)

    def _answer(self, request: ViewRequest, tell: Emit, check: Check) -> None:
        if isinstance(request, DiagramRequest):
            axis_of(asked_model(self._catalogue, request), request.show)  # before what takes time
            draft = self._computing.draft(request)
            if draft is not None:
                view = diagram_view(draft, request.show, request.statistic)
                tell({"draft": True, **view, "done": False})
            diagram = self._computing.diagram(request, check, DiagramProgress(tell))
            tell({"draft": False, **diagram_view(diagram, request.show, request.statistic)})
        elif isinstance(request, OrbitRequest):
            tell(orbit_view(self._computing.orbit(request, check), request.vary))
        elif isinstance(request, PlaneRequest):
            tell(plane_view(self._computing.plane(request, check, PlaneProgress(tell))))
        elif isinstance(request, ExponentsRequest):
            tell_exponents(asked_model(self._catalogue, request), request, tell, check)
        elif isinstance(request, BasinsRequest):
            tell_basins(asked_model(self._catalogue, request), request, tell, check)
        elif isinstance(request, RegimesRequest):
            tell_regimes(asked_model(self._catalogue, request), request, tell, check)
        else:
            stream_simulation(asked_model(self._catalogue, request), request, tell)
