"""The page of labelled drawings of every machine, with the tables of their symbols that `planter about explain` has."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from pathlib import Path

from book.keys import cell
from planter.cli.explanation import draw_sheets, explain_machine
from planter.cli.results import ExplainedMachine, Meaning
from planter.report import style
from planter.report.sheet import Sheet, draw_figure

MACHINES = {
    "Planting device": "wang2017",
    "Clutch": "shi2021",
    "Seedling pick-up": "yu2023",
    "Kinematic mapping": "sun2019-corrected",
}
HEAD = """\
# Drawings and symbols

The symbols on the machines' drawings with their keys, as `planter about explain MACHINE` tells them; of a
machine of your own, `planter about explain my.toml --out drawn` writes the same drawings. Arrows turn the way in which
an angle is counted.
"""


@cache
def sheets(source: str) -> list[Sheet]:
    """The drawings of a machine."""
    return draw_sheets(source, {})


@cache
def machines() -> dict[str, ExplainedMachine]:
    """The machines by the title of their section."""
    return {
        title: explain_machine(source, {}, sheets(source)) for title, source in MACHINES.items()
    }


def rows(symbols: list[Meaning]) -> Iterator[str]:
    """A table of symbols."""
    yield "| symbol | meaning | unit | key |"
    yield "|---|---|---|---|"
    for one in symbols:
        key = f"`{one.key}`" if one.key else ""
        yield f"| `{one.name}` | {cell(one.meaning)} | {one.unit} | {key} |"


def section(title: str, found: ExplainedMachine) -> Iterator[str]:
    """A machine: every drawing with its table."""
    yield f"\n## {title}\n"
    for sheet in found.sheets:
        yield f"\n### {sheet.title[0].upper()}{sheet.title[1:]}\n"
        yield (
            f"```{{figure}} {found.kind}-{sheet.name}.svg\n:alt: {title}, {sheet.title}\n:figclass: "
            f"drawing\n```\n"
        )
        yield from rows(sheet.symbols)


def draw(folder: Path) -> None:
    """Writes every drawing."""
    for title, found in machines().items():
        for sheet in sheets(MACHINES[title]):
            text = style.render_svg(draw_figure(sheet))
            (folder / f"{found.kind}-{sheet.name}.svg").write_text(text, encoding="utf-8")


def page() -> str:
    """The page."""
    parts = (line for title, found in machines().items() for line in section(title, found))
    return "\n".join([HEAD, *parts]) + "\n"
