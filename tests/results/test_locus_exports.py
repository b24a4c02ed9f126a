"""The summary, the HTML, the JSON record and the spreadsheet of a bifurcation set."""

from dataclasses import replace

import pytest

from helpers.locus_diagrams import (
    doubling_locus,
    fold_locus,
    made_locus_diagram,
    torus_locus,
)
from slipfold import End
from slipfold.models.registry import model_named


@pytest.fixture(scope="module")
def diagram():
    return made_locus_diagram()


def parts_of(diagram):
    return [part.splitlines() for part in diagram.summary().split("\n\n")]


def test_summary_has_ends_and_special_points(diagram):
    (title,), (heads, *lines), *_ = parts_of(diagram)
    assert title == (
        "sliding: bifurcations for f from 11.5 to 13.5 Hz and Nd from 0 to 0.98 N; "
        "alpha = 1.04545 rad"
    )
    assert heads.split() == [
        *("LO", "type", "period", "PT", "TY", "LAB", "f", "Nd", "criticality", "coefficients")
    ]
    rows = [line.split() for line in lines]
    assert [(row[0], row[1], row[4]) for row in rows] == [
        ("1", "PD", "EP"),
        ("1", "PD", "GPD"),
        ("1", "PD", "MIN"),
        ("1", "PD", "EP"),
        ("2", "LP", "EP"),
        ("2", "LP", "EP"),
        ("3", "NS", "EP"),
        ("3", "NS", "CH"),
        ("3", "NS", "EP"),
    ]
    assert [row[5] for row in rows] == [str(label) for label in range(1, 10)]
    assert rows[1][6:8] == ["12.43620847", "0.04201532481"]
    assert " ".join(rows[1][8:]) == (
        "l2 = -0.0333333, b = 0 generalized period doubling, to loci 2, 3"
    )
    assert " ".join(rows[2][8:]) == "supercritical b = 47.0487 smallest Nd"
    assert rows[0][8:] == ["subcritical"]
    assert rows[3][8:] == ["supercritical", "limit"]
    assert rows[4][8:] == ["codimension-2"]


def test_summary_says_why_loci_begin_and_end(diagram):
    endings = parts_of(diagram)[2]
    assert endings == [
        "Locus 1 (PD of period 1, 3 points) begins at f = 11.5 Hz, Nd = 0.58 N: "
        "left the window at f = 11.5",
        "Locus 1 ends at f = 13.5 Hz, Nd = 0.29 N: spring collapsed; stay below <this> value",
        "Locus 2 (LP of period 2, 2 points, from locus 1) begins at f = 12.4362 Hz, Nd = 0.042 N: "
        "emanates at a GPD of locus 1",
        "Locus 2 ends at f = 11.5 Hz, Nd = 0.15 N: left the window at f = 11.5",
        "Locus 3 (NS of period 2, 4 points, from locus 1): the locus closed on itself",
    ]


def test_summary_lists_regions_and_what_does_not_fit(diagram):
    (_, *lines), disagreements = parts_of(diagram)[3:]
    rows = [" ".join(line.split()) for line in lines]
    assert rows == [
        "1 period 1 33.33% 12 0.1 agree 1 of 1 agree",
        "2 unknown 16.67% 13 0.1 disagree 1 of 2 agree",
        "3 none 33.33% 12.5 0.5 agree none torus 50%, period 4 50%",
    ]
    assert disagreements == [
        "Region 2 (periods 1 and 2) at f = 12 Hz, Nd = 0.1 N, started near the orbit of period 2: "
        "left the orbit; it is <not> stable",
        "Region 2 (periods 1 and 2): responses across it contradict the label; branch points "
        "whose loci are not known may divide it",
    ]


def test_summary_says_where_else_an_autonomous_model_may_have_loci():
    made = made_locus_diagram(loci=(), regions=None)
    diagram = replace(made, model=model_named("lorenz"), vary=("rho", "sigma"))
    assert "cycles that emanate from them" in diagram.summary()


@pytest.mark.parametrize("which", ["started", "stopped"])
def test_a_failure_is_marked_at_either_end(which):
    lost = End("failed", "no convergence; halve it", (12.0, 0.1))
    diagram = made_locus_diagram(loci=(doubling_locus(**{which: lost}),))
    assert diagram.failed
    rows = [line.split() for line in parts_of(diagram)[1][1:]]
    assert rows[0 if which == "started" else -1][4] == "MX"
    assert not made_locus_diagram().failed


def test_criticality_follows_the_sign_of_the_coefficient():
    assert doubling_locus().criticality == ["subcritical", None, "supercritical"]
    assert fold_locus().criticality == [None, None]
    words = torus_locus().criticality
    assert words == ["supercritical", "subcritical", "subcritical", "supercritical"]
    for locus in (doubling_locus(), torus_locus()):
        above = [word == "supercritical" for word in locus.criticality]
        below = [word == "subcritical" for word in locus.criticality]
        assert above == locus.supercritical.tolist()
        assert below == locus.subcritical.tolist()
