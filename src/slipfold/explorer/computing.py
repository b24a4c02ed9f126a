"""Results of requests; the diagrams computed last are remembered."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Hashable
from dataclasses import replace

from slipfold.branches.draft import draft_branches
from slipfold.branches.orbit_between import orbit_between
from slipfold.computations.loci import bifurcation_set
from slipfold.computations.response import response
from slipfold.errors import InputError
from slipfold.explorer.catalogue import Catalogue
from slipfold.explorer.messages import (
    DiagramRequest,
    OnBranch,
    OrbitRequest,
    PlaneRequest,
)
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
            self._diagrams[key] = response(model, request.vary, request.span, on_progress=watch)
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
        return bifurcation_set(model, plane, window, regions=model.forced, on_progress=watch)


def _family(model: Model, request: DiagramRequest | OrbitRequest) -> Hashable:
    """Return the key of diagrams that differ in parameters alone."""
    return model.kind, request.vary, request.span
