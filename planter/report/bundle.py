"""A folder of result files: every figure is rendered before the first file is written."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from planter.progress import Listener, ProgressPhase
from planter.report import files, style
from planter.report.folder import renews_files
from planter.safe_text import file_name

if TYPE_CHECKING:
    from matplotlib.figure import Figure


RenderedFigure = Mapping[str, str | bytes]
"""A figure by the endings of its files."""


def render_figures(
    figures: Mapping[str, Figure], progress: Listener | None = None
) -> dict[str, RenderedFigure]:
    """Render figures by name as SVG, PNG and PDF, and report the number of rendered figures to
    `progress`.
    """
    rendered: dict[str, RenderedFigure] = {}
    phase = ProgressPhase("drawing", "figure", len(figures), progress)
    for name, figure in figures.items():
        rendered[name] = style.render_figure(figure)
        phase.advance(name)
    return rendered


@renews_files
def write_bundle(
    out: str | Path, texts: Mapping[str, str | bytes], figures: Mapping[str, RenderedFigure]
) -> None:
    """Write texts by file name, and figures into the folder `figures`.

    Raises InputError, naming the path, before any file is written if the folder cannot be written
    or if it has a file of one of these names that planter did not write.
    """
    contents: dict[str, str | bytes] = {}
    for name, figure in figures.items():
        stem, count = file_name(name), 1
        while (
            f"figures/{stem}.svg" in contents
        ):  # names that differ only in characters which file names cannot have
            count += 1
            stem = f"{file_name(name)}-{count}"
        contents |= {f"figures/{stem}.{ending}": content for ending, content in figure.items()}
    files.write_all(out, contents | dict(texts))
