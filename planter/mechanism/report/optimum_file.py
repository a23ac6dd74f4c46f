"""An optimum as a file that the commands take."""

from __future__ import annotations

from planter.files import units
from planter.files.written import lines
from planter.mechanism.optimisation import Found
from planter.version import __version__


def text(found: Found) -> str:
    """Return the machine's file (TOML) with the optimum's values, and what they were beside them."""
    result, machine = found.result, found.machine
    table, paths = machine.document.written_table(), [machine.values[index].path for index in machine.moved]
    start = dict(zip(paths, result.start_design.values(), strict=True))
    moved = [path for path, value in zip(paths, result.design.values(), strict=True) if value != start[path]]
    notes = {path: f"was {start[path]!r} {units.unit(path)}".rstrip() for path in moved}
    table["origin"] = machine.document.origins | dict.fromkeys(moved, f"optimised (least {result.least})")
    limits = "; ".join(one.limit_on for one in result.holds)
    head = [
        f"# {found.machine.name} with least {result.least}{f' under {limits}' if limits else ''}.",
        f"# By planter {__version__}.",
        f"# Reached {result.objective!r}, before {result.start_objective!r}.",
    ]
    order = dict(sorted(table.items(), key=lambda pair: isinstance(pair[1], dict)))
    return "\n".join([*head, "", *lines(order, notes)]) + "\n"
