"""Orbits and solutions as plain data: in time, with spectra, contacts and exponents."""

from __future__ import annotations

import math
from collections import OrderedDict
from collections.abc import Hashable
from contextlib import suppress
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from slipfold.computations.long_term import lyapunov, simulate
from slipfold.errors import InputError
from slipfold.flow.contact_trajectory import ContactPhase
from slipfold.flow.equilibrium import with_duration
from slipfold.flow.flow import flow_of
from slipfold.flow.modes import Status, contacts_of
from slipfold.flow.simulate import initial_state
from slipfold.flow.trajectory import LastRound, Trajectory, last_periods, last_round
from slipfold.interface.explorer.mechanism import mechanism_of
from slipfold.interface.explorer.messages import (
    MOST_PERIODS,
    ExponentsRequest,
    OrbitThrough,
    SimulationRequest,
    SolutionRequest,
    TrajectoryRequest,
)
from slipfold.interface.explorer.plain import Check, Emit, now_and_then, number, short
from slipfold.interface.explorer.settings import PAGE
from slipfold.long_term.contacts import ContactRounds, find_contacts
from slipfold.long_term.spectrum import Spectrum, find_spectrum
from slipfold.models.angles import REVOLUTION, distances
from slipfold.models.model import Model, evaluation_of
from slipfold.models.quantities import DURATION
from slipfold.orbits.eigenvalues import eigenvalues_of
from slipfold.orbits.find import ORBIT, periodic_orbit, shortest_period
from slipfold.orbits.periodic_orbit import PeriodicOrbit
from slipfold.progress import Progress
from slipfold.results.simulation import Simulation
from slipfold.text import stability_word


def start_of(model: Model, request: TrajectoryRequest) -> dict[str, float]:
    """Return the starting state with its perturbation."""
    state = model.start if request.start == "rest" else initial_state(model, request.start)
    initial_state(model, request.perturbation)  # refuses unknown states
    return {
        item.name: float(value) + request.perturbation.get(item.name, 0.0)
        for item, value in zip(model.states, state, strict=True)
    }


def timed(model: Model, request: TrajectoryRequest) -> Model:
    """Return a model whose periods are forcing periods, or intervals that suit its solution."""
    if model.forced:
        return model
    if isinstance(request, SolutionRequest) and request.interval is not None:
        return model.replace(**{DURATION.name: request.interval})
    return with_duration(model, initial_state(model, start_of(model, request)), None)[0]


def run_of(model: Model, request: SolutionRequest) -> tuple[Model, int | None]:
    """Return a model and the periods that a solution takes; None until it is steady."""
    if not model.forced and contacts_of(model) and request.interval is None:
        return model, None
    return timed(model, request), request.periods


class ShownOrbit(NamedTuple):
    """An orbit as a script finds it."""

    orbit: PeriodicOrbit
    through: OrbitThrough  # from where
    again: bool = True  # whether it is found from there
    rounds: int = 1  # of a cycle: those of the one that doubled, which it is near


def orbit_at(model: Model, vary: str, place: OrbitThrough) -> PeriodicOrbit:
    """Return the orbit that a script finds from a place."""
    there = model.replace(**{vary: place.value})
    return periodic_orbit(there, place.period or 1, place.state, duration=place.duration)


def found_again(model: Model, orbit: PeriodicOrbit, vary: str) -> ShownOrbit:
    """Return an orbit of a branch as a script finds it, or itself where none does.

    The other way of Newton's method leads to another rounding of the same orbit. At limits of a
    model, where branches end, there may be no other way. A doubled branch begins at a shorter one.
    """
    rests, period = jacobian_of(orbit) is not None, 1
    if model.forced and orbit.period > 1:
        each = len(orbit.nodes)  # samples are as many from each of them
        states = orbit.sample(each * orbit.period)[1][::each]
        period = shortest_period(model, orbit.period, states)
    names = [state.name for state in model.states]
    place = OrbitThrough(
        value=orbit.model.values[vary],
        state=dict(zip(names, orbit.state.tolist(), strict=True)),
        period=None if rests else period,
        duration=None if rests or model.forced else orbit.duration,
    )
    rounds = 1 if model.forced else orbit.period
    if rests:
        return ShownOrbit(orbit, place)
    with suppress(InputError):
        found = orbit_at(model, vary, place)
        if distances(orbit.model, found.state, orbit.state) < ORBIT.same:
            return ShownOrbit(found, place, rounds=rounds)
    return ShownOrbit(orbit, place, again=False)


def orbit_view(shown: ShownOrbit, vary: str) -> dict[str, Any]:
    """Return an orbit as plain data."""
    orbit, rounds = shown.orbit, shown.rounds
    model, jacobian = orbit.model, jacobian_of(orbit)
    time, values = orbit.outputs(min(4 * PAGE.samples * rounds * orbit.period, PAGE.max_samples))
    time = np.append(time, orbit.duration)
    end = values[:1].copy()
    turned = [REVOLUTION * orbit.revolutions.get(state.name, 0) for state in model.states]
    end[0, : len(turned)] += turned
    columns = finite_columns(model, np.concatenate([values, end]))
    names = [state.name for state in model.states]
    return {
        "t": short(time),
        "states": {name: columns[name] for name in names},
        "outputs": {name: column for name, column in columns.items() if name not in names},
        "spectrum": spectrum_view(
            find_spectrum(orbit, per_period=rounds * PAGE.samples), rounds * PAGE.orders
        ),
        "multipliers": _pairs(orbit.multipliers),
        "eigenvalues": None if jacobian is None else _pairs(eigenvalues_of(jacobian)),
        "stability": stability_word(orbit.multipliers, cycle=jacobian is None and not model.forced),
        "period": rounds * orbit.period,
        "value": number(model.values[vary]),
        "through": shown.through.model_dump(),
        "again": shown.again,
        "mechanism": mechanism_of(model),
    }


def finite_columns(
    model: Model, values: NDArray[np.float64], names: tuple[str, ...] = ()
) -> dict[str, list[float]]:
    """Return outputs that have a value everywhere by name, of all or of some.

    Shapes: values (m, n_outputs).
    """
    flow = flow_of(model)
    columns = {name: values[:, flow.output_index(name)] for name in names or flow.output_names}
    return {name: short(column) for name, column in columns.items() if np.isfinite(column).all()}


def jacobian_of(orbit: PeriodicOrbit) -> NDArray[np.float64] | None:
    """Return the Jacobian of an equilibrium, which has no period; None of an orbit that moves."""
    if orbit.model.forced or (orbit.nodes != orbit.state).any():
        return None
    return evaluation_of(orbit.model).jacobian(orbit.model, orbit.state)


def _pairs(values: NDArray[np.complex128]) -> list[list[float]]:
    return [[float(item.real), float(item.imag)] for item in values]


def spectrum_view(spectrum: Spectrum, orders: float, names: tuple[str, ...] = ()) -> dict[str, Any]:
    """Return amplitudes up to a multiple of the forcing frequency, of all outputs or of some."""
    seen = spectrum.order <= orders
    return {
        "frequency": short(spectrum.frequency[seen]),
        "amplitude": finite_columns(spectrum.model, spectrum.amplitude[seen], names),
    }


Kept = OrderedDict[Hashable, Any]
"""What was computed last, by model and subject."""


def keep(kept: Kept, key: Hashable, made: Any) -> Any:
    """Keep what was computed as the newest of a few, and return it."""
    kept[key] = made
    kept.move_to_end(key)
    if len(kept) > PAGE.kept:
        kept.popitem(last=False)
    return made


def solution_of(
    model: Model, request: SolutionRequest, emit: Emit, check: Check, kept: Kept
) -> Simulation:
    """Return the solution that a request is about, integrated once; send how far it is."""

    def note(now: Progress) -> dict[str, Any]:
        if now.stage == "checks":
            return {"far": "the whole motion"}
        return {"far": f"{now.done} of {now.total} periods" if model.forced else now.text}

    known, start = kept.get(key := (model, request.subject())), start_of(model, request)
    if known is None:
        watch = now_and_then(emit, check, note)
        known = simulate(*run_of(model, request), start, on_progress=watch)
    result: Simulation = keep(kept, key, known)
    return result


def send_simulation(
    model: Model, request: SimulationRequest, emit: Emit, check: Check, kept: Kept
) -> None:
    """Integrate a solution; send how far it is, and at its end what is drawn of it."""
    result = solution_of(model, request, emit, check, kept)
    # Apart, so that a page draws one and hears its reader before it draws the other.
    ended = result.settlement.settled or result.stopped is not None
    longer = None if ended else _advised(result)
    sections = _sections(result, check)
    emit({"sections": sections, **_classification(result), "longer": longer, "done": False})
    emit({"contacts": contacts_view(result), "done": True})


def _advised(trajectory: Trajectory) -> int | None:
    """Return how many periods to add: those that its verdict names, else ten times as many.

    None if requests may not be so long.
    """
    more = trajectory.settlement.more
    if more is None:
        advised = min(10 * trajectory.periods, MOST_PERIODS)
        return advised if advised > trajectory.periods else None
    forced = trajectory.model.forced
    return min(math.ceil(more if forced else more / trajectory.forcing_period), MOST_PERIODS)


def _sections(trajectory: Trajectory, check: Check) -> dict[str, Any] | None:
    """Return extrema of outputs over equal times; None if there is no period.

    Outputs that are undefined somewhere are left out, such as slip over the speed of a wall.
    """
    count, names = trajectory.periods, flow_of(trajectory.model).output_names
    if count == 0:
        return None
    width = -(-count // PAGE.columns)
    samples = max(PAGE.samples // width, PAGE.least_samples)
    pieces = []
    for first in range(0, count, PAGE.piece * width):
        check()
        last = min(first + PAGE.piece * width, count)
        values = trajectory.sampled(first, last, samples)[1].outputs()
        begins = np.arange(0, len(values), width * samples)
        pieces.append([extreme.reduceat(values, begins) for extreme in (np.minimum, np.maximum)])
    low, high = map(np.concatenate, zip(*pieces, strict=True))
    known = [i for i in range(len(names)) if np.isfinite(low[:, i] + high[:, i]).all()]
    return {
        "count": len(low),
        "periods": width,
        "duration": width * trajectory.forcing_period,
        "max": {names[i]: short(high[:, i]) for i in known},
        "min": {names[i]: short(low[:, i]) for i in known},
    }


def _classification(trajectory: Trajectory) -> dict[str, Any]:
    judged, stop = trajectory.settlement, trajectory.stopped
    last = zip(trajectory.model.states, trajectory.states[-1].tolist(), strict=True)
    return {
        # In full, so that what goes on from here is one motion; none goes on from a limit.
        "last": {item.name: value for item, value in last} if stop is None else None,
        "verdict": judged.message if stop is None else stop.reason,
        "settled": judged.settled,
        "period": judged.period,
        "duration": judged.duration,
    }


WORDS = {Status.STICK: "stick", Status.FORTH: "forth", Status.BACK: "back", Status.OPEN: "open"}


def contacts_view(trajectory: Trajectory) -> dict[str, Any] | None:
    """Return what contacts do in the last rounds; None if there are none, or no round."""
    if not contacts_of(trajectory.model) or trajectory.periods == 0:
        return None
    try:
        contacts = find_contacts(trajectory, per_period=2 * PAGE.samples)
    except InputError:
        return None
    model, flow = contacts.model, flow_of(trajectory.model)
    length = contacts.contacts[0].end
    count = max(round(length), 1)
    each = min(4 * PAGE.samples, PAGE.max_samples // count)
    values = trajectory.steady_outputs(count, each)
    last = values[:1] if contacts.repeats else values[-1:]
    values = np.concatenate([values, last])
    columns = finite_columns(trajectory.model, values)
    names = [state.name for state in model.states]
    period = flow.constants_of(model).period
    return {
        "t": short(np.linspace(0.0, length * period, len(values))),
        "states": {name: columns[name] for name in names},
        "outputs": {name: column for name, column in columns.items() if name not in names},
        "period": count,
        "mechanism": mechanism_of(model),
        "contacts": [
            {
                "name": contact.name,
                "plate": contact.pieces[0].plate[0].tolist(),
                "units": list(contacts.units),
                "pieces": [_contact_piece(contacts, piece) for piece in contact.pieces],
            }
            for contact in contacts.contacts
        ],
        "words": _words(trajectory, last_round(trajectory)),
    }


def _contact_piece(contacts: ContactRounds, piece: ContactPhase) -> dict[str, Any]:
    known = not np.isnan(piece.displacement).any()
    return {
        "state": WORDS[piece.status],
        "t": (contacts.unit * piece.phase).tolist(),
        "slip": [short(column) for column in piece.slip.T],
        "friction": [short(column) for column in piece.friction.T],
        "displacement": [short(column) for column in piece.displacement.T] if known else None,
    }


def _words(trajectory: Trajectory, last: LastRound | None) -> str:
    """Return in a sentence what contacts do in the last round."""
    if last is None:
        return ""
    if last.stuck and trajectory.sticking is not None:
        return "It is stuck: all contacts stick all the time."
    seconds = last_periods(trajectory) * trajectory.forcing_period
    repeats = trajectory.model.forced or trajectory.settlement.duration is not None
    end = "period" if repeats else f"{seconds:.3g}\u202fs"
    if not last.sticking:
        return f"It always slips in its last {end}."
    counts = {item.contact: 0 for item in last.sticking}
    for item in last.sticking:
        counts[item.contact] += 1
    times = {1: "once", 2: "twice"}
    text = " and ".join(
        f"{name} sticks {times.get(count, f'{count} times')}" for name, count in counts.items()
    )
    fraction = f"{100 * last.fraction:.3g}\u202f% of the time"
    return f"In its last {end} {text}, {fraction}."


def send_exponents(model: Model, request: ExponentsRequest, send: Emit, check: Check) -> None:
    """Compute the exponents of a solution and send progress; None is minus infinity."""

    def note(progress: Progress) -> dict[str, Any]:
        # Of an autonomous model they are per interval, which means nothing to the reader.
        known = map(number, progress.values["exponents"] if model.forced else ())
        return {"periods": progress.done, "total": progress.total, "exponents": list(known)}

    watch = now_and_then(send, check, note)
    start = start_of(model, request)
    result = lyapunov(model, state=start, tolerance=PAGE.exponent_tolerance, on_progress=watch)
    classification = result.classification
    send(
        {
            "kind_of_motion": classification.kind,
            "period": classification.period,
            "message": classification.message,
            "exponents": [number(value) for value in result.exponents],
            "errors": [number(value) for value in result.errors],
            "per": result.per,
            "dimension": result.dimension,
            "done": True,
        }
    )
