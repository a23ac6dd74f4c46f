"""Printed numbers on trial: each is computed anew from what its paper discloses, and judged by rule.

A paper's numbers stand in a file `NAME.toml` of a room's `printed`. [disclosed] holds inputs that the paper gives,
[assumed] inputs that it does not give. Every [[number]] holds the printed text (its digits are its precision), the
formula `by` which it is computed, and that formula's own arguments `with`. An input with a decimal point is rounded as
it is printed, a whole number is exact. `each` makes a row of numbers: lists of one
length, of which every number takes its entry; `{name}` in `quantity` is replaced by it. `needs` lists inputs that are
neither disclosed nor assumed; `reading` says how a print that can be read in two ways was read.

Every [[claim]] is a statement of the text, the formula `by` which it is measured, and what the measure `must` be for it
to be true. Every [[headline]] is a printed number that rests on equations or on other numbers (`quantities`), with
formulas that compute it `as_printed` and `as_derived`. [[chain]] names the built-in machine of a chain of equations,
what its laws say of the force (`laws`), and which of them fixes the force from masses and motion alone.
"""

from __future__ import annotations

import pkgutil
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from decimal import Decimal
from functools import cache
from importlib import import_module
from types import ModuleType
from typing import Any

import numpy as np

from planter import rooms
from planter.audit import slips
from planter.audit.registry import FORMULAS, Computation, Inputs, Rounded, half_place
from planter.errors import ComputationError
from planter.files.text import parse_toml

SUFFIX = ".toml"
ROWS = ("number", "claim", "headline", "chain")
_TIE = 2e-9
"""Part of half the last printed place by which a value may pass its half: a tie in decimals is not one in binary."""


@dataclass(frozen=True)
class Number:
    """A number as a paper prints it, at a place, and how it is computed anew."""

    paper: str
    quantity: str
    unit: str
    printed: str
    by: str
    arguments: Mapping[str, Any]
    needs: Sequence[str] = field(default_factory=tuple)
    reading: str = ""
    place: str = ""

    def agrees_with(self, computed: Computation) -> bool:
        """Whether the printed number, as far as its digits go, meets what was computed from rounded inputs."""
        if computed.value is None or computed.interval is None:
            return False
        low, high = computed.interval
        nearest = min(max(float(self.printed), low), high)
        return equal(self.printed, computed.value) or equal(self.printed, nearest)


@dataclass(frozen=True)
class Recomputed:
    """A printed number and its computation from the paper's inputs; `reason` says why that did not succeed."""

    number: Number
    computed: Computation
    reason: str = ""

    @property
    def assumed(self) -> Sequence[str]:
        """Assumed inputs that the computation took."""
        return self.computed.inputs.assumed

    @property
    def equal(self) -> bool:
        """Whether both are equal at the printed precision."""
        return self.computed.value is not None and equal(self.number.printed, self.computed.value)


@cache
def data() -> dict[str, Any]:
    """The printed numbers of all papers: inputs by paper, and rows that name theirs.

    They stand in files `NAME.toml` of the rooms' `printed`, whose modules enter the formulas in the registry.
    """
    for room in rooms.brought("printed"):
        load(room)
    files = [file for folder in rooms.folders("printed").values() for file in folder.iterdir()]
    read = {f.name[: -len(SUFFIX)]: parse_toml(f.read_text(encoding="utf-8"), f.name, Rounded)
            for f in files if f.name.endswith(SUFFIX)}  # fmt: skip
    papers = sorted(read, key=lambda name: (read[name]["place"], name))
    single: dict[str, Any] = {key: {name: read[name][key] for name in papers} for key in ("disclosed", "assumed")}
    rows = {kind: [{"paper": name, **row} for name in papers for row in read[name].get(kind, ())] for kind in ROWS}
    return {"papers": {name: read[name]["title"] for name in papers}, **single, **rows}


def load(room: ModuleType) -> None:
    """Have the modules of a room's `printed` enter their formulas in the registry."""
    for found in sorted(pkgutil.iter_modules(room.__path__)):
        import_module(f"{room.__name__}.{found.name}")


def papers() -> dict[str, str]:
    """Title of each paper by its short name."""
    found: dict[str, str] = data()["papers"]
    return found


def judged(paper: str | None = None, content: Mapping[str, Any] | None = None) -> list[dict[str, Any]]:
    """Every printed number, or those of one paper, with its verdict, as the interface gives them.

    A verdict depends on a paper's other numbers as well, so a paper is always judged as a whole. Of one that is not
    reproduced, `cured_by` names the slip in a disclosed input that explains it with others, and `cured_to` what it then
    comes to.
    """
    table = data() if content is None else content
    found = [recompute(number, table) for number in numbers(table) if paper in (None, number.paper)]
    entries = [entry(one, verdict(one, found)) for one in found]
    for name in dict.fromkeys(one.number.paper for one in found):
        wrong = [i for i, e in enumerate(entries) if e["paper"] == name and e["verdict"] == "not reproduced"]
        unmet = [found[i].number for i in wrong]
        for slip in slips.found(unmet, table["disclosed"][name], table["assumed"][name]):
            for place, value in slip.cured.items():
                entries[wrong[place]] |= {"cured_by": slip.what, "cured_to": value}
    return entries


def causes(entries: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Slips in disclosed inputs, each with the numbers that are not reproduced for it alone."""
    cured: dict[tuple[str, str], list[str]] = {}
    for one in entries:
        if one["cured_by"]:
            cured.setdefault((one["paper"], one["cured_by"]), []).append(f"{one['paper']}: {one['quantity']}")
    return [{"paper": paper, "cause": what, "repair": what, "equations": [], "numbers": names}
            for (paper, what), names in cured.items()]  # fmt: skip


def numbers(table: Mapping[str, Any]) -> Iterator[Number]:
    """The numbers of a data file, rows of numbers one by one."""
    for row in table["number"]:
        each: Mapping[str, Sequence[Any]] = row.get("each", {})
        texts: Sequence[str] = row["printed"] if each else [row["printed"]]
        for index, text in enumerate(texts):
            own = {name: values[index] for name, values in each.items()}
            quantity = row["quantity"].format_map(own)
            arguments = {**row.get("with", {}), **own}
            origin = (row["paper"], quantity, row["unit"], text, row["by"], arguments)
            reading = own.get("reading", row.get("reading", ""))
            yield Number(*origin, row.get("needs", ()), reading, row.get("place", "").format_map(own))


def recompute(number: Number, table: Mapping[str, Any]) -> Recomputed:
    """Compute a number from its paper's inputs; what was assumed is seen from what the formula reads.

    A computation that does not succeed is that of this number alone: there is no value then, but a reason.
    """
    inputs = Inputs(number.arguments, table["disclosed"][number.paper], table["assumed"][number.paper])
    try:
        return Recomputed(number, Computation.of(number.by, inputs))
    except ComputationError as error:
        return Recomputed(number, Computation(FORMULAS[number.by], inputs, None), str(error))


def equal(printed: str, value: float) -> bool:
    """Whether a value rounds to a printed number: it is at most half of the last printed place away.

    >>> equal("8.6", 8.649), equal("8.6", 8.66), equal("-8.52e-5", -8.517e-5), equal("45.5", 45.45)
    (True, False, True, True)
    """
    return abs(Decimal(value) - Decimal(printed)) <= Decimal(half_place(printed)) * (1 + Decimal(_TIE))


def verdict(one: Recomputed, of_paper: Sequence[Recomputed]) -> str:
    """The verdict by rule.

    From disclosed inputs alone a number is reproduced if it is equal at the printed precision, consistent if one choice
    of the unrounded inputs gives it together with all that are reproduced, else not reproduced. One that rests on
    assumed inputs is consistent if it is hit and if the same inputs, or part of them, hit more printed values than they
    are many; else, or where an undisclosed input is needed or the computation does not succeed, it is not recomputable.
    """
    if one.number.needs or one.reason:
        return "not recomputable"
    if not one.assumed:
        if one.equal:
            return "reproduced"
        return (
            "consistent" if one.number.agrees_with(one.computed) and fits_jointly(one, of_paper) else "not reproduced"
        )
    return "consistent" if one.equal and hits(one, of_paper) > len(one.assumed) else "not recomputable"


def fits_jointly(one: Recomputed, of_paper: Sequence[Recomputed]) -> bool:
    """Whether inputs within their rounding give a number and, at once, all that the rounded ones reproduce.

    A linear feasibility problem in the roundings u of the inputs, -1 <= u <= 1 half a unit of the last digit each.
    """
    from scipy.optimize import linprog  # a fifth of a second that few numbers need

    reproduced = (
        other
        for other in of_paper
        if other.number.paper == one.number.paper and other.equal and not other.assumed and not other.number.needs
    )
    together = [(each.number.printed, each.computed) for each in (one, *reproduced)]
    keys = sorted(set().union(*(computed.effects for _, computed in together)))
    rows = np.array([[computed.effects.get(key, 0.0) for key in keys] for _, computed in together])
    gaps = np.array([float(printed) - float(computed.value or 0.0) for printed, computed in together])
    reach = np.array([half_place(printed) * (1 + _TIE) for printed, _ in together])
    scaled = np.vstack([rows, -rows]) / np.tile(reach, 2)[:, None]
    found = linprog(np.zeros(len(keys)), scaled, np.concatenate([gaps + reach, reach - gaps]) / np.tile(reach, 2),
                    bounds=(-1, 1))  # fmt: skip
    return bool(found.status == 0)


def hits(one: Recomputed, of_paper: Sequence[Recomputed]) -> int:
    """How many printed values of the paper are hit by nothing more than this number's assumed inputs.

    Equal digits from one formula count once.
    """
    found = {
        (other.number.by, other.number.printed)
        for other in of_paper
        if other.equal
        and other.assumed
        and not other.number.needs
        and other.number.paper == one.number.paper
        and set(other.assumed) <= set(one.assumed)
    }
    return len(found)


def entry(one: Recomputed, judgement: str) -> dict[str, Any]:
    """A judged number as the interface gives it; `printed_text` holds the digits that are printed.

    `difference` is what was computed less what is printed; `interval` the lowest and highest value within the rounding
    of printed inputs, where the value itself differs from the print.
    """
    number, value = one.number, one.computed.value
    return {
        "paper": number.paper,
        "place": number.place,
        "quantity": number.quantity,
        "unit": number.unit,
        "printed": float(number.printed),
        "recomputed": value,
        "interval": _interval(one),
        "difference": None if value is None else value - float(number.printed),
        "verdict": judgement,
        "assumed_inputs": list(one.assumed),
        "needs": list(number.needs),
        "printed_text": number.printed,
        "reading": number.reading,
        "reason": one.reason,
        "formula": number.by,
        "cured_by": "",
        "cured_to": None,
    }


def _interval(one: Recomputed) -> list[float] | None:
    """The interval of a number that is judged by it: one from disclosed inputs alone that is not met exactly."""
    if one.number.needs or one.assumed or one.equal or one.computed.interval is None:
        return None
    return list(one.computed.interval)
