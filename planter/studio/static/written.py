"""A machine's file as a page writes it: its lines, and what each number changes in them when a hand moves it."""

from __future__ import annotations

import difflib
from typing import Any

from planter.errors import ComputationError
from planter.view.portable import Movable
from planter.view.subject import Control

HOLE = "{}"
"""Where a moved number stands in a line."""
SHARE = 0.381966011250105
"""Of its way to a bound, at which a number is tried: it stands nowhere else in the file."""


def template(machine: Movable) -> dict[str, Any]:
    """Own lines, and edits by path: `from` and `to` are lines of those that others stand in the place of.

    Raises ComputationError where two numbers stand in the same line.
    """
    own = {one.path: one.value for one in machine.controls}
    lines = machine.handed(own).splitlines()
    edits = {one.path: _edits(machine, own, lines, one) for one in machine.controls}
    replaced = [line for found in edits.values() for edit in found for line in range(edit["from"], edit["to"])]
    if len(set(replaced)) < len(replaced):
        raise ComputationError(f"{machine.name}: a page without a server cannot write its file, line by line")
    return {"lines": lines, "edits": edits}


def _edits(machine: Movable, own: dict[str, float], lines: list[str], one: Control) -> list[dict[str, Any]]:
    bound = one.upper if one.upper > one.value else one.lower
    tried = one.value + SHARE * (bound - one.value)
    moved = machine.handed(own | {one.path: tried}).splitlines()
    return [
        {"from": i, "to": j, "lines": [line.replace(repr(tried), HOLE) for line in moved[k:m]]}
        for kind, i, j, k, m in difflib.SequenceMatcher(None, lines, moved, autojunk=False).get_opcodes()
        if kind != "equal"
    ]
