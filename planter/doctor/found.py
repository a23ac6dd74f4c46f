"""What an installation finds: the C compiler, the folder of compiled functions, graphics processors."""

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
"""Bits of a vector, by what a compiler defines; the first that it defines counts."""
WAIT_S = 20


def compiler() -> CompilerFound | NoCompilerFound:
    try:
        found = toolchain.compiler()
    except NoCompiler as reason:
        return NoCompilerFound(str(reason))
    return CompilerFound(found.path, found.version, [*found.flags, *found.order], _bits(found), found.bundled)


def _bits(compiler: Compiler) -> int:
    """Width of the vectors that compiled functions use; 64 where there are none."""
    said = " ".join(_said([*compiler.command, *compiler.flags, "-dM", "-E", "-x", "c", os.devnull])).split()
    return next((bits for name, bits in VECTORS.items() if name in said), 64)


def cache() -> tuple[Cache, dict[Path, str]]:
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


def cuda() -> Cuda:
    """The compiler of CUDA, and the devices that its driver lists."""
    nvcc = shutil.which("nvcc")
    version = _said([nvcc, "--version"]) if nvcc else []
    devices = [line.strip() for line in _said(["nvidia-smi", "-L"]) if line.startswith("GPU")]
    release = next((line.strip() for line in version if "release" in line), None)
    return Cuda(nvcc, release, devices)


def _said(command: list[str]) -> list[str]:
    """Lines of a command's output; none where there is no such command, or it fails."""
    try:
        return builds.run(command, WAIT_S).stdout.decode(errors="replace").splitlines()
    except (OSError, subprocess.SubprocessError):
        return []
