"""Friction laws of the sliding oscillator: by an option, and in case files."""

import json

import pytest

import slipfold as sf
from helpers.command_line import run
from slipfold.cli.reading import find_model

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


@pytest.fixture
def case(tmp_path):
    path = tmp_path / "case.toml"
    path.write_text(CASE)
    return path


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
        (["locus", "x.nc", "--friction", "dahl", "--vary", "f=1:2"], "--friction dahl is for a mo"),
        (["simulate", "sliding", "--friction", "stribeck", "--set", "mu=1"], "no parameter 'mu'"),
    ],
)
def test_what_cannot_be(arguments, words, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "x.nc").write_bytes(b"")
    result = run(*arguments)
    assert result.exit_code == 2
    assert words in result.stderr
    assert "Traceback" not in result.stderr


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('"Stribeck"', '"Stribek"', "line 3, column 7: friction.law = 'Stribek' is unknown; did"),
        ("mu_s = 0.6", "mu_s = 0.1", "mu_s = 0.1 is below mu_k = 0.3"),
        ("mu_s = 0.6", "mu = 0.1", "line 4, column 1: friction has no entry 'mu'; did you mean"),
        ('"20 cm/s"', '"20 cm"', "line 5, column 6: vs = '20 cm' has the unit 'cm'"),
        ('law = "Stribeck"\n', "", "line 2, column 1: friction has no law; give one of"),
        ("[friction]", "[fraction]", "has no entry 'fraction'; did you"),
        ('"sliding"', '"duffing"', "duffing takes no friction law"),
    ],
)
def test_what_is_wrong_in_a_case_file(old, new, words, case):
    case.write_text(CASE.replace(old, new, 1))
    result = run("simulate", str(case), "--periods", "1")
    assert result.exit_code == 2
    assert words in result.stderr
