"""The C compiler, where there is one, and the user's cache of what it compiled.

A library is kept under the hash of its C text, the compiler, its flags and the processor, with the hash of its own
bytes behind them, so that a damaged one is seen and built again. It is put in its place in one step: processes that
start together do not see half of it.
"""

from __future__ import annotations

import ctypes
import hashlib
import logging
import os
import platform
import shutil
import stat
import subprocess
import tempfile
import threading
from dataclasses import dataclass
from functools import cache
from pathlib import Path

TIMEOUT_S = 300
MACHINE_FLAGS = ("-march=native", "-mprefer-vector-width=512", "-fveclib=libmvec")
"""Wanted where the compiler knows them: the processor's own instructions, whole vectors, clang's vector library."""
ORDER_FLAGS = ("-fschedule-insns", "-fsched-pressure", "--param=sched-pressure-algorithm=2")
"""Wanted for loops but the largest: an order of instructions that keeps fewer values waiting, a tenth faster."""
OPTIMISED = ("-O3",)
SWIFT = ("-O1", "-ftree-vectorize")
"""For large functions: vectors, without the passes that take minutes."""
FAST_MATH = ("-ffast-math",)
"""For compiling, never for linking: there it would set the processor to flush subnormal numbers, for the process."""


class NoCompiler(Exception):
    """Nothing can be compiled, kept or loaded here; the message says why."""


@dataclass(frozen=True)
class Compiler:
    """A C compiler: its path, its version in a line, which of `MACHINE_FLAGS` it takes, and which of `ORDER_FLAGS`."""

    path: str
    version: str
    flags: tuple[str, ...]
    order: tuple[str, ...] = ()


def compiler() -> Compiler:
    """The compiler that the variable CC names, else `cc`. Raises NoCompiler."""
    return _compiler(os.environ.get("CC", "cc"))


@cache
def _compiler(name: str) -> Compiler:
    path = shutil.which(name) if name else None
    if path is None:
        raise NoCompiler(f"there is no C compiler {name!r}" if name else "the variable CC is empty")
    try:
        answer = subprocess.run([path, "--version"], capture_output=True, text=True, check=True)
    except (OSError, subprocess.CalledProcessError) as error:
        raise NoCompiler(f"the C compiler {path} does not run") from error
    version = answer.stdout.partition("\n")[0]
    flags, order = (tuple(f for f in wanted if _takes(path, f)) for wanted in (MACHINE_FLAGS, ORDER_FLAGS))
    return Compiler(path, version, flags, order)


def _takes(path: str, flag: str) -> bool:
    command = [path, "-Werror", flag, "-x", "c", "-S", "-o", os.devnull, os.devnull]
    return subprocess.run(command, capture_output=True, check=False).returncode == 0


def loop_flags(passes: tuple[str, ...]) -> tuple[str, ...]:
    """Flags for a loop over lanes, `OPTIMISED` or `SWIFT`, beside those of all functions. Raises NoCompiler."""
    return (*passes, *FAST_MATH, *(compiler().order if passes == OPTIMISED else ()))


def library(name: str, source: str, flags: tuple[str, ...], needed: tuple[Path, ...] = ()) -> Path:
    """The shared library of a C text, linked to others: from the cache or built now. Raises NoCompiler."""
    path = place(name, source, (*flags, *map(str, needed)))
    try:
        if not sound(path):
            _build(source, path, flags, needed)
    except subprocess.CalledProcessError as error:
        said = error.stderr.decode(errors="replace").strip().splitlines() or ["it gave no reason"]
        reason = next((line for line in said if "error" in line), said[0])
        raise NoCompiler(f"{compiler().path} did not compile {name}: {reason}") from error
    except (OSError, subprocess.SubprocessError) as error:
        raise NoCompiler(f"{name} could not be compiled: {error}") from error
    return path


def place(name: str, source: str, flags: tuple[str, ...]) -> Path:
    """Where the library of a C text is kept, whether it is there or not. Raises NoCompiler."""
    found = compiler()
    parts = [found.path, found.version, *found.flags, *flags, _processor(), source]
    key = hashlib.sha256("\0".join(parts).encode()).hexdigest()
    return cache_folder() / f"{name}-{key[:32]}.so"


def load(path: Path) -> ctypes.CDLL:
    """A library in this process. Raises NoCompiler where the system refuses it, as on a disk that forbids execution."""
    try:
        return ctypes.CDLL(str(path))
    except OSError as error:
        raise NoCompiler(f"{path} cannot be loaded: {error}") from error


def sound(path: Path) -> bool:
    """Whether a library is there and is what was written."""
    try:
        content = path.read_bytes()
    except FileNotFoundError:
        return False
    return hashlib.sha256(content[:-32]).digest() == content[-32:]


def _build(source: str, path: Path, flags: tuple[str, ...], needed: tuple[Path, ...]) -> None:
    found = compiler()
    with tempfile.TemporaryDirectory(prefix="planter-") as scratch:
        text, compiled, linked = (Path(scratch) / name for name in ("kernel.c", "kernel.o", "kernel.so"))
        text.write_text(source, encoding="utf-8")
        _run([found.path, "-std=gnu99", *flags, *found.flags, "-fPIC", "-c", str(text), "-o", str(compiled)])
        _run([found.path, "-shared", str(compiled), "-o", str(linked), *map(str, needed), "-lm"])
        content = linked.read_bytes()
    beside = path.with_suffix(f".{os.getpid()}-{threading.get_ident()}")
    beside.write_bytes(content + hashlib.sha256(content).digest())
    beside.chmod(0o700)
    beside.replace(path)


def _run(command: list[str]) -> None:
    subprocess.run(command, capture_output=True, check=True, timeout=TIMEOUT_S, stdin=subprocess.DEVNULL)


@cache
def _processor() -> str:
    """What tells processors apart that understand different instructions."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    known = [line for line in lines if line.startswith(("flags", "Features", "model name"))]
    return "\n".join([platform.machine(), platform.processor(), *sorted(set(known))])


def cache_path() -> Path:
    """Where compiled functions are kept: PLANTER_CACHE, else `planter` in XDG_CACHE_HOME, else `~/.cache/planter`.

    Raises RuntimeError for a user without a home.
    """
    named = os.environ.get("PLANTER_CACHE")
    folder = Path(named) if named else Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "planter"
    return folder.absolute()


def cache_folder() -> Path:
    """The user's private folder of compiled functions, `cache_path`, made where it is missing.

    Raises NoCompiler where it cannot be made, or where others could put something into it.
    """
    try:
        folder = cache_path()
        folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        state = folder.stat()
    except (OSError, RuntimeError) as error:
        raise NoCompiler(f"there is no folder for compiled functions: {error}") from error
    if hasattr(os, "getuid") and (state.st_uid != os.getuid() or state.st_mode & stat.S_IWOTH):
        raise NoCompiler(f"the folder for compiled functions, {folder}, is open to other users")
    if not os.access(folder, os.W_OK | os.X_OK):
        raise NoCompiler(f"the folder for compiled functions, {folder}, cannot be written")
    return folder


_warned: list[str] = []


def warn(reason: str) -> None:
    """Say, once for a process, that everything works, but slower."""
    if not _warned:
        _warned.append(reason)
        logging.getLogger("planter").warning("planter: slower without compiled functions: %s", reason)
