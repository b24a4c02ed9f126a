"""Compiled code kept on disk, per user, and trusted only if it is provably ours."""

from __future__ import annotations

import hashlib
import os
import pickle
import platform
import stat
import tempfile
from collections.abc import Callable
from functools import cache as memoise
from pathlib import Path
from typing import Any

import heyoka as hy

_MAGIC = b"slipfold-flow-1\n"
_DIGEST_SIZE = hashlib.sha256().digest_size


def cache_directory() -> Path:
    """Return where compiled flows are kept.

    ``$SLIPFOLD_CACHE_DIR`` if set, else ``$XDG_CACHE_HOME/slipfold`` or ``~/.cache/slipfold``.
    """
    chosen = os.environ.get("SLIPFOLD_CACHE_DIR")
    if chosen:
        return Path(chosen)
    base = os.environ.get("XDG_CACHE_HOME")
    return (Path(base) if base else Path.home() / ".cache") / "slipfold"


def cached(key: str, build: Callable[[], Any]) -> Any:
    """Return what `build` makes, from disk if it was made before on this machine.

    An entry is a pickle, so it is opened only if the directory and the file belong to this user
    and nobody else may write to them, and if its digest fits its content and its key. Anything
    else is rebuilt and overwritten. Where the directory cannot be made safe, nothing is stored.
    """
    digest = hashlib.sha256(f"{key}\n{_machine()}".encode()).hexdigest()
    directory = _safe_directory()
    if directory is None:
        return build()
    path = directory / f"{digest}.flow"
    found = _read(path, digest)
    if found is not None:
        return found
    made = build()
    _write(path, digest, made)
    return made


@memoise
def _machine() -> str:
    """What compiled code depends on: heyoka, Python, and the processor's instruction set."""
    return "\n".join([hy.__version__, platform.python_version(), platform.platform(), _processor()])


def _processor() -> str:
    """Return the model and instruction sets of the processor."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:  # not Linux
        return f"{platform.machine()} {platform.processor()}"
    return "\n".join(sorted({line for line in lines if line.startswith(("model name", "flags"))}))


def _safe_directory() -> Path | None:
    try:
        directory = cache_directory()
        directory.mkdir(mode=0o700, parents=True, exist_ok=True)
        status = directory.lstat()
    except (OSError, RuntimeError):  # RuntimeError: the user has no home directory
        return None
    if not stat.S_ISDIR(status.st_mode) or not _is_private(status):
        return None
    return directory


def _is_private(status: os.stat_result) -> bool:
    if not hasattr(os, "getuid"):  # Windows keeps the profile directory private itself
        return True
    return status.st_uid == os.getuid() and not status.st_mode & 0o022


def _read(path: Path, digest: str) -> Any:
    try:
        descriptor = os.open(path, os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0))
        with open(descriptor, "rb") as file:
            status = os.fstat(file.fileno())
            if not stat.S_ISREG(status.st_mode) or not _is_private(status):
                return None
            content = file.read()
    except OSError:
        return None
    header = _MAGIC + digest.encode()
    payload = content[len(header) + _DIGEST_SIZE :]
    seal = content[len(header) : len(header) + _DIGEST_SIZE]
    if not content.startswith(header) or hashlib.sha256(header + payload).digest() != seal:
        return None
    try:
        return pickle.loads(payload)
    except Exception:  # a stale pickle may fail in any way; it is rebuilt
        return None


def _write(path: Path, digest: str, made: Any) -> None:
    header = _MAGIC + digest.encode()
    payload = pickle.dumps(made, protocol=pickle.HIGHEST_PROTOCOL)
    content = header + hashlib.sha256(header + payload).digest() + payload
    temporary = None
    try:
        descriptor, temporary = tempfile.mkstemp(dir=path.parent, prefix=".flow-")
        with open(descriptor, "wb") as file:
            file.write(content)
        os.replace(temporary, path)
    except OSError:  # a full or read-only disk costs time, never a result
        if temporary is not None:
            Path(temporary).unlink(missing_ok=True)
