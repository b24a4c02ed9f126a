"""From a request to its answers; the diagrams computed last are stored."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Hashable, Mapping
from contextlib import suppress
from dataclasses import replace
from time import perf_counter
from typing import Any, cast

from slipfold.bifurcations.branches.branch import Branch
from slipfold.bifurcations.branches.moved import moved_branches
from slipfold.bifurcations.branches.orbit_between import orbit_between
from slipfold.computations.loci import bifurcation_set
from slipfold.computations.response import response
from slipfold.errors import InputError
from slipfold.interface.explorer.catalogue import Catalogue
from slipfold.interface.explorer.curves import (
    GapsProgress,
    PlaneProgress,
    diagram_note,
    diagram_view,
    plane_view,
)
from slipfold.interface.explorer.export import (
    FIGURES,
    figure,
    modes_table,
    python_text,
    toml_text,
    written,
)
from slipfold.interface.explorer.first_views import send_screen
from slipfold.interface.explorer.friction import send_friction
from slipfold.interface.explorer.messages import (
    DiagramRequest,
    DrawnRequest,
    ExportRequest,
    OnBranch,
    OrbitRequest,
    PlaneRequest,
    PostedRequest,
    SimulationRequest,
    SweepRequest,
    ViewRequest,
)
from slipfold.interface.explorer.motions import send_motion
from slipfold.interface.explorer.pictures import send_basins, send_regimes
from slipfold.interface.explorer.plain import Check, Emit, axis_of, now_and_then
from slipfold.interface.explorer.settings import PAGE
from slipfold.interface.explorer.sounds import send_sound
from slipfold.interface.explorer.sweeps import send_sweep
from slipfold.interface.explorer.texts import answered
from slipfold.interface.explorer.trajectories import (
    Kept,
    ShownOrbit,
    found_again,
    jacobian_of,
    keep,
    orbit_at,
    orbit_view,
    send_exponents,
    send_simulation,
    solution_of,
)
from slipfold.models.model import Model
from slipfold.parameter_space.measurement import parse_measurement
from slipfold.progress import Observer, Progress
from slipfold.results.diagram import Diagram
from slipfold.results.locus_diagram import LocusDiagram
from slipfold.results.orbit import SavedOrbit
from slipfold.results.records import provenance
from slipfold.results.result import Result


class _Warm(Exception):
    """What takes longer is not needed yet."""


class Answering:
    """Answers requests, one after the other."""

    def __init__(self, catalogue: Catalogue) -> None:
        self._catalogue = catalogue
        self._made: Kept = OrderedDict()  # diagrams, planes and solutions
        self._nearest: Kept = OrderedDict()
        self._moved_diagrams: Kept = OrderedDict()
        # Keys of what the clock ended on a busy machine: it is computed again when it is shown.
        self._late = set[Hashable]()

    def warm_up(self, is_wanted: Callable[[], bool]) -> None:
        """Compile or load the flows of the first model, so that the first request does not wait.

        A diagram that takes long, or longer than until a request is there, is left as it is: by
        then its flows are compiled.
        """
        started = perf_counter()

        def check() -> None:
            if is_wanted() or perf_counter() - started > PAGE.warming:
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

        def send(view: dict[str, Any]) -> None:
            check()
            # No view may rename the request that it answers: the page would not take it.
            emit({"done": True, **view, **request.head})

        try:
            if request.kind in STREAMS:
                STREAMS[request.kind](self._catalogue.of(request), request, send, check)
            elif request.kind in VIEWS_OF_SOLUTIONS:
                show = VIEWS_OF_SOLUTIONS[request.kind]
                show(self._catalogue.of(request), request, send, check, self._made)
            else:
                self._answer(request, send, check)
        except InputError as error:
            send({"error": str(error)})

    def _answer(self, request: ViewRequest, send: Emit, check: Check) -> None:
        if isinstance(request, OrbitRequest):
            send(orbit_view(self._orbit(request, check), request.vary))
        elif isinstance(request, PlaneRequest):
            send(plane_view(self._plane(request, check, PlaneProgress(send, request.seconds))))
        else:
            request = cast(DiagramRequest, request)
            show, statistic = request.show, request.statistic
            axis_of(self._catalogue.of(request), show)  # before what takes time

            def show_early(known: Diagram) -> None:
                send({**diagram_view(known, show, statistic), "more": True, "done": False})

            moved = self._moved(request)
            if moved is not None:
                early = {"moved": True, "more": True, "done": not request.rests}
                send({**diagram_view(moved, show, statistic), **early})
                if not request.rests:
                    return
            watch = now_and_then(send, check, diagram_note)
            diagram = self._diagram(request, check, watch, show_early)
            send(diagram_view(diagram, show, statistic))

    def post(self, request: PostedRequest) -> Any:
        """Return the answer to a request over HTTP that is no export, as plain data."""
        return answered(self._catalogue, request)

    def export(self, request: ExportRequest, check: Check) -> bytes:
        """Make a file of a view, or the text that makes it."""
        view, model = request.view, self._catalogue.of(request.view)
        if request.format == "toml":
            return toml_text(model, view, self._catalogue.file(model)).encode()
        if isinstance(view, SweepRequest) and request.format != "python":
            raise InputError("a sweep cannot be saved as a file; copy it as Python")
        result: Result
        if request.format == "python":
            file = self._catalogue.file(model)
            return python_text(model, view, file, request.measurements).encode()
        if isinstance(view, OrbitRequest):
            orbit = self._orbit(view, check).orbit
            jacobian = jacobian_of(orbit)
            if jacobian is not None and request.format == "csv":
                return modes_table(orbit, jacobian)
            result = SavedOrbit(orbit.model, orbit, provenance(0.0))
        elif isinstance(view, DiagramRequest):
            result = self._diagram(view, check)
        elif isinstance(view, PlaneRequest):
            result = self._plane(view, check)
        else:
            view = cast(SimulationRequest, view)
            result = solution_of(model, view, lambda note: None, check, self._made)
        if request.format in FIGURES:
            pinned = {}
            if isinstance(view, DiagramRequest):
                for pin in request.pins:
                    other = view.model_copy(update={"parameters": pin.parameters})
                    pinned[pin.name] = self._diagram(other, check)
            read, name = None, request.measurements
            if request.measured is not None and isinstance(view, DiagramRequest):
                read = parse_measurement(request.measured, name or "the file", model)
            return figure(result, view, request.format, pinned, read)
        return written(result, request.format)

    def made(self, request: ViewRequest) -> Result | None:
        """Return the whole result of which an answer showed parts, if it has one."""
        result: Result | None = self._made.get(_key(self._catalogue.of(request), request))
        return result

    def adopt(self, view: DrawnRequest, result: Result) -> None:
        """Take what another process made for a view in place of computing it."""
        keep(self._made, _key(self._catalogue.of(view), view), result)

    # -- what is computed ----------------------------------------------------------------------

    def _moved(self, request: DiagramRequest) -> Diagram | None:
        """Return a diagram from the last followed one that differs in parameters alone.

        It is not moved from a moved one: what is drawn does not depend on the way of a slider.
        """
        model = self._catalogue.of(request)
        near, key = self._nearest.get(_family(model, request)), _key(model, request)
        if near is None or key in self._made:
            return None
        moved_key = near.model, key
        if moved_key not in self._moved_diagrams:
            branches = moved_branches(near.branches, model, near.span)
            if branches is None:
                return None
            changed = model.replace(**{request.vary: near.span[0]})
            moved = replace(near, model=changed, branches=branches, checked=None)
            keep(self._moved_diagrams, moved_key, moved)
        return self._moved_diagrams[moved_key]

    def _diagram(
        self,
        request: DiagramRequest | OrbitRequest,
        check: Check,
        observer: Observer | None = None,
        show: Callable[[Diagram], None] | None = None,
    ) -> Diagram:
        """Return the diagram that a request is about; show the response before what is added."""
        model = self._catalogue.of(request)
        key = _key(model, request)
        known: Diagram | None = self._made.get(key)
        if known is None or (observer and key in self._late):
            if known is not None and show is not None:
                show(known)
            watch = GapsProgress(_checking(check, observer), model, request, show)
            also = [item.along(request.vary) for item in request.also]
            given = (model, request.vary, request.span)
            known = response(*given, also=also, gaps=True, on_progress=watch)
            (self._late.add if watch.is_late else self._late.discard)(key)
        keep(self._nearest, _family(model, request), known)
        result: Diagram = keep(self._made, key, known)
        return result

    def _orbit(self, request: OrbitRequest, check: Check) -> ShownOrbit:
        """Return the orbit that a request is about; while a slider moves, on moved branches."""
        at, model = request.at, self._catalogue.of(request)
        if not isinstance(at, OnBranch):
            return ShownOrbit(orbit_at(model, request.vary, at), at)
        near, key = self._nearest.get(_family(model, request)), _key(model, request)
        moved = None
        if near is not None and key not in self._made:
            moved = self._moved_diagrams.get((near.model, key))
        branches = (moved or self._diagram(request, check)).branches
        if at.branch > len(branches):
            raise InputError(
                f"there is no branch {at.branch}; give a number from 1 to {len(branches)}"
            )
        branch = branches[at.branch - 1]
        orbit = orbit_between(branch, at.arclength, at.value)
        found, (low, high) = orbit.model.values[request.vary], sorted(request.span)
        if at.value is not None and abs(found - at.value) > PAGE.apart * (high - low):
            raise InputError(_elsewhere(branch, at, found))
        return found_again(model, orbit, request.vary)

    def _plane(
        self, request: PlaneRequest, check: Check, observer: PlaneProgress | None = None
    ) -> LocusDiagram:
        """Return the bifurcation set that a request is about."""
        model, x, y = self._catalogue.of(request), request.x, request.y
        key, watch = _key(model, request), _checking(check, observer)
        found: LocusDiagram | None = self._made.get(key)
        if found is None or (observer and key in self._late):  # a file is what is drawn
            plane = (x.name, y.name), (x.span, y.span)
            found = bifurcation_set(model, *plane, on_progress=watch)
            (self._late.add if observer and observer.is_late else self._late.discard)(key)
        result: LocusDiagram = keep(self._made, key, found)
        return result


STREAMS: Mapping[str, Callable[..., None]] = {
    "exponents": send_exponents,
    "basins": send_basins,
    "regimes": send_regimes,
    "sweep": send_sweep,
    "friction": send_friction,
    "screen": send_screen,
}
"""What answers a request by more than one view of its model."""

VIEWS_OF_SOLUTIONS: Mapping[str, Callable[..., None]] = {
    "simulation": send_simulation,
    "motion": send_motion,
    "sound": send_sound,
}
"""What shows a solution, which is kept for further views."""


def _checking(check: Check, observer: Observer | None) -> Observer:
    """Return what stops a computation that is no longer needed, and reports its progress."""

    def watch(progress: Progress) -> None:
        check()
        if observer is not None:
            observer(progress)

    return watch


def _elsewhere(branch: Branch, at: OnBranch, found: float) -> str:
    """Return why the orbit at a place of a branch has not the requested value."""
    is_before, is_beyond = at.arclength < branch.arclength[0], at.arclength > branch.arclength[-1]
    name, place, other = f"branch {branch.id}", f"{branch.vary} = {found:.6g}", f"{at.value:.6g}"
    if is_beyond and branch.stopped.kind == "interrupted":
        why = f"{name} was followed to {place} here, not to {other}, since it takes long"
    elif is_before or is_beyond:
        why = f"{name} {'begins' if is_before else 'ends'} at {place}, not at {other}"
    else:
        why = f"the orbit there on {name} has {place}, not {other}"
    return f"{why}; choose a point that is nearer"


def _key(model: Model, request: ViewRequest | DrawnRequest) -> Hashable:
    """Return the key of a result."""
    return model, request.subject()


def _family(model: Model, request: DiagramRequest | OrbitRequest) -> Hashable:
    """Return the key of diagrams that differ in parameters alone."""
    return model.kind, request.subject()
