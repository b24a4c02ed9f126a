"""Where the model ends, where users want to stop, and where they interrupt."""

import math

import numpy as np
import pytest

import slipfold as sf
from slipfold import Event, InputError, Newton, Settings, SlidingOscillator, Steps
from slipfold.bifurcations.branches.response import trace_response

SINGLE = Settings(largest_period=1)
STEPS = [0.01, 0.05, 0.5]


def single(model, vary, span, largest=0.5, **options):
    settings = Settings(steps=Steps(largest=largest), largest_period=1)
    (branch,) = trace_response(model, vary, span, settings=settings, **options)
    return branch


def lowest(branch, name):
    return branch.extrema.of(name)[0]


@pytest.mark.parametrize("largest", STEPS)
def test_spring_collapse(largest):
    branch = single(SlidingOscillator(f=12.5), "Nd", (0, 0.98), largest)
    assert branch.stopped.kind == "limit"
    assert "spring collapsed" in branch.stopped.reason
    assert branch.stopped.value == pytest.approx(0.375947313, abs=3e-8)
    assert branch.stopped.value == branch.parameter[-1]
    # l/L is about to be singular: the limit itself is met to a few digits.
    assert lowest(branch, "l")[-1] == pytest.approx(1e-4, rel=1e-3)
    assert np.all(lowest(branch, "l")[:-1] > 1e-4)


@pytest.mark.parametrize("largest", STEPS)
@pytest.mark.parametrize(
    ("values", "expected"),
    [({"f": 9.0, "Nd": 0.5}, 0.02645086), ({"f": 12.5, "Nd": 0.1}, 0.02480015)],
)
def test_stick(values, expected, largest):
    branch = single(SlidingOscillator(**values), "Vd", (1.0, 0.02), largest)
    assert branch.stopped.kind == "limit"
    assert "stick" in branch.stopped.reason
    assert branch.stopped.value == pytest.approx(expected, abs=1e-8)
    assert lowest(branch, "Vrel_ratio")[-1] == pytest.approx(0.01, rel=1e-5)
    assert np.all(lowest(branch, "Vrel_ratio")[:-1] > 0.01)


@pytest.mark.parametrize("largest", STEPS)
@pytest.mark.parametrize(("vary", "span"), [("Ns", (1.0, 0.3)), ("Nd", (0.0, 1.5))])
def test_lost_contact(vary, span, largest):
    model = SlidingOscillator(f=9.0, Nd=0.5) if vary == "Ns" else SlidingOscillator(f=9.0)
    branch = single(model, vary, span, largest)
    assert branch.stopped.kind == "limit"
    assert "lost contact" in branch.stopped.reason
    assert branch.stopped.value == pytest.approx(0.5 if vary == "Ns" else 1.0, abs=3e-9)
    assert lowest(branch, "N")[-1] >= 0


# -- events ----------------------------------------------------------------------------------

WATCHED = (
    Event("y", 0.3),
    Event("y", -0.2, "min"),
    Event("x", 0.3, "peak_to_peak"),
    Event("Nd", 0.123, "parameter"),
    Event("Vrel", 0.5, "min"),
)


@pytest.mark.parametrize("largest", [0.05, 0.5])
def test_events_are_located(largest):
    settings = Settings(steps=Steps(largest=largest))
    model = SlidingOscillator(f=12.2)
    branches = trace_response(model, "Nd", (0, 0.6), settings=settings, events=WATCHED)
    for branch in branches:
        for event in WATCHED:
            found = [item for item in branch.special if item.name.startswith(prefix(event))]
            for item in found:
                assert item.type == "EVENT"
                assert item.criticality is None
                assert item.coefficient is None
                assert measured(item, event) == pytest.approx(event.value, abs=1e-8)
            # As many as the values on the branch say.
            values = np.array([measured(branch.orbit(i), event) for i in range(len(branch))])
            assert len(found) == np.count_nonzero(np.diff(values > event.value))


def prefix(event):
    return f"{event.measure} {event.name} ="


def measured(orbit, event):
    if event.measure == "parameter":
        return orbit.model.values[event.name]
    low, high = getattr(orbit, "orbit", orbit).extrema.of(event.name)
    return {"max": high, "min": low, "peak_to_peak": high - low}[event.measure][0]


def test_events_do_not_depend_on_the_step():
    runs = [
        single(SlidingOscillator(f=12.5), "Nd", (0, 0.3), largest, events=WATCHED)
        for largest in (0.03, 0.1, 0.5)
    ]
    assert len(runs[0].special) >= 5
    for run in runs[1:]:
        for one, other in zip(runs[0].special, run.special, strict=True):
            known = one.uncertainty + other.uncertainty
            assert 0 < known < 1e-9
            assert abs(one.value - other.value) <= known


def test_a_stopping_event_ends_the_branch_there():
    event = Event("y", 0.3, stop=True)
    branch = single(SlidingOscillator(f=12.5), "Nd", (0, 0.3), events=(event,))
    assert branch.stopped.kind == "event"
    assert "y" in branch.stopped.reason
    assert "0.3" in branch.stopped.reason
    assert branch.special[-1].type == "EVENT"
    assert branch.stopped.value == branch.special[-1].value
    assert branch.parameter[-1] == pytest.approx(branch.stopped.value, abs=1e-12)
    assert branch.extrema.of("y")[1][-1] == pytest.approx(0.3, abs=1e-9)


# -- interruption ----------------------------------------------------------------------------


def interrupting(branch, points):
    def observe(progress):
        if progress.values["branch"] == branch and progress.values["points"] >= points:
            raise KeyboardInterrupt

    return observe


def test_interruption_keeps_the_running_branch():
    branches = trace_response(
        SlidingOscillator(f=12.5), "Nd", (0, 0.98), observer=interrupting(1, 6)
    )
    assert len(branches) == 1
    assert branches[0].stopped.kind == "interrupted"
    assert len(branches[0]) >= 6


def test_observer_sees_every_point_and_find():
    seen = []
    (branch,) = trace_response(
        SlidingOscillator(f=12.5), "Nd", (0, 0.2), settings=SINGLE, observer=seen.append
    )
    seen = [item for item in seen if item.stage == "branches"]
    assert [item.values["points"] for item in seen] == list(range(2, len(branch) + 1))
    assert [item.values["parameter"] for item in seen] == pytest.approx(branch.parameter[1:], abs=0)
    assert seen[-1].values["special"] == ("PD",)
    assert {(item.values["branch"], item.values["period"]) for item in seen} == {(1, 1)}


# -- bad input -------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("vary", "span", "message"),
    [
        ("nd", (0, 0.5), "no parameter 'nd'; did you mean Nd"),
        ("Nd", (0.3, 0.3), "span of Nd from 0.3 to 0.3 is empty"),
        ("Nd", (math.nan, 0.3), "Nd = nan is not a finite number"),
        ("Nd", (0.0, math.inf), "Nd = inf is not a finite number"),
        ("Nd", (-0.1, 0.3), "Nd = -0.1 is outside its bounds"),
        ("Vd", (-0.1, 0.3), "Vd = -0.1 is outside its bounds"),
    ],
)
def test_bad_spans(vary, span, message):
    with pytest.raises(InputError, match=message):
        trace_response(SlidingOscillator(), vary, span)


@pytest.mark.parametrize(
    ("event", "message"),
    [
        (Event("z", 1.0), "no output 'z' for an event; there are x, y"),
        (
            Event("f", 1.0, "parameter"),
            "event on parameter 'f' cannot occur; the response varies Nd",
        ),
    ],
)
def test_bad_events(event, message):
    with pytest.raises(InputError, match=message):
        trace_response(SlidingOscillator(), "Nd", (0, 0.5), events=(event,))


def test_bad_settings():
    with pytest.raises(InputError, match="mean"):
        Event("x", 1.0, "mean")
    with pytest.raises(InputError, match="largest step"):
        Steps(largest=-1)
    with pytest.raises(InputError, match="Newton tolerance"):
        Newton(tolerance=0.5)


def test_no_orbit_at_the_start():
    with pytest.raises(InputError, match="sliding reverse or stick where the span of f begins"):
        trace_response(SlidingOscillator(Nd=0.5, Vd=0.01), "f", (11, 14))


def test_a_text_is_no_event():
    with pytest.raises(InputError, match="'x=1' is not an event"):
        sf.response(SlidingOscillator(), vary="Nd", span=(0, 0.1), events="x=1")
