"""`planter audit --front`: the attainable range and variance of a model, compared with a paper; tables, figure, CSV."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from planter.audit import numbers
from planter.audit.registry import FRONTS
from planter.errors import InputError
from planter.progress import Listener
from planter.report import files, style
from planter.report.html import Block, FigureSvg, Items, Section, Table
from planter.terminal.console import Console

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FrontTable = Mapping[str, Any]
NAME = "front"


def search_front(paper: str | None, progress: Listener | None) -> FrontTable:
    """Return the front of a paper. Raises InputError if the paper has none."""
    papers = [name for name in numbers.list_papers() if name in FRONTS]
    if paper not in papers:
        raise InputError(f"--front needs one of the papers {', '.join(papers)}")
    return FRONTS[paper](progress)


def show_front(console: Console, front: FrontTable) -> None:
    """Print the statements, and the points of each front."""
    for statement in front["statements"]:
        print(statement)
    print()
    for curve in front["fronts"]:
        console.table(f"Attained with {curve['contact']}", HEAD, _list_rows(curve["points"]))


def list_front_sections(front: FrontTable) -> Iterator[Section]:
    """Yield the sections of the page with statements, figure and points."""
    yield Section(
        "What can be attained", [Items(front["statements"]), FigureSvg(style.svg(plot_front(front)), CAPTION)]
    )
    blocks: list[Block] = [Table(HEAD, list(_list_rows(curve["points"]))) for curve in front["fronts"]]
    for curve, block in zip(front["fronts"], blocks, strict=True):
        yield Section(f"Attained with {curve['contact']}", [block])


HEAD = ("range / N", "variance / N2", "flanks", "least push of the cam / N")
CAPTION = (
    "Largest variance of the support force for a range that a search of inputs within the stated bounds attained in "
    "the exact model, and the figures of the paper. The search is heuristic: values below are attained, values above "
    "are not excluded."
)


def _list_rows(points: Sequence[FrontTable]) -> Iterator[tuple[Any, ...]]:
    return ((p["range_N"], p["variance_N2"], p["flank"], p["least_push_N"]) for p in points)


def write_front(folder: Path, front: FrontTable) -> None:
    """Write front.json, front.csv and the figure. Raises InputError if the folder cannot be written."""
    files.write_summary(folder / f"{NAME}.json", dict(front))
    names = ("contact", "range_N", "variance_N2", "least_push_N", "flank")
    lines = [
        ",".join((curve["contact"], *(_format_cell(p[n]) for n in names[1:])))
        for curve in front["fronts"]
        for p in curve["points"]
    ]
    files.write_text(folder / f"{NAME}.csv", "\n".join([",".join(names), *lines]) + "\n")
    style.save(plot_front(front), folder, NAME)


def _format_cell(value: Any) -> str:
    return value if isinstance(value, str) else repr(float(value))


@style.with_style
def plot_front(front: FrontTable) -> Figure:
    """Plot fronts of variance over range from the origin, and the points of the paper."""
    plot = style.new_figure(3.6)
    axes = plot.subplots()
    for index, curve in enumerate(front["fronts"]):
        ends = [*curve["points"], curve["largest_range"]]
        x, y = ([0.0, *(p[key] for p in ends)] for key in ("range_N", "variance_N2"))
        shade = style.PALETTE[index]
        axes.plot(x, y, color=shade, marker="o", markersize=3, linewidth=1.3 - 0.4 * index, label=curve["contact"],
                  linestyle="-" if index == 0 else (0, (4, 2)))  # fmt: skip
        if index == 0:
            axes.fill_between(x, y, color=shade, alpha=0.12, linewidth=0)
    for mark in front["table"]:
        axes.plot(mark["range_N"], mark["variance_N2"], "X", color=style.INK, markersize=7)
        axes.annotate(f"Table 1, {mark['name']}", (mark["range_N"], mark["variance_N2"]), (7, 3),
                      textcoords="offset points")  # fmt: skip
    axes.set_xlim(left=0)
    axes.set_ylim(bottom=0, top=1.1 * max(mark["variance_N2"] for mark in front["table"]))
    axes.set_xlabel("range of the support force / N")
    axes.set_ylabel("variance / N²")
    axes.legend(frameon=False, loc="upper right", title="exact model, any inputs within the bounds")
    return plot
