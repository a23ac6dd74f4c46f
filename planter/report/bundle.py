"""A folder of result files, written whole or not at all: all of it is there before the first file is written."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from planter.report import files, style
from planter.report.folder import renews

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Progress = Callable[[str, int, int], None]


@dataclass(frozen=True)
class Drawn:
    """A figure as SVG text and as PNG."""

    svg: str
    png: bytes


def drawn(figures: Mapping[str, Figure], progress: Progress | None = None) -> dict[str, Drawn]:
    """Figures by their names, rendered; `progress` is told how many are."""
    found = {}
    for count, (name, figure) in enumerate(figures.items(), 1):
        found[name] = Drawn(style.svg(figure), style.png(figure))
        if progress is not None:
            progress(f"figure {count} of {len(figures)}: {name}", count, len(figures))
    return found


@renews
def write(out: str | Path, texts: Mapping[str, str], figures: Mapping[str, Drawn]) -> None:
    """Writes texts by their files' names, and figures into the folder `figures`.

    Raises InputError, naming the path, for a folder that cannot be written, before anything is.
    """
    folder = files.output_folder(out)
    place = files.output_folder(folder / "figures")
    for name, figure in figures.items():
        files.write_text(place / f"{name}.svg", figure.svg)
        files.write_bytes(place / f"{name}.png", figure.png)
    for name, text in texts.items():
        files.write_text(folder / name, text)
