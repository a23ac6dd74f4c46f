"""An optimum as a file that the commands take."""

from __future__ import annotations

from planter.files import units
from planter.files.written import lines
from planter.mechanism.optimisation import Found
from planter.version import __version__


def text(found: Found) -> str:
    """A mechanism's file (TOML) with the optimum's values, and what they were beside them."""
    result, table = found.result, found.machine.table()
    table["folder"] = str(found.machine.place)
    moved = {key: result.start_design[key] for key, value in result.design.items() if value != result.start_design[key]}
    notes = {f"values.{key}": f"was {value!r} {units.unit(key)}".rstrip() for key, value in moved.items()}
    origin = {f"values.{key}": f"optimised (least {result.least})" for key in moved}
    table["origin"] = found.machine.origins | origin
    limits = "; ".join(one.limit_on for one in result.holds)
    head = [
        f"# {found.machine.name} with least {result.least}{f' under {limits}' if limits else ''}.",
        f"# By planter {__version__}.",
        f"# Reached {result.objective!r}, before {result.start_objective!r}.",
    ]
    order = dict(sorted(table.items(), key=lambda pair: isinstance(pair[1], dict)))
    return "\n".join([*head, "", *lines(order, notes)]) + "\n"
