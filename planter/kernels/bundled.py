"""The compiler that the extra `compiler` brings: clang, with headers and libraries of many systems, as `zig cc`.

On its first use it builds its own libraries for a system, and keeps them beside the compiled functions.
"""

from __future__ import annotations

import importlib.util
import os
from pathlib import Path

from planter.kernels import platforms

PREPARATION_S = 20
"""How long its first use takes beside what is compiled, measured on two cores."""
FOLDER = "ZIG_GLOBAL_CACHE_DIR"
"""The variable that names the folder where it keeps what it builds for itself."""


def command() -> tuple[str, ...]:
    """How it is called; nothing where the extra is not installed."""
    found = importlib.util.find_spec("ziglang")
    if found is None or found.origin is None:
        return ()
    program = "zig.exe" if platforms.here() is platforms.WINDOWS else "zig"
    return str(Path(found.origin).parent / program), "cc"


def variables(cache: Path) -> dict[str, str]:
    """What it is to find in its environment: where the user names no folder for what it builds, it is in our cache."""
    return {FOLDER: os.environ.get(FOLDER) or str(cache / "zig")}


def prepared(cache: Path) -> bool:
    """Whether it has built something before."""
    return Path(variables(cache)[FOLDER]).exists()
