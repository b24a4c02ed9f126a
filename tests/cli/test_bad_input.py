"""Whatever is wrong with the input: one sentence that helps, exit status 2, nothing written."""

import importlib
import os
from functools import wraps
from pathlib import Path

import pytest

from helpers.command_line import run
from helpers.diagrams import made_diagram

RESPONSE = ["response", "sliding", "--vary", "Nd=0:0.1"]
LOCUS = ["locus", "sliding", "--vary", "f=12.4:12.6", "--vary", "Nd=0:0.1"]


def assert_refused(result, *words):
    assert result.exit_code == 2, result.output
    assert result.stdout == ""
    # One sentence; an excerpt of a file, with a mark below the place, may follow indented.
    sentence, *excerpt = result.stderr.splitlines()
    assert sentence.startswith("slipfold: ")
    assert all(line.startswith("   ") for line in excerpt)
    assert "Traceback" not in result.stderr
    assert all(word in result.stderr for word in words), result.stderr


CASES = {
    "unknown parameter": ([*RESPONSE, "--set", "alhpa=1"], "no parameter 'alhpa'", "alpha?"),
    "Vd zero": ([*RESPONSE, "--set", "Vd=0"], "at Nd = 0 the contact tip", "sticks for good"),
    "NaN": ([*RESPONSE, "--set", "mu=nan"], "mu = nan is not a finite number"),
    "half a span": (["response", "sliding", "--vary", "Nd=0"], "--vary 'Nd=0'", "--vary Nd=0:0.98"),
    "two spans": ([*RESPONSE, "--vary", "f=11:14"], "--vary is given twice; give it once"),
    "no --vary": (["response", "sliding"], "--vary", "slipfold response --help"),
    "no model": (["response", "--vary", "Nd=0:1"], "MODEL", "slipfold response --help"),
    "set and varied": ([*RESPONSE, "--set", "Nd=0.1"], "Nd is varied", "once, in --vary"),
    "set without value": ([*RESPONSE, "--set", "f"], "--set 'f'", "NAME=VALUE"),
    "set twice": ([*RESPONSE, "--set", "f=12", "--set", "f=13"], "--set gives f twice"),
    "unknown command": (["respond"], "respond", "slipfold --help"),
    "unknown option": ([*RESPONSE, "--steps", "3"], "--steps", "slipfold response --help"),
    "option without value": ([*RESPONSE, "--out"], "--out", "slipfold response --help"),
    "step no number": ([*RESPONSE, "--max-step", "big"], "--max-step big is not a finite number"),
    "step negative": ([*RESPONSE, "--max-step", "-1"], "-1"),
    "tolerance zero": ([*RESPONSE, "--tolerance", "0"], "tolerance = 0", "1e-10"),
    "points none": ([*RESPONSE, "--max-points", "0"], "--max-points 0", "at least 1"),
    "misspelled choice": (
        [*RESPONSE, "--discretization", "shoting"], "'shoting' is not known; did you mean shooting",
    ),
    "misspelled runs": (["sweep", "sliding", "--vary", "Nd=0:1", "--runs", "bth"], "mean both?"),
    "distribution of nothing": (
        ["uncertainty", "duffing", "--vary", "W=2:3", "--distribution", "D=normal:5%"], "'D'",
    ),
    "period below none": ([*RESPONSE, "--largest-period", "-1"], "--largest-period -1"),
    "event of nothing": ([*RESPONSE, "--event", "velocity=1"], "no output 'velocity'", "Vrel"),
    "event of a misspelled parameter": ([*RESPONSE, "--event", "Ndd=0.1"], "did you mean Nd?"),
    "event of a varied extremum": ([*RESPONSE, "--event", "max(Nd)=1"], "is varied", "write Nd=1"),
    "event without name": ([*RESPONSE, "--event", "=1"], "event '=1'", "MEASURE(NAME)=VALUE"),
    "simulate no periods": (["simulate", "sliding", "--periods", "0"], "--periods 0", "at least 1"),
    "paper processes": (["paper", "--out", "/dev/null/x", "--processes", "0"], "--processes 0"),
    "locus in one parameter": (["locus", "sliding", "--vary", "f=12:13"], "--vary is given once"),
    "locus in three": ([*LOCUS, "--vary", "mu=0:1"], "--vary is given 3 times; give it twice"),
    "locus, set and varied": ([*LOCUS, "--set", "f=12"], "f is varied", "give it once, in --vary"),
    "regimes without regions": ([*LOCUS, "--regimes", "60x50"], "(60, 50) needs regions"),
    "regimes on no grid": ([*LOCUS, "--regions", "--regimes", "0x9"], "--regimes 0 is not a whole"),
    "label of a model": ([*LOCUS, "--label", "2"], "--label is for a saved", "sliding is a model"),
    "event of a model": ([*LOCUS, "--event", "y=1"], "--event is for a saved", "leave it out"),
    "only of a model": ([*LOCUS, "--only"], "--only is for a saved response", "leave it out"),
    "locus of a file that is not there": (
        ["locus", "no.nc", "--vary", "f=12:13", "--vary", "Nd=0:1"], "no.nc cannot be read",
    ),
    "case file missing": (["response", "no.toml", "--vary", "Nd=0:1"], "no.toml cannot be read"),
    "study missing": (["study", "no.toml"], "give another file that holds a study"),
}  # fmt: skip


@pytest.mark.parametrize("name", CASES)
def test_bad_input(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    arguments, *words = CASES[name]
    assert_refused(run(*arguments), *words)
    assert os.listdir(tmp_path) == []


def test_bad_input_leaves_an_old_result_alone(tmp_path):
    path = tmp_path / "x.nc"
    path.write_bytes(b"old")
    assert_refused(run(*RESPONSE, "--set", "mu=-1", "--out", str(path)), "mu")
    assert path.read_bytes() == b"old"
    assert os.listdir(tmp_path) == ["x.nc"]


# -- places to write to ------------------------------------------------------------------------


PLACES = [
    (RESPONSE, "computations.response.response", ("--out", "--json", "--csv")),
    (LOCUS, "computations.loci.bifurcation_set", ("--out", "--json", "--csv")),
    (("simulate", "sliding"), "computations.long_term.simulate", ("--out", "--json")),
    (("plot", "some.nc"), "results.result.load", ("--out",)),
]


@pytest.mark.parametrize(
    ("command", "name", "option"),
    [(command, name, option) for command, name, options in PLACES for option in options],
)
def test_places_are_checked_before_computing(command, name, option, tmp_path, monkeypatch):
    module, _, function = name.rpartition(".")
    home = importlib.import_module(f"slipfold.{module}")
    monkeypatch.setattr(home, function, wraps(getattr(home, function))(pytest.fail))
    (tmp_path / "file").write_bytes(b"")
    (tmp_path / "folder.png").mkdir()
    (tmp_path / "kept.png").write_bytes(b"")
    (tmp_path / "kept.png").chmod(0o444)
    for place, words in {
        tmp_path / "folder.png": "is a folder",
        tmp_path / "none" / "x.png": "does not exist",
        tmp_path / "file" / "x.png": "does not exist",
        tmp_path / "kept.png": "is read-only; make it writable",
        tmp_path / f"{'x' * 300}.png": "file name too long",
    }.items():
        assert_refused(run(*command, option, str(place)), words)
    assert sorted(os.listdir(tmp_path)) == ["file", "folder.png", "kept.png"]


def test_one_file_for_two_outputs(tmp_path):
    path = str(tmp_path / "x")
    assert_refused(run(*RESPONSE, "--out", path, "--csv", path), "given for two outputs")


INPUTS = {
    "K.mtx": "%%MatrixMarket matrix array real general\n1 1\n4\n",
    "own.toml": 'structure = { names = "x", M = [[1]], K = "K.mtx" }\n'
    'forcing = [{ type = "HarmonicForce", at = "x" }]',
    "case.toml": 'model = "own.toml"\ncompute.what = "lyapunov"\ncases.grid.F = [1, 2]',
    "data.csv": "F [N], max x [m]\n1, 0.2\n",
}


def test_what_a_command_reads_is_not_written_over(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name, text in INPUTS.items():
        Path(name).write_text(text)
    for command, names in {
        ("locus", "own.toml", "--vary", "F=1:2", "--vary", "f=1:2"): ("own.toml", "K.mtx"),
        ("study", "case.toml"): ("case.toml", "own.toml", "K.mtx"),
        ("fit", "own.toml", "data.csv", "--fit", "F=1:2"): ("data.csv", "K.mtx"),
    }.items():
        for name in names:
            assert_refused(run(*command, "--json", name), f"{name} is read as input; give")
    assert {name: Path(name).read_text() for name in os.listdir()} == INPUTS
    assert run("simulate", "duffing", "--periods", "1", "--json", "duffing").exit_code == 0


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="there is no /dev/full")
@pytest.mark.parametrize("option", ["--out", "--json", "--csv"])
def test_full_disk(option):
    result = run("response", "sliding", "--vary", "Nd=0:0.01", option, "/dev/full")
    assert result.exit_code == 2
    assert result.stderr == (
        "slipfold: /dev/full cannot be written (no space left on device); free some space or give "
        "another place\n"
    )
    assert "sliding: Nd from 0 to 0.01 N" in result.stdout  # what was computed is not lost


def test_a_file_that_cannot_be_written_does_not_spoil_the_others(tmp_path):
    path = tmp_path / "x.csv"
    result = run(
        "response", "sliding", "--vary", "Nd=0:0.01", "--out", "/dev/full", "--csv", str(path)
    )
    assert result.exit_code == 2
    assert path.exists()


# -- files to read -----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("", "has no model"),
        ("model = 'sliding'\nparameter = 3", "has no entry 'parameter'; did you mean"),
        ("model = 'sliding'\nparameters = 3", "line 2, column 14: parameters is a number"),
        ("model = sliding", "is not TOML"),
        ("model = 'sliding'\n[parameters]\nmu = -1", "mu must be >= 0"),
        ("model = 'sliding'\n[parameters]\nf = [1, 2]", "f = [1, 2] is not a number"),
    ],
)
def test_case_file(content, words, tmp_path):
    path = tmp_path / "case.toml"
    path.write_text(content)
    assert_refused(run("response", str(path), "--vary", "Nd=0:1"), "case.toml", words)


def test_plot_of_files_that_are_no_results(tmp_path):
    text = tmp_path / "text.nc"
    text.write_text("x,y\n")
    assert_refused(run("plot", str(text)), "text.nc is not a netCDF-4 file")
    assert_refused(run("plot", str(tmp_path / "none.nc")), "none.nc cannot be read")
    assert os.listdir(tmp_path) == ["text.nc"]


def test_locus_of_a_saved_response(tmp_path):
    path = tmp_path / "x.nc"
    made_diagram().save(path)
    window = ("--vary", "f=12:13", "--vary", "Nd=0:0.5")
    known = "give one of 2 (PD of period 1), 6 (NS of period 2)"
    for arguments, words in {
        (*window, "--label", "9"): ("no special point with a locus of label 9", known),
        (*window, "--label", "1"): ("locus of label 1;", known),  # an end
        (*window, "--label", "3"): ("locus of label 3;", known),  # an event
        (*window, "--label", "PD"): ("--label PD is not a whole number",),
        (*window, "--label", "2", "--type", "PD"): ("leave out --type, --period",),
        (*window, "--set", "mu=0.3"): ("--set is for a model", "leave it out"),
        (*window, "--regions"): ("--regions is for a model", "is a saved response"),
        (*window, "--type", "HX"): ("locus of type HX;", known),
        (*window, "--type", "LP"): ("locus of type LP;", known),
        (*window, "--period", "3"): ("locus of period 3;", known),
        ("--vary", "f=13:14", "--vary", "Nd=0:0.5"): (
            "at f = 12.5 is outside the window",
            "give a window",
        ),
        (*window[:2],): ("--vary is given once",),
        (*window[:2], "--vary", "ND=0:1"): ("'ND'", "Nd?"),
    }.items():
        assert_refused(run("locus", str(path), *arguments), *words)
    made_diagram(branches=()).save(path)
    assert_refused(run("locus", str(path), *window), "x.nc has no special point")
    assert os.listdir(tmp_path) == ["x.nc"]


def test_plot_of_what_there_is_not(tmp_path):
    path = tmp_path / "x.nc"
    made_diagram().save(path)
    for arguments, word in {
        ("--output", "speed"): "no output 'speed'",
        ("--measure", "mean"): "mean",
        ("--kind", "phase"): "kind = 'phase' is unknown; give response, spectrum",
        ("--contact", "pad"): "kind = 'response' has no contact; leave it out, or give output",
        ("--out", str(tmp_path / "x.gif")): "give .png, .pdf or .svg, or .csv of a response",
        ("--out", str(tmp_path / "x.csv"), "--at", "1"): "--at is of figures only",
        ("--out", str(tmp_path / "none" / "x.png")): "does not exist",
    }.items():
        assert_refused(run("plot", str(path), *arguments), word)
    assert os.listdir(tmp_path) == ["x.nc"]
