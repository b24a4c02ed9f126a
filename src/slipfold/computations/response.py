"""The periodic response of a model over a parameter, in one call."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from time import perf_counter

from slipfold.branches.event import Event
from slipfold.branches.progress import searching
from slipfold.branches.response import measured_over, trace_response
from slipfold.branches.settings import Settings
from slipfold.branches.start import Begin
from slipfold.checks.checked import Checked
from slipfold.checks.curves import check_branches
from slipfold.computations.given import (
    checked_model,
    checked_settings,
    parse_ends,
    refuse_varied,
)
from slipfold.errors import InputError
from slipfold.models.followed import check_followed
from slipfold.models.model import Model
from slipfold.models.quantity import parse_quantity
from slipfold.models.system import System
from slipfold.orbits.find import may_slip, orbit_near, periodic_orbit, settled_on
from slipfold.orbits.periodic_orbit import PeriodicOrbit, StickSlipOrbit
from slipfold.progress import Observer
from slipfold.results.diagram import Diagram
from slipfold.results.records import provenance
from slipfold.tori.of_response import tori_from, tori_of
from slipfold.tori.torus_branch import TorusBranch


def response(
    model: Model | PeriodicOrbit,
    vary: str,
    span: tuple[float | str, float | str],
    *,
    start: Mapping[str, float | str] | None = None,
    settled: bool = False,
    gradients: bool = False,
    search: bool | Mapping[str, tuple[float | str, float | str]] = False,
    tori: bool = False,
    settings: Settings | None = None,
    events: Sequence[Event] = (),
    observer: Observer | None = None,
    **parameters: float | str,
) -> Diagram:
    """Follow the periodic response of a model over a parameter, and every doubled branch.

    **Main arguments**

    Parameters
    ----------
    model
        The model, e.g. ``SlidingOscillator()``. Or a periodic orbit of it, at a value in the span:
        the branch through that orbit is followed, whether or not the response leads to it, from
        inside the span in both directions.
    vary
        Name of the parameter to follow.
    span
        Its first and last value: numbers in SI units, or text with a unit. A descending span is
        fine.
    start
        States by name, near an orbit that is followed instead of the response; of an autonomous
        model near a cycle or an equilibrium. With a value of the varied parameter among them the
        branch begins there, and goes in both directions. What is not given is the model's start.
    settled
        Whether what a motion from there settles on is followed instead; a torus if `tori` are
        wanted, too.
    gradients
        Whether special points are told with their `gradients`: how each moves with every other
        parameter, see `slipfold.gradients`.
    search
        Whether motions are then started at four values of the span, from 32 states each, and what
        they settle on is followed where no branch leads to it; of an autonomous model all
        equilibria that Newton's method finds from there, too. The states lie in a box three times
        as large as the branches, or in one that is given, as for `slipfold.attractors`.
    tori
        Whether the quasi-periodic tori are followed, too, that are born at Neimark-Sacker points of
        responses or cycles: `Diagram.tori`. With `settled` also the one that the motion settles on,
        in both directions.
    settings
        Options of continuation; the defaults of `slipfold.Settings` if None.
    events
        Values of outputs or of the parameter to locate.
    observer
        Called after every point, and at each normal form and check, with a
        `slipfold.Progress`. If it raises `KeyboardInterrupt`, or the user does,
        what is finished is returned.
    **parameters
        Parameters of the model to change first: numbers in SI units, or text with a unit.

    Returns
    -------
    Diagram
        Branches with their special points. They go on through stick and slip where contacts come to
        that; where no counter-body moves on, they begin at what a motion settles on. A branch that
        stops early says why in its `stopped`.

    Raises
    ------
    InputError
        For an unknown parameter, a wrong unit, a value outside its bounds, an empty span, or a
        start where no orbit is found.

    Examples
    --------
    >>> import slipfold as sf
    >>> diagram = sf.response(sf.SlidingOscillator(), vary="Nd", span=(0, 0.98), f=12.5)
    >>> round(diagram.branches[0].special[0].value, 9)
    0.043578911

    The cycle of the Lorenz system at a large Rayleigh number loses its symmetry, then doubles:

    >>> lorenz = sf.built_in_models()["lorenz"]()
    >>> cycle = sf.periodic_orbit(lorenz.replace(rho=350))
    >>> settings = sf.Settings(largest_period=1)
    >>> diagram = sf.response(cycle, vary="rho", span=(350, 310), settings=settings)
    >>> diagram.branches[0].special[0].type
    'BP'
    """
    orbit = model if isinstance(model, PeriodicOrbit) else None
    if orbit is not None:
        model = _model_of(orbit, vary, span, {**parameters, **(start or {})})
    refuse_varied([vary], parameters, "the span")
    model = checked_model(model)
    parameters[vary], last = _ends(model, vary, span)
    chosen = checked_settings(settings)
    started = perf_counter()
    changed = model.replace(**parameters)
    # Where a counter-body is at rest nothing slides all the time: a motion leads to an orbit.
    at_rest = orbit is None and changed.forced and not may_slip(changed)
    if orbit is None and not at_rest:
        check_followed(changed)
    watched = (*events, *own_events(changed, vary))
    ends = changed.values[vary], last
    found: tuple[TorusBranch, ...] = ()
    begin = None if orbit is None else Begin(orbit.model.values[vary], orbit)
    if orbit is None and (start is not None or settled or at_rest):
        there, state = _start(changed, vary, ends, start or {})
        try:
            begin = _begin(there, vary, state, settled, observer)
        except InputError:
            if not (settled and tori and may_slip(there)):
                raise
            found = tori_from(there, vary, state, ends, chosen, observer)
            if not found:
                raise
    # An orbit through stick has its own sizes.
    if begin is None or not isinstance(begin.orbit, StickSlipOrbit):
        changed = measured_over(changed, vary, ends, begin)
    follow = partial(
        trace_response,
        changed,
        vary,
        ends,
        settings=chosen,
        events=watched,
        observer=observer,
        through_stick=True,
    )
    searched, failure = None, None
    try:
        branches = () if found else follow(begin=begin)
    except InputError as error:
        if not search or begin is not None:
            raise
        branches, failure = (), error  # a search may find what exists elsewhere in the span
    if search:  # which takes more to import than to follow a branch
        from slipfold.long_term.box import checked_box
        from slipfold.long_term.coexisting import find_coexisting

        box = None if search is True else checked_box(changed, search)
        branches, searched = find_coexisting(changed, vary, ends, branches, follow, box, observer)
        if failure is not None and not branches:
            raise failure
    stopped = any(branch.interrupted for branch in branches)
    stopped |= searched is not None and searched.interrupted
    whole = True
    if gradients and not stopped:
        from slipfold.computations.gradients import with_gradients

        branches, whole = with_gradients(branches, chosen, observer)
    if tori and whole and not stopped and not found:
        found = tori_of(branches, ends, chosen, observer)
        whole = not any(item.interrupted for item in found)
    checked = check_branches(branches, observer) if whole else Checked((), interrupted=True)
    return Diagram(
        changed,
        vary,
        ends,
        branches,
        chosen,
        watched,
        provenance(perf_counter() - started),
        checked,
        searched,
        found,
    )


def _model_of(
    orbit: PeriodicOrbit,
    vary: str,
    span: tuple[float | str, float | str],
    parameters: Mapping[str, float | str],
) -> Model:
    """Return the model of an orbit that is to be followed; refuse what would not be its own."""
    if parameters:
        names = ", ".join(parameters)
        raise InputError(
            f"{names} cannot be changed, since the branch begins at a given orbit; find the orbit "
            "with the values wanted"
        )
    model = orbit.model
    first, last = _ends(model, vary, span)
    own = model.values[vary]
    if not min(first, last) <= own <= max(first, last):
        raise InputError(
            f"the span begins at {vary} = {first:g} but the orbit given lies at {vary} = {own:g}; "
            "begin the span there, or let it hold that value"
        )
    return model


def _start(
    model: Model, vary: str, span: tuple[float, float], start: Mapping[str, float | str]
) -> tuple[Model, dict[str, float]]:
    """Return the model at a start, and its states; it may have a value of the parameter."""
    units = {item.name: item.unit for item in model.states}
    at, state = model.values[vary], {}
    for name, value in start.items():
        if name == vary:
            parameter = model.parameter(vary)
            at = parameter.check(parse_quantity(value, parameter.unit, name))
        else:
            state[name] = parse_quantity(value, units.get(name, ""), name)
    if not min(span) <= at <= max(span):
        raise InputError(
            f"the start at {vary} = {at:g} is outside the span from {span[0]:g} to {span[1]:g}; "
            "give one inside it"
        )
    return model.replace(**{vary: at}), state


def _begin(
    there: Model, vary: str, state: dict[str, float], settled: bool, observer: Observer | None
) -> Begin:
    """Return where the first branch begins: near a state, or where a motion from it settles."""
    at = there.values[vary]
    if there.forced and not may_slip(there):
        try:
            return Begin(at, periodic_orbit(there, state=state or None))
        except InputError as error:
            raise InputError(f"at {vary} = {at:g} {error}") from None
    if settled:
        tell = searching(observer, at)
        found = settled_on(there, state, lambda progress: tell(progress.done))
    elif state or not there.forced:
        found = orbit_near(there, state)
    else:
        found = periodic_orbit(there)
    if isinstance(found, PeriodicOrbit):
        return Begin(at, found)
    return Begin(at, state=found)


def own_events(model: Model, vary: str) -> tuple[Event, ...]:
    """Return the events that the definition of a system asks for, as far as they can occur."""
    if not isinstance(model, System):
        return ()
    events = (Event(item.output, item.value, item.measure, item.stop) for item in model.events)
    return tuple(item for item in events if item.measure != "parameter" or item.name == vary)


def _ends(model: Model, vary: str, span: tuple[float | str, float | str]) -> tuple[float, float]:
    parameter = model.variable_parameter(vary)
    first, last = parse_ends(parameter, span)
    return parameter.check(first), parameter.check(last)
