"""The compiler that the extra `compiler` brings: clang, with headers and libraries of many systems, as `zig cc`.

On its first use for a system it builds its own libraries, and keeps them beside the compiled functions.
"""

from __future__ import annotations

import importlib.util
import os
from pathlib import Path

from planter.kernels import platforms

HERE = ""
"""The target that stands for this system."""
PREPARATION_S = {HERE: 20, "x86_64-windows-gnu": 100, "wasm32-wasi": 20}
"""How long its first use for a target takes beside what is compiled, measured on two cores; others as this one."""
FOLDER = "ZIG_GLOBAL_CACHE_DIR"
"""The variable that names the folder where it keeps what it builds for itself."""


def command(target: str = HERE) -> tuple[str, ...]:
    """How it is called, for another system by its target; nothing where the extra is not installed."""
    found = importlib.util.find_spec("ziglang")
    if found is None or found.origin is None:
        return ()
    program = "zig.exe" if platforms.here() is platforms.WINDOWS else "zig"
    return str(Path(found.origin).parent / program), "cc", *(("-target", target) if target else ())


def variables(cache: Path) -> dict[str, str]:
    """What it is to find in its environment: where the user names no folder for what it builds, it is in our cache."""
    return {FOLDER: os.environ.get(FOLDER) or str(cache / "zig")}


def preparation_s(target: str = HERE) -> int:
    """How long its first use for a target takes [s], about."""
    return PREPARATION_S.get(target, PREPARATION_S[HERE])


def prepared(cache: Path, target: str = HERE) -> bool:
    """Whether it has built its libraries for a target."""
    return _mark(cache, target).exists()


def keep(cache: Path, target: str = HERE) -> None:
    """Note that it has."""
    mark = _mark(cache, target)
    mark.parent.mkdir(parents=True, exist_ok=True)
    mark.touch()


def _mark(cache: Path, target: str) -> Path:
    return Path(variables(cache)[FOLDER]) / f"planter-{target or 'here'}"
