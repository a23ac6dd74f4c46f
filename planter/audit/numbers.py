"""Audit of printed numbers: each is recomputed from what its paper discloses, and judged by rule.

A paper's numbers are in a file `NAME.toml` of a package's `printed`. [disclosed] holds inputs that
the paper gives, [assumed] inputs that it does not give. Every [[number]] holds the printed text
(its digits are its precision), the formula `by` which it is computed, and that formula's own
arguments `with`. An input with a decimal point is rounded as it is printed, a whole number is
exact. `each` makes a row of numbers: lists of one length, of which every number takes its entry;
`{name}` in `quantity` is replaced by it. `needs` lists inputs that are neither disclosed nor
assumed; `reading` says how a print that can be read in two ways was read.

Every [[claim]] is a statement of the text, the formula `by` which it is measured, and what the
measure `must` be for it to be true. Every [[headline]] is a printed number that rests on equations
or on other numbers (`quantities`), with formulas that compute it `as_printed` and `as_derived`.
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
import scipy

from planter import plugins
from planter.audit.registry import FORMULAS, Computation, Inputs, Rounded, half_place
from planter.errors import ComputationError, PlanterError
from planter.text_files import parse_toml

MIN_NUMBERS = 3
"""Smallest number of printed numbers that a sign error must explain; fewer may agree by chance."""
SAMPLE_SIZE = 12
"""Numbers on which a sign is tried first."""


def find_sign_errors(
    numbers: Sequence[PrintedNumber], disclosed: Mapping[str, Any], assumed: Mapping[str, Any]
) -> list[tuple[str, dict[int, float]]]:
    """Return sign errors in disclosed inputs that explain numbers that are not reproduced, the most
    explanatory first: the cause, and the values that it gives numbers, by index.

    Each explains only numbers that no earlier one explains.
    """
    remaining, errors = dict(enumerate(numbers)), list[tuple[str, dict[int, float]]]()
    while len(remaining) >= MIN_NUMBERS:
        trials = [
            (cause, _list_cured(remaining, {**disclosed, **inputs}, assumed))
            for cause, inputs in _reverse_signs(disclosed)
        ]
        best = max(trials, key=lambda trial: len(trial[1]), default=("", {}))
        if len(best[1]) < MIN_NUMBERS:
            break
        errors.append(best)
        for index in best[1]:
            del remaining[index]
    return errors


def _reverse_signs(disclosed: Mapping[str, Any]) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield the numbers in short lists of disclosed inputs with reversed signs."""
    for name, value in disclosed.items():
        if (
            isinstance(value, list)
            and len(value) <= MIN_NUMBERS
            and all(isinstance(v, int | float) for v in value)
        ):
            for index, entry in enumerate(value):
                if entry:
                    yield (
                        f"sign of {entry:g} in {name}",
                        {name: [*value[:index], -entry, *value[index + 1 :]]},
                    )


def _list_cured(
    numbers: Mapping[int, PrintedNumber], disclosed: Mapping[str, Any], assumed: Mapping[str, Any]
) -> dict[int, float]:
    """Return the values of the numbers that agree with their print, none if none of the first
    `SAMPLE_SIZE` does.
    """
    cured: dict[int, float] = {}
    for count, (index, number) in enumerate(numbers.items()):
        if count == SAMPLE_SIZE and not cured:
            break
        try:
            inputs = Inputs(number.arguments, disclosed, assumed)
            computed = Computation.evaluate(number.by, inputs)
        except (PlanterError, ArithmeticError, ValueError):
            continue
        if computed.value is not None and number.agrees_with(computed):
            cured[index] = computed.value
    return cured


SUFFIX = ".toml"
ROWS = ("number", "claim", "headline")
_TIE = 2e-9
"""Share of half the last printed place by which a value may exceed it: decimal ties are not exact
in binary.
"""


@dataclass(frozen=True)
class PrintedNumber:
    """A number as a paper prints it, its place, and its computation."""

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
        """Return whether the printed number agrees, within its digits, with the computation from
        rounded inputs.
        """
        if computed.value is None or computed.interval is None:
            return False
        low, high = computed.interval
        nearest = min(max(float(self.printed), low), high)
        return equals_printed(self.printed, computed.value) or equals_printed(self.printed, nearest)


@dataclass(frozen=True)
class Recomputed:
    """A printed number and its computation from the paper's inputs; `reason` explains a failure."""

    number: PrintedNumber
    computed: Computation
    reason: str = ""

    @property
    def assumed(self) -> Sequence[str]:
        """Assumed inputs of the computation."""
        return self.computed.inputs.assumed

    @property
    def equal(self) -> bool:
        """Whether both are equal at the printed precision."""
        return self.computed.value is not None and equals_printed(
            self.number.printed, self.computed.value
        )


@cache
def load_numbers() -> dict[str, Any]:
    """Return the printed numbers of all papers: inputs by paper, and rows with the names of their
    papers.

    They come from files `NAME.toml` of packages `printed`, whose modules register the formulas.
    """
    for package in plugins.load_modules("printed"):
        load_formulas(package)
    files = [
        file for folder in plugins.find_folders("printed").values() for file in folder.iterdir()
    ]
    tables = {
        f.name[: -len(SUFFIX)]: parse_toml(f.read_text(encoding="utf-8"), f.name, Rounded)
        for f in files
        if f.name.endswith(SUFFIX)
    }
    papers = sorted(tables, key=lambda name: (tables[name]["place"], name))
    content: dict[str, Any] = {"papers": {name: tables[name]["title"] for name in papers}}
    for key in ("disclosed", "assumed"):
        content[key] = {name: tables[name][key] for name in papers}
    for kind in ROWS:
        rows = [(name, row) for name in papers for row in tables[name].get(kind, ())]
        content[kind] = [{"paper": name, **row} for name, row in rows]
    return content


def load_formulas(package: ModuleType) -> None:
    """Import the modules of `printed`, if it is a package; modules register their formulas when
    they are imported.
    """
    for module in sorted(pkgutil.iter_modules(getattr(package, "__path__", ()))):
        import_module(f"{package.__name__}.{module.name}")


def list_papers() -> dict[str, str]:
    """Return the title of each paper by its short name."""
    titles: dict[str, str] = load_numbers()["papers"]
    return titles


def judge_numbers(
    paper: str | None = None, content: Mapping[str, Any] | None = None
) -> list[dict[str, Any]]:
    """Return every printed number, or those of one paper, with verdicts, in the form of the result.

    A verdict also depends on a paper's other numbers, so a paper is always judged completely. For a
    number that is not reproduced, `cured_by` names the sign error in a disclosed input that
    explains it and others, and `cured_to` is the value without that error.
    """
    table = load_numbers() if content is None else content
    numbers = [number for number in list_numbers(table) if paper in (None, number.paper)]
    computed = [recompute(number, table) for number in numbers]
    entries = [build_entry(each, decide_verdict(each, computed)) for each in computed]
    for name in dict.fromkeys(number.paper for number in numbers):
        wrong = [
            i
            for i, e in enumerate(entries)
            if e["paper"] == name and e["verdict"] == "not reproduced"
        ]
        unmet = [numbers[i] for i in wrong]
        errors = find_sign_errors(unmet, table["disclosed"][name], table["assumed"][name])
        for cause, cured in errors:
            for index, value in cured.items():
                entries[wrong[index]] |= {"cured_by": cause, "cured_to": value}
    return entries


def list_causes(entries: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Return the errors in disclosed inputs, each with the numbers that only it prevents."""
    cured: dict[tuple[str, str], list[str]] = {}
    for entry in entries:
        if entry["cured_by"]:
            named = cured.setdefault((entry["paper"], entry["cured_by"]), [])
            named.append(f"{entry['paper']}: {entry['quantity']}")
    return [
        {"paper": paper, "cause": cause, "repair": cause, "equations": [], "numbers": names}
        for (paper, cause), names in cured.items()
    ]


def list_numbers(table: Mapping[str, Any]) -> Iterator[PrintedNumber]:
    """Yield the numbers of a data file, with rows of numbers expanded."""
    for row in table["number"]:
        entries = expand_each(row)
        texts: Sequence[str] = row["printed"] if row.get("each") else [row["printed"]]
        for text, entry in zip(texts, entries, strict=True):
            yield PrintedNumber(
                row["paper"],
                row["quantity"].format_map(entry),
                row["unit"],
                text,
                row["by"],
                {**row.get("with", {}), **entry},
                row.get("needs", ()),
                entry.get("reading", row.get("reading", "")),
                row.get("place", "").format_map(entry),
            )


def expand_each(row: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return the entries of `each` of a row, one for each of its numbers."""
    each: Mapping[str, Sequence[Any]] = row.get("each", {})
    return [
        dict(zip(each, values, strict=True)) for values in zip(*each.values(), strict=True)
    ] or [{}]


def recompute(number: PrintedNumber, table: Mapping[str, Any]) -> Recomputed:
    """Compute a number from its paper's inputs, and record the assumed inputs that the formula
    reads.

    If the computation fails, the result has a reason instead of a value.
    """
    inputs = Inputs(
        number.arguments, table["disclosed"][number.paper], table["assumed"][number.paper]
    )
    try:
        return Recomputed(number, Computation.evaluate(number.by, inputs))
    except ComputationError as error:
        return Recomputed(number, Computation(FORMULAS[number.by], inputs, None), str(error))


def equals_printed(printed: str, value: float) -> bool:
    """Return whether a value rounds to a printed number, that is, differs by at most half of the
    last place.

    >>> equals_printed("8.6", 8.649), equals_printed("8.6", 8.66)
    (True, False)
    >>> equals_printed("-8.52e-5", -8.517e-5), equals_printed("45.5", 45.45)
    (True, True)
    """
    return abs(Decimal(value) - Decimal(printed)) <= Decimal(half_place(printed)) * (
        1 + Decimal(_TIE)
    )


def decide_verdict(recomputed: Recomputed, of_paper: Sequence[Recomputed]) -> str:
    """Return the verdict by rule.

    From disclosed inputs alone a number is reproduced if it is equal at the printed precision,
    consistent if one choice of the unrounded inputs gives it together with all that are reproduced,
    else not reproduced. One that rests on assumed inputs is consistent if it is hit and if the same
    inputs, or part of them, hit more printed values than they are many; else, or where an
    undisclosed input is needed or the computation does not succeed, it is not recomputable.
    """
    if recomputed.number.needs or recomputed.reason:
        return "not recomputable"
    if not recomputed.assumed:
        if recomputed.equal:
            return "reproduced"
        return (
            "consistent"
            if recomputed.number.agrees_with(recomputed.computed)
            and fits_jointly(recomputed, of_paper)
            else "not reproduced"
        )
    return (
        "consistent"
        if recomputed.equal and count_hits(recomputed, of_paper) > len(recomputed.assumed)
        else "not recomputable"
    )


def fits_jointly(recomputed: Recomputed, of_paper: Sequence[Recomputed]) -> bool:
    """Return whether inputs within their rounding give a number together with all reproduced
    numbers.

    This is a linear feasibility problem in the roundings u of the inputs, -1 <= u <= 1 half a unit
    of the last digit each.
    """
    reproduced = (
        candidate
        for candidate in of_paper
        if candidate.number.paper == recomputed.number.paper
        and candidate.equal
        and not candidate.assumed
        and not candidate.number.needs
    )
    together = [(each.number.printed, each.computed) for each in (recomputed, *reproduced)]
    keys = sorted(set().union(*(computed.effects for _, computed in together)))
    rows = np.array([[computed.effects.get(key, 0.0) for key in keys] for _, computed in together])
    gaps = np.array(
        [float(printed) - float(computed.value or 0.0) for printed, computed in together]
    )
    reach = np.array([half_place(printed) * (1 + _TIE) for printed, _ in together])
    scaled = np.vstack([rows, -rows]) / np.tile(reach, 2)[:, None]
    limits = np.concatenate([gaps + reach, reach - gaps]) / np.tile(reach, 2)
    solution = scipy.optimize.linprog(np.zeros(len(keys)), scaled, limits, bounds=(-1, 1))
    return bool(solution.status == 0)


def count_hits(recomputed: Recomputed, of_paper: Sequence[Recomputed]) -> int:
    """Return how many printed values of the paper follow from a subset of this number's assumed
    inputs.

    Equal digits from one formula count once.
    """
    matches = {
        (candidate.number.by, candidate.number.printed)
        for candidate in of_paper
        if candidate.equal
        and candidate.assumed
        and not candidate.number.needs
        and candidate.number.paper == recomputed.number.paper
        and set(candidate.assumed) <= set(recomputed.assumed)
    }
    return len(matches)


def build_entry(recomputed: Recomputed, judgement: str) -> dict[str, Any]:
    """Return a judged number in the form of the result; `printed_text` has the printed digits.

    `difference` is the computed minus the printed value; `interval` the lowest and highest value
    within the rounding of printed inputs, where the value itself differs from the print.
    """
    number, value = recomputed.number, recomputed.computed.value
    return {
        "paper": number.paper,
        "place": number.place,
        "quantity": number.quantity,
        "unit": number.unit,
        "printed": float(number.printed),
        "recomputed": value,
        "interval": _find_interval(recomputed),
        "difference": None if value is None else value - float(number.printed),
        "verdict": judgement,
        "assumed_inputs": list(recomputed.assumed),
        "needs": list(number.needs),
        "printed_text": number.printed,
        "reading": number.reading,
        "reason": recomputed.reason,
        "formula": number.by,
        "cured_by": "",
        "cured_to": None,
    }


def _find_interval(recomputed: Recomputed) -> list[float] | None:
    """Return the interval of a number from disclosed inputs only that is not met exactly, else
    None.
    """
    if (
        recomputed.number.needs
        or recomputed.assumed
        or recomputed.equal
        or recomputed.computed.interval is None
    ):
        return None
    return list(recomputed.computed.interval)
