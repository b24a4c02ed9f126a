"""Commands of long-term behavior: what they print, store and draw, and what they refuse."""

import json

import numpy as np
import pytest

import slipfold as sf
from helpers.command_line import run

DUFFING = ("--set", "W=1.2", "--box", "q=-4:4", "--box", "v=-4:4")

COMMANDS = {
    "attractors": (
        ("duffing", *DUFFING, "--starts", "8"),
        lambda record: sum(item["starts"] for item in record["attractors"]) == 8,
        "period 1", "reached,q,v", 8,
    ),
    "basin-fractions": (
        ("duffing", "--vary", "W=1:1.4", *DUFFING[2:], "--points", "3", "--starts", "64"),
        lambda record: [item["value"] for item in record["attractors"]] == [1, 1.2, 1.2, 1.4],
        "W = 1 to 1.4", "W (rad/s),attractor,what,value,low,high", 4,
    ),
    "basins": (
        ("duffing", "--set", "W=1.2", "--plane", "q=-4:4", "--plane", "v=-4:4", "--points", "6x4"),
        lambda record: np.shape(record["labels"]) == (4, 6),
        "6 x 4 starts: q -4 to 4, v -4 to 4", "q,v,reached,uncertain", 24,
    ),
    "sweep": (
        ("sliding", "--vary", "Nd=0.06:0.16", "--set", "f=12.2", "--points", "3", "--starts", "0",
         "--transient", "200"),
        lambda record: record["repeats"][0] == [1, 1, 2],
        "", "", None,
    ),
    "regimes": (
        ("sliding", "--vary", "f=12.2:12.3", "--vary", "Nd=0:0.02", "--points", "2x2",
         "--transient", "200"),
        lambda record: record["schema"] == "slipfold.regimes/1",
        "period 1", "", None,
    ),
    "lyapunov": (
        ("duffing", "--set", "W=1.4", "--start", "v=0.1"),
        lambda record: record["initial_state"] == [0, 0.1]
        and (record["per"], record["period"]) == ("forcing period", 1)
        and len(record["exponents"]) == len(record["errors"]) == 2,
        "Settled on a response of 1 forcing period", "", None,
    ),
}  # fmt: skip
"""Of each: arguments, what its record holds, words of its summary, head and length of its table."""


@pytest.mark.parametrize("command", COMMANDS)
def test_on_the_command_line_and_back_from_a_file(command, tmp_path):
    arguments, holds, words, head, length = COMMANDS[command]
    path, sheet, figure = (str(tmp_path / name) for name in ("r.nc", "r.csv", "r.png"))
    done = run(command, *arguments, "--json", "-", "--out", path, "--csv", sheet)
    assert done.exit_code == 0, done.stderr
    record = json.loads(done.stdout)
    assert record["schema"] == f"slipfold.{command.replace('-', '_')}/1"
    assert holds(record)
    back = sf.load(path)
    assert back.to_json() == record
    assert words in back.summary()
    with open(sheet) as file:
        rows = file.read().splitlines()
    assert rows[0].startswith(head)
    assert length is None or len(rows) == length + 1
    if command in ("basin-fractions", "basins", "sweep", "regimes"):
        drawn = run("plot", path, "--out", figure)
        assert drawn.exit_code == 0, drawn.stderr


PLANE = ("--plane", "x=0:1", "--plane", "y=0:1")

REFUSED = [
    ("attractors", ("sliding", "--box", "z=0:1"), ["no state 'z'", "x, y, vx, vy"]),
    ("attractors", ("sliding", "--box", "y=0.5"), ["NAME=FIRST:LAST"]),
    ("attractors", ("sliding", "--box", "y=0.5:0.1"), ["empty"]),
    ("attractors", ("sliding", "--box", "vx=0:1kg"), ["kg"]),
    ("attractors", ("sliding", "--starts", "0"), ["--starts 0", "at least 1"]),
    ("attractors", ("sliding", "--seed", "-1"), ["--seed -1", "at least 0"]),
    ("basin-fractions", ("duffing", "--vary", "W=1:1"), ["is empty"]),
    ("basin-fractions", ("duffing", "--vary", "W=1:2", "--set", "W=1"), ["is varied"]),
    ("basin-fractions", ("duffing", "--vary", "W=1:2", "--points", "1"), ["at least 2"]),
    ("basins", ("sliding", *PLANE[:2]), ["does not name two states: it has x; give two"]),
    ("basins", ("sliding", *PLANE[:2], "--plane", "z=0:1"), ["no state 'z'"]),
    ("basins", ("sliding", *PLANE, "--points", "1"), ["at least 2"]),
    ("basins", ("sliding", *PLANE, "--start", "q=1"), ["no state 'q'"]),
    (
        "sweep",
        ("sliding", "--vary", "Nd=0:0.1", "--runs", "sideways"),
        ["give both, up, down, none"],
    ),
    ("regimes", ("sliding", "--vary", "f=12:13"), ["--vary is given once; give it twice"]),
    (
        "regimes",
        ("sliding", "--vary", "f=12:13", "--vary", "Nd=0:0.1", "--points", "x9"),
        ["--points is not a whole"],
    ),
    ("lyapunov", ("sliding", "--start", "z=1"), ["sliding has no state 'z'; it has x, y, vx, vy"]),
    ("lyapunov", ("sliding", "--periods", "0"), ["0"]),
    ("lyapunov", ("sliding", "--tolerance", "-1"), ["tolerance = -1"]),
]


@pytest.mark.parametrize(("command", "arguments", "words"), REFUSED)
def test_bad_input_is_one_sentence(command, arguments, words):
    done = run(command, *arguments)
    assert (done.exit_code, done.stdout) == (2, "")
    assert done.stderr.count("\n") == 1
    assert all(word in done.stderr for word in words)
