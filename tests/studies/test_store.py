"""Finished cases on disk: cut short, damaged, in use, on a full or read-only disk."""

import pytest

import slipfold as sf
from helpers.studies import CHEAP, content, files_of_at_most
from slipfold import InputError
from slipfold.studies.store import Store

HEAD = {"compute": "something", "cases": [1, 2, 3]}


def record(number):
    return {"case": number, "found": {"value": number / 3}}


def opened(folder, resume=True, head=HEAD):
    return Store.open(folder, 4, head, resume)


def refused(said, folder, resume=True, head=HEAD):
    with pytest.raises(InputError, match=said), opened(folder, resume, head):
        pass


@pytest.fixture
def kept(tmp_path):
    """A store with three of four cases."""
    folder = tmp_path / "kept.study"
    with opened(folder) as store:
        store.add([record(2)])
        store.add([record(0), record(3)])
    return folder


def test_cut_off_anywhere_it_lacks_the_last_cases_and_goes_on(kept):
    path = kept / "cases.jsonl"
    whole = path.read_bytes()
    for length in range(len(whole)):
        path.write_bytes(whole[:length])
        lines = whole[:length].count(b"\n")
        with opened(kept) as store:
            assert store.done == max(lines - 1, 0)
            store.add([record(number) for number in store.missing()])
        with opened(kept) as store:
            assert list(store.records()) == [record(number) for number in range(4)]


def test_a_damaged_line_counts_as_never_written(kept):
    path = kept / "cases.jsonl"
    lines = path.read_bytes().splitlines(keepends=True)
    lines[2] = lines[2].replace(b"0.0", b"0.1")
    path.write_bytes(b"".join(lines))
    with opened(kept) as store:
        assert list(store.missing()) == [0, 1]
        assert store.damaged == 1


def test_a_damaged_first_line_loses_nothing(kept):
    path = kept / "cases.jsonl"
    whole = path.read_bytes()
    first = whole.index(b"\n")
    for place in (0, 12, first):
        damaged = bytearray(whole)
        damaged[place] ^= 1
        path.write_bytes(damaged)
        for resume in (True, False):
            refused(r"first line of .* is damaged, .* another --o", kept, resume)
        assert path.read_bytes() == damaged


def test_one_begun_with_other_versions_says_which(kept, tmp_path):
    versions = {"slipfold": "1", "numpy": "2.1", "python": "3.11"}
    folder, wanted = tmp_path / "other.study", {**HEAD, "versions": {**versions, "numpy": "2.2"}}
    with opened(folder, head={**HEAD, "versions": versions}):
        pass
    said = r"started with numpy 2\.1, this is numpy 2\.2, .* install"
    refused(said, folder, head=wanted)
    refused(said, folder, head={**wanted, "quantities": ["threshold"]})
    said = "another study, which differs in its compute, versions"
    refused(said, folder, head={**wanted, "compute": "another"})


def test_one_begun_with_other_quantities_says_the_way_out(tmp_path):
    folder, head = tmp_path / "old.study", {**HEAD, "quantities": ["threshold"]}
    with opened(folder, head=head):
        pass
    said = (
        "started by another state .* other quantities; finish it by that one, or compute it again"
    )
    refused(said, folder, head={**HEAD, "quantities": ["threshold", "outcome"]})
    refused("with other quantities; finish it", folder)  # which has none
    refused("another study, which differs in its more; give", folder, head={**head, "more": 1})


def test_one_that_has_cases_is_not_used_unawares(kept, tmp_path):
    for _ in range(2):
        with opened(tmp_path / "without.study", resume=False) as store:
            assert store.done == 0
    refused(r"holds 3 of 4 cases of this study; .* --resume", kept, resume=False)


def test_one_process_at_a_time(kept):
    with opened(kept):
        refused(r"is in use by process \d+ on \S+; wait", kept)
    with opened(kept):
        pass


def test_a_full_disk_is_a_sentence_and_what_was_kept_stays(kept):
    size = (kept / "cases.jsonl").stat().st_size
    with opened(kept) as store:
        with (
            files_of_at_most(size + 20),
            pytest.raises(InputError, match=r"cannot be written \(file too large\); the 3 cases"),
        ):
            store.add([record(1)])
        assert len(list(store.records())) == 3
    assert (kept / "cases.jsonl").stat().st_size == size
    with opened(kept) as store:
        store.add([record(1)])
        assert len(list(store.records())) == 4


def test_interrupted_while_it_writes_it_knows_what_it_wrote(kept, monkeypatch):
    def interrupt(descriptor):
        raise KeyboardInterrupt

    with opened(kept) as store:
        monkeypatch.setattr("os.fsync", interrupt)
        with pytest.raises(KeyboardInterrupt):
            store.add([record(1)])
        assert len(list(store.records())) == store.done == 4


def test_what_cannot_be_written_can_be_read(kept, monkeypatch):
    """As root no permission is missing, so opening is made to fail as on a read-only disk."""

    def refuse(*arguments):
        raise OSError(30, "Read-only file system")

    monkeypatch.setattr("slipfold.studies.store.hold", refuse)
    refused(r"\(read-only file system\); the 3 cases .* make it", kept)
    monkeypatch.undo()
    with opened(kept) as store:
        store.add([record(1)])
    monkeypatch.setattr("slipfold.studies.store.hold", refuse)
    with opened(kept) as store:
        assert len(list(store.records())) == 4


def test_damaged_lines_are_counted_in_the_summary(tmp_path):
    folder = tmp_path / "cheap.study"
    undisturbed = sf.study(CHEAP, folder)
    assert "damaged" not in undisturbed.summary()
    path = folder / "cases.jsonl"
    lines = path.read_bytes().splitlines(keepends=True)
    path.write_bytes(b"".join([*lines[:2], b"x" + lines[2][1:], *lines[3:]]))
    found = sf.study(CHEAP, folder, resume=True)
    assert found.summary().splitlines()[-1] == "1 damaged line of the store left out"
    assert content(found, tmp_path) == content(undisturbed, tmp_path)
