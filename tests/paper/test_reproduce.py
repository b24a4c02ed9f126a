import csv
import errno
import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import slipfold as sf
from slipfold import InputError, writing
from slipfold.interface.paper import reproduce
from slipfold.interface.paper.cases import read_cases
from slipfold.interface.paper.tables import COLUMNS

CASES = read_cases()


@pytest.fixture(scope="module")
def reduced(tmp_path_factory):
    """Figure 5 alone, with what the observer saw."""
    seen = []
    out = tmp_path_factory.mktemp("paper") / "new" / "folder"
    return reproduce(out, seen.append, cases=CASES.only([5])), seen


def table(folder):
    with open(folder / "thresholds.csv", newline="") as file:
        return list(csv.DictReader(file))


def test_files(reduced):
    made, _ = reduced
    found = sorted(
        str(path.relative_to(made.out)) for path in made.out.rglob("*") if path.is_file()
    )
    data = ["data/Nd_Ns0.6_Vd1.nc", "data/Nd_Ns0.8_Vd1.nc", "data/Nd_Vd1.nc"]
    assert found == ["claims.md", *data, "figure5.pdf", "figure5.png", "thresholds.csv"]
    assert sorted(str(path.relative_to(made.out)) for path in made.written) == found
    assert not made.interrupted
    assert made.stopped == ()
    assert made.message == f"7 files are in {made.out}; 1 of 10 claims are confirmed"


def test_figures_are_fit_to_print(reduced):
    folder = reduced[0].out
    with Image.open(folder / "figure5.png") as image:
        assert image.info["dpi"] == pytest.approx((300, 300), abs=0.1)
        assert image.width == 2070
        assert np.asarray(image.convert("L")).std() > 10
    content = (folder / "figure5.pdf").read_bytes()
    assert content.startswith(b"%PDF")
    assert b"/Type42" not in content
    assert b"/CIDFontType2" in content or b"/TrueType" in content  # text, not outlines
    assert b"/Type3" not in content


def test_thresholds_read_back_exactly(reduced):
    folder = reduced[0].out
    rows = table(folder)
    assert tuple(rows[0]) == COLUMNS
    diagram = sf.load(folder / "data" / "Nd_Ns0.6_Vd1.nc")
    mine = [row for row in rows if row["curve"] == "Nd_Ns0.6_Vd1"]
    assert len(mine) == len(diagram.special)
    for row, (branch, point) in zip(mine, diagram.special, strict=True):
        assert row["figures"] == "5"
        assert (row["type"], int(row["branch"])) == (point.type, branch.id)
        assert float(row["value"]) == point.value == float(row["Nd"])
        assert (float(row["Ns"]), float(row["Vd"]), float(row["f"])) == (0.6, 1.0, 12.5)
        assert [float(row[name]) for name in ("x", "y", "vx", "vy")] == list(point.state)
        assert row["criticality"] == (point.criticality or "")
        if point.critical_multiplier is not None:
            multiplier = complex(float(row["multiplier_real"]), float(row["multiplier_imag"]))
            assert multiplier == point.critical_multiplier
            assert abs(multiplier) == pytest.approx(1, abs=1e-8)


def test_thresholds_are_those_of_the_reference(reduced):
    # shared/reference/sliding.json: f = 12.5 Hz, Vd = 1 m/s, Ns = 0.6 N
    mine = [row for row in table(reduced[0].out) if row["curve"] == "Nd_Ns0.6_Vd1"]
    values = [(row["type"], float(row["value"])) for row in mine if row["type"] in ("PD", "NS")]
    assert [kind for kind, _ in values] == ["PD", "NS", "NS"]
    assert [value for _, value in values] == pytest.approx(
        [0.023841926, 0.024379814, 0.48450314], rel=1e-6
    )


def test_claims_that_can_be_judged_are(reduced):
    made, _ = reduced
    verdicts = [claim.verdict for claim in made.claims]
    assert verdicts == [None] * 7 + [True] + [None] * 2
    assert "not computed" in (made.out / "claims.md").read_text()


def stop_after(count):
    def observe(progress):
        if progress.done == count:
            raise KeyboardInterrupt

    return observe


@pytest.mark.parametrize("processes", [1, pytest.param(2, marks=pytest.mark.long)])
def test_interrupt_keeps_what_is_finished(tmp_path, processes):
    made = reproduce(tmp_path, stop_after(1), processes=processes, cases=CASES.only([4]))
    assert made.interrupted
    kept = sorted(path.stem for path in (tmp_path / "data").iterdir())
    assert {row["curve"] for row in table(tmp_path)} == set(kept)
    assert len(kept) == 1
    assert sorted([*made.missing, *kept]) == [
        "Nd_Vd0.4",
        "Nd_Vd0.8",
        "Nd_Vd1",
        "Nd_base",
        "figure4",
    ]
    assert made.message.startswith("interrupted: ")
    assert all(name in made.message for name in made.missing)
    assert not list(tmp_path.rglob("*.part"))


def test_a_folder_that_cannot_be_made(tmp_path):
    (tmp_path / "taken").write_text("")
    with pytest.raises(InputError, match=r"taken.* cannot be made .*give another one"):
        reproduce(tmp_path / "taken")


def test_a_full_disk_is_noticed_before_anything_is_computed(tmp_path, monkeypatch):
    def full(*_):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(writing.os, "fsync", full)
    with pytest.raises(InputError, match="no space left"):
        reproduce(tmp_path)
    assert not [path for path in tmp_path.rglob("*") if path.is_file()]


SCRIPT = """
import json, sys
from slipfold.interface.paper import reproduce
if __name__ == "__main__":
    made = reproduce(sys.argv[1], lambda _: print("one", flush=True), processes=2)
    print(json.dumps([made.interrupted, len(made.written), list(made.missing)]))
"""


@pytest.mark.long
@pytest.mark.skipif(sys.platform == "win32", reason="signals")
def test_ctrl_c_in_the_terminal(tmp_path):
    script = tmp_path / "script.py"
    script.write_text(SCRIPT)
    process = subprocess.Popen(
        [sys.executable, str(script), str(tmp_path / "out")],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    )
    for _ in range(4):
        assert process.stdout.readline() == "one\n"
    os.killpg(process.pid, signal.SIGINT)  # as the terminal does: to all processes of the group
    output, errors = process.communicate(timeout=60)
    assert errors == ""
    interrupted, written, missing = json.loads(output.splitlines()[-1])
    assert interrupted
    assert written >= 4
    assert "figure7" in missing
    # Besides the data: figures, thresholds.csv, claims.md, bifurcation_sets.md.
    figures = [path for path in (tmp_path / "out").iterdir() if path.suffix in (".pdf", ".png")]
    assert len(list((tmp_path / "out" / "data").iterdir())) == written - 3 - len(figures)


@pytest.mark.long
def test_the_whole_paper(tmp_path):
    made = reproduce(tmp_path, processes=2)
    assert made.stopped == made.missing == ()
    assert [claim.verdict for claim in made.claims] == [True] * 10
    figures = sorted(path.name for path in tmp_path.glob("figure*"))
    assert figures == [f"figure{n}.{kind}" for n in range(2, 8) for kind in ("pdf", "png")]
    sets = sorted(path.name for path in tmp_path.glob("bifurcation_set_*"))
    names = ("Ns", "Vd", "alpha", "f", "mu")
    assert sets == [f"bifurcation_set_{n}_Nd.{kind}" for n in names for kind in ("pdf", "png")]
    assert (tmp_path / "bifurcation_sets.md").read_text().count("Not computed") == 0
    assert len(list((tmp_path / "data").iterdir())) == 22 + 5
    reference = json.loads((Path(__file__).parent / "reference.json").read_text())
    rows = table(tmp_path)
    for curve, special in reference.items():
        mine = [
            (row["type"], float(row["value"]))
            for row in rows
            if row["curve"] == curve and row["type"] in ("PD", "NS", "LP", "BP")
        ]
        assert [kind for kind, _ in mine] == [kind for kind, _ in special], curve
        for (_, value), (_, expected) in zip(mine, special, strict=True):
            # Some reference values are printed with fewer digits than that.
            half_a_digit = 0.5 * 10.0 ** -len(str(expected).partition(".")[2])
            assert abs(value - expected) <= max(1e-6 * expected, half_a_digit), curve
