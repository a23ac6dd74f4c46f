"""The optimum as a machine file: every input as it was, the design replaced, what moved told beside it."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping
from typing import Any

from planter.files import paths, units
from planter.optimise.range_and_spread import Sampling
from planter.planting.file import Machine
from planter.planting.results import OptimisationFound
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
    return "\n".join([*head, "", *_lines(table, was)]) + "\n"


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


def _lines(table: Mapping[str, Any], was: Mapping[str, float]) -> Iterator[str]:
    """The keys outside sections, then the sections; behind a number that moved stands what it was."""
    yield from (f"{_key(key)} = {_value(value)}" for key, value in table.items() if not isinstance(value, Mapping))
    for section, values in table.items():
        if isinstance(values, Mapping):
            yield from ("", f"[{_key(section)}]")
            for key, value in values.items():
                path = f"{section}.{key}"
                before = f"  # was {' '.join((repr(was[path]), units.unit(key))).rstrip()}" if path in was else ""
                yield f"{_key(key)} = {_value(value)}{before}"


def _key(name: str) -> str:
    plain = name.isascii() and name.replace("_", "").replace("-", "").isalnum()
    return name if plain else _value(name)


def _value(value: Any) -> str:
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, list):
        return f"[{', '.join(map(_value, value))}]"
    return repr(value)
