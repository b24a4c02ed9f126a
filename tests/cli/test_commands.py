"""The commands do what they say: results, files, exit statuses."""

import csv
import importlib
import json
from functools import wraps

import pytest

from helpers.command_line import run
from helpers.diagrams import made_diagram, response_branch
from helpers.locus_diagrams import doubling_locus, made_locus_diagram
from slipfold import End, load
from slipfold.interface.cli.app import COMMANDS

LOCUS = ["locus", "sliding", "--vary", "f=12.4:12.5", "--vary", "Nd=0:60mN"]
SMALL = ["response", "sliding", "--vary", "Nd=0:0.05"]


def replace_result(monkeypatch, diagram, name="response"):
    """Let the command hand over this diagram instead of computing one."""
    home = "response" if name == "response" else "loci"
    module = importlib.import_module(f"slipfold.computations.{home}")
    monkeypatch.setattr(module, name, wraps(getattr(module, name))(lambda *_, **__: diagram))


# -- response ----------------------------------------------------------------------------------


def test_json_on_standard_output_and_nothing_else():
    result = run("response", "sliding", "--vary", "Nd=0:0.98", "--set", "f=12.5", "--json", "-")
    assert result.exit_code == 0
    assert result.stderr == ""
    record = json.loads(result.stdout)
    assert record["schema"] == "slipfold.response/1"
    assert record["parameters"]["f"] == 12.5
    # shared/reference/sliding.json.
    first, second = record["branches"]
    assert [point["type"] for point in first["special"]] == ["PD"]
    assert first["special"][0]["value"] == pytest.approx(0.043578911491, rel=1e-6)
    assert first["special"][0]["leads_to"] == 2
    assert first["stopped"]["reason"].startswith("spring collapsed")
    assert [point["value"] for point in second["special"]] == pytest.approx(
        [0.056690677223, 0.166438167073], rel=1e-6
    )


def test_all_files_of_one_response_agree(tmp_path):
    paths = {name: tmp_path / f"x.{name}" for name in ("nc", "json", "csv")}
    result = run(
        *SMALL,
        *("--out", str(paths["nc"]), "--json", str(paths["json"]), "--csv", str(paths["csv"])),
    )
    assert result.exit_code == 0
    diagram = load(paths["nc"])
    assert json.loads(paths["json"].read_text()) == diagram.to_json()
    rows = list(csv.DictReader(paths["csv"].read_text().splitlines()))
    points = sum(len(branch) + len(branch.special) for branch in diagram.branches)
    assert len(rows) == points
    assert result.stdout == diagram.summary() + "\n"


def test_settings_reach_the_computation(tmp_path):
    path = tmp_path / "x.nc"
    options = ["--max-step", "0.2", "--tolerance", "1e-9", "--max-points", "4"]
    result = run(*SMALL, *options, "--largest-period", "1", "--out", str(path))
    assert result.exit_code == 3  # four points were not enough
    diagram = load(path)
    assert diagram.settings.steps.largest == 0.2
    assert diagram.settings.steps.points == 4
    assert diagram.settings.newton.tolerance == 1e-9
    assert diagram.settings.largest_period == 1
    assert diagram.branches[0].stopped.kind == "points"


def test_events(tmp_path):
    events = ["--event", "Nd=10mN", "--event", "max(x)=0.121", "--stop-at", "min( Vrel )=0.58"]
    result = run(*SMALL, *events, "--json", "-")
    assert result.exit_code == 0
    (branch,) = json.loads(result.stdout)["branches"]
    assert [point["type"] for point in branch["special"]] == ["EVENT"] * 3
    assert branch["special"][1]["value"] == pytest.approx(0.01, abs=1e-12)
    assert branch["stopped"]["kind"] == "event"


def test_case_file(tmp_path):
    path = tmp_path / "case.toml"
    path.write_text('model = "sliding"\n[parameters]\nf = 12.2\nalpha = "30deg"\nNd = 0.01\n')
    result = run("simulate", str(path), "--periods", "20", "--set", "f=12.3", "--json", "-")
    parameters = json.loads(result.stdout)["parameters"]
    assert (parameters["f"], parameters["Nd"]) == (12.3, 0.01)
    assert parameters["alpha"] == pytest.approx(0.5235987755982988)


def test_failure_is_status_3_after_the_results_are_written(tmp_path, monkeypatch):
    lost = End("failed", "the branch was lost near Nd = 0.1; try a smaller largest step", 0.1)
    replace_result(monkeypatch, made_diagram(branches=(response_branch(stopped=lost),)))
    path = tmp_path / "x.nc"
    result = run(*SMALL, "--out", str(path), "--json", "-")
    assert result.exit_code == 3
    assert result.stderr == f"slipfold: branch 1 stopped early: {lost.reason}\n"
    assert json.loads(result.stdout)["branches"][0]["stopped"]["kind"] == "failed"
    assert load(path).failed


def test_interruption_is_status_130_after_the_results_are_written(tmp_path, monkeypatch):
    stopped = End("interrupted", "interrupted at Nd = 0.1; results up to there are kept", 0.1)
    replace_result(monkeypatch, made_diagram(branches=(response_branch(stopped=stopped),)))
    path = tmp_path / "x.nc"
    result = run(*SMALL, "--out", str(path))
    assert result.exit_code == 130
    assert result.stderr == (
        f"slipfold: interrupted after 3 points on 1 curve; finished results are in {path}\n"
    )
    assert load(path).interrupted


# -- locus -------------------------------------------------------------------------------------


def test_locus_as_json_on_standard_output_and_nothing_else(few_lines):
    result = run(*LOCUS, "--type", "pd", "--period", "1", "--json", "-")
    assert result.exit_code == 0
    assert result.stderr == ""
    record = json.loads(result.stdout)
    assert record["schema"] == "slipfold.locus/1"
    assert record["plane"] == ["f", "Nd"]
    assert record["window"] == [[12.4, 12.5], [0, 0.06]]
    assert record["regions"] is None
    (locus,) = record["loci"]
    assert (locus["type"], locus["period"]) == ("PD", 1)
    assert {point["type"] for point in locus["special"]} == {"GPD", "MIN"}
    # shared/reference/sliding.json, force response at 12.5 Hz.
    ends = dict(end["values"] for end in (locus["started"], locus["stopped"]))
    assert ends[12.5] == pytest.approx(0.043578911491, rel=1e-8)


@pytest.fixture(scope="module")
def saved_response(tmp_path_factory):
    path = tmp_path_factory.mktemp("response") / "x.nc"
    result = run(*SMALL, "--set", "f=12.5", "--event", "x=0.121", "--out", str(path))
    assert result.exit_code == 0
    return str(path)


WINDOW = ("--vary", "f=12.45:12.55", "--vary", "Nd=60mN:0")


def test_locus_of_a_saved_response_as_json(saved_response):
    result = run("locus", saved_response, *WINDOW, "--json", "-")
    assert result.exit_code == 0
    assert result.stderr == ""
    record = json.loads(result.stdout)
    assert record["schema"] == "slipfold.locus/1"
    assert record["window"] == [[12.45, 12.55], [0, 0.06]]
    first = record["loci"][0]
    assert (first["type"], first["period"]) == ("PD", 1)
    gaps = [abs(f - 12.5) + abs(Nd - 0.043578911491) for f, Nd in first["values"]]
    assert min(gaps) < 1e-9  # shared/reference/sliding.json


def test_labels_are_those_of_the_printed_table(saved_response, tmp_path, monkeypatch):
    asked = {}
    module = importlib.import_module("slipfold.computations.loci")
    monkeypatch.setattr(
        module,
        "locus",
        lambda points, *_, switch, **__: (
            asked.update(p=points, switch=switch) or made_locus_diagram()
        ),
    )
    lines = load(saved_response).summary().splitlines()
    (label,) = [line.split()[4] for line in lines if line.split()[3:4] == ["PD"]]
    assert run("locus", saved_response, *WINDOW, "--label", label).exit_code == 0
    assert ([point.type for point in asked["p"]], asked["switch"]) == (["PD"], True)
    assert run("locus", saved_response, *WINDOW, "--label", label, "--only").exit_code == 0
    assert ([point.type for point in asked["p"]], asked["switch"]) == (["PD"], False)
    path = str(tmp_path / "x.nc")
    made_diagram().save(path)
    wide = ("--vary", "f=12:13", "--vary", "Nd=0:0.5")
    for options, expected in {
        (): [("PD", 1), ("NS", 2)],
        ("--type", "ns"): [("NS", 2)],
        ("--period", "1"): [("PD", 1)],
    }.items():
        assert run("locus", path, *wide, *options).exit_code == 0
        assert [(point.type, point.period) for point in asked["p"]] == expected


@pytest.mark.parametrize(
    ("changes", "status"),
    [
        ({}, 0),
        ({"loci": (doubling_locus(stopped=End("failed", "lost", (12, 1))),)}, 3),
        ({"interrupted": True}, 130),
    ],
)
def test_status_of_loci_of_a_saved_response(changes, status, saved_response, monkeypatch):
    replace_result(monkeypatch, made_locus_diagram(**changes), "locus")
    assert run("locus", saved_response, *WINDOW).exit_code == status


# -- the other commands ------------------------------------------------------------------------


def test_simulate(tmp_path):
    path = tmp_path / "x.nc"
    result = run(
        *("simulate", "sliding", "--periods", "1500", "--set", "f=12.2", "--set", "Nd=0.15"),
        *("--state", "y=0.01", "--out", str(path), "--json", "-"),
    )
    assert result.exit_code == 0
    assert result.stderr == ""
    record = json.loads(result.stdout)
    assert (record["settled"], record["period"]) == (True, 2)
    assert record["initial_state"] == [0, 0.01, 0, 0]
    assert load(path).to_json() == record


def test_simulation_that_meets_a_limit_says_so():
    result = run("simulate", "sliding", "--state", "y=-0.99995")
    assert result.exit_code == 0
    assert result.stderr.startswith("slipfold: stopped early: spring collapsed")


def test_models_as_json(tmp_path):
    result = run("models", "--json", "-")
    record = json.loads(result.stdout)
    assert record["schema"] == "slipfold.models/1"
    (model,) = [item for item in record["models"] if item["name"] == "sliding"]
    parameters = {item["name"]: item for item in model["parameters"]}
    assert parameters["Vd"]["unit"] == "m/s"
    assert parameters["alpha"]["lower"] is None
    path = tmp_path / "models.json"
    assert run("models", "--json", str(path)).exit_code == 0
    assert json.loads(path.read_text()) == record


@pytest.mark.parametrize(
    ("name", "magic"), [("x.png", b"\x89PNG"), ("x.pdf", b"%PDF"), ("x.svg", b"<?xml")]
)
def test_plot_of_a_response(name, magic, tmp_path):
    made_diagram().save(tmp_path / "x.nc")
    path = tmp_path / name
    result = run(
        *("plot", str(tmp_path / "x.nc"), "--out", str(path)),
        *("--output", "y", "--measure", "peak_to_peak"),
    )
    assert result.exit_code == 0
    assert result.stdout == ""
    assert path.read_bytes().startswith(magic)


@pytest.mark.parametrize("kind", ["timeseries", "spectrum", "phase"])
def test_plot_of_a_simulation_goes_beside_it_by_default(kind, tmp_path):
    path = tmp_path / "motion.nc"
    assert run("simulate", "sliding", "--periods", "80", "--out", str(path)).exit_code == 0
    result = run("plot", str(path), "--kind", kind)
    assert result.exit_code == 0
    assert (tmp_path / "motion.png").read_bytes().startswith(b"\x89PNG")


def test_ridge_of_a_peak(tmp_path):
    path = str(tmp_path / "peak.nc")
    peak = ("--set", "F=0.05", "--event", "max(q)", "--out", path)
    assert run("response", "duffing", "--vary", "W=0.8:1.4", *peak).exit_code == 0
    window = ("--vary", "W=0.8:1.4", "--vary", "F=0.02:0.1")
    result = run("locus", path, *window, "--type", "MAX", "--event", "F=0.04")
    assert result.exit_code == 0
    assert "max q" in result.stdout.splitlines()[2]
    (at,) = (line for line in result.stdout.splitlines() if "EVENT" in line)
    assert at.endswith("parameter F = 0.04")


@pytest.mark.parametrize(
    ("command", "kind"),
    [
        (["backbone", "duffing", "--output", "q", "--up-to", "1"], []),
        (["response", "squeal", "--vary", "mu=0.1:0.2"], ["--kind", "eigenvalues"]),
    ],
)
def test_plot_of_two_axes(command, kind, tmp_path):
    path = tmp_path / "two.nc"
    assert run(*command, "--out", str(path)).exit_code == 0
    assert run("plot", str(path), *kind).exit_code == 0
    assert (tmp_path / "two.png").read_bytes().startswith(b"\x89PNG")


# -- the whole ---------------------------------------------------------------------------------


@pytest.mark.parametrize("command", COMMANDS)
def test_help_of_each_command(command):
    result = run(command, "--help")
    assert result.exit_code == 0
    assert result.stdout.startswith(f"Usage: slipfold {command}")
    fails = ("backbone", "design", "locus", "measure", "paper", "response", "simulate")
    assert ("input, 3 " in " ".join(result.stdout.split())) == (command in fails)


def test_a_branch_beyond_which_no_orbit_was_found_is_status_3(tmp_path):
    path = tmp_path / "caught.toml"
    path.write_text("""name = "pushed"
parameters = {P = 0.0}
states = {x = "v", v = "F - x - 0.1*v + P*cos(t)"}
forcing = {period = "2*pi", amplitude = "P"}
[contacts.F]
slip = "0.3 - v"
normal = 1.0
friction = {law = "Coulomb", mu_s = 0.6, mu_k = 0.4}
""")
    result = run("response", str(path), "--vary", "P=0:0.1")
    assert result.exit_code == 3, result.output
    assert "no orbit was found beyond" in result.stderr
