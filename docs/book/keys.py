"""The page of machine files' keys, by the dictionary that `planter explain` reads."""

from __future__ import annotations

from itertools import groupby

from planter.explain import dictionary

HEAD = """\
# Keys of machine files

Every key that holds a value, as `planter explain` tells it. Where a number comes from (paper, assumed, calibrated,
measured) stands in the file itself, in its table `[origin]`: `planter example NAME`.
"""


def cell(text: str | None) -> str:
    """Text in a table's cell."""
    return (text or "").replace("|", "\\|").replace("<", "\\<").replace("[", "\\[").replace("*", "\\*")


def page() -> str:
    """The page."""
    found = sorted(
        (one for one in dictionary.every() if one.kind == "file key"), key=lambda one: (one.machine, one.key)
    )
    parts = [HEAD]
    for machine, own in groupby(found, key=lambda one: one.machine):
        parts += [f"\n## {machine}\n", "| key | unit | meaning | allowed |", "|---|---|---|---|"]
        parts += [f"| `{one.key}` | {cell(one.unit)} | {cell(one.meaning)} | {cell(one.allowed)} |" for one in own]
    return "\n".join(parts) + "\n"
