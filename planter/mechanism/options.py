"""What commands for any machine share: how they name and load it, and options that machines of one model refuse."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from planter.errors import InputError

if TYPE_CHECKING:
    from planter.engine.machine import Machine

NO_STAGES = "it has no gear stages"
REFUSED = {
    "--flank": "it has no cam whose flanks a paper leaves open",
    "--target": "no paper reports figures of it; --data takes a measured curve",
    "--lift": "it lifts assumptions of the planting device",
    "--model": "it has one model, its statement",
    "--teeth": NO_STAGES,
    "--module": NO_STAGES,
    "--module1": NO_STAGES,
    "--module2": NO_STAGES,
}
"""Options that do not apply to machines of one model, with the reason."""


def refuse_options(machine: Machine, options: Mapping[str, bool]) -> None:
    """Raise InputError for the first of some options that is present, which says why it does not apply."""
    for option, is_present in options.items():
        if is_present:
            raise InputError(f"{option} does not apply to {machine.name}: {REFUSED[option]}")
