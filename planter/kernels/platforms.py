"""What systems call a shared library, how a compiler makes one there."""

from __future__ import annotations

import platform
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Platform:
    """A system: how names of its shared libraries end, what its compilers take to compile and to link one.

    `placed` is a flag that writes into a library where others find it; elsewhere the name it is linked under says it.
    """

    suffix: str
    compiling: tuple[str, ...] = ()
    linking: tuple[str, ...] = ()
    placed: str = ""

    def compile(self, command: Sequence[str], flags: Sequence[str], source: Path, compiled: Path) -> list[str]:
        """The command that compiles a C text for a library."""
        return [*command, "-std=gnu99", *flags, *self.compiling, "-c", str(source), "-o", str(compiled)]

    def link(
        self, command: Sequence[str], compiled: Path, linked: Path, place: Path, needed: Sequence[Path] = ()
    ) -> list[str]:
        """The command that links a library, for the `place` that it will have, to others."""
        placed = [self.placed + str(place)] if self.placed else []
        return [*command, "-shared", str(compiled), "-o", str(linked), *placed, *map(str, needed), *self.linking]


LINUX = Platform(".so", ("-fPIC",), ("-lm",))
MACOS = Platform(".dylib", ("-fPIC",), ("-lm",), "-Wl,-install_name,")
WINDOWS = Platform(".dll")
"""There every text is compiled for any place, and the C library has the mathematics."""
_BY_SYSTEM = {"darwin": MACOS, "win32": WINDOWS}


def here() -> Platform:
    """The system that this process runs on."""
    return _BY_SYSTEM.get(sys.platform, LINUX)


def vector_library() -> tuple[str, ...]:
    """The flag of clang for mathematics in vectors where the C library has them, which is GNU's alone."""
    return ("-fveclib=libmvec",) if platform.libc_ver()[0] == "glibc" else ()
