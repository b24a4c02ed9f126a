"""Files written whole or not at all."""

from __future__ import annotations

import errno
import os
import secrets
import stat
from collections.abc import Sequence
from pathlib import Path

from slipfold.errors import InputError

FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
"""Errors that space would cure."""

NETCDF = (".nc", ".nc4", ".h5", ".hdf5")
"""Suffixes of netCDF-4 files."""


def check_writable(path: str | Path, suffixes: Sequence[str] = ()) -> None:
    """Make sure before a long computation that its result can be written.

    A name with a suffix must have one of `suffixes`, if there are any.
    """
    target, suffix = Path(os.path.realpath(path)), Path(path).suffix
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


def write_file(path: str | Path, content: bytes) -> None:
    """Write a file so that, whatever happens, the old one or the new one is there.

    The content goes into a new file in the same folder, which then replaces the old one. Devices
    and pipes, such as ``/dev/stdout``, are written to directly.
    """
    target = Path(os.path.realpath(path))
    try:
        if _is_special(target):
            target.write_bytes(content)
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
    return target.with_name(f".{target.name[:64]}.{secrets.token_hex(6)}.part")


def _is_special(target: Path) -> bool:
    return target.exists() and not target.is_file()


def _cannot_write(path: str | Path, error: OSError) -> str:
    why = error.strerror or str(error) or type(error).__name__
    space = "free some space or " if error.errno in FULL else ""
    return f"{path} cannot be written ({why.lower()}); {space}give another place"
