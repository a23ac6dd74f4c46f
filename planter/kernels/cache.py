"""The user's private folder of compiled functions: what is loaded runs, so nobody else may have put it there."""

from __future__ import annotations

import hashlib
import os
import stat
from functools import cache
from pathlib import Path

from planter.kernels.compiler import NoCompiler

ASIDE = getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_CLOEXEC", 0)
"""To open what may be a link, or a pipe that nobody writes to."""
DIGEST_BYTES = 32


class Refused(NoCompiler):
    """Something that others could have put there; the message names it and says why."""


def cache_path() -> Path:
    """Where compiled functions are kept: PLANTER_CACHE, else `planter` in XDG_CACHE_HOME, else `~/.cache/planter`.

    A relative XDG_CACHE_HOME does not count, as the XDG Base Directory Specification has it.
    Raises RuntimeError for a user without a home.
    """
    named, base = os.environ.get("PLANTER_CACHE"), os.environ.get("XDG_CACHE_HOME", "")
    if named:
        return Path(named).absolute()
    return (Path(base) if os.path.isabs(base) else Path.home() / ".cache") / "planter"


def cache_folder() -> Path:
    """The user's private folder of compiled functions, `cache_path` without links, made where it is missing.

    Raises NoCompiler where it cannot be made, Refused where others could put something into it or in its place.
    """
    try:
        _make(cache_path())
        folder = cache_path().resolve(strict=True)
        reasons = [_foreign(folder.stat()), *map(_exposed, folder.parents)]
    except (OSError, RuntimeError) as error:
        raise NoCompiler(f"there is no folder for compiled functions: {error}") from error
    for place, reason in zip((folder, *folder.parents), reasons, strict=True):
        if reason:
            raise Refused(f"the folder for compiled functions, {folder}, is open to other users: {place} {reason}")
    if not os.access(folder, os.W_OK | os.X_OK):
        raise NoCompiler(f"the folder for compiled functions, {folder}, cannot be written")
    return folder


def _make(folder: Path) -> None:
    """Private, as all that is missing above it."""
    if not folder.parent.exists():
        _make(folder.parent)
    folder.mkdir(mode=0o700, exist_ok=True)


def sound(path: Path) -> bool:
    """Whether a library is there and is what was written. Raises Refused for what others could have put there."""
    content = _content(path)
    return content is not None and digest(content[:-DIGEST_BYTES]) == content[-DIGEST_BYTES:]


def digest(content: bytes) -> bytes:
    """What stands behind the bytes of a library."""
    return hashlib.sha256(content).digest()


def _content(path: Path) -> bytes | None:
    """The bytes of a user's own file; None where there is nothing."""
    try:
        content, reason = _read(path)
    except FileNotFoundError:
        return None
    except OSError as error:
        reason = "is a link" if path.is_symlink() else f"cannot be read: {error.strerror}"
    if reason:
        raise Refused(f"{path} is not loaded: it {reason}")
    return content


def _read(path: Path) -> tuple[bytes, str]:
    """The bytes of what is no link, or why they are not read."""
    descriptor = os.open(path, os.O_RDONLY | ASIDE)
    try:
        state = os.fstat(descriptor)
        reason = _foreign(state) if stat.S_ISREG(state.st_mode) else "is no file"
        if reason:
            return b"", reason
        with open(descriptor, "rb", closefd=False) as file:
            return file.read(), ""
    finally:
        os.close(descriptor)


def _foreign(state: os.stat_result) -> str:
    """Why something is not the user's alone; empty if it is."""
    if not hasattr(os, "getuid"):
        return ""
    if state.st_uid != os.getuid():
        return "belongs to another user"
    return "may be written by others" if _writable(state) else ""


def _exposed(parent: Path) -> str:
    """Why others could put something else in the place of what is in a folder; empty if they could not.

    Root may, whoever owns all folders may, and in a sticky folder everybody keeps his own.
    """
    if not hasattr(os, "getuid"):
        return ""
    state = parent.stat()
    if state.st_uid not in (os.getuid(), 0, os.stat("/").st_uid):
        return "belongs to another user"
    return "may be written by others" if _writable(state) and not state.st_mode & stat.S_ISVTX else ""


def _writable(state: os.stat_result) -> bool:
    return bool(state.st_mode & stat.S_IWOTH or (state.st_mode & stat.S_IWGRP and not _alone(state.st_gid)))


@cache
def _alone(group: int) -> bool:
    """Whether a group is the user's private one: of his name, with nobody else in it."""
    import grp
    import pwd

    try:
        found, user = grp.getgrgid(group), pwd.getpwuid(os.getuid()).pw_name
    except KeyError:
        return False
    return found.gr_name == user and set(found.gr_mem) <= {user}
