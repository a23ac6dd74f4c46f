"""The page of machine files' keys, by the dictionary of `planter about explain`, with what built-in files hold."""

from __future__ import annotations

import re
from itertools import groupby
from typing import TYPE_CHECKING

import planter
from planter.cli import dictionary
from planter.papers.pickup.file import load_pickup as load_pick_up
from planter.papers.planting import file as planting

if TYPE_CHECKING:
    from planter.cli.results import Meaning
    from planter.files.document import Document

HEAD = """\
# Keys of machine files

Every key that holds a value, as `planter about explain` tells it: what it means, what is allowed, and, where the
built-in file named above a table has it, its value there and where that comes from (paper, assumed, calibrated,
measured). `planter example NAME` prints such a file.
"""
BUILT_IN = {
    "clutch": (planter.load_clutch, "shi2021"),
    "mapping": (planter.load_poses, "sun2019-corrected"),
    "pickup": (load_pick_up, "yu2023"),
    "planting": (planting.load, "wang2017"),
}
MOST = 6
"""Values of a list that are shown."""
_ITEM = re.compile(r"\[\d+\]")


def cell(text: str | None) -> str:
    """Text in a table's cell."""
    return (
        (text or "").replace("|", "\\|").replace("<", "\\<").replace("[", "\\[").replace("*", "\\*")
    )


def held(document: Document | None, key: str) -> tuple[str, str]:
    """What a file holds under a key, all items of a list, and where it comes from; nothing where it has no number."""
    own = document.numbers() if document is not None else {}
    numbers = {path: value for path, value in own.items() if _ITEM.sub("", path) == key}
    if document is None or not numbers:
        return "", ""
    shown = ", ".join(f"{value:g}" for value in list(numbers.values())[:MOST])
    return f"{shown}{', ...' if len(numbers) > MOST else ''}", document.origin(next(iter(numbers)))


def row(one: Meaning, document: Document | None) -> str:
    """A key with all that is said of it."""
    value, origin = held(document, one.key or "")
    told = (cell(one.unit), cell(one.meaning), cell(one.allowed), value, cell(origin))
    return f"| `{one.key}` | {' | '.join(told)} |"


def page() -> str:
    """The page."""
    found = sorted(
        (one for one in dictionary.collect_meanings() if one.kind == "file key"),
        key=lambda one: (one.machine, one.key),
    )
    parts = [HEAD]
    for machine, own in groupby(found, key=lambda one: one.machine):
        load, name = BUILT_IN.get(machine, (None, None))
        document = load(name) if load else None
        parts.append(
            f"\n## {machine}\n\n{f'Built in: `{name}`.' if name else 'None is built in.'}\n"
        )
        parts += [
            "| key | unit | meaning | allowed | built in | origin |",
            "|---|---|---|---|---|---|",
        ]
        parts += [row(one, document) for one in own]
    return "\n".join(parts) + "\n"
