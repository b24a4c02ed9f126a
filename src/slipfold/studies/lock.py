"""One process at a time: a lock that the system takes back when its holder dies."""

from __future__ import annotations

import os
import platform
import sys
from pathlib import Path
from typing import IO

from slipfold.errors import InputError


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
