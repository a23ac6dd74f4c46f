"""One process at a time writes into the folder of a result: a lock that the operating system ends with its owner."""

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
"""The locked file, which holds the number of the owning process; it is removed when the folder is free again."""
_TAKEN = {errno.EACCES, errno.EAGAIN, errno.EWOULDBLOCK, errno.EDEADLK}
_UNSUPPORTED = {errno.ENOSYS, errno.EOPNOTSUPP, errno.ENOLCK}

if sys.platform == "win32":
    import msvcrt

    _LOCKED_BYTE = 1 << 30
    """Far behind the content: Windows lets nobody read what is locked."""

    def _lock(file: int) -> None:
        os.lseek(file, _LOCKED_BYTE, os.SEEK_SET)
        try:
            msvcrt.locking(file, msvcrt.LK_NBLCK, 1)
        finally:
            os.lseek(file, 0, os.SEEK_SET)

    def _release(path: Path, file: int) -> None:
        os.close(file)
        with suppress(OSError):  # another process has opened it: the file is that one's now
            path.unlink()
else:
    import fcntl

    def _lock(file: int) -> None:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)

    def _release(path: Path, file: int) -> None:
        with suppress(OSError):  # first the name, then the lock: whoever has opened the file sees that it has gone
            path.unlink()
        os.close(file)


@contextmanager
def lock_folder(folder: Path) -> Iterator[None]:
    """Within, no other process, and no other thread of this one, owns the folder. The lock ends with its process.

    Where the file system has no locks, a warning says so. Raises InputError, naming folder and process, if the folder
    has an owner, and OSError if the lock's file cannot be made.
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
    """A descriptor of the file of this name, locked; a file that its last owner has just removed is made again."""
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
    """Lock a file. Raises InputError if it has an owner, or if it is no file of planter's."""
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
        told = f"{path.parent}: this file system has no locks, let one command at a time write there"
        warnings.warn(told, RuntimeWarning, stacklevel=2)
