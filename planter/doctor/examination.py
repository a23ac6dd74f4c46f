"""The optional parts of the package, and which of them are installed."""

from __future__ import annotations

import os
import platform
import subprocess
import threading
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from importlib import metadata
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from planter.doctor.results import (
    Advice,
    Cache,
    CompilerFound,
    Examination,
    Extra,
    KernelFound,
    NoCompilerFound,
    Processor,
    Versions,
)
from planter.kernels import Kernel, backends, builds, toolchain
from planter.kernels.compiler import (
    Compiler,
    CompilerError,
    current_platform,
    find_compiler,
    is_prepared,
    preparation_time_s,
)
from planter.kernels.toolchain import RefusedFileError
from planter.planting import file
from planter.planting.functions import MODELS
from planter.planting.model import Device
from planter.version import __version__

EXTRAS: Mapping[str, tuple[str, str]] = {
    "derive": ("sympy", "mechanisms of your own, audits of papers, derivation of the equations"),
    "compiler": ("ziglang", "a C compiler for systems without one, and pages without a server"),
    "notebook": ("anywidget", "machines that move in a notebook"),
    "studio": ("starlette", "the interactive page (`planter studio`)"),
    "parquet": ("pyarrow", "tables of sweeps as Parquet beside CSV"),
    "step": ("OCP", "solid bodies as STEP files"),
    "cluster": ("distributed", "jobs on a Dask cluster"),
    "sampling": ("numpyro", "samplers of posteriors of measured data"),
}
"""Extras of pyproject.toml for those who use the package: a module that only the extra brings, and
its purpose.
"""


def list_extras() -> list[Extra]:
    """Return every extra with its purpose and whether it is installed."""
    return [
        Extra(name, find_spec(module) is not None, purpose)
        for name, (module, purpose) in EXTRAS.items()
    ]


VECTORS = {"__AVX512F__": 512, "__AVX__": 256, "__SSE2__": 128, "__ARM_NEON": 128}
"""Width of a vector [bit] by the macro of the compiler; the first macro that it defines counts."""
WAIT_S = 20


def examine_compiler() -> CompilerFound | NoCompilerFound:
    """Return the C compiler, or the reason why it is missing."""
    try:
        cc = find_compiler()
    except CompilerError as reason:
        return NoCompilerFound(str(reason))
    return CompilerFound(cc.path, cc.version, [*cc.flags, *cc.order], _bits(cc), cc.bundled)


def _bits(compiler: Compiler) -> int:
    """Return the width [bit] of the vectors that compiled functions use, 64 without vectors."""
    macros = " ".join(
        _output_lines([*compiler.command, *compiler.flags, "-dM", "-E", "-x", "c", os.devnull])
    ).split()
    return next((bits for name, bits in VECTORS.items() if name in macros), 64)


def examine_cache() -> tuple[Cache, dict[Path, str]]:
    """Return the folder, which is not created, and the reason for each file in it that is
    refused.
    """
    try:
        folder = toolchain.cache_path()
        exists = folder.exists()
        problem = _obstacle(folder) if exists else _unmakeable(folder)
    except (OSError, RuntimeError) as error:
        return Cache(folder=None, exists=False, files=0, bytes=0, damaged=0, problem=str(error)), {}
    libraries = (
        sorted(folder.resolve().glob(f"*{current_platform().suffix}"))
        if exists and problem is None
        else []
    )
    damaged, refused = _strange(libraries)
    size = sum(path.lstat().st_size for path in libraries)
    return Cache(str(folder), exists, len(libraries), size, damaged, problem), refused


def _strange(libraries: Iterable[Path]) -> tuple[int, dict[Path, str]]:
    """Return the number of damaged libraries, and those that are refused, with the reasons."""
    damaged, refused = 0, {}
    for path in libraries:
        try:
            damaged += not toolchain.is_intact(path)
        except RefusedFileError as reason:
            refused[path] = str(reason)
    return damaged, refused


def _obstacle(folder: Path) -> str | None:
    """Return why libraries cannot be written to a folder, or loaded from it; None if they can."""
    try:
        toolchain.cache_folder()
    except CompilerError as reason:
        return str(reason)
    if hasattr(os, "statvfs") and os.statvfs(folder).f_flag & getattr(os, "ST_NOEXEC", 0):
        return f"{folder} is on a disk that forbids execution"
    return None


def _unmakeable(folder: Path) -> str | None:
    parent = next(p for p in folder.parents if p.exists())
    if parent.is_dir() and os.access(parent, os.W_OK | os.X_OK):
        return None
    return f"{folder} cannot be made: {parent} cannot be written"


def _output_lines(command: list[str]) -> list[str]:
    """Return the lines of a command's output; an empty list if it is missing or fails."""
    try:
        return builds.run_program(command, WAIT_S).stdout.decode(errors="replace").splitlines()
    except (OSError, subprocess.SubprocessError):
        return []


VECTOR_ARCTANGENT = (2, 35)
"""First version of the GNU C library with an arc tangent for vectors."""


def list_advice(
    machine: str,
    compiler: CompilerFound | NoCompilerFound,
    cache: Cache,
    kernels: Sequence[KernelFound],
) -> Iterator[Advice]:
    """Yield what is missing in an installation, each with a remedy."""
    limited = os.environ.get("PLANTER_KERNELS")
    if isinstance(compiler, NoCompilerFound):
        yield Advice(
            compiler.problem,
            "install gcc (12 or newer), clang or planter[compiler], or name a compiler in the "
            "variable CC",
        )
    elif "clang" in compiler.version and platform.machine() == "x86_64":
        yield Advice(
            "clang has no vector form of the arc tangent: loops in vectors compute it one angle "
            "at a time",
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
        and not (cache.folder and is_prepared(Path(cache.folder)))
    ):
        yield Advice(
            f"the compiler of planter[compiler] prepares itself at its first use, about "
            f"{preparation_time_s()} s",
            "planter doctor --build, or wait at the first use",
        )
    if cache.problem is not None:
        yield Advice(
            cache.problem,
            "name a private folder, on a disk that allows execution, in PLANTER_CACHE",
        )
    if cache.damaged:
        yield Advice(
            f"{cache.damaged} compiled functions are damaged", "nothing: they are built again"
        )
    if limited in backends.BACKENDS[1:]:
        yield Advice(
            f"the variable PLANTER_KERNELS allows nothing faster than {limited}", "unset it"
        )
    waiting = [
        kernel for kernel in kernels if kernel.way != backends.BACKENDS[-1] and not kernel.compiled
    ]
    if waiting:
        yield Advice(
            f"{len(waiting)} functions of {machine} are not compiled yet",
            "planter doctor --build, or wait at their first use",
        )


def _library() -> tuple[int, ...]:
    """Return the version of the GNU C library; (0,) for another library."""
    name, version = platform.libc_ver()
    return tuple(map(int, version.split(".")[:2])) if name == "glibc" else (0,)


MACHINE = "wang2017"


def examine_installation(build: bool = False) -> Examination:
    """Return versions, compiler, cache, the way of each function of the built-in machine, and
    advice.

    Compiles only with `build`.
    """
    devices = {model: Device(file.load(MACHINE), model) for model in MODELS}
    if build:
        for device in devices.values():
            _build(device)
    compiler, (cache, refused) = examine_compiler(), examine_cache()
    usable, filled = isinstance(compiler, CompilerFound) and cache.problem is None, cache.files > 0
    kernels = [
        row
        for model, device in devices.items()
        for row in _kernels(model, device, usable, filled, refused)
    ]
    return Examination(
        versions=Versions(
            planter=__version__,
            python=platform.python_version(),
            casadi=metadata.version("casadi"),
            numpy=np.__version__,
            c_library=" ".join(platform.libc_ver()).strip() or None,
        ),
        processor=Processor(platform.machine(), os.cpu_count()),
        compiler=compiler,
        cache=cache,
        machine=MACHINE,
        kernels=kernels,
        extras=list_extras(),
        advice=[
            *(Advice(reason, "remove it") for reason in refused.values()),
            *list_advice(MACHINE, compiler, cache, kernels),
        ],
    )


def _build(device: Device) -> None:
    """Compile what an optimiser and a whole turn need, and wait for it."""
    from planter.planting.objective import CycleObjective

    CycleObjective(device)
    for kernel in _used(device):
        kernel.compile()
    for thread in threading.enumerate():
        if thread.name.startswith("compile "):
            thread.join()


def _used(device: Device) -> tuple[Kernel, ...]:
    force = device.force.response
    return (
        force.hoisting_kernel,
        force.prologue_kernel,
        force.prologue_hessian_kernel,
        force.values_kernel,
        force.slopes_kernel,
        force.derivatives_kernel,
        force.rates_kernel,
        force.hessian_kernel,
    )


def _kernels(
    model: str, device: Device, usable: bool, filled: bool, refused: Collection[Path]
) -> Iterator[KernelFound]:
    for kernel in _used(device):
        work = kernel.work
        way = backends.predict_backend(work) if usable else backends.BACKENDS[-1]
        if refused and way != backends.BACKENDS[-1] and backends.library_path(work, way) in refused:
            way = backends.BACKENDS[-1]
        compiled = filled and way != backends.BACKENDS[-1] and backends.is_compiled(work)
        yield KernelFound(model, str(work.function.name()), work.size, way, compiled)
