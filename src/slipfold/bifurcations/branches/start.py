"""Where the first branch of a response begins: the response, an equilibrium, or a given orbit."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from slipfold.arrays import Array
from slipfold.bifurcations.branches.closed_branches import CLOSING, half_orbit, rests_at
from slipfold.bifurcations.branches.settings import Settings
from slipfold.continuation.end import End
from slipfold.continuation.newton import Correction, correct
from slipfold.errors import NUMERICAL, InputError, breakdown
from slipfold.flow.flow import flow_of
from slipfold.flow.modes import contacts_of
from slipfold.flow.scales import measured_within
from slipfold.models.equilibria import search_equilibrium
from slipfold.models.model import Model
from slipfold.orbits.collocation import Collocation
from slipfold.orbits.continued import by_collocation, hold_parameter
from slipfold.orbits.discretization import Cut, damps_stiff, is_stiff, scheme_for
from slipfold.orbits.eigenvalues import unit_of_time
from slipfold.orbits.find import may_slip, periodic_orbit
from slipfold.orbits.first_orbits import find_response
from slipfold.orbits.kinds import Equilibria, ForcedOrbits, orbits_of
from slipfold.orbits.limits import broken_limit
from slipfold.orbits.meshes import INTERVALS
from slipfold.orbits.modal_shooting import ModalShooting, segments_for, shooting_for
from slipfold.orbits.orbit_curve import OrbitPoint, Orbits
from slipfold.orbits.periodic_orbit import PeriodicOrbit, StickSlipOrbit
from slipfold.orbits.shooting import SEGMENTS, Shooting
from slipfold.orbits.switched_shooting import SwitchedShooting

SLIPS = (
    "contacts of {name} reverse or stick where the span of {vary} begins, and only contacts that "
    "always slip one way are followed here; make their law smooth: Regularized(law, e=...), in a "
    'file {{ law = "Regularized", of = {{ law = ... }}, e = ... }}, or among equations a formula '
    "such as mu*N*tanh(v/e)"
)
"""Why a response is refused where branches do not continue across sticking phases."""

WORST = 1e8
"""Condition number above which the first value of the parameter is a fold or branch point."""


@dataclass(frozen=True, eq=False)
class Begin:
    """A value of the parameter, and what is there."""

    value: float  # the value; inside the span the branch is followed from it in both directions
    # An orbit at that value, or None for an equilibrium of an autonomous model
    orbit: PeriodicOrbit | None = None
    # State near that equilibrium, shape (n,); None with an orbit
    state: Array | None = None

    def with_scales(self, sizes: Array | None) -> Begin:
        """Return the same in other typical sizes of the states. Shapes: sizes (n,)."""
        if self.orbit is None:
            return self
        model = self.orbit.model.with_scales(sizes)
        return replace(self, orbit=replace(self.orbit, model=model))


def measured_over(
    model: Model, vary: str, span: tuple[float, float], begin: Begin | None = None
) -> Model:
    """Return a model that knows how large its states become over a span of a parameter."""
    values = [{vary: value} for value in (span[0], sum(span) / 2, span[1])]
    orbit = None if begin is None else begin.orbit
    return measured_within(model, values, None if orbit is None else orbit.nodes)


@dataclass(frozen=True, eq=False)
class FirstOrbit:
    """The search for the orbit with which the first branch of a response begins.

    Of an autonomous model that is an equilibrium.
    """

    model: Model
    vary: str
    span: tuple[float, float]
    settings: Settings
    through_stick: bool
    report: Callable[[int], None]  # called with the periods that have led to no orbit yet

    def find(self, begin: Begin | None) -> tuple[Orbits, OrbitPoint, End]:
        """Return the orbits of the first branch, its first point, and why it begins there.

        Where the first value of the span has no response, it begins at the last.
        """
        orbits, point, reason = self._given(begin) if begin else self._at_an_end()
        if self.settings.discretization == "collocation" and orbits.kind == "periodic":
            by_mesh = by_collocation(orbits, point)
            if by_mesh is None:
                raise InputError(
                    f"the orbit at {orbits.vary} = {orbits.value(point.z):g} could not be taken up "
                    "by collocation; use shooting"
                )
            orbits, point = by_mesh
        elif isinstance(orbits.by, Collocation):
            orbits, point = by_collocation(orbits, point) or (orbits, point)
        return point.curve if orbits.by.adapts else orbits, point, reason

    def _given(self, begin: Begin) -> tuple[Orbits, OrbitPoint, End]:
        first, last = self.span
        # On the last value it can only go back.
        width = first - last if begin.value == last else last - first
        ends = begin.value, begin.value + width
        if begin.orbit is not None:
            start = _from_orbit(begin.orbit, self.vary, *ends)
        else:
            there = self.model.replace(**{self.vary: begin.value})
            start = equilibrium_start(there, self.vary, *ends, begin.state)
        return *start, span_begin(self.vary, begin.value)

    def _at_an_end(self) -> tuple[Orbits, OrbitPoint, End]:
        first, last = self.span
        try:
            return *self._at(first, last), span_begin(self.vary, first)
        except InputError as error:
            sticking = self._sticking(first) if self.through_stick else None
            if sticking is not None:
                return self._given(sticking)
            try:
                start = self._at(last, first)
            except InputError:
                if self.through_stick or self._sticking(first) is None:
                    raise error from None
                raise InputError(SLIPS.format(name=self.model.name, vary=self.vary)) from None
        what = "response of period 1" if self.model.forced else "equilibrium"
        reason = (
            f"there is no regular {what} at {self.vary} = {first:g}, so the span was followed "
            f"from its other end, {self.vary} = {last:g}"
        )
        return *start, End("span", reason, last)

    def _at(self, value: float, other: float) -> tuple[Orbits, OrbitPoint]:
        """Return the response or the equilibrium at one end of the span."""
        model = self.model.replace(**{self.vary: value})
        try:
            if not model.forced:
                return equilibrium_start(model, self.vary, value, other)
            return self._response(model, value, other)
        except NUMERICAL as error:
            raise InputError(
                f"nothing was found at {self.vary} = {value:g}: {breakdown(error)}; start the "
                "span elsewhere"
            ) from None

    def _response(
        self, model: Model, value: float, other: float
    ) -> tuple[ForcedOrbits, OrbitPoint]:
        """Return the response of period 1."""
        orbits = forced_orbits(model, self.vary, abs(other - value), self.settings)
        implicitly = self.settings.discretization != "shooting"
        orbits, correction = find_response(
            orbits, value, implicitly=implicitly, on_progress=self.report
        )
        if correction.converged:
            row = hold_parameter(orbits.size) * np.sign(other - value)
            correction = correct(orbits, correction.z, row)
        if not correction.converged:
            raise InputError(
                f"no response of period 1 was found at {orbits.vary} = {value:g}: "
                f"{correction.failure}; "
                + (model.advice or "give a start near one, or start the span elsewhere")
            )
        return orbits, _first_point(orbits, correction, value)

    def _sticking(self, value: float) -> Begin | None:
        """Return the orbit that sticks with which a branch begins, None if none is found.

        Where there are no orbits in slip either, it is said why there is none that sticks.
        """
        if not self.model.forced or not contacts_of(self.model):
            return None
        try:
            orbit = periodic_orbit(self.model)
        except InputError:
            if may_slip(self.model):
                return None
            raise
        return Begin(value, orbit) if isinstance(orbit, StickSlipOrbit) else None


def span_begin(vary: str, first: float) -> End:
    """Say that a branch begins where the span does."""
    return End("span", f"the span begins at {vary} = {first:g}", (first,))


def equilibrium_start(
    model: Model, vary: str, first: float, last: float, near: Array | None = None
) -> tuple[Equilibria, OrbitPoint]:
    """Return the equilibrium of an autonomous model at the first value of a span.

    Shapes: near (n,).
    """
    near = model.start if near is None else near
    state = search_equilibrium(model, near)
    if state is None:
        raise InputError(
            f"no equilibrium of {model.name} was found at {vary} = {first:g}, from the state "
            f"{near.tolist()} or around it; "
            + (model.advice or "give a start nearer to one, or start the span elsewhere")
        )
    width = {vary: abs(last - first)}
    unpaced = Equilibria(model, width)
    z = unpaced.join(state[None], first)
    rates = unpaced.linearize(z).jacobian / unpaced.unit(z)
    orbits = Equilibria(model.replace(duration=unit_of_time(rates[:, :-1], rates[:, -1])), width)
    row = hold_parameter(orbits.size) * np.sign(last - first)
    correction = correct(orbits, orbits.join(state[None], first), row)
    if not correction.converged:
        raise InputError(
            f"no equilibrium of {model.name} was found at {vary} = {first:g}: "
            f"{correction.failure}; "
            + (model.advice or "give another start, or start the span elsewhere")
        )
    assert correction.bordered is not None  # it converged
    matrix = correction.bordered.matrix
    if np.linalg.cond(_equilibrated(matrix)) > WORST:
        raise InputError(
            f"the span cannot start at {vary} = {first:g}: the equilibrium there is at a fold or "
            f"branch point; {model.advice or 'start the span near it'}"
        )
    return orbits, _first_point(orbits, correction, first)


def parent_start(orbits: Orbits, z: Array) -> tuple[Orbits, OrbitPoint]:
    """Return the equilibrium or the orbit of half the period on which a branch closes at an orbit.

    It is regular there: what begins is of another kind, or of twice the period.
    """
    value = orbits.value(z)
    if rests_at(orbits, z):
        model, near = orbits.model.replace(**{orbits.vary: value}), orbits.evenly(z).mean(axis=0)
        return equilibrium_start(model, orbits.vary, value, value + orbits.width, near)
    half, z = half_orbit(orbits, z)
    correction = correct(half, z, hold_parameter(len(z) - 1))
    if not correction.converged or correction.distance > CLOSING.near_origin:
        raise InputError(correction.failure or "another orbit was found, such as one at rest")
    return half, _first_point(half, correction, value)


def _equilibrated(matrix: Array) -> Array:
    """Return a matrix whose rows and columns have largest entries near one."""
    for axis in (1, 0, 1):
        sizes = np.abs(matrix).max(axis=axis, keepdims=True)
        matrix = matrix / np.where(sizes > 0, sizes, 1.0)
    return matrix


def _from_orbit(
    orbit: PeriodicOrbit, vary: str, first: float, last: float
) -> tuple[Orbits, OrbitPoint]:
    """Return a given orbit as the first point of a branch."""
    width, nodes = abs(last - first), orbit.nodes
    by: Cut = Shooting
    if isinstance(orbit, StickSlipOrbit):
        nodes, by = nodes[:1], SwitchedShooting
    orbits = orbits_of(orbit.model, {vary: width}, orbit.period, len(nodes), by=by)
    guess = orbits.unknown(nodes, orbit.model.replace(**{vary: first}))
    correction = correct(orbits, guess, hold_parameter(len(guess) - 1) * np.sign(last - first))
    if not correction.converged:
        raise InputError(
            f"the given orbit could not be corrected at {vary} = {first:g}: {correction.failure}; "
            "give one that is closed"
        )
    return orbits, _first_point(orbits, correction, first)


def _first_point(orbits: Orbits, correction: Correction, value: float) -> OrbitPoint:
    broken = broken_limit(orbits, correction.z)
    if broken is not None:
        raise InputError(f"the span cannot start at {orbits.vary} = {value:g}: {broken}")
    return orbits.point(correction, 0.0)


def method_for(settings: Settings, jacobian: Array) -> Cut:
    """Return how cycles are to be cut, from the derivatives of the rates a period, shape (n, n)."""
    chosen = settings.discretization
    if chosen == "collocation" or (chosen == "automatic" and is_stiff(jacobian)):
        return partial(Collocation, scheme=scheme_for(jacobian[None]))
    return Shooting


def forced_orbits(model: Model, vary: str, width: float, settings: Settings) -> ForcedOrbits:
    """Return orbits of the response, cut as they are to be followed.

    However stiff, they begin by shooting where fast vibrations do not decay: multipliers of those
    that a mesh does not resolve stay near the unit circle and make spurious bifurcations.
    """
    chosen = settings.discretization
    if chosen == "automatic" and shooting_for(model) is ModalShooting:
        return ForcedOrbits(model, {vary: width}, 1, segments_for(model), ModalShooting)
    state, constants = model.start[None], flow_of(model).constants_of(model)
    jacobian = flow_of(model).jacobians(state, np.zeros(1), constants)[0]
    if chosen == "collocation" or (chosen == "automatic" and damps_stiff(jacobian)):
        by = partial(Collocation, scheme=scheme_for(jacobian[None]))
        return ForcedOrbits(model, {vary: width}, 1, 4 * INTERVALS, by)
    return ForcedOrbits(model, {vary: width}, 1, SEGMENTS, Shooting)
