"""`planter audit`: committed verdicts on printed equations and laws, and recomputed printed numbers.

Verdicts on equations and laws come from the generation of the code; numbers are computed on request.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from difflib import get_close_matches
from typing import Any

from planter.audit import claims, consequences, numbers
from planter.errors import ComputationError, InputError
from planter.kernels import generated

Entry = Mapping[str, Any]


def audit(paper: str | None = None) -> dict[str, Any]:
    """Return the verdicts on all papers, or on one of them, in the form of the result.

    Raises InputError for an unknown paper.
    """
    papers = list(numbers.list_papers()) if paper is None else [check_paper(paper)]
    verdicts_found = collect_verdicts(
        load_verdicts(), numbers.judge_numbers(paper), {name: numbers.list_papers()[name] for name in papers}
    )
    derived = consequences.derive_consequences(paper, numbers.load_numbers(), verdicts_found)
    return verdicts_found | {"claims": _select_papers(claims.judge_claims(paper), papers), "consequences": derived}


def collect_verdicts(verdicts: Entry, judged: Sequence[Entry], titles: Mapping[str, str]) -> dict[str, Any]:
    """Return the verdicts on some papers and their numbers, without statements and consequences."""
    parts = ("equations", "laws", "causes", "references")
    equations, laws, causes, references = (_select_papers(verdicts.get(part, ()), list(titles)) for part in parts)
    number_verdicts = _select_papers(judged, list(titles))
    return {
        "equations": equations,
        "laws": laws,
        "numbers": number_verdicts,
        "causes": _select_papers([*causes, *numbers.list_causes(number_verdicts)], list(titles)),
        "references": references,
        "claims": [],
        "consequences": [],
        "summary": {
            name: {
                "title": title,
                "equations": count_verdicts(_select_papers(equations, [name])),
                "at_fault": sum(1 for e in _select_papers(equations, [name]) if e["verdict"] in consequences.FAULTY),
                "causes": len(_select_papers(causes, [name]))
                + len(numbers.list_causes(_select_papers(number_verdicts, [name]))),
                "laws_violated": sum(1 for law in _select_papers(laws, [name]) if law["caused_by"]),
                "numbers": count_verdicts(_select_papers(number_verdicts, [name])),
            }
            for name, title in titles.items()
        },
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


def count_verdicts(entries: Iterable[Entry]) -> dict[str, int]:
    """Return the count of each verdict by name."""
    return dict(sorted(Counter(entry["verdict"] for entry in entries).items()))


def _select_papers(entries: Iterable[Entry], papers: Sequence[str]) -> list[dict[str, Any]]:
    return [dict(entry) for name in papers for entry in entries if entry["paper"] == name]
