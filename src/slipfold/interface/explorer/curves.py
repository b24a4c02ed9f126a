"""Curves as plain data: responses, bifurcation sets, measurements, studies."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from time import perf_counter, process_time
from typing import Any

import numpy as np

from slipfold.bifurcations.branches.branch import Branch
from slipfold.bifurcations.branches.settings import Settings
from slipfold.bifurcations.branches.special_point import SpecialPoint
from slipfold.bifurcations.loci.locus import Locus, LocusPoint
from slipfold.bifurcations.loci.region_map import RegionMap
from slipfold.bifurcations.loci.window import LocusLine
from slipfold.continuation.end import End
from slipfold.errors import InputError
from slipfold.interface.explorer.messages import DiagramRequest, OrbitRequest
from slipfold.interface.explorer.plain import Emit, axis_of, number, short, without_options
from slipfold.interface.explorer.settings import PAGE
from slipfold.lines import branch_segments, locus_segments, measured_at, parts_of
from slipfold.long_term.coexisting import INTERRUPTED
from slipfold.models.model import Model
from slipfold.orbits.bifurcation_types import BIFURCATION_TYPES, CODIMENSION_TWO, CONTACT_TYPES
from slipfold.parameter_space.measurement import Measurement
from slipfold.progress import Observer, Progress
from slipfold.results.checks.checked import Checked
from slipfold.results.curves import ROUNDING
from slipfold.results.diagram import Diagram
from slipfold.results.locus_diagram import LocusDiagram
from slipfold.results.records import provenance
from slipfold.results.study import StudyResult
from slipfold.studies.plan import Grid
from slipfold.text import certain, listed, place_text

LONG = "not followed farther here, since it takes long; the copied Python does"


def checked_view(checked: Checked | None) -> dict[str, Any] | None:
    """Return what was checked as plain data: a sentence, and whether all agree."""
    if checked is None or not checked.checks:
        return None
    return {"sentence": str(checked), "agree": checked.agree}


def diagram_view(diagram: Diagram, show: str, statistic: str) -> dict[str, Any]:
    """Return a diagram as plain data; with two lines a branch, its branches come twice."""
    model = diagram.model
    return {
        "x": axis_of(model, diagram.vary),
        "y": {**axis_of(model, show), "statistic": statistic},
        "branches": [
            {
                **_branch(branch, show, part),
                "started": _end(branch.started, diagram.span, None),
                "stopped": _end(branch.stopped, diagram.span, branch),
            }
            for part in parts_of(statistic)
            for branch in diagram.branches
        ],
        "checked": checked_view(diagram.checked),
        "unfollowed": [
            LONG if why == INTERRUPTED else without_options(why) for why in diagram.unfollowed
        ],
    }


def _branch(branch: Branch, show: str, statistic: str) -> dict[str, Any]:
    x: list[float] = []
    y: list[float] = []
    s: list[float] = []
    segments = []
    for line in branch_segments(branch, show, statistic):
        first = max(len(x) - 1, 0)
        skip = 1 if x else 0  # a segment starts where the one before ends
        x += line.parameter[skip:].tolist()
        y += line.value[skip:].tolist()
        s += line.arclength[skip:].tolist()
        segments.append({"kind": line.kind, "first": first, "last": len(x) - 1})
    shown = [item for item in branch.special if item.type in (*BIFURCATION_TYPES, *CONTACT_TYPES)]
    alone = (measured_at(point, show, statistic) for point in shown)  # one point has no line
    heights = np.interp([point.arclength for point in shown], s, y).tolist() if s else alone
    return {
        "id": branch.id,
        "kind": branch.kind,
        "period": branch.period,
        "statistic": statistic,
        "x": short(x),
        "y": short(y),
        "arclength": short(s),
        "segments": segments,
        "special": [*map(_special, shown, heights)],
    }


def _special(point: SpecialPoint, y: float) -> dict[str, Any]:
    """Return a special point as plain data; it is a point of the line."""
    return {
        "type": point.type,
        "name": point.name,
        "value": certain(point.value, point.uncertainty),
        "uncertainty": number(point.uncertainty),
        "y": y,
        "arclength": point.arclength,
        "period": point.period,
        "criticality": point.criticality,
        "undecided": point.undecided is not None,
        "words": _words(point),
        "sentence": _sentence(point),
    }


def _words(point: SpecialPoint) -> str:
    return " ".join(filter(None, [point.criticality, point.name]))


def _sentence(point: SpecialPoint) -> str:
    at = place_text(point.model, [point.vary], point.certain_values)
    lead = "" if point.leads_to is None else f"; branch {point.leads_to} leaves here"
    period = f" of period {point.period}" if point.model.forced else ""
    unknown = "" if point.undecided is None else f"; {point.undecided}"
    text = f"{_words(point)}{period} at {at}{lead}{unknown}"
    return text[0].upper() + text[1:]


def _end(end: End, span: tuple[float, float], branch: Branch | None) -> dict[str, Any]:
    """Return an end as plain data; of a last one also what lies beyond."""
    return {
        "kind": end.kind,
        "reason": LONG if end.kind == "interrupted" else without_options(end.reason),
        "value": number(certain(end.value, ROUNDING * max(map(abs, span)))),
        "beyond": _beyond(branch) if branch is not None and end.kind == "failed" else None,
    }


def _beyond(branch: Branch) -> dict[str, Any] | None:
    """Return where a solution starts that shows what lies beyond the end of a branch.

    None where its last two points do not determine where that is.
    """
    away = float(branch.parameter[-1] - branch.parameter[-2]) if len(branch) > 1 else 0.0
    known = np.flatnonzero(np.isfinite(branch.states).all(axis=1))
    if away == 0.0 or not len(known):
        return None
    state = branch.states[known[-1]]  # a mesh may leave the last one without states
    names = [item.name for item in branch.model.states]
    return {
        "direction": math.copysign(1.0, away),
        "state": dict(zip(names, state.tolist(), strict=True)),
    }


def diagram_note(progress: Progress) -> dict[str, Any]:
    """Return how far a response is followed: in words, and the parameter at the last point."""
    values = progress.values
    words = f"branch {values['branch']}, {values['points']} points"
    if progress.stage != "branches":
        words += f", {progress.stage}: {progress.done} done"
    return {"progress": words, "value": number(values["parameter"])}


class GapsProgress:
    """The progress of a response; an observer of its computation.

    What is known before gaps are filled, or before it is checked, is shown. Branches that take
    longer than a reader waits end where they are, before a request is given up on a busy machine.
    """

    def __init__(
        self,
        observer: Observer,
        model: Model,
        request: DiagramRequest | OrbitRequest,
        show: Callable[[Diagram], None] | None,
    ) -> None:
        self._observer = observer
        self._about = model.replace(**{request.vary: request.span[0]}), request.vary, request.span
        self._show = show
        self._end = process_time() + PAGE.following
        self._last = perf_counter() + request.seconds / 2
        self._stage = "branches"
        self.is_late = False  # whether the clock ended it

    def __call__(self, progress: Progress) -> None:
        """Take a note of the computation."""
        self._observer(progress)
        if progress.stage in ("gaps", "checks") and self._stage == "branches":
            self._stage, self._end = progress.stage, process_time() + PAGE.filling
            branches = progress.values["branches"]
            if branches and self._show is not None:
                known = Diagram(*self._about, branches, Settings(), (), provenance(0.0))
                self._show(known)
        ends = "points" in progress.values or self._stage != "branches"  # where there is something
        late = ends and perf_counter() > self._last
        over = process_time() > self._end
        if progress.stage != "checks" and (late or over):
            self.is_late |= not over
            raise KeyboardInterrupt


def plane_view(result: LocusDiagram) -> dict[str, Any]:
    """Return a bifurcation set as plain data."""
    first, second = result.vary
    notes = [*([] if result.loci else ["no bifurcation was found in this window"]), *result.missing]
    return {
        "x": {**axis_of(result.model, first), "span": list(result.window[0])},
        "y": {**axis_of(result.model, second), "span": list(result.window[1])},
        "loci": loci_view(result.loci),
        "checked": checked_view(result.checked),
        "regions": None if result.regions is None else _regions(result.regions),
        "note": f"unfinished: {LONG}" if result.interrupted else "; ".join(notes) or None,
    }


def loci_view(loci: Iterable[Locus]) -> list[dict[str, Any]]:
    """Return loci as plain data."""
    return [_locus(locus) for locus in loci]


def _locus(locus: Locus) -> dict[str, Any]:
    return {
        "id": locus.id,
        "type": locus.type,
        "period": locus.period,
        "name": locus.heading,
        "segments": [
            {"criticality": line.kind, "x": short(line.points[:, 0]), "y": short(line.points[:, 1])}
            for line in locus_segments(locus)
        ],
        "special": [_locus_point(locus, point) for point in locus.special],
        "started": {"kind": locus.started.kind, "reason": locus.started.reason},
        "stopped": {"kind": locus.stopped.kind, "reason": locus.stopped.reason},
    }


def _locus_point(locus: Locus, point: LocusPoint) -> dict[str, Any]:
    position = place_text(point.model, point.vary, point.certain_values)
    name = point.name[0].upper() + point.name[1:]
    return {
        "type": point.type,
        "x": number(point.values[0]),
        "y": number(point.values[1]),
        "sentence": f"{name} on the {locus.heading} at {position}",
        "meaning": meaning_of(point.type),
    }


MULTIPLIERS = {1.0: "1", -1.0: "-1", "pair": "a pair on the unit circle"}
EIGENVALUES = {1.0: "0", "pair": "an imaginary pair"}
"""What is critical, in words."""


def meaning_of(type_: str) -> str:
    """Return what happens at a type of point of codimension two.

    >>> meaning_of("GPD")
    'Here the PD changes from supercritical to subcritical. LP loci start here.'
    """
    if type_ not in CODIMENSION_TWO:
        return ""
    kind = CODIMENSION_TWO[type_]
    changed = [name for name, item in BIFURCATION_TYPES.items() if type_ in item.sign_changes]
    if len(kind.critical) > 1:
        is_equilibrium = "HB" in kind.through or type_ == "HH"
        names = EIGENVALUES if is_equilibrium else MULTIPLIERS
        words = "eigenvalues" if is_equilibrium else "multipliers"
        text = f"Critical {words}: {listed(names[each] for each in kind.critical)}."
    elif changed:
        text = f"Here the {changed[0]} changes from supercritical to subcritical."
    elif kind.critical == ("pair",):
        text = f"The critical multipliers are exp(±2πi/{type_[1:]})."
    else:
        text = "Two folds meet and end."
    starting = listed(dict.fromkeys(name for name, _ in kind.emanating))
    crossing = f" {listed(kind.through)} loci pass through it." if kind.through else ""
    return f"{text}{crossing}" + (f" {starting} loci start here." if starting else "")


def _regions(regions: RegionMap) -> dict[str, Any]:
    return {
        "x": short(regions.first),
        "y": short(regions.second),
        "labels": np.asarray(regions.labels).tolist(),
        "names": {str(item.id): item.name for item in regions.regions},
        "stable": {str(item.id): list(item.stable) for item in regions.regions if item.known},
        "known": {str(item.id): item.known for item in regions.regions},
        "sticks": {str(item.id): bool(item.sticking) for item in regions.regions},
    }


class PlaneProgress:
    """The progress of a bifurcation set, sent now and then; an observer of its computation.

    `send` takes each note: ``progress``, a sentence; ``lines``, those extended, each with
    all its points so far, by ``number``; and ``loci`` once all are followed. A set that takes
    long ends where it is, on a busy machine before the request, after `seconds`, is given up.
    """

    def __init__(self, send: Emit, seconds: float) -> None:
        self._send = send
        self._sent = perf_counter()
        self._end, self._latest = process_time() + PAGE.loci, self._sent + seconds / 2
        self._grown: dict[LocusLine, list[tuple[float, float]]] = {}
        self._last: LocusLine | None = None
        self.is_late = False  # whether the clock ended it

    def __call__(self, progress: Progress) -> None:
        """Take a note of the computation."""
        over = process_time() > self._end
        late = over or perf_counter() > self._latest
        if late and progress.stage in ("responses", "loci", "regions"):
            self.is_late |= not over
            raise KeyboardInterrupt
        self._grow(progress)
        followed = progress.values.get("loci")
        if perf_counter() - self._sent < PAGE.interval and not followed:
            return
        self._sent = perf_counter()
        total = "" if progress.total is None else f" of {progress.total}"
        now = progress.text.replace("  ", ", ")  # what a terminal has in columns
        sentence = f"{progress.stage}: {progress.done}{total} done, {now}"
        lines = [_grown_line(line, points) for line, points in self._grown.items()]
        loci = {"loci": loci_view(followed)} if followed else {}
        self._send({"progress": sentence, "lines": lines, **loci, "done": False})
        self._grown = {key: points for key, points in self._grown.items() if key == self._last}

    def _grow(self, progress: Progress) -> None:
        line = self._last = progress.values.get("line")
        if line is not None:
            self._grown.setdefault(line, [line.start]).append(progress.values["place"])


def _grown_line(line: LocusLine, points: list[tuple[float, float]]) -> dict[str, Any]:
    return {
        "number": line.number,
        "type": line.type,
        "period": line.period,
        "name": line.name,
        "x": short([first for first, _ in points]),
        "y": short([second for _, second in points]),
    }


def measurements_view(measurement: Measurement) -> dict[str, Any]:
    """Return measurements by quantity, SI units; None where there is no value or no error."""
    return {
        "vary": measurement.vary,
        "values": measurement.values.tolist(),
        "sweep": list(measurement.sweep),
        "quantities": [
            {
                "show": item.output,
                "statistic": item.measure,
                "measurements": [number(value) for value in measurement.measured[:, k]],
                "errors": [number(value) for value in measurement.errors[:, k]],
            }
            for k, item in enumerate(measurement.quantities)
        ],
    }


def study_view(result: StudyResult, name: str) -> dict[str, Any]:
    """Return a study of the model with this name on the page; None where there is no value.

    Raises `InputError` if it is too large to be shown.
    """
    if len(result) > PAGE.points:
        raise InputError(
            f"the study has {len(result)} cases and the page shows {PAGE.points} at most; open a "
            "smaller one, or draw it with slipfold plot"
        )
    model, cases = result.model, result.cases
    columns = cases.values(np.arange(len(result))).T
    varied = result.work.record()
    return {
        "model": name,
        "title": repr(result)[1:-1],
        "isGrid": isinstance(cases, Grid),
        "parameters": [
            {**axis_of(model, parameter), "values": column.tolist()}
            for parameter, column in zip(cases.names, columns, strict=True)
        ],
        "quantities": [_quantity(result, item.name) for item in result.quantities],
        "reasons": result.reasons.tolist(),
        "vary": varied.get("vary") if isinstance(varied.get("vary"), str) else None,
        "span": varied.get("span"),
    }


def _quantity(result: StudyResult, name: str) -> dict[str, Any]:
    (item,) = (each for each in result.quantities if each.name == name)
    values = result.values[name]
    is_text = item.kind == "text"
    known = [(str(value) or None) if is_text else number(value) for value in values]
    return {
        "name": name,
        "label": name,
        "unit": item.unit,
        "doc": item.meaning,
        "isText": is_text,
        "values": [
            None if reason else value for value, reason in zip(known, result.reasons, strict=True)
        ],
    }
