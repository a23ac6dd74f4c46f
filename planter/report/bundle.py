"""A folder of result files: every figure is rendered before the first file is written."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from planter.progress import Listener, ProgressPhase
from planter.report import files, style
from planter.report.folder import renews_files
from planter.safe_text import file_name

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class RenderedFigure:
    """A figure as SVG text and as PNG."""

    svg: str
    png: bytes


def render_figures(figures: Mapping[str, Figure], progress: Listener | None = None) -> dict[str, RenderedFigure]:
    """Render figures by name as SVG and PNG, and report the number of rendered figures to `progress`."""
    rendered, phase = {}, ProgressPhase("drawing", "figure", len(figures), progress)
    for name, figure in figures.items():
        rendered[name] = RenderedFigure(style.render_svg(figure), style.render_png(figure))
        phase.advance(name)
    return rendered


@renews_files
def write_bundle(out: str | Path, texts: Mapping[str, str | bytes], figures: Mapping[str, RenderedFigure]) -> None:
    """Write texts by file name, and figures into the folder `figures`.

    Raises InputError, naming the path, before any file is written if the folder cannot be written or if it has a file
    of one of these names that planter did not write.
    """
    contents: dict[str, str | bytes] = {}
    for name, figure in figures.items():
        stem, count = file_name(name), 1
        while f"figures/{stem}.svg" in contents:  # names that differ only in characters which file names cannot have
            count += 1
            stem = f"{file_name(name)}-{count}"
        contents |= {f"figures/{stem}.svg": figure.svg, f"figures/{stem}.png": figure.png}
    files.write_all(out, contents | dict(texts))
