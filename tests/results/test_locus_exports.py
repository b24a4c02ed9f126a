"""The summary, the HTML, the JSON record and the spreadsheet of a bifurcation set."""

import csv
import json
import math
from dataclasses import replace

import numpy as np
import pytest

from helpers.locus_diagrams import (
    doubling_locus,
    fold_locus,
    locus_point,
    made_locus_diagram,
    torus_locus,
)
from slipfold.loci.locus import LocusEnd
from slipfold.models import model_named
from slipfold.results.locus_diagram import criticalities, point_criticality


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
        "l2 = -0.0333333, b = 0 generalised period doubling, to loci 2, 3"
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
        "born at a GPD of locus 1",
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
        "Region 2 (periods 1 and 2): not true all over it, as responses across it show; branch "
        "points, whose loci are not known, may divide it",
    ]


def test_summary_without_loci_and_regions():
    parts = parts_of(made_locus_diagram(loci=(), regions=None))
    assert len(parts) == 3
    assert parts[2] == ["No locus was found in this window."]


def test_summary_says_where_else_an_autonomous_model_may_have_loci():
    made = made_locus_diagram(loci=(), regions=None)
    diagram = replace(made, model=model_named("lorenz"), vary=("rho", "sigma"))
    assert "cycles born on them" in diagram.summary()


def test_summary_of_what_was_interrupted():
    diagram = made_locus_diagram(interrupted=True)
    assert "Interrupted: some of the set is missing." in diagram.summary()


@pytest.mark.parametrize("which", ["begun", "stopped"])
def test_a_failure_is_marked_at_either_end(which):
    lost = LocusEnd("failed", "no convergence; halve it", (12.0, 0.1))
    diagram = made_locus_diagram(loci=(doubling_locus(**{which: lost}),))
    assert diagram.failed
    rows = [line.split() for line in parts_of(diagram)[1][1:]]
    assert rows[0 if which == "begun" else -1][4] == "MX"
    assert not made_locus_diagram().failed


def test_html_is_escaped(diagram):
    page = diagram._repr_html_()
    assert "stay below &lt;this&gt; value" in page
    assert "it is &lt;not&gt; stable" in page
    assert "<this>" not in page
    assert page.count("<table>") == 2
    assert page.count("<tr>") == 1 + 9 + 1 + 3


def test_repr(diagram):
    assert repr(diagram) == (
        "<LocusDiagram of sliding: f = 11.5 to 13.5, Nd = 0 to 0.98, 3 loci, GPD, MIN, CH>"
    )
    assert repr(made_locus_diagram(loci=())).endswith("0 loci, no special points>")


def test_special_points_come_with_their_locus(diagram):
    found = [(locus.id, point.type) for locus, point in diagram.special]
    assert found == [(1, "GPD"), (1, "MIN"), (3, "CH")]


def test_criticality_follows_the_sign_of_the_coefficient():
    assert criticalities(doubling_locus()) == ["subcritical", None, "supercritical"]
    assert criticalities(fold_locus()) == [None, None]
    words = criticalities(torus_locus())
    assert words == ["supercritical", "subcritical", "subcritical", "supercritical"]
    for locus in (doubling_locus(), torus_locus()):
        above = [word == "supercritical" for word in criticalities(locus)]
        below = [word == "subcritical" for word in criticalities(locus)]
        assert above == locus.supercritical.tolist()
        assert below == locus.subcritical.tolist()


def test_criticality_of_a_point_is_that_of_an_extremum_alone():
    locus = doubling_locus()
    assert [point_criticality(locus, point) for point in locus.special] == [None, "supercritical"]


def test_record_follows_the_schema(diagram):
    record = diagram.to_json()
    assert list(record) == [
        *("schema", "model", "parameters", "plane", "window", "interrupted", "loci", "regions")
    ]
    assert record["schema"] == "slipfold.locus/1"
    assert record["plane"] == ["f", "Nd"]
    assert record["window"] == [[11.5, 13.5], [0, 0.98]]
    assert record["parameters"] == dict(diagram.model.values)
    first, second, third = record["loci"]
    assert list(first) == [
        *("id", "type", "kind", "period", "parent", "points", "values", "criticality"),
        *("coefficient", "durations", "eigenvalues", "special", "begun", "stopped"),
    ]
    assert (first["kind"], first["durations"], first["eigenvalues"]) == ("periodic", None, None)
    assert first["values"] == diagram.loci[0].values.tolist()
    assert first["criticality"] == ["subcritical", None, "supercritical"]
    assert first["stopped"]["values"] == [13.5, 0.29]
    assert (second["parent"], second["criticality"]) == (1, None)
    assert third["stopped"]["kind"] == "closed"
    degenerate, _ = first["special"]
    assert degenerate["type"] == "GPD"
    assert degenerate["values"] == [12.43620847, 0.04201532481]
    assert degenerate["uncertainty"] == [1e-12, 2e-13]
    assert degenerate["coefficients"] == {"l2": -0.1 / 3, "b": 0.0}
    assert degenerate["coefficient"] == -0.1 / 3
    assert degenerate["leads_to"] == [2, 3]
    assert degenerate["multipliers"][1] == [0.957, 0.019]
    assert third["special"][0]["coefficient"] is None
    region = record["regions"][1]
    assert (region["stable"], region["name"]) == ([1, 2], "unknown")
    assert (region["known"], region["consistent"]) == (False, False)
    assert region["checks"][1] == {
        "values": [12.0, 0.1],
        "start": "2",
        "settled": 0,
        "agrees": False,
        "note": "left the orbit; it is <not> stable",
    }
    assert made_locus_diagram(regions=None).to_json()["regions"] is None


def test_record_has_no_number_that_json_cannot_hold():
    point = locus_point(
        uncertainty=(math.inf, math.nan),
        coefficients={"l2": math.nan},
        multipliers=np.array([complex(math.nan, -math.inf), 1, 1, 1]),
    )
    stopped = LocusEnd("failed", "lost", (math.nan, 0.0))
    locus = doubling_locus(special=(point,), stopped=stopped)
    record = made_locus_diagram(loci=(locus,)).to_json()
    assert json.loads(json.dumps(record, allow_nan=False)) == record
    found = record["loci"][0]["special"][0]
    assert found["uncertainty"] == [None, None]
    assert found["coefficients"] == {"l2": None}
    assert record["loci"][0]["stopped"]["values"] == [None, 0]


def test_spreadsheet_holds_exact_numbers_in_order(diagram, tmp_path):
    path = tmp_path / "points.csv"
    diagram.to_csv(path)
    rows = list(csv.DictReader(path.read_text().splitlines()))
    assert len(rows) == 3 + 2 + 2 + 4 + 1
    assert [row["special"] for row in rows[:5]] == ["", "GPD", "", "MIN", ""]
    assert [row["locus"] for row in rows] == list("111112233333")
    assert float(rows[1]["Nd (N)"]) == 0.04201532481
    locus = diagram.loci[0]
    ordinary = [row for row in rows if row["locus"] == "1" and not row["special"]]
    assert [float(row["f (Hz)"]) for row in ordinary] == locus.values[:, 0].tolist()
    assert [float(row["vx (1/s)"]) for row in ordinary] == locus.states[:, 2].tolist()
    assert [row["criticality"] for row in ordinary] == ["subcritical", "", "supercritical"]
    assert [row["coefficient"] for row in ordinary] == ["-44.7", "", "92.0"]
    assert float(ordinary[1]["multiplier 2 imaginary"]) == locus.multipliers[1, 1].imag
    assert rows[1]["coefficients"] == "l2 = -0.03333333333333333; b = 0.0"
    assert rows[3]["criticality"] == "supercritical"
