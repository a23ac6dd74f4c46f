"""The studio's page as a file: `planter studio --static`."""

from __future__ import annotations

from pathlib import Path

from planter.errors import InputError
from planter.kernels.loops import NotPrintable
from planter.kernels.toolchain import NoCompiler
from planter.report.files import write_bytes
from planter.report.folder import check
from planter.studio.static.page import page
from planter.view.portable import Movable
from planter.view.subject import opened


def write(source: str, file: Path) -> Path:
    """Writes the page of a machine, a file or a built-in name, and says where.

    Raises InputError for another kind of file, for a machine that no page can compute, and without the compiler.
    """
    if file.suffix.lower() != ".html":
        raise InputError(f"--static {file} is not allowed: the name of a page ends in .html")
    check(file.parent, [file.name])
    machine = opened(source)
    if not isinstance(machine, Movable):
        raise InputError(f"--static is not there for {source}: such a machine is computed in Python alone")
    try:
        text = page(machine)
    except NotPrintable as reason:
        raise InputError(f"--static is not there for {source}: {reason}") from None
    except NoCompiler as reason:
        raise InputError(f"--static {file} cannot be written: {reason}") from None
    write_bytes(file, text.encode())
    return file
