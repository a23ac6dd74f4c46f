"""A lock that lets one process at a time write into an output folder; the system releases it when its owner ends."""

from __future__ import annotations

import errno
import os
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from planter.errors import InputError

NAME = ".planter.lock"
"""The locked file, which contains the number of the owning process; it is removed when the lock is released."""
_TAKEN = {errno.EACCES, errno.EAGAIN, errno.EWOULDBLOCK, errno.EDEADLK}
_UNSUPPORTED = {errno.ENOSYS, errno.EOPNOTSUPP, errno.ENOLCK}

if sys.platform == "win32":
    import msvcrt

    _LOCKED_BYTE = 1 << 30
    """Offset far behind the content, because Windows lets no process read locked bytes."""

    def _lock(file: int) -> None:
        os.lseek(file, _LOCKED_BYTE, os.SEEK_SET)
        try:
            msvcrt.locking(file, msvcrt.LK_NBLCK, 1)
        finally:
            os.lseek(file, 0, os.SEEK_SET)

    def _release(path: Path, file: int) -> None:
        os.close(file)
        with suppress(OSError):  # another process has opened the file and owns it now
            path.unlink()
else:
    import fcntl

    def _lock(file: int) -> None:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)

    def _release(path: Path, file: int) -> None:
        with suppress(OSError):  # name first, lock second: a process that has opened the file sees its removal
            path.unlink()
        os.close(file)


@contextmanager
def lock_folder(folder: Path) -> Iterator[None]:
    """Lock a folder, within the context, against other processes and other threads; the lock ends with its process.

    A warning is issued if the file system has no locks. Raises InputError, naming folder and process, if the folder is
    locked, and OSError if the lock file cannot be created.
    """
    path = folder / NAME
    file = _open_locked(path)
    try:
        os.ftruncate(file, 0)
        os.lseek(file, 0, os.SEEK_SET)
        os.write(file, f"{os.getpid()}\n".encode())
        yield
    finally:
        _release(path, file)


def _open_locked(path: Path) -> int:
    """Return a descriptor of the locked file; a file that its last owner has just removed is created again."""
    while True:
        file = os.open(path, os.O_RDWR | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0), 0o666)
        try:
            _take(path, file)
            if os.fstat(file).st_nlink:
                return file
        except BaseException:
            os.close(file)
            raise
        os.close(file)


def _take(path: Path, file: int) -> None:
    """Lock a file. Raises InputError if another process owns it, or if planter did not write it."""
    error_number = 0
    try:
        _lock(file)
    except OSError as error:
        if error.errno not in _TAKEN | _UNSUPPORTED:
            raise
        error_number = error.errno or 0
    content = os.read(file, 32).decode(errors="replace").strip()
    if error_number in _TAKEN:
        process = f"process {content}" if content.isdigit() else "another process"
        allowed = "wait until it has ended, or choose another --out"
        raise InputError(f"{path.parent}: {process} is writing into this folder; {allowed}")
    if content and not content.isdigit():
        raise InputError(
            f"{path}: planter did not write this file and does not overwrite it; remove it, or choose another --out"
        )
    if error_number in _UNSUPPORTED:
        warning = f"{path.parent}: this file system has no locks; run one command at a time on this folder"
        warnings.warn(warning, RuntimeWarning, stacklevel=2)
