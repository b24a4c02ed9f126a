"""Bifurcations followed in two parameters, from special points of branches, in one call."""

from __future__ import annotations

from collections.abc import Iterable
from time import perf_counter
from typing import Any

from slipfold.branches.settings import Settings
from slipfold.branches.special_point import SpecialPoint
from slipfold.checks.curves import check_loci
from slipfold.computations.bifurcation_set import bifurcation_set
from slipfold.computations.given import checked_settings
from slipfold.computations.plane import GivenWindow, corner_model, parse_plane, with_place
from slipfold.errors import InputError
from slipfold.loci.follow import follow_loci
from slipfold.models.model import Model
from slipfold.progress import Observer
from slipfold.results.diagram import Labelled
from slipfold.results.locus_diagram import LocusDiagram
from slipfold.results.records import provenance

Given = SpecialPoint | Labelled
"""A special point, alone or with its branch."""


def locus(
    special_point: Model | Given | Iterable[Given],
    vary: tuple[str, str],
    window: GivenWindow | None = None,
    *,
    type: str | None = None,
    settings: Settings | None = None,
    observer: Observer | None = None,
    switch: bool = True,
) -> LocusDiagram:
    """Follow the locus of a bifurcation in two parameters, and the loci that start on it.

    Parameters
    ----------
    special_point
        A special point of a branch, of type LP, PD, NS, BP or HB, or where contacts begin to do
        something, GRAZE, STICK or LIFT; or several of one model. An item of `Diagram.special` will
        do, and so will all of them. Or a model, whose loci in the window are looked for, see
        `bifurcation_set`.
    vary
        Names of the two parameters; that of the branch need not be among them.
    window
        Two values of each, always to be given: a pair of pairs in the order of `vary`, or pairs by
        name; numbers in SI units, or text with a unit such as ``"20deg"``.
    type
        With a model, the one type of bifurcation to follow, e.g. ``"HB"``; all if None.
    settings
        Options of continuation; the defaults of `slipfold.Settings` if None.
    observer
        Called after every point, and at each normal form and check, with a
        `slipfold.Progress`. If it raises `KeyboardInterrupt`, what is finished is returned.
    switch
        Whether loci that start at points of codimension two are followed as well; with a model,
        those of the given type are.

    Returns
    -------
    LocusDiagram
        Loci with their special points. One that stops early says why in its `begun` or `stopped`.

    Raises
    ------
    InputError
        For a point that has no locus in this plane or is outside the window, an unknown parameter,
        the same one twice, a wrong unit, a value outside its bounds, or an empty window.

    Examples
    --------
    >>> import slipfold as sf
    >>> diagram = sf.response(sf.SlidingOscillator(), vary="Nd", span=(0, 0.05), f=12.5)
    >>> window = {"f": (12.4, 12.6), "Nd": (0, "100mN")}
    >>> doubling, = sf.locus(diagram.special[0], ("f", "Nd"), window, switch=False).loci
    >>> doubling.type, doubling.period, doubling.stopped.kind
    ('PD', 1, 'window')

    >>> from slipfold.models import model_named
    >>> onset, = sf.locus(
    ...     model_named("lure"), ("a", "b"), ((0.9, 1.1), (0.9, 1.1)), type="HB"
    ... ).loci
    >>> onset.kind, bool(abs(onset.values.prod(axis=1) - 1).max() < 1e-12)
    ('equilibrium', True)
    """
    if isinstance(special_point, Model):
        return _of_model(special_point, vary, window, type, settings, observer, switch)
    if type is not None:
        raise InputError(
            f"type = {type!r} goes with a model, but special points have theirs; leave it out"
        )
    points = _points(special_point)
    model = points[0].model
    plane, spans = parse_plane(model, vary, window)
    base = corner_model(model, plane, spans)
    chosen = checked_settings(settings)
    observer = with_place(observer, model, plane)
    started = perf_counter()
    remarks: list[str] = []
    loci = follow_loci(
        points, plane, spans, settings=chosen, observer=observer, switch=switch, remarks=remarks
    )
    checked = check_loci(loci, observer)
    return LocusDiagram(
        base,
        plane,
        spans,
        loci,
        None,
        chosen,
        provenance(perf_counter() - started),
        interrupted=checked.interrupted,
        missing=tuple(remarks),
        checked=checked,
    )


def _of_model(
    model: Model,
    vary: tuple[str, str],
    window: GivenWindow | None,
    type_: str | None,
    settings: Settings | None,
    observer: Observer | None,
    switch: bool,
) -> LocusDiagram:
    if not switch:
        raise InputError(
            "switch=False is for loci from special points, but a model is given; give a type of "
            'bifurcation instead, e.g. type="PD"'
        )
    return bifurcation_set(
        model, vary, window, types=type_, regions=False, settings=settings, observer=observer
    )


def _points(given: Given | Iterable[Given]) -> list[SpecialPoint]:
    items: list[Any] = [given] if isinstance(given, SpecialPoint | Labelled) else _listed(given)
    points = [item.point if isinstance(item, Labelled) else item for item in items]
    for point in points:
        if not isinstance(point, SpecialPoint):
            raise InputError(
                f"{point!r} is not a special point of a branch; give e.g. diagram.special[0]"
            )
    if not points:
        raise InputError("no special point is given; give at least one, e.g. diagram.special[0]")
    return points


def _listed(given: Any) -> list[Any]:
    return list(given) if isinstance(given, Iterable) and not isinstance(given, str) else [given]
