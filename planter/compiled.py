"""CasADi functions as machine code, where there is a C compiler: the same text, faster. Without one nothing is lost.

A compiled function is kept in the user's cache folder under the hash of its C text, the compiler and its flags.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import subprocess
import tempfile
from functools import cache
from pathlib import Path

import casadi as ca

LARGE = 10_000
"""Instructions from which a function is compiled with less optimisation: it would take the compiler too long."""
TIMEOUT_S = 120


def compiled(function: ca.Function) -> ca.Function:
    """The function in machine code; the function itself where there is no compiler or no place to keep the result."""
    compiler = _compiler()
    if compiler is None:
        return function
    try:
        return _loaded(function, compiler)
    except (OSError, RuntimeError, subprocess.SubprocessError):
        return function


@cache
def _compiler() -> str | None:
    named = os.environ.get("CC", "cc")
    found = shutil.which(named) if named else None
    if found is None:
        return None
    version = subprocess.run([found, "--version"], capture_output=True, text=True, check=False)
    return found if version.returncode == 0 else None


def _loaded(function: ca.Function, compiler: str) -> ca.Function:
    flags = ["-O1" if function.n_instructions() > LARGE else "-O2", "-fPIC", "-shared"]
    with tempfile.TemporaryDirectory(prefix="planter-") as scratch:
        source = Path(scratch) / f"{function.name()}.c"
        generator = ca.CodeGenerator(source.name)
        generator.add(function)
        source.write_text(generator.dump(), encoding="utf-8")
        key = hashlib.sha256("\0".join([compiler, *flags, source.read_text(encoding="utf-8")]).encode()).hexdigest()
        library = cache_folder() / f"{function.name()}-{key[:32]}.so"
        if not library.exists():
            fresh = Path(scratch) / library.name
            command = [compiler, *flags, str(source), "-o", str(fresh), "-lm"]
            subprocess.run(command, capture_output=True, check=True, timeout=TIMEOUT_S)
            _publish(fresh, library)
    return ca.external(function.name(), str(library))


def _publish(fresh: Path, library: Path) -> None:
    """Put a file in its place in one step, so that no other process sees half of it."""
    beside = library.with_suffix(f".{os.getpid()}")
    shutil.copy2(fresh, beside)
    beside.replace(library)


def cache_folder() -> Path:
    """Private folder of compiled functions, made where it is missing. Raises OSError where it cannot be."""
    base = (
        os.environ.get("PLANTER_CACHE") or Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "planter"
    )
    folder = Path(base)
    folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    return folder
