"""Files written whole or not at all."""

from __future__ import annotations

import errno
import io
import os
import secrets
import stat
from collections.abc import Callable
from pathlib import Path
from typing import IO, TYPE_CHECKING, cast

from slipfold.errors import InputError

if TYPE_CHECKING:
    from typing_extensions import Buffer

FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
"""Errors that space would cure."""


def check_writable(path: str | Path) -> None:
    """Make sure before a long computation that its result can be written."""
    target = Path(os.path.realpath(path))
    try:
        if target.is_dir():
            raise InputError(f"{path} is a folder; give the name of a file")
        if not target.parent.is_dir():
            raise InputError(
                f"the folder {Path(path).parent} does not exist, so {path} cannot be written; "
                "make the folder or give another one"
            )
        if _is_special(target):
            with open(target, "ab"):
                return
        _check_replaceable(path, target)
        # Permissions do not tell all (read-only disks, quotas): only a trial does.
        trial = _beside(target)
        os.close(os.open(trial, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o600))
        trial.unlink()
    except OSError as error:
        raise InputError(_cannot_write(path, error)) from error


def write_file(path: str | Path, content: bytes | Callable[[IO[bytes]], object]) -> None:
    """Write a file so that, whatever happens, the old one or the new one is there.

    The content, or what writes it to a file given to it, goes into a new file in the same folder,
    which then takes the place of the old one. Devices and pipes, such as ``/dev/stdout``, are
    written to directly.
    """
    target = Path(os.path.realpath(path))
    trial = _beside(target)
    write = (lambda file: file.write(content)) if isinstance(content, bytes) else content
    try:
        if _is_special(target):
            with open(target, "wb") as file:
                file.write(_whole(write))
            return
        try:
            descriptor = os.open(trial, os.O_CREAT | os.O_EXCL | os.O_RDWR, 0o666)
            _write_in_pieces(descriptor, write)
            os.replace(trial, target)
        except BaseException:
            trial.unlink(missing_ok=True)
            raise
    except OSError as error:
        raise InputError(_cannot_write(path, error)) from error


def _whole(write: Callable[[IO[bytes]], object]) -> bytes:
    memory = io.BytesIO()
    write(memory)
    return memory.getvalue()


def _write_in_pieces(descriptor: int, write: Callable[[IO[bytes]], object]) -> None:
    """Have `write` write to a file; raise the first error of the disk, not its consequences."""
    with _Patient(descriptor, "r+") as file:
        try:
            write(cast("IO[bytes]", file))
        finally:
            if file.failure is not None:
                raise file.failure
        os.fsync(descriptor)


class _Patient(io.FileIO):
    """A file that stores its first failure and continues as if there were room.

    HDF5 gives up neither its place nor its memory while it cannot write the rest of a file.
    """

    failure: OSError | None = None

    def write(self, content: Buffer) -> int:
        """Write all of it."""
        rest = memoryview(content).cast("B")
        try:
            while self.failure is None and rest:
                rest = rest[super().write(rest) :]
        except OSError as error:
            self.failure = error
        return memoryview(content).nbytes


def _check_replaceable(path: str | Path, target: Path) -> None:
    """Refuse a file that its owner has protected, and a name that no file can have."""
    try:
        result = target.lstat()
    except FileNotFoundError:
        return
    folder = target.parent.stat()
    owners = (0, result.st_uid, folder.st_uid)
    # In a folder that all may write to, as /tmp, only a file's owner may replace it.
    theirs = folder.st_mode & stat.S_ISVTX and hasattr(os, "geteuid") and os.geteuid() not in owners
    if theirs or not result.st_mode & (stat.S_IWUSR | stat.S_IWGRP | stat.S_IWOTH):
        raise InputError(
            f"{path} is read-only{' or belongs to somebody else' if theirs else ''}; make it "
            "writable or give another name"
        )


def _beside(target: Path) -> Path:
    return target.with_name(f".{target.name[:64]}.{secrets.token_hex(6)}.part")


def _is_special(target: Path) -> bool:
    return target.exists() and not target.is_file()


def _cannot_write(path: str | Path, error: OSError) -> str:
    why = error.strerror or str(error) or type(error).__name__
    space = "free some space or " if error.errno in FULL else ""
    return f"{path} cannot be written ({why.lower()}); {space}give another place"
