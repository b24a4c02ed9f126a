"""Nonlinear modes: frequency and damping of free vibration over its amplitude."""

from __future__ import annotations

import math
from time import perf_counter

from slipfold import options
from slipfold.bifurcations.branches.modes import balanced_mode, trace_mode
from slipfold.bifurcations.branches.settings import Event, Settings
from slipfold.computations.arguments import checked_model, checked_settings
from slipfold.declarations import documented
from slipfold.errors import InputError
from slipfold.models.model import Model
from slipfold.models.nonlinear_mode import XI, NonlinearMode
from slipfold.models.units import parse_quantity
from slipfold.parameter_space.measurement import parse_measured
from slipfold.progress import Observer
from slipfold.results.checks.curves import check_branches
from slipfold.results.diagram import Diagram, finalized
from slipfold.results.records import provenance


@documented
def backbone(
    model: Model,
    output: options.AmplitudeOf,
    up_to: options.UpTo,
    *,
    mode: options.ModeNumber = 1,
    settings: Settings | None = None,
    on_progress: Observer | None = None,
    **parameters: float | str,
) -> Diagram:
    """Follow a nonlinear mode: the frequency and the damping ratio of free vibration.

    Without forcing vibration decays. Negative damping `xi` in proportion to the mass keeps it
    periodic (see `slipfold.NonlinearMode`). Its cycles leave rest where `xi` balances the damping
    of a linear mode, and are followed to an amplitude.

    Returns
    -------
    Diagram
        Its branch is the backbone. `plot` draws frequency and damping ratio over the amplitude.

    Examples
    --------
    >>> import slipfold as sf
    >>> diagram = sf.backbone(sf.built_in_models()["duffing"](), "q", 3)
    >>> (branch,) = diagram.branches
    >>> [round(6.283185307 / duration, 6) for duration in branch.durations[[0, -1]].tolist()]
    [1.0, 1.289811]
    """
    changed = NonlinearMode(checked_model(model).replace(**parameters))
    unit = parse_measured(f"max {output}", changed).unit
    amplitude = parse_quantity(up_to, unit, "up_to")
    if not 0 < amplitude < math.inf:
        raise InputError(f"up_to = {amplitude:g} is no amplitude; give a finite number > 0")
    chosen, started = checked_settings(settings), perf_counter()
    linear = balanced_mode(changed, mode)
    span = -linear.frequency, linear.frequency
    if not span[0] < linear.xi < span[1]:
        raise InputError(
            f"mode {mode} of {changed.name} has the damping ratio "
            f"{linear.xi / (2 * linear.frequency):.3g}; a backbone needs one from -0.5 to 0.5"
        )
    event = Event(output, amplitude, stop=True)
    branches = trace_mode(changed, linear, span, event, chosen, on_progress)
    checked = check_branches(branches, on_progress)
    diagram = Diagram(
        changed, XI.name, span, branches, chosen, (event,), provenance(perf_counter() - started),
        checked,
    )  # fmt: skip
    return diagram if diagram.interrupted else finalized(diagram)
