"""The optimum as a machine file: every input as it was, the design replaced, what moved told beside it."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping

from planter.files import paths, units
from planter.files.document import lines
from planter.optimise.range_and_spread import Sampling
from planter.planting.file import Machine
from planter.planting.results.optimised import OptimisationFound
from planter.version import __version__

SET = "assumed; set on the command line"
"""Origin of a number that was set for one call: the file's own word for it no longer holds."""

ROUNDED = 1e-15
"""Relative difference that the way through SI units makes."""


def text(machine: Machine, model: str, result: OptimisationFound, sampling: Sampling) -> str:
    """A machine file (TOML) with an optimum of `machine` as its design.

    Fed back it gives the
    optimum's objective: the samples of the search stand in it, where it had any.
    """
    own, table = machine.numbers(), machine.table()
    table["design"] = {name: _shown(machine, name, value) for name, value in result.design.items()}
    if sampling != "refined":
        table["objective"]["samples"] = int(sampling)
    reached = Machine.read(table, machine.source).numbers()
    was = {path: own[path] for path, value in reached.items() if value != own[path]}
    how = f"{model} model, {result.method}, seed {result.seed}, " + (
        "true extremes and integrals" if sampling == "refined" else f"{sampling} samples"
    )
    table["origin"] = _origins(machine, was, how)
    head = [
        f"# The machine {json.dumps(machine.name)} with its design optimised by planter {__version__}: {how}.",
        f"# Objective {result.objective!r}, before {result.start_objective!r}. A comment tells what moved.",
    ]
    if result.teeth is not None:
        told = (f"stage {one.stage} has {one.z} teeth of {one.module_mm:.12g} mm" for one in result.teeth.stages)
        head.append(f"# Whole teeth: {', '.join(told)}.")
    notes = {path: f"was {' '.join((repr(value), units.unit(path))).rstrip()}" for path, value in was.items()}
    return "\n".join([*head, "", *lines(table, notes)]) + "\n"


def _shown(machine: Machine, name: str, value: float) -> float:
    """A design value whose way through SI units may have cost it its last bits: where it was, or within its bounds."""
    own, (lower, upper) = machine.design[name], machine.bounds[name]
    return own if math.isclose(value, own, rel_tol=ROUNDED) else min(max(value, lower), upper)


def _origins(machine: Machine, was: Mapping[str, float], how: str) -> dict[str, str]:
    """Origins of the file, with words of their own for the numbers that moved or were set on the command line."""
    changed = dict.fromkeys((*machine.changed, *was), SET)
    changed |= dict.fromkeys((path for path in was if path.startswith("design.")), f"optimised ({how})")
    named = set(changed) | {paths.last_part(path) for path in changed}
    return {name: words for name, words in machine.origins.items() if name not in named} | changed
