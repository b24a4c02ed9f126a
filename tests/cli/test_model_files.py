"""Models from files on the command line: equations, structures from matrices, friction laws."""

import csv
import json
import tomllib

import numpy as np
import pytest

import slipfold as sf
from helpers.command_line import run
from slipfold.interface.cli.reading import find_model
from slipfold.models.registry import built_in_text

DUFFING = """\
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

FRAME = """\
name = "frame"
title = "two masses and a hardening spring"
[structure]
M = "frame.npz"
K = "frame.npz"
names = "root tip"
[damping]
type = "ProportionalDamping"
beta_K = 0.004
[[elements]]
type = "CubicSpring"
at = "tip"
k3 = 40
[[forcing]]
type = "HarmonicForce"
at = "tip"
F = 0.5
"""

CASE = """\
model = "sliding"
[friction]
law = "Stribeck"
mu_s = 0.6
vs = "20 cm/s"
[parameters]
Nd = 0.1
vs = 0.3
"""

BELT = """
name = "belt"
[structure]
names = ["x"]
M = [[1.0]]
K = [[1.0]]
[[contacts]]
along = "x"
friction = { law = "Coulomb", mu_s = 1.0, mu_k = 0.5 }
load = 1
Vd = 0.2
name = "pad"
"""

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


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "my.toml"
    path.write_text(DUFFING)
    return str(path)


@pytest.fixture
def frame(tmp_path):
    np.savez(tmp_path / "frame.npz", M=np.eye(2), K=[[200, -100], [-100, 100]])
    path = tmp_path / "frame.toml"
    path.write_text(FRAME)
    return path


@pytest.fixture
def case(tmp_path):
    path = tmp_path / "case.toml"
    path.write_text(CASE)
    return path


def refused(*arguments):
    """The sentence with which a command refuses what it is given."""
    result = run(*arguments)
    assert result.exit_code == 2
    assert result.stdout == ""
    assert "Traceback" not in result.stderr
    return result.stderr


# -- equations ---------------------------------------------------------------------------------


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


@pytest.mark.parametrize("name", ["sliding", "dufing"])
def test_only_files_are_shown(name):
    assert "duffing" in refused("models", "--show", name)


def test_the_orbit_that_a_motion_settles_to_is_followed():
    # The symmetric cycle of the Lorenz system at large rho, which no Hopf point leads to.
    result = run("response", "lorenz", "--vary", "rho=350:320", "--settled", "--json", "-")
    assert result.exit_code == 0
    (branch,) = json.loads(result.stdout)["branches"]
    assert (branch["kind"], branch["special"]) == ("periodic", [])


def test_what_a_cycle_cannot_do_is_said():
    said = refused("response", "lorenz", "--vary", "rho=28:20", "--settled")
    assert "does not settle on what could be followed" in said
    assert "forcing" not in said
    said = refused("response", "lorenz", "--vary", "duration=1:2")
    assert "vary one of sigma, rho, beta" in said
    said = refused("locus", "lorenz", "--vary", "duration=1:2", "--vary", "rho=20:30")
    assert "the duration of lorenz is a result of the computation" in said


def test_which_parameters_may_be_varied_is_listed():
    (record,) = json.loads(run("models", "lorenz", "--json", "-").stdout)["models"]
    varied = {item["name"]: item["varied"] for item in record["parameters"]}
    assert varied == {"sigma": True, "rho": True, "beta": True, "duration": False}
    line = next(line for line in run("models", "lorenz").stdout.splitlines() if "duration" in line)
    assert line.endswith("; cannot be varied")


def test_maps_are_not_supported(tmp_path):
    (tmp_path / "henon.toml").write_text('[maps]\nx = "1 - a*x^2 + y"\n')
    said = refused("models", str(tmp_path / "henon.toml"))
    assert "maps, which are discrete in time, are not supported; give" in said


def test_arithmetic_in_files_and_options(tmp_path):
    (tmp_path / "lorenz.toml").write_text(LORENZ)
    options = ("--vary", "rho=1/2:3/2", "--set", "sigma=20/2", "--json", "-")
    found = json.loads(run("response", str(tmp_path / "lorenz.toml"), *options).stdout)
    assert found["parameters"]["beta"] == 8 / 3
    assert found["parameters"]["sigma"] == 10
    assert found["branches"][0]["special"][0]["value"] == pytest.approx(1, abs=1e-9)


# -- structures --------------------------------------------------------------------------------


def test_a_reduction_says_how_wrong_it_is_at_the_values_that_are_set(frame):
    small = (
        'G = { w = [[0, 1], [-1, 0]] }\n[reduction]\ntype = "ModalReduction"\nmodes = 1\n[damping]'
    )
    frame.write_text(FRAME.replace("[damping]", small))
    for speed in "0", "9":
        said = run("simulate", str(frame), "--periods", "1", "--set", f"w={speed}").stderr
        report = find_model(str(frame), {"w": speed}).reduction_report
        assert "2 degrees of freedom reduced to 1, band up to 0.983632 Hz" in said
        assert f"receptances by {report.receptance_error:.2g}\n" in said
    assert report.receptance_error > 1
    assert "receptances" not in run("models", str(frame)).stderr
    model = find_model(str(frame), {"w": "9"})
    assert model.replace(F=0.5).reduction_report is model.reduction_report
    assert model.replace(w=0).reduction_report.receptance_error < 1


def test_response_of_a_structure_and_its_saved_result(frame, tmp_path):
    out = tmp_path / "out.nc"
    arguments = ["--vary", "f=0.8:1.3", "--set", "F=0.6", "--out", str(out), "--json", "-"]
    result = run("response", str(frame), *arguments)
    assert result.exit_code == 0
    assert result.stderr == ""
    record = json.loads(result.stdout)
    assert record["model"] == "frame"
    assert [point["type"] for point in record["branches"][0]["special"]] == ["LP", "LP"]
    # What was saved is the structure with its matrices: it continues from there.
    frame.unlink()
    (tmp_path / "frame.npz").unlink()
    diagram = sf.load(out)
    assert isinstance(diagram.model, sf.Structure)
    assert diagram.model.title == "two masses and a hardening spring"
    assert np.array_equal(diagram.model.stiffness_matrix, [[200, -100], [-100, 100]])
    fold = diagram.branches[0].special[0]
    assert sf.periodic_orbit(
        diagram.model.replace(f=1.0)
    ).multipliers.shape == fold.multipliers.shape  # fmt: skip
    assert run("plot", str(out)).exit_code == 0
    rows, measure = tmp_path / "level.csv", "level re 1 um"
    assert run("plot", str(out), "--measure", measure, "--out", str(rows)).exit_code == 0
    (head, first, *_), name = rows.read_text().splitlines(), diagram.model.shown[0]
    assert head == f"branch,f (Hz),level {name} (dB re 1 um),type"
    level = diagram.branches[0].orbit(0).level(name, "1 um")
    assert float(first.split(",")[2]) == pytest.approx(level, abs=1e-12)
    assert run("plot", str(out), "--measure", "max_and_min", "--out", str(rows)).exit_code == 0
    first = next(csv.DictReader(rows.read_text().splitlines()))
    extrema = diagram.branches[0].extrema_of(name)
    for part, values in (("max", extrema.maximum), ("min", extrema.minimum)):
        assert float(first[f"{part} {name} (m)"]) == values[0, 0]


# -- friction laws and contacts ----------------------------------------------------------------


def test_a_law_by_an_option():
    law = sf.Stribeck(mu_s=0.6)
    for name in ("stribeck", "Stribeck", "STRIBECK"):
        assert find_model("sliding", {"mu_s": "0.6"}, name) == sf.SlidingOscillator(friction=law)
    steady = find_model("steady-sliding", {"mu_s": "0.6"}, "stribeck")
    assert steady == sf.SlidingOscillator(friction=law).steady()
    arguments = ["--friction", "stribeck", "--set", "mu_s=0.6", "--periods", "2", "--json", "-"]
    record = json.loads(run("simulate", "sliding", *arguments).stdout)
    assert record["parameters"]["mu_s"] == 0.6
    assert "mu" not in record["parameters"]


def test_a_law_in_a_case_file(case):
    # Values among the parameters go before those of the law.
    expected = sf.SlidingOscillator(friction=sf.Stribeck(mu_s=0.6, vs=0.3), Nd=0.1)
    assert find_model(str(case), {}) == expected
    assert find_model(str(case), {"vs": "0.4"}) == expected.replace(vs=0.4)
    case.write_text(CASE.replace("vs = 0.3", ""))
    other = find_model(str(case), {"Nd": "0.2"}, "coulomb")
    assert other == sf.SlidingOscillator(friction=sf.Coulomb(), Nd=0.2)
    case.write_text(
        'model = "steady-sliding"\n[friction]\nlaw = "Regularized"\ne = 0.01\n'
        'of = { law = "RationalStribeck", d = 2 }\n'
    )
    law = sf.Regularized(sf.RationalStribeck(d=2), e=0.01)
    assert find_model(str(case), {}) == sf.SlidingOscillator(friction=law).steady()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (
            ["models", "sliding", "--friction", "stribek"],
            "= 'stribek' is unknown; did you mean Str",
        ),
        (["models", "duffing", "--friction", "dahl"], "duffing takes no friction law"),
        (["models", "--friction", "dahl"], "--friction dahl is for one model"),
        (["models", "sliding", "--friction", "regularized"], "--friction has no of; give it"),
        (["locus", "x.nc", "--friction", "dahl", "--vary", "f=1:2"], "--friction is for a model"),
        (["simulate", "sliding", "--friction", "stribeck", "--set", "mu=1"], "no parameter 'mu'"),
    ],
)
def test_laws_that_cannot_be(arguments, words, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "x.nc").write_bytes(b"")
    assert words in refused(*arguments)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('"Stribeck"', '"Stribek"', "line 3, column 7: friction.law = 'Stribek' is unknown; did"),
        ("[friction]", "[fraction]", "has no entry 'fraction'; did you"),
        ('"sliding"', '"duffing"', "duffing takes no friction law"),
    ],
)
def test_errors_of_laws_in_a_case_file(old, new, words, case):
    case.write_text(CASE.replace(old, new, 1))
    assert words in refused("simulate", str(case), "--periods", "1")
