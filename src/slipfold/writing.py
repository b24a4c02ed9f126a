"""Files written whole or not at all, and not over what a command reads."""

from __future__ import annotations

import errno
import os
import stat
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path

from slipfold.errors import InputError

FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
"""Errors that space would cure."""

NETCDF = (".nc", ".nc4", ".h5", ".hdf5")
"""Suffixes of netCDF-4 files."""

_OUTPUTS: ContextVar[set[str]] = ContextVar("the files that a command is to write")


@contextmanager
def inputs_kept() -> Iterator[None]:
    """Have `to_read` refuse the files that `check_writable` was asked about within."""
    token = _OUTPUTS.set(set())
    try:
        yield
    finally:
        _OUTPUTS.reset(token)


def as_path(given: object, example: str = "result.nc") -> Path:
    """Return the path of a file, or refuse what is none."""
    path = os.fspath(given) if isinstance(given, os.PathLike) else given
    if not isinstance(path, str) or not path:
        raise InputError(f"{given!r} is no path of a file; give one, such as {example!r}")
    return Path(path)


def to_read(path: str | Path) -> Path:
    """Return the path of a file that is now read, which must not be one to be written."""
    path = as_path(path)
    if os.path.exists(path) and os.path.realpath(path) in _OUTPUTS.get(set()):
        raise InputError(f"{path} is read as input; give the result another name")
    return path


def check_writable(path: str | Path, suffixes: Sequence[str] = ()) -> None:
    """Make sure before a long computation that its result can be written, and over no input.

    A name with a suffix must have one of `suffixes`, if there are any.
    """
    target, suffix = Path(os.path.realpath(as_path(path))), Path(path).suffix
    try:
        if target.is_dir():
            raise InputError(f"{path} is a folder; give the name of a file")
        if not target.parent.is_dir():
            raise InputError(
                f"the folder {Path(path).parent} does not exist, so {path} cannot be written; "
                "make the folder or give another one"
            )
        if _is_special(path):
            if not os.access(path, os.W_OK):  # to open a pipe would wait for its reader
                raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))
            return
        _check_replaceable(path, target)
        if suffixes and suffix and suffix.lower() not in suffixes:
            raise InputError(
                f"{path} would be a netCDF file, which {suffix} does not stand for; give a name "
                f"that ends with {', '.join(suffixes)}"
            )
        # Permissions are not enough (read-only disks, quotas): only a trial shows it.
        trial = _beside(target)
        os.close(os.open(trial, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o600))
        trial.unlink()
    except OSError as error:
        raise InputError(_cannot_write(path, error)) from error
    _OUTPUTS.get(set()).add(str(target))


def write_file(path: str | Path, content: bytes) -> None:
    """Write a file so that, whatever happens, the old one or the new one is there.

    The content goes into a new file in the same folder, which then replaces the old one. Devices
    and pipes, such as ``/dev/stdout``, are written to directly.
    """
    target = Path(os.path.realpath(as_path(path)))
    try:
        if _is_special(path):
            Path(path).write_bytes(content)
            return
        trial = _beside(target)
        try:
            with open(os.open(trial, os.O_CREAT | os.O_EXCL | os.O_WRONLY, 0o666), "wb") as file:
                file.write(content)
                file.flush()
                os.fsync(file.fileno())
            os.replace(trial, target)
        except BaseException:
            trial.unlink(missing_ok=True)
            raise
    except OSError as error:
        raise InputError(_cannot_write(path, error)) from error


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
    return target.with_name(f".{target.name[:64]}.{os.urandom(6).hex()}.part")


def _is_special(path: str | Path) -> bool:
    """Whether it is a device or a pipe: their real paths may not exist, as behind /dev/stdout."""
    return os.path.exists(path) and not os.path.isfile(path)


def _cannot_write(path: str | Path, error: OSError) -> str:
    why = error.strerror or str(error) or type(error).__name__
    space = "free some space or " if error.errno in FULL else ""
    return f"{path} cannot be written ({why.lower()}); {space}give another place"
