"""The command that looks after the compiled functions."""

from __future__ import annotations

from typing import Annotated

import typer

from planter.doctor.results import CompilerFound, Examination, NoCompilerFound
from planter.terminal.console import Console, cell_text
from planter.terminal.options import JsonOption

app = typer.Typer()


@app.command()
def doctor(
    build: Annotated[
        bool, typer.Option("--build", help="compile the functions of the built-in machine first")
    ] = False,
    as_json: JsonOption = False,
) -> None:
    """Show what is installed, and what would make it faster."""
    console = Console(as_json)
    with console.outcome():
        from planter.doctor import examination

        examined = examination.examine_installation(build)
        console.result(examined, lambda: print_examination(console, examined))


def print_examination(console: Console, result: Examination) -> None:
    """Print an examination."""
    cache = result.cache
    rows: list[tuple[str, object]] = [
        *result.versions.table().items(),
        *result.processor.table().items(),
    ]
    rows += [
        *_compiler_rows(result.compiler),
        ("compiled functions in", cache.folder),
        ("files", cache.files),
        ("size, MB", cache.bytes / 1e6),
    ]
    console.table(
        "This installation", ["", "result"], [(name, cell_text(cell)) for name, cell in rows]
    )
    console.table(
        f"Functions of {result.machine}",
        ["model", "function", "instructions", "way", "compiled"],
        [
            (k.model, k.name, k.instructions, k.way, "yes" if k.compiled else "no")
            for k in result.kernels
        ],
    )
    console.table(
        "Optional parts: pip install 'planter[NAME]'",
        ["name", "installed", "for"],
        [
            (extra.name, "yes" if extra.installed else "no", extra.purpose)
            for extra in result.extras
        ],
    )
    if result.advice:
        console.table(
            "What would help", ["missing", "what to do"], [(a.missing, a.do) for a in result.advice]
        )


def _compiler_rows(compiler: CompilerFound | NoCompilerFound) -> list[tuple[str, object]]:
    names = ("compiler", "compiler's path", "flags", "vector, bits")
    if isinstance(compiler, NoCompilerFound):
        return list(zip(names, (compiler.problem, None, None, None), strict=True))
    values = compiler.version, compiler.path, " ".join(compiler.flags) or None, compiler.vector_bits
    return list(zip(names, values, strict=True))
