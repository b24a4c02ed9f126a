"""Structures from matrices on the command line: their files, and what becomes of them."""

import json

import numpy as np
import pytest

import slipfold as sf
from helpers.command_line import run

TEXT = """\
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


@pytest.fixture
def file(tmp_path):
    np.savez(tmp_path / "frame.npz", M=np.eye(2), K=[[200, -100], [-100, 100]])
    path = tmp_path / "frame.toml"
    path.write_text(TEXT)
    return path


def test_response_of_a_structure_and_its_saved_result(file, tmp_path):
    out = tmp_path / "out.nc"
    arguments = ["--vary", "f=0.8:1.3", "--set", "F=0.6", "--out", str(out), "--json", "-"]
    result = run("response", str(file), *arguments)
    assert result.exit_code == 0
    assert result.stderr == ""
    record = json.loads(result.stdout)
    assert record["model"] == "frame"
    assert [point["type"] for point in record["branches"][0]["special"]] == ["LP", "LP"]
    # What was saved is the structure with its matrices: it goes on from there.
    file.unlink()
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


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('"frame.npz"', '"other.npz"', "frame.toml, line 4, column 5: "),
        ('"frame.npz"', '"../frame.npz"', "leads out of the folder of this file"),
        ("k3 = 40", 'k3 = "400 N"', "frame.toml, line 13, column 6: k3 = '400 N' has the unit"),
        ("[structure]", "[structures]", "which has a table [structure]"),
        ("[structure]", "[structure", "line 3, column 11: this is not TOML"),
        ("[[forcing]]", "[states]\nq = 1\n[[forcing]]", "a system has no entry 'structure'"),
    ],
)
def test_errors_end_with_status_2(old, new, words, file):
    file.write_text(TEXT.replace(old, new, 1))
    result = run("response", str(file), "--vary", "f=0.8:1.3")
    assert result.exit_code == 2
    assert result.stdout == ""
    assert "Traceback" not in result.stderr
    assert words in result.stderr
