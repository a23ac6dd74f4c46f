"""What `planter animate` does."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from planter.errors import InputError
from planter.files.names import file_name
from planter.report import files
from planter.report.folder import check
from planter.view.frames import gif
from planter.view.results import Animated
from planter.view.subject import first_scene, opened


def animate(
    source: str, changes: Mapping[str, float], out: Path, model: str | None = None, seconds: float | None = None
) -> Animated:
    """Writes a machine as it moves as a GIF: to a file, or under its name to a folder.

    Raises InputError for what is no machine or model, and where it cannot write.
    """
    machine = opened(source, changes)
    scene, chosen = first_scene(machine, model, f"--model {model}")
    path = out / f"{file_name(machine.name)}.gif" if out.is_dir() else out
    if path.suffix.lower() != ".gif":
        raise InputError(f"--out {path} is not allowed: it must be a folder or a file that ends in .gif")
    check(path.parent, [path.name])
    files.write_bytes(path, gif(scene, seconds))
    return Animated(str(path), machine.name, chosen)
