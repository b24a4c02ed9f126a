"""From a request to its answers; the diagrams computed last are remembered."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Hashable
from contextlib import suppress
from dataclasses import replace
from time import perf_counter
from typing import Any

from slipfold.branches.draft import draft_branches
from slipfold.branches.orbit_between import orbit_between
from slipfold.computations.loci import bifurcation_set
from slipfold.computations.response import response
from slipfold.errors import InputError
from slipfold.explorer.catalogue import Catalogue
from slipfold.explorer.curves import PlaneProgress, diagram_note, diagram_view, plane_view
from slipfold.explorer.messages import (
    BasinsRequest,
    DiagramRequest,
    ExponentsRequest,
    ExportRequest,
    OnBranch,
    OrbitRequest,
    PlaneRequest,
    RegimesRequest,
    ViewRequest,
)
from slipfold.explorer.pictures import tell_basins, tell_regimes
from slipfold.explorer.plain import axis_of, now_and_then
from slipfold.explorer.trajectories import orbit_view, stream_simulation, tell_exponents
from slipfold.models.model import Model
from slipfold.orbits.find import periodic_orbit
from slipfold.orbits.periodic_orbit import PeriodicOrbit
from slipfold.progress import Observer, Progress
from slipfold.results.diagram import Diagram
from slipfold.results.locus_diagram import LocusDiagram

MAX_DIAGRAMS = 16
"""Diagrams stored, each below a megabyte."""

Check = Callable[[], None]


class Computing:
    """Computes what requests are about."""

    def __init__(self, catalogue: Catalogue) -> None:
        self._catalogue = catalogue
        self._diagrams: OrderedDict[Hashable, Diagram] = OrderedDict()
        self._nearest: dict[Hashable, Diagram] = {}

    def draft(self, request: DiagramRequest) -> Diagram | None:
        """Return a diagram from the last one that differs in parameters alone."""
        model = self._catalogue.of(request)
        near = self._nearest.get(_family(model, request))
        if near is None or (model, request.vary, request.span) in self._diagrams:
            return None
        changed = model.replace(**{request.vary: request.span[0]})
        branches = draft_branches(near.branches, changed)
        if branches is None:
            return None
        drawn = replace(near, model=changed, branches=branches, checked=None)
        self._nearest[_family(model, request)] = drawn
        return drawn

    def diagram(
        self,
        request: DiagramRequest | OrbitRequest,
        check: Check,
        observer: Observer | None = None,
    ) -> Diagram:
        """Return the diagram that a request is about."""

        def watch(progress: Progress) -> None:
            check()
            if observer is not None:
                observer(progress)

        model = self._catalogue.of(request)
        key = (model, request.vary, request.span)
        if key not in self._diagrams:
            self._diagrams[key] = response(model, request.vary, request.span, observer=watch)
        self._nearest[_family(model, request)] = self._diagrams[key]
        self._diagrams.move_to_end(key)
        while len(self._diagrams) > MAX_DIAGRAMS:
            self._diagrams.popitem(last=False)
        while len(self._nearest) > MAX_DIAGRAMS:
            del self._nearest[next(iter(self._nearest))]
        return self._diagrams[key]

    def orbit(self, request: OrbitRequest, check: Check) -> PeriodicOrbit:
        """Return the orbit that a request is about."""
        at = request.at
        if not isinstance(at, OnBranch):
            model = self._catalogue.of(request).replace(**{request.vary: at.value})
            return periodic_orbit(model, at.period, at.state)
        branches = self.diagram(request, check).branches
        if at.branch > len(branches):
            raise InputError(
                f"there is no branch {at.branch}; give a number from 1 to {len(branches)}"
            )
        return orbit_between(branches[at.branch - 1], at.arclength, at.value)

    def plane(
        self,
        request: PlaneRequest,
        check: Check,
        observer: Observer | None = None,
    ) -> LocusDiagram:
        """Return the bifurcation set that a request is about."""

        def watch(progress: Progress) -> None:
            check()
            if observer is not None:
                observer(progress)

        plane = (request.x.name, request.y.name)
        window = (request.x.span, request.y.span)
        model = self._catalogue.of(request)
        return bifurcation_set(model, plane, window, regions=model.forced, observer=watch)


def _family(model: Model, request: DiagramRequest | OrbitRequest) -> Hashable:
    """Return the key of diagrams that differ in parameters alone."""
    return model.kind, request.vary, request.span


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

        def tell(view: dict[str, Any]) -> None:
            check()
            elapsed = round(1e3 * (perf_counter() - started), 1)
            # No view may rename the request that it answers: the page would not take it.
            emit({"done": True, **view, **request.head, "elapsed_ms": elapsed})

        try:
            self._answer(request, tell, check)
        except InputError as error:
            tell({"error": str(error)})

    def export(self, request: ExportRequest, check: Check) -> bytes:
        """Make a file of a view, or the text that makes it."""
        from slipfold.explorer.export import export_view

        return export_view(self._catalogue, self._computing, request, check)

    def _answer(self, request: ViewRequest, tell: Emit, check: Check) -> None:
        if isinstance(request, DiagramRequest):
            axis_of(self._catalogue.of(request), request.show)  # before what takes time
            draft = self._computing.draft(request)
            if draft is not None:
                view = diagram_view(draft, request.show, request.statistic)
                tell({"draft": True, **view, "done": False})
            diagram = self._computing.diagram(
                request, check, now_and_then(tell, check, diagram_note)
            )
            tell({"draft": False, **diagram_view(diagram, request.show, request.statistic)})
        elif isinstance(request, OrbitRequest):
            tell(orbit_view(self._computing.orbit(request, check), request.vary))
        elif isinstance(request, PlaneRequest):
            tell(plane_view(self._computing.plane(request, check, PlaneProgress(tell))))
        elif isinstance(request, ExponentsRequest):
            tell_exponents(self._catalogue.of(request), request, tell, check)
        elif isinstance(request, BasinsRequest):
            tell_basins(self._catalogue.of(request), request, tell, check)
        elif isinstance(request, RegimesRequest):
            tell_regimes(self._catalogue.of(request), request, tell, check)
        else:
            stream_simulation(self._catalogue.of(request), request, tell)
