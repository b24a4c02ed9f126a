"""Files are written whole or not at all."""

import os
import resource
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from helpers.studies import files_of_at_most
from slipfold import InputError, writing
from slipfold.results.tables import LabeledTable, Variable
from slipfold.writing import NETCDF, check_writable, write_file

FULL = Path("/dev/full")
needs_full = pytest.mark.skipif(not FULL.is_char_device(), reason="there is no /dev/full")


def test_new_file(tmp_path):
    write_file(tmp_path / "a.nc", b"new")
    assert (tmp_path / "a.nc").read_bytes() == b"new"
    assert os.listdir(tmp_path) == ["a.nc"]


def test_old_file_stays_if_writing_fails(tmp_path, monkeypatch):
    path = tmp_path / "a.nc"
    path.write_bytes(b"old")

    def fail(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(writing.os, "replace", fail)
    with pytest.raises(InputError, match=r"a\.nc cannot be written \(no space left on device\)"):
        write_file(path, b"new")
    assert path.read_bytes() == b"old"
    assert os.listdir(tmp_path) == ["a.nc"]


def test_nothing_is_left_behind_by_an_interrupt(tmp_path, monkeypatch):
    def interrupt(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(writing.os, "fsync", interrupt)
    with pytest.raises(KeyboardInterrupt):
        write_file(tmp_path / "a.nc", b"new")
    assert os.listdir(tmp_path) == []


def test_disk_that_fills_up_half_way(tmp_path):
    program = (
        "import sys; from slipfold.writing import write_file\n"
        "try: write_file(sys.argv[1], bytes(100_000))\n"
        "except ValueError as error: print(error)"
    )

    def limit():
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (5000, 5000))

    path = tmp_path / "a.nc"
    path.write_bytes(b"old")
    # Without bytecode: it would be cut short as well.
    run = subprocess.run(
        [sys.executable, "-B", "-c", program, path],
        preexec_fn=limit,
        capture_output=True,
        text=True,
        check=True,
    )
    assert "a.nc cannot be written (file too large)" in run.stdout
    assert path.read_bytes() == b"old"
    assert os.listdir(tmp_path) == ["a.nc"]


@pytest.mark.parametrize("room", [100, 5_000, 60_000])
def test_netcdf_on_a_disk_that_fills_up(tmp_path, room):
    values = np.arange(10_000.0)
    table = LabeledTable({name: Variable(("row",), values) for name in "ab"}, {"title": "rows"})
    path = tmp_path / "a.nc"
    write_file(path, table.to_netcdf())
    whole = path.read_bytes()
    with files_of_at_most(room), pytest.raises(InputError, match=r"written \(file too large\)"):
        write_file(path, table.to_netcdf())
    assert path.read_bytes() == whole
    assert os.listdir(tmp_path) == ["a.nc"]


@needs_full
def test_full_device():
    check_writable(FULL)
    with pytest.raises(InputError, match="no space left on device"):
        write_file(FULL, b"new")
    assert FULL.is_char_device()


def test_pipe_is_written_to_directly(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    check_writable(tmp_path / "pipe")  # nobody reads it yet
    reader = os.open(tmp_path / "pipe", os.O_RDONLY | os.O_NONBLOCK)
    write_file(tmp_path / "pipe", b"new")
    assert os.read(reader, 10) == b"new"
    os.close(reader)
    reader, writer = os.pipe()
    check_writable(f"/dev/fd/{writer}")  # as /dev/stdout before a pipe: its real path is none
    write_file(f"/dev/fd/{writer}", b"new")
    assert os.read(reader, 10) == b"new"
    os.close(reader)
    os.close(writer)


def test_checking_refuses_folders_and_missing_folders(tmp_path):
    with pytest.raises(InputError, match="is a folder; give the name of a file"):
        check_writable(tmp_path)
    with pytest.raises(InputError, match="does not exist"):
        check_writable(tmp_path / "none" / "a.nc")
    (tmp_path / "file").write_bytes(b"")
    with pytest.raises(InputError, match="does not exist"):
        check_writable(tmp_path / "file" / "a.nc")


def test_checking_a_read_only_disk(tmp_path, monkeypatch):
    def fail(*_):
        raise OSError(30, "Read-only file system")

    monkeypatch.setattr(writing.os, "open", fail)
    with pytest.raises(InputError, match="read-only file system"):
        check_writable(tmp_path / "a.nc")


def test_checking_refuses_to_replace_the_file_of_somebody_else(tmp_path, monkeypatch):
    theirs = tmp_path / "theirs.nc"
    theirs.write_bytes(b"old")
    tmp_path.chmod(0o1777)
    check_writable(theirs)
    monkeypatch.setattr(writing.os, "geteuid", lambda: 12345)
    with pytest.raises(InputError, match="belongs to somebody else"):
        check_writable(theirs)


def test_checking_refuses_a_suffix_of_another_format(tmp_path):
    check_writable(tmp_path / "a.NC", NETCDF)
    check_writable(tmp_path / "a", NETCDF)
    with pytest.raises(InputError, match=r"a\.txt would be a netCDF file.*ends with \.nc, "):
        check_writable(tmp_path / "a.txt", NETCDF)
