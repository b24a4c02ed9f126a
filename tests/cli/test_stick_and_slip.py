"""The command line on motions that stick and slip."""

import json

import pytest

from helpers.command_line import run

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


def test_simulate_says_when_contacts_stick(tmp_path):
    path = tmp_path / "belt.toml"
    path.write_text(
        """
        [structure]
        M = [[1]]
        K = [[1]]
        names = "x"
        [[contacts]]
        along = "x"
        friction = { law = "Coulomb", mu_s = 1.0, mu_k = 0.5 }
        load = 1.0
        Vd = 0.2
        name = "belt"
        """
    )
    found = json.loads(run("simulate", str(path), "--json", "-").stdout)
    assert found["regime"] == "stick-slip"
    assert found["period"] == 1
    assert found["duration"] == pytest.approx(8.902605407815, abs=1e-10)
    assert found["stick"]["fraction"] == pytest.approx(5 / 8.902605407815, abs=1e-10)
    assert found["stick"]["count"] == 1
    (time,) = found["stick"]["intervals"]
    assert time["contact"] == "belt"
    assert time["to"] - time["from"] == pytest.approx(5, abs=1e-10)
    assert found["extrema"]["x"][1] == pytest.approx(1.038516480713, abs=1e-10)


def test_plots_of_contacts(tmp_path):
    case, path = tmp_path / "belt.toml", tmp_path / "motion.nc"
    case.write_text(BELT)
    assert run("simulate", str(case), "--out", str(path)).exit_code == 0
    for kind in ("hysteresis", "friction", "timeline"):
        figure = tmp_path / f"{kind}.png"
        chosen = ("--kind", kind, "--contact", "pad", "--out", str(figure))
        assert run("plot", str(path), *chosen).exit_code == 0
        assert figure.read_bytes().startswith(b"\x89PNG")
    for options, words in {
        ("--kind", "path"): "pad slides along a line",
        ("--kind", "timeline", "--contact", "pat"): "did you mean pad?",
        ("--contact", "pad"): "has no contact; it goes with kind = 'hysteresis'",
        ("--kind", "timeline", "--output", "x"): "has no output; it goes with",
    }.items():
        refused = run("plot", str(path), *options)
        assert refused.exit_code == 2
        assert words in refused.stderr
