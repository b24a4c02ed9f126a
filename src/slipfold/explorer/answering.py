"""From a request to its answers."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from time import perf_counter
from typing import Any

from slipfold.errors import InputError
from slipfold.explorer.catalogue import Catalogue
from slipfold.explorer.computing import Check, Computing
from slipfold.explorer.curves import PlaneProgress, diagram_note, diagram_view, plane_view
from slipfold.explorer.export import export_view
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
from slipfold.explorer.pictures import send_basins, send_regimes
from slipfold.explorer.plain import axis_of, now_and_then
from slipfold.explorer.trajectories import orbit_view, send_exponents, stream_simulation

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

        def send(view: dict[str, Any]) -> None:
            check()
            elapsed = round(1e3 * (perf_counter() - started), 1)
            # No view may rename the request that it answers: the page would not take it.
            emit({"done": True, **view, **request.head, "elapsed_ms": elapsed})

        try:
            self._answer(request, send, check)
        except InputError as error:
            send({"error": str(error)})

    def export(self, request: ExportRequest, check: Check) -> bytes:
        """Make a file of a view, or the text that makes it."""
        return export_view(self._catalogue, self._computing, request, check)

    def _answer(self, request: ViewRequest, send: Emit, check: Check) -> None:
        if isinstance(request, DiagramRequest):
            axis_of(self._catalogue.of(request), request.show)  # before what takes time
            draft = self._computing.draft(request)
            if draft is not None:
                view = diagram_view(draft, request.show, request.statistic)
                send({"draft": True, **view, "done": False})
            diagram = self._computing.diagram(
                request, check, now_and_then(send, check, diagram_note)
            )
            send({"draft": False, **diagram_view(diagram, request.show, request.statistic)})
        elif isinstance(request, OrbitRequest):
            send(orbit_view(self._computing.orbit(request, check), request.vary))
        elif isinstance(request, PlaneRequest):
            send(plane_view(self._computing.plane(request, check, PlaneProgress(send))))
        elif isinstance(request, ExponentsRequest):
            send_exponents(self._catalogue.of(request), request, send, check)
        elif isinstance(request, BasinsRequest):
            send_basins(self._catalogue.of(request), request, send, check)
        elif isinstance(request, RegimesRequest):
            send_regimes(self._catalogue.of(request), request, send, check)
        else:
            stream_simulation(self._catalogue.of(request), request, send)
