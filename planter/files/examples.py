"""Files to start from, each by its name: what the rooms of the machines bring in their folder `examples`."""

from __future__ import annotations

from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Literal

from planter import rooms
from planter.errors import InputError
from planter.files import paths
from planter.files.text import read_text

Suffix = Literal[".toml", ".csv"]


def names(kind: str | None = None, suffix: Suffix | None = None) -> list[str]:
    """Names of what is built in, sorted: all, or those of one room or one kind of file."""
    return sorted(file.name.rpartition(".")[0] for file in _files(kind) if file.name.endswith(suffix or ""))


def example(name: str, kind: str | None = None, suffix: Suffix | None = None) -> str:
    """The commented text of a built-in file, to start from. Raises InputError for an unknown name."""
    for file in _files(kind):
        if file.name.rpartition(".")[0] == name and file.name.endswith(suffix or ""):
            return file.read_text(encoding="utf-8")
    known = names(kind, suffix)
    similar = paths.close(name, known)
    hint = f"did you mean {similar[0]}? " if similar else ""
    what = "machine" if suffix == ".toml" else "example"
    raise InputError(
        f"{name}: there is no built-in {what} of that name, {hint}(built in: {', '.join(known)}; "
        f"anything else must be the path of a {suffix or '.toml or .csv'} file)"
    )


def text(source: str | Path, kind: str, suffix: Suffix = ".toml") -> str:
    """The text of the file at a path, or of the built-in one of that name.

    Raises InputError where there is neither, or where the file cannot be read.
    """
    return example(str(source), kind, suffix) if _is_name(source, kind, suffix) else read_text(source)


def _is_name(source: str | Path, kind: str, suffix: Suffix) -> bool:
    if isinstance(source, Path):
        return False
    if source in names(kind, suffix):
        return True
    return not (source.endswith(suffix) or Path(source).name != source or Path(source).exists())


def _files(kind: str | None) -> list[Traversable]:
    found = rooms.folders("examples")
    folders = [found[kind]] if kind else [found[room] for room in sorted(found)]
    return [file for folder in folders for file in folder.iterdir() if file.name.endswith((".toml", ".csv"))]
