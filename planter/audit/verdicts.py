"""`planter audit`: verdicts on equations, laws, numbers and statements of the text, and their
consequences.
"""

from __future__ import annotations

import operator
import re
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from difflib import get_close_matches
from typing import Any

from planter.audit import numbers
from planter.audit.numbers import load_numbers
from planter.audit.registry import FORMULAS, Computation, Inputs, Value
from planter.errors import ComputationError, InputError
from planter.kernels import generated

EXACT = 1e-9
"""Tolerance of exact claims; lengths and angles are of order one, or in mm and deg."""
_TESTS: dict[str, Callable[[float, float], bool]] = {
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
}


def judge_claims(
    paper: str | None = None, content: Mapping[str, Any] | None = None
) -> list[dict[str, Any]]:
    """Return every claim, or those of one paper, with measure, condition, and whether it holds.

    Assumed inputs of the measure are listed; the result is valid only for these inputs. A claim
    holds if some value within the rounding of the printed inputs meets its condition.
    """
    table = load_numbers() if content is None else content
    return [_judge_claim(row, table) for row in table["claim"] if paper in (None, row["paper"])]


def interval_meets(interval: tuple[float, float], must: str, tolerance: float = EXACT) -> bool:
    """Return whether some value of an interval meets a condition.

    >>> interval_meets((-0.02, 0.03), "= 0"), interval_meets((-0.02, 0.03), "> 0")
    (True, True)
    >>> interval_meets((-0.02, -0.01), ">= 0")
    False
    """
    sign, text = must.split()
    (low, high), limit = interval, float(text)
    if sign == "=":
        return low - tolerance <= limit <= high + tolerance
    slack = tolerance if sign in ("<=", ">=") else 0.0
    return _TESTS[sign](high + slack if ">" in sign else low - slack, limit)


def _judge_claim(row: Mapping[str, Any], table: Mapping[str, Any]) -> dict[str, Any]:
    inputs = Inputs(
        row.get("with", {}), table["disclosed"][row["paper"]], table["assumed"][row["paper"]]
    )
    computed = Computation.evaluate(row["by"], inputs)
    interval, limits = computed.interval, (row["must"], row.get("within", EXACT))
    return {
        "paper": row["paper"],
        "claim": row["claim"],
        "measure": row["measure"],
        "value": computed.value,
        "unit": row["unit"],
        "must": re.sub(r"^= ", "be ", row["must"])
        if row["must"].startswith("=")
        else f"be {row['must']}",
        "holds": interval is not None and interval_meets(interval, *limits),
        "assumed_inputs": list(inputs.assumed),
    }


FAULTY = ("misprint", "incomplete", "contradicted")
AT_FAULT = "at fault"
"""Grade of an equation whose difference is neither neglected nor a stated approximation."""
UNJUDGED = "not judged"
Consequence = dict[str, Any]


def derive_consequences(
    paper: str | None, table: Mapping[str, Any], trial: Mapping[str, Sequence[Mapping[str, Any]]]
) -> list[Consequence]:
    """Return the printed numbers of all papers, or of one, that rest on a fault, by the equations as
    printed and as derived.
    """
    consequences: list[Consequence] = []
    for row in table["headline"]:
        rests_on = _find_faults(row, trial)
        if rests_on and paper in (None, row["paper"]):
            entries = numbers.expand_each(row)
            consequences += [_build_headline(row, entry, rests_on, table) for entry in entries]
    return consequences


def _find_faults(
    row: Mapping[str, Any], trial: Mapping[str, Sequence[Mapping[str, Any]]]
) -> list[str]:
    judged = {
        part: [e for e in trial[part] if e["paper"] == row["paper"]]
        for part in ("equations", "numbers")
    }
    equations = {e["equation"] for e in judged["equations"] if e["verdict"] in FAULTY}
    numbers = {e["quantity"] for e in judged["numbers"] if e["verdict"] == "not reproduced"}
    return [name for name in row.get("equations", ()) if name in equations] + [
        name for name in row.get("quantities", ()) if name in numbers
    ]


def _build_headline(
    row: Mapping[str, Any], entry: Mapping[str, Any], rests_on: list[str], table: Mapping[str, Any]
) -> Consequence:
    disclosed, assumed = table["disclosed"][row["paper"]], table["assumed"][row["paper"]]
    values: dict[str, Value] = {}
    inputs = []
    for key in ("as_printed", "as_derived"):
        arguments = {**row.get("with", {}), **row.get(f"with_{key}", {}), **entry}
        inputs.append(Inputs(arguments, disclosed, assumed))
        values[key] = FORMULAS[row[key]](inputs[-1])
    return {
        "paper": row["paper"],
        "quantity": row["quantity"].format_map(entry),
        "unit": row["unit"],
        "printed": float(entry["printed"]) if "printed" in entry else row.get("printed"),
        **values,
        "rests_on": rests_on,
        "assumed_inputs": list(
            dict.fromkeys(text for arguments_read in inputs for text in arguments_read.assumed)
        ),
    }


Entry = Mapping[str, Any]


def audit(paper: str | None = None) -> dict[str, Any]:
    """Return the verdicts on all papers, or on one of them, in the form of the result.

    Raises InputError for an unknown paper.
    """
    papers = list(numbers.list_papers()) if paper is None else [check_paper(paper)]
    verdicts_found = collect_verdicts(
        load_verdicts(),
        numbers.judge_numbers(paper),
        {name: numbers.list_papers()[name] for name in papers},
    )
    derived = derive_consequences(paper, numbers.load_numbers(), verdicts_found)
    return verdicts_found | {
        "claims": _select_papers(judge_claims(paper), papers),
        "consequences": derived,
    }


def collect_verdicts(
    verdicts: Entry, judged: Sequence[Entry], titles: Mapping[str, str]
) -> dict[str, Any]:
    """Return the verdicts on some papers and their numbers, without statements and consequences."""
    names = list(titles)
    number_verdicts = _select_papers(judged, names)
    causes = [*verdicts.get("causes", ()), *numbers.list_causes(number_verdicts)]
    result: dict[str, Any] = {
        "equations": _select_papers(verdicts["equations"], names),
        "laws": _select_papers(verdicts["laws"], names),
        "numbers": number_verdicts,
        "causes": _select_papers(causes, names),
        "references": _select_papers(verdicts.get("references", ()), names),
        "claims": [],
        "consequences": [],
    }
    result["summary"] = {name: _summarise(result, name, title) for name, title in titles.items()}
    rows = {"rows": [dict(row) for row in verdicts["rows"]]} if "rows" in verdicts else {}
    return rows | result


def _summarise(result: Entry, paper: str, title: str) -> dict[str, Any]:
    """Return the counts of verdicts on a paper."""
    parts = ("equations", "laws", "numbers", "causes")
    entries = {part: _select_papers(result[part], [paper]) for part in parts}
    return {
        "title": title,
        "equations": _count_verdicts(entries["equations"]),
        "at_fault": sum(entry["grade"] == AT_FAULT for entry in entries["equations"]),
        "causes": len(entries["causes"]),
        "laws_violated": sum(bool(law["caused_by"]) for law in entries["laws"]),
        "numbers": _count_verdicts(entries["numbers"]),
    }


def check_paper(paper: str) -> str:
    """Return the short name of an existing paper. Raises InputError for an unknown one."""
    papers = list(numbers.list_papers())
    if paper in papers:
        return paper
    close = get_close_matches(paper.lower(), papers, 1)
    hint = f" (did you mean {close[0]}?)" if close else ""
    raise InputError(f"PAPER = {paper!r} is unknown: give one of {', '.join(papers)}{hint}")


def load_verdicts() -> dict[str, Any]:
    """Return the verdicts that were written with the generated code."""
    try:
        return generated.sidecar("audit")
    except FileNotFoundError:
        raise ComputationError("no verdicts on equations: write them by `make audit`") from None


def _count_verdicts(entries: Iterable[Entry]) -> dict[str, int]:
    """Return the count of each verdict by name."""
    return dict(sorted(Counter(entry["verdict"] for entry in entries).items()))


def _select_papers(entries: Iterable[Entry], papers: Sequence[str]) -> list[dict[str, Any]]:
    return [dict(entry) for name in papers for entry in entries if entry["paper"] == name]
