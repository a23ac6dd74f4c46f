"""What the commands write of a machine, written from the page: below the folder of the studio and nowhere else."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from planter.errors import InputError
from planter.report.folder import NAME as LIST
from planter.report.folder import output_folder
from planter.studio.process import Process

FOLDER = "exports"
"""Folder, below the studio's, where exports are written."""


def place(folder: Path, *parts: str) -> Path:
    """A place for exports below the folder of a studio, whose parts are names and no paths.

    Raises InputError where a link would lead out of the folder.
    """
    found = folder.joinpath(FOLDER, *(re.sub(r"[^\w-]+", "_", part) for part in parts))
    if not found.resolve().is_relative_to(folder.resolve()):
        raise InputError(f"{found} is not allowed: it must be below {folder}")
    return found


def written(folder: Path, path: str) -> Path | None:
    """A file that was exported, by its path below the exports; None for any other path."""
    root = (folder / FOLDER).resolve()
    try:
        found = (root / path).resolve()
        inside = root.is_relative_to(folder.resolve()) and found.is_relative_to(root)
        return found if inside and found.is_file() else None
    except (OSError, ValueError):  # no system has a file of such a name
        return None


@dataclass(frozen=True)
class Work:
    """An export: its name, the folder that it is written to, the command that writes it."""

    name: str
    there: Path
    command: Sequence[str]

    def state(self) -> dict[Path, tuple[int, int]]:
        """What is there, each file with marks that change if it is written again."""
        found = ((path, path.stat()) for path in self.there.rglob("*") if path.is_file() and path.name != LIST)
        return {path: (stat.st_mtime_ns, stat.st_ino) for path, stat in found}

    def files(self, folder: Path, before: Mapping[Path, tuple[int, int]]) -> list[dict[str, Any]]:
        """What was written since, by paths below the exports of a studio's folder, with sizes."""
        found = sorted(path for path, marks in self.state().items() if before.get(path) != marks)
        root = folder / FOLDER
        return [{"path": path.relative_to(root).as_posix(), "bytes": path.stat().st_size} for path in found]


async def export(process: Process, folder: Path, works: Sequence[Work]) -> None:
    """Write exports, and send the files of each when they are there.

    A command replaces what it wrote before, and refuses to replace anything else.

    Raises ComputationError with the sentence of the first command that does not succeed, InputError where its folder
    cannot be written into.
    """
    await process.send({"exporting": ""})
    for work in works:
        output_folder(work.there)
        await process.send({"exporting": work.name})
        before = work.state()
        await process.command(work.command)
        files = work.files(folder, before)
        await process.send({"exported": work.name, "folder": str(work.there.parent), "files": files})
    await process.send({"exporting": None})
