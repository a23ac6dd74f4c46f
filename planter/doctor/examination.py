"""`planter doctor`: what this installation has, how functions are evaluated here, what would make that faster."""

from __future__ import annotations

import os
import platform
import shutil
import subprocess
import threading
from collections.abc import Collection, Iterable, Iterator
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np

from planter.kernels import Kernel, backends, builds, toolchain
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

Report = dict[str, Any]


def examine(build: bool = False) -> Report:
    """Versions, compiler, cache, the way of each function of the built-in machine, and advice.

    Compiles only with `build`.
    """
    devices = {model: Device(file.load(MACHINE), model) for model in MODELS}
    if build:
        for device in devices.values():
            _build(device)
    compiler, cache = _compiler(), _cache()
    refused = cache.pop("refused")
    usable, filled = "path" in compiler and cache["problem"] is None, cache["files"] > 0
    kernels = [row for model, device in devices.items() for row in _kernels(model, device, usable, filled, refused)]
    found: Report = {
        "versions": {"planter": __version__, "python": platform.python_version(), "casadi": metadata.version("casadi"),
                     "numpy": np.__version__, "c_library": " ".join(platform.libc_ver()).strip() or None},
        "processor": {"machine": platform.machine(), "cores": os.cpu_count()},
        "compiler": compiler, "cache": cache, "machine": MACHINE, "kernels": kernels, "cuda": _cuda(),
    }  # fmt: skip
    strange = [{"missing": reason, "do": "remove it"} for reason in refused.values()]
    return found | {"advice": [*strange, *_advice(found)]}


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


def _kernels(model: str, device: Device, usable: bool, filled: bool, refused: Collection[Path]) -> Iterator[Report]:
    for kernel in _used(device):
        work = kernel.work
        way = backends.foreseen(work) if usable else backends.NAMES[-1]
        if refused and way != backends.NAMES[-1] and backends.place(work, way) in refused:
            way = backends.NAMES[-1]
        compiled = filled and way != backends.NAMES[-1] and backends.kept(work)
        yield {"model": model, "name": str(work.function.name()), "instructions": work.size, "way": way,
               "compiled": compiled}  # fmt: skip


def _compiler() -> Report:
    try:
        found = toolchain.compiler()
    except NoCompiler as reason:
        return {"problem": str(reason)}
    return {
        "path": found.path,
        "version": found.version,
        "flags": [*found.flags, *found.order],
        "vector_bits": _bits(found),
    }


def _bits(compiler: Compiler) -> int:
    """Width of the vectors that compiled functions use; 64 where there are none."""
    said = " ".join(_said([*compiler.command, *compiler.flags, "-dM", "-E", "-x", "c", os.devnull])).split()
    return next((bits for name, bits in VECTORS.items() if name in said), 64)


def _cache() -> Report:
    """The folder as it is; it is not made here. `refused` says of each strange thing in it what it is."""
    try:
        folder = toolchain.cache_path()
        there = folder.exists()
        problem = _obstacle(folder) if there else _unmakeable(folder)
    except (OSError, RuntimeError) as error:
        return {"folder": None, "exists": False, "files": 0, "bytes": 0, "damaged": 0, "problem": str(error),
                "refused": {}}  # fmt: skip
    libraries = sorted(folder.resolve().glob("*.so")) if there and problem is None else []
    damaged, refused = _strange(libraries)
    return {"folder": str(folder), "exists": there, "files": len(libraries),
            "bytes": sum(path.lstat().st_size for path in libraries),
            "damaged": damaged, "problem": problem, "refused": refused}  # fmt: skip


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
    if os.statvfs(folder).f_flag & getattr(os, "ST_NOEXEC", 0):
        return f"{folder} is on a disk that forbids execution"
    return None


def _unmakeable(folder: Path) -> str | None:
    parent = next(p for p in folder.parents if p.exists())
    if parent.is_dir() and os.access(parent, os.W_OK | os.X_OK):
        return None
    return f"{folder} cannot be made: {parent} cannot be written"


def _cuda() -> Report:
    compiler = shutil.which("nvcc")
    version = _said([compiler, "--version"]) if compiler else []
    devices = [line.strip() for line in _said(["nvidia-smi", "-L"]) if line.startswith("GPU")]
    release = next((line.strip() for line in version if "release" in line), None)
    return {"compiler": compiler, "version": release, "devices": devices}


def _said(command: list[str]) -> list[str]:
    """Lines of a command's output; none where there is no such command, or it fails."""
    try:
        return builds.run(command, WAIT_S).stdout.decode(errors="replace").splitlines()
    except (OSError, subprocess.SubprocessError):
        return []


def _advice(found: Report) -> Iterator[Report]:
    """What is missing, and what to do about it."""
    compiler, cache, kernels = found["compiler"], found["cache"], found["kernels"]
    limited = os.environ.get("PLANTER_KERNELS")
    if "problem" in compiler:
        yield {"missing": compiler["problem"],
               "do": "install gcc (12 or newer) or clang, or name a compiler in the variable CC"}  # fmt: skip
    elif "clang" in compiler["version"] and platform.machine() == "x86_64":
        yield {"missing": "clang has no vector form of the arc tangent: the loops run one angle at a time",
               "do": "install gcc and set CC=gcc"}  # fmt: skip
    elif platform.machine() == "x86_64" and _library() < VECTOR_ARCTANGENT:
        yield {"missing": "the C library has no arc tangent for vectors: the loops run one angle at a time",
               "do": "use a system with glibc 2.35 or newer"}  # fmt: skip
    if cache["problem"] is not None:
        yield {"missing": cache["problem"],
               "do": "name a private folder, on a disk that allows execution, in PLANTER_CACHE"}  # fmt: skip
    if cache["damaged"]:
        yield {"missing": f"{cache['damaged']} compiled functions are damaged", "do": "nothing: they are built again"}
    if limited in backends.NAMES[1:]:
        yield {"missing": f"the variable PLANTER_KERNELS allows nothing faster than {limited}", "do": "unset it"}
    waiting = [kernel for kernel in kernels if kernel["way"] != backends.NAMES[-1] and not kernel["compiled"]]
    if waiting:
        yield {"missing": f"{len(waiting)} functions of {found['machine']} are not compiled yet",
               "do": "planter doctor --build, or wait at their first use"}  # fmt: skip


def _library() -> tuple[int, ...]:
    """Version of the GNU C library; (0,) where another one is in its place."""
    name, version = platform.libc_ver()
    return tuple(map(int, version.split(".")[:2])) if name == "glibc" else (0,)


def tables(console: Console, found: Report) -> None:
    compiler, cache, cuda = found["compiler"], found["cache"], found["cuda"]
    rows: list[tuple[str, object]] = [*found["versions"].items(), *found["processor"].items()]
    rows += [("compiler", compiler.get("version", compiler.get("problem"))), ("compiler's path", compiler.get("path")),
             ("flags", " ".join(compiler.get("flags", ())) or None), ("vector, bits", compiler.get("vector_bits")),
             ("compiled functions in", cache["folder"]), ("files", cache["files"]),
             ("size, MB", cache["bytes"] / 1e6), ("CUDA compiler", cuda["version"] or cuda["compiler"]),
             ("graphics processors", ", ".join(cuda["devices"]) or None)]  # fmt: skip
    console.table("This installation", ["", "found"], [(name, cell_text(cell)) for name, cell in rows])
    console.table(
        f"Functions of {found['machine']}",
        ["model", "function", "instructions", "way", "compiled"],
        [(k["model"], k["name"], k["instructions"], k["way"], "yes" if k["compiled"] else "no")
         for k in found["kernels"]],
    )  # fmt: skip
    if found["advice"]:
        console.table("What would help", ["missing", "what to do"], [(a["missing"], a["do"]) for a in found["advice"]])
