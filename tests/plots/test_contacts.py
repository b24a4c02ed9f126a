"""Friction loops, paths and timelines of motions that stick and slip, against what is known."""

import math

import numpy as np
import pytest
from matplotlib.colors import to_hex
from matplotlib.figure import Figure

import slipfold as sf
from helpers.dry_friction import belt, den_hartog, sliding, two_masses
from slipfold import InputError
from slipfold.flow.modes import Status
from slipfold.long_term.contacts import find_contacts
from slipfold.plots import (
    draw_friction_force,
    draw_hysteresis,
    draw_path,
    draw_timeline,
)
from slipfold.plots.contacts import BANDS, THICK


@pytest.fixture(scope="module")
def carried():
    """A mass on a belt: Fs = 1, Fk = 0.5, v = 0.2."""
    return sf.simulate(belt(sf.Coulomb(mu_s=1.0, mu_k=0.5)))


@pytest.fixture(scope="module")
def planar():
    return sf.simulate(sliding(0.9, 0.02), 120)


def thick(ax):
    """What is drawn where contacts stick: x and y."""
    found = [line for line in ax.get_lines() if line.get_linewidth() == THICK]
    return [np.asarray(line.get_data()) for line in found]


def area(x, y):
    """Signed area inside a closed curve, by the trapezoidal rule."""
    return float(np.sum(0.5 * (y[1:] + y[:-1]) * np.diff(x)))


@pytest.mark.parametrize(
    ("units", "labels"),
    [(("", ""), ("displacement", "friction force")),
     (("m", "m/s"), ("displacement (mm)", "friction force (N)"))],
)  # fmt: skip
def test_equations_as_text_are_drawn_in_the_units_of_their_states(units, labels, ax):
    text = sf.System(
        parameters={"Vd": 0.02},
        states={
            "x": {"rate": "v", "unit": units[0]},
            "v": {"rate": "F - 100*x", "unit": units[1]},
        },
        contacts={
            "F": {"slip": "Vd - v", "normal": "1.0",
                  "friction": {"law": "Coulomb", "mu_s": 1.0, "mu_k": 0.5}},
        },
    )  # fmt: skip
    draw_hysteresis(sf.simulate(text), ax=ax)
    assert (ax.get_xlabel(), ax.get_ylabel()) == labels
    (x, _) = thick(ax)[0]
    assert max(x) == pytest.approx(10.0 if units[0] else 0.01, abs=1e-9)


def test_where_a_mass_sticks_the_belt_drags_it_along_its_spring(carried, ax):
    assert draw_hysteresis(carried, ax=ax) is ax
    x, force = np.concatenate(thick(ax), axis=1)
    assert force == pytest.approx(x, abs=1e-12)  # k = 1
    assert (x.min(), x.max()) == pytest.approx((0.0, 1.0), abs=1e-12)
    assert ax.get_xlabel() == "displacement (m)"
    assert ax.get_ylabel() == "friction force (N)"
    assert [text.get_text() for text in ax.get_legend().get_texts()] == ["sticks"]


def test_friction_over_slip_is_the_law_with_a_bar_at_rest(carried, ax):
    draw_friction_force(carried, ax=ax)
    slip, force = np.concatenate(thick(ax), axis=1)
    assert set(slip) == {0.0}
    assert (force.min(), force.max()) == pytest.approx((0.0, 1.0), abs=1e-12)
    found = find_contacts(carried).contacts[0].pieces
    slips = [piece for piece in found if piece.status is Status.FORTH]
    assert all(piece.friction == pytest.approx(0.5, abs=1e-12) for piece in slips)
    # x - k x_k oscillates freely: sqrt(D^2 + v^2) beyond the speed of the belt.
    largest = max(piece.slip.max() for piece in slips)
    assert largest == pytest.approx(0.2 + math.hypot(0.5, 0.2), rel=1e-3)


def test_the_loop_has_the_work_that_the_history_tells_as_its_area():
    short, long = (sf.simulate(den_hartog(0.6, 0.7), count) for count in (119, 120))
    work = sum(item.work for item in long.sticking.intervals)
    work -= sum(item.work for item in short.sticking.intervals)
    pieces = find_contacts(long).contacts[0].pieces
    areas = [area(piece.displacement[:, 0], piece.friction[:, 0]) for piece in pieces]
    assert sum(areas) == pytest.approx(work, rel=1e-9)
    assert work == pytest.approx(-4 * 0.7 * 1.351930925995, rel=1e-11)  # by closed form


def test_pieces_meet_and_are_the_times_of_the_history(planar):
    shown = find_contacts(planar)
    (contact,) = shown.contacts
    times = [shown.time(piece)[[0, -1]] for piece in contact.pieces]
    assert [ends[1] for ends in times[:-1]] == [ends[0] for ends in times[1:]]
    (stuck,) = planar.last_round.sticking
    sticks = [item for item, piece in zip(times, contact.pieces, strict=True)
              if piece.status is Status.STICK]  # fmt: skip
    assert sum(end - begin for begin, end in sticks) == pytest.approx(stuck.end - stuck.begin)
    assert sticks[-1][0] - shown.begin == pytest.approx(stuck.begin, abs=1e-9)


def test_path_is_straight_along_the_plate_where_the_tip_sticks(planar, ax):
    draw_path(planar, ax=ax)
    for x, y in thick(ax):
        assert np.diff(y) == pytest.approx(math.sqrt(3) * np.diff(x), rel=1e-6)
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("x (mm)", "y (mm)")
    assert ax.get_aspect() == 1


def test_timeline_has_a_row_for_each_contact(ax):
    motion = sf.simulate(two_masses())
    draw_timeline(motion, ax=ax, rounds=1)
    assert [text.get_text() for text in ax.get_yticklabels()] == ["first", "second"]
    color = BANDS[Status.STICK][1]
    for row, times in enumerate([(2.72270329, 4.07266075), (1.56790351, 5.00842914)]):
        bars = [bar for bar in ax.patches if abs(bar.get_y() + bar.get_height() / 2 - row) < 0.1]
        stuck = sum(bar.get_width() for bar in bars if to_hex(bar.get_facecolor()) == color)
        assert stuck == pytest.approx(sum(times), abs=1e-7)
    assert ax.get_xlabel() == "time (s)"
    draw_timeline(motion, "second", ax=Figure().add_subplot())


@pytest.mark.parametrize(
    ("motion", "options", "words"),
    [
        ("carried", {"kind": "path"}, "along a line"),
        ("carried", {"kind": "track"}, "along a line"),
        ("carried", {"kind": "timeline", "contact": "tip"}, "no contact 'tip'"),
        ("carried", {"kind": "hysteresis", "output": "x"}, "no output"),
        ("carried", {"kind": "phase", "contact": "contact"}, "no contact"),
        ("carried", {"kind": "timeline", "rounds": 0}, "rounds = 0"),
        ("smooth", {"kind": "friction"}, "show its outputs"),
        ("carried", {"kind": "loop"}, "unknown"),
    ],
)
def test_what_there_is_no_picture_of(motion, options, words, request):
    smooth = motion == "smooth"
    found = (
        sf.simulate(sf.built_in_models()["duffing"](), 20)
        if smooth
        else request.getfixturevalue(motion)
    )
    with pytest.raises(InputError, match=words):
        found.plot(**options)
