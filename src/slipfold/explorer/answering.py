"""From a request to its answers: the one place where kinds of requests meet what computes them."""

from __future__ import annotations

from collections.abc import Callable
from time import perf_counter
from typing import Any

from slipfold.branches.orbit_between import orbit_between
from slipfold.errors import InputError
from slipfold.explorer.catalogue import Catalogue
from slipfold.explorer.messages import (
    DiagramRequest,
    OnBranch,
    OrbitRequest,
    PlaneRequest,
    SimulationRequest,
    ViewRequest,
)
from slipfold.explorer.recent import RecentDiagrams
from slipfold.explorer.views.diagram import diagram_view
from slipfold.explorer.views.orbit import orbit_view
from slipfold.explorer.views.plane import plane_view
from slipfold.explorer.views.simulation import stream_simulation
from slipfold.loci.progress import LocusProgress
from slipfold.orbits.find import periodic_orbit
from slipfold.orbits.periodic_orbit import PeriodicOrbit
from slipfold.results.bifurcation_set import bifurcation_set

__all__ = ["Answering"]

BETWEEN = 0.1
"""Least time between two notes of progress, in s."""

Emit = Callable[[dict[str, Any]], None]


class Answering:
    """Answers requests, one after the other, and remembers the last diagrams.

    Parameters
    ----------
    catalogue
        The models.
    """

    def __init__(self, catalogue: Catalogue) -> None:
        self.catalogue = catalogue
        self.diagrams = RecentDiagrams(catalogue)

    def answer(self, request: ViewRequest, emit: Emit) -> None:
        """Compute what a request asks for.

        Parameters
        ----------
        request
            The request.
        emit
            Takes each answer: plain data for JSON; the last has ``done``. What cannot be computed
            is answered with ``error``, a sentence.
        """
        started = perf_counter()
        head = {"kind": request.kind, "id": request.id, "slot": request.slot}

        def tell(view: dict[str, Any]) -> None:
            elapsed = 1e3 * (perf_counter() - started)
            emit({**head, "done": True, **view, "elapsed_ms": round(elapsed, 1)})

        try:
            if isinstance(request, DiagramRequest):
                tell(self._diagram(request))
            elif isinstance(request, OrbitRequest):
                tell(orbit_view(self._orbit(request), request.vary))
            elif isinstance(request, PlaneRequest):
                self._plane(request, tell)
            else:
                self._simulation(request, tell)
        except InputError as error:
            tell({"error": str(error)})

    def _diagram(self, request: DiagramRequest) -> dict[str, Any]:
        diagram = self.diagrams.of(request)
        return {"draft": False, **diagram_view(diagram, request.show, request.statistic)}

    def _orbit(self, request: OrbitRequest) -> PeriodicOrbit:
        if isinstance(request.at, OnBranch):
            branches = self.diagrams.of(request).branches
            if request.at.branch > len(branches):
                raise InputError(
                    f"there is no branch {request.at.branch}; there are {len(branches)}"
                )
            return orbit_between(branches[request.at.branch - 1], request.at.arclength)
        values = {**request.parameters, request.vary: request.at.value}
        model = self.catalogue.model(request.model, values)
        return periodic_orbit(model, request.at.period, request.at.state)

    def _plane(self, request: PlaneRequest, tell: Emit) -> None:
        model = self.catalogue.model(request.model, request.parameters)
        told = perf_counter()

        def observer(progress: LocusProgress) -> None:
            nonlocal told
            if perf_counter() - told < BETWEEN:
                return
            told = perf_counter()
            total = "" if progress.total is None else f" of {progress.total}"
            sentence = f"{progress.stage}: {progress.done}{total} done, {progress.text}"
            tell({"progress": sentence, "done": False})

        found = bifurcation_set(
            model,
            (request.x.name, request.y.name),
            (request.x.span, request.y.span),
            observer=observer,
        )
        tell(plane_view(found))

    def _simulation(self, request: SimulationRequest, tell: Emit) -> None:
        model = self.catalogue.model(request.model, request.parameters)
        start = None if request.start == "rest" else request.start
        stream_simulation(model, start, request.nudge, request.periods, tell)
