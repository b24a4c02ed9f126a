"""Systems of equations on the command line: files, built-in ones, and what is wrong with them."""

import json
import tomllib

import pytest

from helpers.command_line import run
from slipfold.models.registry import built_in_text

TEXT = """\
name = "Duffing"
[parameters]
W = { value = 0.9, unit = "rad/s", min = 0, doc = "forcing frequency" }
F = 0.18
[states]                      # name = its rate
q = "v"
v = "F*cos(W*t) - 0.05*v - q - 0.1*q^3"
[forcing]
period = "2*pi/W"
[outputs]
energy = "v^2/2 + q^2/2 + 0.025*q^4"
"""


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "my.toml"
    path.write_text(TEXT)
    return str(path)


def test_response_of_a_file(file):
    result = run("response", file, "--vary", "W=0.8:1.6", "--event", "energy=3", "--json", "-")
    assert result.exit_code == 0
    assert result.stderr == ""
    record = json.loads(result.stdout)
    assert record["model"] == "Duffing"
    special = record["branches"][0]["special"]
    # shared/reference/textbook.md, 2.
    folds = [point["value"] for point in special if point["type"] == "LP"]
    assert folds == pytest.approx([1.269601955546, 1.115700251771], abs=1e-9)
    assert "EVENT" in {point["type"] for point in special}


def test_models_lists_and_shows_them(file):
    listed = run("models").stdout
    assert "duffing" in listed
    assert "Lorenz system" in listed
    shown = run("models", "--show", "duffing")
    assert shown.exit_code == 0
    assert shown.stdout == built_in_text("duffing")
    assert tomllib.loads(shown.stdout)["forcing"]["period"] == "2*pi/W"
    details = run("models", file).stdout
    assert details.startswith("Duffing\n\nParameters")
    assert "forcing frequency" in details
    assert "Limits" not in details
    record = json.loads(run("models", "duffing", "--json", "-").stdout)
    assert record["models"][0]["outputs"][0]["name"] == "energy"


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("- q -", "- qq -", ["my.toml, line 7, column 28: there is no name 'qq'; did you mean q?"]),
        ("cos(", "cosinus(", ["my.toml, line 7, column 8", "no function 'cosinus'"]),
        ('"v"', "v", ["my.toml, line 6, column 5: this is not TOML"]),
        ("[states]", "[state]", ["my.toml", "which has a table [states]"]),
        ('"2*pi/W"', '"pi/W"', ["my.toml, line 7, column 5: the rate of v does not repeat"]),
        ("[forcing]\nperiod", "[formulas]\nperiod", ["my.toml, line 7", "t, the time, occurs"]),
    ],
)
def test_errors_name_file_line_and_column(old, new, words, file):
    with open(file, "w", encoding="utf-8") as stream:
        stream.write(TEXT.replace(old, new))
    result = run("response", file, "--vary", "W=0.8:1.6")
    assert result.exit_code == 2
    assert result.stdout == ""
    assert "Traceback" not in result.stderr
    for word in words:
        assert word in result.stderr


@pytest.mark.parametrize("name", ["sliding", "dufing"])
def test_only_files_are_shown(name):
    result = run("models", "--show", name)
    assert result.exit_code == 2
    assert "duffing" in result.stderr


def test_the_orbit_that_a_motion_settles_to_is_followed():
    # The symmetric cycle of the Lorenz system at large rho, which no Hopf point leads to.
    result = run("response", "lorenz", "--vary", "rho=350:320", "--settled", "--json", "-")
    assert result.exit_code == 0
    (branch,) = json.loads(result.stdout)["branches"]
    assert (branch["kind"], branch["special"]) == ("periodic", [])


def test_a_motion_that_settles_on_nothing_is_refused():
    result = run("response", "lorenz", "--vary", "rho=28:20", "--settled")
    assert result.exit_code == 2
    assert "does not settle on what could be followed" in result.stderr
    assert "forcing" not in result.stderr


def test_the_duration_of_cycles_is_not_varied():
    result = run("response", "lorenz", "--vary", "duration=1:2")
    assert result.exit_code == 2
    assert "vary one of sigma, rho, beta" in result.stderr
    result = run("locus", "lorenz", "--vary", "duration=1:2", "--vary", "rho=20:30")
    assert result.exit_code == 2
    assert "the duration of lorenz comes out of the computation" in result.stderr


def test_which_parameters_may_be_varied_is_listed():
    (record,) = json.loads(run("models", "lorenz", "--json", "-").stdout)["models"]
    varied = {item["name"]: item["varied"] for item in record["parameters"]}
    assert varied == {"sigma": True, "rho": True, "beta": True, "duration": False}
    line = next(line for line in run("models", "lorenz").stdout.splitlines() if "duration" in line)
    assert line.endswith("; cannot be varied")


def test_maps_are_not_supported(tmp_path):
    (tmp_path / "henon.toml").write_text('[maps]\nx = "1 - a*x^2 + y"\n')
    result = run("models", str(tmp_path / "henon.toml"))
    assert result.exit_code == 2
    assert "maps, which are discrete in time, are not supported; give" in result.stderr


def test_arithmetic_in_files_and_options(tmp_path):
    (tmp_path / "lorenz.toml").write_text(LORENZ)
    options = ("--vary", "rho=1/2:3/2", "--set", "sigma=20/2", "--json", "-")
    found = json.loads(run("response", str(tmp_path / "lorenz.toml"), *options).stdout)
    assert found["parameters"]["beta"] == 8 / 3
    assert found["parameters"]["sigma"] == 10
    assert found["branches"][0]["special"][0]["value"] == pytest.approx(1, abs=1e-9)


LORENZ = """
[parameters]
rho = 1
sigma = 1
beta = "8/3"
[states]
x = "sigma*(y - x)"
y = "rho*x - y - x*z"
z = "x*y - beta*z"
"""
