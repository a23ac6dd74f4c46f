"""The page of labelled drawings of every machine, with the tables of their symbols that `planter explain` prints."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache
from pathlib import Path

from book.keys import cell
from planter.explain.machine import LabelledMachine, draw_machine
from planter.explain.results import DrawnSymbol
from planter.report import style
from planter.view.sheet import draw_figure

MACHINES = {
    "Planting device": "wang2017",
    "Clutch": "shi2021",
    "Seedling pick-up": "yu2023",
    "Kinematic mapping": "sun2019-corrected",
}
HEAD = """\
# Drawings and symbols

Every length, angle and point of the machines' geometry with its key in the machine's file and its column in CSV files,
as `planter explain MACHINE` tells it; of a machine of your own, `planter explain my.toml --out drawn` writes the same
drawings. Arrows turn the way in which an angle is counted.
"""


@cache
def machines() -> dict[str, LabelledMachine]:
    """The machines by the title of their section."""
    return {title: draw_machine(source, {}) for title, source in MACHINES.items()}


def rows(symbols: list[DrawnSymbol]) -> Iterator[str]:
    """A table of symbols."""
    yield "| symbol | meaning | unit | key | column |"
    yield "|---|---|---|---|---|"
    for one in symbols:
        places = [f"`{place}`" if place else "" for place in (one.key, one.column)]
        yield f"| `{one.name}` | {cell(one.meaning)} | {one.unit} | {' | '.join(places)} |"


def section(title: str, found: LabelledMachine) -> Iterator[str]:
    """A machine: every drawing with its table, then what is on none, and why."""
    symbols = found.symbols()
    yield f"\n## {title}\n"
    for sheet in found.labelled.sheets:
        yield f"\n### {sheet.title[0].upper()}{sheet.title[1:]}\n"
        yield (
            f"```{{figure}} {name(found, sheet.name)}\n:alt: {title}, {sheet.title}\n:figclass: "
            f"drawing\n```\n"
        )
        yield from rows([one for one in symbols if one.name in sheet.names])
    yield f"\n### {title}: what is on no drawing\n"
    yield "| symbol | meaning | why |\n|---|---|---|"
    for one in symbols:
        if one.sheet is None:
            yield f"| `{one.name}` | {cell(one.meaning)} | {cell(one.left_out)} |"


def name(found: LabelledMachine, sheet: str) -> str:
    """The file of a drawing."""
    return f"{found.package}-{sheet}.svg"


def draw(folder: Path) -> None:
    """Writes every drawing."""
    for found in machines().values():
        for sheet in found.labelled.sheets:
            (folder / name(found, sheet.name)).write_text(
                style.render_svg(draw_figure(sheet)), encoding="utf-8"
            )


def page() -> str:
    """The page."""
    parts = (line for title, found in machines().items() for line in section(title, found))
    return "\n".join([HEAD, *parts]) + "\n"
