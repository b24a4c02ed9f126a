"""Where the branches of a response begin: at the response, at orbits, at what solutions lead to."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from math import ulp
from typing import TYPE_CHECKING

from slipfold.bifurcations.branches.branch import Branch
from slipfold.bifurcations.branches.progress import searching
from slipfold.bifurcations.branches.settings import Settings
from slipfold.bifurcations.branches.start import Begin
from slipfold.bifurcations.tori.follow import tori_from
from slipfold.bifurcations.tori.torus_branch import TorusBranch
from slipfold.errors import InputError, refusal
from slipfold.models.equilibria import check_followed
from slipfold.models.model import Model
from slipfold.models.quantities import DURATION
from slipfold.models.units import interval, parse_quantity
from slipfold.options import Interval
from slipfold.orbits.find import (
    attractor_from,
    checked_period,
    may_slip,
    orbit_near,
    periodic_orbit,
)
from slipfold.orbits.periodic_orbit import PeriodicOrbit
from slipfold.progress import Observer

if TYPE_CHECKING:
    from slipfold.bifurcations.branches.gaps import BranchSearch


def first_begin(
    model: Model,
    vary: str,
    span: tuple[float, float],
    start: Mapping[str, float | str] | None,
    settled: bool,
    tori: bool,
    settings: Settings,
    on_progress: Observer | None,
) -> tuple[Begin | None, tuple[TorusBranch, ...]]:
    """Return where the first branch begins, None for the response; or the tori instead."""
    # Where a moving surface stands still nothing slides all the time: a solution leads to an orbit.
    asked = start is not None or settled
    if not asked and may_slip(model):
        return None, ()
    there, state = _start(model, vary, span, start or {})
    try:
        return _begin(there, vary, state, settled, on_progress), ()
    except InputError:
        if not (asked or model.forced):
            check_followed(model)
        if not (settled and tori and may_slip(there)):
            raise
        result = tori_from(there, vary, state, span, settings, on_progress)
        if not result:
            raise
        return None, result


@dataclass(frozen=True, eq=False)
class FurtherBranches:
    """The branches of a response, and those from elsewhere in the span."""

    model: Model
    unscaled: Model  # for solutions: what they are found with depends on where they start
    vary: str
    span: tuple[float, float]
    follow: Callable[..., tuple[Branch, ...]]
    also: Sequence[PeriodicOrbit | Mapping[str, float | str]]
    gaps: bool
    own: float  # value of the parameter that the model has itself
    search: bool | Mapping[str, Interval]
    observer: Observer | None

    def followed(
        self, begin: Begin | None, tori: tuple[TorusBranch, ...]
    ) -> tuple[tuple[Branch, ...], tuple[str, ...], BranchSearch | None, bool]:
        """Return the branches, none where there are tori instead.

        Beside them: why nothing was followed from some starts, the search, and whether it was
        interrupted.
        """
        branches: tuple[Branch, ...] = ()
        failure = None
        more = bool(self.also) or self.gaps or bool(self.search)
        if not tori:
            try:
                branches = self.follow(begin=begin)
            except InputError as error:
                if begin is not None or not more:
                    raise
                failure = error  # there may be branches elsewhere in the span
        if not more:
            return branches, (), None, any(branch.interrupted for branch in branches)
        # Imported late: these modules take longer to import than a branch to follow.
        from slipfold.long_term.coexisting import Further
        from slipfold.long_term.search import checked_box

        model, vary, span = self.model, self.vary, self.span
        known, searched = Further(branches, self.follow), None
        reasons = [known.add(partial(self._begin, start)) for start in self.also]
        if self.gaps:
            begin_at = lambda at: self._begin({vary: at})  # noqa: E731
            reasons.append(known.fill_gaps(model, span, begin_at, self.own, self.observer))
        if self.search and not known.interrupted:
            box = None if self.search is True else checked_box(model, self.search)
            searched = known.search(model, vary, span, box, self.observer)
        if failure is not None and not known.branches:
            raise failure
        return known.branches, tuple(filter(None, reasons)), searched, known.interrupted

    def _begin(self, start: PeriodicOrbit | Mapping[str, float | str]) -> Begin:
        """Return where the branch of a further start begins."""
        if isinstance(start, PeriodicOrbit):
            own, values = start.model.values, self.model.values
            free = () if self.model.forced else (DURATION.name,)
            differ = {name for name in own if own[name] != values[name]} - {self.vary, *free}
            if start.model.kind != self.model.kind or differ:
                raise InputError(
                    f"the orbit at {self.vary} = {own[self.vary]:g} has other parameters than the "
                    "response; find it with the same"
                )
            inside = within(own[self.vary], self.span)
            return Begin(own[self.vary] if inside is None else inside, start)
        taken = {self.vary, *(item.name for item in self.unscaled.states)}
        known = {
            name: start[name] for name in ("period", DURATION.name) if name in {*start} - taken
        }
        rest = {name: value for name, value in start.items() if name not in known}
        there, state = _start(self.unscaled, self.vary, self.span, rest)
        if known:
            period = checked_period(parse_quantity(known.pop("period", 1), "", "period"))
            timed = there.replace(**known)
            with suppress(InputError):
                lasting = timed.values[DURATION.name] if known else None
                return Begin(
                    there.values[self.vary],
                    periodic_orbit(there, period, state, duration=lasting),
                )
        return _begin(there, self.vary, state, True, self.observer)


def model_of(
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
            "with the desired values"
        )
    model = orbit.model
    first, last = interval(model.variable_parameter(vary), span)
    own = model.values[vary]
    if within(own, (first, last)) is None:
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
    inside = within(at, span)
    if inside is None:
        raise InputError(
            f"the start at {vary} = {at:g} is outside the span from {span[0]:g} to {span[1]:g}; "
            "give one inside it"
        )
    return model.replace(**{vary: inside}), state


def given_begin(orbit: PeriodicOrbit, vary: str, span: tuple[float, float]) -> Begin:
    """Return where the branch of an orbit begins, whose value of the parameter was checked."""
    inside = within(orbit.model.values[vary], span)
    assert inside is not None
    return Begin(inside, orbit)


def within(value: float, span: tuple[float, float]) -> float | None:
    """Return a value, or the end of the span that it exceeds by rounding; None if it is outside."""
    inside = min(max(value, min(span)), max(span))
    return inside if abs(inside - value) <= 4 * ulp(max(map(abs, span))) else None


def _begin(
    there: Model, vary: str, state: dict[str, float], settled: bool, on_progress: Observer | None
) -> Begin:
    """Return where the first branch begins: near a state, or at the attractor reached from it."""
    at, slides = there.values[vary], may_slip(there)
    try:
        if settled:
            send = searching(on_progress, at)
            result = attractor_from(there, state, lambda progress: send(progress.done))
        elif state or (slides and not there.forced):
            result = orbit_near(there, state)
        else:
            result = periodic_orbit(there)
    except InputError as error:
        if slides:
            raise
        reason = refusal(check_followed, there)
        rest = "" if there.forced else f"; no equilibrium is followed, since {reason}"
        raise InputError(f"at {vary} = {at:g} {error}{rest}") from None
    if isinstance(result, PeriodicOrbit):
        return Begin(at, result)
    check_followed(there)
    return Begin(at, state=result)
