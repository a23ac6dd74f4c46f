"""Advice that makes an installation faster or complete."""

from __future__ import annotations

import os
import platform
from collections.abc import Iterator, Sequence
from pathlib import Path

from planter.doctor.results import Advice, Cache, CompilerFound, KernelFound, NoCompilerFound
from planter.kernels import backends, bundled

VECTOR_ARCTANGENT = (2, 35)
"""First version of the GNU C library with an arc tangent for vectors."""


def advice(
    machine: str, compiler: CompilerFound | NoCompilerFound, cache: Cache, kernels: Sequence[KernelFound]
) -> Iterator[Advice]:
    """Yield what is missing in an installation, each with a remedy."""
    limited = os.environ.get("PLANTER_KERNELS")
    if isinstance(compiler, NoCompilerFound):
        yield Advice(
            compiler.problem,
            "install gcc (12 or newer), clang or planter[compiler], or name a compiler in the variable CC",
        )
    elif "clang" in compiler.version and platform.machine() == "x86_64":
        yield Advice(
            "clang has no vector form of the arc tangent: loops in vectors compute it one angle at a time",
            "install gcc and set CC=gcc",
        )
    elif platform.machine() == "x86_64" and _library() < VECTOR_ARCTANGENT:
        yield Advice(
            "the C library has no arc tangent for vectors: the loops run one angle at a time",
            "use a system with glibc 2.35 or newer",
        )
    if (
        isinstance(compiler, CompilerFound)
        and compiler.bundled
        and not (cache.folder and bundled.prepared(Path(cache.folder)))
    ):
        yield Advice(
            f"the compiler of planter[compiler] prepares itself at its first use, about {bundled.preparation_s()} s",
            "planter doctor --build, or wait at the first use",
        )
    if cache.problem is not None:
        yield Advice(cache.problem, "name a private folder, on a disk that allows execution, in PLANTER_CACHE")
    if cache.damaged:
        yield Advice(f"{cache.damaged} compiled functions are damaged", "nothing: they are built again")
    if limited in backends.NAMES[1:]:
        yield Advice(f"the variable PLANTER_KERNELS allows nothing faster than {limited}", "unset it")
    waiting = [kernel for kernel in kernels if kernel.way != backends.NAMES[-1] and not kernel.compiled]
    if waiting:
        yield Advice(
            f"{len(waiting)} functions of {machine} are not compiled yet",
            "planter doctor --build, or wait at their first use",
        )


def _library() -> tuple[int, ...]:
    """Return the version of the GNU C library; (0,) for another library."""
    name, version = platform.libc_ver()
    return tuple(map(int, version.split(".")[:2])) if name == "glibc" else (0,)
