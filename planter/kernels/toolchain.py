"""Shared libraries compiled from C text, in the user's private cache.

A library is named by the hash of its C text, the compiler, its flags and the processor, and ends
with the hash of its bytes, so that a damaged one is noticed and built again. It is put in its place
in one step: processes that start together never see half of it. A library runs when it is loaded,
so nobody else may be able to write to the folder.
"""

from __future__ import annotations

import ctypes
import errno
import hashlib
import logging
import os
import platform
import stat
import subprocess
from functools import cache
from pathlib import Path
from typing import Any

from planter.kernels import builds, compiler
from planter.kernels.compiler import CompilerError, find_compiler

OPEN_FLAGS = (
    getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_CLOEXEC", 0)
)
"""To open what may be a link, or a pipe that nobody writes to."""
DIGEST_BYTES = 32


class RefusedFileError(CompilerError):
    """Something that others could have put there; the message names it and says why."""


def cache_path() -> Path:
    """Return the cache of compiled functions: PLANTER_CACHE, else `planter` in XDG_CACHE_HOME, else
    `~/.cache/planter`.

    A relative XDG_CACHE_HOME does not count, as the XDG Base Directory Specification has it.
    Raises RuntimeError for a user without a home.
    """
    named, base = os.environ.get("PLANTER_CACHE"), os.environ.get("XDG_CACHE_HOME", "")
    if named:
        return Path(named).absolute()
    return (Path(base) if os.path.isabs(base) else Path.home() / ".cache") / "planter"


def cache_folder() -> Path:
    """The user's private folder of compiled functions, `cache_path` without links, made where it is
    missing.

    Raises CompilerError if it cannot be made, RefusedFileError if others could write to it or
    replace it.
    """
    try:
        _make(cache_path())
        folder = cache_path().resolve(strict=True)
        reasons = [_explain_foreign(folder.stat()), *map(_explain_exposed, folder.parents)]
    except (OSError, RuntimeError) as error:
        raise CompilerError(f"there is no folder for compiled functions: {error}") from error
    for place, reason in zip((folder, *folder.parents), reasons, strict=True):
        if reason:
            raise RefusedFileError(
                f"the folder for compiled functions, {folder}, is open to other users: {place} "
                f"{reason}"
            )
    if not os.access(folder, os.W_OK | os.X_OK):
        raise CompilerError(f"the folder for compiled functions, {folder}, cannot be written")
    return folder


def _make(folder: Path) -> None:
    """Private, as all that is missing above it."""
    if not folder.parent.exists():
        _make(folder.parent)
    folder.mkdir(mode=0o700, exist_ok=True)


def is_intact(path: Path) -> bool:
    """Return whether a library exists and is as written.

    Raises RefusedFileError if others could have written it.
    """
    content = _content(path)
    return (
        content is not None and compute_digest(content[:-DIGEST_BYTES]) == content[-DIGEST_BYTES:]
    )


def compute_digest(content: bytes) -> bytes:
    """Return the digest that follows the bytes of a library."""
    return hashlib.sha256(content).digest()


def _content(path: Path) -> bytes | None:
    """Return the bytes of a file that the user owns, or None if it does not exist."""
    try:
        content, reason = _read(path)
    except FileNotFoundError:
        return None
    except OSError as error:
        reason = "is a link" if path.is_symlink() else f"cannot be read: {error.strerror}"
    if reason:
        raise RefusedFileError(f"{path} is not loaded: it {reason}")
    return content


def _read(path: Path) -> tuple[bytes, str]:
    """Return the bytes of a regular file, or the reason why they are not read."""
    descriptor = os.open(path, os.O_RDONLY | OPEN_FLAGS)
    try:
        state = os.fstat(descriptor)
        reason = _explain_foreign(state) if stat.S_ISREG(state.st_mode) else "is no file"
        if reason:
            return b"", reason
        with open(descriptor, "rb", closefd=False) as file:
            return file.read(), ""
    finally:
        os.close(descriptor)


def _explain_foreign(state: os.stat_result) -> str:
    """Why something is not the user's alone; empty if it is."""
    if not hasattr(os, "getuid"):
        return ""
    if state.st_uid != os.getuid():
        return "belongs to another user"
    return "may be written by others" if _is_writable_by_others(state) else ""


def _explain_exposed(parent: Path) -> str:
    """Why others could put something else in the place of what is in a folder; empty if they could
    not.

    Root may, whoever owns all folders may, and in a sticky folder everybody keeps his own.
    """
    if not hasattr(os, "getuid"):
        return ""
    state = parent.stat()
    if state.st_uid not in (os.getuid(), 0, os.stat("/").st_uid):
        return "belongs to another user"
    return (
        "may be written by others"
        if _is_writable_by_others(state) and not state.st_mode & stat.S_ISVTX
        else ""
    )


def _is_writable_by_others(state: os.stat_result) -> bool:
    return bool(
        state.st_mode & stat.S_IWOTH
        or (state.st_mode & stat.S_IWGRP and not _is_private_group(state.st_gid))
    )


@cache
def _is_private_group(group: int) -> bool:
    """Whether a group is the user's private one: of his name, with nobody else in it."""
    import grp
    import pwd

    try:
        entry, user = grp.getgrgid(group), pwd.getpwuid(os.getuid()).pw_name
    except KeyError:
        return False
    return entry.gr_name == user and set(entry.gr_mem) <= {user}


TIMEOUT_S = 300
OPTIMISED = ("-O3",)
FEW_PASSES = ("-O1", "-ftree-vectorize")
"""For large functions: vectors, without the passes that take minutes."""
FAST_MATH = ("-ffast-math",)
"""For compiling, never for linking: there it would set the processor to flush subnormal numbers,
for the process.
"""
DISK_FULL = {number: os.strerror(number) for number in (errno.ENOSPC, errno.EDQUOT)}
"""A disk that takes no more, in the words of compilers."""
_full_folders: set[Path] = set()
"""Folders that took no more; they are not tried again."""


def loop_flags(passes: tuple[str, ...]) -> tuple[str, ...]:
    """Flags for a loop over lanes, `OPTIMISED` or `SWIFT`, besides those of all functions.

    Raises CompilerError.
    """
    return (*passes, *FAST_MATH, *(find_compiler().order if passes == OPTIMISED else ()))


def build_library(
    name: str, source: str, flags: tuple[str, ...], needed: tuple[Path, ...] = ()
) -> Path:
    """The shared library of a C text, linked to others: from the cache or built now.

    Raises CompilerError.
    """
    path = library_path(name, source, (*flags, *map(str, needed)))
    if is_intact(path):
        return path
    if path.parent in _full_folders:
        raise CompilerError(_describe_full_disk(path))
    try:
        _compile_library(source, path, flags, needed)
    except (OSError, subprocess.SubprocessError) as error:
        # another process was first, and Windows does not replace a loaded library
        if isinstance(error, OSError) and is_intact(path):
            return path
        if _is_disk_full(error):
            _full_folders.add(path.parent)
            raise CompilerError(_describe_full_disk(path)) from error
        raise CompilerError(_describe_failure(name, error)) from error
    return path


def _is_disk_full(error: Exception) -> bool:
    message = getattr(error, "stderr", None) or b""
    return getattr(error, "errno", None) in DISK_FULL or any(
        words.encode() in message for words in DISK_FULL.values()
    )


def _describe_full_disk(path: Path) -> str:
    return f"there is no space for compiled functions in {path.parent}"


def _describe_failure(name: str, error: Exception) -> str:
    if isinstance(error, subprocess.TimeoutExpired):
        return f"{find_compiler().path} did not compile {name} within {TIMEOUT_S} s"
    if not isinstance(error, subprocess.CalledProcessError):
        return f"{name} could not be compiled: {error}"
    return f"{find_compiler().path} did not compile {name}: {summarise_error(error)}"


def library_path(name: str, source: str, flags: tuple[str, ...]) -> Path:
    """Return the path of the library of a C text, whether or not it exists.

    Raises CompilerError.
    """
    active = find_compiler()
    parts = [*active.command, active.version, *active.flags, *flags, _describe_processor(), source]
    key = hashlib.sha256("\0".join(parts).encode(errors="surrogateescape")).hexdigest()
    return cache_folder() / f"{name}-{key[:32]}{compiler.current_platform().suffix}"


def load_library(path: Path) -> ctypes.CDLL:
    """Load a library.

    Raises CompilerError if the system refuses it, as on a disk that forbids execution.
    """
    try:
        return ctypes.CDLL(str(path))
    except OSError as error:
        raise CompilerError(f"{path} cannot be loaded: {error}") from error


def load_functions(path: Path, *names: str) -> list[Any]:
    """Load a library and return some of its functions.

    Raises CompilerError, or RefusedFileError if it lacks one.

    What a library does as it is loaded does not happen where already its bytes lack a name.
    """
    try:
        content = path.read_bytes()
        # names stand in the bytes: nothing of a strange library needs to run to tell
        if all(name.encode() + b"\0" in content for name in names):
            raw = load_library(path)
            return [getattr(raw, name) for name in names]
    except OSError as error:
        raise CompilerError(f"{path} cannot be read: {error}") from error
    except AttributeError:
        pass
    raise RefusedFileError(f"{path} is not used: it lacks one of the functions {', '.join(names)}")


def _compile_library(
    source: str, path: Path, flags: tuple[str, ...], needed: tuple[Path, ...]
) -> None:
    active, system = find_compiler(), compiler.current_platform()
    variables = compiler.bundled_variables(path.parent) if active.bundled else {}
    if active.bundled:
        announce_preparation(path.parent)
    with builds.scratch_folder(path.parent) as folder:
        text, compiled, linked = (folder / name for name in ("kernel.c", "kernel.o", path.name))
        text.write_text(source, encoding="utf-8")
        for command in (
            system.compile(active.command, (*flags, *active.flags), text, compiled),
            system.link(active.command, compiled, linked, path, needed),
        ):
            builds.run_program(command, TIMEOUT_S, folder, variables)
        content = linked.read_bytes()
        # the loader ignores what follows the sections of a library
        linked.write_bytes(content + compute_digest(content))
        linked.chmod(0o700)
        # in one step: who looks sees no library or a whole one
        linked.replace(path)
    if active.bundled:
        compiler.mark_prepared(path.parent)


def announce_preparation(folder: Path, target: str = compiler.THIS_SYSTEM) -> None:
    """Say, before its first use for a target, how long the bundled compiler takes more; `folder` is
    the cache.
    """
    if not compiler.is_prepared(folder, target):
        logging.getLogger("planter").warning(
            "planter: the compiler of planter[compiler] prepares itself%s, once: this takes about "
            "%d s",
            f" for {target}" if target else "",
            compiler.preparation_time_s(target),
        )


def run_bundled(target: str, command: list[str], folder: Path) -> None:
    """A step of the bundled compiler for another system; a folder is where it may leave something
    for a while.

    Raises CompilerError, OSError, or SubprocessError.
    """
    cache = cache_folder()
    announce_preparation(cache, target)
    builds.run_program(command, TIMEOUT_S, folder, compiler.bundled_variables(cache))
    compiler.mark_prepared(cache, target)


def summarise_error(error: Exception) -> str:
    """Return the errors of a compiler in a line."""
    lines = (getattr(error, "stderr", None) or b"").decode(errors="replace").strip().splitlines()
    return next((line for line in lines if "error" in line), lines[0] if lines else str(error))


@cache
def _describe_processor() -> str:
    """Return a description that distinguishes processors with different instructions."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    features = [line for line in lines if line.startswith(("flags", "Features", "model name"))]
    return "\n".join([platform.machine(), platform.processor(), *sorted(set(features))])


_warnings: list[str] = []


def warn_once(reason: CompilerError) -> None:
    """Say, once for a process and once for each thing that is refused, that everything works, but
    slower.
    """
    key = str(reason) if isinstance(reason, RefusedFileError) else ""
    if key not in _warnings:
        _warnings.append(key)
        logging.getLogger("planter").warning(
            "planter: slower without compiled functions: %s", reason
        )
