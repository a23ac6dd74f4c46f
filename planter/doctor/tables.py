"""An examination as tables."""

from __future__ import annotations

from planter.doctor.results import CompilerFound, Examination, NoCompilerFound
from planter.terminal.console import Console, cell_text


def tables(console: Console, found: Examination) -> None:
    cache, cuda = found.cache, found.cuda
    rows: list[tuple[str, object]] = [*found.versions.table().items(), *found.processor.table().items()]
    rows += [*_compiler_rows(found.compiler),
             ("compiled functions in", cache.folder), ("files", cache.files),
             ("size, MB", cache.bytes / 1e6), ("CUDA compiler", cuda.version or cuda.compiler),
             ("graphics processors", ", ".join(cuda.devices) or None)]  # fmt: skip
    console.table("This installation", ["", "found"], [(name, cell_text(cell)) for name, cell in rows])
    console.table(
        f"Functions of {found.machine}",
        ["model", "function", "instructions", "way", "compiled"],
        [(k.model, k.name, k.instructions, k.way, "yes" if k.compiled else "no") for k in found.kernels],
    )
    console.table(
        "Optional parts: pip install 'planter[NAME]'",
        ["name", "installed", "for"],
        [(extra.name, "yes" if extra.installed else "no", extra.purpose) for extra in found.extras],
    )
    if found.advice:
        console.table("What would help", ["missing", "what to do"], [(a.missing, a.do) for a in found.advice])


def _compiler_rows(found: CompilerFound | NoCompilerFound) -> list[tuple[str, object]]:
    names = ("compiler", "compiler's path", "flags", "vector, bits")
    if isinstance(found, NoCompilerFound):
        return list(zip(names, (found.problem, None, None, None), strict=True))
    values = found.version, found.path, " ".join(found.flags) or None, found.vector_bits
    return list(zip(names, values, strict=True))
