"""Derives a user's file: it is run as Python by a process of its own, and text comes back."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from planter import workers
from planter.errors import ComputationError, InputError
from planter.files.text import check_regular

GENERATED = "generated"


def derived(source: Path, out: Path | None = None, targets: Iterable[str] = (), overwrite: bool = False) -> Path:
    """The folder with what was derived of a file or folder: that which is given, else ``generated`` beside it.

    ``targets`` are languages that are written besides those that always are; ``overwrite`` replaces files that were not
    derived, or were edited since.
    Raises InputError for what is wrong with the user's file, with the place in it, ComputationError for anything else.
    """
    if not source.exists():
        raise InputError(f"{source}: there is no such file or folder")
    if not source.is_dir():
        check_regular(source)
    folder = out or (source if source.is_dir() else source.parent) / GENERATED
    options = ["--overwrite"] if overwrite else []
    options += [part for name in targets for part in ("--target", name)]
    done = workers.run_command(workers.program_command("derive", str(source), "--out", str(folder), *options))
    said = done.stderr.strip().splitlines() or [f"{source}: deriving ended with code {done.returncode}"]
    if done.returncode == InputError.exit_code:
        raise InputError(said[0])
    if done.returncode:
        raise ComputationError(said[-1])
    return folder
