"""Where a benchmark ran: processor, load, versions, compiler and flags."""

from __future__ import annotations

import os
import platform
from importlib import metadata
from pathlib import Path

from planter.bench.results import Surroundings
from planter.kernels import toolchain
from planter.version import __version__

PACKAGES = ("casadi", "numpy", "scipy", "jax", "jaxlib", "sympy", "ezdxf", "ncgears")


def machine() -> Surroundings:
    """Processor, cores, and how busy the machine was when the benchmark began (None where it cannot be told)."""
    load = os.getloadavg()[0] if hasattr(os, "getloadavg") else None
    system = f"{platform.system()} {platform.release()}"
    return Surroundings(_processor(), platform.machine(), os.cpu_count(), system, load)


def _processor() -> str:
    """Name of the processor, with family, model and stepping where the system tells them: names alone may not say."""
    try:
        text = Path("/proc/cpuinfo").read_text(encoding="utf-8")
    except OSError:
        return platform.processor()
    first = text.partition("\n\n")[0]
    fields = {key.strip(): value.strip() for key, _, value in (line.partition(":") for line in first.splitlines())}
    if "model name" not in fields:
        return platform.processor()
    numbers = [f"{key.split()[-1]} {fields[key]}" for key in ("cpu family", "model", "stepping") if key in fields]
    return f"{fields['model name']} ({', '.join(numbers)})" if numbers else fields["model name"]


def versions() -> dict[str, str]:
    """Version of everything that takes part; what is not installed is left out."""
    versions_by_name = {"planter": __version__, "python": platform.python_version()}
    for name in PACKAGES:
        try:
            versions_by_name[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            continue
    libc = " ".join(platform.libc_ver()).strip()
    return {**versions_by_name, **({"libc": libc} if libc else {}), **_compiler()}


def _compiler() -> dict[str, str]:
    try:
        cc = toolchain.compiler()
    except toolchain.NoCompiler:
        return {}
    flags = " ".join((*toolchain.OPTIMISED, *cc.flags))
    return {
        "compiler": cc.version,
        "flags": flags,
        "flags of lanes": " ".join((*toolchain.loop_flags(toolchain.OPTIMISED), *cc.flags)),
    }
