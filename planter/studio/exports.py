"""Exports of a machine by commands, which the page starts; they are written only below the folder of the studio."""

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
"""Folder for exports, below the folder of the studio."""


def export_path(folder: Path, *parts: str) -> Path:
    """Return a path for exports below the folder of a studio; `parts` are names and not paths.

    Raises InputError if a link leads out of the folder.
    """
    path = folder.joinpath(FOLDER, *(re.sub(r"[^\w-]+", "_", part) for part in parts))
    if not path.resolve().is_relative_to(folder.resolve()):
        raise InputError(f"{path}: a link leads out of the studio's folder {folder}; remove the link")
    return path


def find_export(folder: Path, path: str) -> Path | None:
    """Return an exported file by its path below the exports, or None for any other path."""
    root = (folder / FOLDER).resolve()
    try:
        file = (root / path).resolve()
        inside = root.is_relative_to(folder.resolve()) and file.is_relative_to(root)
        return file if inside and file.is_file() else None
    except (OSError, ValueError):  # the name is not valid for a file
        return None


@dataclass(frozen=True)
class ExportTask:
    """An export: its name, the folder that it is written to, and the command that writes it."""

    name: str
    folder: Path
    command: Sequence[str]

    def state(self) -> dict[Path, tuple[int, int]]:
        """Return the files of the folder with time and number, which change if a file is written again."""
        files = ((path, path.stat()) for path in self.folder.rglob("*") if path.is_file() and path.name != LIST)
        return {path: (stat.st_mtime_ns, stat.st_ino) for path, stat in files}

    def written_files(self, studio: Path, before: Mapping[Path, tuple[int, int]]) -> list[dict[str, Any]]:
        """Return files written after the state `before`: paths below the exports of a studio, and sizes [byte]."""
        files = sorted(path for path, marks in self.state().items() if before.get(path) != marks)
        root = studio / FOLDER
        return [{"path": path.relative_to(root).as_posix(), "bytes": path.stat().st_size} for path in files]


async def export(process: Process, folder: Path, tasks: Sequence[ExportTask]) -> None:
    """Write exports, and send the files of each after it has been written.

    A command replaces files that it wrote before, and refuses to replace others.

    Raises ComputationError with the message of the first command that fails, and InputError if a folder cannot be
    written into.
    """
    await process.send({"exporting": ""})
    for task in tasks:
        output_folder(task.folder)
        await process.send({"exporting": task.name})
        before = task.state()
        await process.command(task.command)
        files = task.written_files(folder, before)
        await process.send({"exported": task.name, "folder": str(task.folder.parent), "files": files})
    await process.send({"exporting": None})
