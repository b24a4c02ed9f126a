"""The program as a process: streams, signals, terminals, imports."""

import codecs
import json
import os
import re
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

from helpers.command_line import run as run_here
from helpers.long_tests import long_except
from slipfold import load

PROGRAM = [sys.executable, "-m", "slipfold.interface.cli"]
# So many points that it is still running when it is interrupted.
LONG = ["response", "sliding", "--vary", "Nd=0:0.98", "--max-step", "2e-4"]

pty = pytest.importorskip("pty")


class Terminal:
    """Standard error of a process as a terminal, and its standard output; both read as they come.

    A process that nobody reads from waits for ever when what it wrote fills the terminal.
    """

    def __init__(self, *arguments, program=PROGRAM):
        self._ours, theirs = pty.openpty()
        streams = {"stdout": subprocess.PIPE, "stderr": theirs}
        self.process = subprocess.Popen([*program, *arguments], **streams)
        os.close(theirs)
        self.text, self._output, self._more = "", b"", threading.Condition()
        self._readers = [threading.Thread(target=self._read_terminal)]
        self._readers.append(threading.Thread(target=self._read_output))
        for reader in self._readers:
            reader.start()

    def _read_terminal(self):
        decoder = codecs.getincrementaldecoder("utf-8")()
        while True:
            try:
                read = os.read(self._ours, 65536)
            except OSError:  # the process has closed it
                return
            with self._more:
                self.text += decoder.decode(read)
                self._more.notify_all()

    def _read_output(self):
        self._output = self.process.stdout.read()

    def read_until(self, pattern, seconds=180):
        """Wait until words of a pattern have appeared."""
        with self._more:
            found = self._more.wait_for(lambda: re.search(pattern, self.text), seconds)
        if not found:
            self.process.kill()
        assert found, self.text

    def finish(self):
        for reader in self._readers:
            reader.join()
        os.close(self._ours)
        self.process.stdout.close()
        return self.process.wait(), self._output.decode()


EVERY_STATE = """
from rich.progress import Progress
update = Progress.update
def drawn(self, *arguments, **options):
    update(self, *arguments, **options)
    self.refresh()
Progress.update = drawn
from slipfold.interface.cli import main
main()
"""
"""Draws whatever it has to tell: else what lasts a tenth of a second may be missed."""


def watched(*command):
    return Terminal(*command, program=[sys.executable, "-c", EVERY_STATE])


def test_progress_on_a_terminal_and_json_alone_on_standard_output():
    terminal = watched("response", "sliding", "--vary", "Nd=0:0.98", "--json", "-")
    status, output = terminal.finish()
    assert status == 0
    assert json.loads(output)["branches"][1]["period"] == 2
    # Elapsed time, branch, points, parameter, special points found so far.
    assert "0:00:0" in terminal.text
    assert "branch 2 (period 2)" in terminal.text
    assert " points " in terminal.text
    assert "Nd = 0.98 N" in terminal.text
    assert "found: PD NS NS" in terminal.text


HEARD = "slipfold: stopping at the next point"


def interrupt(terminal):
    """Press Ctrl-C; it is to be heard within a second, five where others keep the machine busy."""
    terminal.process.send_signal(signal.SIGINT)
    terminal.read_until(HEARD, seconds=5)


def test_interrupt_keeps_what_is_finished(tmp_path):
    path = tmp_path / "x.nc"
    terminal = Terminal(*LONG, "--out", str(path), "--json", "-")
    terminal.read_until("points")
    interrupt(terminal)
    status, output = terminal.finish()
    assert status == 130
    assert "slipfold: interrupted after " in terminal.text
    assert f"finished results are in {path}" in " ".join(terminal.text.split())
    assert "Traceback" not in terminal.text
    record = json.loads(output)
    assert record["branches"][-1]["stopped"]["kind"] == "interrupted"
    diagram = load(path)
    assert diagram.interrupted
    assert len(diagram.branches[0]) == record["branches"][0]["points"] >= 1
    assert os.listdir(tmp_path) == ["x.nc"]


WITHOUT_END = """
import itertools, sys
from importlib import import_module
from slipfold.interface.cli import main
def without_end(*arguments, **options):
    for _ in itertools.count():
        pass
module, name = sys.argv.pop(1).split(":")
setattr(import_module(module), name, without_end)
main()
"""


def interrupted_within(place, stage, command):
    """Run a command in which one function never returns, and interrupt it there."""
    terminal = Terminal(place, *command, program=[sys.executable, "-c", WITHOUT_END])
    terminal.read_until(stage)
    interrupt(terminal)
    pressed = time.monotonic()
    status, output = terminal.finish()
    assert time.monotonic() - pressed < 10  # a second, and to write and to leave; this is a loop
    assert "Traceback" not in terminal.text
    return status, output, " ".join(terminal.text.split())


def test_an_interrupt_while_normal_forms_are_computed_keeps_the_branches(tmp_path):
    path = tmp_path / "x.nc"
    command = ["response", "sliding", "--vary", "Nd=0:0.05", "--out", str(path)]
    status, output, said = interrupted_within(
        "slipfold.bifurcations.branches.make_branch:describe",
        "normal forms: 0 of 1 done",
        command,
    )
    assert status == 130
    assert "interrupted after" in said
    assert "interrupted before its normal form was computed" in output
    assert "Interrupted before the uncertainty was computed of 1 special points" in output
    assert "checked: nothing, as it was interrupted" in output
    diagram = load(path)
    assert [branch.stopped.kind for branch in diagram.branches] == ["span", "span"]
    [(_, doubling)] = diagram.special
    assert doubling.value == pytest.approx(0.043578911, abs=1e-9)
    assert (doubling.interrupted, doubling.criticality) == (True, None)
    assert diagram.interrupted


def test_an_interrupt_while_normal_forms_along_loci_are_computed_keeps_the_loci(tmp_path):
    path, response = tmp_path / "x.nc", tmp_path / "response.nc"
    given = ["response", "sliding", "--vary", "Nd=0:0.05", "--set", "f=12.5"]
    assert run_here(*given, "--out", str(response)).exit_code == 0
    window = ["--vary", "f=12.45:12.55", "--vary", "Nd=0:0.06"]
    status, output, said = interrupted_within(
        "slipfold.bifurcations.loci.make_locus:coefficient_at",
        "normal forms: 0 of",
        ["locus", str(response), *window, "--out", str(path)],
    )
    assert status == 130
    assert "slipfold: interrupted after " in said
    (locus,) = load(path).loci
    assert len(locus) > 2
    assert np.isnan(locus.coefficient).all()
    assert "interrupted before its coefficients were computed" in locus.stopped.reason
    assert locus.stopped.reason in output


ENDLESS = str(10**7)
MOTIONS = {
    "forced": (["sliding", "--set", "f=12.5"], "forcing periods"),
    "free": (["vanderpol-free", "--set", "duration=0.1"], "intervals"),
    "through stick": (
        ["sliding", "--set", "f=12.2", "--set", "Nd=0.9", "--set", "Vd=0.1"],
        "forcing periods",
    ),
}


@pytest.mark.parametrize("which", long_except(MOTIONS, ("forced", "through stick")))
def test_interrupt_keeps_a_motion_as_far_as_it_came(which, tmp_path):
    path = tmp_path / "x.nc"
    options, each = MOTIONS[which]
    command = ["simulate", *options, "--periods", ENDLESS, "--out", str(path), "--json", "-"]
    terminal = Terminal(*command)
    # More than there are before a motion through stick begins anew.
    terminal.read_until(rf"\d{{3}} of {ENDLESS} done")
    interrupt(terminal)
    status, output = terminal.finish()
    assert status == 130
    said = " ".join(terminal.text.split())
    record = json.loads(output)
    assert f"slipfold: interrupted after {record['periods']} {each}" in said
    assert f"finished results are in {path}" in said
    assert "Traceback" not in said
    motion = load(path)
    assert (motion.interrupted, motion.stopped.kind) == (True, "interrupted")
    assert len(motion.states) == record["periods"] + 1 > 1
    assert np.isfinite(motion.states).all()
    assert "it was interrupted" in motion.settlement.message
    assert (motion.sticking is not None) == (which == "through stick")


def test_interrupt_is_heeded_where_the_shell_ignores_it():
    # As in a script that starts the program in the background.
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        terminal = Terminal(*LONG)
    finally:
        signal.signal(signal.SIGINT, before)
    terminal.read_until("points")
    terminal.process.send_signal(signal.SIGINT)
    status, output = terminal.finish()
    assert status == 130
    assert "interrupted" in output  # the table says where
    assert "--out FILE.nc would keep it" in " ".join(terminal.text.split())


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="there is no /dev/full")
def test_standard_output_on_a_full_disk():
    with open("/dev/full", "w") as full:
        run = subprocess.run(
            [*PROGRAM, "models"], stdout=full, stderr=subprocess.PIPE, text=True, check=False
        )
    assert run.returncode == 2
    assert run.stderr == (
        "slipfold: standard output cannot be written (no space left on device); free some space "
        "or send it elsewhere\n"
    )


def test_reader_that_goes_away():
    reader, writer = os.pipe()
    os.close(reader)
    run = subprocess.run([*PROGRAM, "models"], stdout=writer, stderr=subprocess.PIPE, check=False)
    os.close(writer)
    assert (run.returncode, run.stderr) == (0, b"")


HEAVY = {"xarray", "pandas", "matplotlib", "rich", "h5py", "h5netcdf"}


@pytest.mark.parametrize(
    ("arguments", "others"),
    [
        (
            ["response", "sliding", "--vary", "Nd=0:0.01", "--json", "-"],
            {"scipy", "slipfold.bifurcations.loci"},
        ),
        (
            ["locus", "sliding", "--vary", "f=12.49:12.5", "--vary", "Nd=0:0.05", "--type", "PD",
             "--period", "1", "--json", "-"],
            set(),
        ),
    ],
)  # fmt: skip
def test_a_command_starts_without_heavy_modules_and_is_silent_off_a_terminal(arguments, others):
    program = (
        f"import sys; sys.argv[1:] = {arguments!r}\n"
        "from slipfold.interface.cli import main\n"
        "try: main()\n"
        "except SystemExit: pass\n"
        f"heavy = {HEAVY | others!r}\n"
        "print(sorted(heavy & set(sys.modules)), file=sys.stderr)"
    )
    run = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    assert json.loads(run.stdout)["schema"].startswith("slipfold.")
    assert run.stderr == "[]\n"
