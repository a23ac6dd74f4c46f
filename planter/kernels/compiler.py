"""The C compiler: how it is called, its version, the flags that it accepts, and what a shared
library needs.

Without a C compiler, the extra `compiler` provides one: clang, with headers and libraries of many
systems, as `zig cc`. On its first use for a system it builds its libraries, and stores them next to
the compiled functions.
"""

from __future__ import annotations

import importlib.util
import os
import platform
import shlex
import shutil
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

from planter.kernels import builds


@dataclass(frozen=True)
class Platform:
    """A system: how names of its shared libraries end, what its compilers take to compile and to
    link one.

    `placed` is a flag that writes into a library where others find it; elsewhere the name it is
    linked under says it.
    """

    suffix: str
    compiling: tuple[str, ...] = ()
    linking: tuple[str, ...] = ()
    placed: str = ""

    def compile(
        self, command: Sequence[str], flags: Sequence[str], source: Path, compiled: Path
    ) -> list[str]:
        """The command that compiles a C text for a library."""
        return [
            *command,
            "-std=gnu99",
            *flags,
            *self.compiling,
            "-c",
            str(source),
            "-o",
            str(compiled),
        ]

    def link(
        self,
        command: Sequence[str],
        compiled: Path,
        linked: Path,
        place: Path,
        needed: Sequence[Path] = (),
    ) -> list[str]:
        """The command that links a library, for the `place` that it will have, to others."""
        placed = [self.placed + str(place)] if self.placed else []
        return [
            *command,
            "-shared",
            str(compiled),
            "-o",
            str(linked),
            *placed,
            *map(str, needed),
            *self.linking,
        ]


LINUX = Platform(".so", ("-fPIC",), ("-lm",))
MACOS = Platform(".dylib", ("-fPIC",), ("-lm",), "-Wl,-install_name,")
WINDOWS = Platform(".dll")
"""There every text is compiled for any place, and the C library has the mathematics."""
_BY_SYSTEM = {"darwin": MACOS, "win32": WINDOWS}


def current_platform() -> Platform:
    """The system that this process runs on."""
    return _BY_SYSTEM.get(sys.platform, LINUX)


def vector_library_flags() -> tuple[str, ...]:
    """The flag of clang for mathematics in vectors where the C library has them, which is GNU's
    alone.
    """
    return ("-fveclib=libmvec",) if platform.libc_ver()[0] == "glibc" else ()


THIS_SYSTEM = ""
"""The target that stands for this system."""
PREPARATION_S = {THIS_SYSTEM: 20, "x86_64-windows-gnu": 100, "wasm32-wasi": 20}
"""How long its first use for a target takes beside what is compiled, measured on two cores; others
as this one.
"""
CACHE_VARIABLE = "ZIG_GLOBAL_CACHE_DIR"
"""The variable that names the folder where it keeps what it builds for itself."""


def bundled_command(target: str = THIS_SYSTEM) -> tuple[str, ...]:
    """Return the words that call the bundled compiler, for another system by its target; empty
    without the extra.
    """
    spec = importlib.util.find_spec("ziglang")
    if spec is None or spec.origin is None:
        return ()
    program = "zig.exe" if current_platform() is WINDOWS else "zig"
    return str(Path(spec.origin).parent / program), "cc", *(("-target", target) if target else ())


def bundled_variables(cache: Path) -> dict[str, str]:
    """Return variables of its environment: it builds its libraries in the cache unless the user
    names a folder.
    """
    return {CACHE_VARIABLE: os.environ.get(CACHE_VARIABLE) or str(cache / "zig")}


def preparation_time_s(target: str = THIS_SYSTEM) -> int:
    """Return the approximate time of its first use for a target [s]."""
    return PREPARATION_S.get(target, PREPARATION_S[THIS_SYSTEM])


def is_prepared(cache: Path, target: str = THIS_SYSTEM) -> bool:
    """Whether it has built its libraries for a target."""
    return _mark_path(cache, target).exists()


def mark_prepared(cache: Path, target: str = THIS_SYSTEM) -> None:
    """Note that it has."""
    mark = _mark_path(cache, target)
    mark.parent.mkdir(parents=True, exist_ok=True)
    mark.touch()


def _mark_path(cache: Path, target: str) -> Path:
    return Path(bundled_variables(cache)[CACHE_VARIABLE]) / f"planter-{target or 'here'}"


PROBE_TIMEOUT_S = 20
"""How long a compiler may take to say its version, or whether it takes a flag."""
MACHINE_FLAGS = ("-march=native", "-mprefer-vector-width=512", *vector_library_flags())
"""Wanted where the compiler knows them: the processor's own instructions, whole vectors, clang's
vector library.
"""
ORDER_FLAGS = ("-fschedule-insns", "-fsched-pressure", "--param=sched-pressure-algorithm=2")
"""Wanted for loops but the largest: an order of instructions that keeps fewer values waiting, a
tenth faster.
"""


class CompilerError(Exception):
    """Error of a compiler, a stored library, or loading; the message has the reason."""


@dataclass(frozen=True)
class Compiler:
    """A C compiler: its path, its version in a line, which of `MACHINE_FLAGS` it takes, and which
    of `ORDER_FLAGS`.

    `words` follow the path in every call: `cc` of `python -m ziglang cc`; `bundled` says
    whether it is the one of the extra `compiler`.
    """

    path: str
    version: str
    flags: tuple[str, ...]
    order: tuple[str, ...] = ()
    words: tuple[str, ...] = ()
    bundled: bool = False

    @property
    def command(self) -> tuple[str, ...]:
        return (self.path, *self.words)


def find_compiler() -> Compiler:
    """The compiler that the variable CC names, in one or several words, else `cc`, else the bundled
    one.

    Raises CompilerError.
    """
    named, search = os.environ.get("CC"), os.environ.get("PATH")
    compiler = _probe_compiler("cc" if named is None else named, search)
    if isinstance(compiler, str) and named is None and bundled_command():
        compiler = _probe_compiler(bundled_command(), search)
    if isinstance(compiler, str):
        raise CompilerError(compiler)
    return compiler


@cache
def _probe_compiler(name: str | tuple[str, ...], _search: str | None) -> Compiler | str:
    """Return a compiler, or the reason why it cannot be used; each is probed once, even if it
    fails.

    A name is one of the user's, words are those of the bundled compiler.
    """
    title = name if isinstance(name, str) else " ".join(name)
    try:
        command = _split_command(name) if isinstance(name, str) else list(name)
        version = (
            _run_compiler(command, "--version")
            .stdout.decode(errors="backslashreplace")
            .partition("\n")[0]
        )
        with TemporaryDirectory(prefix="planter-") as folder:
            flags, order = (
                tuple(
                    flag
                    for flag in candidates
                    if _accepts_flag(command, flag, Path(folder) / "probe.o")
                )
                for candidates in (MACHINE_FLAGS, ORDER_FLAGS)
            )
    except CompilerError as reason:
        return str(reason)
    except subprocess.TimeoutExpired:
        return f"the C compiler {title} does not answer within {PROBE_TIMEOUT_S:g} s"
    except (OSError, subprocess.CalledProcessError):
        return f"the C compiler {title} does not run"
    return Compiler(
        command[0], version, flags, order, tuple(command[1:]), not isinstance(name, str)
    )


def _split_command(name: str) -> list[str]:
    """The words of a command, its program as a path; a path may have spaces in it."""
    try:
        words = [name] if shutil.which(name) else _split_words(name)
    except ValueError as error:
        raise CompilerError(f"the variable CC, {name!r}, cannot be read: {error}") from error
    if not words:
        raise CompilerError("the variable CC is empty")
    path = shutil.which(words[0])
    if path is None:
        raise CompilerError(f"there is no C compiler {words[0]!r}")
    return [path, *words[1:]]


def _split_words(name: str) -> list[str]:
    """Split words as a shell does; on Windows a backslash is part of a path."""
    if current_platform() is WINDOWS:
        return [word.strip('"') for word in shlex.split(name, posix=False)]
    return shlex.split(name)


def _accepts_flag(command: list[str], flag: str, target: Path) -> bool:
    """Whether a compiler takes a flag: it neither fails nor warns because of it, whatever else it
    may warn of.
    """
    # an empty source: only the flag itself can be at fault
    probe, folder = (flag, "-x", "c", "-c", os.devnull, "-o", str(target)), target.parent
    try:
        _run_compiler(command, "-Werror", *probe, folder=folder)
    except subprocess.CalledProcessError as error:
        return flag.partition("=")[0].encode() not in error.stderr and _succeeds(
            command, *probe, folder=folder
        )
    return True


def _succeeds(command: list[str], *arguments: str, folder: Path) -> bool:
    try:
        _run_compiler(command, *arguments, folder=folder)
    except subprocess.CalledProcessError:
        return False
    return True


def _run_compiler(
    command: list[str], *arguments: str, folder: Path | None = None
) -> subprocess.CompletedProcess[bytes]:
    """Return the output of a compiler; `folder` holds its temporary files."""
    return builds.run_program(
        [*command, *arguments], PROBE_TIMEOUT_S, folder, bundled_variables(folder) if folder else {}
    )
