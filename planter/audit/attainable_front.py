"""`planter audit --front`: the attainable range and variance of a model, compared with a paper; tables, figure, CSV."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from planter.audit import numbers
from planter.audit.registry import FRONTS
from planter.errors import InputError
from planter.progress import Listener
from planter.report import files, style
from planter.report.html import FigureSvg, Items, Section, Table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FrontTable = Mapping[str, Any]


def search_front(paper: str | None, progress: Listener | None) -> FrontTable:
    """Return the front of a paper. Raises InputError if the paper has none."""
    papers = [name for name in numbers.list_papers() if name in FRONTS]
    if paper not in papers:
        raise InputError(f"--front needs one of the papers {', '.join(papers)}")
    return FRONTS[paper](progress)


def list_front_sections(front: FrontTable) -> Iterator[Section]:
    """Yield the sections with the statements, and with the points of each front."""
    yield Section("Attainable range and variance", [Items(front["statements"])])
    for curve in front["fronts"]:
        rows = [(p["range_N"], p["variance_N2"], p["flank"], p["least_push_N"]) for p in curve["points"]]
        yield Section(f"Attained with {curve['contact']}", [Table(HEAD, rows)])


def build_figure_section(front: FrontTable) -> Section:
    """Return the section with the figure of the fronts."""
    return Section("Figure of the fronts", [FigureSvg(style.svg(plot_front(front)), CAPTION)])


HEAD = ("range / N", "variance / N2", "flanks", "least push of the cam / N")
CAPTION = (
    "Largest variance of the support force for a range that a search of inputs within the stated bounds attained in "
    "the exact model, and the figures of the paper. The search is heuristic: values below are attained, values above "
    "are not excluded."
)


def format_front_files(front: FrontTable) -> dict[str, str | bytes]:
    """Return the contents of front.json, front.csv and the figure by file name."""
    names = ("contact", "range_N", "variance_N2", "least_push_N", "flank")
    lines = [
        ",".join((curve["contact"], *(_format_cell(p[n]) for n in names[1:])))
        for curve in front["fronts"]
        for p in curve["points"]
    ]
    figure = plot_front(front)
    return {
        "front.json": files.summary_text(front),
        "front.csv": "\n".join([",".join(names), *lines]) + "\n",
        "front.svg": style.svg(figure),
        "front.png": style.png(figure),
    }


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
