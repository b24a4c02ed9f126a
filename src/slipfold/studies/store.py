"""Finished cases on disk, safe once they are reported.

The file ``cases.jsonl`` of a store's folder is only ever appended to. A line is the checksum of a
text in JSON and that text: the first one says what the study is, each other is a finished case. A
line that was cut short does not fit its checksum and counts as never written; the last line of a
case counts.
"""

from __future__ import annotations

import json
import os
import platform
import sys
from array import array
from collections.abc import Collection, Iterable, Iterator, Mapping
from contextlib import contextmanager
from io import FileIO
from pathlib import Path
from typing import IO, Any
from zlib import crc32

from slipfold.errors import InputError
from slipfold.writing import FULL

Record = dict[str, Any]
"""A finished case as plain data: its number, and its values or why it failed."""

SCHEMA = "slipfold.study_store/1"

MISSING = -1

PROGRAM = {"schema", "versions", "quantities"}
"""Entries of a head that depend on the program that created the store."""


class Store:
    """The finished cases of one study, for one process at a time.

    Made by `Store.open`, in a context in which it is held.
    """

    def __init__(
        self, folder: Path, total: int, head: Mapping[str, Any], temporary: bool = False
    ) -> None:
        self.folder, self.total = folder, total
        self._head = {"schema": SCHEMA, **head}
        self._temporary = temporary  # the folder goes with the process
        # Where the line of each case begins: eight bytes a case, and no more in memory.
        self._positions = array("q", [MISSING]) * total
        self._failed = bytearray(total)
        self._size = 0  # bytes up to the end of the last complete line
        self.done = self.failures = 0  # cases that are finished, and those of them that failed
        self.damaged = 0  # lines that do not fit their checksum; what they held is computed again
        self._lock: IO[str] | None = None
        self._file: FileIO | None = None
        self._unwritable: OSError | None = None  # why nothing can be added

    @classmethod
    @contextmanager
    def open(
        cls,
        folder: Path,
        total: int,
        head: Mapping[str, Any],
        resume: bool,
        temporary: bool = False,
    ) -> Iterator[Store]:
        """Open or create the store of a study; one that has cases is refused without `resume`."""
        store = cls(folder, total, head, temporary)
        try:
            store._open(resume)
            yield store
        finally:
            for file in (store._file, store._lock):
                if file is not None:
                    file.close()

    def missing(self, failed: bool = False) -> Iterator[int]:
        """Yield the numbers of cases not finished; and on request of those that failed."""
        for number in range(self.total):
            if self._positions[number] == MISSING or (failed and self._failed[number]):
                yield number

    def add(self, records: Iterable[Record]) -> None:
        """Store finished cases: when this returns, no power failure loses them."""
        known = list(records)
        if not known:
            return
        lines = [_line(record) for record in known]
        if self._unwritable is not None:
            raise InputError(self._cannot(self._unwritable))
        try:
            self._write(b"".join(lines))
            for record, line in zip(known, lines, strict=True):
                self._note(record, self._size)
                self._size += len(line)
        except OSError as error:
            self._drop_torn()
            raise InputError(self._cannot(error)) from error
        except KeyboardInterrupt:
            self._scan()  # none, some or all of them may be in the file
            # Counts are behind positions if they were interrupted between the two.
            self.done = self.total - self._positions.count(MISSING)
            self.failures = sum(self._failed)
            raise

    def records(self) -> Iterator[Record]:
        """Yield finished cases in the order of their numbers."""
        with open(self._path, "rb") as file:
            for number in range(self.total):
                position = self._positions[number]
                if position != MISSING:
                    file.seek(position)
                    record = _content(file.readline())
                    assert record is not None
                    yield record

    def prospect(self, cure: str = "") -> str:
        """Return what happens to finished cases if a study cannot continue, and what to do."""
        cases, first = f"the {self.done} cases finished before are", f"{cure} and " if cure else ""
        if self._temporary:
            return f"{cases} lost: {first}name a folder to store them in, store="
        return f"{cases} stored: {first}continue with --resume (resume=True)"

    @property
    def _path(self) -> Path:
        return self.folder / "cases.jsonl"

    def _open(self, resume: bool) -> None:
        try:
            self.folder.mkdir(exist_ok=True)
            self._lock = hold(self.folder / "lock", str(self.folder))
            self._file = FileIO(self._path, "a")
        except OSError as error:
            self._unwritable = error
            if not self._path.is_file():
                raise InputError(self._cannot(error)) from error
        self._scan()
        if self.done and not resume:
            raise InputError(
                f"{self.folder} holds {self.done} of {self.total} cases of this study; "
                "continue with --resume (resume=True), or give another --out"
            )
        if self._unwritable is not None:
            if self.done < self.total:
                raise InputError(self._cannot(self._unwritable))
            return
        self._drop_torn()
        if not self._size:
            self._begin()

    def _scan(self) -> None:
        """Find the complete lines after those known."""
        with open(self._path, "rb") as file:
            file.seek(self._size)
            for line in file:
                content = _content(line)
                if not self._size:
                    if content is None and not line.endswith(b"\n"):
                        return  # killed while it was created
                    self._check_head(content)
                elif content is not None:
                    self._note(content, file.tell() - len(line))
                elif line.endswith(b"\n"):
                    self.damaged += 1
                if line.endswith(b"\n"):
                    self._size = file.tell()

    def _check_head(self, result: Mapping[str, Any] | None) -> None:
        if result is None:
            raise InputError(
                f"the first line of {self._path} is damaged, so it is unknown which study it "
                "holds; restore it, or give another --out"
            )
        expected = json.loads(json.dumps(self._head))
        if result == expected:
            return
        differs = [key for key in {**expected, **result} if result.get(key) != expected.get(key)]
        if set(differs) <= PROGRAM:
            raise InputError(self._other_program(result, differs))
        if differs == ["draws"]:
            raise InputError(
                f"{self.folder} was started when the same seed drew other cases, which cannot be "
                "mixed with those of today; give another --out, or remove that folder"
            )
        raise InputError(
            f"{self.folder} holds another study, which differs in its {', '.join(differs)}; give "
            "another --out, or remove that folder"
        )

    def _other_program(self, result: Mapping[str, Any], differs: Collection[str]) -> str:
        known: Mapping[str, str] = result.get("versions", {})
        here = self._head.get("versions", {})
        names = [name for name in {**known, **here} if known.get(name) != here.get(name)]
        if not names:
            what = "other quantities" if "quantities" in differs else "a store of another form"
            return (
                f"{self.folder} was started by another state of this version of slipfold, with "
                f"{what}; finish it by that one, or compute it again with another --out"
            )
        started, present = (
            ", ".join(f"{name} {each.get(name, 'unknown')}" for name in names)
            for each in (known, here)
        )
        return (
            f"{self.folder} was started with {started}, this is {present}, and last digits would "
            "differ; install what it was started with, or give another --out"
        )

    def _begin(self) -> None:
        line = _line(self._head)
        try:
            self._write(line)
            _sync_folder(self.folder)
        except OSError as error:
            raise InputError(self._cannot(error)) from error
        self._size = len(line)

    def _write(self, content: bytes) -> None:
        """Append without buffers, so that nothing is written later that was given up."""
        assert self._file is not None
        remainder = memoryview(content)
        while remainder:
            remainder = remainder[self._file.write(remainder) :]
        os.fsync(self._file.fileno())

    def _note(self, record: Record, position: int) -> None:
        number, failed = record["case"], "failed" in record
        new, worse = self._positions[number] == MISSING, failed - self._failed[number]
        self._positions[number], self._failed[number] = position, failed
        self.done += new
        self.failures += worse

    def _drop_torn(self) -> None:
        """Cut off an incomplete last line: others would be joined to it."""
        try:
            os.truncate(self._path, self._size)
        except OSError as error:
            raise InputError(self._cannot(error)) from error

    def _cannot(self, error: OSError) -> str:
        why = (error.strerror or str(error)).lower()
        cure = "free some space" if error.errno in FULL else "make it writable"
        return f"{self.folder} cannot be written ({why}); {self.prospect(cure)}"


def _line(content: Mapping[str, Any]) -> bytes:
    text = json.dumps(content, separators=(",", ":")).encode()
    return b"%08x %s\n" % (crc32(text), text)


def _content(line: bytes) -> dict[str, Any] | None:
    """Return the content of a line; None if it is incomplete."""
    checksum, text = line[:8], line[9:-1]
    if not line.endswith(b"\n") or checksum != b"%08x" % crc32(text):
        return None
    result: dict[str, Any] = json.loads(text)
    return result


def _sync_folder(folder: Path) -> None:
    """Make the names of new files safe as well, where a system can."""
    for path in (folder, folder.parent):
        try:
            descriptor = os.open(path, os.O_RDONLY)
        except OSError:  # Windows has no such thing
            return
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)


def hold(path: Path, what: str) -> IO[str]:
    """Take the lock of a file, or say who has it; it is held until the file is closed."""
    file = open(path, "a+", encoding="utf-8")  # noqa: SIM115 (open for as long as it is held)
    try:
        _lock(file)
        file.truncate(0)
        file.write(f"process {os.getpid()} on {platform.node()}\n")
        file.flush()
    except BlockingIOError:
        file.seek(0)
        holder = file.read().strip() or "another process"
        file.close()
        raise InputError(
            f"{what} is in use by {holder}; wait until that is done, or give another --out"
        ) from None
    except OSError:
        file.close()
        raise
    return file


def _lock(file: IO[str]) -> None:
    if sys.platform == "win32":
        import msvcrt

        # Beyond the end, so that others can read who holds it.
        file.seek(1 << 16)
        try:
            msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)
        except OSError as error:
            raise BlockingIOError from error
    else:
        import fcntl

        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
