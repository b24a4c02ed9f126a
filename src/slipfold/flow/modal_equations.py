"""Models as modes with a few nonlinear forces: compiled forces, and intervals they act on."""

from __future__ import annotations

import math
from collections.abc import Iterator
from functools import cached_property
from typing import TypeVar

import heyoka as hy
import numpy as np
from numpy.typing import NDArray

from slipfold.arrays import Array, Indices
from slipfold.collocation_points import CollocationPoints
from slipfold.flow.compiled_code import Evaluated, shared_by_kind
from slipfold.flow.equations import Constants, Equations, model_symbols
from slipfold.flow.flow import flow_of
from slipfold.flow.modal_answers import ModalAnswers, Some
from slipfold.flow.modes import contacts_of
from slipfold.models.formulas.values import as_symbol
from slipfold.models.modal_form import ModalForm
from slipfold.models.model import Model

Number = TypeVar("Number", bound=np.inexact)


class MODAL:
    """Bounds of rounding in modes and meshes."""

    grid: float = 2.0**-50  # difference of lengths of intervals, in forcing periods
    same: float = 1e-9  # of rows of modes that a symmetry maps onto each other, over the largest


class ModalEquations:
    """The modal form of a model, its forces compiled.

    Forces that depend on motions come first: `moved` of them.
    """

    def __init__(self, model: Model, form: ModalForm) -> None:
        symbols = model_symbols(model)
        named = {str(symbol) for symbol in form.motions}
        live = [not named.isdisjoint(hy.get_variables([force])) for force in form.forces]
        order = np.argsort(np.logical_not(live), kind="stable")
        self.squares, self.shapes, self.into = form.squares, form.shapes, form.into
        self.rows, self.inputs, self.moved = form.rows, form.inputs[:, order], sum(live)
        self.motions, self.forces = len(form.motions), len(form.forces)
        self.symmetry = form.symmetry
        names = list(symbols.coefficients)
        self._dampings = [
            (None if name is None else names.index(name), part) for name, part in form.dampings
        ]
        # Functions of as many symbols as there are forces: what is too much stays zero.
        size = max(self.motions, self.forces, 1)
        spare = [hy.expression(f"no motion {k}") for k in range(size - self.motions)]
        states = (*form.motions, *spare)
        forces = [form.forces[k] for k in order] + [hy.expression(0.0)] * (size - self.forces)
        values = [as_symbol(value) for value in symbols.values.values()]
        self._functions = Evaluated(
            Equations(
                names=tuple(str(symbol) for symbol in states),
                states=states,
                parameters=tuple(symbols.parameters.values()),
                # The last coefficient, elsewhere the period, is one: forces are those in a second.
                coefficients=(*symbols.coefficients.values(), hy.expression("one")),
                coefficient_values=(*values, hy.expression(1.0)),
                phase=symbols.phase,
                field=tuple(forces),
                outputs=(),
            )
        )
        self._size = size

    def dampings(self, constants: Constants) -> Array:
        """Return the dampings of modes in 1/s, shape (r,)."""
        values = constants.values
        parts = (part if at is None else values[at] * part for at, part in self._dampings)
        return np.asarray(sum(parts, np.zeros(len(self.squares))))

    def damping_slopes(self, along: Array) -> Array:
        """Return their derivatives along changes of coefficients, (n_c, k) to (r, k)."""
        result = np.zeros((len(self.squares), along.shape[1]))
        for at, part in self._dampings:
            if at is not None:
                result += part[:, None] * along[at]
        return result

    def order(self, turn: Array) -> tuple[Indices, Indices] | None:
        """Return the motion to which a symmetry maps each, and the force that it maps to each.

        None if it maps them to no others. Shapes: turn (r, r); returns (n_y,), (n_f,).
        """
        motions = _places(self.rows @ np.kron(np.eye(2), turn), self.rows)
        forces = _places((turn @ self.inputs).T, self.inputs.T)
        return None if motions is None or forces is None else (motions, np.argsort(forces))

    # -- forces at the points of intervals: motions (m, s, n_y), phases (m, s) -------------------

    def at(self, motions: Array, phases: Array, constants: Constants) -> Array:
        """Return the forces, shape (m, s, n_f)."""
        result = self._functions.rates(*self._given(motions, phases, constants))
        return np.asarray(result.reshape(*phases.shape, -1)[..., : self.forces])

    def slopes(self, motions: Array, phases: Array, constants: Constants) -> Array:
        """Return the derivatives by motions of the forces that have any, (m, s, n_l, n_y)."""
        result = self._functions.jacobians(*self._given(motions, phases, constants))
        result = result.reshape(*phases.shape, self._size, -1)
        return np.asarray(result[..., : self.moved, : self.motions])

    def parameter_slopes(
        self, motions: Array, phases: Array, constants: Constants, along: Array
    ) -> Array:
        """Return the derivatives along changes of coefficients, (m, s, n_f, k)."""
        given = self._given(motions, phases, constants)
        result = self._functions.parameter_slopes(*given, self._changes(along))
        return np.asarray(result.reshape(*phases.shape, self._size, -1)[..., : self.forces, :])

    def curvatures(
        self, motions: Array, phases: Array, constants: Constants, vectors: Array, along: Array
    ) -> tuple[Array, Array]:
        """Return the derivatives of slopes times vectors, (m, s, n_l, n_y) and (m, s, n_l, k).

        Shapes: vectors (m, s, n_y).
        """
        given, more = self._given(motions, phases, constants), self._changes(along)
        bent, mixed = self._functions.curvatures(*given, self._filled(vectors), more)
        bent = bent.reshape(*phases.shape, self._size, -1)[..., : self.moved, : self.motions]
        return bent, mixed.reshape(*phases.shape, self._size, -1)[..., : self.moved, :]

    def cubes(self, motions: Array, phases: Array, constants: Constants, vectors: Array) -> Array:
        """Return the third derivatives along vectors, (m, s, n_l)."""
        given = self._given(motions, phases, constants)
        third = self._functions.powers(*given, self._filled(vectors))[1]
        return third.reshape(*phases.shape, -1)[..., : self.moved]

    def _given(
        self, motions: Array, phases: Array, constants: Constants
    ) -> tuple[Array, Array, Constants]:
        values = np.append(constants.values, 1.0)
        return self._filled(motions), phases.ravel(), Constants(values, constants.scales)

    def _filled(self, motions: Array) -> Array:
        result = np.zeros((motions.shape[0] * motions.shape[1], self._size))
        result[:, : self.motions] = motions.reshape(len(result), self.motions)
        return result

    def _changes(self, along: Array) -> Array:
        return np.vstack([along, np.zeros((1, along.shape[1]))])


def _places(rows: Array, among: Array) -> Indices | None:
    """Return where each of some rows stands among the same in another order, None if not there."""
    apart = np.abs(rows[:, None] - among).max(axis=2, initial=0.0)
    nearest = apart.argmin(axis=1) if len(rows) else np.zeros(0, np.int64)
    missed = apart[np.arange(len(rows)), nearest].max(initial=0.0)
    same = missed <= MODAL.same * np.abs(among).max(initial=0.0)
    return nearest if same and len(set(nearest.tolist())) == len(rows) else None


@shared_by_kind
def modal_equations_of(model: Model) -> ModalEquations | None:
    """Return a model's equations as modes; None where it offers no such form."""
    symbols = model_symbols(model)
    form = model.modal_form(symbols.coefficients, symbols.phase)
    return None if form is None else ModalEquations(model, form)


class CHOICE:
    """From where modal shooting is quicker than the compiled flow."""

    states: int = 24  # a chain of ten masses takes three times as long, of twenty a third
    # Of the fastest mode in a period. Points of beams take 37 ms with 62 turns (5 modes), of the
    # flow 28; with 96 (a static shape more) 32 and 37; with 173 (8 modes) 32 and 83
    turns: float = 80.0


def modes_serve(model: Model) -> bool:
    """Whether motions in slip are computed by modes, so that no integrator is compiled for them."""
    slips = model.forced and not contacts_of(model)
    equations = modal_equations_of(model) if slips else None
    if equations is None:
        return False
    period = flow_of(model).constants(model.vector).period
    turns = math.sqrt(max(float(equations.squares.max()), 0.0)) * period / (2 * math.pi)
    # Where as many forces as modes follow motions, intervals resolve the fastest one: of two masses
    # 23 times the flow's time.
    fast = turns >= CHOICE.turns and equations.moved < len(equations.squares)
    return fast or len(model.states) >= CHOICE.states


class ForcedIntervals:
    """Modes and motions on m intervals, as they follow from the beginnings and from forces.

    Forces are polynomials through their values at s points. Modal states are displacements of
    modes, then their rates: n = 2 r. Intervals of one length have the same answers, which are
    computed once.

    Shapes: start, lengths (m,), in forcing periods.
    """

    def __init__(
        self,
        equations: ModalEquations,
        points: CollocationPoints,
        start: Array,
        lengths: Array,
        period: float,
        dampings: Some,
        alike: tuple[Indices, Array] | None = None,
    ) -> None:
        self.equations, self.points, self.period = equations, points, period
        self.start, self.lengths = start, lengths
        self.phases = start[:, None] + lengths[:, None] * points.points
        self.dampings = dampings
        if alike is None:
            _, which = np.unique(np.rint(lengths / MODAL.grid), return_inverse=True)
            alike = which, np.bincount(which, lengths) / np.bincount(which)
        self._alike, (self._which, different) = alike, alike
        self._answers = ModalAnswers(points, different * period, equations.squares, dampings)
        qq, qp, pq, pp = (part[self._which, :, -1] for part in self._answers.transitions)
        self._free = np.stack([qq, pp], axis=1), np.stack([qp, pq], axis=1)

    def propagated(self, states: Some) -> Some:
        """Return where states end without forces. Shapes: states (m, n, k)."""
        return propagate(self._free, states)

    def steps(self, count: int) -> Iterator[tuple[Some, Some]]:
        """Yield what propagates states without forces, for `count` groups of intervals."""
        own, other = (part.reshape(count, -1, *part.shape[1:]) for part in self._free)
        return zip(own, other, strict=True)

    @cached_property
    def seen(self) -> Some:
        """Motions at the points by states at the beginning, shape (m, s n_y, n)."""
        r = len(self.equations.squares)
        by_q, by_p = self.equations.rows[:, :r], self.equations.rows[:, r:]
        qq, qp, pq, pp = (part[:, :, :-1] for part in self._answers.transitions)
        parts = [
            np.einsum("yr,mrj->mjyr", by_q, one) + np.einsum("yr,mrj->mjyr", by_p, other)
            for one, other in ((qq, pq), (qp, pp))
        ]
        m, s, count, _ = parts[0].shape
        return np.concatenate(parts, axis=3).reshape(m, s * count, 2 * r)[self._which]

    @cached_property
    def answered(self) -> Some:
        """Motions at the points by forces there, shape (m, s n_y, s n_f)."""
        r, inputs, rows = len(self.equations.squares), self.equations.inputs, self.equations.rows
        by_q, by_p = (part[:, None] * inputs.T for part in (rows[:, :r], rows[:, r:]))
        seen, s, different = len(rows), self.phases.shape[1], len(self._answers.lengths)
        result = self._answers.motions(by_q.reshape(-1, r), by_p.reshape(-1, r))
        result = result.reshape(different, seen, inputs.shape[1], s, s).transpose(0, 3, 1, 4, 2)
        return result.reshape(different, s * seen, s * inputs.shape[1])[self._which]

    @cached_property
    def driven(self) -> Some:
        """Ends by forces at the points, shape (m, n, s n_f)."""
        inputs = self.equations.inputs
        parts = [part[..., None] * inputs[:, None] for part in self._answers.forced]
        joined = np.concatenate(parts, axis=1)
        return joined.reshape(*joined.shape[:2], -1)[self._which]

    def by_period(self, states: Some, forces: Array) -> tuple[Some, Some]:
        r"""Differentiate motions at the points, and ends, by the period in seconds.

        Beginnings and forces f at the points stay. With the place :math:`\sigma` in the interval,
        and the answers R to forces, the derivative is :math:`(\sigma x' - R(\sigma f'))/T`, and x'
        answers to f' from its own beginning.

        Shapes: states (m, n); forces (m, s, n_f); returns (m, s n_y) and (m, n).
        """
        moments, r = self._answers.moments, len(self.equations.squares)
        m, s = self.phases.shape
        first = np.einsum("k,mkf->mf", moments.begun[0], forces)
        slopes = np.einsum("jk,mkf->mjf", moments.slopes, forces)
        q, p = states[:, :r], states[:, r:]
        rates = p, first @ self.equations.inputs.T - self.equations.squares * q - self.dampings * p
        moving = np.concatenate(rates, axis=1) * (self.lengths * self.period)[:, None]
        turned = slopes * self.points.points[:, None]
        flat, bent = slopes.reshape(m, -1), turned.reshape(m, -1)
        at_points = times(self.seen, moving) + times(self.answered, flat)
        at_points = (at_points.reshape(m, s, -1) * self.points.points[:, None]).reshape(m, -1)
        ends = self.propagated(moving[..., None])[..., 0] + times(self.driven, flat)
        at_points -= times(self.answered, bent)
        return at_points / self.period, (ends - times(self.driven, bent)) / self.period

    def part(self, which: slice) -> ForcedIntervals:
        """Return some of the intervals."""
        times = self.start[which], self.lengths[which], self.period, self.dampings
        return ForcedIntervals(self.equations, self.points, *times)

    def at(self, period: float, dampings: Some) -> ForcedIntervals:
        """Return the same intervals with another period or other dampings."""
        given = self.equations, self.points, self.start, self.lengths
        return ForcedIntervals(*given, period, dampings, self._alike)


def propagate(free: tuple[Some, Some], states: Some) -> Some:
    """Return where modal states end without forces.

    Shapes: displacements by themselves and rates by themselves, then each by the other, (m, 2, r);
    states (m, n, k).
    """
    own, other = (part[..., None] for part in free)
    pairs = states.reshape(*own.shape[:3], states.shape[-1])
    result = own * pairs
    result += other * pairs[:, ::-1]
    return result.reshape(states.shape)


def times(matrices: NDArray[Number], vectors: NDArray[Number]) -> NDArray[Number]:
    """Return products of matrices and vectors. Shapes: (..., a, b), (..., b)."""
    return np.asarray((matrices @ vectors[..., None])[..., 0])
