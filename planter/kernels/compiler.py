"""The C compiler, where there is one: how it is called, its version, the flags that it takes."""

from __future__ import annotations

import os
import shlex
import shutil
import subprocess
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

from planter.kernels import builds, bundled, platforms

ANSWER_S = 20
"""How long a compiler may take to say its version, or whether it takes a flag."""
MACHINE_FLAGS = ("-march=native", "-mprefer-vector-width=512", *platforms.vector_library())
"""Wanted where the compiler knows them: the processor's own instructions, whole vectors, clang's vector library."""
ORDER_FLAGS = ("-fschedule-insns", "-fsched-pressure", "--param=sched-pressure-algorithm=2")
"""Wanted for loops but the largest: an order of instructions that keeps fewer values waiting, a tenth faster."""


class NoCompiler(Exception):
    """Nothing can be compiled, kept or loaded here; the message says why."""


@dataclass(frozen=True)
class Compiler:
    """A C compiler: its path, its version in a line, which of `MACHINE_FLAGS` it takes, and which of `ORDER_FLAGS`.

    `words` are those that stand behind the path whenever it is called: `cc` of `python -m ziglang cc`; `bundled` says
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


def compiler() -> Compiler:
    """The compiler that the variable CC names, in one or several words, else `cc`, else the bundled one.

    Raises NoCompiler.
    """
    named, search = os.environ.get("CC"), os.environ.get("PATH")
    found = _asked("cc" if named is None else named, search)
    if isinstance(found, str) and named is None and bundled.command():
        found = _asked(bundled.command(), search)
    if isinstance(found, str):
        raise NoCompiler(found)
    return found


@cache
def _asked(name: str | tuple[str, ...], _search: str | None) -> Compiler | str:
    """A compiler, or why there is none: each is asked once, also one that does not answer.

    A name is one of the user's, words are those of the bundled compiler.
    """
    shown = name if isinstance(name, str) else " ".join(name)
    try:
        command = _command(name) if isinstance(name, str) else list(name)
        version = _said(command, "--version").stdout.decode(errors="backslashreplace").partition("\n")[0]
        with TemporaryDirectory(prefix="planter-") as folder:
            flags, order = (
                tuple(flag for flag in wanted if _takes(command, flag, Path(folder) / "probe.o"))
                for wanted in (MACHINE_FLAGS, ORDER_FLAGS)
            )
    except NoCompiler as reason:
        return str(reason)
    except subprocess.TimeoutExpired:
        return f"the C compiler {shown} does not answer within {ANSWER_S:g} s"
    except (OSError, subprocess.CalledProcessError):
        return f"the C compiler {shown} does not run"
    return Compiler(command[0], version, flags, order, tuple(command[1:]), not isinstance(name, str))


def _command(name: str) -> list[str]:
    """The words of a command, its program as a path; a path may have spaces in it."""
    try:
        words = [name] if shutil.which(name) else _words(name)
    except ValueError as error:
        raise NoCompiler(f"the variable CC, {name!r}, cannot be read: {error}") from error
    if not words:
        raise NoCompiler("the variable CC is empty")
    path = shutil.which(words[0])
    if path is None:
        raise NoCompiler(f"there is no C compiler {words[0]!r}")
    return [path, *words[1:]]


def _words(name: str) -> list[str]:
    """As a shell would part them; on Windows a backslash is part of a path."""
    if platforms.here() is platforms.WINDOWS:
        return [word.strip('"') for word in shlex.split(name, posix=False)]
    return shlex.split(name)


def _takes(command: list[str], flag: str, made: Path) -> bool:
    """Whether a compiler takes a flag: it neither fails nor warns because of it, whatever else it may warn of."""
    probe, folder = (flag, "-x", "c", "-c", os.devnull, "-o", str(made)), made.parent
    try:
        _said(command, "-Werror", *probe, folder=folder)
    except subprocess.CalledProcessError as error:
        return flag.partition("=")[0].encode() not in error.stderr and _runs(command, *probe, folder=folder)
    return True


def _runs(command: list[str], *arguments: str, folder: Path) -> bool:
    try:
        _said(command, *arguments, folder=folder)
    except subprocess.CalledProcessError:
        return False
    return True


def _said(command: list[str], *arguments: str, folder: Path | None = None) -> subprocess.CompletedProcess[bytes]:
    """What a compiler says; a folder is where it may leave something for a while."""
    return builds.run([*command, *arguments], ANSWER_S, folder, bundled.variables(folder) if folder else {})
