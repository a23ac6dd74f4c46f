"""Libraries of a unit, for any processor of their kind: for this system by its compiler, else by the bundled one."""

from __future__ import annotations

import platform
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path

from planter.interchange.fmi.model import MAIN
from planter.kernels import builds, bundled, platforms, toolchain
from planter.kernels.platforms import Platform
from planter.kernels.toolchain import NoCompiler

PLATFORMS: dict[str, tuple[str, Platform]] = {
    "linux64": ("x86_64-linux-gnu.2.17", platforms.LINUX),
    "win64": ("x86_64-windows-gnu", platforms.WINDOWS),
}
"""Platforms by name: how the bundled compiler calls each, and how libraries are there."""
FLAGS = ("-O2", "-fvisibility=hidden", "-Werror=implicit-function-declaration")


def build(place: str, texts: Mapping[str, str], name: str) -> tuple[str, bytes]:
    """File name and content of a unit's library for a platform, from its sources. Raises NoCompiler."""
    target, system = PLATFORMS[place]
    native = _is_here(place) and not toolchain.compiler().bundled
    file = f"{name}{system.suffix}"
    with tempfile.TemporaryDirectory(prefix="planter-") as temporary:
        folder = Path(temporary)
        for source, text in texts.items():
            (folder / source).write_text(text, encoding="utf-8")
        command = toolchain.compiler().command if native else bundled.command(target)
        if not command:
            raise NoCompiler("planter[compiler] is not installed, which builds for other systems")
        compiled = folder / "fmu.o"
        steps = (
            system.compile(command, FLAGS, folder / MAIN, compiled),
            [*system.link(command, compiled, folder / file, folder / file), "-s"],
        )
        try:
            for step in steps:
                _run(step, folder, "" if native else target)
            return file, (folder / file).read_bytes()
        except (OSError, subprocess.SubprocessError) as error:
            raise NoCompiler(f"{command[0]} did not build {file}: {toolchain.said(error)}") from error


def _is_here(place: str) -> bool:
    return place == "linux64" and sys.platform == "linux" and platform.machine() == "x86_64"


def _run(command: list[str], folder: Path, target: str) -> None:
    """One step, by the bundled compiler where there is a target."""
    if target:
        toolchain.run_for(target, command, folder)
    else:
        builds.run(command, toolchain.TIMEOUT_S, folder)
