"""The cache of compiled flows: used if it is ours and whole, else rebuilt, never trusted."""

import hashlib
import os
import pickle
import stat

import numpy as np
import pytest

import slipfold as sf
from slipfold.flow import compiled_code
from slipfold.flow.compiled_code import cache_directory, cached
from slipfold.flow.equations import build_equations
from slipfold.flow.flow import Flow
from slipfold.flow.sharp_turns import TURNS, VERSION

posix = pytest.mark.skipif(os.name != "posix", reason="permissions are POSIX")


class Builder:
    """Counts how often it had to build."""

    def __init__(self, value="made"):
        self.value = value
        self.calls = 0

    def __call__(self):
        self.calls += 1
        return self.value


class Trap:
    """Its pickle leaves a trace when it is opened."""

    def __init__(self, path):
        self.path = path

    def __reduce__(self):
        return os.mkdir, (str(self.path),)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    path = tmp_path / "deep" / "cache"
    monkeypatch.setenv("SLIPFOLD_CACHE_DIR", str(path))
    return path


def only_entry(folder):
    (entry,) = folder.iterdir()
    return entry


def seal(entry, payload, key_digest=None):
    """Write an entry as the cache itself would."""
    header = compiled_code._MAGIC + (key_digest or entry.stem).encode()
    entry.write_bytes(header + hashlib.sha256(header + payload).digest() + payload)


def test_second_time_it_comes_from_the_disk(folder):
    builder = Builder([1, 2])
    assert cached("a", builder) == [1, 2]
    assert cached("a", builder) == [1, 2]
    assert builder.calls == 1


def test_keys_name_the_numbers_that_are_compiled():
    assert f"'flat': {TURNS.flat}" in VERSION


@pytest.mark.parametrize("function", ["_machine", "_processor"])
def test_another_machine_is_another_entry(folder, monkeypatch, function):
    cached("a", Builder("here"))
    compiled_code._machine.cache_clear()
    monkeypatch.setattr(compiled_code, function, lambda: "another")
    try:
        assert cached("a", Builder("there")) == "there"
    finally:
        monkeypatch.undo()
        compiled_code._machine.cache_clear()


@posix
def test_directory_and_entries_are_private(folder):
    cached("a", Builder())
    assert stat.S_IMODE(folder.stat().st_mode) == 0o700
    assert stat.S_IMODE(only_entry(folder).stat().st_mode) == 0o600


SEALED = len(compiled_code._MAGIC) + 64


def flipped(content, place):
    return content[:place] + bytes([content[place] ^ 1]) + content[place:][1:]


DAMAGES = {
    "empty": lambda content: b"",
    "cut": lambda content: content[:-3],
    "changed": lambda content: flipped(content, len(content) - 5),
    "changed digest": lambda content: flipped(content, SEALED + 3),
}


@pytest.mark.parametrize("damage", DAMAGES)
def test_damaged_entry_is_rebuilt(folder, damage):
    cached("a", Builder())
    entry = only_entry(folder)
    entry.write_bytes(DAMAGES[damage](entry.read_bytes()))
    again = Builder("rebuilt")
    assert cached("a", again) == "rebuilt"
    assert cached("a", Builder("third")) == "rebuilt"
    assert again.calls == 1


def test_entry_of_another_key_is_not_taken(folder):
    cached("a", Builder("one"))
    first = only_entry(folder).read_bytes()
    cached("b", Builder("two"))
    for entry in folder.iterdir():
        entry.write_bytes(first)
    assert cached("b", Builder("rebuilt")) == "rebuilt"


def unsealed(entry, payload):
    entry.write_bytes(entry.read_bytes()[: SEALED + 32] + payload)


def writable(mode):
    def spoil(entry, payload):
        seal(entry, payload)
        entry.chmod(mode)

    return spoil


def linked(entry, payload):
    elsewhere = entry.parent.parent / entry.name
    seal(elsewhere, payload)
    entry.unlink()
    entry.symlink_to(elsewhere)


def foreign(entry, payload):
    if not hasattr(os, "getuid") or os.getuid() != 0:
        pytest.skip("needs root")
    seal(entry, payload)
    os.chown(entry, 12345, -1)


SPOILT = {
    "wrong digest": unsealed,
    **{f"mode {mode:o}": writable(mode) for mode in (0o666, 0o620, 0o602)},
    "link": linked,
    "foreign owner": foreign,
}


@posix
@pytest.mark.parametrize("spoil", SPOILT)
def test_entry_that_others_may_have_made_is_never_opened(folder, tmp_path, spoil):
    cached("a", Builder())
    SPOILT[spoil](only_entry(folder), pickle.dumps(Trap(tmp_path / "sprung")))
    assert cached("a", Builder("rebuilt")) == "rebuilt"
    assert not (tmp_path / "sprung").exists()
    assert not only_entry(folder).is_symlink()
    assert stat.S_IMODE(only_entry(folder).stat().st_mode) == 0o600


@posix
@pytest.mark.parametrize("mode", [0o777, 0o770, 0o702, None])
def test_directory_others_may_write_is_not_used(folder, tmp_path, mode):
    cached("a", Builder())
    seal(only_entry(folder), pickle.dumps(Trap(tmp_path / "sprung")))
    if mode is not None:
        folder.chmod(mode)
    elif hasattr(os, "getuid") and os.getuid() == 0:
        os.chown(folder, 12345, -1)
    else:
        pytest.skip("needs root")
    assert cached("a", Builder("rebuilt")) == "rebuilt"
    assert cached("b", Builder("two")) == "two"
    assert len(list(folder.iterdir())) == 1
    assert not (tmp_path / "sprung").exists()


def test_unusable_directory_costs_time_only(tmp_path, monkeypatch):
    blocked = tmp_path / "file"
    blocked.write_text("in the way")
    for path in (blocked, blocked / "below"):
        monkeypatch.setenv("SLIPFOLD_CACHE_DIR", str(path))
        builder = Builder()
        assert cached("a", builder) == cached("a", builder) == "made"
        assert builder.calls == 2
    assert blocked.read_text() == "in the way"


@pytest.mark.parametrize("broken", ["mkstemp", "replace"])
def test_full_disk_costs_time_only(folder, monkeypatch, broken):
    def full(*args, **kwargs):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(
        compiled_code.tempfile if broken == "mkstemp" else compiled_code.os, broken, full
    )
    assert cached("a", Builder()) == "made"
    assert not list(folder.iterdir())


def test_directory_follows_the_environment(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setenv("SLIPFOLD_CACHE_DIR", "")
    assert cache_directory() == tmp_path / "slipfold"
    monkeypatch.setenv("SLIPFOLD_CACHE_DIR", str(tmp_path / "own"))
    assert cache_directory() == tmp_path / "own"
    monkeypatch.delenv("SLIPFOLD_CACHE_DIR")
    monkeypatch.delenv("XDG_CACHE_HOME")
    monkeypatch.setenv("HOME", str(tmp_path))
    assert cache_directory() == tmp_path / ".cache" / "slipfold"


def test_flow_from_the_disk_is_the_flow_that_was_compiled(folder):
    model = sf.SlidingOscillator(Nd=0.2)
    grid, start = np.array([0.0, 1.0, 2.0]), np.zeros(4)

    def states():
        flow = Flow(build_equations(model))
        return flow.trajectory(start, flow.constants(model.vector), grid)

    first = states()
    stamps = {path: path.stat().st_mtime_ns for path in folder.iterdir()}
    assert np.array_equal(states(), first)
    assert {path: path.stat().st_mtime_ns for path in folder.iterdir()} == stamps
    for path in stamps:
        path.write_bytes(path.read_bytes()[:-100])
    assert np.array_equal(states(), first)
    assert all(path.stat().st_mtime_ns != stamp for path, stamp in stamps.items())
