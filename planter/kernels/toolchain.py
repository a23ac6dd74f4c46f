"""Libraries compiled from C text and kept in the user's cache.

A library is kept under the hash of its C text, the compiler, its flags and the processor, with the hash of its own
bytes behind them, so that a damaged one is seen and built again. It is put in its place in one step: processes that
start together do not see half of it.
"""

from __future__ import annotations

import ctypes
import errno
import hashlib
import logging
import os
import platform
import subprocess
from functools import cache
from pathlib import Path
from typing import Any

from planter.kernels import builds, bundled, platforms
from planter.kernels.cache import Refused, cache_folder, cache_path, digest, sound
from planter.kernels.compiler import Compiler, NoCompiler, compiler

__all__ = [
    "FAST_MATH", "OPTIMISED", "SWIFT", "Compiler", "NoCompiler", "Refused", "announce", "cache_folder", "cache_path",
    "compiler", "functions", "library", "load", "loop_flags", "place", "run_for", "said", "sound", "warn",
]  # fmt: skip

TIMEOUT_S = 300
OPTIMISED = ("-O3",)
SWIFT = ("-O1", "-ftree-vectorize")
"""For large functions: vectors, without the passes that take minutes."""
FAST_MATH = ("-ffast-math",)
"""For compiling, never for linking: there it would set the processor to flush subnormal numbers, for the process."""
FULL = {number: os.strerror(number) for number in (errno.ENOSPC, errno.EDQUOT)}
"""A disk that takes no more, in the words of compilers."""
_full: set[Path] = set()
"""Folders that took no more; they are not tried again."""


def loop_flags(passes: tuple[str, ...]) -> tuple[str, ...]:
    """Flags for a loop over lanes, `OPTIMISED` or `SWIFT`, beside those of all functions. Raises NoCompiler."""
    return (*passes, *FAST_MATH, *(compiler().order if passes == OPTIMISED else ()))


def library(name: str, source: str, flags: tuple[str, ...], needed: tuple[Path, ...] = ()) -> Path:
    """The shared library of a C text, linked to others: from the cache or built now. Raises NoCompiler."""
    path = place(name, source, (*flags, *map(str, needed)))
    if sound(path):
        return path
    if path.parent in _full:
        raise NoCompiler(_no_room(path))
    try:
        _build(source, path, flags, needed)
    except (OSError, subprocess.SubprocessError) as error:
        if isinstance(error, OSError) and sound(path):  # another process was first, and Windows holds what it loaded
            return path
        if _took_no_more(error):
            _full.add(path.parent)
            raise NoCompiler(_no_room(path)) from error
        raise NoCompiler(_why(name, error)) from error
    return path


def _took_no_more(error: Exception) -> bool:
    said = getattr(error, "stderr", None) or b""
    return getattr(error, "errno", None) in FULL or any(words.encode() in said for words in FULL.values())


def _no_room(path: Path) -> str:
    return f"there is no room for compiled functions in {path.parent}"


def _why(name: str, error: Exception) -> str:
    if isinstance(error, subprocess.TimeoutExpired):
        return f"{compiler().path} did not compile {name} within {TIMEOUT_S} s"
    if not isinstance(error, subprocess.CalledProcessError):
        return f"{name} could not be compiled: {error}"
    said = error.stderr.decode(errors="replace").strip().splitlines() or ["it gave no reason"]
    return f"{compiler().path} did not compile {name}: {next((line for line in said if 'error' in line), said[0])}"


def place(name: str, source: str, flags: tuple[str, ...]) -> Path:
    """Where the library of a C text is kept, whether it is there or not. Raises NoCompiler."""
    found = compiler()
    parts = [*found.command, found.version, *found.flags, *flags, _processor(), source]
    key = hashlib.sha256("\0".join(parts).encode(errors="surrogateescape")).hexdigest()
    return cache_folder() / f"{name}-{key[:32]}{platforms.here().suffix}"


def load(path: Path) -> ctypes.CDLL:
    """A library in this process. Raises NoCompiler where the system refuses it, as on a disk that forbids execution."""
    try:
        return ctypes.CDLL(str(path))
    except OSError as error:
        raise NoCompiler(f"{path} cannot be loaded: {error}") from error


def functions(path: Path, *names: str) -> list[Any]:
    """Functions of a library, which is loaded. Raises NoCompiler, or Refused for a library that has not all of them.

    What a library does as it is loaded does not happen where already its bytes lack a name.
    """
    try:
        content = path.read_bytes()
        if all(name.encode() + b"\0" in content for name in names):
            raw = load(path)
            return [getattr(raw, name) for name in names]
    except OSError as error:
        raise NoCompiler(f"{path} cannot be read: {error}") from error
    except AttributeError:
        pass
    raise Refused(f"{path} is not used: it lacks one of the functions {', '.join(names)}")


def _build(source: str, path: Path, flags: tuple[str, ...], needed: tuple[Path, ...]) -> None:
    found, system = compiler(), platforms.here()
    variables = bundled.variables(path.parent) if found.bundled else {}
    if found.bundled:
        announce(path.parent)
    with builds.scratch(path.parent) as folder:
        text, compiled, linked = (folder / name for name in ("kernel.c", "kernel.o", path.name))
        text.write_text(source, encoding="utf-8")
        for command in (
            system.compile(found.command, (*flags, *found.flags), text, compiled),
            system.link(found.command, compiled, linked, path, needed),
        ):
            builds.run(command, TIMEOUT_S, folder, variables)
        content = linked.read_bytes()
        linked.write_bytes(content + digest(content))
        linked.chmod(0o700)
        linked.replace(path)
    if found.bundled:
        bundled.keep(path.parent)


def announce(folder: Path, target: str = bundled.HERE) -> None:
    """Say, before its first use for a target, how long the bundled compiler takes more; `folder` is the cache."""
    if not bundled.prepared(folder, target):
        logging.getLogger("planter").warning(
            "planter: the compiler of planter[compiler] prepares itself%s, once: this takes about %d s",
            f" for {target}" if target else "",
            bundled.preparation_s(target),
        )


def run_for(target: str, command: list[str], folder: Path) -> None:
    """A step of the bundled compiler for another system; a folder is where it may leave something for a while.

    Raises NoCompiler, OSError, or SubprocessError.
    """
    cache = cache_folder()
    announce(cache, target)
    builds.run(command, TIMEOUT_S, folder, bundled.variables(cache))
    bundled.keep(cache, target)


def said(error: Exception) -> str:
    """What a compiler says is wrong, in a line."""
    lines = (getattr(error, "stderr", None) or b"").decode(errors="replace").strip().splitlines()
    return next((line for line in lines if "error" in line), lines[0] if lines else str(error))


@cache
def _processor() -> str:
    """What tells processors apart that understand different instructions."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    known = [line for line in lines if line.startswith(("flags", "Features", "model name"))]
    return "\n".join([platform.machine(), platform.processor(), *sorted(set(known))])


_warned: list[str] = []


def warn(reason: NoCompiler) -> None:
    """Say, once for a process and once for each thing that is refused, that everything works, but slower."""
    key = str(reason) if isinstance(reason, Refused) else ""
    if key not in _warned:
        _warned.append(key)
        logging.getLogger("planter").warning("planter: slower without compiled functions: %s", reason)
