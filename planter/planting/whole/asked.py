"""Whole teeth as the options of a command ask for them."""

from __future__ import annotations

from planter.errors import InputError
from planter.gear_geometry.cutting import MIN_TEETH
from planter.gears import request
from planter.planting.whole.wanted import Wanted


def wanted(module: float | None, module1: float | None, module2: float | None, teeth: str | None) -> Wanted | None:
    """What the options of a command ask for, modules in mm; None where they ask for nothing.

    Raises InputError for teeth without a module, or not for each stage that has one, or fewer than a gear may have.
    """
    modules = request.parse_modules(module, module1, module2)
    counts = request.parse_tooth_counts(teeth)
    found = Wanted(tuple(None if m is None else m * 1e-3 for m in modules), (None, None))
    if not found.stages:
        if counts:
            raise InputError(
                f"--teeth {teeth} is not allowed without a module: --module, or --module1 and --module2, must say which"
            )
        return None
    if not counts:
        return found
    if len(counts) != len(found.stages):
        allowed = "Z1,Z2" if len(found.stages) == 2 else f"Z, the teeth of stage {found.stages[0] + 1}, which has one"
        raise InputError(f"--teeth {teeth} is not allowed: it must be {allowed}, one for each stage with a module")
    few = [z for z in counts if z < MIN_TEETH]
    if few:
        raise InputError(f"--teeth {teeth} is not allowed: there must be at least {MIN_TEETH} on a gear")
    return found.of(counts)
