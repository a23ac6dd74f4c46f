"""Parts of an installation: the C compiler, the folder of compiled functions, graphics processors."""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Iterable
from pathlib import Path

from planter.doctor.results import Cache, CompilerFound, Cuda, NoCompilerFound
from planter.kernels import builds, platforms, toolchain
from planter.kernels.toolchain import Compiler, NoCompiler, Refused

VECTORS = {"__AVX512F__": 512, "__AVX__": 256, "__SSE2__": 128, "__ARM_NEON": 128}
"""Width of a vector [bit] by the macro of the compiler; the first macro that it defines counts."""
WAIT_S = 20


def compiler() -> CompilerFound | NoCompilerFound:
    """Return the C compiler, or the reason why there is none."""
    try:
        cc = toolchain.compiler()
    except NoCompiler as reason:
        return NoCompilerFound(str(reason))
    return CompilerFound(cc.path, cc.version, [*cc.flags, *cc.order], _bits(cc), cc.bundled)


def _bits(compiler: Compiler) -> int:
    """Return the width [bit] of the vectors that compiled functions use, 64 without vectors."""
    macros = " ".join(_output_lines([*compiler.command, *compiler.flags, "-dM", "-E", "-x", "c", os.devnull])).split()
    return next((bits for name, bits in VECTORS.items() if name in macros), 64)


def cache() -> tuple[Cache, dict[Path, str]]:
    """Return the folder, which is not created, and the reason for each file in it that is refused."""
    try:
        folder = toolchain.cache_path()
        exists = folder.exists()
        problem = _obstacle(folder) if exists else _unmakeable(folder)
    except (OSError, RuntimeError) as error:
        return Cache(folder=None, exists=False, files=0, bytes=0, damaged=0, problem=str(error)), {}
    libraries = sorted(folder.resolve().glob(f"*{platforms.here().suffix}")) if exists and problem is None else []
    damaged, refused = _strange(libraries)
    size = sum(path.lstat().st_size for path in libraries)
    return Cache(str(folder), exists, len(libraries), size, damaged, problem), refused


def _strange(libraries: Iterable[Path]) -> tuple[int, dict[Path, str]]:
    """Return the number of damaged libraries, and those that are refused, with the reasons."""
    damaged, refused = 0, {}
    for path in libraries:
        try:
            damaged += not toolchain.sound(path)
        except Refused as reason:
            refused[path] = str(reason)
    return damaged, refused


def _obstacle(folder: Path) -> str | None:
    """Return why libraries cannot be written to a folder, or loaded from it; None if they can."""
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


def cuda() -> Cuda:
    """Return the compiler of CUDA, and the devices that its driver lists."""
    nvcc = shutil.which("nvcc")
    version = _output_lines([nvcc, "--version"]) if nvcc else []
    devices = [line.strip() for line in _output_lines(["nvidia-smi", "-L"]) if line.startswith("GPU")]
    release = next((line.strip() for line in version if "release" in line), None)
    return Cuda(nvcc, release, devices)


def _output_lines(command: list[str]) -> list[str]:
    """Return the lines of a command's output; an empty list if it is missing or fails."""
    try:
        return builds.run(command, WAIT_S).stdout.decode(errors="replace").splitlines()
    except (OSError, subprocess.SubprocessError):
        return []
