"""What this installation has, and what would make it faster."""

from __future__ import annotations

import os
import platform
from importlib import metadata
from importlib.util import find_spec

from planter.cli.results import Examination, KernelFound
from planter.engine.response import MachineResponse
from planter.kernels import backends, toolchain
from planter.kernels.compiler import CompilerError, find_compiler
from planter.papers.planting import machines
from planter.version import __version__

MACHINE = "wang2017"
EXTRAS = {
    "derive": "sympy",
    "compiler": "ziglang",
    "notebook": "anywidget",
    "studio": "starlette",
    "parquet": "pyarrow",
    "step": "OCP",
    "cluster": "distributed",
    "sampling": "numpyro",
    "control": "control",
}
"""Extras of pyproject.toml for users, each with a module that it alone brings."""


def examine_installation(build: bool = False) -> Examination:
    """Return what is installed and what is missing; compiles functions only with `build`."""

    response = MachineResponse(machines.load(MACHINE, {}), ["support"])
    kernels = [response.prologue_kernel, response.values_kernel, response.slopes_kernel]
    advice, compiler, cache = {}, None, None
    try:
        compiler = find_compiler()
        cache = str(toolchain.cache_folder())
    except (CompilerError, OSError, RuntimeError) as reason:
        advice[str(reason)] = (
            "install gcc (12 or newer), clang or planter[compiler], or name a compiler in CC"
            if compiler is None
            else "name a private folder, on a disk that allows execution, in PLANTER_CACHE"
        )
    usable = cache is not None
    listed = []
    for kernel in kernels:
        if build:
            kernel.compile()
        way = backends.predict_backend(kernel.work) if usable else backends.BACKENDS[-1]
        compiled = usable and backends.is_compiled(kernel.work)
        listed.append(KernelFound(kernel.work.function.name(), way, compiled))
    if (limit := os.environ.get("PLANTER_KERNELS")) in backends.BACKENDS[1:]:
        advice[f"PLANTER_KERNELS allows nothing faster than {limit}"] = "unset it"
    if usable and not all(kernel.compiled for kernel in listed):
        advice["functions that are not compiled yet"] = "planter doctor --build, or wait"
    versions = {"planter": __version__, "python": platform.python_version()}
    versions |= {name: metadata.version(name) for name in ("casadi", "numpy")}
    return Examination(
        versions=versions,
        compiler=None if compiler is None else compiler.version,
        flags=None if compiler is None else list(compiler.flags),
        cache=cache,
        kernels=listed,
        extras={name: find_spec(module) is not None for name, module in EXTRAS.items()},
        advice=advice,
    )
