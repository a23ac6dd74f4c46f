"""`planter audit --front`: what a model can give at all, beside the figures of a paper; tables, figure, CSV."""

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

Found = Mapping[str, Any]
NAME = "front"


def sought(paper: str | None, progress: Listener | None) -> Found:
    """The front of a paper. Raises InputError where there is none."""
    known = [name for name in numbers.papers() if name in FRONTS]
    if paper not in known:
        raise InputError(f"--front is not allowed here: it wants one of the papers {', '.join(known)}")
    return FRONTS[paper](progress)


def show(console: Console, found: Found) -> None:
    """What was found in sentences, and the points of each front."""
    for statement in found["statements"]:
        print(statement)
    print()
    for one in found["fronts"]:
        console.table(f"Attained with {one['contact']}", HEAD, _rows(one["points"]))


def sections(found: Found) -> Iterator[Section]:
    """The same for a page, with the figure."""
    yield Section("What can be attained", [Items(found["statements"]), FigureSvg(style.svg(figure(found)), CAPTION)])
    blocks: list[Block] = [Table(HEAD, list(_rows(one["points"]))) for one in found["fronts"]]
    for one, block in zip(found["fronts"], blocks, strict=True):
        yield Section(f"Attained with {one['contact']}", [block])


HEAD = ("range / N", "variance / N2", "flanks", "least push of the cam / N")
CAPTION = (
    "Most variance of the support force that inputs within the stated bounds were found to give for a range, in the "
    "exact model; the paper's own figures beside. A heuristic search: what lies below is attained, nothing proves that "
    "nothing lies above."
)


def _rows(points: Sequence[Found]) -> Iterator[tuple[Any, ...]]:
    return ((p["range_N"], p["variance_N2"], p["flank"], p["least_push_N"]) for p in points)


def write(folder: Path, found: Found) -> None:
    """Writes front.json, front.csv and the figure. Raises InputError for a folder that it cannot write."""
    files.write_summary(folder / f"{NAME}.json", dict(found))
    names = ("contact", "range_N", "variance_N2", "least_push_N", "flank")
    lines = [
        ",".join((one["contact"], *(_text(p[n]) for n in names[1:]))) for one in found["fronts"] for p in one["points"]
    ]
    files.write_text(folder / f"{NAME}.csv", "\n".join([",".join(names), *lines]) + "\n")
    style.save(figure(found), folder, NAME)


def _text(value: Any) -> str:
    return value if isinstance(value, str) else repr(float(value))


@style.drawn
def figure(found: Found) -> Figure:
    """Fronts of variance over range, from nothing at all, and the paper's points."""
    drawn = style.new_figure(3.6)
    axes = drawn.subplots()
    for index, one in enumerate(found["fronts"]):
        ends = [*one["points"], one["largest_range"]]
        x, y = ([0.0, *(p[key] for p in ends)] for key in ("range_N", "variance_N2"))
        shade = style.PALETTE[index]
        axes.plot(x, y, color=shade, marker="o", markersize=3, linewidth=1.3 - 0.4 * index, label=one["contact"],
                  linestyle="-" if index == 0 else (0, (4, 2)))  # fmt: skip
        if index == 0:
            axes.fill_between(x, y, color=shade, alpha=0.12, linewidth=0)
    for mark in found["table"]:
        axes.plot(mark["range_N"], mark["variance_N2"], "X", color=style.INK, markersize=7)
        axes.annotate(f"Table 1, {mark['name']}", (mark["range_N"], mark["variance_N2"]), (7, 3),
                      textcoords="offset points")  # fmt: skip
    axes.set_xlim(left=0)
    axes.set_ylim(bottom=0, top=1.1 * max(mark["variance_N2"] for mark in found["table"]))
    axes.set_xlabel("range of the support force / N")
    axes.set_ylabel("variance / N²")
    axes.legend(frameon=False, loc="upper right", title="exact model, any inputs within the bounds")
    return drawn
