"""The summary, the HTML, the JSON record and the spreadsheet of a diagram."""

import json
import math

import numpy as np
import pytest

from helpers.diagrams import made_diagram, response_branch, special_point
from slipfold import End, InputError, SlidingOscillator, simulate
from slipfold.models.registry import model_named


@pytest.fixture(scope="module")
def diagram():
    return made_diagram()


def lines_of(diagram, *outputs):
    title, _, heads, *rest = diagram.summary(*outputs).splitlines()
    end = rest.index("")
    return title, heads.split("  "), [line.split() for line in rest[:end]], rest[end + 1 :]


def test_summary_has_ends_and_special_points(diagram):
    title, _, rows, _ = lines_of(diagram)
    assert title == "sliding: Nd from 0 to 0.1 N; alpha = 1.04545 rad"
    assert [(row[0], row[3]) for row in rows] == [
        ("1", "EP"),
        ("1", "PD"),
        ("1", "EVENT"),
        ("1", "EP"),
        ("2", "EP"),
        ("2", "NS"),
        ("2", "EVENT"),
        ("2", "EP"),
    ]
    assert [row[4] for row in rows] == [str(label) for label in range(1, 9)]
    assert rows[1][5] == "0.04357891149"
    assert rows[0][10] == "yes"
    assert rows[3][10] == "no"
    assert " ".join(rows[1][10:]) == "supercritical, to branch 2"


def test_summary_shows_extrema_of_the_outputs_asked_for(diagram):
    rows = lines_of(diagram, ["Vrel"])[2]
    extrema = diagram.branches[0].extrema.of("Vrel")
    assert float(rows[3][6]) == pytest.approx(extrema[1][-1], rel=1e-5)
    assert float(rows[3][7]) == pytest.approx(extrema[0][-1], rel=1e-5)


def test_summary_says_why_branches_stop(diagram):
    endings = lines_of(diagram)[3]
    assert endings[0].startswith("Branch 1 (period 1, 3 points) stopped at Nd = 0.1 N: spring")


def test_summary_of_an_unknown_output(diagram):
    with pytest.raises(InputError, match="no output 'vrel'; did you mean Vrel"):
        diagram.summary(["vrel"])


def test_summary_marks_a_failure_as_auto_does():
    failed = response_branch(special=(), stopped=End("failed", "no convergence; halve it", 0.1))
    diagram = made_diagram(branches=(failed,))
    assert diagram.failed
    assert lines_of(diagram)[2][-1][3] == "MX"


def test_html_is_escaped(diagram):
    page = diagram._repr_html_()
    assert "stay below &lt;this&gt; value" in page
    assert "<this>" not in page
    assert page.count("<tr>") == 9


def test_record_has_no_number_that_json_cannot_hold():
    point = special_point(
        uncertainty=math.nan,
        coefficient=math.inf,
        multipliers=np.array([complex(math.nan, -math.inf), 1, 1, 1]),
    )
    branch = response_branch(special=(point,), stopped=End("failed", "lost", math.nan))
    record = made_diagram(branches=(branch,)).to_json()
    text = json.dumps(record, allow_nan=False)
    assert json.loads(text) == record
    found = record["branches"][0]["special"][0]
    assert found["uncertainty"] is None
    assert found["coefficient"] is None
    assert found["multipliers"][0] == [None, None]
    assert record["branches"][0]["stopped"]["value"] is None


def test_simulation_record_and_summary():
    # Amplitudes from shared/reference/sliding.json.
    motion = simulate(SlidingOscillator(), 1500, f=12.2, Nd="150mN")
    record = motion.to_json()
    assert record["schema"] == "slipfold.simulation/1"
    assert (record["settled"], record["period"]) == (True, 2)
    assert record["initial_state"] == [0, 0, 0, 0]
    assert record["spectrum"]["frequency"][:3] == pytest.approx([0, 6.1, 12.2])
    assert record["spectrum"]["amplitude"]["x"][:4] == pytest.approx(
        [0.1153731745, 0.2763272675, 0.0389868653, 0.0129595018], rel=1e-6
    )
    assert json.loads(json.dumps(record, allow_nan=False)) == record
    assert "Settled on a response of 2 forcing periods" in motion.summary()
    assert "0.27632727" in motion.summary()


def test_simulation_that_has_not_settled_shows_no_amplitudes():
    motion = simulate(SlidingOscillator(), 20, f=12.2, Nd=0.15)
    record = motion.to_json()
    assert record["settled"] is False
    assert record["spectrum"] is None
    assert "not settled" in motion.summary().lower()


def test_tables_of_a_simulation_have_a_column_a_state():
    motion = simulate(model_named("duffing"), 3)
    assert motion.to_xarray().states.dims == ("sample", "state")
    assert motion.to_dataframe().columns.tolist() == ["time", "q", "v"]
