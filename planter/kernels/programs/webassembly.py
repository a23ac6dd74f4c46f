"""Programs as a WebAssembly module with vector instructions, by the compiler of the extra `compiler`.

It imports nothing, and exports its memory, and by a program's name the program and where its numbers are.
"""

from __future__ import annotations

import subprocess
import tempfile
from collections.abc import Sequence
from pathlib import Path

from planter.kernels import bundled, toolchain
from planter.kernels.programs.program import Program
from planter.kernels.programs.text import LOOPS, texts
from planter.kernels.toolchain import NoCompiler

TARGET = "wasm32-wasi"
COMMON = ("-std=gnu99", "-O3", "-msimd128", "-mexec-model=reactor", "-ffp-contract=off")
FLAGS = {LOOPS: ("-ffinite-math-only", "-fno-signed-zeros", "-fno-math-errno", "-fno-trapping-math")}
"""For loops, that they can become vector instructions; the order of additions stays what it is."""


def module(programs: Sequence[Program]) -> bytes:
    """The module. Raises NoCompiler where there is none, NotPrintable for what has no form in C."""
    command = bundled.command(TARGET)
    if not command:
        raise NoCompiler("planter[compiler] is not installed: pip install 'planter[compiler]'")
    exports = [f"-Wl,--export={name}" for one in programs for name in (one.name, f"{one.name}_numbers")]
    with tempfile.TemporaryDirectory(prefix="planter-") as made:
        folder = Path(made)
        written = texts(programs)
        for name, text in written.items():
            (folder / name).write_text(text, encoding="utf-8")
            _run(
                [*command, *COMMON, *FLAGS.get(name, ()), "-c", str(folder / name), "-o", f"{folder / name}.o"], folder
            )
        objects = [f"{folder / name}.o" for name in written]
        _run([*command, *COMMON, *objects, "-o", str(folder / "all.wasm"), "-s", *exports], folder)
        return (folder / "all.wasm").read_bytes()


def _run(command: list[str], folder: Path) -> None:
    try:
        toolchain.run_for(TARGET, command, folder)
    except (OSError, subprocess.SubprocessError) as error:
        raise NoCompiler(f"{command[0]} did not build the functions: {toolchain.said(error)}") from error
