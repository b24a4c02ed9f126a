"""Results of requests; the diagrams computed last are remembered, so that a click is quick."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Hashable
from dataclasses import replace

from slipfold.branches.carried.carry import carry_branches
from slipfold.branches.orbit_between import orbit_between
from slipfold.computations.loci import bifurcation_set
from slipfold.computations.response import response
from slipfold.errors import InputError
from slipfold.explorer.asked import asked_model
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

KEPT = 16
"""Diagrams kept, each below a megabyte."""

Check = Callable[[], None]


class Computing:
    """Computes what requests are about."""

    def __init__(self, catalogue: Catalogue) -> None:
        self._catalogue = catalogue
        self._kept: OrderedDict[Hashable, Diagram] = OrderedDict()
        self._nearest: dict[Hashable, Diagram] = {}

    def draft(self, request: DiagramRequest) -> Diagram | None:
        """Return a diagram from the last one that differs in parameters alone."""
        model = asked_model(self._catalogue, request)
        near = self._nearest.get(_family(model, request))
        if near is None or (model, request.vary, request.span) in self._kept:
            return None
        changed = model.replace(**{request.vary: request.span[0]})
        branches = carry_branches(near.branches, changed)
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

        model = asked_model(self._catalogue, request)
        key = (model, request.vary, request.span)
        if key not in self._kept:
            self._kept[key] = response(model, request.vary, request.span, observer=watch)
        self._nearest[_family(model, request)] = self._kept[key]
        self._kept.move_to_end(key)
        while len(self._kept) > KEPT:
            self._kept.popitem(last=False)
        while len(self._nearest) > KEPT:
            del self._nearest[next(iter(self._nearest))]
        return self._kept[key]

    def orbit(self, request: OrbitRequest, check: Check) -> PeriodicOrbit:
        """Return the orbit that a request is about."""
        at = request.at
        if not isinstance(at, OnBranch):
            model = asked_model(self._catalogue, request).replace(**{request.vary: at.value})
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
        model = asked_model(self._catalogue, request)
        return bifurcation_set(model, plane, window, regions=model.forced, observer=watch)


def _family(model: Model, request: DiagramRequest | OrbitRequest) -> Hashable:
    """Return what diagrams share that differ in parameters alone."""
    return model.kind, request.vary, request.span
