"""`planter doctor`: what this installation has, how functions are evaluated here, what would make that faster."""

from __future__ import annotations

import os
import platform
import shutil
import subprocess
import threading
from collections.abc import Collection, Iterable, Iterator, Sequence
from importlib import metadata
from pathlib import Path

import numpy as np

from planter.doctor.results import (
    Advice,
    Cache,
    CompilerFound,
    Cuda,
    Examination,
    KernelFound,
    NoCompilerFound,
    Processor,
    Versions,
)  # fmt: skip
from planter.kernels import Kernel, backends, builds, bundled, platforms, toolchain
from planter.kernels.toolchain import Compiler, NoCompiler, Refused
from planter.planting import file
from planter.planting.functions import MODELS
from planter.planting.model import Device
from planter.terminal.console import Console, cell_text
from planter.version import __version__

MACHINE = "wang2017"
VECTORS = {"__AVX512F__": 512, "__AVX__": 256, "__SSE2__": 128, "__ARM_NEON": 128}
"""Bits of a vector, by what a compiler defines; the first that it defines counts."""
VECTOR_ARCTANGENT = (2, 35)
"""The version of the C library from which on it has an arc tangent for vectors."""
WAIT_S = 20


def examine(build: bool = False) -> Examination:
    """Versions, compiler, cache, the way of each function of the built-in machine, and advice.

    Compiles only with `build`.
    """
    devices = {model: Device(file.load(MACHINE), model) for model in MODELS}
    if build:
        for device in devices.values():
            _build(device)
    compiler, (cache, refused) = _compiler(), _cache()
    usable, filled = isinstance(compiler, CompilerFound) and cache.problem is None, cache.files > 0
    kernels = [row for model, device in devices.items() for row in _kernels(model, device, usable, filled, refused)]
    return Examination(
        versions=Versions(
            planter=__version__, python=platform.python_version(), casadi=metadata.version("casadi"),
            numpy=np.__version__, c_library=" ".join(platform.libc_ver()).strip() or None,
        ),
        processor=Processor(platform.machine(), os.cpu_count()),
        compiler=compiler, cache=cache, machine=MACHINE, kernels=kernels, cuda=_cuda(),
        advice=[*(Advice(reason, "remove it") for reason in refused.values()), *_advice(compiler, cache, kernels)],
    )  # fmt: skip


def _build(device: Device) -> None:
    """Compile what an optimiser and a whole turn need, and wait for it."""
    from planter.planting.turns import Turns

    Turns(device)
    device.compile()
    for kernel in _used(device):
        kernel.compile()
    for thread in threading.enumerate():
        if thread.name.startswith("compile "):
            thread.join()


def _used(device: Device) -> tuple[Kernel, ...]:
    force = device.force
    return (device.hoisting_kernel, device.prologue_kernel, device.prologue_hessian_kernel, force.value_kernel,
            force.slopes_kernel, force.hessian_kernel)  # fmt: skip


def _kernels(
    model: str, device: Device, usable: bool, filled: bool, refused: Collection[Path]
) -> Iterator[KernelFound]:
    for kernel in _used(device):
        work = kernel.work
        way = backends.foreseen(work) if usable else backends.NAMES[-1]
        if refused and way != backends.NAMES[-1] and backends.place(work, way) in refused:
            way = backends.NAMES[-1]
        compiled = filled and way != backends.NAMES[-1] and backends.kept(work)
        yield KernelFound(model, str(work.function.name()), work.size, way, compiled)


def _compiler() -> CompilerFound | NoCompilerFound:
    try:
        found = toolchain.compiler()
    except NoCompiler as reason:
        return NoCompilerFound(str(reason))
    return CompilerFound(found.path, found.version, [*found.flags, *found.order], _bits(found), found.bundled)


def _bits(compiler: Compiler) -> int:
    """Width of the vectors that compiled functions use; 64 where there are none."""
    said = " ".join(_said([*compiler.command, *compiler.flags, "-dM", "-E", "-x", "c", os.devnull])).split()
    return next((bits for name, bits in VECTORS.items() if name in said), 64)


def _cache() -> tuple[Cache, dict[Path, str]]:
    """The folder as it is, which is not made here; and of each strange thing in it what it is."""
    try:
        folder = toolchain.cache_path()
        there = folder.exists()
        problem = _obstacle(folder) if there else _unmakeable(folder)
    except (OSError, RuntimeError) as error:
        return Cache(folder=None, exists=False, files=0, bytes=0, damaged=0, problem=str(error)), {}
    libraries = sorted(folder.resolve().glob(f"*{platforms.here().suffix}")) if there and problem is None else []
    damaged, refused = _strange(libraries)
    size = sum(path.lstat().st_size for path in libraries)
    return Cache(str(folder), there, len(libraries), size, damaged, problem), refused


def _strange(libraries: Iterable[Path]) -> tuple[int, dict[Path, str]]:
    """How many libraries are damaged, and which are refused, with the reasons."""
    damaged, refused = 0, {}
    for path in libraries:
        try:
            damaged += not toolchain.sound(path)
        except Refused as reason:
            refused[path] = str(reason)
    return damaged, refused


def _obstacle(folder: Path) -> str | None:
    """Why libraries cannot be kept in a folder, or loaded from it."""
    try:
        toolchain.cache_folder()
    except NoCompiler as reason:
        return str(reason)
    if hasattr(os, "statvfs") and os.statvfs(folder).f_flag & getattr(os, "ST_NOEXEC", 0):
        return f"{folder} is on a disk that forbids execution"
    return None


def _unmakeable(folder: Path) -> str | None:
    parent = next(p for p in folder.parents if p.exists())
    if parent.is_dir() and os.access(parent, os.W_OK | os.X_OK):
        return None
    return f"{folder} cannot be made: {parent} cannot be written"


def _cuda() -> Cuda:
    compiler = shutil.which("nvcc")
    version = _said([compiler, "--version"]) if compiler else []
    devices = [line.strip() for line in _said(["nvidia-smi", "-L"]) if line.startswith("GPU")]
    release = next((line.strip() for line in version if "release" in line), None)
    return Cuda(compiler, release, devices)


def _said(command: list[str]) -> list[str]:
    """Lines of a command's output; none where there is no such command, or it fails."""
    try:
        return builds.run(command, WAIT_S).stdout.decode(errors="replace").splitlines()
    except (OSError, subprocess.SubprocessError):
        return []


def _advice(
    compiler: CompilerFound | NoCompilerFound, cache: Cache, kernels: Sequence[KernelFound]
) -> Iterator[Advice]:
    """What is missing, and what to do about it."""
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
            f"{len(waiting)} functions of {MACHINE} are not compiled yet",
            "planter doctor --build, or wait at their first use",
        )


def _library() -> tuple[int, ...]:
    """Version of the GNU C library; (0,) where another one is in its place."""
    name, version = platform.libc_ver()
    return tuple(map(int, version.split(".")[:2])) if name == "glibc" else (0,)


def tables(console: Console, found: Examination) -> None:
    cache, cuda = found.cache, found.cuda
    rows: list[tuple[str, object]] = [*found.versions.table().items(), *found.processor.table().items()]
    rows += [*_compiler_rows(found.compiler),
             ("compiled functions in", cache.folder), ("files", cache.files),
             ("size, MB", cache.bytes / 1e6), ("CUDA compiler", cuda.version or cuda.compiler),
             ("graphics processors", ", ".join(cuda.devices) or None)]  # fmt: skip
    console.table("This installation", ["", "found"], [(name, cell_text(cell)) for name, cell in rows])
    console.table(
        f"Functions of {found.machine}",
        ["model", "function", "instructions", "way", "compiled"],
        [(k.model, k.name, k.instructions, k.way, "yes" if k.compiled else "no") for k in found.kernels],
    )
    if found.advice:
        console.table("What would help", ["missing", "what to do"], [(a.missing, a.do) for a in found.advice])


def _compiler_rows(found: CompilerFound | NoCompilerFound) -> list[tuple[str, object]]:
    names = ("compiler", "compiler's path", "flags", "vector, bits")
    if isinstance(found, NoCompilerFound):
        return list(zip(names, (found.problem, None, None, None), strict=True))
    values = found.version, found.path, " ".join(found.flags) or None, found.vector_bits
    return list(zip(names, values, strict=True))
