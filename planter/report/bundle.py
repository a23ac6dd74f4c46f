"""A folder of result files, written whole or not at all: all of it is there before the first file is written."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from planter.files.names import file_name
from planter.progress import Listener, Phase
from planter.report import files, style
from planter.report.folder import renews

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class Drawn:
    """A figure as SVG text and as PNG."""

    svg: str
    png: bytes


def drawn(figures: Mapping[str, Figure], progress: Listener | None = None) -> dict[str, Drawn]:
    """Figures by their names, rendered; `progress` is told how many are."""
    found, phase = {}, Phase("drawing", "figure", len(figures), progress)
    for name, figure in figures.items():
        found[name] = Drawn(style.svg(figure), style.png(figure))
        phase.next(name)
    return found


@renews
def write(out: str | Path, texts: Mapping[str, str | bytes], figures: Mapping[str, Drawn]) -> None:
    """Write texts by their files' names, and figures into the folder `figures`.

    Raises InputError, naming the path, for a folder that cannot be written, and for files there that planter did not
    write, before anything is.
    """
    contents: dict[str, str | bytes] = {}
    for name, figure in figures.items():
        stem, count = file_name(name), 1
        while f"figures/{stem}.svg" in contents:  # of another name that differs in signs which no file's name has
            count += 1
            stem = f"{file_name(name)}-{count}"
        contents |= {f"figures/{stem}.svg": figure.svg, f"figures/{stem}.png": figure.png}
    files.write_all(out, contents | dict(texts))
