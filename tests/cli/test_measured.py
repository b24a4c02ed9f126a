"""Measured responses on the command line: a test stand, a fit, a plan, and figures of them."""

import json

import pytest

from helpers.command_line import run

DUFFING = ("--set", "d=0.06", "--set", "F=0.2")


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    """Measurements of Duffing's oscillator in both directions."""
    path = tmp_path_factory.mktemp("data") / "data.csv"
    done = run(
        "measure", "duffing", "--vary", "W=0.9:1.35", "--points", "10", "--quantity", "max q",
        "--sweep", "both", "--error", "1e-3", *DUFFING, "--csv", str(path),
    )  # fmt: skip
    assert done.exit_code == 0
    return path


def test_what_a_test_stand_reads_a_fit_explains(data, tmp_path):
    assert "W [rad/s],max q [1],error of max q [1],sweep" in data.read_text()
    saved = tmp_path / "fit.nc"
    done = run(
        "fit", "duffing", str(data), "--fit", "d=0.02:0.2", "--set", "F=0.2",
        "--json", "-", "--out", str(saved),
    )  # fmt: skip
    assert done.exit_code == 0
    found = json.loads(done.stdout)
    assert found["schema"] == "slipfold.fit/1"
    (item,) = found["fitted"]
    assert abs(item["value"] - 0.06) < 4 * item["error"]
    assert run("plot", str(saved)).exit_code == 0
    assert saved.with_suffix(".png").stat().st_size > 5000


def test_a_stand_that_comes_to_a_limit_keeps_its_readings(tmp_path):
    model, path = tmp_path / "floor.toml", tmp_path / "floor.csv"
    model.write_text(
        'name = "floor"\nparameters = {F = 1.0, W = 2.0}\n'
        'states = {x = "v", v = "F*cos(W*t) - x - 0.1*v"}\nforcing = {period = "2*pi/W"}\n'
        'outputs = {room = "x + 1"}\nlimits = {floor = {output = "room", bound = 0.0}}\n'
    )
    given = ("measure", str(model), "--points", "3", "--quantity", "max x")
    done = run(*given, "--vary", "F=1:5", "--csv", str(path))
    assert done.exit_code == 3
    assert "stopped early: the trajectory ends at " in done.stderr
    assert "1 of 3 measurements are kept" in done.stderr
    lines = path.read_text().splitlines()
    assert lines[2].startswith("# stopped early: the trajectory ends at ")
    assert lines[4].startswith("1.0,")
    assert len(lines) == 5
    assert run(*given, "--vary", "F=4:6", "--csv", str(path)).exit_code == 2


def test_measurements_are_drawn_with_a_response(data, tmp_path):
    saved = tmp_path / "response.nc"
    run("response", "duffing", "--vary", "W=0.9:1.35", *DUFFING, "--out", str(saved))
    done = run("plot", str(saved), "--measured", str(data), "--out", str(tmp_path / "with.svg"))
    assert done.exit_code == 0
    drawn = (tmp_path / "with.svg").read_text()
    assert "measured, upward" in drawn
    assert "measured, downward" in drawn
    other = tmp_path / "other.nc"
    run("response", "duffing", "--vary", "F=0.1:0.2", "--out", str(other))
    done = run("plot", str(other), "--measured", str(data))
    assert done.exit_code == 2
    assert "W was varied in the measurement but the diagram is over F" in done.stderr


def test_a_plan_says_which_readings_tell_most():
    done = run(
        "plan", "duffing", "--vary", "W=0.8:1.4", "--points", "9", "--quantity", "max q",
        "--fit", "d", "--fit", "k", "--error", "1e-3", "--best", "3",
    )  # fmt: skip
    assert done.exit_code == 0
    assert "max q at 3 values of W" in done.stdout
    assert "best at W = " in done.stdout


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["fit", "duffing", "none.csv", "--fit", "d=0:1"], "none.csv cannot be read"),
        (["fit", "duffing", "DATA", "--fit", "d"], "--fit 'd' is not of the form NAME=FIRST:LAST"),
        (["fit", "duffing", "DATA", "--fit", "d=0:1", "--fit", "d=0:1"], "--fit gives d twice"),
        (["fit", "duffing", "DATA", "--fit", "W=0.5:2"], "W was varied in the measurement"),
        (["measure", "duffing", "--vary", "W=1:2", "--quantity", "q"], "what is measured"),
        (["measure", "duffing", "--vary", "W=1:2", "--quantity", "max", "q"], "spaces in quotes"),
        (["plan", "duffing", "--vary", "W=1:2", "--quantity", "max q", "--fit", "d"], "'--error'"),
    ],
)  # fmt: skip
def test_what_is_wrong_is_one_sentence(data, arguments, words):
    done = run(*[str(data) if each == "DATA" else each for each in arguments])
    assert done.exit_code == 2
    assert words in done.stderr
    assert done.stderr.count("\n") == 1
